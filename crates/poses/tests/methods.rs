//! Whatever the way to them, poses are the same within their uncertainty, and the joint adjustment knows them best.

use nalgebra::Vector6;
use trueaxis_identify::SixRows;
use trueaxis_poses::{MeasuredPoses, Method, PoseNoise, Settings, measure};
use trueaxis_simulate::{Scenario, simulate};

const SCENARIOS: [&str; 2] = [
    include_str!("../../../campaigns/rotary-stage/scenario.json"),
    include_str!("../../../campaigns/fxyz/scenario.json"),
];

/// The largest of some hundred differences, in standard uncertainties.
const APART: f64 = 4.0;

/// Variances of a pose, mm² and rad².
fn variances(noise: &PoseNoise, pose: usize) -> Vector6<f64> {
    let coupling = noise.coupling(pose);
    (noise.own[pose] + coupling * &noise.shared * coupling.transpose()).diagonal()
}

/// The twist from a pose of one measurement to that of the other, about the pivot of the first: mm and rad.
fn twist(from: &MeasuredPoses<'_>, to: &MeasuredPoses<'_>, pose: usize) -> Vector6<f64> {
    let [from, to] = [from, to].map(|measured| &measured.poses.observations[pose]);
    assert_eq!((from.step, from.direction), (to.step, to.direction));
    let motion = to.datum_from_home * from.datum_from_home.inverse();
    let displacement = motion * from.pivot_mm - from.pivot_mm;
    let rotation = motion.rotation.scaled_axis();
    Vector6::from_iterator(displacement.iter().chain(&rotation).copied())
}

#[test]
fn the_methods_agree_and_the_joint_adjustment_knows_best() {
    for text in SCENARIOS {
        let scenario = Scenario::from_json(text).unwrap();
        let campaign = simulate(&scenario, 1).unwrap().campaign;
        let by = |method| {
            let settings = Settings {
                method,
                ..Settings::default()
            };
            measure(&campaign, &settings).unwrap()
        };
        let joint = by(Method::Joint);
        let noise = joint.by_equations.as_ref().unwrap();
        let (nine, six) = (&noise.nine, noise.six.as_ref().unwrap());
        let poses = joint.poses.observations.len();
        assert_eq!(poses, campaign.steps.len());
        for (method, noise) in [(Method::Nine, nine), (Method::Six(SixRows::PAPER), six)] {
            let other = by(method);
            assert_eq!(other.poses.observations.len(), poses);
            for pose in 0..poses {
                let variances = variances(noise, pose);
                let in_u = twist(&joint, &other, pose).component_div(&variances.map(f64::sqrt));
                assert!(in_u.amax() < APART, "{method:?}, pose {pose}: {in_u}");
            }
        }
        for pose in 0..poses {
            let [joint, nine, six] = [&joint.poses.noise, nine, six].map(|n| variances(n, pose));
            for c in 0..6 {
                // All weigh with the same noise; only rounding is allowed for.
                assert!(joint[c] <= nine[c] * (1.0 + 1e-6), "pose {pose}, {c}");
                assert!(nine[c] <= six[c] * (1.0 + 1e-6), "pose {pose}, {c}");
            }
        }
    }
}
