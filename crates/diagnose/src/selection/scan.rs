//! A hypothesis with all its shapes.

use trueaxis_effects::{Effect, Shape, Subject};
use trueaxis_leastsquares::Lanes;

use crate::selection::Gram;

/// An effect of the catalogue on one subject.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Hypothesis {
    /// The effect.
    pub(crate) effect: &'static Effect,
    /// What it happens to.
    pub(crate) subject: Subject,
    /// Number of subjects of the same effect that are looked at.
    pub(crate) subjects: usize,
}

impl Hypothesis {
    /// Whether it is the same effect on the same subject.
    pub(crate) fn is(&self, other: &Self) -> bool {
        self.effect.id == other.effect.id && self.subject == other.subject
    }

    /// Whether it is one course in time of all readings, or of all of one target, alike: what wanders looks like one,
    /// and several together draw any course.
    pub(crate) fn is_of_time(&self) -> bool {
        self.subject.axis.is_none()
    }

    /// Whether a shape has to be found.
    pub(crate) fn has_shape(&self) -> bool {
        self.effect.shape != Shape::Fixed
    }
}

/// A shape that is tried.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Tried {
    pub(crate) shape: f64,
    /// Of an instant the length of the time that it stands for: the data say no more than that it lies in it, s.
    pub(crate) gap_s: Option<f64>,
    /// Whether noise is asked for it, too ([`Scan::for_each_of`]), so that it may say how likely noise is.
    pub(crate) is_tested: bool,
}

impl Tried {
    pub(crate) fn new(shape: f64) -> Self {
        Self {
            shape,
            gap_s: None,
            is_tested: true,
        }
    }
}

/// What is called with a shape, its Gram matrix and `s = Xᵀ e`.
pub(crate) type OfOne<'a> = dyn FnMut(Tried, &Gram, &[f64]) + 'a;

/// What is called with a Gram matrix and `s = Xᵀ e` of several residuals, side by side.
pub(crate) type OfSeveral<'a> = dyn FnMut(&Gram, &[Lanes]) + 'a;

/// A hypothesis, ready to be compared with residuals.
pub(crate) trait Scan: Send + Sync {
    /// What it says.
    fn hypothesis(&self) -> &Hypothesis;

    /// Calls `f` for each shape with its Gram matrix and `s = Xᵀ e`.
    fn for_each(&self, residuals: &[f64], f: &mut OfOne<'_>);

    /// The same of several residuals at once, for those that are tested.
    fn for_each_of(&self, residuals: &[Lanes], f: &mut OfSeveral<'_>);

    /// The columns of one shape, whitened, not projected.
    fn columns(&self, shape: f64) -> Vec<Vec<f64>>;
}
