//! The search for causes in the lengths.

use trueaxis_campaign::{Campaign, Lengths};
use trueaxis_effects::{Level, Scene};

use crate::lengths::base::{Adjusted, Base, Suspect};
use crate::lengths::held_out::{HeldOut, held_out};
use crate::lengths::hypotheses::hypotheses;
use crate::lengths::noise_floor::{mean_noise_um, noise_floor_um};
use crate::lengths::not_observable::not_observable;
use crate::lengths::omnibus::{Omnibus, omnibus};
use crate::lengths::places::places;
use crate::lengths::unexplained::period_s;
use crate::selection::{Fit, Null, Score, cosine, is_rival, ln_f_test, rank};
use crate::{
    Cause, Error, EstimatedParameter, Gain, LevelReport, Misfit, NotObservable, Rival, Unexplained,
    Verdict,
};

/// Family-wise level of the causes: false alarms in one of a hundred clean campaigns.
const CAUSE_LEVEL: f64 = 0.01;

/// Family-wise level of the omnibus tests.
const OMNIBUS_LEVEL: f64 = 0.005;

/// More causes at once are a pile of names, not a diagnosis.
const MOST_CAUSES: usize = 3;

/// A single cause that explains so much of the structure is named even if its shape is not quite that
/// of the catalogue (a drift with a bend, a jump that took ten seconds).
const NEARLY_ALL: f64 = 0.9;

/// Rivals that are worth a line.
const MOST_RIVALS: usize = 5;

/// The diagnosis of the lengths.
pub(crate) struct LengthsOutcome {
    pub(crate) scene: Scene,
    pub(crate) verdict: Verdict,
    pub(crate) report: LevelReport,
    pub(crate) causes: Vec<Cause>,
    pub(crate) unexplained: Option<Unexplained>,
    pub(crate) not_observable: Vec<NotObservable>,
    pub(crate) notices: Vec<String>,
    /// For every reading of the campaign what the causes do to it, mm.
    pub(crate) effects_mm: Vec<f64>,
}

/// A cause with its judgement.
struct Found {
    suspect: Suspect,
    p_value: f64,
    bic: f64,
    statistic: f64,
    rivals: Vec<(Suspect, f64)>,
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
    let not_observable = not_observable(&base.scene, &first.without_trace);
    drop(first);

    let mut found: Vec<Found> = Vec::new();
    let mut current = base.adjust(Vec::new(), Some(plain.network.noise))?;
    while found.len() < MOST_CAUSES {
        let Some((next, adjusted)) = next_cause(&base, &current, &null)? else {
            break;
        };
        found.push(next);
        current = adjusted;
        current = drop_superfluous(&base, current, &mut found, &null)?;
    }
    let mut after = omnibus(&base, &current);
    let is_left = |tests: &[Omnibus]| tests.iter().any(|t| t.test.p_value < OMNIBUS_LEVEL);
    let mut unexplained = None;
    let mut closest = None;
    if is_left(&after) {
        let explained: f64 = found.iter().map(|f| f.statistic).sum();
        let left = after.iter().map(|t| t.excess).fold(0.0, f64::max);
        let share = explained / (explained + left);
        if found.len() != 1 || share < NEARLY_ALL {
            closest = found.first().map(|f| (f.suspect.clone(), share));
            found.clear();
            current = base.adjust(Vec::new(), Some(plain.network.noise))?;
            after = omnibus(&base, &current);
        }
        unexplained = Some(unexplained_part(&base, &current, &after, closest.as_ref()));
    }

    let mut gain = None;
    let mut heldout: Option<HeldOut> = None;
    if !found.is_empty() {
        heldout = held_out(&base, &current)?;
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
                1.0
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
        scene: base.scene,
    })
}

