//! Hypotheses whose whitened columns are listed for every shape: readings and runs, where nothing is adjusted anew.

use std::sync::Arc;

use trueaxis_effects::{Level, ResolvedEffect, Scene};

use crate::engine::with_uncertainties;
use crate::selection::{Fit, FixedScan, Hypothesis, Null, Projection, Scan, Score, rank};
use crate::{Cause, Rival};

/// An effect on a subject with the columns of all its shapes.
pub(crate) struct Candidate {
    pub(crate) hypothesis: Hypothesis,
    pub(crate) shapes: Vec<f64>,
    pub(crate) columns: Vec<Vec<Vec<f64>>>,
    /// The plausible range of each parameter.
    pub(crate) plausible: Vec<Option<[f64; 2]>>,
    /// Whether it has more columns than the effect has parameters: its size is a free function of the position.
    pub(crate) is_free: bool,
}

/// A hypothesis in the model, at one shape.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Chosen {
    /// Which candidate.
    pub(crate) candidate: usize,
    pub(crate) shape: f64,
    /// Standard deviation of the shape.
    pub(crate) u_shape: f64,
}

/// What there is to explain, and what may explain it.
pub(crate) struct Listed {
    /// The base model's projection.
    pub(crate) base: Projection,
    pub(crate) candidates: Arc<[Candidate]>,
}

/// The other hypotheses beside a model with causes.
pub(crate) struct Beside {
    /// The model.
    pub(crate) model: Projection,
    /// Those that are physically possible, the one with the most evidence first.
    pub(crate) scores: Vec<Score>,
    pub(crate) scans: Vec<Box<dyn Scan>>,
    /// Which candidate each scan is.
    pub(crate) numbers: Vec<usize>,
}

/// A cause against the model with the others.
pub(crate) struct Judged {
    pub(crate) cause: Chosen,
    pub(crate) score: Score,
    /// Family-wise.
    pub(crate) p_value: f64,
    /// Its fit.
    pub(crate) fit: Fit,
    pub(crate) beside: Beside,
}

/// Part of the level at which a free form is preferred to its mean and slope.
const FREE_FORM: f64 = 0.1;

impl Candidate {
    /// The effect with the values of its parameters, which come first.
    pub(crate) fn resolved(&self, estimates: &[f64], shape: f64) -> ResolvedEffect {
        let values = &estimates[..self.plausible.len()];
        self.hypothesis.resolved(values.to_vec(), shape)
    }

    /// Whether it follows many courses: one in time, or a free function of the position.
    pub(crate) fn is_of_any_form(&self) -> bool {
        self.hypothesis.is_of_time() || self.is_free
    }

    /// The columns at the nearest shape.
    pub(crate) fn columns(&self, shape: f64) -> &[Vec<f64>] {
        let distance = |k: &usize| (self.shapes[*k] - shape).abs();
        let nearest = (0..self.shapes.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)));
        nearest.map_or(&[], |k| &self.columns[k])
    }

    /// Logarithm of the probability that noise has at most for what this form explains beyond a smaller one, if `level` is that of
    /// forms with parameters alone. Of a free form the best of several numbers of waves was taken; and it is named only where
    /// a simpler one is beyond doubt too simple.
    pub(crate) fn ln_level_of_more(&self, level: f64) -> f64 {
        match self.is_free {
            true => (level * FREE_FORM / self.shapes.len() as f64).ln(),
            false => level.ln(),
        }
    }

    /// Whether the data allow it a size that is physical: each value in its plausible range, three standard
    /// uncertainties considered.
    fn is_possible(&self, model: &Projection, shape: f64) -> bool {
        let is_any = self.plausible.iter().all(Option::is_none);
        let variance = model.squares() / model.degrees_of_freedom.max(1.0);
        is_any || Fit::new(model, self.columns(shape)).is_possible(&self.plausible, variance)
    }
}

impl Listed {
    pub(crate) fn hypothesis(&self, cause: &Chosen) -> &Hypothesis {
        &self.candidates[cause.candidate].hypothesis
    }

    /// The candidate that a score is of.
    pub(crate) fn candidate(&self, beside: &Beside, score: &Score) -> &Candidate {
        &self.candidates[beside.numbers[score.scan]]
    }

    /// The columns of causes, one cause after the other.
    pub(crate) fn columns(&self, causes: &[Chosen]) -> Vec<Vec<f64>> {
        let of_cause = |chosen: &Chosen| self.candidates[chosen.candidate].columns(chosen.shape);
        causes.iter().flat_map(of_cause).cloned().collect()
    }

