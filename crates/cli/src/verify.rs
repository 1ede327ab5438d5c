//! `trueaxis verify`.

use serde_json::json;
use trueaxis_campaign::{VerificationKind, checksums};
use trueaxis_compensate::{
    Circular, EXPECTED_ABOVE_ONE, ParallelLines, Point, Positioning, Verified, parallel_lines,
    verification_json, verify, verify_notices,
};
use trueaxis_files::{counted, p_value};
use trueaxis_kinematics::ARCSEC;
use trueaxis_predict::CalibratedMachine;

use crate::args::VerifyArgs;
use crate::check::read_out;
use crate::exit::Exit;
use crate::other_machine::placed;
use crate::output::replaced;
use crate::predict::source;
use crate::talk::{notice_all, say_all};
use crate::traceability::{of_calibration, traced};

pub(crate) fn execute(args: &VerifyArgs) -> anyhow::Result<Exit> {
    let machine = CalibratedMachine::read(&args.calibration)?;
    let campaign = trueaxis_campaign::read(&args.campaign)?;
    let mut inputs = of_calibration(&args.calibration, &machine)?;
    inputs.extend(checksums(&args.campaign)?);
    let out = args.result.out.as_deref();
    let replaced = replaced(out, "verification.json", &campaign, &inputs)?;
    let verified = verify(&machine, &campaign, args.compensated);
    let verified = verified.map_err(|error| placed(error, &args.calibration, &args.campaign))?;
    let parallel = parallel_lines(&machine, &verified, args.compensated);
    let mut document = verification_json(
        &machine,
        &campaign.name,
        args.compensated,
        &verified,
        &parallel,
    );
    let mut notices = campaign.notices.clone();
    notices.extend(read_out(&campaign));
    notices.extend(verify_notices(&machine, &verified, args.compensated));
    let mistakes = mistaken(&verified, args.compensated).into_iter();
    notices.extend(mistakes.map(|(name, what)| format!("{name}: {what}")));
    if !notices.is_empty() {
        document["notices"] = json!(notices);
    }
    let text = traced(document, &inputs, None)?;
    let mut results = args.result.folder(&campaign.name)?;
    results.write("verification.json", text.as_bytes())?;
    if !args.no_report {
        results.report()?;
    }

    say_all(source(&machine));
    let of_entry = |entry| lines(entry, args.compensated);
    say_all(verified.iter().flat_map(of_entry));
    say_all(parallel.iter().flat_map(|found| angles(&machine, found)));
    notice_all(notices.iter().chain(&replaced));
    results.end(args.result.json.then_some(&text))?;
    let is_rejected = verified.iter().any(Verified::is_misfit);
    Ok(Exit::of_misfit(args.fail_on_misfit && is_rejected))
}

/// What may be mistaken about readings that contradict their prediction, with the name of each verification.
pub(crate) fn mistaken(verified: &[Verified], is_compensated: bool) -> Vec<(String, String)> {
    let found = verified.iter().filter_map(|entry| {
        let mistaken = entry.mistaken(is_compensated)?;
        Some((entry.name.clone(), mistaken.in_words().to_owned()))
    });
    found.collect()
}

