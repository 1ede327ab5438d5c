//! Hypotheses compared with what a model leaves, the one with the largest 2 ln B first.

use trueaxis_effects::Scene;
use trueaxis_selection::{EQUAL, Fit, Hypothesis, Null, Projection, Scan, Score, cosine, rank};

use crate::engine::{Measured, Suspect};

/// The hypotheses that are physically possible, by rank.
pub(crate) struct Ranking<'m> {
    projection: &'m Projection,
    scans: &'m [Box<dyn Scan>],
    pub(crate) scores: Vec<Score>,
}

/// Most rivals to be listed; each explains at least half of what the leader explains.
const MOST_RIVALS: usize = 8;
const HALF: f64 = 0.5;

impl<'m> Ranking<'m> {
    /// Ranks prepared hypotheses by what a model leaves.
    pub(crate) fn new<D: Measured>(
        data: &D,
        projection: &'m Projection,
        scans: &'m [Box<dyn Scan>],
    ) -> Self {
        let mut ranking = Self {
            scores: rank(projection, scans),
            projection,
            scans,
        };
        let mut scores = std::mem::take(&mut ranking.scores);
        scores.retain(|score| {
            let hypothesis = ranking.hypothesis(score);
            let plausible = data.plausible(hypothesis);
            let is_free = plausible.iter().all(Option::is_none);
            // Whitened, so that the noise has unit variance.
            is_free || ranking.fit(score).is_possible(&plausible, 1.0)
        });
        ranking.scores = scores;
        ranking
    }

    pub(crate) fn hypothesis(&self, score: &Score) -> &Hypothesis {
        self.scans[score.scan].hypothesis()
    }

    fn fit(&self, score: &Score) -> Fit {
        let scan = &self.scans[score.scan];
        Fit::new(self.projection, &scan.columns(score.shape))
    }

    /// A scored hypothesis with its parameters.
    pub(crate) fn suspect(&self, score: &Score) -> (Suspect, Fit) {
        let fit = self.fit(score);
        let shape = (score.shape, score.u_shape);
        (Suspect::new(*self.hypothesis(score), shape, &fit), fit)
    }

    /// The first that noise does not explain at a family-wise level; `own` instead of another with the same 2 ln B.
    pub(crate) fn leader(
        &self,
        null: &Null,
        level: f64,
        own: Option<&Hypothesis>,
    ) -> Option<&Score> {
        let is_significant = |s: &&Score| null.family_wise(s.ln_p) <= level;
        let leader = self.scores.iter().find(is_significant)?;
        let as_good = |s: &&Score| {
            own.is_some_and(|own| self.hypothesis(s).is(own))
                && is_significant(s)
                && leader.two_ln_b - s.two_ln_b < EQUAL
        };
        self.scores.iter().find(as_good).or(Some(leader))
    }

    /// The hypotheses that explain as much as the leader, whose fit is `fit`, with their BIC.
    pub(crate) fn rivals<D: Measured>(&self, leader: &Score, fit: &Fit) -> Vec<(Suspect, f64)> {
        let of_leader = (self.hypothesis(leader), leader);
        let is_alike = |score: &Score, (suspect, other): &(Suspect, Fit)| {
            D::is_alike(of_leader, (&suspect.hypothesis, score), cosine(fit, other))
        };
        let least = HALF * leader.statistic;
        let scores = self.scores.iter().filter(|s| s.statistic >= least);
        let rivals = rivals(leader, scores, |score| self.suspect(score), is_alike);
        let named = rivals.take(MOST_RIVALS);
        named
            .map(|(score, (suspect, _))| (suspect, score.bic))
            .collect()
    }

    /// The hypotheses that explain at least the share `part` of what the leader explains, in their order.
    pub(crate) fn comparable(&self, leader: &Score, part: f64) -> Vec<Hypothesis> {
        let near = |&number: &usize| {
            let own = self.scores.iter().find(|s| s.scan == number);
            own.is_some_and(|s| s.statistic >= part * leader.statistic)
        };
        let near = (0..self.scans.len()).filter(near);
        near.map(|number| *self.scans[number].hypothesis())
            .collect()
    }
}

/// The other hypotheses of some, each `fitted`, that cannot be told from a leader.
pub(crate) fn rivals<'s, F>(
    leader: &'s Score,
    scores: impl Iterator<Item = &'s Score>,
    fitted: impl Fn(&Score) -> F,
    is_alike: impl Fn(&Score, &F) -> bool,
) -> impl Iterator<Item = (&'s Score, F)> {
    let others = scores.filter(|score| score.scan != leader.scan);
    let fitted = others.map(move |score| (score, fitted(score)));
    fitted.filter(move |(score, fit)| is_alike(score, fit))
}

/// The plausible range of each parameter of a hypothesis.
pub(crate) fn plausible(hypothesis: &Hypothesis, scene: &Scene) -> Vec<Option<[f64; 2]>> {
    let parameters = hypothesis.parameters(scene).into_iter();
    parameters.map(|p| p.plausible).collect()
}
