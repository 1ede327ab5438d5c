//! The machine of a scenario as it truly is, at any position.

use trueaxis_kinematics::{GeometricErrors, LocationError, Machine, MotionError};

use crate::plan::Plan;
use crate::true_errors::TrueAxis;
use crate::{Error, Scenario};

/// The true errors of a machine, in the frame and gauge of the truth: curves everywhere, not at steps alone.
///
/// Lost motion is left out: an axis stands at the mean of both sides of approach.
#[derive(Debug, Clone, PartialEq)]
pub struct TrueMachine {
    machine: Machine,
    axes: Vec<TrueAxis>,
}

impl Scenario {
    /// The machine without noise and effects.
    ///
    /// # Errors
    /// If the scenario is inconsistent; the error names the field.
    pub fn true_machine(&self) -> Result<TrueMachine, Error> {
        let plan = Plan::new(self)?;
        Ok(TrueMachine {
            machine: plan.machine,
            axes: plan.errors,
        })
    }
}

impl TrueMachine {
    /// Its nominal geometry.
    pub fn machine(&self) -> &Machine {
        &self.machine
    }
}

impl GeometricErrors for TrueMachine {
    fn location(&self, axis: usize) -> LocationError {
        self.axes[axis].location
    }

    fn motion(&self, axis: usize, position: f64) -> MotionError {
        self.axes[axis].motion(position)
    }
}
