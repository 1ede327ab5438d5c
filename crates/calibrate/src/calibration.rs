//! The result: every geometric error of the machine, with uncertainty and evidence.

use nalgebra::Point3;
use trueaxis_campaign::Direction;
use trueaxis_kinematics::{
    AxisKind, GeometricErrors, LocationComponent, LocationError, MotionError,
};

use crate::settings::Method;

/// All geometric errors of a machine in its reference frame, with standard uncertainties (k = 1).
///
/// Lengths are mm, angles rad. `calibration.json` has them in µm, arcsec and degrees
/// ([`Calibration::to_json`]).
#[derive(Debug, Clone)]
pub struct Calibration {
    /// Name of the campaign.
    pub campaign: String,
    /// How component errors were identified.
    pub method: Method,
    /// What the measurement says about itself.
    pub adjustment: AdjustmentReport,
    /// Stations of the tracker; empty for a points campaign.
    pub stations: Vec<StationResult>,
    /// Adjusted home positions of the targets, mean over the runs.
    pub targets: Vec<TargetResult>,
    /// Axes that were measured, in the order of the machine.
    pub axes: Vec<AxisResult>,
    /// Steps whose points do not move as a rigid body.
    pub misfits: Vec<StepMisfit>,
    /// Distances between targets that differ from nominal.
    pub triangle: Vec<TriangleSide>,
    /// What a user must know before using the numbers.
    pub notices: Vec<String>,
}

/// What the measurement says about itself.
#[derive(Debug, Clone, PartialEq)]
pub struct AdjustmentReport {
    /// Lengths, or coordinates of a points campaign.
    pub observations: usize,
    /// Unknowns that they determine.
    pub unknowns: usize,
    /// Redundancy.
    pub degrees_of_freedom: usize,
    /// Standard deviation of unit weight: 1 if the noise is as declared.
    pub sigma0: f64,
    /// Probability of residuals at least as large if the noise is as declared.
    pub p_value: f64,
    /// Whether the noise was declared.
    pub noise_declared: bool,
    /// Factor on all standard uncertainties: 1 if the declared noise explains the residuals.
    pub uncertainty_factor: f64,
    /// Rms of the residuals, mm.
    pub rms_residual_mm: f64,
    /// Standard deviation of a length at zero distance that the weights used, mm; `None` for a
    /// points campaign.
    pub length_sigma_mm: Option<f64>,
    /// Standard deviation per coordinate of the machine's return that the weights used, mm.
    pub repeatability_mm: f64,
    /// Iterations of the adjustment.
    pub iterations: usize,
    /// Why it stopped.
    pub termination: String,
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
    /// Dead path, mm.
    pub dead_path_mm: f64,
    /// Its standard uncertainty, mm.
    pub u_dead_path_mm: f64,
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
    /// of the points, by the method used: mm and rad per mm.
    pub noise_gain: [f64; 6],
    /// The same for the nine equations without weights.
    pub noise_gain_nine: [f64; 6],
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
}

/// A step whose points do not move as a rigid body.
#[derive(Debug, Clone, PartialEq)]
pub struct StepMisfit {
    /// The step in words.
    pub step: String,
    /// Rms of what a rigid motion leaves, µm.
    pub rms_um: f64,
    /// `vᵀ C⁻¹ v`.
    pub chi_squared: f64,
    /// Its degrees of freedom.
    pub degrees_of_freedom: usize,
    /// Probability of one as large if the targets are rigid.
    pub p_value: f64,
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

    /// Component errors at any position: linear between the measured ones; the mean of the sides
    /// of approach that reach the position; the nearest one if none does.
    pub fn error_at(&self, position: f64) -> MotionError {
        let sides = [None, Some(Direction::Backward), Some(Direction::Forward)];
        let reached: Vec<MotionError> = sides
            .iter()
            .filter_map(|&side| self.between_nodes(side, position))
            .collect();
        match reached.as_slice() {
            [one] => *one,
            [backward, forward] => backward.interpolate(forward, 0.5),
            _ => {
                let distance = |node: &&NodeResult| (node.position - position).abs();
                let nearest = self
                    .nodes
                    .iter()
                    .min_by(|a, b| distance(a).total_cmp(&distance(b)));
                nearest.map_or_else(MotionError::default, |node| node.error)
            }
        }
    }

    /// Interpolation on one side of approach; `None` outside its range.
    fn between_nodes(&self, side: Option<Direction>, position: f64) -> Option<MotionError> {
        let nodes = || self.nodes.iter().filter(|node| node.direction == side);
        let low = nodes().rfind(|node| node.position <= position)?;
        let high = nodes().find(|node| node.position >= position)?;
        let span = high.position - low.position;
        let weight = if span > 0.0 {
            (position - low.position) / span
        } else {
            0.0
        };
        Some(low.error.interpolate(&high.error, weight))
    }
}

/// A calibrated machine predicts with its errors; axes that were not measured have none.
impl GeometricErrors for Calibration {
    fn location(&self, axis: usize) -> LocationError {
        let result = self.axes.iter().find(|result| result.axis == axis);
        result.map_or_else(LocationError::default, |result| result.location)
    }

    fn motion(&self, axis: usize, position: f64) -> MotionError {
        let result = self.axes.iter().find(|result| result.axis == axis);
        result.map_or_else(MotionError::default, |result| result.error_at(position))
    }
}
