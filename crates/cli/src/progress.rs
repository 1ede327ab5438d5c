//! Progress on a terminal.

use std::io::{IsTerminal, Write, stderr};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use crate::talk::is_quiet;

/// Letters of the whole bar.
const WIDTH: usize = 30;

const INTERVAL: Duration = Duration::from_millis(200);

/// Start of the line, and what erases the rest of it.
const START: &str = "\r";
const ERASE: &str = "\x1b[K";

/// A bar with rate and time left on standard error; nothing where that is no terminal.
pub(crate) struct Bar {
    total: usize,
    start: Instant,
    /// When it was drawn last; none if it is not shown.
    drawn: Option<Mutex<Instant>>,
}

impl Bar {
    pub(crate) fn new(total: usize) -> Self {
        let is_shown = !is_quiet() && stderr().is_terminal();
        let start = Instant::now();
        Self {
            total,
            start,
            drawn: is_shown.then(|| Mutex::new(start)),
        }
    }

    /// Draws the bar now and then; calls come from any thread.
    pub(crate) fn set_position(&self, done: usize) {
        let Some(Ok(mut drawn)) = self.drawn.as_ref().map(Mutex::try_lock) else {
            return;
        };
        if done > 0 && drawn.elapsed() > INTERVAL {
            *drawn = Instant::now();
            show(&line(done, self.total, self.start.elapsed()));
        }
    }

    /// Erases it.
    pub(crate) fn clear(self) {
        if self.drawn.is_some() {
            show("");
        }
    }
}

/// What cannot be shown is not worth an error.
fn show(line: &str) {
    let mut out = stderr().lock();
    let _ = write!(out, "{START}{line}{ERASE}").and_then(|()| out.flush());
}

fn line(done: usize, total: usize, elapsed: Duration) -> String {
    let bar = "█".repeat(WIDTH * done.min(total) / total.max(1));
    let per_s = done as f64 / elapsed.as_secs_f64();
    let left_s = total.saturating_sub(done) as f64 / per_s;
    format!("{bar:░<WIDTH$} {done}/{total} trials  {per_s:.0}/s  {left_s:.0} s left")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_third_of_the_work_in_two_seconds() {
        let expected = format!(
            "{}{} 1000/3000 trials  500/s  4 s left",
            "█".repeat(10),
            "░".repeat(20)
        );
        assert_eq!(line(1000, 3000, Duration::from_secs(2)), expected);
    }
}
