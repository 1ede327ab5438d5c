//! Predictions of calibrated machines against the exact truth of the simulator.

use nalgebra::{Isometry3, Point3, Vector6};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use trueaxis_calibrate::{Settings, calibrate};
use trueaxis_kinematics::{Branch, Component, GeometricErrors, Ideal, Machine};
use trueaxis_predict::CalibratedMachine;
use trueaxis_simulate::{Scenario, Term, TrueMachine, simulate};
use trueaxis_tests::{Deviation, Kind, Pooled, Scatter, in_parallel};

const SCENARIOS: [(&str, &str); 2] = [
    (
        "three-axis",
        include_str!("../../../campaigns/fxyz/scenario.json"),
    ),
    (
        "five-axis",
        include_str!("../../../campaigns/five-axis/scenario.json"),
    ),
];

/// A machine like that of the scenario, with other errors: curves of the same terms, none of the waves shorter. No
/// lost motion, so that there is one curve.
fn drawn(text: &str, rng: &mut ChaCha8Rng) -> Scenario {
    let mut scenario = Scenario::from_json(text).unwrap();
    let mut size = || 3.0 * rng.random::<f64>() - 1.5;
    for axis in scenario.errors.values_mut() {
        (axis.lost_motion_um, axis.lost_motion_arcsec) = (None, None);
        for term in axis.components.values_mut().flatten() {
            match term {
                Term::Polynomial { coefficients } => {
                    coefficients.iter_mut().for_each(|c| *c *= size());
                }
                Term::Sine {
                    amplitude,
                    phase_deg,
                    period_mm,
                    period_deg,
                } => {
                    *amplitude *= size();
                    *phase_deg += 120.0 * size();
                    let stretch = 1.0 + size().abs();
                    for period in [period_mm, period_deg].into_iter().flatten() {
                        *period *= stretch;
                    }
                }
                Term::Table { values, .. } => values.iter_mut().for_each(|v| *v *= size()),
            }
        }
        for location in axis.location_errors.values_mut() {
            let values = [&mut location.value_arcsec, &mut location.value_mm];
            values.into_iter().flatten().for_each(|v| *v *= size());
        }
    }
    scenario
}

/// Where the tool is against the workpiece, put together here.
fn tool_in_workpiece(
    machine: &Machine,
    errors: &impl GeometricErrors,
    positions: &[f64],
) -> Isometry3<f64> {
    let [tool, workpiece] = [Branch::Tool, Branch::Workpiece].map(|branch| {
        let last = machine.branch(branch).last();
        last.map_or_else(Isometry3::identity, |&axis| {
            machine.motion(errors, axis, positions)
        })
    });
    workpiece.inverse() * tool
}

/// Displacement of the tool point (mm) and rotation of the tool (rad), true against nominal.
fn true_error(truth: &TrueMachine, positions: &[f64], point_mm: Point3<f64>) -> Vector6<f64> {
    let machine = truth.machine();
    let actual = tool_in_workpiece(machine, truth, positions);
    let nominal = tool_in_workpiece(machine, &Ideal, positions);
    let displaced = actual * point_mm - nominal * point_mm;
    // Of a rotation by 1e-4 rad the matrix less the identity is skew to 1e-8.
    let [a, n] = [actual, nominal].map(|g| g.rotation.to_rotation_matrix().into_inner());
    let turned = a * n.transpose();
    let half = 0.5 * (turned - turned.transpose());
    Vector6::new(
        displaced.x,
        displaced.y,
        displaced.z,
        half[(2, 1)],
        half[(0, 2)],
        half[(1, 0)],
    )
}

/// Predictions at random poses of one machine: with all axes at steps, or anywhere between them.
struct Compared {
    at_steps: Vec<Deviation>,
    between: Vec<Deviation>,
}

