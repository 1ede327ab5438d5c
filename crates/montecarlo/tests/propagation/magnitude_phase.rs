//! JCGM 102 (GUM Supplement 2): magnitude and phase of a complex quantity close to zero.

use trueaxis_montecarlo::{FirstOrder, Outcome, Settings, Trials, propagate, validate};

use crate::comparison::{TRIALS, assert_printed};
use crate::model::{gaussian, model_of};

#[test]
fn first_order_fails_for_a_small_complex_quantity() {
    // Real part 0.001, imaginary part 0, u = 0.010 each.
    let model = model_of(|rng| {
        let (re, im) = (gaussian(rng, 0.001, 0.010), gaussian(rng, 0.0, 0.010));
        [re.hypot(im), im.atan2(re)]
    });
    let settings = Settings {
        trials: Trials::Fixed(TRIALS),
        seed: 102,
        ..Settings::default()
    };
    let found = propagate(&model, &settings, &|_| {}).unwrap();
    let [magnitude, phase] = found.outputs[..] else {
        panic!("two outputs");
    };
    assert_printed(magnitude.mean, magnitude.scatter.mean, "0.013");
    assert_printed(magnitude.u, magnitude.scatter.u, "0.007");
    assert!(phase.mean.abs() < 4.0 * phase.scatter.mean, "{phase:?}");
    assert!((phase.u - 1.744).abs() < 0.0005 + 4.0 * phase.scatter.u);

    // First order: 0.001 with u = 0.010 and 0 with u = 10 rad, more than the circle has.
    for (summary, first_order) in [
        (&magnitude, FirstOrder::normal(0.001, 0.010, 0.95)),
        (&phase, FirstOrder::normal(0.0, 10.0, 0.95)),
    ] {
        let validation = validate(&first_order, summary, 1).unwrap();
        assert_eq!(validation.outcome, Outcome::NotValidated, "{validation:?}");
    }
}
