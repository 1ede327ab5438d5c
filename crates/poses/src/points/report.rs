//! What measured coordinates say about their noise: the rigid triangle and the repeats test it.

use trueaxis_campaign::Campaign;
use trueaxis_kinematics::MICROMETRE;
use trueaxis_leastsquares::chi_squared_upper_tail;

use crate::Residual;
use crate::points::MeasuredPoints;
use crate::points::equations::PointPoses;
use crate::points::rigidity;
use crate::report::{AdjustmentReport, GLOBAL_TEST_LEVEL, approached_from_both_sides};

/// The report of measured points and the poses found from them, with what a user must know of it.
pub(crate) fn points_report(
    campaign: &Campaign,
    by_direction: bool,
    measured: &MeasuredPoints,
    (found, residuals): (&PointPoses, &[Residual]),
) -> (AdjustmentReport, Vec<String>) {
    let (squares, degrees_of_freedom) = rigidity::total(found);
    let mut readings = campaign.points.iter().flat_map(|points| &points.readings);
    let noise_declared = readings.all(|reading| reading.sigma_um.is_some());
    let sigma0 = match degrees_of_freedom {
        0 => 1.0,
        _ => (squares / degrees_of_freedom as f64).sqrt(),
    };
    let observations = 3 * measured
        .groups
        .iter()
        .map(|g| g.points_mm.len())
        .sum::<usize>();
    let mut report = AdjustmentReport {
        observations,
        unknowns: observations - degrees_of_freedom,
        degrees_of_freedom,
        sigma0,
        // Nothing is declared that residuals could contradict.
        p_value: match noise_declared {
            true => chi_squared_upper_tail(squares, degrees_of_freedom as f64),
            false => 1.0,
        },
        noise_declared,
        uncertainty_factor: 1.0,
        factor_degrees_of_freedom: f64::INFINITY,
        rms_residual_mm: rms_mm(residuals),
        noise: None,
        iterations: 0,
        termination: "points measured directly, nothing to adjust".to_owned(),
        rejected: Vec::new(),
        interruptions: Vec::new(),
    };
    let scaled = !noise_declared || report.is_contradicted();
    if scaled {
        report.uncertainty_factor = sigma0;
        report.factor_degrees_of_freedom = degrees_of_freedom as f64;
    }
    let mut notices = Vec::new();
    if let Some((factor, degrees_of_freedom, p_value)) = repeat_factor(measured, noise_declared) {
        if noise_declared {
            notices.push(format!(
                "repeated points scatter {factor:.2} times as much as sigma_um and the repeatability of the \
                 machine explain (p = {p_value:.1e}): all uncertainties are multiplied by {factor:.2} at least"
            ));
        }
        if factor > report.uncertainty_factor {
            report.uncertainty_factor = factor;
            report.factor_degrees_of_freedom = degrees_of_freedom;
        }
    }
    let both_sides = !by_direction && approached_from_both_sides(campaign);
    let returns_mm = report.uncertainty_factor * measured.repeatability_variance_mm2.sqrt();
    if campaign.instrument.repeatability_um.is_none() && returns_mm > 0.0 {
        let sides = match both_sides {
            true => {
                ", the difference of both sides of approach included; --by-direction keeps them apart"
            }
            false => "",
        };
        notices.push(format!(
            "repeatability_um is not declared: by the repeated points the machine returns within {:.2} µm (standard \
             deviation of a coordinate{sides})",
            returns_mm / MICROMETRE
        ));
    }
    let consequence = match scaled {
        true => "all uncertainties are multiplied by this",
        false => "uncertainties are those of the declared noise",
    };
    notices.extend(report.residual_notices(consequence, both_sides));
    if !report.noise_declared && campaign.instrument.length_sigma_um.is_some() {
        let text = "length_sigma_um is the noise of lengths: points have theirs in a column `sigma_um` of points.csv";
        notices.push(text.to_owned());
    }
    (report, notices)
}

fn rms_mm(residuals: &[Residual]) -> f64 {
    let squares: f64 = residuals.iter().map(|r| r.residual_mm.powi(2)).sum();
    (squares / residuals.len().max(1) as f64).sqrt()
}

/// How much larger than declared the scatter of repeated points is, if that is significant, with its
/// degrees of freedom and p-value.
fn repeat_factor(measured: &MeasuredPoints, declared: bool) -> Option<(f64, f64, f64)> {
    let (squares, degrees_of_freedom) = measured.repeat_scatter();
    let degrees = degrees_of_freedom as f64;
    let p_value = chi_squared_upper_tail(squares, degrees);
    let significant = !declared || p_value < GLOBAL_TEST_LEVEL;
    (degrees_of_freedom > 0 && significant).then(|| ((squares / degrees).sqrt(), degrees, p_value))
}
