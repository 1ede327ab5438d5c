//! `trueaxis volume`.

use serde_json::{Value, json};
use trueaxis_compensate::{Remains, Sizes, remains};
use trueaxis_files::{counted, point_mm, round};
use trueaxis_kinematics::{ARCSEC, AxisKind, MICROMETRE};
use trueaxis_predict::{CalibratedMachine, Figure, Volume, VolumeSettings};
use trueaxis_report::Report;

use crate::args::VolumeArgs;
use crate::exit::Exit;
use crate::predict::source;
use crate::talk::{notice, say_all};
use crate::traceability::{of_calibration, traced};

/// Shares that are listed.
const MOST_LISTED: usize = 6;

pub(crate) fn execute(args: &VolumeArgs) -> anyhow::Result<Exit> {
    let machine = CalibratedMachine::read(&args.calibration)?;
    let volume = machine.volume(&VolumeSettings {
        points: args.points.into(),
        tool_home_mm: args.tool.unwrap_or(machine.reference_point_mm()),
        draws: args.draws.into(),
        seed: args.seed,
    });
    let after = remains(&machine, &volume.places)?;
    let text = traced(
        with_after(&volume.to_json(&machine), &after)?,
        &of_calibration(&args.calibration, &machine)?,
        Some(args.seed),
    )?;
    let map = volume.map(&machine);
    let mut files = vec![("volume.json", text.clone())];
    let has_map = volume.places.grid.iter().any(Option::is_some);
    if has_map {
        files.push(("volumetric.csv", volume.map_csv(&machine, &map)));
        files.push(("volumetric.vti", volume.map_vti(&map)));
    }

    let mut results = args.result.folder(&machine.campaign)?;
    for (name, text) in &files {
        results.write(name, text.as_bytes())?;
    }
    // A page of the results that is there shows it from now on.
    if results.folder.join(Report::FILE).exists() {
        results.report()?;
    }
    say_all(source(&machine).into_iter().chain(lines(&machine, &volume)));
    say_all(after_lines(&after));
    if !has_map {
        notice("no map was written: no linear axis was measured");
    }
    results.end(args.result.json.then_some(&text))?;
    Ok(Exit::Good)
}

fn lines(machine: &CalibratedMachine, volume: &Volume) -> Vec<String> {
    let mut lines = vec![
        format!(
            "{}; tool point {} at home{}",
            counted(volume.places.count(), "place"),
            point_mm(volume.places.tool_home_mm.into()),
            match volume.figures.zeroed_at_home.rms.drawn {
                Some(_) => "; in brackets 95 % intervals",
                None => "",
            }
        ),
        "volumetric error, µm              rms                  95 %               largest"
            .to_owned(),
    ];
    let figures = &volume.figures;
    for (what, sizes) in [
        ("zero at home", &figures.zeroed_at_home),
        ("after the best fit", &figures.best_fit),
    ] {
        let [rms, p95, max] = [sizes.rms, sizes.p95, sizes.max].map(|f| figure(&f, MICROMETRE));
        lines.push(format!("  {what:20} {rms:>20} {p95:>20} {max:>20}"));
    }
    for (what, first, unit) in [
        ("range X Y Z, µm", 0, MICROMETRE),
        ("range A B C, ″", 3, ARCSEC),
    ] {
        let [a, b, c] = [0, 1, 2].map(|i| figure(&figures.ranges[first + i], unit));
        lines.push(format!("  {what:20} {a:>20} {b:>20} {c:>20}"));
    }
    if let Some(drawn) = figures.zeroed_at_home.max.drawn {
        lines.push(format!(
            "  bias of the largest error by the noise of the calibration: {:.2} µm; it is taken off the intervals",
            drawn.bias / MICROMETRE
        ));
    }
    let axes = machine.machine().axes().iter().zip(&volume.worst);
    let at = axes.map(|(axis, &q)| match axis.kind() {
        AxisKind::Linear => format!("{} {q:.1}", axis.name()),
        AxisKind::Rotary => format!("{} {:.1}°", axis.name(), q.to_degrees()),
    });
    let e = volume.worst_error.translation_mm / MICROMETRE;
    lines.push(format!(
        "  worst place          {}: {:+.2}, {:+.2}, {:+.2} µm",
        at.collect::<Vec<_>>().join(", "),
        e.x,
        e.y,
        e.z
    ));
    let mut shares: Vec<_> = volume.shares.iter().collect();
    shares.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
    let listed = shares.iter().take(MOST_LISTED);
    let listed = listed.map(|(name, share)| format!("{name} {:.0} %", 100.0 * share));
    lines.push(format!(
        "  mean square          {}",
        listed.collect::<Vec<_>>().join(", ")
    ));
    lines
}

fn figure(figure: &Figure, unit: f64) -> String {
    let value = figure.value / unit;
    figure.drawn.map_or_else(
        || format!("{value:.2}"),
        |drawn| {
            let [low, high] = drawn.interval.map(|x| x / unit);
            format!("{value:.2} ({low:.2} … {high:.2})")
        },
    )
}

/// Decimals of µm and ″.
const DECIMALS: i32 = 4;

/// The document with what the best compensation leaves.
fn with_after(text: &str, after: &Remains) -> serde_json::Result<Value> {
    let um = |mm: f64| round(mm / MICROMETRE, DECIMALS);
    let arcsec = |rad: f64| round(rad / ARCSEC, DECIMALS);
    let left = |left: &Sizes| {
        json!({
            "rms_um": um(left.rms_mm),
            "max_um": um(left.max_mm),
            "rotation_rms_arcsec": arcsec(left.rotation_rms_rad),
            "rotation_max_arcsec": arcsec(left.rotation_max_rad),
        })
    };
    let mut document: Value = serde_json::from_str(text)?;
    document["after"] = json!({
        "places": after.places,
        "linear_axes_corrected": left(&after.linear),
        "all_axes_corrected": left(&after.all),
        "u_rms_um": um(after.u_rms_mm),
        "u_max_um": um(after.u_max_mm),
    });
    Ok(document)
}

fn after_lines(after: &Remains) -> Vec<String> {
    let line = |what: &str, left: &Sizes| {
        format!(
            "  {what:22} rms {:.2}, largest {:.2} µm; rotation rms {:.2}, largest {:.2}″",
            left.rms_mm / MICROMETRE,
            left.max_mm / MICROMETRE,
            left.rotation_rms_rad / ARCSEC,
            left.rotation_max_rad / ARCSEC
        )
    };
    let mut lines = vec!["the best compensation leaves, of the errors as calibrated".to_owned()];
    lines.push(line("linear axes corrected", &after.linear));
    if after.linear != after.all {
        lines.push(line("all axes corrected", &after.all));
    }
    if after.u_rms_mm.is_nan() {
        lines.push("  and what the calibration does not know: its uncertainties are not stated (import calibration: --u-um)".to_owned());
        return lines;
    }
    lines.push(format!(
        "  and what the calibration does not know: u rms {:.2}, largest {:.2} µm (k = 1)",
        after.u_rms_mm / MICROMETRE,
        after.u_max_mm / MICROMETRE
    ));
    lines
}
