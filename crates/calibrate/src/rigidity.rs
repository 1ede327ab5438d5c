//! Whether the targets move as a rigid triangle.
//!
//! Each step is compared with the shape of its run: first with the median over the steps, which
//! steps that fail do not bend, then with the mean over those that passed. The noise is the declared
//! one, or larger if most steps say so.

use std::collections::{BTreeMap, HashMap};

use nalgebra::Vector3;
use trueaxis_campaign::{Campaign, Lengths};
use trueaxis_identify::{RigidMisfit, StepPose, nine, rigid_misfit};
use trueaxis_kinematics::MICROMETRE;
use trueaxis_leastsquares::chi_squared_upper_tail;
use trueaxis_multilateration::Screened;

use crate::calibration::StepMisfit;
use crate::describe;
use crate::in_order;
use crate::nine::PointPoses;

/// Family-wise significance of the test of all steps together.
const LEVEL: f64 = 0.01;

/// Sum of squares of the test over all steps, and its degrees of freedom: those of the steps less
/// the shape of each body, which is estimated.
///
/// Each step is tested with the covariance of its distance from the mean shape, so that on average
/// its sum equals its own degrees of freedom; together they have fewer, and the sum is scaled down
/// to follow chi-squared with these.
pub(crate) fn total(points: &PointPoses) -> (f64, usize) {
    let (squares, degrees) = points.steps().fold((0.0, 0), |(squares, degrees), step| {
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

/// Rms of what rigid motions leave, mm.
pub(crate) fn rms_mm(points: &PointPoses) -> f64 {
    let steps = points.steps();
    let squares: Vec<f64> = steps.map(|step| step.pose.misfit.rms_um.powi(2)).collect();
    (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt() * MICROMETRE
}

/// The steps that fail, in measuring order. `declared` says whether the noise is; if not, the
/// steps themselves are the measure.
pub(crate) fn misfits(campaign: &Campaign, points: &PointPoses, declared: bool) -> Vec<StepMisfit> {
    let fits: Vec<&StepPose> = points.steps().collect();
    let level = LEVEL / fits.len() as f64;
    let run_of = |i: usize| campaign.steps[points.poses.observations[i].step].run;
    let mut found = Vec::new();
    for run in 0..campaign.runs.len() {
        let records: Vec<usize> = (0..fits.len()).filter(|&i| run_of(i) == run).collect();
        for (record, misfit, p_value) in failing(&records, &fits, declared, level) {
            found.push(StepMisfit {
                step: describe::step(campaign, points.poses.observations[record].step),
                rms_um: misfit.rms_um,
                chi_squared: misfit.chi_squared,
                degrees_of_freedom: misfit.degrees_of_freedom,
                p_value,
            });
        }
    }
    found
}

/// Steps at which the lengths to a target contradict the rigid body so much that half of them or more were
/// removed: it stood elsewhere. The sum of squares is that of the displacement of the target, whose three
/// coordinates explain them.
pub(crate) fn lost_targets(
    campaign: &Campaign,
    lengths: &Lengths,
    screened: &Screened,
) -> Vec<StepMisfit> {
    let mut errors: HashMap<usize, (f64, f64)> = HashMap::new();
    for removed in &screened.removed {
        errors.insert(removed.reading, (removed.error_mm, removed.u_mm));
    }
    let mut seen: BTreeMap<(usize, usize), Seen> = BTreeMap::new();
    for stop in &lengths.stops {
        for i in stop.readings.clone() {
            let key = (stop.step, lengths.readings[i].target);
            let seen = seen.entry(key).or_default();
            seen.lengths += 1;
            seen.removed.extend(errors.get(&i));
        }
    }
    let lost = |(&(step, _), seen): (&(usize, usize), &Seen)| {
        let errors = &seen.removed;
        if errors.len() < COORDINATES || 2 * errors.len() < seen.lengths {
            return None;
        }
        let squares: f64 = errors.iter().map(|(error, _)| error * error).sum();
        let chi_squared = errors.iter().map(|(error, u)| (error / u).powi(2)).sum();
        Some(StepMisfit {
            step: describe::step(campaign, step),
            rms_um: (squares / errors.len() as f64).sqrt() / MICROMETRE,
            chi_squared,
            degrees_of_freedom: COORDINATES,
            p_value: chi_squared_upper_tail(chi_squared, COORDINATES as f64),
        })
    };
    seen.iter().filter_map(lost).collect()
}

/// The lengths to a target at a step.
#[derive(Default)]
struct Seen {
    lengths: usize,
    /// Error and its standard uncertainty of those that were removed, mm.
    removed: Vec<(f64, f64)>,
}

/// Of a displacement.
const COORDINATES: usize = 3;

/// A record that fails, with its test and p-value.
type Failing = (usize, RigidMisfit, f64);

/// Failing records of one run with their test against the mean shape of the others. The sum of
/// squares is in units of the noise that most steps show.
fn failing(records: &[usize], fits: &[&StepPose], declared: bool, level: f64) -> Vec<Failing> {
    let Some(&first) = records.first() else {
        return Vec::new();
    };
    let against_shape = |shape: &[Vector3<f64>]| -> Vec<Failing> {
        let mut tested: Vec<(usize, RigidMisfit)> = in_order::map(records.len(), |n| {
            let i = records[n];
            (i, against(fits[i], shape))
        });
        let variance = typical_variance(&tested, declared);
        tested
            .iter_mut()
            .for_each(|(_, misfit)| misfit.chi_squared /= variance);
        let with_p = |(i, misfit): (usize, RigidMisfit)| {
            let degrees_of_freedom = misfit.degrees_of_freedom as f64;
            let p_value = chi_squared_upper_tail(misfit.chi_squared, degrees_of_freedom);
            (i, misfit, p_value)
        };
        let tested = tested.into_iter().map(with_p);
        tested.filter(|(_, _, p_value)| *p_value < level).collect()
    };
    let shape_of = |combine: fn(Vec<f64>) -> f64, without: &[Failing]| {
        let kept = records
            .iter()
            .filter(|&&i| without.binary_search_by_key(&i, |bad| bad.0).is_err());
        let kept: Vec<&StepPose> = kept.map(|&i| fits[i]).collect();
        let targets = 0..fits[first].deltas_mm.len();
        let coordinate = |target: usize, c: usize| {
            combine(
                kept.iter()
                    .map(|fit| fit.distortion_mm[target][c])
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
