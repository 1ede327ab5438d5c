//! Which hypotheses explain why runs differ.

use crate::runs::hypotheses::Candidate;
use crate::selection::{
    DECISIVE, Fit, FixedScan, Null, Projection, Scan, Score, cosine, is_rival, rank,
};

/// Causes at most: more are no longer an explanation.
const MOST_CAUSES: usize = 3;

/// A hypothesis that joined the model.
#[derive(Debug, Clone, Copy)]
pub(super) struct Found {
    pub(super) candidate: usize,
}

/// A cause beside the others.
pub(super) struct Judged {
    pub(super) candidate: usize,
    pub(super) p_value: f64,
    pub(super) bic: f64,
    pub(super) fit: Fit,
    /// What explains as much: candidate, its fit and its BIC.
    pub(super) rivals: Vec<(usize, Fit, f64)>,
}

/// The hypothesis with the most evidence if it is significant at `level` (family-wise), and further ones while
/// something is left for them.
pub(super) fn search(
    base: &Projection,
    candidates: &[Candidate],
    level: f64,
    is_left: impl Fn(&Projection) -> bool,
) -> Vec<Found> {
    let mut found: Vec<Found> = Vec::new();
    while found.len() < MOST_CAUSES {
        let model = super::with(base, candidates, &found);
        if !found.is_empty() && !is_left(&model) {
            break;
        }
        let (scans, numbers) = scans(&model, candidates, &found);
        let scores = rank(&model, &scans);
        let null = Null::simulated(&model, &scans);
        let best = scores.iter().find(|s| null.family_wise(s.ln_p) < level);
        let Some(best) = best else {
            break;
        };
        let plain = |score: &&Score| {
            let subject = &candidates[numbers[score.scan]].hypothesis.subject;
            subject.other_axis.is_some() && subject.component.is_none()
        };
        // An angle is claimed only where it shows: it would change the curves that are told from the runs.
        let variance = model.squares() / model.degrees_of_freedom;
        let enough = best.statistic - DECISIVE * variance.max(1.0);
        let plain = scores.iter().find(|s| plain(s) && s.statistic >= enough);
        let best = plain.unwrap_or(best);
        found.push(Found {
            candidate: numbers[best.scan],
        });
    }
    found
}

/// Cause `k` with the others in the model; `None` if they leave nothing of it.
pub(super) fn judged_beside(
    base: &Projection,
    candidates: &[Candidate],
    found: &[Found],
    k: usize,
) -> Option<Judged> {
    let others = found.iter().enumerate().filter(|(i, _)| *i != k);
    let others: Vec<Found> = others.map(|(_, found)| *found).collect();
    let model = super::with(base, candidates, &others);
    let (scans, numbers) = scans(&model, candidates, &others);
    let scores = rank(&model, &scans);
    let null = Null::simulated(&model, &scans);
    let candidate = found[k].candidate;
    let own = scores.iter().find(|s| numbers[s.scan] == candidate)?;
    let fitted = |score: &Score| Fit::new(&model, &candidates[numbers[score.scan]].columns);
    let fit = fitted(own);
    let others = scores.iter().filter(|s| s.scan != own.scan);
    let rivals = others.filter_map(|score| {
        let other = fitted(score);
        // Who explains less than half cannot be alike.
        let is_alike =
            score.statistic >= 0.5 * own.statistic && is_rival(own, score, cosine(&fit, &other));
        is_alike.then(|| (numbers[score.scan], other, score.bic))
    });
    Some(Judged {
        candidate,
        p_value: null.family_wise(own.ln_p),
        bic: own.bic,
        rivals: rivals.collect(),
        fit,
    })
}

/// The hypotheses that the runs see beside those of the model, and which candidate each is.
fn scans(
    model: &Projection,
    candidates: &[Candidate],
    found: &[Found],
) -> (Vec<Box<dyn Scan>>, Vec<usize>) {
    let mut scans: Vec<Box<dyn Scan>> = Vec::new();
    let mut numbers = Vec::new();
    for (number, candidate) in candidates.iter().enumerate() {
        if found.iter().any(|found| found.candidate == number) {
            continue;
        }
        let columns = |_: f64| candidate.columns.clone();
        if let Some(scan) = FixedScan::new(candidate.hypothesis, model, &[0.0], columns) {
            scans.push(Box::new(scan));
            numbers.push(number);
        }
    }
    (scans, numbers)
}
