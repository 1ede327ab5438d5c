//! One cause after the other.
//!
//! 1. The hypothesis with the most evidence, among those that noise alone would not match once in a
//!    hundred campaigns, joins the causes.
//! 2. All of them settle ([`settle`]): each is compared with every other hypothesis while the others are
//!    in the model, with the noise that is left; a better one takes its place, and one that is no longer
//!    needed leaves. The first cause is often a compromise between two.
//! 3. It ends when nothing joins, or when the next would be the same trouble under another name
//!    ([`overlap`]) or no more than the shape of an earlier one.

use crate::Error;
use crate::lengths::base::{Adjusted, Base, Suspect};
use crate::lengths::culprit::overlap;
use crate::lengths::hypotheses::{hypotheses, neighbours};
use crate::lengths::swapped::{add_swapped, swapped};
use crate::selection::{
    DECISIVE, Fit, Hypothesis, Null, Projection, Scan, Score, cosine, golden_section, is_rival,
    rank, weakest,
};

/// Family-wise level of the causes: false alarms in one of a hundred clean campaigns.
const CAUSE_LEVEL: f64 = 0.01;

/// More causes at once are a pile of names, not a diagnosis.
const MOST_CAUSES: usize = 6;

/// Rivals that are worth a line.
const MOST_RIVALS: usize = 8;

/// A cause with its judgement beside the others.
#[derive(Debug, Clone)]
pub(crate) struct Found {
    pub(crate) suspect: Suspect,
    pub(crate) p_value: f64,
    /// Drop of the BIC by this cause.
    pub(crate) bic: f64,
    /// Drop of the sum of squares by this cause.
    pub(crate) statistic: f64,
    /// What explains as much, with its BIC.
    pub(crate) rivals: Vec<(Suspect, f64)>,
}

/// The causes, the model with them, and what a further cause would explain that is not one of its own.
pub(crate) struct Search {
    pub(crate) found: Vec<Found>,
    pub(crate) adjusted: Adjusted,
    pub(crate) left: f64,
}

/// Finds the causes of what `start`, a model without any, leaves. `first` are the scans of `all`
/// hypotheses of that model.
pub(crate) fn find_causes(
    base: &Base<'_>,
    start: Adjusted,
    all: &[Hypothesis],
    first: &[Box<dyn Scan>],
    null: &Null,
) -> Result<Search, Error> {
    let mut next = leader(&start, first, null);
    let mut search = Search {
        found: Vec::new(),
        adjusted: start,
        left: 0.0,
    };
    while let Some((leader_of_all, shortlist)) = next {
        let mut suspects = search.adjusted.suspects.clone();
        suspects.push(leader_of_all);
        // Beside others everything is looked at again: what they hid may come out.
        let candidates = if suspects.len() == 1 { &shortlist } else { all };
        let (found, adjusted) = settle(base, suspects, candidates, null)?;
        if found.len() <= search.found.len() {
            break;
        }
        if let Some(left) = not_its_own(base, &found) {
            search.left = left;
            break;
        }
        (search.found, search.adjusted) = (found, adjusted);
        if search.found.len() == MOST_CAUSES {
            break;
        }
        let scans = hypotheses(base, &search.adjusted, all).scans;
        next = leader(&search.adjusted, &scans, null);
    }
    Ok(search)
}

