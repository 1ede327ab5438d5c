//! Which files hold the tables that were in force, by their names.

use trueaxis_kinematics::{AxisKind, Machine};

use crate::Error;
use crate::export::named_errors::wrong;
use crate::export::{ExportedFile, Request, names};

/// The files of old tables, as a format names them.
pub(super) enum OldFiles {
    /// It takes none: it has no tables, or what they did to the targets depends on the tool point that the control had, and the
    /// angles in them, which it takes away nowhere, are whole in the new ones.
    None,
    /// One file alone may have any name.
    Named(&'static [&'static str]),
    /// One for each axis, by its name and an ending.
    OfAxes {
        ending: &'static str,
        linear_alone: bool,
        /// One for all of them.
        of_all: Option<&'static str>,
        /// The format's own files that hold no table.
        beside: &'static [&'static str],
    },
}

impl OldFiles {
    /// Those of a machine.
    pub(super) fn names(
        &self,
        format: &'static str,
        machine: &Machine,
    ) -> Result<Vec<String>, Error> {
        match self {
            Self::Named(names) => Ok(names.iter().map(|&name| name.to_owned()).collect()),
            Self::OfAxes {
                ending,
                linear_alone,
                of_all,
                ..
            } => {
                let has_one = |kind: AxisKind| !*linear_alone || matches!(kind, AxisKind::Linear);
                let axes = machine.axes().iter().filter(|axis| has_one(axis.kind()));
                let of_axes = axes.map(|axis| format!("{}{ending}", axis.name()));
                Ok(of_axes.chain(of_all.map(str::to_owned)).collect())
            }
            Self::None => {
                let lacks = "switch its correction off before you measure".to_owned();
                Err(Error::Unsuitable {
                    format,
                    takes: "no old tables",
                    lacks,
                })
            }
        }
    }

    /// Whether a file of that name is meant for one of them, with the name of an axis or a wrong one.
    pub(super) fn is_like(&self, name: &str) -> bool {
        let matches = |end: &str| name.to_lowercase().ends_with(&end.to_lowercase());
        match self {
            Self::None => false,
            Self::Named(names) => names.contains(&name),
            Self::OfAxes { ending, of_all, .. } => matches(ending) || *of_all == Some(name),
        }
    }

    /// None is left aside without a word.
    pub(super) fn check(&self, request: &Request<'_>) -> Result<(), Error> {
        let (given, format) = (request.onto, request.format.name());
        if given.is_empty() {
            return Ok(());
        }
        let names_of_all = self.names(format, request.machine.machine())?;
        let Self::OfAxes { beside, .. } = self else {
            return Ok(());
        };
        let is_one = |file: &&ExportedFile| names_of_all.contains(&file.name);
        let is_beside = |file: &ExportedFile| beside.contains(&file.name.as_str());
        let stray = given.iter().find(|file| !is_one(file) && !is_beside(file));
        // Its own files without a table say nothing alone.
        let stray = stray.or_else(|| given.first().filter(|_| !given.iter().any(|f| is_one(&f))));
        stray.map_or(Ok(()), |file| {
            Err(Error::NoOldTable {
                file: file.name.clone(),
                format,
                expected: names(names_of_all.iter().map(String::as_str)),
            })
        })
    }
}

/// By how much of the travel an old table may reach beyond either end: controls have points outside it.
const BEYOND: f64 = 0.25;

/// How much of the measured positions an old table has, at least, without a word.
const MOST_OF_IT: f64 = 0.9;

/// Refuses a table from a first to a last position (mm or degrees) that is none of an axis of this machine, and says what it does not reach.
pub(super) fn reach(
    request: &Request<'_>,
    file: &str,
    axis: usize,
    [first, last]: [f64; 2],
) -> Result<Option<String>, Error> {
    let (name, unit) = (request.name(axis), request.unit(axis));
    let travel = request.machine.machine().axes()[axis].travel();
    let [low, high] = travel.map(|q| request.in_file(axis, q));
    let most = BEYOND * (high - low);
    if first < low - most || last > high + most {
        let found = format!("{name} from {first} to {last} {unit}");
        let expected = format!(
            "positions within the travel of {name}, {low} to {high} {unit}: is it a table of another axis, another machine or in another unit?"
        );
        return Err(wrong(file, 1, &found, expected));
    }
    let steps = request.machine.steps(axis);
    let measured = [steps.first(), steps.last()];
    let [Some(start), Some(end)] = measured.map(|q| q.map(|q| request.in_file(axis, *q))) else {
        return Ok(None);
    };
    let common = last.min(end) - first.max(start);
    let is_short = common < MOST_OF_IT * (end - start);
    Ok(is_short.then(|| {
        format!(
            "{file}: the old table of {name} goes from {first} to {last} {unit}, the new one from {start} to {end}: beyond its ends the old one \
             stays as it is there; is it whole, and of this axis?"
        )
    }))
}
