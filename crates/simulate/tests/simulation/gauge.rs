//! The truth is in the least-squares gauge, and the gauge takes nothing else from the curves.

use nalgebra::{Rotation3, Vector3};
use serde_json::json;
use trueaxis_campaign::Direction;
use trueaxis_kinematics::{Axis, AxisKind, MotionError};
use trueaxis_simulate::{Simulated, simulate};

use crate::shipped;

/// Sums of a few dozen errors of 1e-2 mm; slopes are taken against positions in travels.
const SUM_TOL: f64 = 1e-12;

/// One axis of a simulated campaign: positions (mm or rad), and the mean of both directions.
struct Curves {
    axis: Axis,
    q: Vec<f64>,
    mean: Vec<MotionError>,
}

impl Curves {
    fn of(simulated: &Simulated) -> Vec<Self> {
        let machine = &simulated.campaign.machine;
        let axes = simulated.truth.axes.iter();
        let curves = axes.map(|truth| {
            let count = truth.positions.len() / truth.directions.as_ref().map_or(1, |_| 2);
            let (up, down) = (
                &truth.errors[..count],
                &truth.errors[truth.errors.len() - count..],
            );
            let mean = |(up, down): (&MotionError, &MotionError)| {
                MotionError::from_vector(&up.to_vector().lerp(&down.to_vector(), 0.5))
            };
            Self {
                axis: machine.axes()[machine.axis_index(&truth.name).unwrap()].clone(),
                q: truth.positions[..count].to_vec(),
                mean: up.iter().zip(down).map(mean).collect(),
            }
        });
        curves.collect()
    }

    /// δ and ε, each one vector per position.
    fn vectors(&self) -> [Vec<Vector3<f64>>; 2] {
        let errors = self.mean.iter();
        [
            errors.clone().map(|e| e.translation_mm).collect(),
            errors.map(|e| e.rotation_rad).collect(),
        ]
    }

    fn across(&self, v: &Vector3<f64>) -> Vector3<f64> {
        v - self.along(v)
    }

    fn along(&self, v: &Vector3<f64>) -> Vector3<f64> {
        let d = self.axis.direction();
        d.into_inner() * d.dot(v)
    }

    fn turn(&self, angle_rad: f64) -> Rotation3<f64> {
        Rotation3::from_axis_angle(&self.axis.direction(), angle_rad)
    }

    fn home(&self) -> usize {
        self.q.iter().position(|q| q.abs() < 1e-15).unwrap()
    }
}

#[test]
fn location_errors_leave_nothing_in_the_curves() {
    for name in shipped::NAMES {
        let simulated = simulate(&shipped::scenario(&shipped::json(name)), 1).unwrap();
        for curves in Curves::of(&simulated) {
            let [delta, epsilon] = curves.vectors();
            let home = curves.home();
            let sum = |weighted: &dyn Fn(f64, &Vector3<f64>) -> Vector3<f64>, values: &[_]| {
                let terms = curves.q.iter().zip(values);
                terms
                    .map(|(&q, v)| weighted(q, &curves.across(v)))
                    .sum::<Vector3<f64>>()
            };
            let mut vanishing = vec![sum(&|_, v| *v, &delta), curves.along(&delta[home])];
            match curves.axis.kind() {
                AxisKind::Linear => {
                    let travel_mm = curves.axis.travel()[1];
                    vanishing.push(sum(&|q, v| v * (q / travel_mm), &delta));
                    vanishing.push(epsilon[home]);
                }
                AxisKind::Rotary => {
                    vanishing.push(sum(&|q, v| curves.turn(-q) * v, &delta));
                    vanishing.push(sum(&|_, v| *v, &epsilon));
                    vanishing.push(sum(&|q, v| curves.turn(-q) * v, &epsilon));
                    vanishing.push(curves.along(&epsilon[home]));
                }
            }
            for (i, value) in vanishing.iter().enumerate() {
                let axis = curves.axis.name();
                assert!(
                    value.amax() < SUM_TOL,
                    "{name} {axis} condition {i}: {value}"
                );
            }
        }
    }
}

/// Rounding of two curves of 1e-2 mm.
const CURVE_TOL: f64 = 1e-15;

#[test]
fn the_gauge_takes_lines_and_turning_constants_only() {
    for name in shipped::NAMES {
        let mut json = shipped::json(name);
        let gauged = Curves::of(&simulate(&shipped::scenario(&json), 1).unwrap());
        json["gauge"] = json!("none");
        let given = Curves::of(&simulate(&shipped::scenario(&json), 1).unwrap());
        let mut most_taken = 0.0_f64;
        for (given, gauged) in given.iter().zip(&gauged) {
            let taken = given.vectors().into_iter().zip(gauged.vectors());
            for (part, (before, after)) in taken.enumerate() {
                let pairs = before.iter().zip(&after);
                let taken: Vec<_> = pairs.map(|(before, after)| before - after).collect();
                most_taken = taken.iter().fold(most_taken, |most, v| most.max(v.amax()));
                // Positions are evenly spaced: a line has equal differences, a vector that turns
                // with the axis has differences that turn, a constant has none.
                let step = given.q[1] - given.q[0];
                for triple in taken.windows(3) {
                    let (first, second) = (triple[1] - triple[0], triple[2] - triple[1]);
                    let expected = match (given.axis.kind(), part) {
                        (AxisKind::Linear, 0) => given.across(&first),
                        (AxisKind::Linear, _) => Vector3::zeros(),
                        (AxisKind::Rotary, _) => given.turn(step) * given.across(&first),
                    };
                    assert!((second - expected).amax() < CURVE_TOL);
                }
            }
        }
        assert!(most_taken > 1e-4, "{name} must need its gauge");
    }
}

#[test]
fn lost_motion_stays_half_on_either_side() {
    let simulated = simulate(&shipped::scenario(&shipped::json("five-axis")), 1).unwrap();
    let um = Vector3::new(0.0, 3.6e-3, 0.0);
    let arcsec = Vector3::new(0.0, 0.0, 4.2 * trueaxis_kinematics::ARCSEC);
    for truth in &simulated.truth.axes {
        let count = truth.positions.len() / 2;
        let directions = truth.directions.as_ref().unwrap();
        assert!(directions[..count].iter().all(|&d| d == Direction::Forward));
        assert!(
            directions[count..]
                .iter()
                .all(|&d| d == Direction::Backward)
        );
        let expected = match truth.name.as_str() {
            "Y" => (um, Vector3::zeros()),
            "C" => (Vector3::zeros(), arcsec),
            _ => Default::default(),
        };
        for (up, down) in truth.errors[..count].iter().zip(&truth.errors[count..]) {
            let lost = (
                down.translation_mm - up.translation_mm,
                down.rotation_rad - up.rotation_rad,
            );
            assert!((lost.0 - expected.0).amax() < CURVE_TOL);
            assert!((lost.1 - expected.1).amax() < CURVE_TOL);
        }
    }
}
