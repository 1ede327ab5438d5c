//! The section `machine` of `campaign.json` and of scenarios.

use nalgebra::{Point3, Vector3};
use trueaxis_files::{check_names, index_of};
use trueaxis_kinematics::{Axis, AxisKind, Branch, FrameRule, Machine, NominalTarget};

use crate::{
    AxisKindSpec, AxisSpec, Campaign, Error, KinematicsSpec, LoggedQuantity, MachineSpec, Place,
    Problem, Target, lengths, point_checks, points, position_unit, verification,
};

impl MachineSpec {
    /// Builds and checks the machine.
    ///
    /// # Errors
    /// With the path of the field in a document that has this machine as `machine`.
    pub fn build(&self) -> Result<Machine, Error> {
        let names: Vec<&str> = self.axes.iter().map(|axis| axis.name.as_str()).collect();
        check_names("machine.axes", "axis", &names)?;
        let axes = self.axes.iter().enumerate();
        let axes = axes.map(|(i, axis)| axis.build(&format!("machine.axes[{i}]")));
        let axes = axes.collect::<Result<_, _>>()?;
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
        if is_another_column(name) {
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
            direction: axis.direction().into_inner().into(),
            travel: axis.travel().map(|end| position_unit::in_file(kind, end)),
            position_mm: (kind == AxisKind::Rotary).then(|| axis.point_mm().coords.into()),
            expansion_ppm_per_k: None,
            temperature_column: None,
            temperature_sigma_k: None,
        }
    }
}

/// Whether some table has a column of that name which holds no positions.
fn is_another_column(name: &str) -> bool {
    let of_tables = [
        &lengths::FIRST_COLUMNS[..],
        &lengths::LAST_COLUMNS,
        &points::LAST_COLUMNS,
        &[points::SIGMA_COLUMN],
        &verification::FIRST_COLUMNS,
        &verification::VALUE_COLUMNS,
        &point_checks::DEVIATION_COLUMNS,
    ];
    of_tables.concat().contains(&name) || LoggedQuantity::of_column(name).is_some()
}

/// The rule that fixes the reference frame for the nominal targets; `measured` says which runs see them: pairs of the index
/// of a run's axis and that of a target.
pub fn frame_rule(
    machine: &Machine,
    targets: &[Target],
    measured: impl IntoIterator<Item = (usize, usize)>,
) -> FrameRule {
    let nominal = targets.iter().map(|target| NominalTarget {
        carrier: target.carrier,
        home_mm: target.home_mm,
    });
    FrameRule::new(machine, &nominal.collect::<Vec<_>>(), measured)
}
