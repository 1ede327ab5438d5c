//! What a calibration that keeps the sides of approach apart says of the lost motion of its axes.

use trueaxis_calibrate::{AxisResult, Calibration, NodeResult};
use trueaxis_campaign::Direction;
use trueaxis_kinematics::{ARCSEC, AxisKind, MICROMETRE};

/// The reversal values of ISO 230-2, forward less backward, at the reference point; nothing where the sides are together.
pub(super) fn reversal_values(calibration: &Calibration) -> Vec<String> {
    let of_axes = calibration.axes.iter();
    let of_axes: Vec<String> = of_axes
        .filter_map(|axis| of_axis(calibration, axis))
        .collect();
    match of_axes.is_empty() {
        true => Vec::new(),
        false => {
            let head = "reversal values         forward less backward, mean and largest";
            let head = [String::new(), head.to_owned()].into_iter();
            head.chain(of_axes).collect()
        }
    }
}

fn of_axis(calibration: &Calibration, axis: &AxisResult) -> Option<String> {
    let geometry = &calibration.machine.axes()[axis.axis];
    let direction = geometry.direction();
    let (unit, size) = match geometry.kind() {
        AxisKind::Linear => (" µm", MICROMETRE),
        AxisKind::Rotary => ("″", ARCSEC),
    };
    let own = |node: &NodeResult| match geometry.kind() {
        AxisKind::Linear => direction.dot(&node.error.translation_mm),
        AxisKind::Rotary => direction.dot(&node.error.rotation_rad),
    };
    let of_side = |side: Direction| {
        let nodes = axis.nodes.iter();
        nodes.filter(move |node| node.direction == Some(side))
    };
    let reversals = of_side(Direction::Forward).filter_map(|forward| {
        let mut backward = of_side(Direction::Backward);
        let same = |node: &&NodeResult| (node.position - forward.position).abs() < f64::EPSILON;
        Some((forward.position, own(forward) - own(backward.find(same)?)))
    });
    let reversals: Vec<(f64, f64)> = reversals.collect();
    let (at, largest) = reversals
        .iter()
        .max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
    let mean = reversals.iter().map(|(_, b)| b).sum::<f64>() / reversals.len() as f64;
    let positions: Vec<f64> = reversals.iter().map(|(position, _)| *position).collect();
    let machine = calibration.calibrated_machine();
    let u = machine.u_of_lost_motion(axis.axis, &positions, axis.reference_point_mm);
    let position = geometry.kind().position_in_file(*at);
    let position_unit = geometry.kind().position_unit();
    Some(format!(
        "  {:<22}{:+.2}{unit} (U {:.2}), {:+.2}{unit} at {position} {position_unit}",
        axis.name,
        mean / size,
        2.0 * u / size,
        largest / size
    ))
}
