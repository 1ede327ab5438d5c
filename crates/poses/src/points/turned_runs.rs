//! Runs between which the stage is turned at equal axis positions, such as home.
//!
//! Squareness is the angle between the average lines of two runs. An instrument or a machine that moved between them
//! makes it wrong by as much. The same targets at the same positions of all axes have one orientation:
//!
//! ```text
//! θ = log(R_b R_aᵀ)     χ² = θᵀ (C_a + C_b)⁻¹ θ, of all positions that two runs share
//! ```
//!
//! Displacements are not tested, nor angles about rotary axes that carry the targets: the other axes may have arrived
//! from different sides, and their lost motion moves the stage. The shape of the targets turns both runs alike.

use std::collections::BTreeMap;

use nalgebra::{Matrix3, SymmetricEigen, UnitQuaternion, Vector3};
use trueaxis_campaign::Campaign;
use trueaxis_kinematics::{ARCSEC, AxisKind, Ideal, centroid};
use trueaxis_leastsquares::f_upper_tail;

use crate::poses::Poses;
use crate::report::{MANY, TurnedRuns};
use crate::words::step_in_words;

/// Probability that any two runs of a campaign with a fixed frame are reported as turned.
const LEVEL: f64 = 1e-3;

/// Smaller angles are not the instrument's, rad: rounded positions, or angular lost motion of a good machine.
const LEAST_RAD: f64 = 0.5 * ARCSEC;

/// Weights below this share of the largest are rounding.
const ROUNDING: f64 = 1e-9;

/// Pairs of runs that are turned. `noise_dof` are the degrees of freedom of the noise of the poses.
pub(crate) fn turned_runs(campaign: &Campaign, poses: &Poses, noise_dof: f64) -> Vec<TurnedRuns> {
    let stands = stands(campaign, poses);
    let pairs = (0..stands.len()).flat_map(|b| (0..b).map(move |a| [a, b]));
    let compared = pairs.filter_map(|pair| compared(campaign, pair, &stands));
    let compared: Vec<Compared> = compared.collect();
    let level = LEVEL / compared.len().max(1) as f64;
    let judged = compared.into_iter().map(|own| {
        let freedom = own.degrees_of_freedom as f64;
        let p_value = f_upper_tail(own.chi_squared / freedom, freedom, noise_dof.min(MANY));
        (own, p_value)
    });
    let turned = judged.filter(|(own, p)| *p < level && own.turned_rad.norm() > LEAST_RAD);
    turned
        .map(|(own, p_value)| TurnedRuns {
            runs: own.pair.map(|run| campaign.runs[run].name.clone()),
            at: step_in_words(campaign, own.step),
            turned_rad: own.turned_rad,
            u_rad: own
                .covariance
                .diagonal()
                .map(|variance| variance.max(0.0).sqrt()),
            moved_mm: own.turned_rad.norm() * arm_mm(poses, own.body),
            chi_squared: own.chi_squared,
            degrees_of_freedom: own.degrees_of_freedom,
            p_value,
        })
        .collect()
}

/// The orientation of a body in a run at one position of all axes, the mean of both sides of approach.
struct Stand {
    step: usize,
    body: usize,
    /// The orientation on the first side, and the rotation of the mean from it.
    first: UnitQuaternion<f64>,
    turned_rad: Vector3<f64>,
    covariance: Matrix3<f64>,
    count: f64,
}

/// The orientations of a run by positions of all axes and body.
type Stands = BTreeMap<(Vec<u64>, usize), Stand>;

/// The orientations of each run; empty if the noise is not known.
fn stands(campaign: &Campaign, poses: &Poses) -> Vec<Stands> {
    let mut all: Vec<Stands> = campaign.runs.iter().map(|_| Stands::new()).collect();
    for (own, noise) in poses.observations.iter().zip(&poses.noise.own) {
        let step = &campaign.steps[own.step];
        let Some(run) = step.run else { continue };
        let rotation = own.datum_from_home.rotation;
        let positions = step.positions.iter().map(|q| q.to_bits()).collect();
        let stand = all[run].entry((positions, own.body)).or_insert(Stand {
            step: own.step,
            body: own.body,
            first: rotation,
            turned_rad: Vector3::zeros(),
            covariance: Matrix3::zeros(),
            count: 0.0,
        });
        stand.turned_rad += (rotation * stand.first.inverse()).scaled_axis();
        stand.covariance += noise.fixed_view::<3, 3>(3, 3);
        stand.count += 1.0;
    }
    for stand in all.iter_mut().flat_map(BTreeMap::values_mut) {
        stand.turned_rad /= stand.count;
        stand.covariance /= stand.count * stand.count;
    }
    all
}

