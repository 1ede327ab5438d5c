//! The section `machine` of `campaign.json`.

use std::path::Path;

use nalgebra::{Point3, Unit, Vector3};
use trueaxis_kinematics::{Axis, AxisKind, Branch, Machine};

use crate::document::{AxisEntry, AxisKindEntry, KinematicsEntry, MachineEntry};
use crate::names::Names;
use crate::table::FIXED_COLUMNS;
use crate::{Error, Place, position_unit};

/// Builds and checks the machine.
pub(crate) fn from_entry(file: &Path, entry: &MachineEntry) -> Result<Machine, Error> {
    let mut names = Names::new("axis", entry.axes.iter().map(|axis| axis.name.as_str()));
    names.check(file, "machine.axes")?;
    let axes = entry
        .axes
        .iter()
        .enumerate()
        .map(|(i, axis)| axis_from_entry(file, &format!("machine.axes[{i}]"), axis))
        .collect::<Result<_, _>>()?;
    let mut branch = |branch: &[String], path: &str| {
        branch
            .iter()
            .enumerate()
            .map(|(i, name)| names.in_field(name, file, &format!("{path}[{i}]")))
            .collect::<Result<Vec<_>, _>>()
    };
    let tool = branch(&entry.kinematics.tool, "machine.kinematics.tool")?;
    let workpiece = branch(&entry.kinematics.workpiece, "machine.kinematics.workpiece")?;
    Machine::new(axes, tool, workpiece).map_err(|problem| Error::Machine {
        place: Place::field(file, "machine.kinematics"),
        problem: Box::new(problem),
    })
}

fn axis_from_entry(file: &Path, path: &str, entry: &AxisEntry) -> Result<Axis, Error> {
    let place = |field: &str| Place::field(file, format!("{path}.{field}"));
    if FIXED_COLUMNS.contains(&entry.name.as_str()) {
        return Err(Error::Value {
            place: place("name"),
            found: format!("axis `{}` has the name of another column", entry.name),
            expected: "a name like X or C, because each axis has a column".to_owned(),
        });
    }
    let kind = match entry.kind {
        AxisKindEntry::Linear => AxisKind::Linear,
        AxisKindEntry::Rotary => AxisKind::Rotary,
    };
    let [low, high] = entry.travel;
    if low > high {
        return Err(Error::Value {
            place: place("travel"),
            found: format!("the travel [{low}, {high}] ends before it begins"),
            expected: format!("the low end first, in {}", position_unit::unit(kind)),
        });
    }
    let direction = Vector3::from(entry.direction);
    let travel = entry.travel.map(|end| position_unit::from_file(kind, end));
    let axis = match (kind, entry.position_mm) {
        (AxisKind::Linear, None) => Axis::linear(&entry.name, direction, travel),
        (AxisKind::Rotary, Some(point_mm)) => {
            Axis::rotary(&entry.name, direction, travel, Point3::from(point_mm))
        }
        (AxisKind::Linear, Some(_)) => {
            return Err(Error::Value {
                place: place("position_mm"),
                found: format!("axis {} is linear and has a position", entry.name),
                expected: "`position_mm` of rotary axes only; remove it".to_owned(),
            });
        }
        (AxisKind::Rotary, None) => {
            return Err(Error::MissingField {
                place: Place::field(file, path),
                name: "position_mm".to_owned(),
            });
        }
    };
    axis.map_err(|problem| Error::Machine {
        place: place("direction"),
        problem: Box::new(problem),
    })
}

/// The entry that [`from_entry`] reads as `machine`. The file has no place for the reference point
/// of a linear axis.
pub(crate) fn to_entry(name: &str, machine: &Machine) -> MachineEntry {
    let axes = machine.axes();
    let branch = |branch| {
        let axes = machine.branch(branch).iter().filter_map(|&i| axes.get(i));
        axes.map(|axis| axis.name().to_owned()).collect()
    };
    MachineEntry {
        name: name.to_owned(),
        kinematics: KinematicsEntry {
            tool: branch(Branch::Tool),
            workpiece: branch(Branch::Workpiece),
        },
        axes: axes.iter().map(axis_to_entry).collect(),
    }
}

fn axis_to_entry(axis: &Axis) -> AxisEntry {
    let kind = axis.kind();
    AxisEntry {
        name: axis.name().to_owned(),
        kind: match kind {
            AxisKind::Linear => AxisKindEntry::Linear,
            AxisKind::Rotary => AxisKindEntry::Rotary,
        },
        direction: direction_in_file(axis.direction()),
        travel: axis.travel().map(|end| position_unit::in_file(kind, end)),
        position_mm: (kind == AxisKind::Rotary).then(|| axis.reference_mm().coords.into()),
    }
}

/// Lengths to try: most directions are found at the first, nearly all among the next hundred.
const LENGTHS_TRIED: u32 = 10_000;

/// From one length to the next, far below what makes a direction not a unit vector.
const LENGTH_STEP: f64 = 1e-9;

/// A vector that normalises to exactly `direction`.
///
/// Normalising a unit vector again moves the last bit of a third of them; a vector a little longer
/// rounds differently.
fn direction_in_file(direction: Unit<Vector3<f64>>) -> [f64; 3] {
    (0..LENGTHS_TRIED)
        .map(|i| direction.into_inner() * (1.0 + f64::from(i) * LENGTH_STEP))
        .find(|&vector| Unit::new_normalize(vector) == direction)
        .unwrap_or(direction.into_inner())
        .into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn skew_directions_are_read_as_they_were_written() {
        for i in 1..2000_u32 {
            let angle = f64::from(i) * 0.011;
            let vector = Vector3::new(angle.cos(), angle.sin(), (3.0 * angle).sin());
            let direction = Unit::new_normalize(vector);
            let written = Vector3::from(direction_in_file(direction));
            assert_eq!(Unit::new_normalize(written), direction);
        }
    }
}
