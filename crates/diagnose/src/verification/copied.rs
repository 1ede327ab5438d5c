//! Rows that repeat earlier ones, reading by reading, as another cycle: pasted, not measured.

use trueaxis_campaign::VerificationReading;

use crate::numbers::extremes;
use crate::verification::arrivals::is_same;
use crate::verification::given_once::LEAST_REPEATED;

/// Expected number of runs of equal rows of this length, below which a run is no chance: coarse rows are often equal.
const BY_CHANCE: f64 = 1e-4;

/// Most rows for which it is sought: every row is compared with every other.
const MOST_ROWS: usize = 10_000;

/// Consecutive rows that equal later ones.
#[derive(Default)]
struct Run {
    first: usize,
    rows: usize,
    apart: usize,
}

/// Names the longest run of rows that repeats an earlier one, if chance does not explain it.
pub(crate) fn copied(readings: &[VerificationReading]) -> Option<String> {
    if readings.len() > MOST_ROWS {
        return None;
    }
    let mut longest = Run::default();
    let (mut comparable, mut equal) = (0_usize, 0_usize);
    let mut furthest = 0.0_f64;
    for apart in 1..readings.len() {
        let mut rows = 0;
        for (first, (a, b)) in readings.iter().zip(&readings[apart..]).enumerate() {
            let is_comparable = a.direction == b.direction && a.positions == b.positions;
            let is_equal = is_comparable && is_same(a.value_um, b.value_um);
            comparable += usize::from(is_comparable);
            if is_comparable {
                furthest = furthest.max((a.value_um - b.value_um).abs());
            }
            equal += usize::from(is_equal);
            rows = if is_equal { rows + 1 } else { 0 };
            // It must not overlap itself.
            if rows > longest.rows && rows <= apart {
                longest = Run {
                    first: first + 1 - rows,
                    rows,
                    apart,
                };
            }
        }
    }
    if is_coarse(readings, furthest) {
        return None;
    }
    let Run { first, rows, apart } = longest;
    let chance = (equal + 1 - rows) as f64 / (comparable + 1) as f64;
    // A value that comes again within the run is as likely in any row nearby: what hardly changes says nothing.
    let run = &readings[first..first + rows];
    let again = |own: &VerificationReading| {
        let alike = run
            .iter()
            .filter(|other| is_same(own.value_um, other.value_um));
        (alike.count() - 1) as f64 / (rows.max(2) - 1) as f64
    };
    let chances = run.iter().map(|own| again(own).max(chance));
    let expected = comparable as f64 * chances.product::<f64>();
    if rows < LEAST_REPEATED || expected > BY_CHANCE {
        return None;
    }
    let line = |row: usize| readings[row].line;
    Some(format!(
        "the readings in lines {} to {} are those in lines {} to {}, one by one: were they pasted twice? Each counts as a measurement of \
         its own, which makes the result look more certain than it is; remove those that were not measured",
        line(first + apart),
        line(first + apart + rows - 1),
        line(first),
        line(first + rows - 1)
    ))
}

/// Most steps of the last digit over the range of the readings with which it hides the differences of repeats.
const COARSE: f64 = 50.0;

/// Whether repeats differ by at most one digit, of few over the range: a coarse instrument shows the same twice.
pub(super) fn is_coarse(readings: &[VerificationReading], furthest_um: f64) -> bool {
    let values = || readings.iter().map(|reading| reading.value_um);
    let [low, high] = extremes(values());
    let is_digit = |digit: &f64| {
        let steps = |value: f64| (value / digit - (value / digit).round()).abs();
        values().all(|value| steps(value) < ROUNDING)
    };
    let digits = (-4..4)
        .rev()
        .flat_map(|power| [5.0, 2.0, 1.0].map(|x| x * 10_f64.powi(power)));
    let mut digits = digits.filter(is_digit);
    let digit = digits.next().unwrap_or(0.0);
    high - low <= COARSE * digit && furthest_um <= digit * (1.0 + ROUNDING)
}

/// Rounding error of a number of digits.
const ROUNDING: f64 = 1e-6;
