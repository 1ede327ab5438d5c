//! The noun: a machine with its errors.

use std::collections::BTreeMap;

use trueaxis_effects::GivenEffect;
use trueaxis_kinematics::{
    GeometricErrors, LocationComponent, LocationError, Machine, MotionError,
};

use crate::curve::{Curve, Sample};
use crate::factored_covariance::FactoredCovariance;
use crate::interpolation::Node;
use crate::remainder::Remainder;

/// A machine with its geometric errors as calibrated, and how well they are known.
///
/// It predicts through the exact rigid motions of [`Machine`]. Axes that were not measured have no errors, and their
/// unknown ones are not in any uncertainty ([`CalibratedMachine::unmeasured`]).
#[derive(Debug, Clone, PartialEq)]
pub struct CalibratedMachine {
    /// Name of the machine.
    pub name: String,
    /// Name of the campaign in which it was measured.
    pub campaign: String,
    /// Effects that were taken out of what was measured first.
    pub effects_taken_out: Vec<GivenEffect>,
    /// For each measured axis where the axes of the machine stood meanwhile, mm or rad (0 for its own), none for those that stood at
    /// several places: what they did to it is in its curves. A measured axis that is missing here stands for home.
    pub parked: BTreeMap<usize, Vec<Option<f64>>>,
    /// Whether it is known how well the errors are known: a calibration that another system made may not say. Without it every
    /// standard uncertainty and covariance is NaN.
    pub has_uncertainties: bool,
    /// Least degrees of freedom of any standard uncertainty of the calibration: the factor for an interval is
    /// [`crate::coverage_factor`].
    pub dof: f64,
    /// With the reference points of the component errors.
    pub(crate) machine: Machine,
    /// In the order of the machine.
    pub(crate) axes: Vec<CalibratedAxis>,
    pub(crate) factors: FactoredCovariance,
}

/// The measured errors of an axis.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredAxis {
    /// Index among the machine's axes.
    pub axis: usize,
    /// Where it was measured, in order of position.
    pub nodes: Vec<Node>,
    /// Component errors at each of them.
    pub errors: Vec<MotionError>,
    /// Location errors as a whole.
    pub location: LocationError,
    /// The location errors that the frame does not define away.
    pub reported: Vec<LocationComponent>,
}

/// An axis that predicts.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct CalibratedAxis {
    pub(crate) axis: usize,
    pub(crate) errors: Vec<MotionError>,
    pub(crate) location: LocationError,
    pub(crate) reported: Vec<LocationComponent>,
    /// First and last step.
    pub(crate) range: [f64; 2],
    pub(crate) curve: Curve,
    pub(crate) remainder: Remainder,
    /// Places of its first component and location error among the results.
    pub(crate) first: usize,
    pub(crate) first_location: usize,
}

impl CalibratedMachine {
    /// Of a machine with the reference points of the component errors, and of its measured axes in the order of the
    /// results, whose covariance `factors` is. It has no names, and as many degrees of freedom as it needs.
    pub fn new(machine: Machine, axes: Vec<MeasuredAxis>, factors: FactoredCovariance) -> Self {
        Self {
            name: String::new(),
            campaign: String::new(),
            effects_taken_out: Vec::new(),
            parked: BTreeMap::new(),
            has_uncertainties: true,
            dof: f64::INFINITY,
            axes: calibrated_axes(&machine, axes, &factors),
            machine,
            factors,
        }
    }

    /// Names of the effects that were taken out.
    pub fn names_taken_out(&self) -> Vec<&str> {
        let effects = self.effects_taken_out.iter();
        effects.map(|effect| effect.effect.as_str()).collect()
    }
}

/// The axes, in the order of the results.
fn calibrated_axes(
    machine: &Machine,
    measured: Vec<MeasuredAxis>,
    factors: &FactoredCovariance,
) -> Vec<CalibratedAxis> {
    let mut first = 0;
    let mut first_location: usize = measured.iter().map(|axis| 6 * axis.nodes.len()).sum();
    let of_axis = |axis: MeasuredAxis| {
        let kind = machine.axes()[axis.axis].kind();
        let curve = Curve::new(kind, &axis.nodes);
        let at = |node: Option<&Node>| node.map_or(0.0, |node| node.position);
        let calibrated = CalibratedAxis {
            axis: axis.axis,
            location: axis.location,
            range: [at(axis.nodes.first()), at(axis.nodes.last())],
            remainder: Remainder::new(&curve, &axis.errors, factors, first),
            curve,
            first,
            first_location,
            errors: axis.errors,
            reported: axis.reported,
        };
        first += 6 * calibrated.errors.len();
        first_location += calibrated.reported.len();
        calibrated
    };
    measured.into_iter().map(of_axis).collect()
}

impl CalibratedAxis {
    /// The component errors of a sample of the curve.
    pub(crate) fn error(&self, sample: &Sample) -> MotionError {
        let weights = sample.weights.iter();
        let sum = weights.map(|&(node, weight)| self.errors[node].to_vector() * weight);
        MotionError::from_vector(&sum.sum())
    }
}

impl CalibratedMachine {
    /// The nominal machine, with the reference points that the component errors are given for.
    pub fn machine(&self) -> &Machine {
        &self.machine
    }

    /// Names of axes that were not measured.
    pub fn unmeasured(&self) -> Vec<&str> {
        let axes = self.machine.axes().iter().enumerate();
        let unmeasured = axes.filter(|(i, _)| self.axis(*i).is_none());
        unmeasured.map(|(_, axis)| axis.name()).collect()
    }

    /// The measured errors of an axis of the machine.
    pub(crate) fn axis(&self, index: usize) -> Option<&CalibratedAxis> {
        self.axes.iter().find(|axis| axis.axis == index)
    }
}

impl GeometricErrors for CalibratedMachine {
    fn location(&self, axis: usize) -> LocationError {
        self.axis(axis)
            .map_or_else(LocationError::default, |axis| axis.location)
    }

    fn motion(&self, axis: usize, position: f64) -> MotionError {
        self.axis(axis).map_or_else(MotionError::default, |axis| {
            axis.error(&axis.curve.at(position))
        })
    }
}
