//! A hypothesis with the whitened columns of a list of shapes, and of those between them.

use std::borrow::Cow;

use trueaxis_effects::ResolvedEffect;
use trueaxis_leastsquares::dot;
use trueaxis_selection::{Fit, FixedScan, Hypothesis, Projection, Scan, middle, rank};

use crate::engine::between::{golden_section, neighbours};
use crate::engine::derivative;

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
    /// Of a size that changes from row to row what a unit of each parameter is of it there, over which it has a mean square. The range of
    /// the first parameter applies to that, too: the parameters are its value and slope where nobody may have measured. Empty of any other.
    pub(crate) sizes: Vec<Vec<f64>>,
}

/// Shapes between those of a list.
pub(crate) struct Finer<'a> {
    /// Whitened columns of any shape.
    pub(crate) columns: ColumnsAt<'a>,
    /// All gaps in which an instant may lie, s, the first one first; `None` for a shape that may have any value.
    pub(crate) gaps_s: Option<Vec<[f64; 2]>>,
    /// Of these as many on either side of an instant as it may be in, too.
    pub(crate) nearby: usize,
    /// The shortest that is told from others. One of the list below it stands alone, and may as well be shorter: of waves of two
    /// steps the positions show one phase, and beside them the other one would fit with any size.
    pub(crate) shortest: f64,
}

/// Whitened columns of a shape.
type ColumnsAt<'a> = Box<dyn Fn(f64) -> Vec<Vec<f64>> + Send + Sync + 'a>;

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

    /// Whether it is one parameter, which follows no course.
    pub(crate) fn is_simple(&self) -> bool {
        self.plausible.len() == 1 && !self.is_of_any_form()
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
    pub(super) fn refined(&self, model: &Projection, shape: f64, part: f64) -> Option<f64> {
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
    pub(super) fn u_instant(&self, model: &Projection, instant: f64) -> Option<f64> {
        let finer = self.finer.as_ref()?;
        let all = finer.gaps_s.as_ref()?;
        let own = all.iter().position(|gap| middle(gap) >= instant)?;
        let near = own.saturating_sub(finer.nearby)..all.len().min(own + finer.nearby + 1);
        let columns = |shape: f64| self.columns(shape).into_owned();
        let scan = FixedScan::of_instants(self.hypothesis, model, &all[near], columns)?;
        let scans: [Box<dyn Scan>; 1] = [Box::new(scan)];
        rank(model, &scans).first().map(|score| score.u_shape)
    }

    /// What the observations change by with the shape of an effect with values; none of one that has nothing in between.
    pub(super) fn by_shape(&self, values: &[f64], shape: f64) -> Option<Vec<f64>> {
        let finer = self.finer_at(shape).filter(|f| f.gaps_s.is_none())?;
        Some(derivative(&finer.columns, values, shape))
    }

    /// The shapes around one; none around one that stands alone.
    fn finer_at(&self, shape: f64) -> Option<&Finer<'_>> {
        self.finer.as_ref().filter(|f| f.shortest <= shape)
    }

    /// Whether a shape is but an upper limit.
    pub(super) fn is_limit(&self, shape: f64) -> bool {
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
    pub(super) fn is_possible(&self, model: &Projection, shape: f64) -> bool {
        let is_any = self.plausible.iter().all(Option::is_none);
        // In the noise that is left with it: without it most of what is left may be its own.
        let is_possible = |columns: &[Vec<f64>]| {
            let fit = Fit::new(model, columns);
            let freedom = model.degrees_of_freedom - columns.len() as f64;
            let variance = (model.squares() - fit.gained()).max(0.0) / freedom.max(1.0);
            fit.is_possible(&self.plausible, variance) && self.has_possible_size(&fit, variance)
        };
        is_any || is_possible(&self.columns(shape))
    }

    /// Whether a size that changes from row to row may have a root mean square in the plausible range.
    fn has_possible_size(&self, fit: &Fit, variance: f64) -> bool {
        let Some([_, most]) = self.plausible.first().copied().flatten() else {
            return true;
        };
        let [size, u] = self.root_mean_square(fit, variance);
        size - 3.0 * u <= most
    }

    /// Root mean square of such a size, and of its standard uncertainties; zeros of any other.
    pub(crate) fn root_mean_square(&self, fit: &Fit, variance: f64) -> [f64; 2] {
        let n = fit.estimates.len();
        let mut squares = [0.0; 2];
        for there in &self.sizes {
            let there = &there[..n];
            let of_covariance = |k: usize| dot(&fit.covariance[k * n..(k + 1) * n], there);
            squares[0] += dot(there, &fit.estimates).powi(2);
            squares[1] += (0..n).map(|k| there[k] * of_covariance(k)).sum::<f64>() * variance;
        }
        squares.map(|sum| (sum / self.sizes.len().max(1) as f64).max(0.0).sqrt())
    }
}
