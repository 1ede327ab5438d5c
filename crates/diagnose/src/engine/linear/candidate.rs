//! A hypothesis with the whitened columns of a list of shapes, and of shapes between them.

use std::sync::Arc;

use trueaxis_effects::ResolvedEffect;
use trueaxis_leastsquares::dot;
use trueaxis_selection::{
    Fit, FixedScan, Hypothesis, Projection, Scan, ShapeColumns, middle, rank,
};

use crate::engine::between::{around, golden_section};
use crate::engine::{are_two, derivative};

/// An effect on a subject with the columns of all its shapes.
pub(crate) struct Candidate<'a> {
    pub(crate) hypothesis: Hypothesis,
    /// The columns of a list of shapes.
    pub(crate) columns: Arc<ShapeColumns>,
    /// The plausible range of each parameter.
    pub(crate) plausible: Vec<Option<[f64; 2]>>,
    /// Whether it has more columns than the effect has parameters: its size is then a free function of position.
    pub(crate) is_free: bool,
    /// Shapes between those of the list, if there are any.
    pub(crate) finer: Option<Finer<'a>>,
    /// Where the size changes from row to row, its derivatives in each row by the parameters, for its rms. The range
    /// of the first parameter then applies to the rms, too: the parameter may belong to an unmeasured position.
    pub(crate) sizes: Vec<Vec<f64>>,
}

/// Shapes between those of a list.
pub(crate) struct Finer<'a> {
    /// Whitened columns of any shape.
    pub(crate) columns: ColumnsAt<'a>,
    /// All gaps in which an instant may lie, s, in time order; `None` for a shape with any value.
    pub(crate) gaps_s: Option<Vec<[f64; 2]>>,
    /// Number of gaps on either side of an instant in which it may also lie.
    pub(crate) nearby: usize,
    /// The shortest shape that is distinguished from others. A listed shape below it stands alone and is an upper
    /// limit: of waves of two steps the positions show one phase, and the other phase would fit with any size.
    pub(crate) shortest: f64,
}

/// Accuracy of a shape in the end, as a share of the distance of its neighbours in the list.
const REFINED: f64 = 1e-5;

/// Whitened columns of a shape.
type ColumnsAt<'a> = Box<dyn Fn(f64) -> Vec<Vec<f64>> + Send + Sync + 'a>;

/// Share of the level at which a free form is preferred to its mean and slope.
const FREE_FORM: f64 = 0.1;

