//! Hypotheses whose whitened columns are listed for every shape: readings and runs, where nothing is adjusted anew.
//!
//! The list has neighbours that hardly lose anything of what lies between them. Where that matters the best of a list is
//! looked for between its neighbours ([`Finer`]), and that joins the list of the hypothesis for this model. A period or time
//! constant joins the parameters by its derivative ([`Listed::sizes`]), so that all of them carry its uncertainty.

use std::borrow::Cow;
use std::ops::Range;
use std::sync::Arc;

use trueaxis_effects::{Level, ResolvedEffect, Scene};

use crate::engine::between::{golden_section, neighbours};
use crate::engine::estimated::beside_shape;
use crate::engine::{derivative, with_uncertainties};
use crate::selection::{
    Fit, FixedScan, Hypothesis, Null, Projection, Scan, Score, best_shape, dot, middle, rank,
};
use crate::{Cause, Rival};

/// An effect on a subject with the columns of all its shapes.
pub(crate) struct Candidate<'a> {
    pub(crate) hypothesis: Hypothesis,
    pub(crate) shapes: Vec<f64>,
    pub(crate) columns: Vec<Vec<Vec<f64>>>,
    /// The plausible range of each parameter.
    pub(crate) plausible: Vec<Option<[f64; 2]>>,
    /// Whether it has more columns than the effect has parameters: its size is a free function of the position.
    pub(crate) is_free: bool,
    /// Shapes between those of the list, where there are any.
    pub(crate) finer: Option<Finer<'a>>,
}

/// Shapes between those of a list.
pub(crate) struct Finer<'a> {
    /// Whitened columns of any shape.
    pub(crate) columns: ColumnsAt<'a>,
    /// All gaps in which an instant may lie, s, the first one first; `None` for a shape that may have any value.
    pub(crate) gaps_s: Option<Vec<[f64; 2]>>,
    /// The shortest that is told from others. One of the list below it stands alone, and may as well be shorter: of waves of two
    /// steps the positions show one phase, and beside them the other one would fit with any size.
    pub(crate) shortest: f64,
}

/// Whitened columns of a shape.
pub(crate) type ColumnsAt<'a> = Box<dyn Fn(f64) -> Vec<Vec<f64>> + Send + Sync + 'a>;

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

/// Gaps on either side of an instant in which it may be, too: what is farther off fits so much worse, unless hardly anything shows.
const GAPS_NEARBY: usize = 60;

/// Part of the level at which a free form is preferred to its mean and slope.
const FREE_FORM: f64 = 0.1;

