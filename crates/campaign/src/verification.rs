//! Verifications: measurements of other instruments, each with its own readings file.

use std::path::Path;

use nalgebra::Point3;
use trueaxis_files::index_of;
use trueaxis_kinematics::{Ideal, Machine};

use crate::axis_columns::AxisColumns;
use crate::document::{VerificationEntry, VerificationKindEntry};
use crate::rows::{Rows, position_cells};
use crate::run_axes::check_moves;
use crate::setup::{axis_names, check_sigma};
use crate::stops::required_columns;
use crate::table::Table;
use crate::{Error, Place, Problem, Verification, VerificationKind, VerificationReading};

/// Columns before those of the axes.
pub(crate) const FIRST_COLUMNS: [&str; 2] = ["cycle", "direction"];

/// The columns of the measured value: along a laser line, of a ball bar.
pub(crate) const VALUE_COLUMNS: [&str; 2] = ["deviation_um", "delta_um"];

/// The optional column.
const TIME_COLUMN: &str = "time_s";

/// Entry number `index` as what was measured; none of point checks.
fn kind(
    index: usize,
    entry: &VerificationEntry,
    machine: &Machine,
) -> Result<Option<VerificationKind>, Error> {
    use VerificationKindEntry::{Ballbar, Points, Positioning};
    let path = format!("verification[{index}]");
    // Which fields an entry may have depends on its kind.
    let (line, bar) = ((Positioning, "positioning"), (Ballbar, "ballbar"));
    let fields = [
        ("axis", line, entry.axis.is_some()),
        ("target_mm", line, entry.target_mm.is_some()),
        ("ball_mm", bar, entry.ball_mm.is_some()),
        ("ball_carried_by", bar, entry.ball_carried_by.is_some()),
        ("center_mm", bar, entry.center_mm.is_some()),
        (
            "length_is_calibrated",
            bar,
            entry.length_is_calibrated.is_some(),
        ),
    ];
    let mut foreign = fields.iter().filter(|(_, (of, _), _)| *of != entry.kind);
    if let Some((name, (_, kind), _)) = foreign.find(|(.., is_there)| *is_there) {
        let found = format!("`{name}` belongs to the kind `{kind}`");
        let expected = "only fields of the kind given; remove it, or correct `kind`";
        let place = Place::in_field(format!("{path}.{name}"));
        return Err(Problem::value(found, expected).at(place));
    }
    let missing = |name| Problem::missing(name).at(Place::in_field(path.as_str()));
    let point =
        |name, value: Option<[f64; 3]>| value.map(Point3::from).ok_or_else(|| missing(name));
    let axis = |name, value: Option<&String>| -> Result<usize, Error> {
        let field = format!("{path}.{name}");
        let axis = value.ok_or_else(|| missing(name))?;
        Ok(index_of(field, "axis", axis, &axis_names(machine))?)
    };
    Ok(match entry.kind {
        Positioning => Some(VerificationKind::Positioning {
            axis: axis("axis", entry.axis.as_ref())?,
            target_mm: point("target_mm", entry.target_mm)?,
        }),
        Ballbar => Some(VerificationKind::Ballbar {
            ball_mm: point("ball_mm", entry.ball_mm)?,
            ball_carrier: axis("ball_carried_by", entry.ball_carried_by.as_ref())?,
            center_mm: point("center_mm", entry.center_mm)?,
            length_is_calibrated: entry.length_is_calibrated.unwrap_or(false),
        }),
        Points => None,
    })
}

/// Entry number `index` without its readings; none of point checks. A standard uncertainty is more than zero; its proportional part may
/// be zero.
pub(crate) fn declared(
    index: usize,
    entry: &VerificationEntry,
    machine: &Machine,
) -> Result<Option<Verification>, Error> {
    let kind = kind(index, entry, machine)?;
    let &VerificationEntry { u_um, u_ppm, .. } = entry;
    for (field, u, or_zero) in [("u_um", u_um, false), ("u_ppm", u_ppm, true)] {
        let field = format!("verification[{index}].{field}");
        check_sigma(field, "standard uncertainty", u, "", or_zero)?;
    }
    Ok(kind.map(|kind| Verification {
        name: entry.name.clone(),
        kind,
        u_um,
        u_ppm,
        readings: Vec::new(),
    }))
}

