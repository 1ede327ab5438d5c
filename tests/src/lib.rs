//! Comparison of calibrations with the truth of simulated campaigns.
//!
//! Not published; the tests and studies are in `tests/`, programs for other counts in `examples/`.

pub mod blind;
pub mod estimators;
mod in_parallel;
mod kind;
mod scatter;
pub mod verification;

pub use in_parallel::in_parallel;
pub use kind::Kind;
pub use scatter::{Estimate, Pooled, Scatter};

use trueaxis_calibrate::{AxisResult, Calibration};
use trueaxis_campaign::Direction;
use trueaxis_kinematics::{Component, MICROMETRE};
use trueaxis_predict::coverage_factor;
use trueaxis_simulate::{TrueComponents, Truth};

/// One number that was estimated, in mm or rad.
#[derive(Debug, Clone)]
pub struct Deviation {
    /// Its name, as `EXX at 40`.
    pub name: String,
    /// What it is.
    pub kind: Kind,
    /// Estimate minus truth.
    pub error: f64,
    /// Stated standard uncertainty.
    pub u: f64,
    /// Its degrees of freedom.
    pub dof: f64,
}

impl Deviation {
    /// Whether the stated 95 % interval holds the truth; `None` where gauge or frame define the
    /// number, which then must be exact.
    pub fn is_inside(&self) -> Option<bool> {
        if self.u < ZERO {
            assert!(
                self.error.abs() < ZERO,
                "{} = {:e}, u = 0",
                self.name,
                self.error
            );
            return None;
        }
        Some(self.error.abs() < coverage_factor(self.dof) * self.u)
    }

    /// `(error / u)²`, divided by the mean that it has with Student's distribution: one on average. With
    /// two degrees of freedom or less there is no mean.
    pub fn square(&self) -> f64 {
        let mean = if self.dof.is_finite() {
            self.dof / (self.dof - 2.0)
        } else {
            1.0
        };
        (self.error / self.u).powi(2) / mean
    }
}

/// What is zero by definition (gauge at home, frame) has no uncertainty, mm or rad.
const ZERO: f64 = 1e-9;

/// Component errors of all axes: estimate minus truth. Where the calibration does not keep the
/// sides of approach apart, the truth is their mean.
pub fn components(calibration: &Calibration, truth: &Truth) -> Vec<Deviation> {
    let mut all = Vec::new();
    for (found, true_axis) in calibration.axes.iter().zip(&truth.axes) {
        assert_eq!(
            found.name, true_axis.name,
            "axes in the order of the machine"
        );
        all.extend(components_of(found, true_axis));
    }
    all
}

fn components_of(found: &AxisResult, truth: &TrueComponents) -> Vec<Deviation> {
    let mut all = Vec::new();
    for node in &found.nodes {
        let at: Vec<usize> = (0..truth.positions.len())
            .filter(|&k| (truth.positions[k] - node.position).abs() < 1e-9)
            .filter(|&k| node.direction.is_none_or(|side| side_of(truth, k) == side))
            .collect();
        assert!(
            !at.is_empty(),
            "{} at {}: no truth",
            found.name,
            node.position
        );
        let error = node.error.to_vector();
        let side = match node.direction {
            Some(Direction::Forward) => ", forward",
            Some(Direction::Backward) => ", backward",
            None => "",
        };
        for component in Component::ALL {
            let c = component.index();
            let sum: f64 = at.iter().map(|&k| truth.errors[k].to_vector()[c]).sum();
            all.push(Deviation {
                name: format!("{} at {}{side}", component.name(&found.name), node.position),
                kind: Kind::Component(component),
                error: error[c] - sum / at.len() as f64,
                u: node.u[c],
                dof: node.dof[c],
            });
        }
    }
    all
}

fn side_of(truth: &TrueComponents, k: usize) -> Direction {
    truth
        .directions
        .as_ref()
        .map_or(Direction::Forward, |sides| sides[k])
}

/// Location errors of all axes: estimate minus truth. Those that are zero by definition of the
/// reference frame are no part of the truth; the calibration must state them as exactly zero.
pub fn locations(calibration: &Calibration, truth: &Truth) -> Vec<Deviation> {
    let mut expected = truth.location_errors.iter().peekable();
    let mut all = Vec::new();
    for axis in &calibration.axes {
        for location in &axis.location_errors {
            let name = location.component.name(&axis.name);
            let Some(truth) = expected.next_if(|truth| truth.name == name) else {
                assert!(
                    location.value.abs() + location.u < f64::MIN_POSITIVE,
                    "{name}: no truth"
                );
                continue;
            };
            all.push(Deviation {
                name,
                kind: Kind::of_location(location.component),
                error: location.value - truth.value,
                u: location.u,
                dof: location.dof,
            });
        }
    }
    assert_eq!(
        expected.next().map(|truth| &truth.name),
        None,
        "not estimated"
    );
    all
}

/// Stations and dead paths: estimate minus truth. What the reflectors' constants have in common is dead path, unless
/// known dead paths tell them apart: lengths are longer by the one and shorter by the other.
pub fn stations(calibration: &Calibration, truth: &Truth) -> Vec<Deviation> {
    let mut all = Vec::new();
    let constants_um: f64 = truth.reflectors.iter().map(|r| r.constant_um).sum();
    let mean_mm = match calibration.reflectors_are_relative {
        true => constants_um * MICROMETRE / truth.reflectors.len().max(1) as f64,
        false => 0.0,
    };
    for (found, truth) in calibration.stations.iter().zip(&truth.stations) {
        let d = found.position_mm - truth.position_mm;
        let dead_path = found.dead_path_mm - (truth.dead_path_mm - mean_mm);
        let u = found.u_mm.into_iter().chain([found.u_dead_path_mm]);
        let dof = found.dof.into_iter().chain([found.dof_dead_path]);
        let what = [
            ("x", d.x, Kind::Station),
            ("y", d.y, Kind::Station),
            ("z", d.z, Kind::Station),
            ("L", dead_path, Kind::DeadPath),
        ];
        for (((what, error, kind), u), dof) in what.into_iter().zip(u).zip(dof) {
            all.push(Deviation {
                name: format!("{what} of {}", found.name),
                kind,
                error,
                u,
                dof,
            });
        }
    }
    all
}
