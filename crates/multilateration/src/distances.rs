//! Distances between adjusted points that keep their distance, with the errors.
//!
//! ```text
//! d = |p_a - p_b|     dd = hᵀ x + gᵀ s     x = ξ - Z s
//! ```
//!
//! where `x` are the unknowns of a group with free points; deformations of bodies are among the shared unknowns `s`.

use nalgebra::{DMatrix, DVector, Vector3};

use crate::bodies::Deformations;
use crate::{Corrections, Network, Solution};

/// Two points whose distance does not change.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pair {
    /// Places of a body.
    OfBody {
        /// The body.
        body: usize,
        /// Its places.
        places: [usize; 2],
    },
    /// Points of a group whose points are free.
    OfGroup {
        /// The group.
        group: usize,
        /// Its points.
        points: [usize; 2],
    },
}

/// Distances, and how they depend on the errors of the adjustment.
#[derive(Debug, Clone, PartialEq)]
pub struct Distances {
    /// The distances, mm.
    pub values_mm: Vec<f64>,
    /// Coefficients of the shared sources `s` ([`crate::BlockNoise::shared`]), a row for each distance.
    pub of_shared: DMatrix<f64>,
    /// Covariance of the part that does not come through the shared sources, `hᵀ D h`, mm².
    pub own: DMatrix<f64>,
    /// `h` with its group, and `g`.
    of_groups: Vec<Option<(usize, DVector<f64>)>>,
    of_shapes: Vec<Vec<(usize, f64)>>,
}

impl Solution {
    /// The distances of some pairs; `network` must be the one that was solved.
    ///
    /// # Panics
    /// If there is no such body, group or point.
    pub fn distances(&self, network: &Network, pairs: &[Pair]) -> Distances {
        let (count, width) = (pairs.len(), self.covariance.factors.width());
        let mut found = Distances {
            values_mm: Vec::with_capacity(count),
            of_shared: DMatrix::zeros(count, width),
            own: DMatrix::zeros(count, count),
            of_groups: Vec::with_capacity(count),
            of_shapes: Vec::with_capacity(count),
        };
        for (k, pair) in pairs.iter().enumerate() {
            let (beam_mm, of_group, of_shape) = match *pair {
                Pair::OfBody { body, places } => {
                    let beam_mm = self.shapes_mm[body][places[0]] - self.shapes_mm[body][places[1]];
                    (beam_mm, None, deformed(network, body, places, beam_mm))
                }
                Pair::OfGroup { group, points } => {
                    let own = &self.points_mm[network.groups[group].clone()];
                    let beam_mm = own[points[0]] - own[points[1]];
                    let mut h = DVector::zeros(3 * own.len());
                    for (point, sign) in points.into_iter().zip([1.0, -1.0]) {
                        h.fixed_rows_mut::<3>(3 * point)
                            .copy_from(&(beam_mm.normalize() * sign));
                    }
                    (beam_mm, Some((group, h)), Vec::new())
                }
            };
            found.values_mm.push(beam_mm.norm());
            for &(column, g) in &of_shape {
                found.of_shared[(k, column)] += g;
            }
            if let Some((group, h)) = &of_group {
                let through = self.covariance.factors.coupling_transposed(*group) * h;
                found.of_shared.row_mut(k).tr_copy_from(&-through);
                let factor = self.covariance.factors.inverse_factor(*group);
                let own = factor.tr_mul(h);
                for (other, seen) in found.of_groups.iter().enumerate() {
                    if let Some((_, h)) = seen.as_ref().filter(|(other, _)| other == group) {
                        let both = factor.tr_mul(h).dot(&own);
                        (found.own[(k, other)], found.own[(other, k)]) = (both, both);
                    }
                }
                found.own[(k, k)] = own.norm_squared();
            }
            found.of_groups.push(of_group);
            found.of_shapes.push(of_shape);
        }
        found
    }
}

impl Distances {
    /// The changes of the distances in a trial, mm.
    pub fn changes_mm(&self, corrections: &Corrections) -> Vec<f64> {
        let all = self.of_groups.iter().zip(&self.of_shapes);
        let change = all.map(|(of_group, of_shape)| {
            let shared = corrections.shared_mm();
            let by_shape: f64 = of_shape.iter().map(|&(k, g)| g * shared[k]).sum();
            let by_group = of_group.as_ref().map_or(0.0, |(group, h)| {
                let moved = corrections.group(*group).iter();
                moved.zip(h.iter()).map(|(x, h)| x * h).sum()
            });
            by_shape + by_group
        });
        change.collect()
    }
}

/// Effect of the deformations of a body on the distance between two points.
fn deformed(
    network: &Network,
    body: usize,
    [a, b]: [usize; 2],
    beam_mm: Vector3<f64>,
) -> Vec<(usize, f64)> {
    let all = Deformations::new(network);
    let unit = beam_mm.normalize();
    let own = all.of_bodies[body].iter();
    let along = own.map(|d| unit.dot(&(d.fixed_rows::<3>(3 * a) - d.fixed_rows::<3>(3 * b))));
    (all.first[body]..).zip(along).collect()
}
