//! The result: every geometric error of the machine, with uncertainty and evidence.

use nalgebra::Point3;
use trueaxis_campaign::{Direction, MachineSpec};
use trueaxis_effects::GivenEffect;
use trueaxis_kinematics::{
    AxisKind, Component, LocationComponent, LocationError, Machine, MotionError,
};
use trueaxis_poses::{AdjustmentReport, Method, ReflectorConstant, SideDifference, StepMisfit};

use crate::result::budget::Budget;
use crate::result::factored_covariance::FactoredCovariance;
use crate::result::interpolation::Place;
use crate::result::output::OutputCovariance;

/// All geometric errors of a machine in its reference frame, with standard uncertainties (k = 1).
///
/// Lengths are mm, angles rad. `calibration.json` has them in µm, arcsec and degrees
/// ([`Calibration::to_json`]).
#[derive(Debug, Clone)]
pub struct Calibration {
    /// Name of the campaign.
    pub campaign: String,
    /// The nominal machine, as in the campaign.
    pub machine: Machine,
    /// The same as files have it.
    pub machine_spec: MachineSpec,
    /// How component errors were identified.
    pub method: Method,
    /// What the measurement says about itself.
    pub adjustment: AdjustmentReport,
    /// Stations of the tracker; empty for a points campaign.
    pub stations: Vec<StationResult>,
    /// Constants of the reflectors, relative to their mean; empty where there is one reflector only, and for a
    /// points campaign.
    pub reflectors: Vec<ReflectorConstant>,
    /// Adjusted home positions of the targets, mean over the runs.
    pub targets: Vec<TargetResult>,
    /// Axes that were measured, in the order of the machine.
    pub axes: Vec<AxisResult>,
    /// Covariance of all these results, in factors.
    pub factors: FactoredCovariance,
    /// The same as one matrix, if it was asked for.
    pub covariance: Option<OutputCovariance>,
    /// Steps whose points do not move as a rigid body.
    pub misfits: Vec<StepMisfit>,
    /// Distances between targets that differ from nominal.
    pub triangle: Vec<TriangleSide>,
    /// Effects that were taken out of the lengths, with the uncertainties that entered.
    pub effects: Vec<GivenEffect>,
    /// What a user must know before using the numbers.
    pub notices: Vec<String>,
}

/// A station in the reference frame.
#[derive(Debug, Clone, PartialEq)]
pub struct StationResult {
    /// Name.
    pub name: String,
    /// Position, mm.
    pub position_mm: Point3<f64>,
    /// Standard uncertainties of its coordinates, mm.
    pub u_mm: [f64; 3],
    /// Their degrees of freedom; infinite where the noise is taken as known.
    pub dof: [f64; 3],
    /// Dead path, mm.
    pub dead_path_mm: f64,
    /// Its standard uncertainty, mm.
    pub u_dead_path_mm: f64,
    /// Its degrees of freedom.
    pub dof_dead_path: f64,
}

/// A target at home in the reference frame.
#[derive(Debug, Clone, PartialEq)]
pub struct TargetResult {
    /// Name.
    pub name: String,
    /// Position, mm.
    pub position_mm: Point3<f64>,
}

/// The errors of one axis.
#[derive(Debug, Clone, PartialEq)]
pub struct AxisResult {
    /// Name.
    pub name: String,
    /// Index among the machine's axes.
    pub axis: usize,
    /// Linear or rotary.
    pub kind: AxisKind,
    /// Reference point of δ at home, mm.
    pub reference_point_mm: Point3<f64>,
    /// Component errors at each position.
    pub nodes: Vec<NodeResult>,
    /// Location errors as a whole, for prediction.
    pub location: LocationError,
    /// Location errors that the reference frame leaves, with uncertainty.
    pub location_errors: Vec<LocationResult>,
    /// Mean over the steps of the standard deviation of each component for independent unit noise
    /// of the points, by the equations used and by all nine without weights: mm and rad per mm. `None` for the
    /// joint adjustment, which has no points.
    pub noise_gain: Option<[[f64; 6]; 2]>,
    /// What other methods would lose on the same lengths; `None` where the joint adjustment was not used or the
    /// others cannot be.
    pub u_ratio: Option<MethodLoss>,
    /// How the two sides of approach differ, where they share a curve and differ significantly.
    pub sides: Option<SideDifference>,
    /// How the runs contradict each other of which the curves are the mean, if they do: the uncertainties of
    /// its components, and of the location errors of all axes, then are what the noise makes them, times
    /// [`RunMisfit::birge_ratio`].
    pub runs: Option<RunMisfit>,
}

