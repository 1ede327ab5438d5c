//! Whether repeated points scatter as declared, and how well the machine returns if nothing is declared.
//!
//! The readings of one visit of a step share the machine's repeatability error, so that their covariance along each
//! direction is `S = diag(1/w) + ρ² [same visit]`. With the readings `e` less the means of their targets, and `X`,
//! which says of which target each is, what no constant position of each target explains is
//!
//! ```text
//! χ² = eᵀ S⁻¹ e - gᵀ (Xᵀ S⁻¹ X)⁻¹ g     g = Xᵀ S⁻¹ e     (S⁻¹ e)_j = w_j (e_j - κ_v Σ_v w e)
//! ```
//!
//! with `κ_v = ρ² / (1 + ρ² Σ_v w)` of its visit (Sherman and Morrison). A displacement common to all targets of a
//! visit counts once, not once for each target.
//!
//! An undeclared ρ makes the sum of the weighted squares equal its expectation (C. R. Henderson, *Biometrics* 9, 226,
//! 1953, method 1), with the variance `s²` of unit weight by the rigid triangle, free of displacements of visits:
//!
//! ```text
//! Q = Σ w e²      E Q = s² ν + ρ² tr A      A_vv' = Σ_v w [v = v'] - Σ_t w_tv w_tv' / w_t      of all directions and steps
//! var Q = 2 (s⁴ ν + 2 s² ρ² tr A + ρ⁴ tr A²)
//! ```
//!
//! The same sum tests a declared ρ: `Q / E Q` follows F with `2 (E Q)² / var Q` and `2 (E Q)² / (ν² var s²)` degrees of
//! freedom (Satterthwaite).

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector, Matrix2, Vector3};
use trueaxis_leastsquares::f_upper_tail;
use trueaxis_screening::{LEAST_DEGREES_OF_FREEDOM, TOO_GOOD};

use crate::points::{GroupReading, MeasuredPoints};
use crate::report::{GLOBAL_TEST_LEVEL, MANY};

impl MeasuredPoints {
    /// χ² of the repeated readings of all steps about their means, and its degrees of freedom.
    pub(crate) fn repeat_scatter(&self) -> (f64, usize) {
        self.scatter_with(self.repeatability_variance_mm2)
    }

    fn scatter_with(&self, repeatability_variance_mm2: f64) -> (f64, usize) {
        let groups = self.groups.iter().zip(&self.readings);
        let of_groups = groups.map(|(group, readings)| {
            scatter_of_repeats(readings, group.targets.len(), repeatability_variance_mm2)
        });
        of_groups.fold((0.0, 0), |(squares, degrees), (s, d)| {
            (squares + s, degrees + d)
        })
    }

    /// How well visits separate the noise of the instrument from the machine's repeatability, which all targets of a
    /// visit share: 0 where each visit sees one target, up to 1. For `n` targets in each visit it is `1 - 1/n`, which
    /// is `1 - ρ²` of the estimates of both parts from the repeats.
    pub(crate) fn separation(&self) -> f64 {
        let readings: usize = self.readings.iter().map(Vec::len).sum();
        let visits: usize = self.readings.iter().map(|of| by_visit(of).len()).sum();
        1.0 - visits as f64 / readings.max(1) as f64
    }

    /// The p-value of repeats that reject this ρ² (mm²), because they scatter too much or too little; `None` if they
    /// do not. `unit` is as in [`Self::repeatability_by_repeats`].
    pub(crate) fn rejected_repeatability(
        &self,
        variance: f64,
        unit: f64,
        relative_variance: f64,
    ) -> Option<f64> {
        let (squares, degrees) = self.scatter_with(0.0);
        if degrees == 0 {
            return None;
        }
        let [trace, of_square] = self.traces_of_visits();
        let by_unit = unit * degrees as f64;
        let expected = by_unit + variance * trace;
        let of_squares =
            2.0 * unit * (by_unit + 2.0 * variance * trace) + 2.0 * variance * variance * of_square;
        let freedom = |variance: f64| (2.0 * expected * expected / variance).min(MANY);
        let own = freedom(of_squares);
        let of_unit = freedom(by_unit * by_unit * relative_variance);
        let above = f_upper_tail(squares / expected, own, of_unit);
        // Repeats that scatter much less than the instrument alone are no measurements.
        let is_credible =
            own >= LEAST_DEGREES_OF_FREEDOM && squares > TOO_GOOD * TOO_GOOD * by_unit;
        let p_value = match above < 0.5 {
            true => above,
            false if is_credible => (1.0 - above).max(f64::EPSILON),
            false => 1.0,
        };
        (p_value < GLOBAL_TEST_LEVEL).then_some(p_value)
    }

