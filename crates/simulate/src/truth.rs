//! What is true of a simulated campaign.

use nalgebra::Point3;
use trueaxis_campaign::Direction;
use trueaxis_effects::GivenEffect;
use trueaxis_kinematics::{AxisKind, LocationComponent, MotionError};

use crate::plan::Plan;
use crate::read_errors::distinct_positions;
use crate::systematic::Systematic;
use crate::{Noise, ReflectorSpec, Scenario};

/// The values that an estimator should find, in the reference frame and gauge of the calibration.
///
/// Stations, targets and errors are those without the effects: a calibration that takes the effects
/// into its model should find them.
///
/// Inside, positions are mm or rad and errors mm or rad; `truth.json` has the units of
/// `calibration.json`.
#[derive(Debug, Clone, PartialEq)]
pub struct Truth {
    /// Name of the campaign.
    pub campaign: String,
    /// Seed of its noise.
    pub seed: u64,
    /// True noise.
    pub noise: Noise,
    /// By how much all lengths are shown too long, µm per m, beside effects.
    pub scale_ppm: f64,
    /// Reflectors as the targets name them. Where dead paths are unknown, lengths determine only the differences of
    /// their constants.
    pub reflectors: Vec<ReflectorSpec>,
    /// Stations in the order of the campaign.
    pub stations: Vec<TrueStation>,
    /// Targets in the order of the campaign.
    pub targets: Vec<TrueTarget>,
    /// Component errors of the axes that have a run, in the order of the machine.
    pub axes: Vec<TrueComponents>,
    /// Location errors of the same axes, zero ones too, without those that are zero by definition
    /// of the reference frame.
    pub location_errors: Vec<TrueLocation>,
    /// What disturbed the readings, as the scenario says it.
    pub effects: Vec<GivenEffect>,
}

/// A station as it stood.
#[derive(Debug, Clone, PartialEq)]
pub struct TrueStation {
    /// Name.
    pub name: String,
    /// Position, mm.
    pub position_mm: Point3<f64>,
    /// Dead path, mm.
    pub dead_path_mm: f64,
}

/// A target as it was mounted.
#[derive(Debug, Clone, PartialEq)]
pub struct TrueTarget {
    /// Name.
    pub name: String,
    /// Home position h in `p = T1(q1) T2(q2) ... h`, mm. The component errors of axes at home are
    /// in the T, so p at home differs from h by the straightness there.
    pub home_mm: Point3<f64>,
}

/// The component errors of one axis.
#[derive(Debug, Clone, PartialEq)]
pub struct TrueComponents {
    /// Name of the axis.
    pub name: String,
    /// Linear or rotary.
    pub kind: AxisKind,
    /// Reference point of δ, mm.
    pub reference_mm: Point3<f64>,
    /// Different commanded positions, mm or rad: those of upward sweeps, increasing, then those
    /// of downward sweeps, increasing.
    pub positions: Vec<f64>,
    /// Side of approach of each position, if the axis sweeps in both directions.
    pub directions: Option<Vec<Direction>>,
    /// Errors at each position, lost motion included.
    pub errors: Vec<MotionError>,
}

/// One location error.
#[derive(Debug, Clone, PartialEq)]
pub struct TrueLocation {
    /// Name, such as `C0Y`.
    pub name: String,
    /// Which it is.
    pub component: LocationComponent,
    /// Value, mm or rad.
    pub value: f64,
}

impl Truth {
    pub(crate) fn new(
        scenario: &Scenario,
        plan: &Plan,
        systematic: &Systematic,
        seed: u64,
    ) -> Self {
        let stations = scenario.stations.iter();
        let targets = plan.targets.iter().zip(&plan.homes_mm);
        let runs = |axis| plan.runs.iter().any(|run| run.axis == axis);
        let measured: Vec<usize> = (0..plan.machine.axes().len())
            .filter(|&i| runs(i))
            .collect();
        Self {
            campaign: scenario.name.clone(),
            seed,
            noise: plan.noise,
            scale_ppm: systematic.scale_ppm,
            reflectors: systematic.reflectors.clone(),
            stations: stations
                .map(|station| TrueStation {
                    name: station.name.clone(),
                    position_mm: Point3::from(station.position_mm),
                    dead_path_mm: station.dead_path_mm,
                })
                .collect(),
            targets: targets
                .map(|(target, &home_mm)| TrueTarget {
                    name: target.name.clone(),
                    home_mm,
                })
                .collect(),
            axes: measured.iter().map(|&i| components(plan, i)).collect(),
            location_errors: measured.iter().flat_map(|&i| locations(plan, i)).collect(),
            effects: scenario.effects.clone(),
        }
    }
}

fn components(plan: &Plan, index: usize) -> TrueComponents {
    let axis = &plan.machine.axes()[index];
    let truth = &plan.errors[index];
    let (mut positions, mut directions, mut errors) = (Vec::new(), Vec::new(), Vec::new());
    for direction in [Direction::Forward, Direction::Backward] {
        let own = plan.runs.iter().filter(|run| run.axis == index);
        let swept = distinct_positions(own.filter(|run| run.directions.contains(&direction)));
        directions.extend(swept.iter().map(|_| direction));
        errors.extend(swept.iter().map(|&q| truth.motion_after(q, direction)));
        positions.extend(swept);
    }
    let one_sided = directions.iter().all(|d| Some(d) == directions.first());
    TrueComponents {
        name: axis.name().to_owned(),
        kind: axis.kind(),
        reference_mm: axis.reference_mm(),
        positions,
        directions: (!one_sided).then_some(directions),
        errors,
    }
}

fn locations(plan: &Plan, index: usize) -> Vec<TrueLocation> {
    let axis = &plan.machine.axes()[index];
    let free = axis.location_components().into_iter();
    free.filter(|&component| !plan.frame.defines(&plan.machine, index, component))
        .map(|component| TrueLocation {
            name: component.name(axis.name()),
            component,
            value: component.of(&plan.errors[index].location),
        })
        .collect()
}
