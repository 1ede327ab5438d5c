//! Vectors as three arrays, so that loops over many of them work on eight at a time.

use nalgebra::Vector3;
use trueaxis_leastsquares::{LANES, Lanes, lanes_only};

/// Vectors at all points: all x, all y, all z. Behind the last point there are more, up to whole eights: zeros,
/// or what has weight zero wherever it is used.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Coordinates {
    count: usize,
    values: [Vec<f64>; 3],
}

impl Coordinates {
    pub(crate) fn zeros(count: usize) -> Self {
        let length = (count + LANES - 1).next_multiple_of(LANES);
        let values = [(); 3].map(|()| vec![0.0; length]);
        Self { count, values }
    }

    pub(crate) fn from_vectors(vectors: impl ExactSizeIterator<Item = Vector3<f64>>) -> Self {
        let mut all = Self::zeros(vectors.len());
        for (i, vector) in vectors.enumerate() {
            for (values, value) in all.values.iter_mut().zip(vector.iter()) {
                values[i] = *value;
            }
        }
        all
    }

    pub(crate) fn count(&self) -> usize {
        self.count
    }

    #[inline(always)]
    pub(crate) fn get(&self, i: usize) -> Vector3<f64> {
        let [x, y, z] = &self.values;
        Vector3::new(x[i], y[i], z[i])
    }

    #[inline(always)]
    pub(crate) fn add_at(&mut self, i: usize, vector: Vector3<f64>) {
        let [x, y, z] = &mut self.values;
        x[i] += vector.x;
        y[i] += vector.y;
        z[i] += vector.z;
    }

    /// x, y and z of all points.
    #[inline(always)]
    pub(crate) fn all(&self) -> [&[f64]; 3] {
        let [x, y, z] = &self.values;
        [&x[..self.count], &y[..self.count], &z[..self.count]]
    }

    #[inline(always)]
    pub(crate) fn all_mut(&mut self) -> [&mut [f64]; 3] {
        let [x, y, z] = &mut self.values;
        let count = self.count;
        [&mut x[..count], &mut y[..count], &mut z[..count]]
    }

    /// All points, and the zeros behind them, in eights.
    #[inline(always)]
    pub(crate) fn eights(&self) -> [&[[f64; LANES]]; 3] {
        let [x, y, z] = &self.values;
        [x.as_chunks().0, y.as_chunks().0, z.as_chunks().0]
    }

    #[inline(always)]
    pub(crate) fn eights_mut(&mut self) -> [&mut [[f64; LANES]]; 3] {
        let [x, y, z] = &mut self.values;
        [
            x.as_chunks_mut().0,
            y.as_chunks_mut().0,
            z.as_chunks_mut().0,
        ]
    }

    /// So many eights from a point on.
    #[inline(always)]
    pub(crate) fn eights_from(&self, first: usize, eights: usize) -> [&[[f64; LANES]]; 3] {
        let [x, y, z] = &self.values;
        let places = first..first + eights * LANES;
        [
            x[places.clone()].as_chunks().0,
            y[places.clone()].as_chunks().0,
            z[places].as_chunks().0,
        ]
    }

    #[inline(always)]
    pub(crate) fn eights_from_mut(
        &mut self,
        first: usize,
        eights: usize,
    ) -> [&mut [[f64; LANES]]; 3] {
        let [x, y, z] = &mut self.values;
        let places = first..first + eights * LANES;
        [
            x[places.clone()].as_chunks_mut().0,
            y[places.clone()].as_chunks_mut().0,
            z[places].as_chunks_mut().0,
        ]
    }

    #[inline(always)]
    pub(crate) fn fill(&mut self, value: f64) {
        for values in &mut self.values {
            values.fill(value);
        }
    }

    #[inline(always)]
    pub(crate) fn copy_from(&mut self, other: &Self) {
        for (values, others) in self.values.iter_mut().zip(&other.values) {
            values.copy_from_slice(others);
        }
    }

    #[inline(always)]
    pub(crate) fn add(&mut self, other: &Self) {
        for (values, others) in self.values.iter_mut().zip(&other.values) {
            for (value, other) in values.iter_mut().zip(others) {
                *value += other;
            }
        }
    }

    /// `Σ aᵀ b` over all points.
    #[inline(always)]
    pub(crate) fn dot(&self, other: &Self) -> f64 {
        let ([x, y, z], [u, v, w]) = (self.eights(), other.eights());
        (dot(x, u) + dot(y, v) + dot(z, w)).sum()
    }
}

/// `Σ a_i b_i` of each lane.
#[inline(always)]
pub(crate) fn dot(a: &[[f64; LANES]], b: &[[f64; LANES]]) -> Lanes {
    let mut sum = Lanes::ZERO;
    for (a, b) in a.iter().zip(b) {
        lanes_only();
        sum += Lanes(*a) * Lanes(*b);
    }
    sum
}

/// `Σ a_i` of each lane.
#[inline(always)]
pub(crate) fn sum(a: &[[f64; LANES]]) -> Lanes {
    let mut sum = Lanes::ZERO;
    for a in a {
        lanes_only();
        sum += Lanes(*a);
    }
    sum
}
