//! Hypotheses with whitened columns for a list of shapes: readings and runs, where nothing is adjusted anew.
//!
//! The list is so dense that little is lost between its shapes. Where that matters, a better shape between the
//! neighbours of the best one is sought ([`Finer`](crate::engine::linear::Finer)) and joins the list for this model. A period or
//! time constant joins the parameters by its derivative ([`Listed::sizes`]): all then include its uncertainty.

use std::collections::VecDeque;
use std::ops::Range;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use trueaxis_effects::{Level, Scene};
use trueaxis_selection::{
    Fit, FixedScan, Hypothesis, Null, Projection, Scan, Score, best_shape, rank,
};

use crate::engine::estimated::{ByShape, beside_shape};
use crate::engine::linear::Candidate;
use crate::engine::{with_uncertainties, without};
use crate::{Cause, Rival};

/// A hypothesis in the model, at one shape.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Chosen {
    /// Index of the candidate.
    pub(crate) candidate: usize,
    pub(crate) shape: f64,
    /// Standard deviation of the shape.
    pub(crate) u_shape: f64,
}

/// The data, and the candidates that may explain them.
#[derive(Clone)]
pub(crate) struct Listed<'a> {
    /// The base model's projection.
    pub(crate) base: Projection,
    pub(crate) candidates: Arc<[Candidate<'a>]>,
    /// The latest comparisons.
    known: Arc<Mutex<Known>>,
}

/// Comparisons beside causes (candidate and shape of each), the latest last: searches, judgements and 2 ln B ask for
/// the same ones again.
type Known = VecDeque<(Vec<(usize, u64)>, Arc<Beside>)>;

/// The other hypotheses beside a model with causes.
pub(crate) struct Beside {
    pub(crate) model: Projection,
    /// The physically possible ones, the one with the largest 2 ln B first.
    pub(crate) scores: Vec<Score>,
    /// Those of an impossible size.
    pub(crate) impossible: Vec<Score>,
    pub(crate) scans: Vec<Box<dyn Scan>>,
    /// Index of the candidate of each scan.
    pub(crate) numbers: Vec<usize>,
    null: OnceLock<Null>,
}

/// A cause judged against the model with the others.
pub(crate) struct Judged {
    pub(crate) cause: Chosen,
    pub(crate) score: Score,
    pub(crate) fit: Fit,
    pub(crate) beside: Arc<Beside>,
}

/// A cause with its parameters, with all causes in the model.
pub(crate) struct Sized {
    /// Fit of its linear parameters; the covariance is for observations of unit variance.
    pub(crate) fit: Fit,
    /// Standard uncertainty of its shape for such observations, if the shape joined the parameters.
    pub(crate) u_shape: Option<f64>,
}

/// Least statistic of a listed shape, in units of the noise, for which a better shape in between matters.
const WORTH_REFINING: f64 = 20.0;

/// Comparisons that are kept.
const KEPT: usize = 16;

/// Accuracy of a shape for comparisons, as a share of the distance of its neighbours in the list.
const ROUGHLY: f64 = 1e-2;

impl<'a> Listed<'a> {
    pub(crate) fn new(base: Projection, candidates: Arc<[Candidate<'a>]>) -> Self {
        Self {
            base,
            candidates,
            known: Arc::default(),
        }
    }

    /// The same candidates for another base model.
    pub(crate) fn on(&self, base: Projection) -> Self {
        Self::new(base, Arc::clone(&self.candidates))
    }

    pub(crate) fn hypothesis(&self, cause: &Chosen) -> &Hypothesis {
        &self.candidates[cause.candidate].hypothesis
    }

    pub(crate) fn candidate(&self, beside: &Beside, score: &Score) -> &Candidate<'a> {
        &self.candidates[beside.numbers[score.scan]]
    }

    pub(crate) fn columns_of(&self, cause: &Chosen) -> Vec<Vec<f64>> {
        let candidate = &self.candidates[cause.candidate];
        candidate.columns(cause.shape)
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

    /// The hypotheses that the data see beside a model with causes, with the candidate of each.
    ///
    /// No effect occurs twice on the same subject, except what warms up, with time constants that are [`are_two`].
    pub(crate) fn beside(&self, causes: &[Chosen]) -> Arc<Beside> {
        let lock = || self.known.lock().unwrap_or_else(PoisonError::into_inner);
        let key = |cause: &Chosen| (cause.candidate, cause.shape.to_bits());
        let key: Vec<(usize, u64)> = causes.iter().map(key).collect();
        let take = |known: &mut Known| {
            let place = known.iter().position(|(own, _)| *own == key)?;
            known.remove(place)
        };
        let earlier = take(&mut lock());
        let beside = earlier.map_or_else(|| Arc::new(self.compared(causes)), |known| known.1);
        let mut known = lock();
        if known.len() == KEPT {
            known.pop_front();
        }
        known.push_back((key, Arc::clone(&beside)));
        beside
    }

    fn compared(&self, causes: &[Chosen]) -> Beside {
        let model = self.with(causes);
        let worth = WORTH_REFINING * model.squares() / model.degrees_of_freedom.max(1.0);
        let (mut scans, mut numbers): (Vec<Box<dyn Scan>>, _) = (Vec::new(), Vec::new());
        for (number, candidate) in self.candidates.iter().enumerate() {
            let own = causes.iter().filter(|cause| cause.candidate == number);
            let own: Vec<f64> = own.map(|cause| cause.shape).collect();
            let (hypothesis, columns) = (candidate.hypothesis, candidate.columns_beside(&own));
            let Some(mut scan) = FixedScan::of_columns(hypothesis, &model, &columns) else {
                continue;
            };
            let best = best_shape(&model, &scan).filter(|(_, explained, _)| *explained > worth);
            let finer = best.and_then(|(shape, ..)| candidate.refined(&model, shape, ROUGHLY));
            if let Some(shape) = finer {
                scan.add(&model, shape, candidate.columns(shape));
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

    /// A scored hypothesis as a cause, with its shape as accurate as the data show it.
    pub(crate) fn chosen(&self, beside: &Beside, score: &Score) -> Chosen {
        let candidate = self.candidate(beside, score);
        let shape = candidate.converged(&beside.model, score.shape);
        let u_instant = candidate.u_instant(&beside.model, shape);
        Chosen {
            candidate: beside.numbers[score.scan],
            shape,
            u_shape: u_instant.unwrap_or(score.u_shape),
        }
    }

    /// The parameters of all causes together, including shapes that take any value.
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
            columns.extend(own);
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

    /// Judges cause `k` with the others in the model; `None` if they leave nothing of it.
    pub(crate) fn judge(&self, causes: &[Chosen], k: usize) -> Option<Judged> {
        let beside = self.beside(&without(causes, k));
        let score = beside.score_of(&causes[k])?;
        Some(self.judged(beside, causes[k], score))
    }

    /// A cause beside others with its score.
    pub(super) fn judged(&self, beside: Arc<Beside>, cause: Chosen, score: Score) -> Judged {
        let fit = Fit::new(&beside.model, &self.columns_of(&cause));
        Judged {
            cause,
            score,
            fit,
            beside,
        }
    }

    /// A judged cause with its parameters from a fit of its columns to observations of this variance, and the
    /// standard uncertainty of its shape; its size in the data and its rivals are filled in later.
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
    /// The score of a cause that is not in the model.
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
