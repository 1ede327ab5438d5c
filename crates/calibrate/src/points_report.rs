//! What measured coordinates say about their noise: the rigid triangle and the repeats test it.

use trueaxis_campaign::Campaign;
use trueaxis_leastsquares::chi_squared_upper_tail;

use crate::adjustment_report::{
    AdjustmentReport, GLOBAL_TEST_LEVEL, Residuals, approached_from_both_sides,
};
use crate::nine::PointPoses;
use crate::points::MeasuredPoints;
use crate::rigidity;

pub(crate) fn of_points(
    campaign: &Campaign,
    by_direction: bool,
    measured: &MeasuredPoints,
    found: &PointPoses,
    notices: &mut Vec<String>,
) -> AdjustmentReport {
    let (squares, degrees_of_freedom) = rigidity::total(found);
    let readings = campaign.points.iter().flat_map(|points| &points.readings);
    let noise_declared = readings
        .into_iter()
        .all(|reading| reading.sigma_um.is_some());
    let sigma0 = match degrees_of_freedom {
        0 => 1.0,
        _ => (squares / degrees_of_freedom as f64).sqrt(),
    };
    let p_value = chi_squared_upper_tail(squares, degrees_of_freedom as f64);
    let scaled = !noise_declared || p_value < GLOBAL_TEST_LEVEL;
    let from_shape = match scaled {
        true => (sigma0, degrees_of_freedom as f64),
        false => (1.0, f64::INFINITY),
    };
    let from_repeats = repeat_factor(measured, noise_declared, notices);
    let (uncertainty_factor, factor_degrees_of_freedom) = if from_repeats.0 > from_shape.0 {
        from_repeats
    } else {
        from_shape
    };
    let residuals = Residuals {
        sigma0,
        p_value,
        degrees_of_freedom,
        noise_declared,
        consequence: match scaled {
            true => "all uncertainties are multiplied by this",
            false => "uncertainties are those of the declared noise",
        },
    };
    let both_sides = !by_direction && approached_from_both_sides(campaign);
    residuals.notices(both_sides, notices);
    let points = measured.groups.iter().map(|group| group.points_mm.len());
    let observations = 3 * points.sum::<usize>();
    AdjustmentReport {
        observations,
        unknowns: observations - degrees_of_freedom,
        degrees_of_freedom,
        sigma0,
        p_value,
        noise_declared,
        uncertainty_factor,
        factor_degrees_of_freedom,
        rms_residual_mm: rigidity::rms_mm(found),
        noise: None,
        rejected: Vec::new(),
        interruptions: Vec::new(),
        iterations: 0,
        termination: "points measured directly, nothing to adjust".to_owned(),
    }
}

/// How much larger than declared the scatter of repeated points is, if that is significant, and its
/// degrees of freedom.
fn repeat_factor(
    measured: &MeasuredPoints,
    declared: bool,
    notices: &mut Vec<String>,
) -> (f64, f64) {
    let (squares, degrees_of_freedom) = measured.repeat_scatter;
    let p_value = chi_squared_upper_tail(squares, degrees_of_freedom as f64);
    if degrees_of_freedom == 0 || (declared && p_value >= GLOBAL_TEST_LEVEL) {
        return (0.0, f64::INFINITY);
    }
    let factor = (squares / degrees_of_freedom as f64).sqrt();
    if declared {
        notices.push(format!(
            "repeated points scatter {factor:.2} times as much as declared (p = {p_value:.1e}): declare \
             repeatability_um; until then all uncertainties are multiplied by {factor:.2} at least"
        ));
    }
    (factor, degrees_of_freedom as f64)
}
