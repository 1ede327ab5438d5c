//! Whether the targets move as a rigid triangle.
//!
//! Each step is compared with the shape of its run: first with the median over the steps, which
//! steps that fail do not bend, then with the mean over those that passed. The noise is the declared
//! one, or larger if most steps say so.

use nalgebra::Vector3;
use rayon::prelude::*;
use trueaxis_campaign::Campaign;
use trueaxis_identify::{RigidMisfit, StepPose, nine, rigid_misfit};
use trueaxis_leastsquares::chi_squared_upper_tail;

use crate::points::equations::PointPoses;
use crate::report::StepMisfit;
use crate::words::step_in_words;

/// Family-wise significance of the test of all steps together.
const LEVEL: f64 = 0.01;

/// Steps that one thread takes at a time.
const PIECE: usize = 32;

/// Sum of squares of the test over all steps, and its degrees of freedom: those of the steps less
/// the shape of each body, which is estimated.
///
/// Each step is tested with the covariance of its distance from the mean shape, so that on average
/// its sum equals its own degrees of freedom; together they have fewer, and the sum is scaled down
/// to follow chi-squared with these.
pub(crate) fn total(points: &PointPoses) -> (f64, usize) {
    let (squares, degrees) = points
        .equations
        .steps()
        .fold((0.0, 0), |(squares, degrees), step| {
            (
                squares + step.pose.misfit.chi_squared,
                degrees + step.pose.misfit.degrees_of_freedom,
            )
        });
    let bodies = points.poses.bodies.iter();
    let shapes: usize = bodies.map(|body| 3 * body.targets.len() - 6).sum();
    let left = degrees.saturating_sub(shapes);
    (squares * left as f64 / degrees.max(1) as f64, left)
}

/// The steps that fail, in measuring order. `declared` says whether the noise is; if not, the
/// steps themselves are the measure.
pub(crate) fn misfits(campaign: &Campaign, points: &PointPoses, declared: bool) -> Vec<StepMisfit> {
    let fits: Vec<&StepPose> = points.equations.steps().collect();
    let level = LEVEL / fits.len() as f64;
    let run_of = |i: usize| campaign.steps[points.poses.observations[i].step].run;
    let mut found = Vec::new();
    for run in 0..campaign.runs.len() {
        let records: Vec<usize> = (0..fits.len())
            .filter(|&i| run_of(i) == Some(run))
            .collect();
        for (record, misfit, p_value) in failing(&records, &fits, declared, level) {
            found.push(StepMisfit {
                step: step_in_words(campaign, points.poses.observations[record].step),
                rms_um: misfit.rms_um,
                chi_squared: misfit.chi_squared,
                degrees_of_freedom: misfit.degrees_of_freedom,
                p_value,
            });
        }
    }
    found
}

/// A record that fails, with its test and p-value.
type Failing = (usize, RigidMisfit, f64);

/// Failing records of one run with their test against the mean shape of the others. The sum of
/// squares is in units of the noise that most steps show.
fn failing(records: &[usize], fits: &[&StepPose], declared: bool, level: f64) -> Vec<Failing> {
    let Some(&first) = records.first() else {
        return Vec::new();
    };
    let against_shape = |shape: &[Vector3<f64>]| -> Vec<Failing> {
        let tested = records.par_iter().with_min_len(PIECE);
        let tested: Vec<(usize, RigidMisfit)> =
            tested.map(|&i| (i, against(fits[i], shape))).collect();
        let variance = typical_variance(&tested, declared);
        let with_p = |(i, mut misfit): (usize, RigidMisfit)| {
            misfit.chi_squared /= variance;
            let degrees_of_freedom = misfit.degrees_of_freedom as f64;
            let p_value = chi_squared_upper_tail(misfit.chi_squared, degrees_of_freedom);
            (i, misfit, p_value)
        };
        let tested = tested.into_iter().map(with_p);
        tested.filter(|(_, _, p_value)| *p_value < level).collect()
    };
    let shape_of = |combine: fn(Vec<f64>) -> f64, without: &[Failing]| -> Vec<Vector3<f64>> {
        let is_kept = |i: &&usize| without.binary_search_by_key(*i, |bad| bad.0).is_err();
        let kept: Vec<usize> = records.iter().filter(is_kept).copied().collect();
        let coordinate = |target: usize, c: usize| {
            combine(
                kept.iter()
                    .map(|&i| fits[i].distortion_mm[target][c])
                    .collect(),
            )
        };
        let targets = 0..fits[first].deltas_mm.len();
        let targets = targets.map(|t| Vector3::from_fn(|c, _| coordinate(t, c)));
        targets.collect()
    };
    let suspects = against_shape(&shape_of(median, &[]));
    if suspects.is_empty() {
        return suspects;
    }
    against_shape(&shape_of(mean, &suspects))
}

/// The factor on the variance that makes the median sum of squares what chi-squared says; not below
/// one if the noise is declared.
fn typical_variance(tested: &[(usize, RigidMisfit)], declared: bool) -> f64 {
    // Median of chi-squared by Wilson and Hilferty.
    let expected = |degrees: f64| degrees * (1.0 - 2.0 / (9.0 * degrees)).powi(3);
    let ratio = |(_, misfit): &(usize, RigidMisfit)| {
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
fn against(step: &StepPose, shape: &[Vector3<f64>]) -> RigidMisfit {
    let points_from_home = step.home_from_points.transpose();
    let deltas = step.deltas_mm.iter().zip(shape);
    let deltas: Vec<Vector3<f64>> = deltas
        .map(|(delta, w)| delta - points_from_home * w)
        .collect();
    // Both succeeded with these targets and this covariance when the record was identified.
    nine(step.pose.from_points.targets_mm())
        .and_then(|operator| rigid_misfit(&operator, &deltas, &step.about_shape))
        .unwrap_or_else(|_| step.pose.misfit.clone())
}
