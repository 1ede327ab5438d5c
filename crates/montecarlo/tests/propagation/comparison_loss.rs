//! JCGM 101, 9.4: comparison loss Y = X₁² + X₂² in microwave power meter calibration, in 10⁻⁶.

use trueaxis_montecarlo::{FirstOrder, Outcome, Settings, Trials, propagate, validate};

use crate::comparison::{
    Exact, Shortest, TRIALS, assert_close, assert_exact, assert_published, assert_shortest,
};
use crate::model::{gaussian, model_of};

const U: f64 = 0.005;

struct Case {
    x1: f64,
    correlation: f64,
    /// Mean and u as published.
    published: [&'static str; 2],
    /// Half of the second digit of u.
    tolerance: f64,
    /// Symmetric interval of `exact.py`.
    symmetric: [f64; 2],
    /// Shortest interval of `exact.py` and as published.
    shortest: Shortest,
}

const CASES: [Case; 6] = [
    Case {
        x1: 0.0,
        correlation: 0.0,
        published: ["50", "50"],
        tolerance: 0.5,
        symmetric: [1.265_890_4, 184.443_97],
        shortest: Shortest {
            exact: [0.0, 149.786_61],
            published: ["0", "150"],
            end_scatter: None,
        },
    },
    Case {
        x1: 0.010,
        correlation: 0.0,
        published: ["150", "112"],
        tolerance: 5.0,
        symmetric: [8.546_844_9, 427.123_28],
        shortest: Shortest {
            exact: [0.0, 366.005_29],
            published: ["0", "367"],
            end_scatter: None,
        },
    },
    Case {
        x1: 0.050,
        correlation: 0.0,
        published: ["2551", "502"],
        tolerance: 5.0,
        symmetric: [1_638.477_1, 3_603.358_1],
        shortest: Shortest {
            exact: [1_593.569_7, 3_548.569_8],
            published: ["1590", "3543"],
            end_scatter: Some(517.0),
        },
    },
    Case {
        x1: 0.0,
        correlation: 0.9,
        published: ["50", "67"],
        tolerance: 0.5,
        symmetric: [0.560_977_72, 241.217_19],
        shortest: Shortest {
            exact: [0.0, 185.056_46],
            published: ["0", "185"],
            end_scatter: None,
        },
    },
    Case {
        x1: 0.010,
        correlation: 0.9,
        published: ["150", "121"],
        tolerance: 5.0,
        symmetric: [29.081_467, 478.310_68],
        shortest: Shortest {
            exact: [12.651_56, 397.478_78],
            published: ["13", "398"],
            end_scatter: Some(40.7),
        },
    },
    Case {
        x1: 0.050,
        correlation: 0.9,
        published: ["2551", "505"],
        tolerance: 5.0,
        symmetric: [1696.858, 3_659.796_3],
        shortest: Shortest {
            exact: [1_624.418_6, 3_554.682_5],
            published: ["1628", "3555"],
            end_scatter: Some(479.0),
        },
    },
];

#[test]
fn squares_of_reflection_coefficients_near_zero() {
    let model = model_of(|rng| {
        let (z1, z2) = (gaussian(rng, 0.0, 1.0), gaussian(rng, 0.0, 1.0));
        CASES.map(|case| {
            let r = case.correlation;
            let x1 = case.x1 + U * z1;
            let x2 = U * (r * z1 + (1.0 - r * r).sqrt() * z2);
            1e6 * (x1 * x1 + x2 * x2)
        })
    });
    let settings = Settings {
        trials: Trials::Fixed(TRIALS),
        seed: 94,
        ..Settings::default()
    };
    let found = propagate(&model, &settings, &|_| {}).unwrap();
    for (case, found) in CASES.iter().zip(&found.outputs) {
        // Closed form: E Y = x₁² + 2 u², var Y = 4 u² x₁² + 4 u⁴ (1 + r²).
        let (x1, r) = (case.x1, case.correlation);
        let mean = 1e6 * (x1 * x1 + 2.0 * U * U);
        let u = 2e6 * U * (x1 * x1 + U * U * (1.0 + r * r)).sqrt();
        let symmetric = case.symmetric;
        assert_exact(found, &Exact { mean, u, symmetric });

        // The published figures scatter, too: 2551 stands for 2550.
        let [published_mean, published_u] = case.published;
        assert_published(found.mean, found.scatter.mean, TRIALS, published_mean);
        assert_published(found.u, found.scatter.u, TRIALS, published_u);
        assert_shortest(found, TRIALS, &case.shortest);

        // First order: y = x₁², u = 2 x₁ u(x₁). None is validated (published for r = 0), most of
        // all not at x₁ = 0, where first order has no uncertainty at all.
        let first_order = FirstOrder::normal(1e6 * x1 * x1, 2e6 * x1 * U, 0.95);
        let validation = validate(&first_order, found, 2).unwrap();
        assert_eq!(validation.outcome, Outcome::NotValidated, "{validation:?}");
        assert_close("δ", validation.tolerance, case.tolerance, 1e-12);
    }
}
