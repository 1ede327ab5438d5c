//! The result: every geometric error of the machine with its uncertainty, and what the measurement says about itself.

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
    /// The nominal machine in the form of files.
    pub machine_spec: MachineSpec,
    /// How component errors were identified.
    pub method: Method,
    /// What the measurement says about itself.
    pub adjustment: AdjustmentReport,
    /// Stations of the tracker; empty for a points campaign.
    pub stations: Vec<StationResult>,
    /// Constants of the reflectors; empty for points, and for a single reflector without a known dead path.
    pub reflectors: Vec<ReflectorConstant>,
    /// Whether the constants are relative to their mean, because no dead path is known.
    pub reflectors_are_relative: bool,
    /// The scale of all lengths, where it is an unknown: results are free of it, and U contains its uncertainty.
    pub scale: Option<ScaleResult>,
    /// What the uncertainties contain, and what they lack.
    pub uncertainty: UncertaintyStatement,
    /// Adjusted home positions of the targets, mean over the runs.
    pub targets: Vec<TargetResult>,
    /// Axes that were measured, in the order of the machine.
    pub axes: Vec<AxisResult>,
    /// Locations of rotary axes relative to each other, independent of the nests of the targets.
    pub relative_locations: Vec<RelativeLocation>,
    /// Covariance of all these results, in factors.
    pub factors: FactoredCovariance,
    /// The covariance as one matrix, if the settings ask for it.
    pub covariance: Option<OutputCovariance>,
    /// Steps whose points do not move as a rigid body.
    pub misfits: Vec<StepMisfit>,
    /// Runs of measured points between which the stage is turned at equal axis positions.
    pub turned_runs: Vec<TurnedRuns>,
    /// Known lengths and dead paths that contradict the lengths.
    pub known_misfits: Vec<KnownMisfit>,
    /// The residuals of all lengths, or of all coordinates of a points campaign, in measuring order.
    pub residuals: Vec<Residual>,
    /// Distances between targets that differ from nominal.
    pub triangle: Vec<TriangleSide>,
    /// Effects that were removed from the lengths, with the uncertainties that were used.
    pub effects: Vec<GivenEffect>,
    /// What a user must know before using the numbers.
    pub notices: Vec<String>,
    /// Who, when and with what: the origin of the results.
    pub traceability: Traceability,
}

/// Who, when and with what: the statements of a certificate beside its numbers.
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
    /// The campaign's files with checksums ([`trueaxis_campaign::checksums`]); empty if it came from no files.
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
    /// Position of each axis meanwhile, mm or rad; 0 for this axis, `None` for one that stood at several positions.
    pub parked: Vec<Option<f64>>,
    /// Component errors at each position.
    pub nodes: Vec<NodeResult>,
    /// Location errors as a whole, for prediction.
    pub location: LocationError,
    /// Location errors that the reference frame leaves, with uncertainty.
    pub location_errors: Vec<LocationResult>,
    /// Mean over the steps of the standard deviation of each component for unit noise of the points, by the equations
    /// used and by all nine without weights: mm and rad per mm. `None` for the joint adjustment, which has no points.
    pub noise_gain: Option<[[f64; 6]; 2]>,
    /// The loss by other methods on the same lengths; `None` if the joint adjustment was not used or others fail.
    pub u_ratio: Option<MethodLoss>,
    /// The difference between sides of approach that share a curve, if it is significant.
    pub sides: Option<SideDifference>,
    /// The contradiction of the runs of which the curves are the mean, if there is one: the uncertainties of the
    /// components are then those of the noise times [`RunMisfit::birge_ratio`], and those of all location errors
    /// contain the differences of the average lines or axes of the runs.
    pub runs: Option<RunMisfit>,
}

/// Runs of one axis that contradict each other beyond their noise.
#[derive(Debug, Clone, PartialEq)]
pub struct RunMisfit {
    /// Names of the runs.
    pub runs: Vec<String>,
    /// Rms distance of the reference point in a run from its mean position, mm.
    pub rms_mm: f64,
    /// Weighted sum of squares of the differences.
    pub chi_squared: f64,
    /// Its degrees of freedom.
    pub degrees_of_freedom: usize,
    /// Probability of a sum as large if the runs agree.
    pub p_value: f64,
    /// The component error that differs most, relative to its noise.
    pub component: Component,
    /// Where it does, mm or rad.
    pub position: f64,
    /// The largest difference between runs there, mm or rad.
    pub difference: f64,
}

impl RunMisfit {
    /// Ratio of the differences to their noise, `√(χ²/ν)` (R. T. Birge, Phys. Rev. 40, 207, 1932), at least one.
    pub fn birge_ratio(&self) -> f64 {
        let ratio = (self.chi_squared / self.degrees_of_freedom as f64).sqrt();
        ratio.max(1.0)
    }
}

/// The factor by which contradictory runs widen the component errors of an axis.
pub(crate) fn widening_of_components(axis: &AxisResult) -> f64 {
    axis.runs.as_ref().map_or(1.0, RunMisfit::birge_ratio)
}

/// Standard uncertainty of each component error by other methods, relative to that of the joint adjustment (rms over the positions).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MethodLoss {
    /// Points first, then nine equations.
    pub nine: [f64; 6],
    /// Points first, then the paper's six equations; `None` where six do not determine the components.
    pub six: Option<[f64; 6]>,
}

/// Component errors at one position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NodeResult {
    /// Commanded position, mm or rad.
    pub position: f64,
    /// Side of approach, if the sides are kept apart.
    pub direction: Option<Direction>,
    /// δ and ε in the least-squares gauge.
    pub error: MotionError,
    /// Standard uncertainties in the order of [`trueaxis_kinematics::Component::ALL`], mm and rad.
    pub u: [f64; 6],
    /// Their degrees of freedom; infinite where the noise counts as known. The factor for an interval is
    /// [`trueaxis_predict::coverage_factor`].
    pub dof: [f64; 6],
    /// The parts of their squares.
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
    /// The parts of its square.
    pub budget: Budget,
    /// Whether it is relative to the positions of the targets' nests: it is as uncertain as these, which u contains
    /// as far as `position_sigma_mm` of the targets declares it.
    pub relative_to_targets: bool,
}

/// Location of a rotary axis relative to another: distance and angle of the two, less nominal. Neither depends on the
/// reference frame or on how the nests of the targets were set.
#[derive(Debug, Clone, PartialEq)]
pub struct RelativeLocation {
    /// Name of the axis.
    pub axis: String,
    /// Name of the axis to which it is relative.
    pub to: String,
    /// Unit vector across both: direction of the offset, and of the axis of the angle, positive by the right-hand
    /// rule. Parallel axes have two such entries.
    pub direction: Vector3<f64>,
    /// From the reference points of the axis and of the other one to where they are nearest to each other, mm.
    pub levers_mm: [Vector3<f64>; 2],
    /// Offset along the direction, mm.
    pub offset: RelativeQuantity,
    /// Angle about the direction, rad.
    pub angle: RelativeQuantity,
}

impl RelativeLocation {
    /// Offset (mm) and angle (rad) by location errors of the axis and of the other one; linear in both.
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
    /// The parts of its square.
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
    /// The result of the axis with this name.
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
