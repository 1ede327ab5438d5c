//! JCGM 101, 9.5: length of a gauge block against a standard, in nm (GUM H.1 with distributions).

use trueaxis_montecarlo::{FirstOrder, Outcome, Settings, Trials, propagate, validate};

use crate::comparison::{Exact, Shortest, TRIALS, assert_exact, assert_published, assert_shortest};
use crate::model::{
    Student, arc_sine, curvilinear_trapezoid, gaussian, model_of, rectangular, student,
};

#[test]
fn deviation_of_a_gauge_block_from_nominal_length() {
    let standard = Student::new(18.0, 50_000_623.0, 25.0);
    let difference = Student::new(24.0, 215.0, 6.0);
    let random = Student::new(5.0, 0.0, 4.0);
    let systematic = Student::new(8.0, 0.0, 7.0);
    // δL = L_S + D + d₁ + d₂ - L_S (δα (θ₀ + Δ) + α_S δθ) - L_nom
    let model = model_of(|rng| {
        let length = student(rng, &standard);
        let compared = student(rng, &difference) + student(rng, &random);
        let alpha = rectangular(rng, 9.5e-6, 13.5e-6);
        let theta = gaussian(rng, -0.1, 0.2) + arc_sine(rng, -0.5, 0.5);
        let delta_alpha = curvilinear_trapezoid(rng, -1.0e-6, 1.0e-6, 0.1e-6);
        let delta_theta = curvilinear_trapezoid(rng, -0.050, 0.050, 0.025);
        let expansion = length * (delta_alpha * theta + alpha * delta_theta);
        [length + compared + student(rng, &systematic) - expansion - 50_000_000.0]
    });
    let settings = Settings {
        trials: Trials::Fixed(TRIALS),
        seed: 95,
        coverage: 0.99,
        ..Settings::default()
    };
    let found = propagate(&model, &settings, &|_| {}).unwrap().outputs[0];
    assert_exact(
        &found,
        &Exact {
            mean: 838.0,
            u: 35.808_079,
            symmetric: [744.348_36, 931.651_64],
        },
    );
    // Published: 838, 36 and the shortest 99 % interval [745, 932].
    assert_published(found.mean, found.scatter.mean, TRIALS, "838");
    assert_published(found.u, found.scatter.u, TRIALS, "36");
    assert_shortest(
        &found,
        TRIALS,
        &Shortest {
            exact: [744.348_35, 931.651_64],
            published: ["745", "932"],
            end_scatter: Some(53.6),
        },
    );

    // Published first order: u = 32, with k = 2.92 (16 effective degrees of freedom) 745 to 931.
    let student_factor = FirstOrder {
        value: 838.0,
        u: 32.0,
        coverage_factor: 2.92,
    };
    let interval = student_factor.interval();
    let printed = format!("{:.0} {:.0}", interval.low, interval.high);
    assert_eq!(printed, "745 931");
    // Its u is 4 too small, but the factor makes up for that: the ends are 0.2 from the exact
    // ones, within δ = 5 for one digit. Whether within δ = 0.5, so few trials do not decide.
    for (digits, outcome) in [(1, Outcome::Validated), (2, Outcome::Undecided)] {
        let validation = validate(&student_factor, &found, digits).unwrap();
        assert_eq!(validation.outcome, outcome, "{validation:?}");
    }
    // With the factor of a normal distribution the interval is too short by far.
    let normal_factor = FirstOrder::normal(838.0, 32.0, 0.99);
    for digits in [1, 2] {
        let validation = validate(&normal_factor, &found, digits).unwrap();
        assert_eq!(validation.outcome, Outcome::NotValidated, "{validation:?}");
    }
}
