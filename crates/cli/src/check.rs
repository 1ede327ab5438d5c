//! `trueaxis check`.

use trueaxis_calibrate::Settings;
use trueaxis_campaign::Campaign;
use trueaxis_files::counted;
use trueaxis_kinematics::Branch;
use trueaxis_poses::missing;
use trueaxis_predict::{GIVE_COMMANDED, positions_are_read_out};

use crate::args::CheckArgs;
use crate::exit::Exit;
use crate::given_campaign::read_campaign;
use crate::output;
use crate::summary::named;
use crate::talk::{notice_all, say, say_all};

mod coverage;
mod json;

pub(crate) fn execute(args: &CheckArgs) -> anyhow::Result<Exit> {
    let campaign = read_campaign(&args.campaign, &Settings::default())?;
    describe(&campaign);
    let mut notices = campaign.notices.clone();
    notices.extend(missing(&campaign));
    notices.extend(read_out(&campaign));
    notice_all(&notices);
    let verdict = match notices.len() {
        0 => "good".to_owned(),
        count => format!("can be read; see the {} above", counted(count, "notice")),
    };
    say(&format!("{}: {verdict}", args.campaign.display()));
    if args.json {
        output::print(&json::text(&campaign, &notices))?;
    }
    Ok(Exit::Good)
}

/// Verifications whose positions are those of encoders, as notices.
pub(crate) fn read_out(campaign: &Campaign) -> Vec<String> {
    let all = campaign.verification.iter();
    let read_out = all.filter(|verification| positions_are_read_out(verification));
    read_out
        .map(|verification| format!("{}: {GIVE_COMMANDED}", verification.name))
        .collect()
}

fn describe(campaign: &Campaign) {
    let machine = &campaign.machine;
    let line = |label: &str, text: &str| say(&format!("  {label:<10}{text}"));
    let measured = |what: &str, readings: usize, stops: usize| {
        line(what, &format!("{readings} in {}", counted(stops, "stop")));
    };
    let branch = |way: &str, branch| {
        let names = machine.branch(branch).iter().map(|&axis| {
            let axis = &machine.axes()[axis];
            format!("{} ({})", axis.name(), axis.kind().name())
        });
        let names = Some(list(names)).filter(|names| !names.is_empty());
        line(
            "",
            &format!("{way}: {}", names.as_deref().unwrap_or("none")),
        );
    };
    say(named(&campaign.name));
    line("machine", &campaign.machine_name);
    branch("bed to tool", Branch::Tool);
    branch("bed to workpiece", Branch::Workpiece);
    let targets = campaign.targets.iter().map(|target| {
        let carrier = target.carrier.map(|axis| machine.axes()[axis].name());
        format!("{} on {}", target.name, carrier.unwrap_or("the bed"))
    });
    if !campaign.targets.is_empty() {
        line("targets", &list(targets));
    }
    if let Some(lengths) = &campaign.lengths {
        let stations = campaign.stations.iter().map(|s| s.name.clone());
        line("stations", &list(stations));
        measured("lengths", lengths.readings.len(), lengths.stops.len());
    }
    if let Some(points) = &campaign.points {
        measured("points", points.readings.len(), points.stops.len());
    }
    for (number, run) in campaign.runs.iter().enumerate() {
        let steps = campaign.steps.iter();
        let steps = steps.filter(|step| step.run == Some(number)).count();
        let (axis, steps) = (machine.axes()[run.axis].name(), counted(steps, "step"));
        line("run", &format!("{}: axis {axis}, {steps}", run.name));
    }
    say_all(coverage::lines(campaign));
    for verification in &campaign.verification {
        let readings = counted(verification.readings.len(), "reading");
        line("verify", &format!("{}: {readings}", verification.name));
    }
    for check in &campaign.point_checks {
        let places = counted(check.readings.len(), "point");
        line("verify", &format!("{}: {places}", check.name));
    }
}

fn list(names: impl Iterator<Item = String>) -> String {
    names.collect::<Vec<_>>().join(", ")
}
