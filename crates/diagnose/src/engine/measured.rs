//! What differs between kinds of data, and what is found in all kinds.

use rayon::prelude::*;
use trueaxis_effects::{Effect, ResolvedEffect, Scene, Shape};
use trueaxis_selection::{Fit, Hypothesis, Projection, Score, VisitTimes, is_rival};

use crate::Error;
use crate::engine::disturbance::Wanderer;
use crate::engine::{Culprit, plausible};

/// Data of one kind with their base model.
pub(crate) trait Measured: Sync {
    /// The base model adjusted with causes.
    type Model: Send + Sync;

    type Noise: Copy + Send + Sync;

    /// Family-wise level of the causes.
    const CAUSE_LEVEL: f64;

    /// Most causes at once: more would be a list of names, not a diagnosis.
    const MOST_CAUSES: usize;

    fn scene(&self) -> &Scene;

    /// What the base model does not absorb.
    fn bare(model: &Self::Model) -> &Projection;

    /// What neither the base model nor the causes absorb.
    fn projection(model: &Self::Model) -> &Projection;

    /// The causes of a model with their parameters.
    fn suspects(model: &Self::Model) -> &[Suspect];

    /// The columns of a hypothesis for a shape, mm: the change of the rows of a model by a unit of each parameter.
    fn columns_mm<'m>(
        &'m self,
        model: &'m Self::Model,
    ) -> impl Fn(&Hypothesis, f64) -> Vec<Vec<f64>> + Sync + 'm;

    fn whiten(&self, model: &Self::Model, column: &mut [f64]);

    /// The same columns, whitened.
    fn columns<'m>(
        &'m self,
        model: &'m Self::Model,
    ) -> impl Fn(&Hypothesis, f64) -> Vec<Vec<f64>> + Sync + 'm {
        let columns_mm = self.columns_mm(model);
        move |hypothesis, shape| whitened(self, model, columns_mm(hypothesis, shape))
    }

    /// Rows and times between which an instant may lie.
    fn visits(&self) -> Vec<VisitTimes>;

    /// The time constants or lags to try, ascending.
    fn shapes(&self, shape: Shape) -> Vec<f64>;

    /// Adjusts everything with causes, starting from their present parameters, with this noise or the estimated one.
    fn adjust(
        &self,
        suspects: Vec<Suspect>,
        noise: Option<Self::Noise>,
    ) -> Result<Self::Model, Error>;

    /// The same with the noise of a model with other causes.
    fn adjust_near(
        &self,
        near: &Self::Model,
        suspects: Vec<Suspect>,
    ) -> Result<Self::Model, Error> {
        self.adjust(suspects, Some(Self::noise(near)))
    }

    fn noise(model: &Self::Model) -> Self::Noise;

    /// The causes with two names exchanged at once, where exchanging one at a time fails.
    fn exchanged(&self, _: &[Suspect]) -> Option<Vec<Suspect>> {
        None
    }

    /// What a cause blames.
    fn culprit(&self, suspect: &Suspect) -> Culprit;

    /// The range of each parameter of a hypothesis; a value outside rules the hypothesis out.
    fn plausible(&self, hypothesis: &Hypothesis) -> Vec<Option<[f64; 2]>> {
        plausible(hypothesis, self.scene())
    }

    /// Whether a hypothesis that explains at least half as much as a leader is indistinguishable from it.
    fn is_alike(leader: (&Hypothesis, &Score), other: (&Hypothesis, &Score), cosine: f64) -> bool {
        is_rival(leader.1, other.1, cosine)
    }
}

/// Whitens columns.
pub(crate) fn whitened<D: Measured + ?Sized>(
    data: &D,
    model: &D::Model,
    mut columns: Vec<Vec<f64>>,
) -> Vec<Vec<f64>> {
    let each = columns.par_iter_mut();
    each.for_each(|column| data.whiten(model, column));
    columns
}

/// Ratio of two time constants beyond which both can be there.
const APART: f64 = 3.0;

/// Whether an effect may be there twice: what warms up, with time constants so far apart, those of a spindle and of a bed.
pub(crate) fn are_two(effect: &Effect, a: f64, b: f64) -> bool {
    effect.shape == Shape::TimeConstant && a.max(b) > APART * a.min(b)
}

/// A cause with its parameters, linear at its shape.
#[derive(Debug, Clone)]
pub(crate) struct Suspect {
    pub(crate) hypothesis: Hypothesis,
    pub(crate) shape: f64,
    /// Standard deviation of the shape over its marginal likelihood.
    pub(crate) u_shape: f64,
    pub(crate) parameters: Vec<f64>,
    /// Covariance of the parameters, rows one after the other.
    pub(crate) covariance: Vec<f64>,
    /// Whether the data see all of each parameter.
    pub(crate) seen: Vec<bool>,
}

impl Suspect {
    /// A hypothesis fitted at a shape.
    pub(crate) fn new(hypothesis: Hypothesis, (shape, u_shape): (f64, f64), fit: &Fit) -> Self {
        Self {
            hypothesis,
            shape,
            u_shape,
            parameters: fit.estimates.clone(),
            covariance: fit.covariance.clone(),
            seen: fit.seen.clone(),
        }
    }

    /// Whether both are the same cause: what warms up may do so with two time constants.
    pub(crate) fn is(&self, other: &Self) -> bool {
        self.hypothesis.is(&other.hypothesis) && !self.is_second_time_constant(other)
    }

    /// Whether both are the same effect with two time constants.
    pub(crate) fn is_second_time_constant(&self, other: &Self) -> bool {
        let is_same = self.hypothesis.is(&other.hypothesis);
        is_same && are_two(self.hypothesis.effect, self.shape, other.shape)
    }

    /// The effect with its values.
    pub(crate) fn resolved(&self) -> ResolvedEffect {
        let parameters = self.parameters.clone();
        self.hypothesis.resolved(parameters, self.shape)
    }
}

/// A cause with its judgement with the others in the model.
#[derive(Debug, Clone)]
pub(crate) struct Found {
    pub(crate) suspect: Suspect,
    pub(crate) p_value: f64,
    /// Drop of the BIC by this cause.
    pub(crate) bic: f64,
    /// Twice the logarithm of its marginal likelihood ratio.
    pub(crate) two_ln_b: f64,
    /// Drop of the sum of squares by this cause.
    pub(crate) statistic: f64,
    /// Other effects that explain as much, with their BIC.
    pub(crate) rivals: Vec<(Suspect, f64)>,
    /// Disturbances that may have been there instead, with their 2 ln B.
    pub(crate) wandering: Vec<(Wanderer, f64)>,
}
