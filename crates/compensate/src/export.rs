//! Tables that a control takes, and what they can take away.

mod announcement;
mod components;
mod csv;
pub(crate) mod etalon;
mod grid;
mod heidenhain;
pub(crate) mod isg;
mod klipper;
mod line;
mod linuxcnc;
mod marlin;
pub(crate) mod named_errors;
mod old_files;
mod sides;
mod sinumerik;
mod skew;

use nalgebra::Point3;
use trueaxis_files::{point_mm, round};
use trueaxis_kinematics::{AxisKind, Branch, Machine};
use trueaxis_predict::CalibratedMachine;

use crate::Error;
pub use announcement::{Announcement, LineFigures};
use old_files::OldFiles;
use sides::Sides;

/// A control, or a format that controls read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// A neutral table of error vectors over the linear axes (CSV).
    Grid,
    /// `LinuxCNC`: a compensation file for each joint, and the matrix of `matrixkins`.
    LinuxCnc,
    /// ISG kernel, Beckhoff TF5280: `ISG_CSV`, all component and location errors.
    Isg,
    /// Etalon exchange format: the same.
    Etalon,
    /// Siemens SINUMERIK: `$AA_ENC_COMP` and `$AN_CEC`.
    Sinumerik,
    /// HEIDENHAIN TNC: the columns of `.COM` and `.CMA`.
    Heidenhain,
    /// Marlin: `M852`.
    Marlin,
    /// Klipper: `SET_SKEW`.
    Klipper,
}

impl Format {
    /// All of them.
    pub const ALL: [Self; 8] = [
        Self::Grid,
        Self::LinuxCnc,
        Self::Isg,
        Self::Etalon,
        Self::Sinumerik,
        Self::Heidenhain,
        Self::Marlin,
        Self::Klipper,
    ];

    fn description_of(self) -> &'static Description {
        match self {
            Self::Grid => &grid::FORMAT,
            Self::LinuxCnc => &linuxcnc::FORMAT,
            Self::Isg => &isg::FORMAT,
            Self::Etalon => &etalon::FORMAT,
            Self::Sinumerik => &sinumerik::FORMAT,
            Self::Heidenhain => &heidenhain::FORMAT,
            Self::Marlin => &marlin::FORMAT,
            Self::Klipper => &klipper::FORMAT,
        }
    }

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        self.description_of().name
    }

    /// What it is, in a line.
    pub fn description(self) -> &'static str {
        self.description_of().text
    }

    /// Names of the files of old tables that [`Request::onto`] takes, for a machine.
    ///
    /// # Errors
    /// [`Error::Unsuitable`] for a format without tables.
    pub fn old_files(self, machine: &Machine) -> Result<Vec<String>, Error> {
        let description = self.description_of();
        description.old_files.names(description.name, machine)
    }

    /// Whether a file of that name is meant as one of them; [`export()`] refuses it if it is none.
    pub fn is_like_an_old_file(self, name: &str) -> bool {
        self.description_of().old_files.is_like(name)
    }
}

/// What the file of a format says of it.
struct Description {
    /// On the command line.
    name: &'static str,
    /// A line for its help.
    text: &'static str,
    old_files: OldFiles,
    sides: Sides,
    /// Whether the rule of the control is known from one source alone, or in part.
    is_experimental: bool,
    tables: fn(&Request<'_>) -> Result<Tables, Error>,
}

/// At the top of each file whose rule is known from one source alone, or in part.
const EXPERIMENTAL: &str =
    "EXPERIMENTAL: not all of the rule of the control is public; check one measured line";

/// Refuses a table with more points than the control holds.
fn check_points(
    request: &Request<'_>,
    what: impl FnOnce() -> String,
    points: usize,
    most: usize,
) -> Result<(), Error> {
    match points <= most {
        true => Ok(()),
        false => Err(Error::TooManyPoints {
            what: what(),
            format: request.format.name(),
            points,
            most,
        }),
    }
}

/// What is asked for.
#[derive(Debug, Clone, Copy)]
pub struct Request<'a> {
    /// The format.
    pub format: Format,
    /// The machine.
    pub machine: &'a CalibratedMachine,
    /// The tool point in the reference frame at home, mm: one-dimensional tables are right for the lines along which
    /// the axes move it from home.
    pub at: Point3<f64>,
    /// Only this axis, by index; without it all that were measured.
    pub axis: Option<usize>,
    /// Distance of the points of a table, mm for linear and degrees for rotary axes; without it the steps at which the axis
    /// was measured.
    pub step: Option<f64>,
    /// What the control makes of a value, where no public page says it: [`Format::Heidenhain`] wants it, no other format takes
    /// it.
    pub sign: Option<TableSign>,
    /// Whether the angles of linear axes act on the positions of the others, as products of tables: only [`Format::Sinumerik`]
    /// has them.
    pub levers: bool,
    /// The files of this format that were active while the machine was measured: the new ones contain them.
    pub onto: &'a [ExportedFile],
}

/// What the control makes of a positive value in a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TableSign {
    /// Values are errors, actual minus commanded: a positive one moves the axis in the negative direction.
    Error,
    /// Values are corrections: a positive one moves the axis in the positive direction.
    Correction,
}

impl TableSign {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Error, Self::Correction];

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Error => "error",
            Self::Correction => "correction",
        }
    }

    /// What it means, in a line.
    pub fn description(self) -> &'static str {
        match self {
            Self::Error => "a positive value moves the axis in the negative direction",
            Self::Correction => "a positive value moves the axis in the positive direction",
        }
    }
}

