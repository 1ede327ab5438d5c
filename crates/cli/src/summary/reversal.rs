//! What a calibration that keeps the sides of approach apart says of the lost motion of its axes.

use trueaxis_calibrate::{AxisResult, Calibration, NodeResult};
use trueaxis_files::round;
use trueaxis_kinematics::AxisKind;
use trueaxis_predict::CalibratedMachine;

use crate::summary::unit;

const HEAD: &str = "reversal values         forward less backward, mean and largest";

/// The reversal values of ISO 230-2, forward less backward, at the reference point; nothing where the sides are together.
pub(super) fn reversal_values(calibration: &Calibration) -> Vec<String> {
    let mut nodes = calibration.axes.iter().flat_map(|axis| &axis.nodes);
    if nodes.all(|node| node.direction.is_none()) {
        return Vec::new();
    }
    let machine = calibration.calibrated_machine();
    let axes = calibration.axes.iter();
    let mut lines: Vec<String> = axes.filter_map(|axis| of_axis(&machine, axis)).collect();
    if !lines.is_empty() {
        lines.splice(0..0, ["", HEAD].map(str::to_owned));
    }
    lines
}

fn of_axis(machine: &CalibratedMachine, axis: &AxisResult) -> Option<String> {
    let geometry = &machine.machine().axes()[axis.axis];
    let (direction, kind) = (geometry.direction(), geometry.kind());
    let own = |node: &NodeResult| match kind {
        AxisKind::Linear => direction.dot(&node.error.translation_mm),
        AxisKind::Rotary => direction.dot(&node.error.rotation_rad),
    };
    // Nodes rise by position, backward before forward.
    let reversals = axis.nodes.windows(2).filter_map(|pair| {
        let [backward, forward] = pair else {
            return None;
        };
        let is_reversal = backward.position.total_cmp(&forward.position).is_eq();
        is_reversal.then(|| (forward.position, own(forward) - own(backward)))
    });
    let (positions, reversals): (Vec<f64>, Vec<f64>) = reversals.unzip();
    let pairs = positions.iter().zip(&reversals);
    let (at, largest) = pairs.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
    let mean = reversals.iter().sum::<f64>() / reversals.len() as f64;
    let u = machine.u_of_lost_motion(axis.axis, &positions, axis.reference_point_mm);
    let (unit, size) = unit(kind == AxisKind::Rotary);
    let unit = unit.trim();
    Some(format!(
        "  {:<22}{:+.2} {unit} (U {:.2}), {:+.2} {unit} at {} {}",
        axis.name,
        mean / size,
        2.0 * u / size,
        largest / size,
        round(kind.position_in_file(*at), 9),
        kind.position_unit()
    ))
}
