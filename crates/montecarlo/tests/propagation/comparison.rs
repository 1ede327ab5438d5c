//! When a Monte Carlo result agrees with an exact or a printed figure.
//!
//! The Monte Carlo is allowed four standard errors, which scatter exceeds with a probability of
//! 6e-5 per figure; this file's assertions are called for some 150 figures, so that a new seed
//! would break one of the tests with a probability of 1 %. Standard errors are those of the trials
//! made, so that fewer trials widen what is allowed by their scatter and by nothing else. What
//! [`TRIALS`] leave open is decided by ignored studies of more:
//! `cargo test -p trueaxis-montecarlo -- --ignored`.

use trueaxis_montecarlo::Summary;

/// Trials of an example.
pub(crate) const TRIALS: usize = 200_000;

/// Trials behind the published figures of JCGM 101.
const PUBLISHED_TRIALS: f64 = 1e6;

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

/// Agreement with a figure that was published from a Monte Carlo of its own: its last digit is rounded,
/// and it scatters as the one here would after so many trials.
#[track_caller]
pub(crate) fn assert_published(found: f64, scatter: f64, trials: usize, published: &str) {
    let both = scatter.hypot(scatter * (trials as f64 / PUBLISHED_TRIALS).sqrt());
    let allowed = 0.5 * last_digit(published) + STANDARD_ERRORS * both;
    assert_close(published, found, published.parse().unwrap(), allowed);
}

/// A shortest interval as it is known.
pub(crate) struct Shortest {
    pub(crate) exact: [f64; 2],
    /// As published, found by a Monte Carlo of a million trials.
    pub(crate) published: [&'static str; 2],
    /// Standard deviation of both ends, times the cube root of the number of trials; none where
    /// the lower end is the least possible value and does not move.
    pub(crate) end_scatter: Option<f64>,
}

/// Agreement with the exact shortest interval and with the published one, which scatters itself.
/// The length of the interval scatters far less than its place.
#[track_caller]
pub(crate) fn assert_shortest(found: &Summary, trials: usize, known: &Shortest) {
    let trials = trials as f64;
    // An upper end with 5 % above it scatters less than one with 2.5 %.
    let after = |count: f64| {
        let of_quantile = found.scatter.high * (trials / count).sqrt();
        let of_place = |scatter: f64| scatter / count.cbrt();
        known.end_scatter.map_or(of_quantile, of_place)
    };
    let allowed = STANDARD_ERRORS * after(trials);
    let both = STANDARD_ERRORS * after(trials).hypot(after(PUBLISHED_TRIALS));
    let ends = [found.shortest.low, found.shortest.high];
    for ((end, exact), published) in ends.into_iter().zip(known.exact).zip(known.published) {
        assert_close("exact end", end, exact, allowed);
        let allowed = both + 0.5 * last_digit(published);
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
