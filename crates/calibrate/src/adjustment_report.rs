//! What the residuals say about the declared noise.

use trueaxis_campaign::Campaign;
use trueaxis_kinematics::MICROMETRE;
use trueaxis_leastsquares::chi_squared_upper_tail;
use trueaxis_multilateration::Solution;

use crate::axis_data::AxisData;
use crate::calibration::AdjustmentReport;
use crate::identify_axes::Identified;
use crate::measured::Measured;
use crate::{from_lengths, rigidity};

/// Significance at which the declared noise is given up for the residuals' own: one clean campaign
/// in a thousand gets larger uncertainties than it needs.
const GLOBAL_TEST_LEVEL: f64 = 1e-3;

/// The report, and what a user must know of it added to `notices`.
pub(crate) fn report(
    campaign: &Campaign,
    by_direction: bool,
    measured: &Measured,
    data: &[AxisData],
    identified: &Identified,
    solution: Option<&Solution>,
    notices: &mut Vec<String>,
) -> AdjustmentReport {
    let instrument = &campaign.instrument;
    let (squares, observations, degrees_of_freedom, declared) = match solution {
        Some(solution) => (
            solution.squares,
            solution.observations,
            solution.degrees_of_freedom(),
            instrument.length_sigma_um.is_some(),
        ),
        None => {
            let (squares, degrees_of_freedom) = rigidity::total(data, identified);
            let readings = campaign.points.iter().flat_map(|points| &points.readings);
            let declared = readings
                .into_iter()
                .all(|reading| reading.sigma_um.is_some());
            (
                squares,
                3 * measured.points_mm.len(),
                degrees_of_freedom,
                declared,
            )
        }
    };
    let sigma0 = if degrees_of_freedom > 0 {
        (squares / degrees_of_freedom as f64).sqrt()
    } else {
        1.0
    };
    let p_value = chi_squared_upper_tail(squares, degrees_of_freedom as f64);
    let scaled = !declared || p_value < GLOBAL_TEST_LEVEL;
    let uncertainty_factor = if scaled { sigma0 } else { 1.0 };
    let uncertainty_factor = uncertainty_factor.max(repeat_factor(measured, declared, notices));
    if degrees_of_freedom == 0 {
        notices.push(
            "nothing checks the measurement: there are no more observations than unknowns"
                .to_owned(),
        );
    } else if !declared {
        notices.push(format!(
            "the noise is not declared: uncertainties follow from the residuals ({degrees_of_freedom} \
             degrees of freedom)"
        ));
    } else if p_value < GLOBAL_TEST_LEVEL {
        notices.push(format!(
            "the residuals are {sigma0:.2} times what the declared noise explains (p = {p_value:.0e}): \
             the model or the declared noise is wrong; all uncertainties are multiplied by {sigma0:.2}"
        ));
        if let (Some(solution), Some(lengths)) = (solution, &campaign.lengths) {
            notices.push(format!(
                "the largest residual is that of {}",
                from_lengths::worst_length(campaign, lengths, solution)
            ));
        }
        if !by_direction && approached_from_both_sides(campaign) {
            notices.push(
                "positions were approached from both sides: lost motion makes such residuals; \
                 --by-direction gives each side curves of its own"
                    .to_owned(),
            );
        }
    } else if p_value > 1.0 - GLOBAL_TEST_LEVEL {
        notices.push(format!(
            "the residuals are only {sigma0:.3} times what the declared noise explains: it is declared \
             too large, and so are the uncertainties"
        ));
    }
    AdjustmentReport {
        observations,
        unknowns: observations - degrees_of_freedom,
        degrees_of_freedom,
        sigma0,
        p_value,
        noise_declared: declared,
        uncertainty_factor,
        rms_residual_mm: match solution {
            Some(solution) => solution.rms_residual_mm(),
            None => rigidity::rms_mm(identified),
        },
        // Where none is declared the weights are those of 1 µm, and sigma0 estimates it.
        length_sigma_mm: solution.map(|_| {
            let declared_mm = instrument.length_sigma_um.map(|um| um * MICROMETRE);
            declared_mm.unwrap_or(sigma0 * MICROMETRE)
        }),
        repeatability_mm: instrument.repeatability_um.unwrap_or(0.0) * MICROMETRE,
        iterations: solution.map_or(0, |solution| solution.iterations),
        termination: solution.map_or_else(
            || "points measured directly, nothing to adjust".to_owned(),
            |solution| solution.termination.to_string(),
        ),
    }
}

/// How much larger than declared the scatter of repeated points is, if that is significant.
fn repeat_factor(measured: &Measured, declared: bool, notices: &mut Vec<String>) -> f64 {
    let (squares, degrees_of_freedom) = measured.repeat_scatter;
    let p_value = chi_squared_upper_tail(squares, degrees_of_freedom as f64);
    if degrees_of_freedom == 0 || (declared && p_value >= GLOBAL_TEST_LEVEL) {
        return 0.0;
    }
    let factor = (squares / degrees_of_freedom as f64).sqrt();
    if declared {
        notices.push(format!(
            "repeated points scatter {factor:.2} times as much as declared (p = {p_value:.1e}): declare \
             repeatability_um; until then all uncertainties are multiplied by {factor:.2} at least"
        ));
    }
    factor
}

fn approached_from_both_sides(campaign: &Campaign) -> bool {
    let lengths = campaign.lengths.iter().flat_map(|lengths| &lengths.stops);
    let points = campaign.points.iter().flat_map(|points| &points.stops);
    let mut directions = lengths.chain(points).map(|stop| stop.direction);
    let first = directions.next();
    directions.any(|direction| Some(direction) != first)
}
