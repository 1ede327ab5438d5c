//! JCGM 101, 9.3: calibration of a weight in air of uncertain density, in mg.

use trueaxis_montecarlo::{FirstOrder, Outcome, Settings, Summary, Trials, propagate, validate};

use crate::comparison::{
    Exact, Shortest, TRIALS, assert_close, assert_exact, assert_published, assert_shortest,
};
use crate::model::{gaussian, model_of, rectangular};

fn deviation_from_nominal(trials: usize) -> Summary {
    // δm = (m_R,c + δm_R,c) (1 + (ρ_a - ρ_a0) (1/ρ_W - 1/ρ_R)) - m_nom, densities in kg/m³.
    let model = model_of(|rng| {
        let reference = gaussian(rng, 100_000.000, 0.050);
        let added = gaussian(rng, 1.234, 0.020);
        let air = rectangular(rng, 1.10, 1.30);
        let weight = rectangular(rng, 7000.0, 9000.0);
        let standard = rectangular(rng, 7950.0, 8050.0);
        let buoyancy = (air - 1.2) * (1.0 / weight - 1.0 / standard);
        [(reference + added) * (1.0 + buoyancy) - 100_000.0]
    });
    let settings = Settings {
        trials: Trials::Fixed(trials),
        seed: 93,
        ..Settings::default()
    };
    propagate(&model, &settings, &|_| {}).unwrap().outputs[0]
}

#[test]
fn deviation_of_a_weight_and_its_first_and_second_order_results() {
    let found = assert_published_results(TRIALS);
    // 0.0026 off, and the ends scatter by 0.00045: what so many trials can say of the second order.
    for (digits, wrong) in [(1, Outcome::NotValidated), (2, Outcome::Validated)] {
        let validation = validate(&second_order(), &found, digits).unwrap();
        assert_ne!(validation.outcome, wrong, "{validation:?}");
    }
}

#[test]
#[ignore = "study: a million trials decide what the second-order result is good for"]
fn second_order_result_is_validated_to_one_digit_and_not_to_two() {
    let found = assert_published_results(1_000_000);
    for (digits, outcome) in [(1, Outcome::Validated), (2, Outcome::NotValidated)] {
        let validation = validate(&second_order(), &found, digits).unwrap();
        assert_eq!(validation.outcome, outcome, "{validation:?}");
    }
}

/// Published second order, 1.0870 to 1.3810: 0.003 off, within δ for one significant digit.
fn second_order() -> FirstOrder {
    let second_order = FirstOrder::normal(1.234, 0.0750, 0.95);
    let interval = second_order.interval();
    let printed = format!("{:.4} {:.4}", interval.low, interval.high);
    assert_eq!(printed, "1.0870 1.3810");
    second_order
}

fn assert_published_results(trials: usize) -> Summary {
    let found = deviation_from_nominal(trials);
    assert_exact(
        &found,
        &Exact {
            mean: 1.234,
            u: 0.075_479_740,
            symmetric: [1.084_433_3, 1.383_566_8],
        },
    );

    // Published: 1.2341, 0.0754 and [1.0834, 1.3825]. It must be the shortest interval: it is as
    // long as the exact one to 0.0001, but stands 0.001 off, which is no more than its scatter.
    assert_published(found.mean, found.scatter.mean, trials, "1.2341");
    assert_published(found.u, found.scatter.u, trials, "0.0754");
    assert_shortest(
        &found,
        trials,
        &Shortest {
            exact: [1.084_433_3, 1.383_566_7],
            published: ["1.0834", "1.3825"],
            end_scatter: Some(0.0845),
        },
    );

    // Densities enter in second order only, so first order leaves them out: U = 1.96 × 0.0539.
    let u = 0.050_f64.hypot(0.020);
    let first_order = FirstOrder::normal(1.234, u, 0.95);
    assert_eq!(format!("{u:.4}"), "0.0539");
    let interval = first_order.interval();
    let printed = format!("{:.4} {:.4}", interval.low, interval.high);
    assert_eq!(printed, "1.1285 1.3395");
    let validation = validate(&first_order, &found, 1).unwrap();
    assert_eq!(validation.outcome, Outcome::NotValidated);
    assert_close("δ", validation.tolerance, 0.005, 1e-15);
    found
}
