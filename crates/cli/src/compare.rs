//! `trueaxis compare`.

use std::path::Path;

use serde_json::Value;
use trueaxis_files::{round, told_behind};
use trueaxis_kinematics::AxisKind;
use trueaxis_predict::{
    CalibratedMachine, Difference, check_same_machine, comparison_json, position_in_file,
};

use crate::args::CompareArgs;
use crate::exit::Exit;
use crate::other_machine::placed;
use crate::predict::source;
use crate::talk::{notice, say, say_all};
use crate::traceability::{of_calibration, traced};

/// Decimals of µm, ″ and `E_n`.
const DECIMALS: i32 = 4;

pub(crate) fn execute(args: &CompareArgs) -> anyhow::Result<Exit> {
    let first = CalibratedMachine::read(&args.first)?;
    let second = CalibratedMachine::read(&args.second)?;
    check_same_machine(first.machine(), second.machine())
        .map_err(|error| placed(error, &args.first, &args.second))?;
    let differences = first.compare(&second)?;
    let mut inputs = of_calibration(&args.first, &first)?;
    inputs.extend(of_calibration(&args.second, &second)?);
    // Curves and location errors in the order of the differences.
    let curves = differences.chunk_by(|a, b| a.name == b.name);
    let curves: Vec<&[Difference]> = curves.collect();
    let text = traced(comparison_json(&first, &second, &curves), &inputs, None)?;
    let mut results = args.result.folder(&second.campaign)?;
    results.write("comparison.json", text.as_bytes())?;
    for (name, machine) in [("first", &first), ("second", &second)] {
        say_all(source(machine).iter().map(|line| format!("{name}: {line}")));
    }
    say_all(table(&curves));
    say(&summary(&curves));
    for (axis, kind, homes) in first.other_homes(&second) {
        notice(&other_home(axis, kind, &homes));
    }
    for ([axis, other], at) in first.other_parking(&second) {
        let [axis, other] = [axis, other].map(|index| &second.machine().axes()[index]);
        let [a, b] = at.map(|q| place(other.kind(), q));
        notice(&format!(
            "{} was measured with {} at {a} first, at {b} then: if that axis bends or turns it, its curves differ by that",
            axis.name(),
            other.name(),
        ));
    }
    for (axis, kind, positions) in first.other_steps(&second) {
        notice(&other_steps(axis, kind, positions.as_deref()));
    }
    let open = curves.iter().filter(|c| c[0].follows_from_other_steps);
    let open: Vec<&str> = open.map(|curve| curve[0].name.as_str()).collect();
    if !open.is_empty() {
        notice(&format!(
            "differences of {} contain what error curves make of other positions, which U does not, so that no \
             change of the machine follows from them: measure both times at the same positions",
            open.join(", ")
        ));
    }
    if measured_lengths(&args.first)
        .is_some_and(|hash| measured_lengths(&args.second) == Some(hash))
    {
        notice(
            "both follow from the same measurement, whose noise is common to them: U of the differences is too large",
        );
    }
    if !args.no_report {
        results.report()?;
    }
    results.end(args.result.json.then_some(&text))?;
    Ok(Exit::Good)
}

/// A position with its unit.
fn place(kind: AxisKind, position: f64) -> String {
    let rounded = round(position_in_file(kind, position), DECIMALS);
    format!("{rounded}{}", told_behind(kind.position_unit(), ' '))
}

/// What average lines refer to of an axis that was measured at other positions.
fn other_steps(axis: &str, kind: AxisKind, positions: Option<&[f64]>) -> String {
    let measured = format!("{axis} was measured at different positions in the two calibrations");
    let what = match kind {
        AxisKind::Linear => "straightness, and squareness to it, are from its average line through",
        AxisKind::Rotary => "what is across it is from its average axis at",
    };
    match positions.and_then(|all| Some((all.len(), all.first()?, all.last()?))) {
        Some((count, from, to)) => format!(
            "{measured}: in both {what} {count} positions from {} to {}",
            place(kind, *from),
            place(kind, *to)
        ),
        None => format!("{measured}, and its average line or axis is that of the positions"),
    }
}

/// What the differences of an axis refer to of which home was not a step in both calibrations.
fn other_home(axis: &str, kind: AxisKind, homes: &[Vec<f64>; 2]) -> String {
    let errors = match kind {
        AxisKind::Linear => "positioning and angles",
        AxisKind::Rotary => "what is along and about it",
    };
    let place = |q: &f64| place(kind, *q);
    let [first, second] = homes.each_ref().map(|steps| match steps.as_slice() {
        [low, high] => format!("on the line from {} to {}", place(low), place(high)),
        steps => format!("at {}", steps.iter().map(place).collect::<String>()),
    });
    let not_measured = format!("{axis}: home, {}, was not measured", place(&0.0));
    match first == second {
        true => format!(
            "{not_measured}: {errors} are zero {first} in both calibrations, so that no difference says what has \
             changed between there and home"
        ),
        false => format!(
            "{not_measured} in both calibrations: {errors} are zero {first} in the first, {second} in the second, and \
             all their differences contain what the curves do in between"
        ),
    }
}

/// The checksum of the table of readings that a calibration follows from, if it says so.
fn measured_lengths(path: &Path) -> Option<String> {
    let document: Value = serde_json::from_slice(&std::fs::read(path).ok()?).ok()?;
    let inputs = document["traceability"]["inputs"].as_array()?;
    let table = inputs.iter().find(|input| {
        let name = input["name"].as_str().unwrap_or_default();
        Path::new(name).extension().is_some_and(|e| e == "csv")
    })?;
    table["sha256"].as_str().map(str::to_owned)
}

/// What it amounts to.
fn summary(curves: &[&[Difference]]) -> String {
    if curves.iter().copied().flatten().any(|d| d.u.is_nan()) {
        return "whether any has changed by more than the noise is not known: a calibration has no uncertainties".to_owned();
    }
    let changed = curves
        .iter()
        .filter(|curve| curve.iter().any(Difference::is_change));
    let all = curves.len();
    match changed.count() {
        0 => format!("none of the {all} has changed by more than the noise"),
        1 => format!("1 of the {all} has changed by more than the noise"),
        n => format!("{n} of the {all} have changed by more than the noise"),
    }
}

/// A line for each curve and location error: its largest difference.
fn table(curves: &[&[Difference]]) -> Vec<String> {
    let mut lines = vec!["second - first         largest           U (k = 2)".to_owned()];
    for curve in curves {
        let largest = curve
            .iter()
            .max_by(|a, b| a.value().abs().total_cmp(&b.value().abs()));
        let Some(largest) = largest else { continue };
        let (unit, suffix) = largest.unit();
        let symbol = if suffix == "um" { "µm" } else { "″ " };
        let beyond = curve.iter().filter(|d| d.is_beyond_noise()).count();
        let of_all = format!("at {beyond} of {}", curve.len());
        let said = match beyond {
            0 => String::new(),
            _ if curve[0].follows_from_other_steps => format!("other positions, {of_all}"),
            _ => format!("changed, {of_all}"),
        };
        let expanded = match largest.u.is_nan() {
            true => format!("{:>9}", "unknown"),
            false => format!("{:>9.2} {symbol}", 2.0 * largest.u / unit),
        };
        let line = format!(
            "  {:12} {:>14.2} {symbol} {expanded}  {said}",
            largest.name,
            round(largest.value() / unit, 2),
        );
        lines.push(line.trim_end().to_owned());
    }
    lines
}
