//! The search for causes in the lengths.

use trueaxis_campaign::{Campaign, Lengths};
use trueaxis_effects::Level;

use crate::lengths::base::{Adjusted, Base};
use crate::lengths::causes::{Found, Search, find_causes};
use crate::lengths::estimated::estimated;
use crate::lengths::held_out::{HeldOut, held_out};
use crate::lengths::hypotheses::hypotheses;
use crate::lengths::noise_floor::{mean_noise_um, noise_floor_um};
use crate::lengths::not_observable::not_observable;
use crate::lengths::omnibus::{OMNIBUS_LEVEL, Omnibus, omnibus};
use crate::lengths::places::places;
use crate::lengths::unexplained::unexplained_part;
use crate::selection::Null;
use crate::{Cause, Error, Gain, LevelReport, Misfit, NotObservable, Rival, Unexplained, Verdict};

/// Causes that explain so much of the structure are named even if their shape is not quite that of the
/// catalogue (a drift with a bend, a jump that took ten seconds).
const NEARLY_ALL: f64 = 0.9;

/// The diagnosis of the lengths.
pub(crate) struct LengthsOutcome {
    pub(crate) verdict: Verdict,
    pub(crate) report: LevelReport,
    pub(crate) causes: Vec<Cause>,
    pub(crate) unexplained: Option<Unexplained>,
    pub(crate) not_observable: Vec<NotObservable>,
    pub(crate) notices: Vec<String>,
    /// For every reading of the campaign what the causes do to it, mm.
    pub(crate) effects_mm: Vec<f64>,
}

/// Finds what the lengths contradict in the rigid, quasi-static model, and why.
pub(crate) fn diagnose_lengths(
    campaign: &Campaign,
    lengths: &Lengths,
) -> Result<LengthsOutcome, Error> {
    let base = Base::new(campaign, lengths)?;
    let plain = base.adjust(Vec::new(), None)?;
    let before = omnibus(&base, &plain);
    let first = hypotheses(&base, &plain);
    let null = Null::simulated(&plain.projection, &first.scans);
    let sides = || base.readings.iter().map(|r| r.direction);
    let both_sides = sides().any(|side| Some(side) != sides().next());
    let not_observable = not_observable(&base.scene, &first.without_trace, both_sides);
    drop(first);

    let start = base.adjust(Vec::new(), Some(plain.network.noise))?;
    let Search {
        mut found,
        adjusted: mut current,
        left: left_by_causes,
    } = find_causes(&base, start, &null)?;
    let mut after = omnibus(&base, &current);
    let is_left = |tests: &[Omnibus]| tests.iter().any(|t| t.test.p_value < OMNIBUS_LEVEL);
    let mut unexplained = None;
    let mut closest = None;
    if is_left(&after) || left_by_causes > 0.0 {
        let explained: f64 = found.iter().map(|f| f.statistic).sum();
        let left = after
            .iter()
            .map(|t| t.excess)
            .fold(left_by_causes, f64::max);
        let share = explained / (explained + left);
        let named = !found.is_empty() && share >= NEARLY_ALL;
        if !named {
            closest = found.first().map(|f| (f.suspect.clone(), share));
            found.clear();
            current = base.adjust(Vec::new(), Some(plain.network.noise))?;
            after = omnibus(&base, &current);
        }
        if !named || is_left(&after) {
            unexplained = Some(unexplained_part(&base, &current, &after, closest.as_ref()));
        }
    }

    let mut gain = None;
    let mut heldout: Option<HeldOut> = None;
    if !found.is_empty() {
        // A fold that cannot be adjusted holds nothing out.
        heldout = held_out(&base, &current).unwrap_or(None);
        if heldout.is_some_and(|h| h.interval[0] >= 1.0) {
            // What predicts unused data worse than nothing is no cause.
            found.clear();
            current = base.adjust(Vec::new(), Some(plain.network.noise))?;
            after = omnibus(&base, &current);
            heldout = None;
            if is_left(&after) {
                unexplained = Some(unexplained_part(&base, &current, &after, None));
            }
        }
    }
    let floor_um = noise_floor_um(&base, &current);
    // Both in the noise that is left at the end.
    let noise = current.network.noise;
    let sharp = base.adjust(Vec::new(), Some(noise))?;
    let length_um = mean_noise_um(&base, &current);
    let rms_um = |adjusted: &Adjusted| {
        (adjusted.projection.squares() / adjusted.projection.degrees_of_freedom).sqrt() * length_um
    };
    let (before_um, after_um) = (rms_um(&sharp), rms_um(&current));
    if let Some(h) = heldout {
        let excess = before_um.powi(2) - floor_um.powi(2);
        let left = (after_um.powi(2) - floor_um.powi(2)).max(0.0);
        gain = Some(Gain {
            heldout_rms_ratio: h.after / h.before,
            interval: h.interval,
            share_of_excess_removed: if excess > 0.0 {
                (1.0 - left / excess).clamp(0.0, 1.0)
            } else {
                0.0
            },
        });
    }
    let verdict = match (&unexplained, found.is_empty()) {
        (None, true) => Verdict::Clean,
        (Some(_), true) => Verdict::Unknown,
        _ if found.iter().any(|f| !f.rivals.is_empty()) => Verdict::Ambiguous,
        _ => Verdict::Named,
    };
    let scale = |adjusted: &Adjusted| {
        (base.readings.len() as f64 / adjusted.projection.degrees_of_freedom).sqrt()
    };
    let report = LevelReport {
        level: Level::Lengths,
        data: format!("{} lengths", base.readings.len()),
        noise_floor_um: floor_um,
        before: Misfit {
            rms_um: before_um,
            heldout_rms_um: heldout.map(|h| h.before * length_um),
        },
        after: Misfit {
            rms_um: after_um,
            heldout_rms_um: heldout.map(|h| h.after * length_um),
        },
        gain,
        tests: before.into_iter().map(|t| t.test).collect(),
        tests_after: after.into_iter().map(|t| t.test).collect(),
        places: places(
            &base,
            &plain.solution.residuals_mm,
            &current.solution.residuals_mm,
            [scale(&plain), scale(&current)],
        ),
    };
    let effects_mm = effects_mm(&base, lengths, &current);
    let notices = notices(&base);
    let causes = causes(&base, found, &current, after_um, gain);
    Ok(LengthsOutcome {
        verdict,
        report,
        causes,
        unexplained,
        not_observable,
        notices,
        effects_mm,
    })
}

