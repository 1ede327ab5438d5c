//! `trueaxis calibrate`.

use anyhow::Context;
use trueaxis_calibrate::{
    Calibration, LengthsReliability, Settings, calibrate, calibrate_for_replay,
    calibrate_with_effects,
};
use trueaxis_campaign::checksums;
use trueaxis_diagnose::{KeptWrongPoint, Rejected, WithoutWrongPoints, without_wrong_points};
use trueaxis_poses::{at_one_temperature, scene_of};
use trueaxis_predict::{FactoredCovariance, OutputCovariance};

use crate::args::CalibrateArgs;
use crate::exit::Exit;
use crate::given_campaign::read_campaign;
use crate::output::replaced;
use crate::talk::{notice, notice_all, say_all};
use crate::{effects_input, summary};

/// Significance at which `--fail-on-misfit` rejects the model.
const MISFIT_LEVEL: f64 = 1e-3;

/// Beside the matrices, the names of their rows and columns.
const COVARIANCE_INDEX: &str = "covariance.json";
const RELIABILITY_INDEX: &str = "reliability.json";

pub(crate) fn execute(args: &CalibrateArgs) -> anyhow::Result<Exit> {
    let settings = Settings {
        covariance: args.covariance,
        ..args.model.settings()
    };
    let campaign = read_campaign(&args.campaign, &settings)?;
    let inputs = checksums(&args.campaign)?;
    let out = args.result.out.as_deref();
    let replaced = replaced(out, "calibration.json", &campaign, &inputs)?;
    let poses = &settings.poses;
    let screened = poses
        .robust
        .then(|| without_wrong_points(&campaign, poses.by_direction));
    let WithoutWrongPoints {
        campaign,
        left_out,
        kept,
    } = screened.flatten().unwrap_or(WithoutWrongPoints {
        campaign,
        left_out: Vec::new(),
        kept: Vec::new(),
    });
    let in_file = || args.campaign.display().to_string();
    let mut extra = Vec::new();
    let mut checked = Vec::new();
    let mut of_effects = Vec::new();
    let mut calibration = if args.reliability {
        let at_one = at_one_temperature(&campaign);
        let (calibration, replay) =
            calibrate_for_replay(&at_one, &settings).with_context(in_file)?;
        if let (Some(found), Some(lengths)) = (replay.reliability()?, &campaign.lengths) {
            let index = found.index_json(replay.results(), lengths);
            extra.push((LengthsReliability::MATRIX_FILE, found.to_npy()));
            extra.push((RELIABILITY_INDEX, index.into_bytes()));
            checked = summary::reliability(&campaign, lengths, &found, replay.results());
        } else {
            notice("reliability is that of lengths; this campaign has points");
        }
        calibration
    } else if let Some(path) = &args.with_effects {
        let effects = effects_input::read(path, &scene_of(&campaign), &campaign.name)?;
        of_effects = effects.notices;
        calibrate_with_effects(&campaign, &effects.resolved, &settings).with_context(in_file)?
    } else {
        calibrate(&campaign, &settings).with_context(in_file)?
    };
    if let Some(covariance) = &calibration.covariance {
        let index = covariance.index_json().into_bytes();
        extra.push((OutputCovariance::MATRIX_FILE, covariance.to_npy()));
        extra.push((COVARIANCE_INDEX, index));
    }
    calibration.traceability.inputs = inputs;
    let mut results = args.result.folder(&campaign.name)?;
    let lines = summary::lines(&campaign, &calibration, args.paper_signs);
    let is_rejected = rejects_the_model(&calibration);
    let left_out = left_out.iter().map(Rejected::in_words);
    let of_points = left_out.chain(kept.iter().map(KeptWrongPoint::in_words));
    calibration.notices.splice(0..0, of_points);
    let notices = [&campaign.notices, &calibration.notices, &of_effects].map(Vec::as_slice);
    let mut notices = notices.concat();
    notices.extend(replaced);
    // Where the first result cannot be written, none is.
    let text = calibration.to_json();
    results.write("calibration.json", text.as_bytes())?;
    let covariance = FactoredCovariance::FILE;
    results.write_beside(
        covariance,
        |out| calibration.write_covariance_npz(out),
        |results| {
            for (name, bytes) in extra {
                results.write(name, &bytes)?;
            }
            results.write_by(Calibration::RESIDUALS_FILE, |out| {
                calibration.write_residuals_csv(&campaign, out)
            })?;
            // The report reads the files: a million lengths need not be in memory twice.
            drop(campaign);
            match args.no_report {
                true => Ok(()),
                false => results.report(),
            }
        },
    )?;

    let matrices = [
        OutputCovariance::MATRIX_FILE,
        COVARIANCE_INDEX,
        LengthsReliability::MATRIX_FILE,
        RELIABILITY_INDEX,
    ];
    notices.extend(results.left_from_before(&matrices, "is of an earlier calibration"));

    say_all(lines.iter().chain(&checked));
    notice_all(&notices);
    results.end(args.result.json.then_some(&text))?;
    Ok(Exit::of_misfit(args.fail_on_misfit && is_rejected))
}

fn rejects_the_model(calibration: &Calibration) -> bool {
    let adjustment = &calibration.adjustment;
    adjustment.p_value < MISFIT_LEVEL
        || adjustment.noise.is_some() && adjustment.uncertainty_factor > 1.0
        || !calibration.misfits.is_empty()
        || !calibration.known_misfits.is_empty()
        || !calibration.turned_runs.is_empty()
        || calibration.axes.iter().any(|axis| axis.runs.is_some())
}
