//! Whether the calibration is sound, in one sentence with its reasons.

use serde::Serialize;

use crate::calibration::Calibration;
use crate::causes::changes;
use crate::comparison::Comparison;
use crate::diagnosis::{Diagnosis, Disturbance};
use crate::locations::Measured;
use crate::numbers::{fixed, p_value};
use crate::verification::Verification;
use crate::words;

/// What stands at the top of the page.
#[derive(Serialize)]
pub(crate) struct Verdict {
    /// `good`, `care` or `bad`.
    level: &'static str,
    sentence: String,
    reasons: Vec<String>,
}

/// Significance at which residuals reject the declared noise, as for `--fail-on-misfit`.
const MISFIT_LEVEL: f64 = 1e-3;

impl Verdict {
    pub(crate) fn new(
        calibration: Option<&Calibration>,
        diagnosis: Option<&Diagnosis>,
        verification: Option<&Verification>,
        comparison: Option<&Comparison>,
    ) -> Self {
        let contradiction = calibration.and_then(contradiction);
        let is_only_louder = contradiction.is_none();
        let louder = calibration.and_then(louder).into_iter();
        let mut reasons: Vec<String> = louder.chain(contradiction).collect();
        let consequence = diagnosis.map_or_else(Consequence::default, Consequence::new);
        let diagnosed = diagnosis.map(|diagnosis| (diagnosis.verdict.as_str(), said(diagnosis)));
        let (mut level, mut sentence) = match (&diagnosed, reasons.is_empty()) {
            (Some(("clean", _)), true) => (
                "good",
                "The calibration is sound: nothing in the data contradicts the rigid machine model.",
            ),
            (Some(("clean", _)), false) if is_only_louder => (
                "care",
                "The noise is more than declared; beside it nothing in the data contradicts the rigid machine model.",
            ),
            (Some(("named" | "ambiguous", _)), true) if consequence.is_none_of_it => (
                "care",
                "The data hold more than the rigid machine model, but it changes no result by 0.1 µm.",
            ),
            (Some(("named" | "ambiguous" | "unknown", _)), _) | (_, false) => (
                "bad",
                "The data contradict the rigid machine model: read the reasons before you use the numbers.",
            ),
            (Some(_), true) => (
                "care",
                "The residuals do not contradict the model, but the data could not be judged further.",
            ),
            (None, true) if calibration.is_some_and(is_unchecked) => (
                "care",
                "Nothing checks this measurement: there are no more observations than unknowns.",
            ),
            (None, true) => (
                "good",
                "The residuals agree with the model and the noise; hidden causes were not sought (trueaxis diagnose).",
            ),
        };
        if calibration.is_none() && diagnosis.is_some_and(Diagnosis::is_of_readings) {
            (level, sentence) = match level {
                "good" => (level, "Nothing in the readings contradicts the model."),
                "bad" => (
                    level,
                    "The readings hold more than noise: read the causes before you use them.",
                ),
                _ => (level, "The readings could not be judged."),
            };
        }
        let absurd = calibration.map_or_else(Vec::new, absurd);
        if !absurd.is_empty() {
            if level == "good" {
                (level, sentence) = (
                    "care",
                    "The residuals agree with the model, but no machine has such errors: is it as the campaign describes it?",
                );
            }
            reasons.push(format!("{}: see the notices.", absurd.join(", ")));
        }
        if let Some(taken_out) = calibration.and_then(taken_out) {
            if level == "good" {
                (level, sentence) = (
                    "care",
                    "The residuals agree with the model once effects are taken out: the machine is described as it would be without them.",
                );
            }
            reasons.push(taken_out);
        }
        reasons.extend(diagnosed.map(|(_, said)| said));
        reasons.extend(consequence.said);
        let verified = verification.and_then(Verification::is_misfit);
        if let Some(verification) = verification.filter(|_| verified == Some(true)) {
            let misfits = verification.misfits().join("; ");
            reasons.push(format!(
                "The readings contradict the prediction: {misfits}."
            ));
        }
        if calibration.is_none() && diagnosis.is_none() && verification.is_none() {
            let changed = comparison.and_then(Comparison::changed);
            (level, sentence) = match changed.map(|names| names.is_empty()) {
                Some(true) => ("good", "No change is seen beyond the noise."),
                Some(false) => ("care", "The machine has changed."),
                None => ("care", "Whether the machine has changed is not known."),
            };
        } else if calibration.is_none() && diagnosis.is_none() {
            (level, sentence) = match verified {
                Some(true) => ("bad", "The readings contradict the calibration."),
                Some(false) => ("good", "The readings agree with the calibration."),
                None => (
                    "care",
                    "Whether the readings agree is not judged: no uncertainty is declared.",
                ),
            };
        } else if verified == Some(true) && level == "good" {
            (level, sentence) = (
                "care",
                "The residuals agree with the model, but other readings contradict it.",
            );
        }
        reasons.extend(comparison.map(Comparison::said));
        Self {
            level,
            sentence: sentence.to_owned(),
            reasons,
        }
    }
}

/// What the causes do to the results.
#[derive(Default)]
struct Consequence {
    /// Whether a user sees nothing of it.
    is_none_of_it: bool,
    said: Option<String>,
}

/// Changes that no machine shows, µm.
const UNSEEN_UM: f64 = 0.1;

