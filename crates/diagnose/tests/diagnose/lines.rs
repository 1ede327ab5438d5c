//! Positioning lines without a calibration: each effect by its name.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use trueaxis_diagnose::Diagnosis;

use crate::counts::Counts;
use crate::iso_run::{Place, beyond_the_mean_curve, curve_um, places, table, values_um};
use crate::{found, generator, length, report};

/// A disturbance of random form, to be scaled.
type Form = fn(&Place, &[f64]) -> f64;

struct Case {
    effect: &'static str,
    form: Form,
    parked_mm: &'static [f64],
    timed: bool,
}

const CASES: [Case; 6] = [
    Case {
        effect: "backlash",
        form: backlash,
        parked_mm: &[0.0],
        timed: false,
    },
    Case {
        effect: "backlash",
        form: backlash,
        parked_mm: &[0.0],
        timed: true,
    },
    Case {
        effect: "position_dependent_backlash",
        form: worn,
        parked_mm: &[0.0],
        timed: false,
    },
    Case {
        effect: "warm_up",
        form: warm_up,
        parked_mm: &[0.0],
        timed: true,
    },
    Case {
        effect: "axis_expansion",
        form: expansion,
        parked_mm: &[0.0],
        timed: true,
    },
    Case {
        effect: "cross_coupling",
        form: coupling,
        parked_mm: &[50.0, 350.0],
        timed: false,
    },
];

fn backlash(place: &Place, _: &[f64]) -> f64 {
    -place.side()
}

/// Mean and slope with about the same part in the trace.
fn worn(place: &Place, random: &[f64]) -> f64 {
    let from_middle = (place.x_mm - 200.0) / 121.0;
    -place.side() * (1.0 + (random[0] - 0.5) + (1.0 + (random[1] - 0.5)) * from_middle)
}

/// Time constants from a tenth of the run to half of it.
fn warm_up(place: &Place, random: &[f64]) -> f64 {
    1.0 - (-place.time_s / (120.0 + 480.0 * random[0])).exp()
}

fn expansion(place: &Place, _: &[f64]) -> f64 {
    place.time_s * place.x_mm
}

fn coupling(place: &Place, _: &[f64]) -> f64 {
    place.x_mm * place.y_mm
}

fn outcome(case: &Case, lambda: f64, seed: u64) -> Diagnosis {
    let mut generator: ChaCha8Rng = generator(seed, 1);
    let sigma_um = 0.3 + 0.7 * generator.random::<f64>();
    let random: [f64; 2] = std::array::from_fn(|_| generator.random());
    let places = places(5, case.parked_mm, &[2.0]);
    let trace: Vec<f64> = places.iter().map(|p| (case.form)(p, &random)).collect();
    let sign = if generator.random::<bool>() {
        1.0
    } else {
        -1.0
    };
    let size = sign * lambda * sigma_um / length(&beyond_the_mean_curve(&places, &trace));
    let disturbance: Vec<f64> = trace.iter().map(|x| size * x).collect();
    let curve = curve_um(&mut generator);
    let values = values_um(&places, &curve, &disturbance, sigma_um, &mut generator);
    found(table(&places, &values, case.timed))
}

/// Every case `seeds` times, at the strength that is just found and at one that is plain.
fn counts(seeds: u64) -> Vec<(String, Counts)> {
    let strengths = [7.0, 20.0];
    let all = strengths
        .iter()
        .flat_map(|l| CASES.iter().map(move |c| (l, c)));
    let counted = all.map(|(&lambda, case)| {
        let mut counts = Counts::default();
        for seed in 0..seeds {
            counts.add(&outcome(case, lambda, seed), case.effect, Some(0));
        }
        let Case { effect, timed, .. } = case;
        (format!("λ {lambda}: {effect} (times: {timed})"), counts)
    });
    counted.collect()
}

/// One of each. For a true rate of 98 % fewer than 11 of 12 come with a probability of 2.3 %; the seeds are fixed.
#[test]
fn each_effect_is_named() {
    let counts = counts(1);
    let all = counts.iter();
    let (right, wrong) = all.fold((0, 0), |(right, wrong), (line, of)| {
        report(&format!("{line}: {of:?}"));
        (right + of.right(), wrong + of.wrong)
    });
    assert!(
        right >= 11 && wrong == 0,
        "{right} right, {wrong} wrong of 12"
    );
}

/// For a true rate of 99 % fewer than 18 of 20 come with a probability of 1e-3 for each case; the seeds
/// are fixed.
#[test]
#[ignore = "study: 240 diagnoses"]
fn each_effect_is_named_in_nine_of_ten() {
    for (line, counts) in counts(20) {
        counts.assert_named(20, &line);
    }
}
