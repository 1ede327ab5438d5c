//! The true errors of the simulated machine.

use trueaxis_campaign::Direction;
use trueaxis_kinematics::{ARCSEC, Axis, AxisKind, Component, GeometricErrors};
use trueaxis_kinematics::{LocationError, MICROMETRE, MotionError};

use crate::Term;
use crate::gauge::GaugePart;

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct TrueAxis {
    pub(crate) kind: AxisKind,
    /// Travel in mm or deg, over which polynomials run.
    pub(crate) travel: [f64; 2],
    pub(crate) location: LocationError,
    /// Curves in the order of [`Component::ALL`].
    pub(crate) curves: [Curve; 6],
    pub(crate) gauge: GaugePart,
    /// Error after arrival in negative direction; in positive direction it is the opposite.
    pub(crate) half_lost_motion: MotionError,
}

/// One component error as a function of the position.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Curve {
    pub(crate) terms: Vec<Term>,
    /// From the unit of the terms (µm or arcsec) to mm or rad.
    pub(crate) unit: f64,
}

/// The unit in which files give a component error, µm or arcsec, in mm or rad.
pub(crate) fn unit_of(component: Component) -> f64 {
    match component.is_angular() {
        true => ARCSEC,
        false => MICROMETRE,
    }
}

impl TrueAxis {
    pub(crate) fn faultless(axis: &Axis) -> Self {
        Self {
            kind: axis.kind(),
            travel: axis.travel().map(|q| axis.kind().position_in_file(q)),
            location: LocationError::default(),
            curves: Default::default(),
            gauge: GaugePart::none(axis),
            half_lost_motion: MotionError::default(),
        }
    }

    /// The curves as the scenario gives them, at `position` (mm or rad).
    pub(crate) fn as_given(&self, position: f64) -> MotionError {
        let q = self.kind.position_in_file(position);
        let values = self.curves.each_ref().map(|curve| {
            let terms = curve.terms.iter();
            curve.unit * terms.map(|term| term.value(q, self.travel)).sum::<f64>()
        });
        MotionError::from_vector(&values.into())
    }

    /// The curves in the gauge: the mean of both directions of approach.
    pub(crate) fn motion(&self, position: f64) -> MotionError {
        let given = self.as_given(position).to_vector();
        MotionError::from_vector(&(given - self.gauge.at(position).to_vector()))
    }

    pub(crate) fn motion_after(&self, position: f64, direction: Direction) -> MotionError {
        let mean = self.motion(position).to_vector();
        let sign = f64::from(direction.sign());
        MotionError::from_vector(&(mean - self.half_lost_motion.to_vector() * sign))
    }
}

/// The machine's errors while one axis sweeps and the others are parked.
///
/// Parked axes stand at the mean of both directions of approach.
pub(crate) struct Sweeping<'a> {
    pub(crate) axes: &'a [TrueAxis],
    pub(crate) axis: usize,
    pub(crate) direction: Direction,
}

impl GeometricErrors for Sweeping<'_> {
    fn location(&self, axis: usize) -> LocationError {
        self.axes[axis].location
    }

    fn motion(&self, axis: usize, position: f64) -> MotionError {
        if axis == self.axis {
            self.axes[axis].motion_after(position, self.direction)
        } else {
            self.axes[axis].motion(position)
        }
    }
}
