//! The search for causes: forward selection, the same for all kinds of data.
//!
//! 1. The hypothesis with the largest 2 ln B, among those that noise alone would not match, joins the causes.
//! 2. All causes are revised ([`revise`]): each is judged with the others in the model; a better one replaces it, its shape
//!    is sought again, and one that is not needed leaves. The first cause is often a compromise between two.
//! 3. The search ends when nothing joins, or when what joined is no cause of its own: the same problem under another
//!    name, no more than the shape of the others, or there only to cancel another.

use trueaxis_selection::Projection;

use crate::Error;
use crate::engine::{Found, are_opposed};

/// What differs between kinds of data. The table in [`crate::engine`] has the reasons.
pub(crate) trait Forward {
    /// A cause in a model.
    type Cause: Clone;

    /// A cause judged beside the others.
    type Found;

    /// The data with causes in the model.
    type Model;

    /// Most causes at once: more would be a list of names, not a diagnosis.
    fn most(&self) -> usize;

    /// The model with causes, in its own noise.
    fn fit(&self, causes: Vec<Self::Cause>) -> Result<Self::Model, Error>;

    /// The same in the noise of a model with other causes.
    fn fit_near(
        &self,
        _near: &Self::Model,
        causes: Vec<Self::Cause>,
    ) -> Result<Self::Model, Error> {
        self.fit(causes)
    }

    fn causes(model: &Self::Model) -> &[Self::Cause];

    /// What explains most of what a model leaves, if noise does not: a further cause, or what takes the place of `own`,
    /// which stays if it has as large a 2 ln B.
    fn best(&self, model: &Self::Model, own: Option<&Self::Cause>) -> Option<Self::Found>;

    fn cause(found: &Self::Found) -> &Self::Cause;

    /// Drop of the sum of squares by a cause.
    fn statistic(found: &Self::Found) -> f64;

    /// Whether a judged cause is another one than before, or has another shape.
    fn has_moved(before: &Self::Cause, now: &Self::Cause) -> bool;

    /// Two causes that hide each other, where none stands out.
    fn hidden(&self) -> Vec<Self::Cause> {
        Vec::new()
    }

    /// Seeks several shapes at once, where one at a time creeps.
    fn seek_together(&self, _causes: &mut [Self::Cause]) {}

    /// The causes with two names exchanged at once, if they explain more; as rivals if they explain as much.
    fn exchanged(
        &self,
        _model: &Self::Model,
        _found: &mut [Self::Found],
    ) -> Result<Option<Self::Model>, Error> {
        Ok(None)
    }

    /// A further cause that explains less than this share of what the others explain may be only their shape.
    fn shape_error(&self) -> f64 {
        SHAPE_ERROR
    }

    /// Whether one of several causes is the same problem as another, or not certain enough beside it.
    fn is_doubtful(&self, _found: &[Self::Found]) -> bool {
        false
    }

    /// The model without causes, and the whitened effect of each, where causes may cancel each other.
    fn effects<'m>(&'m self, _model: &'m Self::Model) -> Option<(&'m Projection, Vec<Vec<f64>>)> {
        None
    }
}

/// Causes with their judgement, the model with them, and what a further cause that is not a separate one would explain.
pub(crate) struct Search<M, F = Found> {
    pub(crate) found: Vec<F>,
    pub(crate) adjusted: M,
    pub(crate) left: f64,
}

impl<M, F> Search<M, F> {
    /// A model without causes.
    pub(crate) fn without_causes(adjusted: M) -> Self {
        Self {
            found: Vec::new(),
            adjusted,
            left: 0.0,
        }
    }
}

/// Adds causes to those of a model while there are any.
pub(crate) fn select<F: Forward>(
    search: &F,
    start: F::Model,
) -> Result<Search<F::Model, F::Found>, Error> {
    let mut selected = Search::without_causes(start);
    loop {
        // 1. What joins.
        let known = F::causes(&selected.adjusted);
        if known.len() >= search.most() {
            break;
        }
        let causes = match search.best(&selected.adjusted, None) {
            Some(next) => [known, &[F::cause(&next).clone()]].concat(),
            None if known.is_empty() => search.hidden(),
            None => break,
        };
        // 2. All are revised.
        let count = known.len();
        let (found, adjusted) = revise(search, causes)?;
        // 3. Whether there is one more, and of its own.
        if found.len() <= count {
            break;
        }
        if let Some(left) = not_its_own(search, &adjusted, &found) {
            selected.left = left;
            break;
        }
        (selected.found, selected.adjusted) = (found, adjusted);
    }
    Ok(selected)
}

/// Share of what the others explain that is no more than their shape, which is never quite that of the catalogue; for
/// the same reason a further cause must be more certain.
pub(crate) const SHAPE_ERROR: f64 = 0.05;
pub(crate) const FURTHER_LEVEL: f64 = 0.001;

/// What the weakest of several causes explains, if the last addition is not a separate cause.
fn not_its_own<F: Forward>(search: &F, model: &F::Model, found: &[F::Found]) -> Option<f64> {
    if found.len() < 2 {
        return None;
    }
    let all: f64 = found.iter().map(F::statistic).sum();
    let weakest = found.iter().map(F::statistic).fold(all, f64::min);
    let is_shape = weakest < search.shape_error() * (all - weakest);
    let is_none = is_shape || search.is_doubtful(found) || opposed(search, model);
    is_none.then_some(weakest)
}

/// Whether the causes of a model cancel each other.
fn opposed<F: Forward>(search: &F, model: &F::Model) -> bool {
    let effects = search.effects(model);
    effects.is_some_and(|(bare, effects)| are_opposed(bare, &effects))
}

/// Most exchanges of causes for better ones.
const MOST_EXCHANGES: usize = 6;

/// Relative accuracy to which shapes converge.
pub(crate) const RESTS: f64 = 1e-3;

/// Whether a shape is another one than before, beyond its standard deviation.
pub(crate) fn is_another(before: f64, (shape, u): (f64, f64)) -> bool {
    (shape - before).abs() > u.max(RESTS * before.abs())
}

/// All except `k`.
pub(crate) fn without<T: Clone>(all: &[T], k: usize) -> Vec<T> {
    [&all[..k], &all[k + 1..]].concat()
}

/// Judges each cause with the others in the model until nothing changes.
pub(crate) fn revise<F: Forward>(
    search: &F,
    mut causes: Vec<F::Cause>,
) -> Result<(Vec<F::Found>, F::Model), Error> {
    search.seek_together(&mut causes);
    let mut model = search.fit(causes.clone())?;
    let mut exchanges = 0;
    loop {
        let mut found = Vec::new();
        let mut changed = false;
        for k in 0..causes.len() {
            // In the noise left without it: a large disturbance hides its own rivals.
            let without = search.fit_near(&model, without(&causes, k))?;
            let Some(judged) = search.best(&without, Some(&causes[k])) else {
                causes.remove(k);
                changed = true;
                break;
            };
            if F::has_moved(&causes[k], F::cause(&judged)) && exchanges < MOST_EXCHANGES {
                exchanges += 1;
                changed = true;
            }
            causes[k] = F::cause(&judged).clone();
            found.push(judged);
        }
        model = search.fit(causes)?;
        if !changed {
            match search.exchanged(&model, &mut found)? {
                Some(other) if exchanges < MOST_EXCHANGES => {
                    exchanges += 1;
                    model = other;
                }
                _ => return Ok((found, model)),
            }
        }
        causes = F::causes(&model).to_vec();
    }
}