/// Reads the readings file of a verification.
pub(crate) fn read(
    file: &Path,
    text: &str,
    declared: Verification,
    machine: &Machine,
) -> Result<Verification, Error> {
    let value_column = value_column(&declared.kind);
    let required = required_columns(&FIRST_COLUMNS, machine, &[value_column]);
    let mut table = Table::open(file, text, &required, &[TIME_COLUMN])?;
    let time = table.optional_column(TIME_COLUMN);
    let cycle = table.column("cycle")?;
    let direction = table.column("direction")?;
    let mut axes = AxisColumns::of(&table, machine)?;
    let value = table.column(value_column)?;

    let readings = table.read_rows(|row| {
        let positions = axes.read_within_travel(row)?;
        Ok(VerificationReading {
            time_s: time.map(|column| row.time_s(column)).transpose()?,
            cycle: row.counting_number(cycle)?,
            direction: row.direction(direction)?,
            positions,
            value_um: row.number(value)?,
            line: row.line(),
        })
    })?;
    let axes = match &declared.kind {
        VerificationKind::Positioning { axis, .. } => std::slice::from_ref(axis),
        VerificationKind::Ballbar { ball_carrier, .. } => machine.chain(*ball_carrier),
    };
    let rows = readings.iter().map(|r| (r.positions.as_slice(), r.line));
    let of = ("verification", declared.name.as_str());
    check_moves(file, machine.axes(), axes, of, rows)?;
    check_bar(file, &declared.kind, &readings, machine)?;
    Ok(Verification {
        readings,
        ..declared
    })
}

/// A bar gives way by a millimetre or two.
const BAR_GIVES_MM: f64 = 2.0;

/// Refuses rows between which the nominal distance of the balls of a bar changes by more than a bar can.
fn check_bar(
    file: &Path,
    kind: &VerificationKind,
    readings: &[VerificationReading],
    machine: &Machine,
) -> Result<(), Error> {
    let VerificationKind::Ballbar {
        ball_mm,
        ball_carrier,
        center_mm,
        ..
    } = *kind
    else {
        return Ok(());
    };
    let length_mm = |reading: &VerificationReading| {
        let ball = machine.position(&Ideal, ball_carrier, &reading.positions, ball_mm);
        (ball - center_mm).norm()
    };
    let first_mm = readings.first().map_or(0.0, length_mm);
    let is_other = |r: &&VerificationReading| (length_mm(r) - first_mm).abs() > BAR_GIVES_MM;
    let Some(other) = readings.iter().find(is_other) else {
        return Ok(());
    };
    let found = format!(
        "the balls nominally {:.3} mm apart, {first_mm:.3} mm in line {}",
        length_mm(other),
        readings[0].line
    );
    let expected = "a bar that keeps its length; check ball_mm, ball_carried_by, center_mm and the positions. center_mm is a place on \
                    the bed: where both balls move, a bar cannot be given";
    Err(Problem::value(found, expected).at(Place::line(file, other.line)))
}

/// The text that [`read`] reads as `verification`.
pub(crate) fn text(verification: &Verification, machine: &Machine) -> String {
    let value_column = value_column(&verification.kind);
    let has_time = verification.readings.iter().any(|r| r.time_s.is_some());
    let time_column = has_time.then_some(TIME_COLUMN);
    let columns = required_columns(&FIRST_COLUMNS, machine, &[value_column]);
    let mut rows = Rows::with_header(time_column.into_iter().chain(columns));
    for reading in &verification.readings {
        if has_time {
            rows.optional_time_s(reading.time_s);
        }
        rows.number(reading.cycle);
        rows.number(reading.direction.sign());
        rows.positions(&position_cells(machine, &reading.positions));
        rows.number(reading.value_um);
        rows.end_row();
    }
    rows.into_text()
}

fn value_column(kind: &VerificationKind) -> &'static str {
    let [of_line, of_bar] = VALUE_COLUMNS;
    match kind {
        VerificationKind::Positioning { .. } => of_line,
        VerificationKind::Ballbar { .. } => of_bar,
    }
}

/// The entry that [`kind`] reads as `verification`.
pub(crate) fn to_entry(
    verification: &Verification,
    machine: &Machine,
    readings: String,
) -> VerificationEntry {
    let axis_name = |axis: usize| machine.axes().get(axis).map(|a| a.name().to_owned());
    let entry = VerificationEntry {
        name: verification.name.clone(),
        u_um: verification.u_um,
        u_ppm: verification.u_ppm,
        readings,
        ..VerificationEntry::default()
    };
    match verification.kind {
        VerificationKind::Positioning { axis, target_mm } => VerificationEntry {
            kind: VerificationKindEntry::Positioning,
            axis: axis_name(axis),
            target_mm: Some(target_mm.into()),
            ..entry
        },
        VerificationKind::Ballbar {
            ball_mm,
            ball_carrier,
            center_mm,
            length_is_calibrated,
        } => VerificationEntry {
            kind: VerificationKindEntry::Ballbar,
            ball_mm: Some(ball_mm.into()),
            ball_carried_by: axis_name(ball_carrier),
            center_mm: Some(center_mm.into()),
            length_is_calibrated: length_is_calibrated.then_some(true),
            ..entry
        },
    }
}