impl Candidate<'_> {
    /// The effect with the values of its parameters, which come first.
    pub(crate) fn resolved(&self, estimates: &[f64], shape: f64) -> ResolvedEffect {
        let values = &estimates[..self.plausible.len()];
        self.hypothesis.resolved(values.to_vec(), shape)
    }

    /// Whether it follows many courses: one in time, or a free function of the position.
    pub(crate) fn is_of_any_form(&self) -> bool {
        self.hypothesis.is_of_time() || self.is_free
    }

    /// The columns at a shape: of the nearest in the list, if there are none between them.
    pub(crate) fn columns(&self, shape: f64) -> Cow<'_, [Vec<f64>]> {
        let distance = |k: &usize| (self.shapes[*k] - shape).abs();
        let nearest = (0..self.shapes.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)));
        match (nearest, &self.finer) {
            (Some(k), Some(finer)) if distance(&k) > 0.0 => Cow::Owned((finer.columns)(shape)),
            (Some(k), _) => Cow::Borrowed(&self.columns[k]),
            (None, _) => Cow::Borrowed(&[]),
        }
    }

    /// The shape between the neighbours of one in the list that explains most of what a model leaves, to a part of their distance;
    /// none where there is nothing in between.
    fn refined(&self, model: &Projection, shape: f64, part: f64) -> Option<f64> {
        let finer = self.finer_at(shape)?;
        let [before, after] = neighbours(&self.shapes, shape);
        let low = before.unwrap_or(shape).max(finer.shortest);
        let high = after.unwrap_or(shape);
        let gained = |shape: f64| Fit::new(model, &(finer.columns)(shape)).gained();
        match &finer.gaps_s {
            Some(all) => {
                // Before the first of the list, and after the last, there may be more.
                let low = before.unwrap_or(f64::NEG_INFINITY);
                let high = after.unwrap_or(f64::INFINITY);
                let between = all.iter().map(middle).filter(|&t| low <= t && t <= high);
                let between = between.map(|t| (t, gained(t)));
                between
                    .max_by(|a, b| a.1.total_cmp(&b.1))
                    .map(|(instant, _)| instant)
            }
            None => {
                let is_close = |a: f64, b: f64| b - a <= part * (high - low);
                Some(golden_section([low, high], is_close, gained))
            }
        }
    }

    /// Standard deviation of an instant over its marginal likelihood in the gaps nearby.
    fn u_instant(&self, model: &Projection, instant: f64) -> Option<f64> {
        let all = self.finer.as_ref()?.gaps_s.as_ref()?;
        let own = all.iter().position(|gap| middle(gap) >= instant)?;
        let near = own.saturating_sub(GAPS_NEARBY)..all.len().min(own + GAPS_NEARBY + 1);
        let columns = |shape: f64| self.columns(shape).into_owned();
        let scan = FixedScan::of_instants(self.hypothesis, model, &all[near], columns)?;
        let scans: [Box<dyn Scan>; 1] = [Box::new(scan)];
        rank(model, &scans).first().map(|score| score.u_shape)
    }

    /// What the observations change by with the shape of an effect with values; none of one that has nothing in between.
    fn by_shape(&self, values: &[f64], shape: f64) -> Option<Vec<f64>> {
        let finer = self.finer_at(shape).filter(|f| f.gaps_s.is_none())?;
        Some(derivative(&finer.columns, values, shape))
    }

    /// The shapes around one; none around one that stands alone.
    fn finer_at(&self, shape: f64) -> Option<&Finer<'_>> {
        self.finer.as_ref().filter(|f| f.shortest <= shape)
    }

    /// Whether a shape is but an upper limit.
    fn is_limit(&self, shape: f64) -> bool {
        self.finer.is_some() && self.finer_at(shape).is_none()
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
        is_any || Fit::new(model, &self.columns(shape)).is_possible(&self.plausible, variance)
    }
}

impl<'a> Listed<'a> {
    pub(crate) fn hypothesis(&self, cause: &Chosen) -> &Hypothesis {
        &self.candidates[cause.candidate].hypothesis
    }

    /// The candidate that a score is of.
    pub(crate) fn candidate(&self, beside: &Beside, score: &Score) -> &Candidate<'a> {
        &self.candidates[beside.numbers[score.scan]]
    }

    /// The columns of causes, one cause after the other.
    pub(crate) fn columns(&self, causes: &[Chosen]) -> Vec<Vec<f64>> {
        let of_cause = |chosen: &Chosen| self.candidates[chosen.candidate].columns(chosen.shape);
        let all = causes.iter().map(of_cause);
        all.flat_map(Cow::into_owned).collect()
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
        let mut scores = rank(&model, &scans);
        scores.retain(|s| self.candidates[numbers[s.scan]].is_possible(&model, s.shape));
        Beside {
            model,
            scores,
            scans,
            numbers,
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
            // What a shape does not change cannot tell it.
            let by_shape = by_shape.filter(|by_shape| dot(by_shape, by_shape) > 0.0);
            let place = columns.len();
            // As long as another column, so that what the data see of it is not taken for rounding.
            let scale = by_shape.as_ref().map(|by_shape| {
                let squares = own.iter().map(|column| dot(column, column));
                (squares.fold(0.0, f64::max) / dot(by_shape, by_shape)).sqrt()
            });
            columns.extend(own.into_owned());
            columns.extend(by_shape.zip(scale).map(|(mut by_shape, scale)| {
                by_shape.iter_mut().for_each(|x| *x *= scale);
                by_shape
            }));
            places.push((of_linear, place..columns.len(), scale));
        }
        let all = Fit::new(&self.base, &columns);
        let of_cause = |((of_linear, place, scale), cause): ((Range<usize>, _, _), &Chosen)| {
            let (count, joint) = (of_linear.len(), all.part(place));
            let is_limit = || self.candidates[cause.candidate].is_limit(cause.shape);
            let (covariance, u_shape) = match scale {
                None => (joint.covariance, is_limit().then_some(f64::INFINITY)),
                Some(scale) => {
                    let (covariance, u) = beside_shape(&joint, count);
                    (covariance, Some(u * scale))
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
            let other = Fit::new(&beside.model, &columns);
            is_close(score, &other, &columns).then(|| Rival::Effect {
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