/// A file for the control.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ExportedFile {
    /// Its name.
    pub name: String,
    /// Its text.
    pub text: String,
}

impl ExportedFile {
    fn new(name: impl Into<String>, text: String) -> Self {
        let name = name.into();
        Self { name, text }
    }
}

/// Tables for a control.
#[derive(Debug, Clone, PartialEq)]
pub struct Export {
    /// The files.
    pub files: Vec<ExportedFile>,
    /// Sign, place and what else must be known to enter it: a line each.
    pub notes: Vec<String>,
    /// Whether the rule of the control is known from one source alone, or in part.
    pub is_experimental: bool,
    /// What the tables can take away, and what not.
    pub announcement: Announcement,
}

/// What the control makes of a table: what it adds to the commanded positions, mm or rad for each axis.
type Rule = dyn Fn(&[f64]) -> Result<Vec<f64>, Error>;

/// The files of a format before they are judged.
pub(crate) struct Tables {
    files: Vec<ExportedFile>,
    notes: Vec<String>,
    rule: Box<Rule>,
}

/// Makes the tables.
///
/// # Errors
/// What the control cannot hold, with the numbers: [`Error`].
pub fn export(request: &Request<'_>) -> Result<Export, Error> {
    let description = request.format.description_of();
    description.old_files.check(request)?;
    if request.sign.is_some() && request.format != Format::Heidenhain {
        let lacks = format!("only {} leaves that choice", Format::Heidenhain.name());
        return Err(request.unsuitable("no sign", lacks));
    }
    if request.levers && request.format != Format::Sinumerik {
        let lacks = format!("only {} multiplies tables", Format::Sinumerik.name());
        return Err(request.unsuitable("no levers", lacks));
    }
    let mut tables = (description.tables)(request)?;
    tables.notes.extend(description.sides.note(request));
    Ok(Export {
        announcement: Announcement::new(request, &tables.rule)?,
        files: tables.files,
        notes: tables.notes,
        is_experimental: description.is_experimental,
    })
}

impl Request<'_> {
    /// Indices of the axes that tables are asked for.
    fn axes(&self) -> Result<Vec<usize>, Error> {
        let all = self.machine.machine().axes();
        let measured: Vec<usize> = (0..all.len())
            .filter(|&axis| !self.machine.steps(axis).is_empty())
            .collect();
        match self.axis {
            None => Ok(measured),
            Some(axis) if measured.contains(&axis) => Ok(vec![axis]),
            Some(axis) => Err(Error::NoSuchAxis {
                axis: all.get(axis).map_or("?", |axis| axis.name()).to_owned(),
                measured: names(measured.iter().map(|&axis| all[axis].name())),
            }),
        }
    }

    /// Those of them that are linear, of which the format wants one at least.
    fn linear_axes(&self) -> Result<Vec<usize>, Error> {
        let all = self.machine.machine().axes();
        let mut axes = self.axes()?;
        axes.retain(|&axis| all[axis].kind() == AxisKind::Linear);
        if axes.is_empty() {
            let lacks = "none of those asked for is linear and was measured";
            return Err(self.unsuitable("errors over linear axes", lacks));
        }
        Ok(axes)
    }

    /// Whether targets saw what an old table did to `output` while `input` moved, the other axes at home: they stand on the
    /// branch of `input`. What they did not see is still whole in the new errors.
    fn is_seen(&self, input: usize, output: usize) -> bool {
        let machine = self.machine.machine();
        let branches = [Branch::Tool, Branch::Workpiece].map(|branch| machine.branch(branch));
        let mut both = branches.iter();
        both.any(|axes| axes.contains(&input) && axes.contains(&output))
    }

    /// The error for what the format cannot hold.
    fn unsuitable(&self, takes: &'static str, lacks: impl Into<String>) -> Error {
        Error::Unsuitable {
            format: self.format.name(),
            takes,
            lacks: lacks.into(),
        }
    }

    fn name(&self, axis: usize) -> &str {
        self.machine.machine().axes()[axis].name()
    }

    /// mm or degrees of mm or rad.
    fn in_file(&self, axis: usize, value: f64) -> f64 {
        in_file(self.machine.machine().axes()[axis].kind(), value)
    }

    fn unit(&self, axis: usize) -> &'static str {
        unit(self.machine.machine().axes()[axis].kind())
    }

    /// Where it comes from and for which lines it is right.
    fn origin(&self) -> String {
        let effects = match self.machine.names_taken_out().as_slice() {
            [] => String::new(),
            effects => format!(", without {}", effects.join(", ")),
        };
        format!(
            "machine {}, campaign {}{effects}; tool point {} at home",
            self.machine.name,
            self.machine.campaign,
            point_mm(self.at.into())
        )
    }
}

fn names<'a>(names: impl Iterator<Item = &'a str>) -> String {
    names.collect::<Vec<_>>().join(", ")
}

/// mm or degrees of mm or rad.
pub(crate) fn in_file(kind: AxisKind, value: f64) -> f64 {
    round(kind.position_in_file(value), 9)
}

/// The unit of positions.
pub(crate) fn unit(kind: AxisKind) -> &'static str {
    match kind {
        AxisKind::Linear => "mm",
        AxisKind::Rotary => "degrees",
    }
}

/// The different positions, rising; those no farther apart than `same` are one.
pub(crate) fn rising(positions: impl Iterator<Item = f64>, same: f64) -> Vec<f64> {
    let mut all: Vec<f64> = positions.collect();
    all.sort_by(f64::total_cmp);
    all.dedup_by(|a, b| (*a - *b).abs() <= same);
    all
}
