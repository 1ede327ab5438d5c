//! Hypotheses whose whitened columns are listed for every shape: readings and runs, where nothing is adjusted anew.
//!
//! The list has neighbours that hardly lose anything of what lies between them. Where that matters the best of a list is
//! looked for between its neighbours ([`crate::engine::Finer`]), and that joins the list of the hypothesis for this model. A period or time
//! constant joins the parameters by its derivative ([`Listed::sizes`]), so that all of them carry its uncertainty.

use std::ops::Range;
use std::sync::{Arc, OnceLock};

use trueaxis_effects::{Level, Scene};
use trueaxis_selection::{
    Fit, FixedScan, Hypothesis, Null, Projection, Scan, Score, best_shape, rank,
};

use crate::engine::estimated::{ByShape, beside_shape};
use crate::engine::{Candidate, with_uncertainties};
use crate::{Cause, Rival};

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
pub(crate) struct Listed<'a> {
    /// The base model's projection.
    pub(crate) base: Projection,
    pub(crate) candidates: Arc<[Candidate<'a>]>,
}

/// The other hypotheses beside a model with causes.
pub(crate) struct Beside {
    /// The model.
    pub(crate) model: Projection,
    /// Those that are physically possible, the one with the most evidence first.
    pub(crate) scores: Vec<Score>,
    /// Those of a size that no machine has.
    pub(crate) impossible: Vec<Score>,
    pub(crate) scans: Vec<Box<dyn Scan>>,
    /// Which candidate each scan is.
    pub(crate) numbers: Vec<usize>,
    null: OnceLock<Null>,
}

/// A cause against the model with the others.
pub(crate) struct Judged {
    pub(crate) cause: Chosen,
    pub(crate) score: Score,
    /// Its fit.
    pub(crate) fit: Fit,
    pub(crate) beside: Beside,
}

/// A cause with its parameters in the model of all.
pub(crate) struct Sized {
    /// Of its linear parameters; a covariance for observations of variance one.
    pub(crate) fit: Fit,
    /// Standard uncertainty of its shape for such observations, if it joined them.
    pub(crate) u_shape: Option<f64>,
}

/// What a shape of a list must explain, in units of the noise, for what a better one in between explains beyond it to matter.
const WORTH_REFINING: f64 = 20.0;

/// Parts of the distance of two neighbours in the list to which a shape is found: to compare what it explains, and in the end.
const ROUGHLY: f64 = 1e-2;
const REFINED: f64 = 1e-5;

impl<'a> Listed<'a> {
    pub(crate) fn hypothesis(&self, cause: &Chosen) -> &Hypothesis {
        &self.candidates[cause.candidate].hypothesis
    }