/// The next cause, if noise alone would not look as much like one, and the model with it.
fn next_cause(
    base: &Base<'_>,
    current: &Adjusted,
    null: &Null,
) -> Result<Option<(Found, Adjusted)>, Error> {
    let Some(leader) = leader(base, current, null) else {
        return Ok(None);
    };
    let trial = base.adjust(with(&current.suspects, leader), None)?;
    // Again with the noise that is left with it in the model: a large disturbance blurs its rivals.
    let sharp = base.adjust(current.suspects.clone(), Some(trial.network.noise))?;
    let scans = hypotheses(base, &sharp).scans;
    let scores = rank(&sharp.projection, &scans);
    let significant = |s: &Score| null.family_wise(s.ln_p) <= CAUSE_LEVEL;
    let Some(best) = scores.iter().find(|s| significant(s)).copied() else {
        return Ok(None);
    };
    let fit_of = |score: &Score| {
        let columns = scans[score.scan].columns(score.shape);
        Fit::new(&sharp.projection, &columns)
    };
    let suspect_of = |score: &Score, fit: &Fit| Suspect {
        hypothesis: *scans[score.scan].hypothesis(),
        shape: score.shape,
        u_shape: score.u_shape,
        parameters: fit.estimates.clone(),
        covariance: fit.covariance.clone(),
    };
    let best_fit = fit_of(&best);
    let mut rivals = Vec::new();
    for score in &scores {
        // Who explains less than half cannot be alike, and has no evidence.
        if score.scan == best.scan || score.statistic < 0.5 * best.statistic {
            continue;
        }
        let fit = fit_of(score);
        if is_rival(&best, score, cosine(&best_fit, &fit)) && rivals.len() < MOST_RIVALS {
            rivals.push((suspect_of(score, &fit), score.bic));
        }
    }
    let suspect = suspect_of(&best, &best_fit);
    let adjusted = base.adjust(with(&current.suspects, suspect.clone()), None)?;
    let found = Found {
        suspect,
        p_value: null.family_wise(best.ln_p),
        bic: best.bic,
        statistic: best.statistic,
        rivals,
    };
    Ok(Some((found, adjusted)))
}

/// The hypothesis with the most evidence among those that noise does not explain.
fn leader(base: &Base<'_>, current: &Adjusted, null: &Null) -> Option<Suspect> {
    let scans = hypotheses(base, current).scans;
    let scores = rank(&current.projection, &scans);
    let best = scores
        .iter()
        .find(|s| null.family_wise(s.ln_p) <= CAUSE_LEVEL)?;
    let fit = Fit::new(&current.projection, &scans[best.scan].columns(best.shape));
    Some(Suspect {
        hypothesis: *scans[best.scan].hypothesis(),
        shape: best.shape,
        u_shape: best.u_shape,
        parameters: fit.estimates,
        covariance: fit.covariance,
    })
}

fn with(suspects: &[Suspect], next: Suspect) -> Vec<Suspect> {
    let mut all = suspects.to_vec();
    all.push(next);
    all
}

/// Takes causes out again that the others made superfluous.
fn drop_superfluous(
    base: &Base<'_>,
    current: Adjusted,
    found: &mut Vec<Found>,
    null: &Null,
) -> Result<Adjusted, Error> {
    let rows = base.readings.len() as f64;
    let needed: Vec<bool> = current
        .suspects
        .iter()
        .map(|suspect| {
            let (statistic, rank) = wald(suspect);
            let squares = current.projection.squares() + statistic;
            null.family_wise(ln_f_test(statistic, squares, rank, rows)) <= CAUSE_LEVEL
        })
        .collect();
    if needed.iter().all(|&needed| needed) {
        for (found, suspect) in found.iter_mut().zip(&current.suspects) {
            found.suspect = suspect.clone();
        }
        return Ok(current);
    }
    let mut keep = needed.iter();
    found.retain(|_| *keep.next().unwrap_or(&true));
    let mut keep = needed.iter();
    let mut suspects = current.suspects;
    suspects.retain(|_| *keep.next().unwrap_or(&true));
    let adjusted = base.adjust(suspects, None)?;
    for (found, suspect) in found.iter_mut().zip(&adjusted.suspects) {
        found.suspect = suspect.clone();
    }
    Ok(adjusted)
}

