//! Whether targets with measured coordinates move as a rigid triangle. (For lengths the adjustment itself shows it:
//! [`crate::lengths`].)
//!
//! Each step is compared with the shape of its run: first with the median over the steps, which steps that fail do
//! not bend, then with the mean over those that passed. The noise is the declared one, or larger if most steps show
//! so. Without a declared noise it is that of the steps that passed, with its uncertainty: a step whose test is `χ²`
//! in units of the points' variances has, against the mean shape of `m` others,
//!
//! ```text
//! F = χ² / (d s² (1 + 1/m))     s² = Σ χ² (of all that passed, in all runs) / Σ d (m - 1)
//! ```

use nalgebra::Vector3;
use rayon::prelude::*;
use trueaxis_campaign::Campaign;
use trueaxis_identify::{RigidMisfit, StepPose, nine, rigid_misfit};
use trueaxis_leastsquares::{chi_squared_upper_tail, f_upper_tail};

use crate::points::equations::PointPoses;
use crate::report::StepMisfit;
use crate::words::step_in_words;

/// Family-wise significance of the test of all steps together.
const LEVEL: f64 = 0.01;

/// Steps that one thread takes at a time.
const CHUNK: usize = 32;

/// Sum of squares of the test over all steps, and its degrees of freedom: those of the steps less those of the shape
/// of each body, which is estimated.
///
/// Each step is tested with the covariance of its distance from the mean shape, so that on average
/// its sum equals its own degrees of freedom; together they have fewer, and the sum is scaled down
/// to follow chi-squared with these.
pub(crate) fn total(points: &PointPoses) -> (f64, usize) {
    let misfits = || points.equations.steps().map(|step| &step.pose.misfit);
    let squares: f64 = misfits().map(|misfit| misfit.chi_squared).sum();
    let degrees: usize = misfits().map(|misfit| misfit.degrees_of_freedom).sum();
    let bodies = points.poses.bodies.iter();
    let shapes: usize = bodies.map(|body| 3 * body.targets.len() - 6).sum();
    let left = degrees.saturating_sub(shapes);
    (squares * left as f64 / degrees.max(1) as f64, left)
}

/// The steps that fail, in measuring order. Without `declared` noise the steps themselves determine it.
pub(crate) fn misfits(campaign: &Campaign, points: &PointPoses, declared: bool) -> Vec<StepMisfit> {
    let fits: Vec<&StepPose> = points.equations.steps().collect();
    let level = LEVEL / fits.len() as f64;
    // The poses of each run that has any.
    let mut runs = vec![Vec::new(); campaign.runs.len()];
    for (pose, own) in points.poses.observations.iter().enumerate() {
        if let Some(run) = campaign.steps[own.step].run {
            runs[run].push(pose);
        }
    }
    runs.retain(|poses| !poses.is_empty());
    let steps_of_body = |i: usize| {
        let observations = points.poses.observations.iter();
        let body = points.poses.observations[i].body;
        observations.filter(|other| other.body == body).count() as f64
    };
    let failing = match declared {
        true => failing_declared(&runs, &fits, level),
        false => failing_among_others(&runs, &fits, &steps_of_body, level),
    };
    let in_words = |(pose, misfit, p_value): Failing| StepMisfit {
        step: step_in_words(campaign, points.poses.observations[pose].step),
        rms_um: misfit.rms_um,
        chi_squared: misfit.chi_squared,
        degrees_of_freedom: misfit.degrees_of_freedom,
        p_value,
    };
    failing.into_iter().map(in_words).collect()
}

/// The index of a pose, with its test.
type Tested = (usize, RigidMisfit);

/// The index of a pose that fails, with its test and p-value.
type Failing = (usize, RigidMisfit, f64);

/// Poses that fail by the declared noise, or by that of most steps of their run if it is larger; the sum of squares
/// is in units of the noise used.
fn failing_declared(runs: &[Vec<usize>], fits: &[&StepPose], level: f64) -> Vec<Failing> {
    let mut failing = Vec::new();
    for poses in runs {
        let against_shape = |shape: &[Vector3<f64>]| {
            let tested = tested(poses, fits, shape);
            let variance = typical_variance(&tested).max(1.0);
            beyond(tested, variance, level)
        };
        let suspects = against_shape(&shape(poses, fits, median));
        if !suspects.is_empty() {
            // By the typical variance at least half of the steps pass.
            let kept = without(poses, &suspects);
            failing.extend(against_shape(&shape(&kept, fits, mean)));
        }
    }
    failing
}