/// Two runs at the positions that they share.
struct Compared {
    pair: [usize; 2],
    /// The first of these positions, and the body there.
    step: usize,
    body: usize,
    /// Rotation of the second run against the first about the reference axes, in the directions that are tested, rad.
    turned_rad: Vector3<f64>,
    covariance: Matrix3<f64>,
    chi_squared: f64,
    degrees_of_freedom: usize,
}

/// `None` if the runs share no position that is tested.
fn compared(campaign: &Campaign, pair: [usize; 2], stands: &[Stands]) -> Option<Compared> {
    let (mut weights, mut sum, mut first) = (Matrix3::zeros(), Vector3::zeros(), None);
    for (place, a) in &stands[pair[0]] {
        let Some(b) = stands[pair[1]].get(place) else {
            continue;
        };
        let between = (b.first * a.first.inverse()).scaled_axis();
        let turned = between + b.turned_rad - a.turned_rad;
        let mut weight = (a.covariance + b.covariance).try_inverse()?;
        for direction in rotary_directions(campaign, a) {
            let along = weight * direction;
            let all = direction.dot(&along);
            if all > 0.0 {
                weight -= along * along.transpose() / all;
            }
        }
        weights += weight;
        sum += weight * turned;
        first = first.or(Some((a.step, a.body)));
    }
    let (step, body) = first?;
    let eigen = SymmetricEigen::new(weights);
    let limit = ROUNDING * eigen.eigenvalues.amax();
    let inverse = eigen
        .eigenvalues
        .map(|w| if w > limit { 1.0 / w } else { 0.0 });
    let degrees_of_freedom = inverse.iter().filter(|w| **w > 0.0).count();
    let axes = eigen.eigenvectors;
    let covariance = axes * Matrix3::from_diagonal(&inverse) * axes.transpose();
    let turned_rad = covariance * sum;
    (degrees_of_freedom > 0).then_some(Compared {
        pair,
        step,
        body,
        turned_rad,
        covariance,
        chi_squared: turned_rad.dot(&sum),
        degrees_of_freedom,
    })
}

/// Directions of the rotary axes that carry the targets, in their present positions.
fn rotary_directions(campaign: &Campaign, stand: &Stand) -> Vec<Vector3<f64>> {
    let (machine, positions) = (&campaign.machine, &campaign.steps[stand.step].positions);
    let run = campaign.steps[stand.step].run;
    let targets = campaign.targets.iter().filter_map(|target| target.carrier);
    let carried = targets.filter(|&carrier| {
        let axis = run.map(|run| campaign.runs[run].axis);
        axis.is_some_and(|axis| machine.chain(Some(carrier)).contains(&axis))
    });
    let mut axes: Vec<usize> = carried
        .flat_map(|c| machine.chain(Some(c)).to_vec())
        .collect();
    axes.sort_unstable();
    axes.dedup();
    axes.retain(|&axis| machine.axes()[axis].kind() == AxisKind::Rotary);
    let direction = |axis: usize| {
        let motion = machine.chain_motion(&Ideal, machine.chain(Some(axis)), positions);
        motion.rotation * machine.axes()[axis].direction().into_inner()
    };
    axes.into_iter().map(direction).collect()
}

/// Rms distance of the targets of a body from their middle, mm.
fn arm_mm(poses: &Poses, body: usize) -> f64 {
    let home_mm = &poses.bodies[body].home_mm;
    let middle = centroid(home_mm);
    let squares = home_mm.iter().map(|p| (p - middle).norm_squared());
    (squares.sum::<f64>() / home_mm.len().max(1) as f64).sqrt()
}
