//! Whether the targets move as a rigid triangle.
//!
//! Each step is compared with the shape of its run: first with the median over the steps, which
//! steps that fail do not bend, then with the mean over those that passed. The noise is the declared
//! one, or larger if most steps say so.

use nalgebra::{DMatrix, Vector3};
use trueaxis_identify::{nine, rigid_misfit};
use trueaxis_kinematics::MICROMETRE;
use trueaxis_leastsquares::chi_squared_upper_tail;

use crate::axis_data::AxisData;
use crate::calibration::StepMisfit;
use crate::describe;
use crate::identify_axes::Identified;
use crate::in_order;
use crate::records::{Context, Misfit, RecordFit, rotated};

/// Family-wise significance of the test of all steps together.
const LEVEL: f64 = 0.01;

/// Sum of squares of the test over all steps, and its degrees of freedom: those of the steps less
/// the shape of the targets in each run, which is estimated.
///
/// Each step is tested with the covariance of its distance from the mean shape, so that on average
/// its sum equals its own degrees of freedom; together they have fewer, and the sum is scaled down
/// to follow chi-squared with these.
pub(crate) fn total(data: &[AxisData], identified: &Identified) -> (f64, usize) {
    let fits = identified.fits.iter().flatten();
    let (squares, degrees) = fits.fold((0.0, 0), |(squares, degrees), fit| {
        (
            squares + fit.misfit.chi_squared,
            degrees + fit.misfit.degrees_of_freedom,
        )
    });
    let runs = data.iter().flat_map(|axis| &axis.runs);
    let shapes: usize = runs.map(|run| 3 * run.targets.len() - 6).sum();
    let left = degrees.saturating_sub(shapes);
    (squares * left as f64 / degrees.max(1) as f64, left)
}

/// Rms of what rigid motions leave, mm.
pub(crate) fn rms_mm(identified: &Identified) -> f64 {
    let fits = identified.fits.iter().flatten();
    let squares: Vec<f64> = fits.map(|fit| fit.misfit.rms_um.powi(2)).collect();
    (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt() * MICROMETRE
}

/// The steps that fail, in measuring order. `declared` says whether the noise is; if not, the
/// steps themselves are the measure.
pub(crate) fn misfits(
    context: &Context<'_>,
    data: &[AxisData],
    identified: &Identified,
    declared: bool,
) -> Vec<StepMisfit> {
    let records: usize = identified.fits.iter().map(Vec::len).sum();
    let level = LEVEL / records as f64;
    let mut found = Vec::new();
    for (k, axis) in data.iter().enumerate() {
        let (fits, weights) = (&identified.fits[k], &identified.weights[k]);
        for run in 0..axis.runs.len() {
            for (record, misfit, p_value) in failing(axis, run, fits, weights, declared, level) {
                let step = context.measured.groups[axis.records[record].group].step;
                found.push(StepMisfit {
                    step: describe::step(context.campaign, step),
                    rms_um: misfit.rms_um,
                    chi_squared: misfit.chi_squared,
                    degrees_of_freedom: misfit.degrees_of_freedom,
                    p_value,
                });
            }
        }
    }
    found
}

/// Failing records of one run with their test against the mean shape of the others. The sum of
/// squares is in units of the noise that most steps show.
fn failing(
    axis: &AxisData,
    run: usize,
    fits: &[RecordFit],
    weights: &[DMatrix<f64>],
    declared: bool,
    level: f64,
) -> Vec<(usize, Misfit, f64)> {
    let records: Vec<usize> = (0..fits.len())
        .filter(|&i| axis.records[i].run == run)
        .collect();
    let against_shape = |shape: &[Vector3<f64>]| -> Vec<(usize, Misfit, f64)> {
        let mut tested: Vec<(usize, Misfit)> = in_order::map(records.len(), |n| {
            let i = records[n];
            (i, against(&fits[i], &weights[i], shape))
        });
        let variance = typical_variance(&tested, declared);
        tested
            .iter_mut()
            .for_each(|(_, misfit)| misfit.chi_squared /= variance);
        let with_p = |(i, misfit): (usize, Misfit)| {
            let degrees_of_freedom = misfit.degrees_of_freedom as f64;
            (
                i,
                misfit,
                chi_squared_upper_tail(misfit.chi_squared, degrees_of_freedom),
            )
        };
        let tested = tested.into_iter().map(with_p);
        tested.filter(|&(_, _, p_value)| p_value < level).collect()
    };
    let shape_of = |combine: fn(Vec<f64>) -> f64, without: &[(usize, Misfit, f64)]| {
        let kept = records
            .iter()
            .filter(|&&i| without.binary_search_by_key(&i, |bad| bad.0).is_err());
        let kept: Vec<&RecordFit> = kept.map(|&i| &fits[i]).collect();
        let targets = 0..axis.runs[run].targets.len();
        let coordinate = |target: usize, c: usize| {
            combine(
                kept.iter()
                    .map(|fit| fit.pose.distortion_mm[target][c])
                    .collect(),
            )
        };
        targets
            .map(|t| Vector3::from_fn(|c, _| coordinate(t, c)))
            .collect::<Vec<_>>()
    };
    let suspects = against_shape(&shape_of(median, &[]));
    if suspects.is_empty() {
        return suspects;
    }
    against_shape(&shape_of(mean, &suspects))
}

/// The factor on the variance that makes the median sum of squares what chi-squared says; not below
/// one if the noise is declared.
fn typical_variance(tested: &[(usize, Misfit)], declared: bool) -> f64 {
    // Median of chi-squared by Wilson and Hilferty.
    let expected = |degrees: f64| degrees * (1.0 - 2.0 / (9.0 * degrees)).powi(3);
    let ratio = |(_, misfit): &(usize, Misfit)| {
        misfit.chi_squared / expected(misfit.degrees_of_freedom as f64)
    };
    let typical = median(tested.iter().map(ratio).collect());
    if declared {
        typical.max(1.0)
    } else {
        typical.max(f64::MIN_POSITIVE)
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    let half = values.len() / 2;
    match values.len() {
        0 => 0.0,
        n if n % 2 == 1 => values[half],
        _ => 0.5 * (values[half - 1] + values[half]),
    }
}

fn mean(values: Vec<f64>) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// The test of a record against another shape of the targets.
fn against(fit: &RecordFit, weight: &DMatrix<f64>, shape: &[Vector3<f64>]) -> Misfit {
    let base_from_stage = fit.stage_from_base.transpose();
    let deltas = fit.deltas_mm.iter().zip(shape);
    let deltas: Vec<Vector3<f64>> = deltas
        .map(|(delta, w)| delta - base_from_stage * w)
        .collect();
    // Both succeeded with these targets and this covariance when the record was identified.
    nine(&fit.levers_mm)
        .and_then(|operator| {
            rigid_misfit(&operator, &deltas, &rotated(weight, &fit.base_from_datum))
        })
        .map_or(fit.misfit, |misfit| Misfit::from(&misfit))
}