/// Runs of one axis that contradict each other beyond their noise.
#[derive(Debug, Clone, PartialEq)]
pub struct RunMisfit {
    /// Names of the runs.
    pub runs: Vec<String>,
    /// Rms distance of the reference point in a run from where it is in the mean, mm.
    pub rms_mm: f64,
    /// Sum of squares of what they differ by, with the covariance of that.
    pub chi_squared: f64,
    /// Its degrees of freedom.
    pub degrees_of_freedom: usize,
    /// Probability of such a sum if the runs agree.
    pub p_value: f64,
    /// The component error, and the position (mm or rad) where the runs differ most by their noise; and by how
    /// much, mm or rad.
    pub component: Component,
    /// See [`RunMisfit::component`].
    pub position: f64,
    /// See [`RunMisfit::component`].
    pub difference: f64,
}

impl RunMisfit {
    /// By how much the runs differ in units of their noise, `√(χ²/ν)`; not below one.
    pub fn birge_ratio(&self) -> f64 {
        let ratio = (self.chi_squared / self.degrees_of_freedom as f64).sqrt();
        ratio.max(1.0)
    }
}

/// By what runs that contradict each other widen the component errors of an axis.
pub(crate) fn widening_of_components(axis: &AxisResult) -> f64 {
    axis.runs.as_ref().map_or(1.0, RunMisfit::birge_ratio)
}

/// By what they widen location errors: those of every axis, since the lines of some make the frame of all.
pub(crate) fn widening_of_locations(axes: &[AxisResult]) -> f64 {
    axes.iter().map(widening_of_components).fold(1.0, f64::max)
}

/// Standard uncertainty of each component error by other methods, relative to that of the joint adjustment
/// (rms over the positions).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MethodLoss {
    /// Points first, then nine equations.
    pub nine: [f64; 6],
    /// Points first, then the paper's six equations; `None` where these do not determine the components.
    pub six: Option<[f64; 6]>,
}

/// Component errors at one position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NodeResult {
    /// Commanded position, mm or rad.
    pub position: f64,
    /// Side of approach, where the two are kept apart.
    pub direction: Option<Direction>,
    /// δ and ε in the least-squares gauge.
    pub error: MotionError,
    /// Standard uncertainties in the order of [`trueaxis_kinematics::Component::ALL`], mm and rad.
    pub u: [f64; 6],
    /// Their degrees of freedom; infinite where the noise is taken as known. The factor for an
    /// interval is [`crate::coverage_factor`].
    pub dof: [f64; 6],
    /// Where their squares come from.
    pub budget: [Budget; 6],
}

/// One location error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LocationResult {
    /// Which one.
    pub component: LocationComponent,
    /// Value, mm or rad.
    pub value: f64,
    /// Standard uncertainty, mm or rad.
    pub u: f64,
    /// Its degrees of freedom; infinite where the noise is taken as known.
    pub dof: f64,
    /// Where its square comes from.
    pub budget: Budget,
}

/// A distance between two targets, measured against nominal.
#[derive(Debug, Clone, PartialEq)]
pub struct TriangleSide {
    /// Names of the two targets.
    pub targets: [String; 2],
    /// Distance of the nominal positions, mm.
    pub nominal_mm: f64,
    /// Measured distance, mm.
    pub measured_mm: f64,
}

impl Calibration {
    /// The result of the axis of that name.
    pub fn axis(&self, name: &str) -> Option<&AxisResult> {
        self.axes.iter().find(|axis| axis.name == name)
    }
}

impl AxisResult {
    /// Value and standard uncertainty of a location error by its ISO name, mm or rad.
    pub fn location_error(&self, name: &str) -> Option<&LocationResult> {
        self.location_errors
            .iter()
            .find(|l| l.component.name(&self.name) == name)
    }
}

impl Place for NodeResult {
    fn position(&self) -> f64 {
        self.position
    }

    fn direction(&self) -> Option<Direction> {
        self.direction
    }
}