    /// The projection with causes in the model.
    pub(crate) fn with(&self, causes: &[Chosen]) -> Projection {
        self.base.extended(&self.columns(causes))
    }

    /// The hypotheses that the data can see beside a model with causes, and which candidate each is.
    ///
    /// No effect happens twice to the same subject: a second time constant or period of the same name
    /// would fit anything.
    pub(crate) fn beside(&self, causes: &[Chosen]) -> Beside {
        let model = self.with(causes);
        let (mut scans, mut numbers): (Vec<Box<dyn Scan>>, _) = (Vec::new(), Vec::new());
        for (number, candidate) in self.candidates.iter().enumerate() {
            if causes.iter().any(|cause| cause.candidate == number) {
                continue;
            }
            let columns = |shape: f64| candidate.columns(shape).to_vec();
            let shapes = &candidate.shapes;
            if let Some(scan) = FixedScan::new(candidate.hypothesis, &model, shapes, columns) {
                scans.push(Box::new(scan));
                numbers.push(number);
            }
        }
        let mut scores = rank(&model, &scans);
        scores.retain(|s| self.candidates[numbers[s.scan]].is_possible(&model, s.shape));
        Beside {
            model,
            scores,
            scans,
            numbers,
        }
    }

    /// Cause `k` if the others are in the model; `None` if they leave nothing of it.
    pub(crate) fn judge(&self, causes: &[Chosen], k: usize) -> Option<Judged> {
        let beside = self.beside(&without(causes, k));
        let is_own = |s: &&Score| beside.numbers[s.scan] == causes[k].candidate;
        let score = *beside.scores.iter().find(is_own)?;
        Some(Judged {
            cause: causes[k],
            score,
            p_value: beside.null().family_wise(score.ln_p),
            fit: Fit::new(&beside.model, &self.columns(&causes[k..=k])),
            beside,
        })
    }

    /// A judged cause with its parameters from a fit of its columns to observations of this variance; its size in the data and
    /// its rivals are to be filled in.
    pub(crate) fn cause(
        &self,
        judged: &Judged,
        (scene, level): (&Scene, Level),
        fit: &Fit,
        variance: f64,
    ) -> Cause {
        let candidate = &self.candidates[judged.cause.candidate];
        let own = fit.part(0..candidate.plausible.len());
        let covariance: Vec<f64> = own.covariance.iter().map(|c| c * variance).collect();
        let linear = (&own.estimates[..], &covariance[..], &own.seen[..]);
        let shape = (judged.cause.shape, judged.cause.u_shape);
        let parameters = with_uncertainties(scene, &candidate.hypothesis, linear, shape);
        let effect = candidate.resolved(&own.estimates, judged.cause.shape);
        Cause {
            p_value: judged.p_value,
            delta_bic: judged.score.bic,
            ..Cause::of(level, effect, parameters, covariance)
        }
    }

    /// What cannot be told from a judged cause: its score, its fit and its columns say.
    pub(crate) fn rivals(
        &self,
        judged: &Judged,
        is_close: impl Fn(&Score, &Fit, &[Vec<f64>]) -> bool,
    ) -> Vec<Rival> {
        let beside = &judged.beside;
        let others = beside.scores.iter();
        // The same effect in another form is no rival.
        let own = self.hypothesis(&judged.cause);
        let is_other = |score: &&Score| !self.candidate(beside, score).hypothesis.is(own);
        let others = others.filter(is_other);
        let rival = |score: &Score| {
            let candidate = self.candidate(beside, score);
            let columns = candidate.columns(score.shape);
            let other = Fit::new(&beside.model, columns);
            is_close(score, &other, columns).then(|| Rival {
                effect: candidate.resolved(&other.estimates, score.shape),
                delta_bic: score.bic,
            })
        };
        others.filter_map(rival).collect()
    }
}

impl Beside {
    pub(crate) fn null(&self) -> Null {
        Null::simulated(&self.model, &self.scans)
    }

    pub(crate) fn chosen(&self, score: &Score) -> Chosen {
        Chosen {
            candidate: self.numbers[score.scan],
            shape: score.shape,
            u_shape: score.u_shape,
        }
    }
}

impl Hypothesis {
    /// The effect with values.
    pub(crate) fn resolved(&self, parameters: Vec<f64>, shape: f64) -> ResolvedEffect {
        ResolvedEffect {
            effect: self.effect,
            subject: self.subject,
            parameters,
            shape,
        }
    }
}

/// All causes but one.
pub(crate) fn without(causes: &[Chosen], k: usize) -> Vec<Chosen> {
    let others = causes.iter().enumerate().filter(|(i, _)| *i != k);
    others.map(|(_, cause)| *cause).collect()
}
