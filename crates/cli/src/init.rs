//! `trueaxis init`.

mod plan;

use std::path::Path;

use crate::args::{InitArgs, MachineType};
use crate::exit::Exit;
use crate::output;
use crate::talk::say;

pub(crate) fn execute(args: &InitArgs) -> anyhow::Result<Exit> {
    let plan = match args.machine_type {
        MachineType::Fxyz => plan::FXYZ,
        MachineType::FiveAxis => plan::FIVE_AXIS,
        MachineType::RotaryStage => plan::ROTARY_STAGE,
    };
    let kind = if args.points { "points" } else { "lengths" };
    let name = args.folder.canonicalize().ok();
    let name = name.as_deref().unwrap_or(&args.folder).file_name();
    let name = name.map_or_else(|| "machine".into(), |name| name.to_string_lossy());
    let campaign = args.folder.join("campaign.json");
    let template = args.folder.join(format!("{kind}-template.csv"));
    let map = args.folder.join("import.toml");
    let table = plan.table(args.points);
    let schema = args.folder.join("campaign.schema.json");
    // The first one that is there already is named: the campaign is what somebody would miss.
    output::write_all_new(&[
        (&campaign, campaign_text(plan.campaign, &name, args.points)),
        (&template, table.clone()),
        (&map, plan.map(args.points)),
        (&schema, trueaxis_campaign::schema()),
    ])?;
    let rows = table.lines().count() - 1;
    let rows = format!("{rows} rows to measure; fill it in and save it as {kind}.csv");
    let of_map = "what the columns of a tracker's export mean, instead of filling in";
    for (path, what) in [
        (
            &campaign,
            "machine, targets, stations and runs; change what is not so",
        ),
        (&template, rows.as_str()),
        (&map, of_map),
        (&schema, "lets an editor complete and check campaign.json"),
    ] {
        say(&format!("written: {}: {what}", path.display()));
    }
    let out = args.folder.join(format!("{kind}.csv"));
    let [campaign, map, out] = [&campaign, &map, &out].map(|path| argument(path));
    say("next:");
    say(&format!(
        "  trueaxis import {kind} EXPORT.txt --map {map} --out {out}"
    ));
    say(&format!("  trueaxis check {campaign}"));
    say(&format!("  trueaxis calibrate {campaign}"));
    Ok(Exit::Good)
}

/// A path as a shell takes it for one argument.
fn argument(path: &Path) -> String {
    let path = path.display().to_string();
    match path.contains(char::is_whitespace) {
        true => format!("\"{path}\""),
        false => path,
    }
}

/// The template with its name; with points there are no stations.
fn campaign_text(template: &str, name: &str, points: bool) -> String {
    let quoted = serde_json::Value::from(name).to_string();
    let text = template.replace("\"NAME\"", &quoted);
    let text = text.replacen('{', "{\n  \"$schema\": \"campaign.schema.json\",", 1);
    if !points {
        return text;
    }
    let lines = text
        .lines()
        .filter(|line| !line.trim_start().starts_with("\"stations\""));
    let text: String = lines.flat_map(|line| [line, "\n"]).collect();
    // The noise of points stands in their table.
    let text = text
        .replace(" \"length_sigma_um\": 0.269,", "")
        .replace(" \"length_sigma_ppm\": 0.2,", "");
    text.replace("\"lengths\": \"lengths.csv\"", "\"points\": \"points.csv\"")
}
