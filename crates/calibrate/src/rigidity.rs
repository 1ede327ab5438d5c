//! Whether the targets move as a rigid triangle.
//!
//! Each step is compared with the mean shape of its run. A step that fails would itself bend the
//! mean, so failures are taken out one at a time, the worst first, and the rest is compared with
//! the mean of what is left.

use nalgebra::Vector3;
use trueaxis_identify::{nine, rigid_misfit};
use trueaxis_kinematics::MICROMETRE;
use trueaxis_leastsquares::chi_squared_upper_tail;

use crate::axis_data::AxisData;
use crate::calibration::StepMisfit;
use crate::describe;
use crate::identify_axes::Identified;
use crate::records::{Context, Misfit, RecordFit};

/// Family-wise significance of the test of all steps together.
const LEVEL: f64 = 0.01;

/// With more than one step in so many failing, the mean shape is no reference any more.
const MOST_FAILING: usize = 3;

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

/// The steps that fail, in measuring order. `factor` is the factor on all uncertainties.
pub(crate) fn misfits(
    context: &Context<'_>,
    data: &[AxisData],
    identified: &Identified,
    factor: f64,
) -> Vec<StepMisfit> {
    let records: usize = identified.fits.iter().map(Vec::len).sum();
    let level = LEVEL / records as f64;
    let mut found = Vec::new();
    for (axis, fits) in data.iter().zip(&identified.fits) {
        for run in 0..axis.runs.len() {
            for (record, misfit) in failing(axis, run, fits, factor, level) {
                let step = context.measured.groups[axis.records[record].group].step;
                found.push(StepMisfit {
                    step: describe::step(context.campaign, step),
                    rms_um: misfit.rms_um,
                    chi_squared: misfit.chi_squared / factor.powi(2),
                    degrees_of_freedom: misfit.degrees_of_freedom,
                    p_value: p_value(&misfit, factor),
                });
            }
        }
    }
    found
}

fn p_value(misfit: &Misfit, factor: f64) -> f64 {
    chi_squared_upper_tail(
        misfit.chi_squared / factor.powi(2),
        misfit.degrees_of_freedom as f64,
    )
}

/// Failing records of one run with their test against the mean shape of the others.
fn failing(
    axis: &AxisData,
    run: usize,
    fits: &[RecordFit],
    factor: f64,
    level: f64,
) -> Vec<(usize, Misfit)> {
    let records: Vec<usize> = (0..fits.len())
        .filter(|&i| axis.records[i].run == run)
        .collect();
    let most = records.len() / MOST_FAILING;
    let mut failing: Vec<usize> = Vec::new();
    loop {
        let shape = mean_shape(axis, run, fits, &failing);
        let tested = |&i: &usize| (i, against(axis, run, &fits[i], i, &shape));
        let left = records.iter().filter(|i| !failing.contains(i));
        let worst = left
            .map(tested)
            .min_by(|a, b| p_value(&a.1, factor).total_cmp(&p_value(&b.1, factor)));
        match worst {
            Some((i, misfit)) if failing.len() < most && p_value(&misfit, factor) < level => {
                failing.push(i);
            }
            _ => {
                failing.sort_unstable();
                return failing.iter().map(tested).collect();
            }
        }
    }
}

/// Mean distortion of the run's targets over the records that do not fail, on the stage at home.
fn mean_shape(
    axis: &AxisData,
    run: usize,
    fits: &[RecordFit],
    failing: &[usize],
) -> Vec<Vector3<f64>> {
    let targets = &axis.runs[run].targets;
    let mut sums = vec![(Vector3::zeros(), 0.0); targets.len()];
    for (i, fit) in fits.iter().enumerate() {
        if axis.records[i].run != run || failing.contains(&i) {
            continue;
        }
        for (&(target, _), distortion) in axis.records[i].targets.iter().zip(&fit.distortion_mm) {
            if let Some(place) = targets.iter().position(|&t| t == target) {
                sums[place].0 += distortion;
                sums[place].1 += 1.0;
            }
        }
    }
    sums.into_iter()
        .map(|(sum, count)| if count > 0.0 { sum / count } else { sum })
        .collect()
}

/// The test of a record against another mean shape.
fn against(
    axis: &AxisData,
    run: usize,
    fit: &RecordFit,
    record: usize,
    shape: &[Vector3<f64>],
) -> Misfit {
    let targets = &axis.runs[run].targets;
    let deltas: Vec<Vector3<f64>> = axis.records[record]
        .targets
        .iter()
        .zip(&fit.deltas_mm)
        .map(|(&(target, _), delta)| {
            let place = targets.iter().position(|&t| t == target).unwrap_or(0);
            delta - fit.stage_from_base.transpose() * shape[place]
        })
        .collect();
    // Both succeeded with these targets and this covariance when the record was identified.
    nine(&fit.levers_mm)
        .and_then(|operator| rigid_misfit(&operator, &deltas, &fit.covariance))
        .map_or(fit.misfit, |misfit| Misfit::from(&misfit))
}