    /// The candidate that a score is of.
    pub(crate) fn candidate(&self, beside: &Beside, score: &Score) -> &Candidate<'a> {
        &self.candidates[beside.numbers[score.scan]]
    }

    /// The columns of a cause.
    pub(crate) fn columns_of(&self, cause: &Chosen) -> Vec<Vec<f64>> {
        let candidate = &self.candidates[cause.candidate];
        candidate.columns(cause.shape).into_owned()
    }

    /// The columns of causes, one cause after the other.
    pub(crate) fn columns(&self, causes: &[Chosen]) -> Vec<Vec<f64>> {
        let of_each = causes.iter().map(|cause| self.columns_of(cause));
        of_each.flatten().collect()
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
        let worth = WORTH_REFINING * model.squares() / model.degrees_of_freedom.max(1.0);
        let (mut scans, mut numbers): (Vec<Box<dyn Scan>>, _) = (Vec::new(), Vec::new());
        for (number, candidate) in self.candidates.iter().enumerate() {
            if causes.iter().any(|cause| cause.candidate == number) {
                continue;
            }
            let columns = |shape: f64| candidate.columns(shape).into_owned();
            let shapes = &candidate.shapes;
            let Some(mut scan) = FixedScan::new(candidate.hypothesis, &model, shapes, columns)
            else {
                continue;
            };
            let best = best_shape(&model, &scan).filter(|(_, explained, _)| *explained > worth);
            let finer = best.and_then(|(shape, ..)| candidate.refined(&model, shape, ROUGHLY));
            if let Some(shape) = finer {
                scan.add(&model, shape, &candidate.columns(shape));
            }
            scans.push(Box::new(scan));
            numbers.push(number);
        }
        let is_possible = |s: &Score| self.candidates[numbers[s.scan]].is_possible(&model, s.shape);
        let scores = rank(&model, &scans).into_iter();
        let (scores, impossible) = scores.partition(is_possible);
        Beside {
            model,
            scores,
            impossible,
            scans,
            numbers,
            null: OnceLock::new(),
        }
    }

    /// A scored hypothesis as a cause, with its shape as close as the data tell it.
    pub(crate) fn chosen(&self, beside: &Beside, score: &Score) -> Chosen {
        let candidate = self.candidate(beside, score);
        let shape = candidate.refined(&beside.model, score.shape, REFINED);
        let shape = shape.unwrap_or(score.shape);
        let u_instant = candidate.u_instant(&beside.model, shape);
        Chosen {
            candidate: beside.numbers[score.scan],
            shape,
            u_shape: u_instant.unwrap_or(score.u_shape),
        }
    }

    /// All causes free together, with those of their shapes that take every value.
    pub(crate) fn sizes(&self, causes: &[Chosen]) -> Vec<Sized> {
        let linear = Fit::new(&self.base, &self.columns(causes));
        let (mut first, mut columns, mut places) = (0, Vec::new(), Vec::new());
        for cause in causes {
            let candidate = &self.candidates[cause.candidate];
            let own = candidate.columns(cause.shape);
            let of_linear = first..first + own.len();
            first = of_linear.end;
            let values = &linear.estimates[of_linear.clone()];
            let by_shape = candidate.by_shape(values, cause.shape);
            let by_shape = by_shape.and_then(|by_shape| ByShape::new(by_shape, &own));
            let place = columns.len();
            columns.extend(own.into_owned());
            let unit = by_shape.map(|by_shape| {
                columns.push(by_shape.column);
                by_shape.unit
            });
            places.push((of_linear, place..columns.len(), unit));
        }
        let all = Fit::new(&self.base, &columns);
        let of_cause = |((of_linear, place, unit), cause): ((Range<usize>, _, _), &Chosen)| {
            let (count, joint) = (of_linear.len(), all.part(place));
            let is_limit = || self.candidates[cause.candidate].is_limit(cause.shape);
            let (covariance, u_shape) = match unit {
                None => (joint.covariance, is_limit().then_some(f64::INFINITY)),
                Some(unit) => {
                    let (covariance, u) = beside_shape(&joint, count, unit);
                    (covariance, Some(u))
                }
            };
            Sized {
                fit: Fit {
                    covariance,
                    ..linear.part(of_linear)
                },
                u_shape,
            }
        };
        places.into_iter().zip(causes).map(of_cause).collect()
    }

    /// Cause `k` if the others are in the model; `None` if they leave nothing of it.
    pub(crate) fn judge(&self, causes: &[Chosen], k: usize) -> Option<Judged> {
        let beside = self.beside(&without(causes, k));
        let score = beside.score_of(&causes[k])?;
        Some(Judged {
            cause: causes[k],
            score,
            fit: Fit::new(&beside.model, &self.columns_of(&causes[k])),
            beside,
        })
    }

    /// A judged cause with its parameters from a fit of its columns to observations of this variance, and the standard uncertainty
    /// of its shape; its size in the data and its rivals are to be filled in.
    pub(crate) fn cause(
        &self,
        judged: &Judged,
        (scene, level): (&Scene, Level),
        (fit, u_shape): (&Fit, f64),
        variance: f64,
    ) -> Cause {
        let candidate = &self.candidates[judged.cause.candidate];
        let own = fit.part(0..candidate.plausible.len());
        let covariance: Vec<f64> = own.covariance.iter().map(|c| c * variance).collect();
        let linear = (&own.estimates[..], &covariance[..], &own.seen[..]);
        let shape = (judged.cause.shape, u_shape);
        let parameters = with_uncertainties(scene, &candidate.hypothesis, linear, shape);
        let effect = candidate.resolved(&own.estimates, judged.cause.shape);
        Cause {
            p_value: judged.beside.null().family_wise(judged.score.ln_p),
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
            let columns = self.candidate(beside, score).columns(score.shape);
            let other = Fit::new(&beside.model, &columns);
            is_close(score, &other, &columns).then(|| self.rival(beside, score, &other))
        };
        others.filter_map(rival).collect()
    }

    /// A scored hypothesis with its fit as a rival.
    pub(crate) fn rival(&self, beside: &Beside, score: &Score, fit: &Fit) -> Rival {
        let candidate = self.candidate(beside, score);
        Rival::Effect {
            effect: candidate.resolved(&fit.estimates, score.shape),
            delta_bic: score.bic,
        }
    }
}

impl Beside {
    /// That of a cause that is not in the model.
    pub(crate) fn score_of(&self, cause: &Chosen) -> Option<Score> {
        let mut scores = self.scores.iter();
        let own = scores.find(|score| self.numbers[score.scan] == cause.candidate);
        own.copied()
    }

    /// Whether noise alone gives a p-value as small somewhere with a probability below `level`.
    pub(crate) fn is_significant(&self, score: &Score, level: f64) -> bool {
        Null::decided(&self.scans, score.ln_p, level)
            .unwrap_or_else(|| self.null().family_wise(score.ln_p) < level)
    }

    fn null(&self) -> &Null {
        self.null
            .get_or_init(|| Null::simulated(&self.model, &self.scans))
    }
}

/// All causes but one.
pub(crate) fn without(causes: &[Chosen], k: usize) -> Vec<Chosen> {
    let others = causes.iter().enumerate().filter(|(i, _)| *i != k);
    others.map(|(_, cause)| *cause).collect()
}
