//! Distributions whose moments, quantiles and shortest intervals have a closed form.

use rand::RngExt;
use trueaxis_montecarlo::{Propagation, Settings, Trials, propagate};

use crate::comparison::{Exact, TRIALS, assert_close, assert_exact};
use crate::model::{arc_sine, curvilinear_trapezoid, gaussian, model_of, rectangular};

/// Mode of a triangular distribution on 0 to 1.
const MODE: f64 = 0.2;

/// Gaussian, rectangular, arc sine, exponential, triangular.
fn known_distributions(trials: usize, seed: u64) -> Propagation {
    let model = model_of(|rng| {
        let share = rng.random::<f64>();
        let triangular = if share < MODE {
            (MODE * share).sqrt()
        } else {
            1.0 - ((1.0 - MODE) * (1.0 - share)).sqrt()
        };
        [
            gaussian(rng, 3.0, 2.0),
            rectangular(rng, -1.0, 5.0),
            arc_sine(rng, -1.0, 1.0),
            -(1.0 - rng.random::<f64>()).ln(),
            triangular,
        ]
    });
    let settings = Settings {
        trials: Trials::Fixed(trials),
        seed,
        ..Settings::default()
    };
    propagate(&model, &settings, &|_| {}).unwrap()
}

#[test]
fn moments_and_symmetric_intervals() {
    let found = known_distributions(TRIALS, 1);
    let tail = 0.025_f64;
    let gaussian_end = 2.0 * 1.959_963_984_540_054;
    let arc_sine_end = (std::f64::consts::PI * (0.5 - tail)).sin();
    let exact = [
        (3.0, 2.0, [3.0 - gaussian_end, 3.0 + gaussian_end]),
        (2.0, 3_f64.sqrt(), [-1.0 + 6.0 * tail, 5.0 - 6.0 * tail]),
        (0.0, 0.5_f64.sqrt(), [-arc_sine_end, arc_sine_end]),
        (1.0, 1.0, [-(1.0 - tail).ln(), -tail.ln()]),
        (
            (1.0 + MODE) / 3.0,
            ((1.0 - MODE + MODE * MODE) / 18.0).sqrt(),
            [(MODE * tail).sqrt(), 1.0 - ((1.0 - MODE) * tail).sqrt()],
        ),
    ];
    for (found, (mean, u, symmetric)) in found.outputs.iter().zip(exact) {
        assert_exact(found, &Exact { mean, u, symmetric });
    }
}

/// The probability inside an interval between two order statistics q ranks apart is Beta
/// distributed with mean q/(M + 1) and standard deviation √(p (1 - p)/M), whatever the
/// distribution.
#[test]
fn intervals_hold_the_coverage_probability() {
    let trials = TRIALS;
    let found = known_distributions(trials, 2);
    let allowed = 4.0 * (0.95_f64 * 0.05 / trials as f64).sqrt();
    let exponential = found.outputs[3].symmetric;
    let inside = (-exponential.low).exp() - (-exponential.high).exp();
    assert_close("exponential", inside, 0.95, allowed);
    let rectangular = found.outputs[1].symmetric;
    assert_close("rectangular", rectangular.width() / 6.0, 0.95, allowed);
    let arc_sine = found.outputs[2].symmetric;
    let inside = (arc_sine.high.asin() - arc_sine.low.asin()) / std::f64::consts::PI;
    assert_close("arc sine", inside, 0.95, allowed);
}

#[test]
fn shortest_intervals_of_asymmetric_distributions() {
    let trials = TRIALS;
    let found = known_distributions(trials, 3);

    // Exponential: from 0 to -ln(1 - p). The lower end is one of the lowest values: each step up
    // shortens the interval by a spacing near 0 and lengthens it by one twenty times as large, so
    // that more than 50 steps have a probability below 0.2⁵⁰.
    let exponential = &found.outputs[3];
    assert!(exponential.shortest.low < 100.0 / trials as f64);
    let scatter = (0.95 / 0.05 / trials as f64).sqrt();
    assert_close(
        "exponential",
        exponential.shortest.high,
        -0.05_f64.ln(),
        4.0 * scatter,
    );
    assert!(exponential.shortest.width() < 0.83 * exponential.symmetric.width());

    // Triangular with mode c: the tails left out end where the density is √(1 - p) of its peak.
    // The ends of the shortest interval scatter with M^(-1/3), its length with M^(-1/2).
    let triangular = &found.outputs[4];
    let height = 0.05_f64.sqrt();
    let (low, high) = (MODE * height, 1.0 - (1.0 - MODE) * height);
    let width_scatter = triangular.scatter.low.hypot(triangular.scatter.high);
    let width = triangular.shortest.width();
    assert_close("width", width, high - low, 4.0 * width_scatter);
    let allowed = 0.4 / (trials as f64).cbrt();
    assert_close("low", triangular.shortest.low, low, allowed);
    assert_close("high", triangular.shortest.high, high, allowed);
}

/// Reported scatter against the standard deviation of the results of 300 seeds, which itself is
/// known to 4 %; 0.2 is five times that (the arc sine has its mode at the ends, where quantiles
/// hardly scatter, and is as good as the others).
#[test]
fn scatter_is_what_another_seed_does() {
    let seeds = 300_u64;
    let runs: Vec<_> = (0..seeds)
        .map(|seed| known_distributions(2000, seed))
        .collect();
    for output in 0..5 {
        let results = runs.iter().map(|run| {
            let o = &run.outputs[output];
            let reported = [o.scatter.mean, o.scatter.u, o.scatter.low, o.scatter.high];
            ([o.mean, o.u, o.symmetric.low, o.symmetric.high], reported)
        });
        let (results, reported): (Vec<_>, Vec<_>) = results.unzip();
        for figure in 0..4 {
            let n = seeds as f64;
            let mean = results.iter().map(|r| r[figure]).sum::<f64>() / n;
            let squares: f64 = results.iter().map(|r| (r[figure] - mean).powi(2)).sum();
            let observed = (squares / (n - 1.0)).sqrt();
            let reported = reported.iter().map(|r| r[figure]).sum::<f64>() / n;
            let ratio = reported / observed;
            assert!((ratio - 1.0).abs() < 0.2, "{output} {figure}: {ratio}");
        }
    }
}

/// JCGM 101, 6.4.3: variance (b - a)²/12 + d²/9.
#[test]
fn curvilinear_trapezoid_has_the_variance_of_the_supplement() {
    let model = model_of(|rng| [curvilinear_trapezoid(rng, -2.0, 4.0, 1.0)]);
    let found = propagate(&model, &Settings::default(), &|_| {}).unwrap();
    let found = &found.outputs[0];
    assert_close("mean", found.mean, 1.0, 4.0 * found.scatter.mean);
    let u = (36_f64 / 12.0 + 1.0 / 9.0).sqrt();
    assert_close("u", found.u, u, 4.0 * found.scatter.u);
}