/// What the weakest of several causes explains, if it is not a cause of its own.
fn not_its_own(base: &Base<'_>, found: &[Found]) -> Option<f64> {
    if found.len() < 2 {
        return None;
    }
    let pairs = || (1..found.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
    let stacked = pairs().any(|(i, j)| overlap(base, &found[i], &found[j]));
    let (weakest, is_doubtful) = weakest(found.iter().map(|f| (f.statistic, f.p_value)));
    (stacked || is_doubtful).then_some(weakest)
}

/// A hypothesis that explains less than this part of what the leader explains is no rival of it in
/// the same model, whatever the noise is found to be: rivals explain at least half ([`judged`]).
const WORTH_COMPARING: f64 = 0.25;

/// The hypothesis with the most evidence among those that noise does not explain, and those that are
/// worth comparing with it.
fn leader(
    current: &Adjusted,
    scans: &[Box<dyn Scan>],
    null: &Null,
) -> Option<(Suspect, Vec<Hypothesis>)> {
    let scores = ranked(&current.projection, scans);
    let best = scores.iter().find(|s| is_significant(s, null))?;
    let near = |&number: &usize| {
        let own = scores.iter().find(|s| s.scan == number);
        own.is_some_and(|s| s.statistic >= WORTH_COMPARING * best.statistic)
    };
    let shortlist = (0..scans.len()).filter(near);
    let shortlist = shortlist.map(|number| *scans[number].hypothesis());
    Some((
        suspect(&current.projection, scans, best).0,
        shortlist.collect(),
    ))
}

/// Scores of the hypotheses that are physically possible.
fn ranked(projection: &Projection, scans: &[Box<dyn Scan>]) -> Vec<Score> {
    let mut scores = rank(projection, scans);
    scores.retain(|score| {
        let Hypothesis {
            effect, subject, ..
        } = scans[score.scan].hypothesis();
        effect.id != "refraction_drift" || subject.column.is_none() || {
            let fit = suspect(projection, scans, score).1;
            fit.estimates[0].abs() <= MOST_PPM_PER_K + 3.0 * fit.covariance[0].sqrt()
        }
    });
    scores
}

/// The refractive index of air changes by no more with its temperature, ppm/K.
const MOST_PPM_PER_K: f64 = 1.2;

fn is_significant(score: &Score, null: &Null) -> bool {
    null.family_wise(score.ln_p) <= CAUSE_LEVEL
}

/// Exchanges of causes for better ones before it is enough.
const MOST_EXCHANGES: usize = 6;

/// Judges each cause against the candidates with the others in the model until none changes any more.
pub(super) fn settle(
    base: &Base<'_>,
    mut suspects: Vec<Suspect>,
    candidates: &[Hypothesis],
    null: &Null,
) -> Result<(Vec<Found>, Adjusted), Error> {
    let mut adjusted = base.adjust(suspects.clone(), None)?;
    let mut exchanges = 0;
    loop {
        let mut found = Vec::new();
        let mut changed = false;
        for k in 0..suspects.len() {
            let mut others = suspects.clone();
            let own = others.remove(k);
            // With the noise that is left: a large disturbance blurs its own rivals.
            let without = base.adjust_near(&adjusted, others)?;
            let Some(judged) = judged(base, &without, &own, candidates, null) else {
                suspects.remove(k);
                changed = true;
                break;
            };
            let same = judged.suspect.hypothesis.is(&own.hypothesis);
            let step = (judged.suspect.shape - own.shape).abs();
            let moved = step > judged.suspect.u_shape.max(REFINED * own.shape.abs());
            if (!same || moved) && exchanges < MOST_EXCHANGES {
                exchanges += 1;
                changed = true;
            }
            suspects[k] = judged.suspect.clone();
            found.push(judged);
        }
        adjusted = base.adjust(suspects.clone(), None)?;
        let others = swapped(base, &adjusted.suspects).filter(|_| !changed);
        if let Some(others) = others {
            // As many parameters, so that the squares decide.
            let other = base.adjust_near(&adjusted, others)?;
            let more = other.projection.squares() - adjusted.projection.squares();
            if more < -EQUAL && exchanges < MOST_EXCHANGES {
                exchanges += 1;
                (suspects, adjusted) = (other.suspects.clone(), other);
                continue;
            }
            if more < DECISIVE {
                add_swapped(&mut found, &other.suspects, more);
            }
        }
        if !changed {
            for (found, suspect) in found.iter_mut().zip(&adjusted.suspects) {
                found.suspect = suspect.clone();
            }
            return Ok((found, adjusted));
        }
        suspects.clone_from(&adjusted.suspects);
    }
}

/// The best explanation of what a model without one of its causes leaves, and its rivals; `None` if
/// noise explains it.
fn judged(
    base: &Base<'_>,
    without: &Adjusted,
    own: &Suspect,
    candidates: &[Hypothesis],
    null: &Null,
) -> Option<Found> {
    let scans = hypotheses(base, without, candidates).scans;
    let scores = ranked(&without.projection, &scans);
    let leader = scores.iter().find(|s| is_significant(s, null))?;
    // An explanation with the same evidence is no reason to change.
    let best = scores
        .iter()
        .find(|s| {
            scans[s.scan].hypothesis().is(&own.hypothesis)
                && is_significant(s, null)
                && leader.evidence - s.evidence < EQUAL
        })
        .unwrap_or(leader);
    let (mut suspect_of_best, mut fit) = suspect(&without.projection, &scans, best);
    let shape = suspect_of_best.hypothesis.effect.shape;
    if let Some(range) = neighbours(base, shape, suspect_of_best.shape) {
        (suspect_of_best, fit) = refined(base, without, suspect_of_best, range);
    }
    let mut rivals = Vec::new();
    for score in &scores {
        // Who explains less than half cannot be alike, and has no evidence.
        if score.scan == best.scan || score.statistic < 0.5 * best.statistic {
            continue;
        }
        let (other, other_fit) = suspect(&without.projection, &scans, score);
        let column = |suspect: &Suspect| suspect.hypothesis.subject.column.is_some();
        // A temperature that was logged is an observation: what explains the data better than time does, does so
        // even if their courses are alike.
        let is_alike = match column(&suspect_of_best) == column(&other) {
            true => is_rival(best, score, cosine(&fit, &other_fit)),
            false => best.evidence - score.evidence < DECISIVE,
        };
        if is_alike && rivals.len() < MOST_RIVALS {
            rivals.push((other, score.bic));
        }
    }
    Some(Found {
        suspect: suspect_of_best,
        p_value: null.family_wise(best.ln_p),
        bic: best.bic,
        statistic: best.statistic,
        rivals,
    })
}

/// Part of a time constant to which it is refined.
const REFINED: f64 = 1e-3;

/// A time constant or a lag between its neighbours in the list that were tried: golden section on what it
/// explains.
fn refined(
    base: &Base<'_>,
    without: &Adjusted,
    suspect: Suspect,
    ends: [f64; 2],
) -> (Suspect, Fit) {
    let at = |shape: f64| {
        let columns = base.columns(without, &suspect.hypothesis, shape);
        Fit::new(&without.projection, &columns)
    };
    let explained = |fit: &Fit| fit.explained.iter().map(|x| x * x).sum::<f64>();
    let enough = REFINED * ends[1];
    let is_close = |low: f64, high: f64| high - low <= enough;
    let shape = golden_section(ends, is_close, |shape| explained(&at(shape)));
    let fit = at(shape);
    let suspect = Suspect {
        shape,
        parameters: fit.estimates.clone(),
        covariance: fit.covariance.clone(),
        ..suspect
    };
    (suspect, fit)
}

/// Evidence that differs by less is rounding.
const EQUAL: f64 = 1e-3;

/// A scored hypothesis with its parameters.
fn suspect(projection: &Projection, scans: &[Box<dyn Scan>], score: &Score) -> (Suspect, Fit) {
    let scan = &scans[score.scan];
    let fit = Fit::new(projection, &scan.columns(score.shape));
    let suspect = Suspect {
        hypothesis: *scan.hypothesis(),
        shape: score.shape,
        u_shape: score.u_shape,
        parameters: fit.estimates.clone(),
        covariance: fit.covariance.clone(),
        seen: fit.seen.clone(),
    };
    (suspect, fit)
}