    /// ρ² by the repeats, mm²; `None` if there are none or they scatter no more than `unit` explains. With it the
    /// relative covariance of `unit`, the variance of unit weight whose relative variance is given, and of ρ².
    pub(crate) fn repeatability_by_repeats(
        &self,
        unit: f64,
        relative_variance: f64,
    ) -> Option<(f64, Matrix2<f64>)> {
        let (squares, degrees) = self.scatter_with(0.0);
        let excess = squares - unit * degrees as f64;
        if degrees == 0 || excess <= 0.0 {
            return None;
        }
        let [trace, of_square] = self.traces_of_visits();
        let variance = excess / trace;
        let by_unit = unit * degrees as f64;
        let of_squares =
            2.0 * (unit * by_unit + 2.0 * unit * excess + variance * variance * of_square);
        let own = of_squares + by_unit * by_unit * relative_variance;
        let common = -by_unit * relative_variance / excess;
        let relative = Matrix2::new(relative_variance, common, common, own / (excess * excess));
        Some((variance, relative))
    }

    /// `tr A` and `tr A²`. With `A = D - B Bᵀ`, `D_v = Σ_v w` and `B_vt = w_tv / √w_t`, the last is
    /// `Σ D² - 2 Σ D (B Bᵀ)_vv + tr (Bᵀ B)²`, and `Bᵀ B` has as many rows as there are targets.
    fn traces_of_visits(&self) -> [f64; 2] {
        let (mut trace, mut of_square) = (0.0, 0.0);
        for (group, readings) in self.groups.iter().zip(&self.readings) {
            let visits = by_visit(readings);
            let mut of_targets = vec![0.0; group.targets.len()];
            let weights = visits.values().flat_map(|visit| &visit.weights);
            weights.for_each(|(&t, w)| of_targets[t] += w);
            let mut products = DMatrix::<f64>::zeros(of_targets.len(), of_targets.len());
            for Visit { weights, .. } in visits.values() {
                let scaled = weights.iter().map(|(&t, w)| (t, w / of_targets[t].sqrt()));
                let scaled: Vec<(usize, f64)> = scaled.collect();
                let all: f64 = weights.values().sum();
                let own: f64 = scaled.iter().map(|(_, b)| b * b).sum();
                trace += 3.0 * (all - own);
                of_square += 3.0 * all * (all - 2.0 * own);
                for (t, b) in &scaled {
                    scaled.iter().for_each(|(k, c)| products[(*t, *k)] += b * c);
                }
            }
            of_square += 3.0 * products.norm_squared();
        }
        [trace, of_square]
    }
}

/// Sums over the readings of one visit.
#[derive(Default)]
struct Visit {
    /// The sum of the weights of each target.
    weights: BTreeMap<usize, f64>,
    /// `Σ w e`.
    weighted: Vector3<f64>,
}

/// χ² of the readings of one step, of `targets` targets, about their means, and its degrees of freedom.
fn scatter_of_repeats(
    readings: &[GroupReading],
    targets: usize,
    repeatability_variance_mm2: f64,
) -> (f64, usize) {
    let degrees = 3 * readings.len().saturating_sub(targets);
    if degrees == 0 {
        return (0.0, 0);
    }
    let visits = by_visit(readings);
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
    // Every target has a reading, and ρ² is finite: the positions are determined.
    if let Some(normal) = normal.cholesky() {
        let explained = gradient.iter().map(|g| g.dot(&normal.solve(g)));
        squares -= explained.sum::<f64>();
    }
    (squares.max(0.0), degrees)
}

fn by_visit(readings: &[GroupReading]) -> BTreeMap<usize, Visit> {
    let mut visits: BTreeMap<usize, Visit> = BTreeMap::new();
    for reading in readings {
        let visit = visits.entry(reading.visit).or_default();
        *visit.weights.entry(reading.place).or_default() += reading.weight;
        visit.weighted += reading.weight * reading.off_mean_mm;
    }
    visits
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

    /// A displacement common to all targets of a visit counts once.
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
