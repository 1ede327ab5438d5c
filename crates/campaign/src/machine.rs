//! The section `machine` of `campaign.json` and of scenarios.

use nalgebra::{Point3, Unit, Vector3};
use trueaxis_files::{check_names, index_of};
use trueaxis_kinematics::{Axis, AxisKind, Branch, Machine};

use crate::header::is_fixed_column;
use crate::{
    AxisKindSpec, AxisSpec, Campaign, Error, KinematicsSpec, MachineSpec, Place, Problem,
    position_unit,
};

impl MachineSpec {
    /// Builds and checks the machine.
    ///
    /// # Errors
    /// With the path of the field in a document that has this machine as `machine`.
    pub fn build(&self) -> Result<Machine, Error> {
        let names: Vec<&str> = self.axes.iter().map(|axis| axis.name.as_str()).collect();
        check_names("machine.axes", "axis", &names)?;
        let axes = self
            .axes
            .iter()
            .enumerate()
            .map(|(i, axis)| axis.build(&format!("machine.axes[{i}]")))
            .collect::<Result<_, _>>()?;
        let branch = |listed: &[String], name: &str| {
            let field = |i| format!("machine.kinematics.{name}[{i}]");
            let listed = listed.iter().enumerate();
            listed
                .map(|(i, name)| index_of(field(i), "axis", name, &names))
                .collect::<Result<Vec<_>, _>>()
        };
        let tool = branch(&self.kinematics.tool, "tool")?;
        let workpiece = branch(&self.kinematics.workpiece, "workpiece")?;
        Machine::new(axes, tool, workpiece).map_err(|problem| {
            let problem = Box::new(problem);
            Problem::Machine { problem }.at(Place::in_field("machine.kinematics"))
        })
    }

    /// What [`MachineSpec::build`] makes a machine from. There is no place for the reference point of a
    /// linear axis; no thermal expansion is declared.
    pub fn of(name: &str, machine: &Machine) -> Self {
        let axes = machine.axes();
        let branch = |branch| {
            let axes = machine.branch(branch).iter().filter_map(|&i| axes.get(i));
            axes.map(|axis| axis.name().to_owned()).collect()
        };
        Self {
            name: name.to_owned(),
            kinematics: KinematicsSpec {
                tool: branch(Branch::Tool),
                workpiece: branch(Branch::Workpiece),
            },
            axes: axes.iter().map(AxisSpec::of).collect(),
        }
    }
}

impl Campaign {
    /// The machine as `campaign.json` has it.
    pub fn machine_spec(&self) -> MachineSpec {
        MachineSpec::of(&self.machine_name, &self.machine).with_expansions(&self.expansions)
    }
}

impl AxisSpec {
    fn build(&self, path: &str) -> Result<Axis, Error> {
        let place = |field: &str| Place::in_field(format!("{path}.{field}"));
        let name = &self.name;
        if is_fixed_column(name) {
            let found = format!("axis `{name}` has the name of another column");
            let expected = "a name like X or C, because each axis has a column";
            return Err(Problem::value(found, expected).at(place("name")));
        }
        let kind = match self.kind {
            AxisKindSpec::Linear => AxisKind::Linear,
            AxisKindSpec::Rotary => AxisKind::Rotary,
        };
        let [low, high] = self.travel;
        if low > high {
            let found = format!("the travel [{low}, {high}] ends before it begins");
            let expected = format!("the low end first, in {}", kind.position_unit());
            return Err(Problem::value(found, expected).at(place("travel")));
        }
        let direction = Vector3::from(self.direction);
        let travel = self.travel.map(|end| kind.position_from_file(end));
        let axis = match (kind, self.position_mm) {
            (AxisKind::Linear, None) => Axis::linear(name, direction, travel),
            (AxisKind::Rotary, Some(point_mm)) => {
                Axis::rotary(name, direction, travel, Point3::from(point_mm))
            }
            (AxisKind::Linear, Some(_)) => {
                let found = format!("axis {name} is linear and has a position");
                let expected = "`position_mm` of rotary axes only; remove it";
                return Err(Problem::value(found, expected).at(place("position_mm")));
            }
            (AxisKind::Rotary, None) => {
                return Err(Problem::missing("position_mm").at(Place::in_field(path)));
            }
        };
        axis.map_err(|problem| {
            let problem = Box::new(problem);
            Problem::Machine { problem }.at(place("direction"))
        })
    }

    fn of(axis: &Axis) -> Self {
        let kind = axis.kind();
        Self {
            name: axis.name().to_owned(),
            kind: match kind {
                AxisKind::Linear => AxisKindSpec::Linear,
                AxisKind::Rotary => AxisKindSpec::Rotary,
            },
            direction: direction_in_file(axis.direction()),
            travel: axis.travel().map(|end| position_unit::in_file(kind, end)),
            position_mm: (kind == AxisKind::Rotary).then(|| axis.reference_mm().coords.into()),
            expansion_ppm_per_k: None,
            temperature_column: None,
            temperature_sigma_k: None,
        }
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
