//! A hypothesis with all its shapes.

use trueaxis_effects::{
    Circumstances, Displaced, Effect, Parameter, ResolvedEffect, Scene, Shape, Subject,
};
use trueaxis_leastsquares::lane_products::LaneMatrix;

use crate::Gram;

/// An effect of the catalogue on one subject.
#[derive(Debug, Clone, Copy)]
pub struct Hypothesis {
    /// The effect.
    pub effect: &'static Effect,
    /// The subject.
    pub subject: Subject,
    /// Number of subjects of the same effect that are compared.
    pub subjects: usize,
}

impl Hypothesis {
    /// An effect on each of some subjects.
    pub fn of_each(effect: &'static Effect, subjects: Vec<Subject>) -> Vec<Self> {
        let count = subjects.len();
        let of_one = |subject| Self {
            effect,
            subject,
            subjects: count,
        };
        subjects.into_iter().map(of_one).collect()
    }

    /// Whether both are the same effect on the same subject.
    pub fn is(&self, other: &Self) -> bool {
        self.effect.id == other.effect.id && self.subject == other.subject
    }

    /// Whether it is one course in time common to all readings, or to all of one target: wandering looks like such a
    /// course, and several together draw any course.
    pub fn is_of_time(&self) -> bool {
        self.subject.axis.is_none()
    }

    /// Its linear parameters.
    pub fn parameters(&self, scene: &Scene) -> Vec<Parameter> {
        self.effect.parameters(scene, &self.subject)
    }

    /// What a unit of a parameter does to a reading at a shape.
    pub fn form(&self, parameter: usize, shape: f64, at: &Circumstances<'_>) -> Displaced {
        self.effect.form(&self.subject, parameter, shape, at)
    }

    /// The effect with these values.
    pub fn resolved(&self, parameters: Vec<f64>, shape: f64) -> ResolvedEffect {
        ResolvedEffect {
            effect: self.effect,
            subject: self.subject,
            parameters,
            shape,
        }
    }

    /// Whether a shape has to be found.
    pub fn has_shape(&self) -> bool {
        self.effect.shape != Shape::Fixed
    }
}

/// A shape to be tried.
#[derive(Debug, Clone, Copy)]
pub struct Tried {
    /// Its instant (s), time constant (s), period or order.
    pub shape: f64,
    /// For an instant the length of the gap that it represents, s: the data only say that it lies in the gap.
    pub gap_s: Option<f64>,
    /// Whether noise is also compared with it ([`Scan::for_each_of`]), which its p-value needs.
    pub is_tested: bool,
}

impl Tried {
    /// A shape with which noise is also compared.
    pub fn new(shape: f64) -> Self {
        Self {
            shape,
            gap_s: None,
            is_tested: true,
        }
    }
}

/// Called with a shape, its Gram matrix and `s = Xᵀ e`.
pub type OfOne<'a> = dyn FnMut(Tried, &Gram, &[f64]) + 'a;

/// Called with a Gram matrix and `s = Xᵀ e` of several residuals: a row for each parameter.
pub type OfSeveral<'a> = dyn FnMut(&Gram, LaneMatrix<'_>) + 'a;

/// A hypothesis, ready to be compared with residuals.
pub trait Scan: Send + Sync {
    /// The effect and its subject.
    fn hypothesis(&self) -> &Hypothesis;

    /// Calls `f` for each shape with its Gram matrix and `s = Xᵀ e`.
    fn for_each(&self, residuals: &[f64], f: &mut OfOne<'_>);

    /// Number of shapes that are tested.
    fn tests(&self) -> usize;

    /// The same for several residuals at once, the columns of a matrix, and only for shapes that are tested.
    fn for_each_of(&self, residuals: LaneMatrix<'_>, f: &mut OfSeveral<'_>);

    /// The columns of one shape, whitened, not projected.
    fn columns(&self, shape: f64) -> Vec<Vec<f64>>;
}
