//! What a diagnosis says about its causes.

use trueaxis_diagnose::{Cause, Change, EstimatedParameter, LevelReport, Rival};
use trueaxis_effects::{ResolvedEffect, Scene};

use crate::diagnose::in_words;
use crate::diagnose::layout::labelled;

/// Changes of the calibration that are listed.
const MOST_CHANGES: usize = 4;

/// Changes below this are none, µm.
const WORTH_A_WORD_UM: f64 = 0.01;

/// Rivals that are listed.
const MOST_RIVALS: usize = 3;

/// A cause of a misfit: what, how much, how sure, what else, what it changes, what to do.
pub(crate) fn of_misfit(
    cause: &Cause,
    rank: Option<usize>,
    with_changes: bool,
    scene: &Scene,
) -> Vec<String> {
    let explanation = cause.explanation();
    let several = rank.is_some();
    let rank = rank.map(|rank| format!(" {rank}")).unwrap_or_default();
    let name = in_words::effect(&cause.effect, scene);
    let or_another = match cause.rivals.is_empty() || is_clear_but_for_its_form(cause) {
        true => "",
        false => ", or another",
    };
    let mut lines = vec![format!("cause{rank}: {name}{or_another}")];
    let mut tell = |label: &str, text: &str| lines.extend(labelled(label, text));
    tell("seen in", &cause.data.join(", "));
    tell("what", explanation.cause);
    let mut size = in_words::parameters(&cause.told_parameters());
    if let Some(share) = cause.share {
        size += &format!("; {} of the misfit, in squares", in_words::percent(share));
    }
    tell("size", &size);
    if let Some(curve) = in_words::curve(cause) {
        tell("along it", &curve);
    }
    if let Some(note) = cause.note() {
        tell("in each", &note);
    }
    if let Some(follows) = cause.follows(scene) {
        let where_it_is = if follows.is_plausible {
            "in"
        } else {
            "outside"
        };
        let [low, high] = follows.range;
        let text = format!(
            "{} as it was logged; the coefficient is {where_it_is} its plausible range of {low} to {high}{}",
            follows.column,
            in_words::unit(follows.unit)
        );
        tell("goes with", &text);
    }
    tell("certainty", &in_words::certainty(cause.p_value));
    tell("or else", &rivals(cause, scene));
    if is_clear_but_for_its_form(cause) {
        tell("to separate", MORE_OF_BOTH_SIDES);
    } else if !cause.rivals.is_empty() {
        tell("to separate", explanation.separate_by);
    }
    tell("calibration", &changes(cause, with_changes, several));
    tell("to do", explanation.action);
    lines
}

/// Whether all that is open of a lost motion is whether it is the same all along the axis.
pub(crate) fn is_clear_but_for_its_form(cause: &Cause) -> bool {
    let is_form = |effect: &ResolvedEffect| {
        effect.effect.is_lost_motion() && effect.subject == cause.effect.subject
    };
    let is_other_form = |rival: &Rival| match rival {
        Rival::Effect { effect, .. } => is_form(effect),
        Rival::Disturbance { .. } => false,
    };
    let mut rivals = cause.rivals.iter();
    !cause.rivals.is_empty() && is_form(&cause.effect) && rivals.all(is_other_form)
}

/// What tells one lost motion from one that changes along the axis.
const MORE_OF_BOTH_SIDES: &str =
    "read more positions of the axis from both sides, or the same in more cycles";

fn rivals(cause: &Cause, scene: &Scene) -> String {
    if is_clear_but_for_its_form(cause) {
        return "nothing else that is known; whether it is the same all along the axis is open"
            .to_owned();
    }
    if cause.rivals.is_empty() {
        return "nothing else that is known explains the data nearly as well".to_owned();
    }
    let more = match cause.rivals.len().saturating_sub(MOST_RIVALS) {
        0 => String::new(),
        more => format!(" or {more} more"),
    };
    let names = names_of_rivals(cause, scene);
    format!("these data cannot tell it from {names}{more}")
}

/// The first of the rivals.
fn names_of_rivals(cause: &Cause, scene: &Scene) -> String {
    let name = |rival: &Rival| match rival {
        Rival::Effect { effect, .. } => in_words::effect(effect, scene),
        Rival::Disturbance { whose, .. } => {
            format!("something of no known form: {}", whose.in_words(scene))
        }
    };
    let rivals = cause.rivals.iter().take(MOST_RIVALS);
    rivals.map(name).collect::<Vec<_>>().join(" or ")
}

