//! When a Monte Carlo result agrees with an exact or a printed figure.
//!
//! The Monte Carlo is allowed four standard errors, which scatter exceeds with a probability of
//! 6e-5 per figure; this file's assertions are called for some 150 figures, so that a new seed
//! would break one of the tests with a probability of 1 %.

use trueaxis_montecarlo::Summary;

/// Standard errors of the Monte Carlo that are allowed.
pub(crate) const STANDARD_ERRORS: f64 = 4.0;

/// What an output is known to be.
pub(crate) struct Exact {
    pub(crate) mean: f64,
    pub(crate) u: f64,
    pub(crate) symmetric: [f64; 2],
}

#[track_caller]
pub(crate) fn assert_close(name: &str, found: f64, expected: f64, allowed: f64) {
    let difference = (found - expected).abs();
    assert!(
        difference <= allowed,
        "{name}: {found} against {expected}, {difference:.2e} apart, {allowed:.2e} allowed"
    );
}

/// Agreement with the exact mean, standard uncertainty and ends of the symmetric interval.
#[track_caller]
pub(crate) fn assert_exact(found: &Summary, exact: &Exact) {
    let scatter = found.scatter;
    for (name, found, expected, scatter) in [
        ("mean", found.mean, exact.mean, scatter.mean),
        ("u", found.u, exact.u, scatter.u),
        ("low", found.symmetric.low, exact.symmetric[0], scatter.low),
        (
            "high",
            found.symmetric.high,
            exact.symmetric[1],
            scatter.high,
        ),
    ] {
        assert_close(name, found, expected, STANDARD_ERRORS * scatter);
    }
}

/// Agreement with a printed figure, which says that the exact one lies within half a unit of its
/// last digit. Four standard errors of the Monte Carlo must be no more than one unit.
#[track_caller]
pub(crate) fn assert_printed(found: f64, scatter: f64, printed: &str) {
    let unit = last_digit(printed);
    let allowed = STANDARD_ERRORS * scatter;
    assert!(allowed <= unit, "{printed}: scatter {scatter:.1e}");
    let printed_value: f64 = printed.parse().unwrap();
    assert_close(printed, found, printed_value, 0.5 * unit + allowed);
}

/// Agreement of mean, u and symmetric interval with what is printed, in this order.
#[track_caller]
pub(crate) fn assert_printed_summary(found: &Summary, printed: [&str; 4]) {
    assert_printed(found.mean, found.scatter.mean, printed[0]);
    assert_printed(found.u, found.scatter.u, printed[1]);
    assert_printed(found.symmetric.low, found.scatter.low, printed[2]);
    assert_printed(found.symmetric.high, found.scatter.high, printed[3]);
}

/// A shortest interval as it is known.
pub(crate) struct Shortest {
    pub(crate) exact: [f64; 2],
    /// As published, found by a Monte Carlo of about a million trials.
    pub(crate) published: [&'static str; 2],
    /// Standard deviation of both ends, times the cube root of the number of trials; none where
    /// the lower end is the least possible value and does not move.
    pub(crate) end_scatter: Option<f64>,
}

/// Agreement with the exact shortest interval and with the published one, which scatters as much.
/// The length of the interval scatters far less than its place.
#[track_caller]
pub(crate) fn assert_shortest(found: &Summary, trials: usize, known: &Shortest) {
    let per_trial = |scatter: f64| scatter / (trials as f64).cbrt();
    // An upper end with 5 % above it scatters less than one with 2.5 %.
    let scatter = known.end_scatter.map_or(found.scatter.high, per_trial);
    let allowed = STANDARD_ERRORS * scatter;
    let ends = [found.shortest.low, found.shortest.high];
    for ((end, exact), published) in ends.into_iter().zip(known.exact).zip(known.published) {
        assert_close("exact end", end, exact, allowed);
        let allowed = 2_f64.sqrt() * allowed + 0.5 * last_digit(published);
        assert_close("published end", end, published.parse().unwrap(), allowed);
    }
    let width = known.exact[1] - known.exact[0];
    let width_scatter = found.scatter.low.hypot(found.scatter.high);
    let allowed = STANDARD_ERRORS * width_scatter;
    assert_close("width", found.shortest.width(), width, allowed);
}

/// One unit of the last digit of a printed number: 0.001 for 0.071, 1e-15 for 2.05e-13.
fn last_digit(printed: &str) -> f64 {
    let (digits, exponent) = printed.split_once('e').unwrap_or((printed, "0"));
    let decimals = digits.split_once('.').map_or(0, |(_, d)| d.len());
    let exponent: i32 = exponent.parse().unwrap();
    format!("1e{}", exponent - i32::try_from(decimals).unwrap())
        .parse()
        .unwrap()
}
