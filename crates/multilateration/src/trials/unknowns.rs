//! A value for every unknown: a correction, a step, a gradient.

use super::coordinates::Coordinates;

/// Points and shared unknowns.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Unknowns {
    pub(crate) points: Coordinates,
    /// Columns of the adjustment: x y z L of each station, then the dead paths after interruptions.
    pub(crate) shared: Vec<f64>,
}

impl Unknowns {
    pub(crate) fn zeros(points: usize, shared: usize) -> Self {
        Self {
            points: Coordinates::zeros(points),
            shared: vec![0.0; shared],
        }
    }

    #[inline(always)]
    pub(crate) fn fill(&mut self, value: f64) {
        self.points.fill(value);
        self.shared.fill(value);
    }

    #[inline(always)]
    pub(crate) fn add(&mut self, other: &Self) {
        self.points.add(&other.points);
        for (value, other) in self.shared.iter_mut().zip(&other.shared) {
            *value += other;
        }
    }

    #[inline(always)]
    pub(crate) fn dot(&self, other: &Self) -> f64 {
        let shared = self.shared.iter().zip(&other.shared);
        self.points.dot(&other.points) + shared.map(|(a, b)| a * b).sum::<f64>()
    }
}
