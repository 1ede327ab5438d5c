//! The adjustment in `calibration.json`.

use serde::Serialize;
use trueaxis_poses::{
    AdjustmentReport, InterruptedTurn, NoiseBasis, NoiseReport, PartReport, RejectedLength,
};

use crate::json::{round, significant, um};

#[derive(Serialize)]
pub(crate) struct AdjustmentFile<'a> {
    observations: usize,
    unknowns: usize,
    degrees_of_freedom: usize,
    sigma0: f64,
    p_value: f64,
    uncertainty_factor: f64,
    rms_residual_um: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    length_sigma_um: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    repeatability_um: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    noise: Option<NoiseFile>,
    iterations: usize,
    termination: &'a str,
    rejected: Vec<RejectedFile>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    interruptions: Vec<InterruptionFile<'a>>,
}

#[derive(Serialize)]
struct NoiseFile {
    basis: &'static str,
    length_sigma: PartFile,
    #[serde(skip_serializing_if = "Option::is_none")]
    length_sigma_ppm: Option<f64>,
    repeatability: PartFile,
}

#[derive(Serialize)]
struct PartFile {
    #[serde(skip_serializing_if = "Option::is_none")]
    declared_um: Option<f64>,
    used_um: f64,
    u_um: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    p_value: Option<f64>,
}

#[derive(Serialize)]
struct RejectedFile {
    row: usize,
    reason: String,
    error_um: f64,
    u_um: f64,
}

#[derive(Serialize)]
struct InterruptionFile<'a> {
    station: &'a str,
    rows: [usize; 2],
    times_s: [f64; 2],
    change_um: f64,
    u_um: f64,
}

impl<'a> AdjustmentFile<'a> {
    pub(crate) fn new(adjustment: &'a AdjustmentReport) -> Self {
        Self {
            observations: adjustment.observations,
            unknowns: adjustment.unknowns,
            degrees_of_freedom: adjustment.degrees_of_freedom,
            sigma0: round(adjustment.sigma0, 6),
            p_value: significant(adjustment.p_value),
            uncertainty_factor: round(adjustment.uncertainty_factor, 6),
            rms_residual_um: um(adjustment.rms_residual_mm),
            length_sigma_um: adjustment.noise.map(|n| um(n.length.used.sigma_mm)),
            repeatability_um: adjustment.noise.map(|n| um(n.machine_return.used.sigma_mm)),
            noise: adjustment.noise.as_ref().map(noise),
            iterations: adjustment.iterations,
            termination: &adjustment.termination,
            rejected: adjustment.rejected.iter().map(rejected).collect(),
            interruptions: adjustment.interruptions.iter().map(interruption).collect(),
        }
    }
}

fn noise(noise: &NoiseReport) -> NoiseFile {
    let part = |part: &PartReport| PartFile {
        declared_um: part.declared_mm.map(um),
        used_um: um(part.used.sigma_mm),
        u_um: um(part.used.u_mm),
        p_value: part.used.p_value.map(significant),
    };
    NoiseFile {
        basis: match noise.basis {
            NoiseBasis::Given => "declared",
            NoiseBasis::CommonFactor => "one factor from the residuals",
            NoiseBasis::Components => "estimated from the residuals",
        },
        length_sigma: part(&noise.length),
        length_sigma_ppm: (noise.length_ppm > 0.0).then(|| round(noise.length_ppm, 6)),
        repeatability: part(&noise.machine_return),
    }
}

fn rejected(rejected: &RejectedLength) -> RejectedFile {
    RejectedFile {
        row: rejected.line,
        reason: match rejected.unchecked {
            false => format!("contradicts the other lengths: {}", rejected.length),
            true => format!("unchecked beside a wrong length: {}", rejected.length),
        },
        error_um: um(rejected.error_mm),
        u_um: um(rejected.u_mm),
    }
}

fn interruption(turn: &InterruptedTurn) -> InterruptionFile<'_> {
    InterruptionFile {
        station: &turn.station,
        rows: turn.lines,
        times_s: turn.times_s,
        change_um: um(turn.change_mm),
        u_um: um(turn.u_mm),
    }
}
