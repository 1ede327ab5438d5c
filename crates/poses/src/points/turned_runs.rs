//! Runs that see the stage turned against each other where all axes stand alike, as at home.
//!
//! Squareness is the angle between the average lines of two runs, so an instrument that was moved or turned between them, or a machine
//! that shifted, makes it wrong by as much. The same targets at the same positions of all axes have one orientation:
//!
//! ```text
//! θ = log(R_a R_bᵀ)     χ² = θᵀ (C_a + C_b)⁻¹ θ, of all positions that two runs share
//! ```
//!
//! Displacements are not asked: the side from which the other axes came to stand there may move the stage by their lost motion. What two
//! runs have in common, the shape of their targets, turns both alike.

use nalgebra::{Matrix3, Vector3};
use trueaxis_campaign::Campaign;
use trueaxis_kinematics::ARCSEC;
use trueaxis_leastsquares::f_upper_tail;

use crate::poses::Poses;
use crate::report::TurnedRuns;
use crate::words::step_in_words;

/// Probability that any two runs of a campaign whose frame stands still are said to be turned.
const LEVEL: f64 = 1e-3;

/// Smaller ones are nothing that an instrument does, rad: what positions are rounded to, and angular lost motion of a good machine.
const LEAST_RAD: f64 = 0.5 * ARCSEC;

/// Pairs of runs that are turned. The noise of the poses is known with these degrees of freedom.
pub(crate) fn turned_runs(campaign: &Campaign, poses: &Poses, noise_dof: usize) -> Vec<TurnedRuns> {
    let runs = campaign.runs.len();
    let pairs: Vec<[usize; 2]> = (0..runs)
        .flat_map(|b| (0..b).map(move |a| [a, b]))
        .collect();
    let compared = pairs
        .iter()
        .filter_map(|&pair| compared(campaign, poses, pair));
    let compared: Vec<Compared> = compared.collect();
    let level = LEVEL / compared.len().max(1) as f64;
    let judged = compared.into_iter().map(|own| {
        let p_value = f_upper_tail(own.chi_squared / 3.0, 3.0, noise_dof.max(1) as f64);
        (own, p_value)
    });
    let turned =
        judged.filter(|(own, p_value)| *p_value < level && own.turned_rad.norm() > LEAST_RAD);
    turned
        .map(|(own, p_value)| TurnedRuns {
            runs: own.pair.map(|run| campaign.runs[run].name.clone()),
            at: step_in_words(campaign, own.step),
            turned_rad: own.turned_rad,
            u_rad: own.covariance.diagonal().map(f64::sqrt),
            chi_squared: own.chi_squared,
            p_value,
        })
        .collect()
}

/// Two runs at the positions that they share.
struct Compared {
    pair: [usize; 2],
    /// The first of these.
    step: usize,
    /// How far the second is turned against the first about the reference axes, rad.
    turned_rad: Vector3<f64>,
    covariance: Matrix3<f64>,
    chi_squared: f64,
}

/// None if they share no position, or their noise is not known.
fn compared(campaign: &Campaign, poses: &Poses, pair: [usize; 2]) -> Option<Compared> {
    let of_run = |run: usize| {
        let all = poses.observations.iter().enumerate();
        all.filter(move |(_, own)| campaign.steps[own.step].run == Some(run))
    };
    let (mut weights, mut sum, mut first) = (Matrix3::zeros(), Vector3::zeros(), None);
    for (i, a) in of_run(pair[0]) {
        for (k, b) in of_run(pair[1]) {
            let stand_alike = campaign.steps[a.step].positions == campaign.steps[b.step].positions;
            if !stand_alike || a.body != b.body || a.direction != b.direction {
                continue;
            }
            let rotation = |own: &crate::PoseObservation| own.datum_from_home.rotation;
            let turned = (rotation(b) * rotation(a).inverse()).scaled_axis();
            let of_angles = |i: usize| {
                let own = poses.noise.own.get(i)?;
                Some(own.fixed_view::<3, 3>(3, 3).into_owned())
            };
            let weight = (of_angles(i)? + of_angles(k)?).try_inverse()?;
            weights += weight;
            sum += weight * turned;
            first = first.or(Some(a.step));
        }
    }
    let covariance = weights.try_inverse()?;
    let turned_rad = covariance * sum;
    Some(Compared {
        pair,
        step: first?,
        turned_rad,
        covariance,
        chi_squared: turned_rad.dot(&(weights * turned_rad)),
    })
}
