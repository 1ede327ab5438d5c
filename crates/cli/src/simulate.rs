//! `trueaxis simulate`.

use anyhow::Context;
use trueaxis_files::counted;
use trueaxis_simulate::{Scenario, simulate};

use crate::args::SimulateArgs;
use crate::exit::Exit;
use crate::output;
use crate::summary::named;
use crate::talk::{notice_all, say};

pub(crate) fn execute(args: &SimulateArgs) -> anyhow::Result<Exit> {
    let scenario = Scenario::read(&args.scenario)?;
    let simulated =
        simulate(&scenario, args.seed).with_context(|| args.scenario.display().to_string())?;
    let folder = output::folder(args.out.as_deref(), &simulated.campaign.name)?;
    let truth = folder.join("truth.json");
    // A folder that has a truth was simulated; what lies in any other may have been measured.
    if !truth.exists() {
        output::refuse_old(
            ["campaign.json", "lengths.csv", "points.csv"].map(|name| folder.join(name)),
        )?;
    }
    let campaign = trueaxis_campaign::write(&simulated.campaign, &folder)?;
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
        "written: {} with its tables, {}",
        campaign.display(),
        truth.display()
    ));
    Ok(Exit::Good)
}
