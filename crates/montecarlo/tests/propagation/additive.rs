//! JCGM 101, 9.2: Y = X₁ + X₂ + X₃ + X₄ of Gaussian and of rectangular inputs.

use trueaxis_montecarlo::{
    FirstOrder, Model, Outcome, Propagation, Settings, Trials, propagate, validate,
};

use crate::comparison::{Exact, TRIALS, assert_exact, assert_printed_summary};
use crate::model::{gaussian, model_of, rectangular};

/// Half the width of a rectangular distribution with standard deviation 1.
const HALF_WIDTH: f64 = 1.732_050_807_568_877_2;

fn run(model: &impl Model, trials: usize) -> Propagation {
    let settings = Settings {
        trials: Trials::Fixed(trials),
        seed: 92,
        ..Settings::default()
    };
    propagate(model, &settings, &|_| {}).unwrap()
}

#[test]
fn sum_of_gaussian_inputs_and_sum_with_one_dominant_rectangular_input() {
    // Clauses 9.2.2 and 9.2.4: four of standard deviation 1; one of 10, three of 1.
    let model = model_of(|rng| {
        let normal = [(); 4].map(|()| gaussian(rng, 0.0, 1.0));
        let dominant = 10.0 * rectangular(rng, -HALF_WIDTH, HALF_WIDTH);
        let others = [(); 3].map(|()| rectangular(rng, -HALF_WIDTH, HALF_WIDTH));
        [normal.iter().sum(), dominant + others.iter().sum::<f64>()]
    });
    let found = run(&model, TRIALS);
    let [normal, dominated] = &found.outputs[..] else {
        panic!("two outputs");
    };
    // Published as 0.00, 2.00 and ±3.92.
    let end = 2.0 * 1.959_963_984_540_054;
    let symmetric = [-end, end];
    let (mean, u) = (0.0, 2.0);
    assert_exact(normal, &Exact { mean, u, symmetric });
    // First order is exact. Its ends scatter by 0.012 after so many trials: within δ = 0.5 beyond
    // doubt, while δ = 0.05 for two digits would take 730 000.
    let first_order = FirstOrder::normal(0.0, u, 0.95);
    let validation = validate(&first_order, normal, 1).unwrap();
    assert_eq!(validation.outcome, Outcome::Validated, "{validation:?}");
    let validation = validate(&first_order, normal, 2).unwrap();
    assert_ne!(validation.outcome, Outcome::NotValidated, "{validation:?}");

    // First order gives ±19.9, 2.9 off against δ = 0.5. The end is that of `exact.py`.
    assert_printed_summary(dominated, ["0.0", "10.1", "-17.0", "17.0"]);
    let symmetric = [-17.015_814, 17.015_814];
    let u = 103_f64.sqrt();
    assert_exact(dominated, &Exact { mean, u, symmetric });
    let first_order = FirstOrder::normal(0.0, u, 0.95);
    let validation = validate(&first_order, dominated, 2).unwrap();
    assert_eq!(validation.outcome, Outcome::NotValidated, "{validation:?}");
}

/// Clauses 9.2.2 and 9.2.3: the sum of four Gaussian, and of four rectangular inputs.
fn assert_sum(trials: usize, rectangular_inputs: bool, digits: u32, expected: Outcome) {
    let model = model_of(|rng| {
        let inputs = [(); 4].map(|()| match rectangular_inputs {
            true => rectangular(rng, -HALF_WIDTH, HALF_WIDTH),
            false => gaussian(rng, 0.0, 1.0),
        });
        [inputs.iter().sum()]
    });
    let (end, printed) = match rectangular_inputs {
        true => (2.0 * 3_f64.sqrt() * (2.0 - 0.6_f64.powf(0.25)), "3.88"),
        false => (2.0 * 1.959_963_984_540_054, "3.92"),
    };
    let found = run(&model, trials).outputs[0];
    assert_exact(
        &found,
        &Exact {
            mean: 0.0,
            u: 2.0,
            symmetric: [-end, end],
        },
    );
    if trials > 10_000_000 {
        assert_printed_summary(&found, ["0.00", "2.00", &format!("-{printed}"), printed]);
    }
    let validation = validate(&FirstOrder::normal(0.0, 2.0, 0.95), &found, digits).unwrap();
    assert_eq!(validation.outcome, expected, "{validation:?}");
}

/// First order gives ±3.92, the ends are ±3.88: within δ = 0.5 for one digit; within δ = 0.05 for two
/// they are by so little that few trials do not decide.
#[test]
fn sum_of_rectangular_inputs_is_validated_to_one_digit() {
    assert_sum(TRIALS, true, 1, Outcome::Validated);
    assert_sum(TRIALS, true, 2, Outcome::Undecided);
}

/// Off by 0.0405 of 0.05: a million trials leave 0.0405 ± 4 × 0.0048, and it takes more than 10⁷.
#[test]
#[ignore = "study: 17 million trials decide the second digit"]
fn sums_are_validated_to_two_digits_by_enough_trials() {
    assert_sum(1_000_000, false, 2, Outcome::Validated);
    assert_sum(1_000_000, true, 2, Outcome::Undecided);
    assert_sum(15_000_000, true, 2, Outcome::Validated);
}
