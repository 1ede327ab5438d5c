//! The effects for `calibrate --with-effects`: an effects file, or the causes of a diagnosis.

use std::path::Path;

use anyhow::Context;
use serde::Deserialize;
use trueaxis_effects::{
    EffectsFile, GivenEffect, GivenParameter, GivenSubject, ResolvedEffects, Scene,
};

use crate::given_file::read_text;

/// A file of effects that cannot be used.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub(crate) struct EffectsInputError(String);

/// What of `diagnosis.json` says which effects the lengths show; the rest is passed over.
#[derive(Deserialize)]
struct DiagnosisFile {
    campaign: String,
    causes: Vec<CauseFile>,
}

#[derive(Deserialize)]
struct CauseFile {
    effect: String,
    level: String,
    #[serde(default)]
    subject: GivenSubject,
    parameters: Vec<GivenParameter>,
    #[serde(default)]
    covariance: Vec<Vec<f64>>,
}

#[derive(Default, Deserialize)]
#[serde(default)]
struct Header {
    format: String,
    version: u32,
}

const DIAGNOSIS: &str = "trueaxis-diagnosis";

/// Reads effects and finds their names in the scene of the campaign.
pub(crate) fn read(path: &Path, scene: &Scene, campaign: &str) -> anyhow::Result<Effects> {
    let in_file = || path.display().to_string();
    let wrong = |text: String| EffectsInputError(text);
    let wanted = "--with-effects wants an effects.json or a diagnosis.json";
    let text = read_text(path, wanted)?;
    let header: Header = serde_json::from_str(&text)
        .map_err(|error| {
            wrong(format!(
                "this is neither an effects.json nor a diagnosis.json: {error}"
            ))
        })
        .with_context(in_file)?;
    let (mut file, in_part) = if header.format == DIAGNOSIS {
        of_diagnosis(&header, &text).with_context(in_file)?
    } else {
        let file = EffectsFile::from_json(&text).map_err(|error| error.in_file(path))?;
        (file, Vec::new())
    };
    if file.effects.is_empty() {
        let text = match in_part.as_slice() {
            [] => "it has no effects of lengths to take out; calibrate without it".to_owned(),
            in_part => format!(
                "nothing can be taken out: {} is seen in part only, so that the data do not say what it changes in \
                 the calibration",
                in_part.join("; ")
            ),
        };
        return Err(wrong(text)).with_context(in_file);
    }
    let exact = file.covariance.is_none() && !with_uncertainties(&mut file, scene);
    let resolved = file.resolve(scene).map_err(|error| error.in_file(path))?;
    let mut notices = Vec::new();
    let mut notice = |text: &str| notices.push(format!("{}: {text}", path.display()));
    if !in_part.is_empty() {
        notice(&format!(
            "{} is seen in part only and stays in: the data do not say what it changes in the calibration",
            in_part.join("; ")
        ));
    }
    if file.campaign != campaign {
        let other = &file.campaign;
        notice(&format!(
            "the effects were found in another campaign, `{other}`"
        ));
    }
    if resolved
        .effects
        .iter()
        .any(|own| own.effect.is_lost_motion())
    {
        notice(
            "lost motion is taken out, but the machine still has it: for its errors in use, calibrate --by-direction without --with-effects",
        );
    }
    if exact {
        notice("the effects have no uncertainties and are taken as exact");
    }
    Ok(Effects { resolved, notices })
}

/// Effects in the scene of a campaign.
pub(crate) struct Effects {
    pub(crate) resolved: ResolvedEffects,
    pub(crate) notices: Vec<String>,
}

/// The causes in the lengths whose parameters are all seen, as in the `effects.json` of a diagnosis; the others by name.
fn of_diagnosis(
    header: &Header,
    text: &str,
) -> Result<(EffectsFile, Vec<String>), EffectsInputError> {
    if header.version != 1 {
        let found = header.version;
        let text = format!("version: expected 1 of {DIAGNOSIS}, found {found}");
        return Err(EffectsInputError(text));
    }
    let diagnosis: DiagnosisFile =
        serde_json::from_str(text).map_err(|error| EffectsInputError(error.to_string()))?;
    let causes = diagnosis.causes.into_iter();
    let of_lengths = causes.filter(|cause| cause.level == "lengths");
    let (causes, in_part): (Vec<CauseFile>, Vec<CauseFile>) =
        of_lengths.partition(|cause| cause.parameters.iter().all(|p| p.u.is_some()));
    let effects = causes.into_iter().map(|cause| {
        let given = GivenEffect {
            effect: cause.effect,
            subject: cause.subject,
            parameters: cause.parameters,
        };
        (given, cause.covariance)
    });
    let file = EffectsFile::of_independent(diagnosis.campaign, effects);
    let name = |cause: CauseFile| format!("{} ({})", cause.effect, cause.subject.describe());
    Ok((file, in_part.into_iter().map(name).collect()))
}

/// The covariance of a file that gives none: the squares of the given uncertainties, uncorrelated. Whether
/// there are any.
fn with_uncertainties(file: &mut EffectsFile, scene: &Scene) -> bool {
    let mut variances = Vec::new();
    for given in &file.effects {
        let Ok(resolved) = given.resolve(scene) else {
            // Said when the file is resolved.
            return true;
        };
        let names = resolved.effect.parameters(scene, &resolved.subject);
        let linear = given
            .parameters
            .iter()
            .filter(|p| names.iter().any(|name| name.name == p.name));
        variances.extend(linear.map(|p| p.u.unwrap_or(0.0).powi(2)));
    }
    let any = variances.iter().any(|v| *v > 0.0);
    let row = |i: usize| {
        let mut row = vec![0.0; variances.len()];
        row[i] = variances[i];
        row
    };
    file.covariance = any.then(|| (0..variances.len()).map(row).collect());
    any
}
