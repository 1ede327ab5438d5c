//! What explains readings or runs nearly as well as a cause.

use trueaxis_effects::{Effect, Subject};
use trueaxis_selection::{DECISIVE, Fit, Score, cosine, is_rival};

use crate::Rival;
use crate::engine::linear::search::{contains, ln_more};
use crate::engine::linear::{Judged, Listed};
use crate::engine::ranking::rivals;

/// Probability that noise gives as much as a larger form has more, above which it is taken to have no more.
const UNDECIDED: f64 = 0.1;

impl Listed<'_> {
    /// What explains the data nearly as well as a cause, each against the model with the other causes. A form that
    /// holds the cause and more is a rival only while it is undecided whether there is more.
    pub(crate) fn rivals(&self, judged: &Judged) -> Vec<Rival> {
        let (beside, own) = (&judged.beside, &judged.score);
        let model = &beside.model;
        let cause_columns = self.columns_of(&judged.cause);
        let hypothesis = self.hypothesis(&judged.cause);
        let is_alike = |score: &Score, (other, columns): &(Fit, Vec<Vec<f64>>)| {
            let candidate = self.candidate(beside, score);
            let holds_cause =
                score.rank > own.rank && contains(model, &model.extended(columns), &cause_columns);
            let is_held =
                score.rank < own.rank && contains(model, &model.extended(&cause_columns), columns);
            let is_close = if is_held {
                // The larger form was taken because it is decided that there is more, but not always by much.
                ln_more(model, score, own) > UNDECIDED.ln() || score.bic - own.bic < DECISIVE
            } else if holds_cause {
                ln_more(model, own, score) < candidate.ln_level_of_more(UNDECIDED)
            } else {
                is_rival(own, score, cosine(&judged.fit, other))
            };
            // Another form of the same effect is no rival.
            is_close && !candidate.hypothesis.is(hypothesis)
        };
        let fitted = |score: &Score| {
            let columns = self.candidate(beside, score).columns(score.shape);
            (Fit::new(model, &columns), columns)
        };
        let rivals = rivals(own, beside.scores.iter(), fitted, is_alike);
        let rivals = rivals.map(|(score, (fit, _))| self.rival(beside, score, &fit));
        let mut rivals: Vec<Rival> = rivals.collect();
        rivals.extend(self.lost_motion_beyond_drives(judged));
        // Straight and free lost motion are one effect in two forms: the better of them is stated.
        let mut said: Vec<(&Effect, Subject)> = Vec::new();
        rivals.retain(|rival| {
            let Rival::Effect { effect, .. } = rival else {
                return true;
            };
            let name = (effect.effect, effect.subject);
            let is_new = !said.contains(&name);
            said.push(name);
            is_new
        });
        rivals
    }

    /// Lost motion that would explain as much if a drive lost so much: a mistake in the table is likelier than anything
    /// else that reverses with the axis. Beside late time stamps it always counts: soft joints lose unlike play.
    fn lost_motion_beyond_drives(&self, judged: &Judged) -> impl Iterator<Item = Rival> {
        let (beside, own) = (&judged.beside, &judged.score);
        let effect = |score: &Score| self.candidate(beside, score).hypothesis.effect;
        let is_late = effect(own).is_delay();
        let is_it = move |score: &&Score| {
            effect(score).is_lost_motion() && (is_late || own.two_ln_b - score.two_ln_b < DECISIVE)
        };
        beside.impossible.iter().filter(is_it).map(|score| {
            let columns = self.candidate(beside, score).columns(score.shape);
            self.rival(beside, score, &Fit::new(&beside.model, &columns))
        })
    }
}
