//! The result: every geometric error of the machine, with uncertainty and evidence.

use nalgebra::{Point3, Vector3};
use trueaxis_campaign::{Direction, InputFile, MachineSpec};
use trueaxis_effects::GivenEffect;
use trueaxis_kinematics::{
    AxisKind, Component, LocationComponent, LocationError, Machine, MotionError,
};
use trueaxis_poses::{
    AdjustmentReport, KnownMisfit, Method, ReflectorConstant, Residual, ScaleResult,
    SideDifference, StepMisfit, TurnedRuns,
};

use crate::result::budget::Budget;
use trueaxis_predict::{FactoredCovariance, OutputCovariance};

/// All geometric errors of a machine in its reference frame, with standard uncertainties (k = 1).
///
/// Lengths are mm, angles rad. `calibration.json` has them in µm, arcsec and degrees ([`Calibration::to_json`]).
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
    /// Constants of the reflectors; empty for a points campaign, and where there is one reflector only and no dead path is known.
    pub reflectors: Vec<ReflectorConstant>,
    /// Whether they are relative to their mean: no dead path is known, which would tell that.
    pub reflectors_are_relative: bool,
    /// The scale of all lengths, where it is an unknown: results are free of it, and U contains its uncertainty.
    pub scale: Option<ScaleResult>,
    /// What the uncertainties contain, and what not.
    pub uncertainty: UncertaintyStatement,
    /// Adjusted home positions of the targets, mean over the runs.
    pub targets: Vec<TargetResult>,
    /// Axes that were measured, in the order of the machine.
    pub axes: Vec<AxisResult>,
    /// Where rotary axes lie relative to each other, whatever the nests of the targets are.
    pub relative_locations: Vec<RelativeLocation>,
    /// Covariance of all these results, in factors.
    pub factors: FactoredCovariance,
    /// The same as one matrix, if it was asked for.
    pub covariance: Option<OutputCovariance>,
    /// Steps whose points do not move as a rigid body.
    pub misfits: Vec<StepMisfit>,
    /// Runs of measured points that see the stage turned against each other where all axes stand alike.
    pub turned_runs: Vec<TurnedRuns>,
    /// Known lengths and dead paths that contradict the lengths.
    pub known_misfits: Vec<KnownMisfit>,
    /// What is left of each length, or of each coordinate of a points campaign, in measuring order.
    pub residuals: Vec<Residual>,
    /// Distances between targets that differ from nominal.
    pub triangle: Vec<TriangleSide>,
    /// Effects that were taken out of the lengths, with the uncertainties that entered.
    pub effects: Vec<GivenEffect>,
    /// What a user must know before using the numbers.
    pub notices: Vec<String>,
    /// What the results rest on.
    pub traceability: Traceability,
}

/// By whom, when, with what: what a certificate says beside its numbers.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Traceability {
    /// Day of the measurement as `YYYY-MM-DD`, if the campaign gives it.
    pub date: Option<String>,
    /// Who measured, if the campaign gives it.
    pub operator: Option<String>,
    /// Name of the instrument; empty if the campaign gives none.
    pub instrument: String,
    /// Its serial number, if the campaign gives it.
    pub serial: Option<String>,
    /// The files of the campaign with their checksums ([`trueaxis_campaign::checksums`]); empty if whoever calibrated it had no files.
    pub inputs: Vec<InputFile>,
}

/// What the uncertainties of a calibration contain, and what they lack, as phrases.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct UncertaintyStatement {
    /// Parts that U contains.
    pub contains: Vec<String>,
    /// Parts that it does not contain, with the reason.
    pub lacks: Vec<String>,
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
    /// Where each axis of the machine stood meanwhile, mm or rad; 0 for this one, none for one that stood at several places.
    pub parked: Vec<Option<f64>>,
    /// Component errors at each position.
    pub nodes: Vec<NodeResult>,
    /// Location errors as a whole, for prediction.
    pub location: LocationError,
    /// Location errors that the reference frame leaves, with uncertainty.
    pub location_errors: Vec<LocationResult>,
    /// Mean over the steps of the standard deviation of each component for independent unit noise of the points, by the equations used and
    /// by all nine without weights: mm and rad per mm. `None` for the joint adjustment, which has no points.
    pub noise_gain: Option<[[f64; 6]; 2]>,
    /// What other methods would lose on the same lengths; `None` where the joint adjustment was not used or the others cannot be.
    pub u_ratio: Option<MethodLoss>,
    /// How the two sides of approach differ, where they share a curve and differ significantly.
    pub sides: Option<SideDifference>,
    /// How the runs contradict each other of which the curves are the mean, if they do: the uncertainties of its
    /// components then are what the noise makes them, times [`RunMisfit::birge_ratio`], and those of all location errors
    /// contain how the average lines or axes of the runs differ.
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
    /// The component error, and the position (mm or rad) where the runs differ most by their noise; and by how much, mm or rad.
    pub component: Component,
    /// See [`RunMisfit::component`].
    pub position: f64,
    /// See [`RunMisfit::component`].
    pub difference: f64,
}

impl RunMisfit {
    /// By how much the runs differ in units of their noise, `√(χ²/ν)` (R. T. Birge, Phys. Rev. 40, 207, 1932); not below one.
    pub fn birge_ratio(&self) -> f64 {
        let ratio = (self.chi_squared / self.degrees_of_freedom as f64).sqrt();
        ratio.max(1.0)
    }
}

/// By what runs that contradict each other widen the component errors of an axis.
pub(crate) fn widening_of_components(axis: &AxisResult) -> f64 {
    axis.runs.as_ref().map_or(1.0, RunMisfit::birge_ratio)
}

/// Standard uncertainty of each component error by other methods, relative to that of the joint adjustment (rms over the positions).
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
    /// interval is [`trueaxis_predict::coverage_factor`].
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
    /// Whether it is relative to where the nests of the targets are: it is as uncertain as these were set, which u
    /// contains as far as `position_sigma_mm` of the targets declares it.
    pub relative_to_targets: bool,
}

/// Where a rotary axis lies relative to another one: how far the two are apart, and which angle they have, beyond
/// nominal. Neither depends on the reference frame or on how the nests of the targets were set.
#[derive(Debug, Clone, PartialEq)]
pub struct RelativeLocation {
    /// Name of the axis.
    pub axis: String,
    /// Name of the axis that it is relative to.
    pub to: String,
    /// Unit vector across both, along which the offset is and about which the angle is positive by the right-hand
    /// rule. Parallel axes have two such entries.
    pub direction: Vector3<f64>,
    /// From the reference point of the axis, and of the other one, to where they are nearest to each other, mm.
    pub levers_mm: [Vector3<f64>; 2],
    /// Offset along the direction, mm.
    pub offset: RelativeQuantity,
    /// Angle about the direction, rad.
    pub angle: RelativeQuantity,
}

impl RelativeLocation {
    /// Offset (mm) and angle (rad) of location errors of the axis and of the other one; linear in both.
    pub(crate) fn of(&self, axis: &LocationError, to: &LocationError) -> [f64; 2] {
        let n = &self.direction;
        let place = |location: &LocationError, lever_mm: &Vector3<f64>| {
            n.dot(&(location.offset_mm + location.tilt_rad.cross(lever_mm)))
        };
        let [own, other] = &self.levers_mm;
        [
            place(axis, own) - place(to, other),
            n.dot(&(axis.tilt_rad - to.tilt_rad)),
        ]
    }
}

/// A number of a [`RelativeLocation`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RelativeQuantity {
    /// Actual minus nominal, mm or rad.
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
