//! The nominal machine of a scenario.

use nalgebra::{Point3, Vector3};
use trueaxis_kinematics::{Axis, AxisKind, Machine};

use crate::axis_unit;
use crate::check;
use crate::{AxisKindSpec, AxisSpec, Error, MachineSpec};

pub(crate) fn build_machine(spec: &MachineSpec) -> Result<Machine, Error> {
    let names: Vec<&str> = spec.axes.iter().map(|axis| axis.name.as_str()).collect();
    check::distinct_names("machine.axes", "axis", &names)?;
    let axes = spec.axes.iter().enumerate();
    let axes = axes
        .map(|(i, axis)| build_axis(&format!("machine.axes[{i}]"), axis))
        .collect::<Result<Vec<_>, _>>()?;
    let branch = |branch: &str, listed: &[String]| {
        let listed = listed.iter().enumerate();
        listed
            .map(|(i, name)| {
                let field = format!("machine.kinematics.{branch}[{i}]");
                check::index_of(field, "axis", name, &names)
            })
            .collect::<Result<Vec<_>, _>>()
    };
    let tool = branch("tool", &spec.kinematics.tool)?;
    let workpiece = branch("workpiece", &spec.kinematics.workpiece)?;
    Machine::new(axes, tool, workpiece).map_err(|source| Error::Machine {
        field: "machine.kinematics".to_owned(),
        source,
    })
}

fn build_axis(field: &str, spec: &AxisSpec) -> Result<Axis, Error> {
    let direction = Vector3::from(spec.direction);
    let axis = match (spec.kind, spec.position_mm) {
        (AxisKindSpec::Linear, None) => Axis::linear(&spec.name, direction, spec.travel),
        (AxisKindSpec::Rotary, Some(position_mm)) => {
            let travel_rad = spec
                .travel
                .map(|q| axis_unit::from_file(AxisKind::Rotary, q));
            Axis::rotary(&spec.name, direction, travel_rad, Point3::from(position_mm))
        }
        (AxisKindSpec::Linear, Some(_)) => {
            let field = format!("{field}.position_mm");
            return Err(check::expected(field, "nothing here for a linear axis"));
        }
        (AxisKindSpec::Rotary, None) => {
            let missing = "`position_mm`, a point on the axis of rotation";
            return Err(check::expected(field, missing));
        }
    };
    axis.map_err(|source| Error::Machine {
        field: field.to_owned(),
        source,
    })
}
