//! Whether two descriptions are of one machine.

use trueaxis_kinematics::{Axis, Branch, Machine};

/// The calibration of another machine.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("this is the calibration of another machine: {difference}")]
pub struct OtherMachine {
    /// The first thing in which they differ: what the calibration has, and what was expected.
    pub difference: String,
}

/// Unit vectors this close are one.
const SAME_DIRECTION: f64 = 1e-9;

/// Names, kinds, directions and order of the axes must be the same, and the branches.
///
/// # Errors
/// [`OtherMachine`] with what differs first.
pub fn check_same_machine(calibrated: &Machine, measured: &Machine) -> Result<(), OtherMachine> {
    let axes = calibrated.axes().iter().zip(measured.axes());
    let differing = differ("its axes are", [calibrated, measured].map(names))
        .or_else(|| axes.into_iter().find_map(|(a, b)| axes_differ(a, b)))
        .or_else(|| {
            let chains = [calibrated, measured].map(|machine| {
                let [tool, workpiece] = [Branch::Tool, Branch::Workpiece].map(|branch| {
                    let axes = machine.branch(branch).iter();
                    let own: Vec<&str> = axes.map(|&axis| machine.axes()[axis].name()).collect();
                    own.join(" ")
                });
                format!("tool [{tool}] workpiece [{workpiece}]")
            });
            differ("from the bed outwards it has", chains)
        });
    match differing {
        Some(difference) => Err(OtherMachine { difference }),
        None => Ok(()),
    }
}

fn axes_differ(calibrated: &Axis, measured: &Axis) -> Option<String> {
    let name = calibrated.name();
    let kinds = [calibrated, measured].map(|axis| axis.kind().name().to_owned());
    let directions = [calibrated, measured].map(|axis| axis.direction().into_inner());
    let is_along = (directions[0] - directions[1]).norm() < SAME_DIRECTION;
    differ(&format!("its axis {name} is"), kinds).or_else(|| {
        let told = directions.map(|d| format!("[{}, {}, {}]", d.x, d.y, d.z));
        (!is_along)
            .then(|| differ(&format!("the direction of its axis {name} is"), told))
            .flatten()
    })
}

fn names(machine: &Machine) -> String {
    let names: Vec<&str> = machine.axes().iter().map(|axis| axis.name()).collect();
    names.join(" ")
}

fn differ(what: &str, [calibrated, measured]: [String; 2]) -> Option<String> {
    (calibrated != measured).then(|| format!("{what} {calibrated}, expected {measured}"))
}
