//! What is found does not depend on the unit of a position.

use rand_distr::{Distribution, StandardNormal};
use trueaxis_diagnose::Cause;

use crate::counts::summary;
use crate::iso_run::there_and_back;
use crate::{found, generator};

/// Lost motion of 0.4 µm at one end and 2.0 at the other, beside a drift of 1.2 µm, noise 0.05 µm. Over 0.4 mm the columns of the slope are
/// so small against those of the mean that it was taken for unseen: the curve went from 1.25 to 1.30 µm.
#[test]
fn lost_motion_changes_along_the_shortest_line() {
    for range_mm in [0.4, 40.0] {
        let mut generator = generator(1, 103);
        let found = found(there_and_back((5, range_mm, true), 0.0, &mut |place| {
            let noise: f64 = StandardNormal.sample(&mut generator);
            let lost = 0.4 + 1.6 * place.x_mm / range_mm;
            0.05 * noise + 1.2 * place.time_s / 1100.0 - 0.5 * place.side() * lost
        }));
        let is_worn = |cause: &&Cause| cause.effect.effect.id == "position_dependent_backlash";
        let worn = found.causes.iter().find(is_worn);
        let worn = worn.unwrap_or_else(|| panic!("{range_mm} mm: {}", summary(&found)));
        let slope = &worn.parameters[1];
        let expected = 1600.0 / range_mm;
        assert!(
            (slope.value - expected).abs() < 4.0 * slope.u && slope.u < 0.1 * expected,
            "{range_mm} mm: {slope:?}"
        );
    }
}