fn compared(text: &str, seed: u64, poses: usize) -> Compared {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let scenario = drawn(text, &mut rng);
    let truth = scenario.true_machine().unwrap();
    let simulated = simulate(&scenario, seed).unwrap();
    let calibration = calibrate(&simulated.campaign, &Settings::default()).unwrap();
    let machine = calibration.calibrated_machine();
    let steps: Vec<Vec<f64>> = calibration
        .axes
        .iter()
        .map(|axis| axis.nodes.iter().map(|node| node.position).collect())
        .collect();
    let point =
        |rng: &mut ChaCha8Rng| Point3::from([(); 3].map(|()| 600.0 * rng.random::<f64>() - 100.0));
    let mut all = Compared {
        at_steps: Vec::new(),
        between: Vec::new(),
    };
    for _ in 0..poses {
        let at = steps
            .iter()
            .map(|steps| steps[rng.random_range(0..steps.len())]);
        let at: Vec<f64> = at.collect();
        all.at_steps
            .extend(deviations(&machine, &truth, &at, point(&mut rng)));
        let at = steps.iter().map(|steps| {
            let (low, high) = (steps[0], steps[steps.len() - 1]);
            low + (high - low) * rng.random::<f64>()
        });
        let at: Vec<f64> = at.collect();
        all.between
            .extend(deviations(&machine, &truth, &at, point(&mut rng)));
    }
    all
}

/// What gauge or frame define is left out.
fn deviations(
    machine: &CalibratedMachine,
    truth: &TrueMachine,
    positions: &[f64],
    point_mm: Point3<f64>,
) -> Vec<Deviation> {
    let predicted = machine.predict(positions, point_mm);
    let error = predicted.error.to_vector() - true_error(truth, positions, point_mm);
    let u = predicted.u();
    let of = |component: Component| Deviation {
        name: format!("{} at {positions:?}", component.letter()),
        kind: Kind::Component(component),
        error: error[component.index()],
        u: u[component.index()],
        dof: machine.dof,
    };
    let mut all: Vec<Deviation> = Component::ALL.map(of).into();
    all.retain(|deviation| deviation.is_inside().is_some());
    all
}

/// At steps and between them, clustered by machine.
fn pooled(text: &str, machines: u64, poses: usize) -> [Pooled; 2] {
    let compared: Vec<Compared> = in_parallel(0..machines, |seed| compared(text, seed, poses));
    let (mut at_steps, mut between) = (Scatter::default(), Scatter::default());
    for machine in compared {
        at_steps.campaigns.push(machine.at_steps);
        between.campaigns.push(machine.between);
    }
    [at_steps, between].map(|scatter| scatter.pooled(|_| true))
}

/// With a fifth of the noise.
fn quiet(text: &str) -> String {
    let quiet = text.replace("\"length_sigma_um\": 0.269", "\"length_sigma_um\": 0.054");
    quiet.replace("\"repeatability_um\": 1.0", "\"repeatability_um\": 0.2")
}

/// With a fifth of the noise the curves between the steps are what is unknown: the uncertainty of the interpolation is
/// seen.
fn assert_covered(machines: u64, poses: usize, standard_errors: f64) {
    for (name, text) in SCENARIOS {
        for (noise, text) in [("", text), (", a fifth of the noise", &quiet(text))] {
            let [at_steps, between] = pooled(text, machines, poses);
            println!("{name}{noise}, {machines} machines, at steps: {at_steps}");
            println!("{name}{noise}, {machines} machines, between:  {between}");
            let off = at_steps.coverage.off(0.95);
            assert!(off.abs() < standard_errors, "{name}{noise}: {at_steps}");
            let off = between.coverage.off(0.95);
            assert!(off > -standard_errors, "{name}{noise}: {between}");
        }
    }
}

/// 95 % of the predictions at steps are inside ± t u, and between them at least as many, within 5 standard errors of
/// the scatter between machines (Student's, 7 degrees of freedom: by chance one of the eight numbers is off with a
/// probability of 1 %; the seeds are fixed).
#[test]
fn predictions_are_as_good_as_they_say() {
    assert_covered(8, 50, 5.0);
}