/// For every reading of the campaign what the causes do to it, mm. Readings that were left out keep
/// their error.
fn effects_mm(base: &Base<'_>, lengths: &Lengths, adjusted: &Adjusted) -> Vec<f64> {
    let mut effects_mm = vec![0.0; lengths.readings.len()];
    let kept =
        (0..lengths.readings.len()).filter(|&i| !base.left_out.contains(&lengths.readings[i].line));
    for (i, reading) in kept.zip(&base.readings) {
        effects_mm[i] = base.effect_mm(reading, &adjusted.solution, &adjusted.suspects);
    }
    effects_mm
}

fn notices(base: &Base<'_>) -> Vec<String> {
    let mut notices = Vec::new();
    if !base.left_out.is_empty() {
        let lines: Vec<String> = base.left_out.iter().map(ToString::to_string).collect();
        notices.push(format!(
            "{} length(s) contradict all others and were left out: line(s) {}",
            lines.len(),
            lines.join(", ")
        ));
    }
    if base.many_gross > 0 {
        notices.push(format!(
            "{} lengths look like gross errors, too many to be left out as accidents: they are in the \
             misfit; `calibrate` lists them",
            base.many_gross
        ));
    }
    notices
}

/// The causes in words and units.
fn causes(
    base: &Base<'_>,
    found: Vec<Found>,
    current: &Adjusted,
    after_um: f64,
    gain: Option<Gain>,
) -> Vec<Cause> {
    let dof = current.projection.degrees_of_freedom;
    let only = found.len() == 1;
    found
        .into_iter()
        .map(|found| Cause {
            level: Level::Lengths,
            data: String::new(),
            p_value: found.p_value,
            delta_bic: found.bic,
            explained_rms_um: after_um * (found.statistic / dof).sqrt(),
            heldout_gain: gain.filter(|_| only).map(|g| 1.0 - g.heldout_rms_ratio),
            parameters: estimated(base, current, &found.suspect),
            covariance: found.suspect.covariance.clone(),
            rivals: found
                .rivals
                .iter()
                .map(|(suspect, bic)| Rival {
                    effect: Base::resolved(suspect),
                    delta_bic: *bic,
                })
                .collect(),
            changes: Vec::new(),
            share_of_curve: None,
            effect: Base::resolved(&found.suspect),
        })
        .collect()
}
