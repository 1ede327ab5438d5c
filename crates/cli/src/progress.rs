//! Signs of life on standard error; nothing where that is no terminal, or is to be quiet.

use std::sync::LazyLock;
use std::thread;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};

use crate::talk::is_quiet;

/// What takes longer shows that it goes on.
const PATIENCE: Duration = Duration::from_secs(1);

const TICK: Duration = Duration::from_millis(200);

static CLOCK: LazyLock<ProgressBar> =
    LazyLock::new(|| styled(ProgressBar::new_spinner(), "{spinner} {elapsed} so far"));

/// Lets a clock run until something is said.
pub(crate) fn start_clock() {
    LazyLock::force(&CLOCK);
    thread::spawn(|| {
        thread::sleep(PATIENCE);
        CLOCK.enable_steady_tick(TICK);
    });
}

/// Takes the clock away; it does not come again.
pub(crate) fn end_clock() {
    CLOCK.finish_and_clear();
}

/// A bar with rate and time left, in place of the clock.
pub(crate) fn bar(total: usize) -> ProgressBar {
    end_clock();
    if is_quiet() {
        return ProgressBar::hidden();
    }
    let template = "{bar:30} {pos}/{len} trials  {per_sec}  {eta} left";
    let bar = styled(ProgressBar::new(total as u64), template);
    bar.enable_steady_tick(TICK);
    bar
}

fn styled(bar: ProgressBar, template: &str) -> ProgressBar {
    match ProgressStyle::with_template(template) {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}