#[test]
#[ignore = "study: 800 calibrations, 1,600,000 predictions"]
fn many_predictions_are_as_good_as_they_say() {
    assert_covered(200, 1000, 3.0);
}

/// Curves of one kind: waves, or polynomials of the fifth degree, which are steepest where they were not measured.
fn curves(text: &str, are_waves: bool, rng: &mut ChaCha8Rng) -> Scenario {
    let mut scenario = Scenario::from_json(text).unwrap();
    let axes = scenario.errors.values_mut();
    for terms in axes.flat_map(|axis| axis.components.values_mut()) {
        let mut size = || 3.0 * rng.sample::<f64, _>(StandardNormal);
        let wave = |k: f64, amplitude: f64, turn: f64| Term::Sine {
            amplitude: amplitude / (k * k),
            period_mm: Some(800.0 / k),
            period_deg: None,
            phase_deg: 90.0 * turn,
        };
        *terms = match are_waves {
            true => (1..=4)
                .map(|k| wave(f64::from(k), size(), size()))
                .collect(),
            false => {
                let coefficients = (0..6_i32).map(|k| size() / f64::from(k.max(1)));
                vec![Term::Polynomial {
                    coefficients: coefficients.collect(),
                }]
            }
        };
    }
    scenario
}

/// Predictions with one axis beyond its first or last step by so many steps, the others at home.
fn outside(scenario: &Scenario, seed: u64, beyond: f64) -> Vec<Deviation> {
    let truth = scenario.true_machine().unwrap();
    let simulated = simulate(scenario, seed).unwrap();
    let calibration = calibrate(&simulated.campaign, &Settings::default()).unwrap();
    let machine = calibration.calibrated_machine();
    let mut all = Vec::new();
    for (number, axis) in calibration.axes.iter().enumerate() {
        let steps = [&axis.nodes[..2], &axis.nodes[axis.nodes.len() - 2..]];
        let [[first, second], [before, last]] =
            steps.map(|pair| [pair[0].position, pair[1].position]);
        let below = first - beyond * (second - first);
        for position in [below, last + beyond * (last - before)] {
            let mut at = vec![0.0; calibration.axes.len()];
            at[number] = position;
            all.extend(deviations(&machine, &truth, &at, Point3::origin()));
        }
    }
    all
}

/// As many steps beyond, clustered by machine.
fn pooled_outside(text: &str, are_waves: bool, machines: u64, beyond: f64) -> Pooled {
    let of_machine = |seed: u64| {
        let scenario = curves(text, are_waves, &mut ChaCha8Rng::seed_from_u64(seed));
        outside(&scenario, seed, beyond)
    };
    let campaigns = in_parallel(0..machines, of_machine);
    Scatter { campaigns }.pooled(|_| true)
}

/// Noise hid the slopes of angles, which are 0 at home by definition: u was 0 a step before home. 36 numbers of each machine,
/// within 5 standard errors, as above.
#[test]
fn a_step_outside_predictions_are_as_good_as_they_say() {
    let pooled = pooled_outside(SCENARIOS[0].1, false, 20, 1.0);
    println!("{pooled}");
    assert!(pooled.coverage.off(0.95) > -5.0, "{pooled}");
}

/// Farther out polynomials steepen by more than anything measured tells: 79 % at four steps.
#[test]
#[ignore = "study: 3200 calibrations"]
fn many_predictions_outside_the_steps() {
    let text = SCENARIOS[0].1;
    for (are_waves, name) in [(true, "waves"), (false, "polynomials")] {
        for (noise, text) in [("", text), (", a fifth of the noise", &quiet(text))] {
            for beyond in [0.5, 1.0, 2.0, 4.0] {
                let pooled = pooled_outside(text, are_waves, 200, beyond);
                println!("{name}{noise}, {beyond} steps beyond: {pooled}");
            }
        }
    }
}