impl Consequence {
    fn new(diagnosis: &Diagnosis) -> Self {
        let of_model = diagnosis.causes.iter().filter(|cause| !cause.is_of_curve());
        let told: Vec<(Option<f64>, String)> = of_model.map(changes).collect();
        // What one of them says, all together change.
        let Some((_, text)) = told.iter().find(|(most, _)| most.is_some()) else {
            return Self::default();
        };
        let is_unseen = |most: &Option<f64>| most.is_some_and(|um| um < UNSEEN_UM);
        let are_unseen = told.iter().all(|(most, _)| is_unseen(most));
        let mut shares = diagnosis
            .levels
            .iter()
            .map(|level| level.shares.unexplained);
        let is_all = diagnosis.disturbances.is_empty() && shares.all(|share| share <= 0.0);
        Self {
            is_none_of_it: are_unseen && is_all,
            said: Some(format!("Without that the results would differ by: {text}.")),
        }
    }
}

/// Errors above these are more likely mistakes in the campaign, as the notices of `calibrate` say, µm and arcsec.
const ABSURD_UM: f64 = 1e3;
const ABSURD_ARCSEC: f64 = 1e3;

/// Errors that no machine has; offsets of rotary axes may be those of the nests of the targets.
fn absurd(calibration: &Calibration) -> Vec<String> {
    let locations = calibration.location_errors.iter();
    let tilts = locations.filter_map(|(name, error)| {
        let measured = Measured::of(error).filter(|measured| measured.is_angular)?;
        Some((name, measured.value, true))
    });
    let curves = calibration.axes.iter().flat_map(|axis| &axis.components);
    let curves = curves.filter_map(|(name, curve)| {
        let largest = curve.values().iter().copied();
        let largest = largest.max_by(|a, b| a.abs().total_cmp(&b.abs()))?;
        Some((name, largest, curve.is_angular()))
    });
    let is_absurd = |(_, value, is_angular): &(&String, f64, bool)| match is_angular {
        true => value.abs() > ABSURD_ARCSEC,
        false => value.abs() > ABSURD_UM,
    };
    let absurd = tilts.chain(curves).filter(is_absurd);
    let told = absurd.map(|(name, value, is_angular)| match is_angular {
        true => format!("{name} is {}°", fixed(value / 3600.0, 2)),
        false => format!("{name} reaches {} mm", fixed(1e-3 * value, 2)),
    });
    told.collect()
}

fn is_unchecked(calibration: &Calibration) -> bool {
    calibration.adjustment.degrees_of_freedom == 0
}

/// What was taken out of the lengths; lost motion stays in the machine all the same.
fn taken_out(calibration: &Calibration) -> Option<String> {
    let all = &calibration.effects_taken_out;
    let names: Vec<String> = all
        .iter()
        .map(|own| words::effect(&own.effect, &own.subject))
        .collect();
    let kept = match all.iter().any(|own| own.effect.ends_with("backlash")) {
        true => {
            ". The machine still has its lost motion: for its errors in use, calibrate --by-direction without --with-effects"
        }
        false => "",
    };
    (!names.is_empty()).then(|| format!("Taken out of the lengths: {}{kept}.", names.join("; ")))
}

/// That the residuals reject the declared noise.
fn louder(calibration: &Calibration) -> Option<String> {
    let adjustment = &calibration.adjustment;
    let (p, sigma0) = (adjustment.p_value?, adjustment.sigma0?);
    let is_louder = p < MISFIT_LEVEL && !is_unchecked(calibration);
    is_louder.then(|| {
        format!(
            "The residuals are {} times what the declared noise explains ({}).",
            fixed(sigma0, 2),
            p_value(p)
        )
    })
}

/// Steps, runs and known lengths that contradict the rest.
fn contradiction(calibration: &Calibration) -> Option<String> {
    let [first, others @ ..] = calibration.misfits.as_slice() else {
        return None;
    };
    let step = &first.step;
    Some(match others.len() {
        0 => format!("It contradicts the rest: {step}."),
        more => format!(
            "They contradict the rest: {step}, and {more} more (steps, runs or known lengths)."
        ),
    })
}

/// The diagnosis in a sentence.
fn said(diagnosis: &Diagnosis) -> String {
    let of_data = diagnosis.causes.iter().filter(|cause| !cause.is_of_curve());
    let names: Vec<String> = of_data
        .map(|cause| {
            let name = words::effect(&cause.effect, &cause.subject);
            match cause.cannot_tell_apart_from.is_empty() {
                true => name,
                false => format!("{name}, or what cannot be told apart from it"),
            }
        })
        .collect();
    let wanders = diagnosis.disturbances.iter().map(Disturbance::name);
    let wanders: Vec<String> = wanders.collect();
    let (names, wanders) = (names.join("; "), wanders.join("; "));
    match diagnosis.verdict.as_str() {
        "clean" => "Diagnosis: clean, nothing but noise beside the rigid model.".to_owned(),
        "named" | "ambiguous" if is_mostly_wandering(diagnosis) => format!(
            "Diagnosis: most of the misfit is {wanders}, which no known effect explains; beside it {names}."
        ),
        "named" | "ambiguous" => format!("Diagnosis: {names}."),
        "unknown" if !diagnosis.disturbances.is_empty() => {
            format!("Diagnosis: {wanders}; no known effect explains it.")
        }
        "unknown" => {
            "Diagnosis: something is in the data that no known effect explains.".to_owned()
        }
        "not_judged" => {
            "Diagnosis: not judged, since these data cannot contradict the model.".to_owned()
        }
        other => format!("Diagnosis: {other}."),
    }
}

/// Whether what wanders explains more of the squares than causes do, wherever there are causes.
fn is_mostly_wandering(diagnosis: &Diagnosis) -> bool {
    let shares = diagnosis.levels.iter().map(|level| &level.shares);
    let mut with_causes = shares.filter(|shares| !shares.causes.is_empty()).peekable();
    let sum = |of: &[f64]| of.iter().sum::<f64>();
    with_causes.peek().is_some()
        && with_causes.all(|shares| sum(&shares.disturbances) > sum(&shares.causes))
}
