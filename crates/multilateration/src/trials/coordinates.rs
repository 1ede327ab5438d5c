//! Vectors as three arrays, so that loops over many of them use vector registers.

use nalgebra::Vector3;

/// Neighbours that a loop takes together. Two vector registers of the plain x86-64, one with AVX.
pub(crate) const LANES: usize = 4;

/// As many values as a loop takes together.
pub(crate) type Lanes = [f64; LANES];

/// Vectors at all points: all x, all y, all z. Zeros behind the last point fill up the lanes that
/// start with it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Coordinates {
    count: usize,
    values: [Vec<f64>; 3],
}

impl Coordinates {
    pub(crate) fn zeros(count: usize) -> Self {
        let values = [(); 3].map(|()| vec![0.0; count + LANES - 1]);
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

    pub(crate) fn get(&self, i: usize) -> Vector3<f64> {
        Vector3::from(self.values.each_ref().map(|values| values[i]))
    }

    pub(crate) fn add_at(&mut self, i: usize, vector: Vector3<f64>) {
        for (values, value) in self.values.iter_mut().zip(vector.iter()) {
            values[i] += value;
        }
    }

    /// x, y and z of all points.
    pub(crate) fn all(&self) -> [&[f64]; 3] {
        self.values.each_ref().map(|values| &values[..self.count])
    }

    pub(crate) fn all_mut(&mut self) -> [&mut [f64]; 3] {
        self.values
            .each_mut()
            .map(|values| &mut values[..self.count])
    }

    /// So many lanes from a point on.
    pub(crate) fn lanes(&self, first: usize, lanes: usize) -> [&[Lanes]; 3] {
        let values = self.values.each_ref();
        values.map(|values| &values[first..][..lanes * LANES].as_chunks().0[..lanes])
    }

    pub(crate) fn lanes_mut(&mut self, first: usize, lanes: usize) -> [&mut [Lanes]; 3] {
        let values = self.values.each_mut();
        values.map(|values| &mut values[first..][..lanes * LANES].as_chunks_mut().0[..lanes])
    }

    pub(crate) fn fill(&mut self, value: f64) {
        for values in self.all_mut() {
            values.fill(value);
        }
    }

    pub(crate) fn add(&mut self, other: &Self) {
        for (values, others) in self.all_mut().into_iter().zip(other.all()) {
            for (value, other) in values.iter_mut().zip(others) {
                *value += other;
            }
        }
    }

    /// `Σ aᵀ b` over all points.
    pub(crate) fn dot(&self, other: &Self) -> f64 {
        let [x, y, z] = self.all();
        let [u, v, w] = other.all();
        dot(x, u) + dot(y, v) + dot(z, w)
    }
}

/// `Σ a_i b_i`, summed lane by lane: an order of additions that vector registers can follow.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let (a_lanes, a_rest) = a.as_chunks::<LANES>();
    let (b_lanes, b_rest) = b.as_chunks::<LANES>();
    let mut sums: Lanes = [0.0; LANES];
    for (a, b) in a_lanes.iter().zip(b_lanes) {
        for (sum, (a, b)) in sums.iter_mut().zip(a.iter().zip(b)) {
            *sum += a * b;
        }
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
    total(sums) + rest
}

/// `Σ a_i`, lane by lane.
pub(crate) fn sum(a: &[f64]) -> f64 {
    let (lanes, rest) = a.as_chunks::<LANES>();
    let mut sums = [0.0; LANES];
    for a in lanes {
        for (sum, a) in sums.iter_mut().zip(a) {
            *sum += a;
        }
    }
    total(sums) + rest.iter().sum::<f64>()
}

/// A value for each lane.
pub(crate) fn lanes(value: impl FnMut(usize) -> f64) -> Lanes {
    std::array::from_fn(value)
}

/// Sum of the lanes.
pub(crate) fn total(lanes: Lanes) -> f64 {
    lanes.iter().sum()
}
