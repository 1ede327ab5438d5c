//! `trueaxis diagnose`.

mod as_truth;
mod causes;
mod in_words;
mod layout;
mod story;

use trueaxis_campaign::{Campaign, checksums};
use trueaxis_compensate::{uncompensated, verify};
use trueaxis_diagnose::{Diagnosis, Settings, diagnose, diagnose_against};
use trueaxis_predict::CalibratedMachine;
use trueaxis_simulate::replay;

use crate::args::DiagnoseArgs;
use crate::exit::Exit;
use crate::given_campaign::read_campaign;
use crate::other_machine::placed;
use crate::output::replaced;
use crate::talk::{notice_all, say_all};
use crate::traceability::{of_calibration, traced};
use crate::verify::mistaken;

/// What was found in the lengths, for `calibrate --with-effects`.
const EFFECTS: &str = "effects.json";

/// The campaign with it, for `simulate`.
const REPLAY: &str = "replay.json";

pub(crate) fn execute(args: &DiagnoseArgs) -> anyhow::Result<Exit> {
    let campaign = read_campaign(&args.campaign, &trueaxis_calibrate::Settings::default())?;
    let mut inputs = checksums(&args.campaign)?;
    let calibration = args.calibration.as_deref();
    let calibration = calibration.map(|path| anyhow::Ok((path, CalibratedMachine::read(path)?)));
    let calibration = calibration.transpose()?;
    if let Some((path, calibration)) = &calibration {
        inputs.extend(of_calibration(path, calibration)?);
    }
    let out = args.result.out.as_deref();
    let replaced = replaced(out, "diagnosis.json", &campaign, &inputs)?;
    let diagnosis = match calibration {
        None => diagnose(&campaign, &Settings::default()),
        Some((path, calibration)) => {
            // What the campaign has none of is said by the diagnosis.
            let verified = verify(&calibration, &campaign, args.compensated);
            let mistakes = mistaken(&verified.unwrap_or_default(), args.compensated);
            let settings = Settings::default();
            let judged = match args.compensated {
                true => {
                    let without = uncompensated(&calibration, &campaign)
                        .map_err(|error| placed(error, path, &args.campaign))?;
                    diagnose_against(&without, &calibration, &settings)
                }
                false => diagnose_against(&campaign, &calibration, &settings),
            };
            judged.map(|diagnosis| with_mistakes(diagnosis, mistakes))
        }
    };
    let calibration = args.calibration.as_deref().unwrap_or(&args.campaign);
    let diagnosis = diagnosis.map_err(|error| placed(error, calibration, &args.campaign))?;
    let text = traced(serde_json::from_str(&diagnosis.to_json())?, &inputs, None)?;
    let mut notices: Vec<String> = campaign.notices.clone();
    notices.extend(diagnosis.notices.iter().cloned());
    notices.extend(replaced);
    let mut files = vec![("diagnosis.json", text.clone())];
    files.extend(extended_model(&campaign, &diagnosis, &mut notices)?);

    let mut results = args.result.folder(&campaign.name)?;
    for (name, text) in &files {
        results.write(name, text.as_bytes())?;
    }
    if !args.no_report {
        results.report()?;
    }
    notices.extend(results.left_from_before(&[EFFECTS, REPLAY], "is of an earlier diagnosis"));

    say_all(story::lines(&diagnosis));
    notice_all(&notices);
    results.end(args.result.json.then_some(&text))?;
    Ok(Exit::of_misfit(
        args.fail_on_misfit && diagnosis.verdict.is_misfit(),
    ))
}

/// A diagnosis that says first what may be mistaken about readings that it judges.
fn with_mistakes(mut diagnosis: Diagnosis, mut mistakes: Vec<(String, String)>) -> Diagnosis {
    mistakes.retain(|(name, _)| diagnosis.levels.iter().any(|level| level.data == *name));
    let said = mistakes
        .into_iter()
        .map(|(name, what)| format!("{name}: {what}"));
    diagnosis.notices.splice(0..0, said);
    diagnosis
}

/// The files of the extended model, if the lengths show causes.
fn extended_model(
    campaign: &Campaign,
    diagnosis: &Diagnosis,
    notices: &mut Vec<String>,
) -> anyhow::Result<Vec<(&'static str, String)>> {
    let effects = diagnosis.effects_file();
    if effects.effects.is_empty() {
        return Ok(Vec::new());
    }
    let mut files = vec![(EFFECTS, effects.to_json()?)];
    let Some(calibration) = &diagnosis.calibration else {
        return Ok(files);
    };
    let replayed = as_truth::truth(calibration, &effects.effects)
        .and_then(|truth| Ok(replay(campaign, &truth)?));
    match replayed {
        Ok(replay) => {
            notices.extend(replay.notices);
            files.push((REPLAY, trueaxis_files::to_json(&replay.scenario)?));
        }
        Err(reason) => notices.push(format!("no {REPLAY} was written: {reason:#}")),
    }
    Ok(files)
}