/// Poses that fail by the noise of the others; the sum of squares is in units of that noise.
fn failing_among_others(
    runs: &[Vec<usize>],
    fits: &[&StepPose],
    steps_of_body: &dyn Fn(usize) -> f64,
    level: f64,
) -> Vec<Failing> {
    let against_median = |of: &Vec<usize>| tested(of, fits, &shape(of, fits, median));
    let against_median: Vec<Tested> = runs.iter().flat_map(against_median).collect();
    let typical = typical_variance(&against_median).max(f64::MIN_POSITIVE);
    let suspects = beyond(against_median, typical, level);
    // Each sum of squares is relative to a mean shape that contains the step itself.
    let own = |(i, misfit): &Tested| misfit.chi_squared * (1.0 - 1.0 / steps_of_body(*i));
    let (mut squares, mut degrees) = (0.0, 0.0);
    let mut left = Vec::new();
    for poses in runs {
        let kept = without(poses, &suspects);
        if kept.is_empty() {
            continue;
        }
        let count = kept.len() as f64;
        for tested in tested(poses, fits, &shape(&kept, fits, mean)) {
            if kept.contains(&tested.0) {
                squares += own(&tested);
                degrees += tested.1.degrees_of_freedom as f64 * (1.0 - 1.0 / count);
            } else {
                left.push((own(&tested) / (1.0 + 1.0 / count), tested));
            }
        }
    }
    if degrees <= 0.0 {
        return Vec::new();
    }
    let variance = (squares / degrees).max(f64::MIN_POSITIVE);
    let with_p = |(own, (i, mut misfit)): (f64, Tested)| {
        misfit.chi_squared = own / variance;
        let of_step = misfit.degrees_of_freedom as f64;
        let p_value = f_upper_tail(misfit.chi_squared / of_step, of_step, degrees);
        (i, misfit, p_value)
    };
    let failing = left.into_iter().map(with_p);
    failing.filter(|(_, _, p_value)| *p_value < level).collect()
}

fn tested(poses: &[usize], fits: &[&StepPose], shape: &[Vector3<f64>]) -> Vec<Tested> {
    let tested = poses.par_iter().with_min_len(CHUNK);
    tested.map(|&i| (i, against(fits[i], shape))).collect()
}

/// The poses that chi-squared with this variance does not explain.
fn beyond(tested: Vec<Tested>, variance: f64, level: f64) -> Vec<Failing> {
    let with_p = |(i, mut misfit): Tested| {
        misfit.chi_squared /= variance;
        let degrees_of_freedom = misfit.degrees_of_freedom as f64;
        let p_value = chi_squared_upper_tail(misfit.chi_squared, degrees_of_freedom);
        (i, misfit, p_value)
    };
    let tested = tested.into_iter().map(with_p);
    tested.filter(|(_, _, p_value)| *p_value < level).collect()
}

fn without(poses: &[usize], suspects: &[Failing]) -> Vec<usize> {
    let is_kept = |i: &&usize| suspects.iter().all(|suspect| suspect.0 != **i);
    poses.iter().filter(is_kept).copied().collect()
}

/// The common shape of some poses.
fn shape(poses: &[usize], fits: &[&StepPose], combine: fn(Vec<f64>) -> f64) -> Vec<Vector3<f64>> {
    let coordinate = |target: usize, c: usize| {
        let of_poses = poses.iter().map(|&i| fits[i].distortion_mm[target][c]);
        combine(of_poses.collect())
    };
    let targets = poses.first().map_or(0, |&i| fits[i].deltas_mm.len());
    let targets = (0..targets).map(|t| Vector3::from_fn(|c, _| coordinate(t, c)));
    targets.collect()
}

/// The factor on the variance that gives the median sum of squares its expected value.
fn typical_variance(tested: &[Tested]) -> f64 {
    // Median of chi-squared by Wilson and Hilferty.
    let expected = |degrees: f64| degrees * (1.0 - 2.0 / (9.0 * degrees)).powi(3);
    let ratio =
        |(_, misfit): &Tested| misfit.chi_squared / expected(misfit.degrees_of_freedom as f64);
    median(tested.iter().map(ratio).collect())
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

/// The test of a pose against another shape of the targets.
fn against(step: &StepPose, shape: &[Vector3<f64>]) -> RigidMisfit {
    let points_from_home = step.home_from_points.transpose();
    let deltas = step.deltas_mm.iter().zip(shape);
    let deltas: Vec<Vector3<f64>> = deltas
        .map(|(delta, w)| delta - points_from_home * w)
        .collect();
    // Both succeeded with these targets and this covariance when the pose was found.
    nine(step.pose.from_points.targets_mm())
        .and_then(|operator| rigid_misfit(&operator, &deltas, &step.about_shape))
        .unwrap_or_else(|_| step.pose.misfit.clone())
}