/// The largest changes, and the consequence of leaving the cause in.
fn changes(cause: &Cause, with_changes: bool, several: bool) -> String {
    let consequence = cause.explanation().consequence;
    let mut changes: Vec<&Change> = cause.changes.iter().collect();
    if changes.is_empty() || !with_changes {
        return consequence.to_owned();
    }
    if changes.iter().all(|c| size_um(c) < WORTH_A_WORD_UM) {
        return format!(
            "hardly changes (by less than {WORTH_A_WORD_UM} µm); left in: {consequence}"
        );
    }
    changes.sort_by(|a, b| size_um(b).total_cmp(&size_um(a)));
    let listed = changes.iter().take(MOST_CHANGES).map(|change| {
        let (largest, unit) = match change.unit {
            "mm" => (change.largest * 1e3, "um"),
            unit => (change.largest, unit),
        };
        format!("{} {largest:.2}{}", change.name, in_words::unit(unit))
    });
    let listed: Vec<String> = listed.collect();
    format!(
        "taking {} out changes the results by at most {}; left in: {consequence}",
        if several { "all causes" } else { "it" },
        listed.join(", ")
    )
}

/// Angles at an arm of half a metre, to compare them with displacements.
fn size_um(change: &Change) -> f64 {
    match change.unit {
        "arcsec" => change.largest * 2.4,
        "mm" => change.largest * 1e3,
        _ => change.largest,
    }
}

/// The part of the misfit beyond the noise that is gone; nothing where there was none beyond it.
fn of_excess(share: f64) -> String {
    match share > 0.0 {
        true => format!(
            "; {:.0} % of the misfit beyond the noise is gone",
            100.0 * share
        ),
        false => String::new(),
    }
}

/// What was gained on unused data.
pub(crate) fn gained(level: &LevelReport, of_several: bool) -> Vec<String> {
    let data = match of_several {
        true => format!("{}: ", level.data),
        false => String::new(),
    };
    let Some(gain) = &level.gain else {
        let between_runs = level.tests.iter().all(|test| test.varies_with == "run");
        let text = match between_runs {
            true => {
                "not measured: the runs are compared with each other, none was left out to be predicted"
            }
            false => "not measured: too few repeats to leave some out",
        };
        return labelled("gained", &(data + text));
    };
    let [low, high] = gain.interval;
    let mut text = if gain.is_claimed() {
        format!(
            "data that the model was not fitted to are predicted {:.0} % better ({:.0} to {:.0} %){}",
            100.0 * (1.0 - gain.heldout_rms_ratio),
            100.0 * (1.0 - high),
            100.0 * (1.0 - low),
            of_excess(gain.share_of_excess_removed),
        )
    } else {
        format!(
            "could not be shown: on unused data the misfit is {:.3} times what it was ({low:.3} to \
             {high:.3})",
            gain.heldout_rms_ratio
        )
    };
    if let Some(out) = gain.leave_one_station_out {
        let [low, high] = out.interval;
        text += &format!(
            "; each station predicted from the others: {:.3} times ({low:.3} to {high:.3})",
            out.ratio
        );
    }
    labelled("gained", &(data + &text))
}

/// Amplitude and phase where they are known, without the sine and cosine that say the same.
fn amplitudes(parameters: &[EstimatedParameter]) -> Vec<EstimatedParameter> {
    let has_amplitude = parameters.iter().any(|p| p.name == "amplitude");
    let says_the_same =
        |p: &EstimatedParameter| p.name.starts_with("sine") || p.name.starts_with("cosine");
    let kept = parameters
        .iter()
        .filter(|p| !(has_amplitude && says_the_same(p)));
    kept.cloned().collect()
}

/// A cause of an error curve, on one line.
pub(crate) fn of_curve(cause: &Cause, scene: &Scene) -> String {
    let share = cause
        .share_of_curve
        .map(|share| match share {
            s if s < 0.005 => ", less than 1 % of the curve".to_owned(),
            s => format!(", {:.0} % of the curve", 100.0 * s),
        })
        .unwrap_or_default();
    let or = match cause.rivals.is_empty() {
        true => String::new(),
        false => format!(" (or {})", names_of_rivals(cause, scene)),
    };
    let data = match cause.data.join(", ").as_str() {
        "error curves" => String::new(),
        data => format!("{data}: "),
    };
    format!(
        "  {data}{}{or}: {}{share}",
        in_words::effect(&cause.effect, scene),
        in_words::parameters(&amplitudes(&cause.parameters))
    )
}
