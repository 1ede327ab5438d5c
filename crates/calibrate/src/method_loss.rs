//! What other methods would lose on the same lengths.
//!
//! The points that the same lengths have without rigid stages make poses by nine or six equations. Their
//! noise goes through the dependence of the results on the poses, which is that of the joint adjustment: no
//! second search and no second identification.

use trueaxis_campaign::Campaign;
use trueaxis_identify::SixRows;

use crate::calibration::MethodLoss;
use crate::measure::Measured;
use crate::nine::{PointPoses, poses_from_points};
use crate::poses::PoseNoise;
use crate::settings::Method;
use crate::uncertainty::{Noise, Propagation};

/// For each axis the ratios of standard uncertainties; `None` where the joint adjustment was not used.
pub(crate) fn method_loss(
    campaign: &Campaign,
    measured: &Measured<'_>,
    propagation: &Propagation<'_>,
) -> Vec<Option<MethodLoss>> {
    let axes = propagation.dependence.data.len();
    let points = measured
        .points
        .as_ref()
        .filter(|_| measured.method == Method::Joint);
    let Some((points, by_nine)) = points else {
        return vec![None; axes];
    };
    let by_six = Method::Six(SixRows::PAPER);
    let by_six = poses_from_points(campaign, points, by_six).ok();
    let joint = squares(&propagation.whole, axes);
    let ratios = |found: &PointPoses| {
        let noise = at_the_same_pivots(found, measured)?;
        let other = squares(&Noise::new(propagation.dependence, &noise), axes);
        let ratio =
            |(a, b): (&[f64; 6], &[f64; 6])| std::array::from_fn(|c| (a[c] / b[c]).max(0.0).sqrt());
        Some(
            other
                .iter()
                .zip(&joint)
                .map(ratio)
                .collect::<Vec<[f64; 6]>>(),
        )
    };
    let (nine, six) = (ratios(by_nine), by_six.as_ref().and_then(ratios));
    let of_axis = |k: usize| {
        Some(MethodLoss {
            nine: nine.as_ref()?[k],
            six: six.as_ref().map(|six| six[k]),
        })
    };
    (0..axes).map(of_axis).collect()
}

/// Sums of the variances of each component over the nodes of each axis.
fn squares(noise: &Noise<'_>, axes: usize) -> Vec<[f64; 6]> {
    let of_axis = |k: usize| {
        let mut sums = [0.0; 6];
        for node in noise.components(k) {
            for (sum, variance) in sums.iter_mut().zip(node) {
                *sum += (variance.own + variance.through).max(0.0);
            }
        }
        sums
    };
    (0..axes).map(of_axis).collect()
}

/// The noise of poses by equations at the pivots of those of the joint adjustment; `None` if they are not of
/// the same steps.
fn at_the_same_pivots(found: &PointPoses, measured: &Measured<'_>) -> Option<PoseNoise> {
    let joint = &measured.poses().observations;
    let mut noise = found.poses.noise.clone();
    if found.poses.observations.len() != joint.len() {
        return None;
    }
    let pairs = found.poses.observations.iter().zip(joint);
    for (i, (from, to)) in pairs.enumerate() {
        if (from.step, from.direction) != (to.step, to.direction) {
            return None;
        }
        let map = from.to_pivot(&to.pivot_mm);
        noise.own[i] = map * noise.own[i] * map.transpose();
        noise.coupling[i] = map * &noise.coupling[i];
    }
    Some(noise)
}
