//! Whether two descriptions are of one machine.

use trueaxis_kinematics::{Branch, Machine};

/// The calibration of another machine.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "this is the calibration of another machine: its axes are {calibrated}, expected {measured}; names, kinds, \
     directions and order from the bed must be the same"
)]
pub struct OtherMachine {
    /// Names of the axes of the calibration.
    pub calibrated: String,
    /// Names of the axes of the other calibration, or of the campaign.
    pub measured: String,
}

/// Unit vectors this close are one.
const SAME_DIRECTION: f64 = 1e-9;

/// Names, kinds, directions and order of the axes must be the same, and the branches.
///
/// # Errors
/// [`OtherMachine`] with the names of both.
pub fn check_same_machine(calibrated: &Machine, measured: &Machine) -> Result<(), OtherMachine> {
    let is_same = calibrated.axes().len() == measured.axes().len()
        && calibrated.axes().iter().zip(measured.axes()).all(|(a, b)| {
            let off = a.direction().into_inner() - b.direction().into_inner();
            a.name() == b.name() && a.kind() == b.kind() && off.norm() < SAME_DIRECTION
        })
        && [Branch::Tool, Branch::Workpiece]
            .into_iter()
            .all(|branch| calibrated.branch(branch) == measured.branch(branch));
    let names = |machine: &Machine| {
        let names: Vec<&str> = machine.axes().iter().map(|axis| axis.name()).collect();
        names.join(" ")
    };
    if is_same {
        return Ok(());
    }
    Err(OtherMachine {
        calibrated: names(calibrated),
        measured: names(measured),
    })
}