fn lines(entry: &Verified, is_compensated: bool) -> Vec<String> {
    let kind = match entry.kind {
        Some(VerificationKind::Positioning { .. }) => "positioning",
        Some(VerificationKind::Ballbar { .. }) => "ball bar",
        None => "point checks",
    };
    let places = match entry.kind {
        Some(_) if entry.points.len() == 1 => "1 position".to_owned(),
        Some(_) => format!("{} positions and sides", entry.points.len()),
        None => counted(entry.points.len(), "coordinate"),
    };
    let readings = entry.points.iter().map(|point| point.readings).sum();
    let mut lines = vec![format!(
        "{}: {kind}, {} at {places}; zero or set-up fitted out",
        entry.name,
        counted(readings, "reading")
    )];
    let columns: [fn(&Point) -> f64; 3] =
        [|p| p.reading_um, |p| p.predicted_um, |p| p.compensated_um];
    let [read, without, with] = columns.map(|of| range(entry.points.iter().map(of)));
    let u = entry.points.iter().map(|point| point.u_prediction_um);
    let u = match u.clone().any(f64::is_nan) {
        true => "u of the predictions is not known".to_owned(),
        false => format!("largest u of a prediction {:.2}", u.fold(0.0, f64::max)),
    };
    lines.push(format!(
        "  range, µm            read {read:.2}; predicted {without:.2}, with compensation {with:.2}; {u}"
    ));
    // More than the last digit shows.
    if with > without + 0.005 {
        lines.push(
            "                       compensation corrects the tool against the workpiece; seen from where this reads, the axis then moves more"
                .to_owned(),
        );
    }
    let squares = entry.points.iter().map(|point| {
        let predicted = if is_compensated {
            point.compensated_um
        } else {
            point.predicted_um
        };
        (point.reading_um - predicted).powi(2)
    });
    let rms = (squares.sum::<f64>() / entry.points.len().max(1) as f64).sqrt();
    let (above, all) = entry.above_one();
    let judged = match all {
        0 if entry.points.iter().any(|p| p.u_prediction_um.is_nan()) => {
            "without uncertainties there is no E_n".to_owned()
        }
        0 if entry.points.iter().any(|p| p.u_reading_um.is_some()) => {
            "nothing is left to compare beside the zero or the set-up".to_owned()
        }
        0 => "no u_um is declared, so there is no E_n".to_owned(),
        _ => format!(
            "|E_n| above 1 at {above} of {all} (expected {:.1}{}): {}",
            EXPECTED_ABOVE_ONE * all as f64,
            entry
                .p_value
                .map_or_else(String::new, |p| format!("; {}", p_value(p))),
            if entry.is_misfit() {
                "more than chance"
            } else {
                "agrees"
            }
        ),
    };
    lines.push(format!("  read - predicted     rms {rms:.2} µm; {judged}"));
    for (_, positioning) in &entry.positioning {
        lines.extend(iso_230_2(positioning));
    }
    lines.extend(entry.circular.as_ref().map(iso_230_4));
    lines
}

/// Largest less smallest.
fn range(values: impl Iterator<Item = f64> + Clone) -> f64 {
    values.clone().fold(f64::MIN, f64::max) - values.fold(f64::MAX, f64::min)
}

/// Pitch and yaw from parallel lines.
fn angles(machine: &CalibratedMachine, found: &ParallelLines) -> Vec<String> {
    let name = machine.machine().axes()[found.axis].name();
    let mut lines = vec![format!(
        "angles of {name} from {} parallel lines ({}), at {}; mean taken out, as each line has a zero of its own",
        found.lines.len(),
        found.lines.join(", "),
        counted(found.positions.len(), "position")
    )];
    for curve in &found.angles {
        let range = |values: &[f64]| range(values.iter().copied()) / ARCSEC;
        let u = match curve.u_largest() {
            Some(u) => format!("; U of that {:.2}″ (k = 2)", 2.0 * u / ARCSEC),
            None => String::new(),
        };
        lines.push(format!(
            "  {}, range, ″         read {:.2}; predicted {:.2}; they differ by {:.2}″ at most{u}",
            curve.component.name(name),
            range(&curve.measured),
            range(&curve.predicted),
            curve.largest_difference() / ARCSEC
        ));
    }
    lines
}

fn iso_230_2(found: &Positioning) -> Vec<String> {
    let value = |value: Option<f64>| value.map_or("–".to_owned(), |value| format!("{value:.2}"));
    let short = match found.is_short {
        true if found.passes == 1 => " (only 1 pass a side, the standard wants five)".to_owned(),
        true => format!(
            " (only {} passes a side, the standard wants five)",
            found.passes
        ),
        false => String::new(),
    };
    let mut lines = vec![format!(
        "  ISO 230-2, µm        B {}, mean B {}, M {}{short}",
        value(found.b_um),
        value(found.mean_b_um),
        value(found.m_um)
    )];
    for (name, side) in ["forward", "backward", "both"].iter().zip(&found.sides) {
        if let Some(side) = side {
            lines.push(format!(
                "    {name:18} A {}, E {:.2}, R {}",
                value(side.a_um),
                side.e_um,
                value(side.r_um)
            ));
        }
    }
    lines
}

fn iso_230_4(found: &Circular) -> String {
    let parts = [
        ("G forward", found.g_forward_um),
        ("G backward", found.g_backward_um),
        ("G(b)", found.g_both_um),
        ("H", found.h_um),
        ("F forward min", found.f_forward_um.map(|f| f[0])),
        ("max", found.f_forward_um.map(|f| f[1])),
        ("F backward min", found.f_backward_um.map(|f| f[0])),
        ("max", found.f_backward_um.map(|f| f[1])),
        ("D", found.d_um),
    ];
    let parts = parts
        .iter()
        .filter_map(|(name, value)| Some(format!("{name} {:.2}", (*value)?)));
    format!(
        "  ISO 230-4, µm        {}",
        parts.collect::<Vec<_>>().join(", ")
    )
}
