//! `trueaxis calibrate`.

use anyhow::Context;
use trueaxis_calibrate::{Calibration, Method, Settings, calibrate};
use trueaxis_campaign::read;
use trueaxis_identify::SixRows;

use crate::args::{CalibrateArgs, MethodArg};
use crate::exit::Exit;
use crate::talk::{notice, say};
use crate::{output, summary};

/// Significance at which `--fail-on-misfit` rejects the model.
const MISFIT_LEVEL: f64 = 1e-3;

pub(crate) fn run(args: &CalibrateArgs) -> anyhow::Result<Exit> {
    let campaign = read(&args.campaign)?;
    let settings = Settings {
        method: match args.method {
            MethodArg::Nine => Method::Nine,
            MethodArg::Six => Method::Six(SixRows::PAPER),
        },
        by_direction: args.by_direction,
        reference_point: args.reference_point,
    };
    let calibration =
        calibrate(&campaign, &settings).with_context(|| args.campaign.display().to_string())?;
    let folder = output::folder(args.out.as_deref(), &campaign.name)?;
    let path = folder.join("calibration.json");
    let text = calibration.to_json();
    output::write(&path, &text)?;

    for line in summary::lines(&campaign, &calibration, args.paper_signs) {
        say(&line);
    }
    for text in campaign.notices.iter().chain(&calibration.notices) {
        notice(text);
    }
    say(&format!("written: {}", path.display()));
    if args.json {
        output::print(&text)?;
    }
    if args.fail_on_misfit && rejects_the_model(&calibration) {
        say("the data reject the model (--fail-on-misfit)");
        return Ok(Exit::Misfit);
    }
    Ok(Exit::Good)
}

fn rejects_the_model(calibration: &Calibration) -> bool {
    calibration.adjustment.p_value < MISFIT_LEVEL || !calibration.misfits.is_empty()
}