/// `θᵀ C⁺ θ` of a cause among the others, and its rank.
fn wald(suspect: &Suspect) -> (f64, usize) {
    let n = suspect.parameters.len();
    let diagonal: Vec<f64> = (0..n).map(|i| suspect.covariance[i * n + i]).collect();
    let gram = crate::selection::Gram::new(&suspect.covariance, &diagonal);
    let squares = gram.standardised(&suspect.parameters).map(|(_, z)| z * z);
    (squares.sum(), gram.rank())
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
    if base.left_out.is_empty() {
        return Vec::new();
    }
    let lines: Vec<String> = base.left_out.iter().map(ToString::to_string).collect();
    vec![format!(
        "{} length(s) contradict all others and were left out: line(s) {}",
        lines.len(),
        lines.join(", ")
    )]
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
            p_value: found.p_value,
            delta_bic: found.bic,
            explained_rms_um: after_um * (found.statistic / dof).sqrt(),
            heldout_gain: gain.filter(|_| only).map(|g| 1.0 - g.heldout_rms_ratio),
            parameters: estimated(&base.scene, &found.suspect),
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

/// Values with uncertainties; the shape last.
fn estimated(scene: &Scene, suspect: &Suspect) -> Vec<EstimatedParameter> {
    let Suspect {
        hypothesis,
        covariance,
        ..
    } = suspect;
    let parameters = hypothesis.effect.parameters(scene, &hypothesis.subject);
    let n = parameters.len();
    let mut all: Vec<EstimatedParameter> = parameters
        .into_iter()
        .enumerate()
        .map(|(k, parameter)| EstimatedParameter {
            name: parameter.name,
            value: suspect.parameters[k],
            u: covariance[k * n + k].max(0.0).sqrt(),
            unit: parameter.unit,
        })
        .collect();
    if let Some(shape) =
        trueaxis_effects::shape_parameter(hypothesis.effect, scene, &hypothesis.subject)
    {
        all.push(EstimatedParameter {
            name: shape.name,
            value: suspect.shape,
            u: suspect.u_shape,
            unit: shape.unit,
        });
    }
    all
}

/// What is left beyond the noise, and what it varies with.
fn unexplained_part(
    base: &Base<'_>,
    current: &Adjusted,
    after: &[Omnibus],
    closest: Option<&(Suspect, f64)>,
) -> Unexplained {
    let clear: Vec<&Omnibus> = after
        .iter()
        .filter(|t| t.test.p_value < OMNIBUS_LEVEL)
        .collect();
    let excess = clear.iter().map(|t| t.excess).fold(0.0, f64::max);
    let dof = current.projection.degrees_of_freedom;
    let squares: f64 = current.solution.residuals_mm.iter().map(|r| r * r).sum();
    let rms_um = (squares / dof).sqrt() * 1e3;
    let varies_with: Vec<&'static str> = clear.iter().map(|t| t.test.varies_with).collect();
    let mut note = format!("varies with {}", varies_with.join(" and "));
    if let Some(period_s) = period_s(base, current) {
        note += &format!(", strongest with a period of {period_s:.0} s");
    }
    note += &of_stations(base, current);
    if let Some((suspect, share)) = closest {
        let id = suspect.hypothesis.effect.id();
        note += &format!(
            "; {id} comes closest and explains {:.0} % of it, which is not enough to name it",
            share * 100.0
        );
    }
    Unexplained {
        level: Level::Lengths,
        rms_um: rms_um * (excess / dof).sqrt().min(1.0),
        varies_with,
        note,
    }
}

/// A station whose residuals are so much larger than those of the others is worth its name.
const STANDS_OUT: f64 = 1.2;

fn of_stations(base: &Base<'_>, current: &Adjusted) -> String {
    let mut sums = vec![(0_usize, 0.0); base.scene.stations.len()];
    for (reading, e) in base.readings.iter().zip(&current.projection.residuals) {
        sums[reading.station].0 += 1;
        sums[reading.station].1 += e * e;
    }
    let mut rms: Vec<(f64, usize)> = sums
        .iter()
        .enumerate()
        .map(|(station, (count, squares))| ((squares / (*count).max(1) as f64).sqrt(), station))
        .collect();
    rms.sort_by(|a, b| b.0.total_cmp(&a.0));
    match rms.as_slice() {
        [first, second, ..] if first.0 > STANDS_OUT * second.0 => {
            format!(", largest from station {}", base.scene.stations[first.1])
        }
        _ => String::new(),
    }
}
