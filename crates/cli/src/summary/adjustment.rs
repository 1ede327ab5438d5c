//! How the measurement was adjusted, as the table says it.

use trueaxis_calibrate::Calibration;
use trueaxis_files::{p_value, round};
use trueaxis_kinematics::MICROMETRE;
use trueaxis_poses::{NoiseReport, PartReport, ScaleBasis};
use trueaxis_predict::coverage_factor;

use crate::summary::{COVERAGE, MOST_LISTED, first_ones, named};

/// How the measurement was adjusted, and with which noise.
pub(crate) fn adjustment(calibration: &Calibration) -> Vec<String> {
    let a = &calibration.adjustment;
    let what = if calibration.stations.is_empty() {
        "coordinates"
    } else {
        "lengths"
    };
    let mut lines = vec![
        format!(
            "{}: {} {what}, {} unknowns, redundancy {}",
            named(&calibration.campaign),
            a.observations,
            a.unknowns,
            a.degrees_of_freedom
        ),
        format!(
            "{}rms residual {:.2} µm; {}",
            match a.noise_declared {
                true => format!("sigma0 {:.3} ({}), ", a.sigma0, p_value(a.p_value)),
                false => String::new(),
            },
            a.rms_residual_mm / MICROMETRE,
            coverage(calibration)
        ),
    ];
    if !calibration.effects.is_empty() {
        let effects = calibration.effects.iter();
        let names =
            effects.map(|e| format!("{} ({})", e.effect.replace('_', " "), e.subject.describe()));
        let names: Vec<String> = names.collect();
        lines.push(format!(
            "taken out of the lengths before: {}",
            names.join("; ")
        ));
    }
    lines.extend(a.noise.as_ref().map(noise));
    lines.extend(reflectors(calibration));
    lines.extend(scale(calibration));
    lines.push(uncertainty(calibration));
    for occupation in &a.interruptions {
        lines.push(format!(
            "{}: the lengths jump by {:+.2} ± {:.2} µm between lines {} and {} ({:.0} … {:.0} s): {}; its occupation is \
             split there",
            occupation.station,
            occupation.change_mm / MICROMETRE,
            COVERAGE * occupation.u_mm / MICROMETRE,
            occupation.lines[0],
            occupation.lines[1],
            occupation.times_s[0],
            occupation.times_s[1],
            occupation.cause(),
        ));
    }
    if !a.rejected.is_empty() {
        lines.push(format!(
            "removed: {} of {} lengths that contradict the others",
            a.rejected.len(),
            a.rejected.len() + a.observations
        ));
        let elsewhere = ", all in calibration.json";
        lines.extend(first_ones(&a.rejected, elsewhere, |rejected| {
            format!(
                "  {}: {:+.2} ± {:.2} µm{}",
                rejected.length,
                rejected.error_mm / MICROMETRE,
                COVERAGE * rejected.u_mm / MICROMETRE,
                match rejected.unchecked {
                    true => ", unchecked beside a wrong one",
                    false => "",
                }
            )
        }));
    }
    lines
}

/// The constants of the reflectors, if they are few enough for a line.
fn reflectors(calibration: &Calibration) -> Option<String> {
    let constants = calibration.reflectors.iter().take(MOST_LISTED);
    let constants: Vec<String> = constants
        .map(|reflector| {
            let (value, u) = (reflector.constant_mm, COVERAGE * reflector.u_mm);
            let [value, u] = [value, u].map(|x| x / MICROMETRE);
            format!("{} {value:+.2} ± {u:.2} µm", reflector.name)
        })
        .collect();
    let more = match calibration.reflectors.len().checked_sub(MOST_LISTED + 1) {
        Some(more) => format!(" and {} more in calibration.json", more + 1),
        None => String::new(),
    };
    let relative = match calibration.reflectors_are_relative {
        true => " (relative to their mean)",
        false => "",
    };
    (!constants.is_empty()).then(|| {
        format!(
            "reflector constants{relative}: {}{more}",
            constants.join(", ")
        )
    })
}

/// The scale of all lengths, if it is an unknown.
fn scale(calibration: &Calibration) -> Option<String> {
    let scale = calibration.scale?;
    let [value, u] = [scale.value, COVERAGE * scale.u].map(|x| x * 1e6);
    Some(match scale.basis {
        ScaleBasis::Declared => format!("scale of the lengths: as shown, ± {u:.2} ppm as declared"),
        ScaleBasis::KnownLengths | ScaleBasis::Both => format!(
            "scale of the lengths: shown too {} by {:.2} ± {u:.2} ppm, by known lengths; the results are free of it",
            if value < 0.0 { "short" } else { "long" },
            value.abs()
        ),
    })
}

/// What the uncertainties contain.
fn uncertainty(calibration: &Calibration) -> String {
    let statement = &calibration.uncertainty;
    let lacks = match statement.lacks.is_empty() {
        true => String::new(),
        false => format!("; it lacks {}", statement.lacks.join("; ")),
    };
    format!("U contains {}{lacks}", statement.contains.join(", "))
}

/// What the uncertainties are multiplied with.
fn coverage(calibration: &Calibration) -> String {
    let of_axes = calibration.axes.iter().flat_map(|axis| {
        let components = axis.nodes.iter().flat_map(|node| node.dof);
        components.chain(axis.location_errors.iter().map(|location| location.dof))
    });
    let least = of_axes.fold(f64::INFINITY, f64::min);
    let factor = round(coverage_factor(least), 2);
    if factor > COVERAGE {
        format!("U is for 95 % (Student): k = {COVERAGE} to {factor}")
    } else {
        format!("U is for k = {COVERAGE}")
    }
}

/// The noise used, beside the declared one.
fn noise(noise: &NoiseReport) -> String {
    let part = |part: &PartReport| {
        let mut text = format!("{:.3}", part.used.sigma_mm / MICROMETRE);
        if part.used.u_mm > 0.0 {
            text.push_str(&format!(" ± {:.3}", COVERAGE * part.used.u_mm / MICROMETRE));
        }
        text.push_str(" µm");
        if let Some(declared) = part.declared_mm {
            text.push_str(&format!(" (declared {:.3})", declared / MICROMETRE));
        }
        text
    };
    let proportional = match noise.length_ppm > 0.0 {
        true => format!(" and {:.3} µm/m", noise.length_ppm),
        false => String::new(),
    };
    format!(
        "noise: length {}{proportional}, repeatability {}",
        part(&noise.length),
        part(&noise.repeatability)
    )
}
