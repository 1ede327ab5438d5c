//! The calibrated machine, for predictions.

use trueaxis_kinematics::Machine;
use trueaxis_predict::{CalibratedMachine, MeasuredAxis, Node};

use crate::result::calibration::{AxisResult, Calibration};

impl Calibration {
    /// The calibrated machine, for predictions.
    pub fn calibrated_machine(&self) -> CalibratedMachine {
        let axes = self.axes.iter().map(measured_axis).collect();
        let factors = self.factors.clone();
        let mut machine = CalibratedMachine::new(self.with_reference_points(), axes, factors);
        machine.name.clone_from(&self.machine_spec.name);
        machine.campaign.clone_from(&self.campaign);
        machine.effects_taken_out.clone_from(&self.effects);
        let parked = |axis: &AxisResult| (axis.axis, axis.parked.clone());
        machine.parked = self.axes.iter().map(parked).collect();
        let dof = self.results().into_iter().map(|result| result.dof);
        machine.dof = dof.fold(f64::INFINITY, f64::min);
        machine
    }

    /// The machine with the reference points to which the component errors belong.
    fn with_reference_points(&self) -> Machine {
        self.machine.with_axes(|index, axis| {
            match self.axes.iter().find(|result| result.axis == index) {
                Some(result) => axis.with_reference(result.reference_point_mm),
                None => axis,
            }
        })
    }
}

fn measured_axis(axis: &AxisResult) -> MeasuredAxis {
    let nodes = axis.nodes.iter().map(|node| Node {
        position: node.position,
        direction: node.direction,
    });
    let reported = axis.location_errors.iter();
    MeasuredAxis {
        axis: axis.axis,
        nodes: nodes.collect(),
        errors: axis.nodes.iter().map(|node| node.error).collect(),
        location: axis.location,
        reported: reported.map(|location| location.component).collect(),
    }
}
