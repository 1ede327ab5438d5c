//! What measured coordinates say about their noise, tested by the rigid triangle and by the repeats.

use trueaxis_campaign::Campaign;
use trueaxis_kinematics::MICROMETRE;
use trueaxis_leastsquares::{chi_squared_upper_tail, f_upper_tail};
use trueaxis_screening::CoordinateNoise;

use crate::Residual;
use crate::points::equations::PointPoses;
use crate::points::noise_shown::NoiseShown;
use crate::points::rigidity;
use crate::points::{MeasuredPoints, UNDECLARED_SIGMA_UM};
use crate::report::{AdjustmentReport, GLOBAL_TEST_LEVEL, MANY, approached_from_both_sides};

/// The report of measured points and their poses, with the notices for the user.
pub(crate) fn points_report(
    campaign: &Campaign,
    by_direction: bool,
    (measured, noise, shown): (&MeasuredPoints, &CoordinateNoise, &NoiseShown),
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
        // Undeclared noise cannot be contradicted.
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
    let scaled = !noise_declared || shown.by_residuals || report.is_contradicted();
    if scaled {
        report.uncertainty_factor = sigma0;
        report.factor_degrees_of_freedom = degrees_of_freedom as f64;
    }
    let mut notices = Vec::new();
    if let Some((factor, degrees_of_freedom, p_value)) = repeat_factor(measured, &report) {
        if noise_declared {
            notices.push(format!(
                "repeated points scatter {factor:.2} times as much as sigma_um and the repeatability of the \
                 machine explain ({}): all uncertainties are multiplied by {factor:.2} at least",
                trueaxis_files::p_value(p_value)
            ));
        }
        if factor > report.uncertainty_factor {
            report.uncertainty_factor = factor;
            report.factor_degrees_of_freedom = degrees_of_freedom;
        }
    }
    // A direction that few differences tell has as few degrees of freedom.
    let freedom = &mut report.factor_degrees_of_freedom;
    *freedom = freedom.min(noise.degrees_of_freedom());
    let both_sides = !by_direction && approached_from_both_sides(campaign);
    let returns_mm = report.uncertainty_factor * measured.repeatability_variance_mm2.sqrt();
    let sides = match both_sides {
        true => {
            ", the difference of both sides of approach included; --by-direction keeps them apart"
        }
        false => "",
    };
    let returns = format!(
        "by the repeated points the machine returns within {:.2} µm (standard deviation of a coordinate{sides})",
        returns_mm / MICROMETRE
    );
    match (campaign.instrument.repeatability_um, shown.p_value) {
        (Some(declared_um), Some(p_value)) => notices.push(format!(
            "repeatability_um is declared as {declared_um:.2}, but {returns}: uncertainties contain the latter ({})",
            trueaxis_files::p_value(p_value)
        )),
        (None, _) if returns_mm > 0.0 => {
            notices.push(format!("repeatability_um is not declared: {returns}"));
        }
        _ => {}
    }
    let consequence = match scaled {
        true if shown.told_apart => {
            let declared_um = rms_sigma_um(campaign);
            format!(
                "sigma_um, declared as {declared_um:.2} (rms of all), counts as {:.2}",
                sigma0 * declared_um
            )
        }
        true => "all uncertainties are multiplied by this".to_owned(),
        false => "uncertainties are those of the declared noise".to_owned(),
    };
    match noise_declared || degrees_of_freedom == 0 {
        true => notices.extend(report.residual_notices(&consequence, both_sides)),
        false => notices.push(format!(
            "sigma_um is not declared: the noise of a coordinate follows from the residuals ({degrees_of_freedom} \
             degrees of freedom)"
        )),
    }
    if let Some(words) = noise.in_words(report.uncertainty_factor * rms_sigma_um(campaign)) {
        notices.push(format!(
            "the points scatter by {words}: weights and uncertainties follow this"
        ));
    }
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

/// The standard deviation of a coordinate in the weights, rms of all readings, µm.
fn rms_sigma_um(campaign: &Campaign) -> f64 {
    let readings = campaign.points.iter().flat_map(|points| &points.readings);
    let sigmas = readings.map(|reading| reading.sigma_um.unwrap_or(UNDECLARED_SIGMA_UM));
    let sigmas: Vec<f64> = sigmas.collect();
    let squares: f64 = sigmas.iter().map(|sigma| sigma * sigma).sum();
    (squares / sigmas.len().max(1) as f64).sqrt()
}

/// The scatter of repeated points in units of the declared noise, with its degrees of freedom and p-value against the
/// noise found so far; if noise is declared, only a significant scatter.
fn repeat_factor(measured: &MeasuredPoints, report: &AdjustmentReport) -> Option<(f64, f64, f64)> {
    let (squares, degrees_of_freedom) = measured.repeat_scatter();
    let degrees = degrees_of_freedom as f64;
    let p_value = match report.factor_degrees_of_freedom.is_finite() {
        false => chi_squared_upper_tail(squares, degrees),
        true => {
            let ratio = squares / degrees / report.uncertainty_factor.powi(2);
            f_upper_tail(ratio, degrees, report.factor_degrees_of_freedom.min(MANY))
        }
    };
    let significant = !report.noise_declared || p_value < GLOBAL_TEST_LEVEL;
    (degrees_of_freedom > 0 && significant).then(|| ((squares / degrees).sqrt(), degrees, p_value))
}
