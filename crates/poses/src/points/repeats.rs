//! Whether repeated points scatter as declared.
//!
//! The readings of one visit of a step share the machine's repeatability error, so that their covariance along each
//! direction is `S = diag(1/w) + ρ² [same visit]`. With `e` the readings less the means of their targets and `X` the
//! targets, what no constant place of each target explains is
//!
//! ```text
//! χ² = eᵀ S⁻¹ e - gᵀ (Xᵀ S⁻¹ X)⁻¹ g     g = Xᵀ S⁻¹ e     (S⁻¹ e)_j = w_j (e_j - κ_v Σ_v w e)
//! ```
//!
//! with `κ_v = ρ² / (1 + ρ² Σ_v w)` of its visit (Sherman and Morrison). A displacement that all targets of a visit
//! share counts once, not once for each target.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector, Vector3};

use crate::points::GroupReading;

/// What the readings of one visit add up to.
#[derive(Default)]
struct Visit {
    /// Of each target, the sum of the weights.
    weights: BTreeMap<usize, f64>,
    /// `Σ w e`.
    weighted: Vector3<f64>,
}

/// χ² of the readings of one step, of `targets` targets, about their means, and its degrees of freedom.
pub(crate) fn scatter_of_repeats(
    readings: &[GroupReading],
    targets: usize,
    repeatability_variance_mm2: f64,
) -> (f64, usize) {
    let degrees = 3 * readings.len().saturating_sub(targets);
    if degrees == 0 {
        return (0.0, 0);
    }
    let mut visits: BTreeMap<usize, Visit> = BTreeMap::new();
    for reading in readings {
        let visit = visits.entry(reading.visit).or_default();
        *visit.weights.entry(reading.place).or_default() += reading.weight;
        visit.weighted += reading.weight * reading.off_mean_mm;
    }
    let shrinkage = |visit: &Visit| {
        let sum: f64 = visit.weights.values().sum();
        repeatability_variance_mm2 / (1.0 + repeatability_variance_mm2 * sum)
    };
    let mut normal = DMatrix::zeros(targets, targets);
    for visit in visits.values() {
        for (&a, of_a) in &visit.weights {
            normal[(a, a)] += of_a;
            for (&b, of_b) in &visit.weights {
                normal[(a, b)] -= shrinkage(visit) * of_a * of_b;
            }
        }
    }
    let mut squares = 0.0;
    let mut gradient: [DVector<f64>; 3] = std::array::from_fn(|_| DVector::zeros(targets));
    for reading in readings {
        let visit = &visits[&reading.visit];
        let e = reading.off_mean_mm;
        let whitened = reading.weight * (e - shrinkage(visit) * visit.weighted);
        squares += e.dot(&whitened);
        for (of_axis, value) in gradient.iter_mut().zip(&whitened) {
            of_axis[reading.place] += value;
        }
    }
    // Every target has a reading, and ρ² is finite: the places are determined.
    if let Some(normal) = normal.cholesky() {
        let explained = gradient.iter().map(|g| g.dot(&normal.solve(g)));
        squares -= explained.sum::<f64>();
    }
    (squares.max(0.0), degrees)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three targets read in each of three visits, the last one lacking a target, off their weighted means.
    fn readings(e: impl Fn(usize, usize) -> Vector3<f64>) -> Vec<GroupReading> {
        let visits = [vec![0, 1, 2], vec![0, 1, 2], vec![0, 2]];
        let weight = |place: usize, visit: usize| 1.0 + (3 * place + visit) as f64;
        let all: Vec<(usize, usize)> = visits
            .iter()
            .enumerate()
            .flat_map(|(visit, places)| places.iter().map(move |&place| (place, visit)))
            .collect();
        let reading = |&(place, visit): &(usize, usize)| {
            let of_target = all.iter().filter(|(other, _)| *other == place);
            let (sum, weighted) = of_target
                .fold((0.0, Vector3::zeros()), |(sum, weighted), &(p, v)| {
                    (sum + weight(p, v), weighted + weight(p, v) * e(p, v))
                });
            GroupReading {
                reading: 0,
                visit,
                place,
                weight: weight(place, visit),
                share: weight(place, visit) / sum,
                variance_mm2: 0.0,
                off_mean_mm: e(place, visit) - weighted / sum,
            }
        };
        all.iter().map(reading).collect()
    }

    #[test]
    fn it_is_least_squares_with_the_whole_covariance() {
        let wild = |place: usize, visit: usize| {
            let phase = (7 * place + 3 * visit) as f64;
            Vector3::new(phase.sin(), (2.0 * phase).cos(), (phase * phase).sin())
        };
        let readings = readings(wild);
        for variance in [0.0, 0.3, 100.0] {
            let count = readings.len();
            let covariance = DMatrix::from_fn(count, count, |i, j| {
                let (a, b) = (&readings[i], &readings[j]);
                let own = if i == j { 1.0 / a.weight } else { 0.0 };
                own + if a.visit == b.visit { variance } else { 0.0 }
            });
            let targets =
                DMatrix::from_fn(count, 3, |i, t| f64::from(u8::from(readings[i].place == t)));
            let whitened = covariance.try_inverse().unwrap();
            let normal = targets.transpose() * &whitened * &targets;
            let e = DMatrix::from_fn(count, 3, |i, c| readings[i].off_mean_mm[c]);
            let places = normal.try_inverse().unwrap() * targets.transpose() * &whitened * &e;
            let left = &e - &targets * places;
            let expected = (left.transpose() * whitened * &left).trace();
            let (squares, degrees) = scatter_of_repeats(&readings, 3, variance);
            assert!(
                (squares - expected).abs() < 1e-10 * expected,
                "{squares} {expected}"
            );
            assert_eq!(degrees, 3 * (8 - 3));
        }
    }

    /// What all targets of a visit have in common counts once.
    #[test]
    fn a_common_displacement_counts_once() {
        let common = readings(|_, visit| Vector3::new([0.0, 10.0, 0.0][visit], 0.0, 0.0));
        let (once, _) = scatter_of_repeats(&common, 3, 100.0);
        let (as_independent, _) = scatter_of_repeats(&common, 3, 0.0);
        // 10 against an expected scatter of 10: about one, not hundreds.
        assert!(once < 1.0, "{once}");
        assert!(as_independent > 100.0, "{as_independent}");
    }
}
