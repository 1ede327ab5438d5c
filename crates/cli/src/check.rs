//! `trueaxis check`.

use trueaxis_campaign::{Campaign, read};
use trueaxis_files::counted;
use trueaxis_kinematics::Branch;

use crate::args::CheckArgs;
use crate::exit::Exit;
use crate::output;
use crate::talk::{notice_all, say, say_all};

mod coverage;
mod json;

pub(crate) fn run(args: &CheckArgs) -> anyhow::Result<Exit> {
    let campaign = read(&args.campaign)?;
    describe(&campaign);
    notice_all(&campaign.notices);
    say(&format!("{}: good", args.campaign.display()));
    if args.json {
        output::print(&json::text(&campaign))?;
    }
    Ok(Exit::Good)
}

fn describe(campaign: &Campaign) {
    let machine = &campaign.machine;
    let branch = |branch| {
        let names = machine.branch(branch).iter().map(|&axis| {
            let axis = &machine.axes()[axis];
            format!("{} ({})", axis.name(), axis.kind().name())
        });
        let names: Vec<String> = names.collect();
        if names.is_empty() {
            "none".to_owned()
        } else {
            names.join(", ")
        }
    };
    say(&campaign.name);
    say(&format!("  machine   {}", campaign.machine_name));
    say(&format!(
        "            bed to tool: {}",
        branch(Branch::Tool)
    ));
    say(&format!(
        "            bed to workpiece: {}",
        branch(Branch::Workpiece)
    ));
    say(&format!(
        "  targets   {}",
        list(campaign.targets.iter().map(|target| {
            let carrier = target.carrier.map(|axis| machine.axes()[axis].name());
            format!("{} on {}", target.name, carrier.unwrap_or("the bed"))
        }))
    ));
    if let Some(lengths) = &campaign.lengths {
        say(&format!(
            "  stations  {}",
            list(campaign.stations.iter().map(|s| s.name.clone()))
        ));
        say(&format!(
            "  lengths   {} in {}",
            lengths.readings.len(),
            counted(lengths.stops.len(), "stop")
        ));
    }
    if let Some(points) = &campaign.points {
        say(&format!(
            "  points    {} in {}",
            points.readings.len(),
            counted(points.stops.len(), "stop")
        ));
    }
    for (number, run) in campaign.runs.iter().enumerate() {
        let steps = campaign
            .steps
            .iter()
            .filter(|step| step.run == Some(number))
            .count();
        let axis = machine.axes()[run.axis].name();
        say(&format!(
            "  run       {}: axis {axis}, {}",
            run.name,
            counted(steps, "step")
        ));
    }
    say_all(coverage::lines(campaign));
    for verification in &campaign.verification {
        let readings = counted(verification.readings.len(), "reading");
        say(&format!("  verify    {}: {readings}", verification.name));
    }
    for check in &campaign.point_checks {
        let places = counted(check.readings.len(), "point");
        say(&format!("  verify    {}: {places}", check.name));
    }
}

fn list(names: impl Iterator<Item = String>) -> String {
    names.collect::<Vec<_>>().join(", ")
}
