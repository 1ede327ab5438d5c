//! `trueaxis simulate`.

use anyhow::Context;
use trueaxis_files::counted;
use trueaxis_simulate::{Scenario, simulate};

use crate::args::SimulateArgs;
use crate::exit::Exit;
use crate::output;
use crate::summary::named;
use crate::talk::{notice_all, say};

pub(crate) fn run(args: &SimulateArgs) -> anyhow::Result<Exit> {
    let scenario = Scenario::read(&args.scenario)?;
    let simulated =
        simulate(&scenario, args.seed).with_context(|| args.scenario.display().to_string())?;
    let folder = output::folder(args.out.as_deref(), &simulated.campaign.name)?;
    let campaign = trueaxis_campaign::write(&simulated.campaign, &folder)?;
    let truth = folder.join("truth.json");
    simulated.truth.write(&truth)?;
    let lengths = simulated.campaign.lengths.as_ref();
    say(&format!(
        "{}: {}, seed {}",
        named(&simulated.campaign.name),
        counted(
            lengths.map_or(0, |lengths| lengths.readings.len()),
            "length"
        ),
        args.seed
    ));
    notice_all(&simulated.campaign.notices);
    say(&format!(
        "written: {}, {}",
        campaign.display(),
        truth.display()
    ));
    Ok(Exit::Good)
}