impl Candidate<'_> {
    /// The effect with the values of its parameters, which come first in `estimates`.
    pub(crate) fn resolved(&self, estimates: &[f64], shape: f64) -> ResolvedEffect {
        let values = &estimates[..self.plausible.len()];
        self.hypothesis.resolved(values.to_vec(), shape)
    }

    /// Whether it fits many courses: one in time, or a free function of position.
    pub(crate) fn is_of_any_form(&self) -> bool {
        self.hypothesis.is_of_time() || self.is_free
    }

    /// Whether it has one parameter and no such course.
    pub(crate) fn is_simple(&self) -> bool {
        self.plausible.len() == 1 && !self.is_of_any_form()
    }

    /// The columns of the shapes that it may have beside itself in the model with other shapes.
    pub(super) fn columns_beside(&self, shapes: &[f64]) -> Arc<ShapeColumns> {
        if shapes.is_empty() {
            return Arc::clone(&self.columns);
        }
        let listed = self.columns.shapes().enumerate();
        let others = listed.filter(|(_, shape)| {
            let mut all = shapes.iter();
            all.all(|own| are_two(self.hypothesis.effect, *own, *shape))
        });
        let others = others.map(|(k, shape)| (shape, self.columns.whole(k)));
        Arc::new(ShapeColumns::new(others))
    }

    /// The columns for a shape, or for the nearest in the list if there are none between.
    pub(crate) fn columns(&self, shape: f64) -> Vec<Vec<f64>> {
        let distances = self.columns.shapes().map(|own| (own - shape).abs());
        let nearest = distances.enumerate().min_by(|a, b| a.1.total_cmp(&b.1));
        match (nearest, &self.finer) {
            (Some((_, distance)), Some(finer)) if distance > 0.0 => (finer.columns)(shape),
            (Some((k, _)), _) => self.columns.whole(k),
            (None, _) => Vec::new(),
        }
    }

    /// The shape that explains most of what a model leaves, between the neighbours of a listed shape, to the share
    /// `part` of their distance; `None` if there are no shapes between.
    pub(super) fn refined(&self, model: &Projection, shape: f64, part: f64) -> Option<f64> {
        let finer = self.finer_at(shape)?;
        let shapes: Vec<f64> = self.columns.shapes().collect();
        let [before, after] = around(&shapes, shape);
        let low = before.unwrap_or(shape).max(finer.shortest);
        let high = after.unwrap_or(shape);
        let gained = |shape: f64| Fit::new(model, &(finer.columns)(shape)).gained();
        match &finer.gaps_s {
            Some(all) => {
                // There may be gaps before the first and after the last of the list.
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

    /// Whether there are shapes between those of the list, and none is an instant.
    pub(super) fn is_continuous(&self) -> bool {
        self.finer
            .as_ref()
            .is_some_and(|finer| finer.gaps_s.is_none())
    }

    /// A shape that explains most of what a model leaves, near another one.
    pub(super) fn converged(&self, model: &Projection, shape: f64) -> f64 {
        self.refined(model, shape, REFINED).unwrap_or(shape)
    }

    /// Standard deviation of an instant over its marginal likelihood in nearby gaps.
    pub(super) fn u_instant(&self, model: &Projection, instant: f64) -> Option<f64> {
        let finer = self.finer.as_ref()?;
        let all = finer.gaps_s.as_ref()?;
        let own = all.iter().position(|gap| middle(gap) >= instant)?;
        let near = own.saturating_sub(finer.nearby)..all.len().min(own + finer.nearby + 1);
        let columns = |shape: f64| self.columns(shape);
        let scan = FixedScan::of_instants(self.hypothesis, model, &all[near], columns)?;
        let scans: [Box<dyn Scan>; 1] = [Box::new(scan)];
        rank(model, &scans).first().map(|score| score.u_shape)
    }

    /// Derivative of the observations by the shape of an effect with values; `None` without shapes between.
    pub(super) fn by_shape(&self, values: &[f64], shape: f64) -> Option<Vec<f64>> {
        let finer = self.finer_at(shape).filter(|f| f.gaps_s.is_none())?;
        Some(derivative(&finer.columns, values, shape))
    }

    /// The shapes around a shape; `None` if it stands alone.
    fn finer_at(&self, shape: f64) -> Option<&Finer<'_>> {
        self.finer.as_ref().filter(|f| f.shortest <= shape)
    }

    /// Whether a shape is only an upper limit.
    pub(super) fn is_limit(&self, shape: f64) -> bool {
        self.finer.is_some() && self.finer_at(shape).is_none()
    }

    /// Logarithm of the largest p-value at which this form is preferred to a smaller one, if `level` is that of
    /// parametric forms. For a free form the best of several numbers of waves was taken; and it is named only if a
    /// simpler form is certainly too simple.
    pub(crate) fn ln_level_of_more(&self, level: f64) -> f64 {
        match self.is_free {
            true => (level * FREE_FORM / self.columns.shapes().len() as f64).ln(),
            false => level.ln(),
        }
    }

    /// Whether the data allow it a physical size: each value in its plausible range, within three standard
    /// uncertainties.
    pub(super) fn is_possible(&self, model: &Projection, shape: f64) -> bool {
        let is_any = self.plausible.iter().all(Option::is_none);
        // In the noise left with it: without it most of what is left may be its own effect.
        let is_possible = |columns: &[Vec<f64>]| {
            let fit = Fit::new(model, columns);
            let freedom = model.degrees_of_freedom - columns.len() as f64;
            let variance = (model.squares() - fit.gained()).max(0.0) / freedom.max(1.0);
            fit.is_possible(&self.plausible, variance) && self.has_possible_size(&fit, variance)
        };
        is_any || is_possible(&self.columns(shape))
    }

    /// Whether a size that changes from row to row may have an rms in the plausible range.
    fn has_possible_size(&self, fit: &Fit, variance: f64) -> bool {
        let Some([_, most]) = self.plausible.first().copied().flatten() else {
            return true;
        };
        let [size, u] = self.root_mean_square(fit, variance);
        size - 3.0 * u <= most
    }

    /// Root mean square of a size that changes from row to row, and of its standard uncertainties; otherwise zeros.
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
