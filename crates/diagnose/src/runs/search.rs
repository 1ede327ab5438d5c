//! The hypotheses that explain why runs differ.

use trueaxis_selection::{DECISIVE, Projection, Score, cosine, is_rival};

use crate::Rival;
use crate::engine::linear::{Chosen, Judged, Listed, MOST_CAUSES};

/// The hypothesis with the most evidence if it is significant at `level` (family-wise), and further ones while
/// something is left to explain.
pub(super) fn search(
    listed: &Listed,
    level: f64,
    is_left: impl Fn(&Projection) -> bool,
) -> Vec<Chosen> {
    let mut found: Vec<Chosen> = Vec::new();
    while found.len() < MOST_CAUSES {
        let beside = listed.beside(&found);
        if !found.is_empty() && !is_left(&beside.model) {
            break;
        }
        let (model, scores) = (&beside.model, &beside.scores);
        let best = scores.iter().find(|s| beside.is_significant(s, level));
        let Some(best) = best else {
            break;
        };
        let plain = |score: &&Score| {
            let number = beside.numbers[score.scan];
            let subject = &listed.candidates[number].hypothesis.subject;
            subject.other_axis.is_some() && subject.component.is_none()
        };
        // A rotation is named only if it shows: it would change the curves that the runs determine.
        let variance = model.squares() / model.degrees_of_freedom;
        let enough = best.statistic - DECISIVE * variance.max(1.0);
        let plain = scores.iter().find(|s| plain(s) && s.statistic >= enough);
        found.push(listed.chosen(&beside, plain.unwrap_or(best)));
    }
    found
}

/// The hypotheses that explain as much as a cause.
pub(super) fn rivals(listed: &Listed, judged: &Judged) -> Vec<Rival> {
    let own = &judged.score;
    listed.rivals(judged, |score, other, _| {
        // A hypothesis that explains less than half is no rival.
        let alike = || is_rival(own, score, cosine(&judged.fit, other));
        score.statistic >= 0.5 * own.statistic && alike()
    })
}
