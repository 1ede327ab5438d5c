//! The adjustment in `calibration.json`.

use serde_json::{Value, json};
use trueaxis_files::{round, significant, without_nulls};
use trueaxis_poses::{
    AdjustmentReport, InterruptedOccupation, NoiseBasis, NoiseReport, PartReport, RejectedLength,
};

use crate::files::unless_empty;
use trueaxis_predict::Unit;

fn um(value_mm: f64) -> f64 {
    Unit::Micrometre.in_file(value_mm)
}

pub(super) fn adjustment(adjustment: &AdjustmentReport) -> Value {
    let noise = adjustment.noise.as_ref();
    without_nulls(json!({
        "observations": adjustment.observations,
        "unknowns": adjustment.unknowns,
        "degrees_of_freedom": adjustment.degrees_of_freedom,
        "noise_declared": (!adjustment.noise_declared).then_some(false),
        "sigma0": round(adjustment.sigma0, 6),
        "p_value": significant(adjustment.p_value),
        "uncertainty_factor": round(adjustment.uncertainty_factor, 6),
        "rms_residual_um": um(adjustment.rms_residual_mm),
        "length_sigma_um": noise.map(|noise| um(noise.length.used.sigma_mm)),
        "repeatability_um": noise.map(|noise| um(noise.repeatability.used.sigma_mm)),
        "noise": noise.map(noise_report),
        "iterations": adjustment.iterations,
        "termination": adjustment.termination,
        "rejected": adjustment.rejected.iter().map(rejected).collect::<Value>(),
        "interruptions": unless_empty(&adjustment.interruptions, interruption),
    }))
}

fn noise_report(noise: &NoiseReport) -> Value {
    let part = |part: &PartReport| {
        without_nulls(json!({
            "declared_um": part.declared_mm.map(um),
            "used_um": um(part.used.sigma_mm),
            "u_um": um(part.used.u_mm),
            "p_value": part.used.p_value.map(significant),
        }))
    };
    without_nulls(json!({
        "basis": match noise.basis {
            NoiseBasis::Given => "declared",
            NoiseBasis::CommonFactor => "one factor from the residuals",
            NoiseBasis::Components => "estimated from the residuals",
        },
        "length_sigma": part(&noise.length),
        "length_sigma_ppm": (noise.length_ppm > 0.0).then(|| round(noise.length_ppm, 6)),
        "repeatability": part(&noise.repeatability),
    }))
}

fn rejected(rejected: &RejectedLength) -> Value {
    let why = match rejected.unchecked {
        false => "contradicts the other lengths",
        true => "unchecked beside a wrong length",
    };
    json!({
        "row": rejected.line,
        "reason": format!("{why}: {}", rejected.length),
        "error_um": um(rejected.error_mm),
        "u_um": um(rejected.u_mm),
    })
}

fn interruption(occupation: &InterruptedOccupation) -> Value {
    json!({
        "station": occupation.station,
        "rows": occupation.lines,
        "times_s": occupation.times_s,
        "change_um": um(occupation.change_mm),
        "u_um": um(occupation.u_mm),
        "cause": occupation.cause(),
    })
}
