//! Whether repeated points scatter as declared, and how well the machine returns if nothing is declared.
//!
//! The readings of one visit of a step share the machine's repeatability error. With the weight `w` (3 x 3) of the
//! own noise of a reading, all together have the covariance `S = diag(w⁻¹) + ρ² [same visit]`. With the readings `e` less
//! the means of their targets, and `X`, which says of which target each is, what no constant position of each target
//! explains is
//!
//! ```text
//! χ² = eᵀ S⁻¹ e - gᵀ (Xᵀ S⁻¹ X)⁻¹ g     g = Xᵀ S⁻¹ e     (S⁻¹ e)_j = w_j (e_j - κ_v Σ_v w e)
//! ```
//!
//! with `κ_v = ρ² (1 + ρ² Σ_v w)⁻¹` of its visit (Woodbury). A displacement common to all targets of a
//! visit counts once, not once for each target.
//!
//! An undeclared ρ makes the sum of the weighted squares equal its expectation (C. R. Henderson, *Biometrics* 9, 226,
//! 1953, method 1), with the variance `s²` of unit weight by the rigid triangle, free of displacements of visits:
//!
//! ```text
//! Q = Σ eᵀ w e     E Q = s² ν + ρ² tr A      A_vv' = Σ_v w [v = v'] - Σ_t w_tv w_t⁻¹ w_tv'      of all steps
//! var Q = 2 (s⁴ ν + 2 s² ρ² tr A + ρ⁴ tr A²)
//! ```
//!
//! The same sum tests a declared ρ: `Q / E Q` follows F with `2 (E Q)² / var Q` and `2 (E Q)² / (ν² var s²)` degrees of
//! freedom (Satterthwaite).

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector, Matrix2, Matrix3, Vector3};
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

    fn traces_of_visits(&self) -> [f64; 2] {
        let groups = self.groups.iter().zip(&self.readings);
        let traces =
            groups.map(|(group, readings)| traces_of_visits(readings, group.targets.len()));
        traces.fold([0.0; 2], |sum, own| [sum[0] + own[0], sum[1] + own[1]])
    }
}

/// `tr A` and `tr A²` of one step. The noise of a target has one form there, `w_tv = h_tv w_t` with its share `h`, so that
/// with `D_v = Σ_v w` the last is `Σ tr D_v (D_v - 2 Σ_t h_tv² w_t) + Σ_tt' (Σ_v h_tv h_t'v)² tr w_t w_t'`.
fn traces_of_visits(readings: &[GroupReading], targets: usize) -> [f64; 2] {
    let mut of_targets = vec![Matrix3::zeros(); targets];
    for reading in readings {
        of_targets[reading.place] += reading.weight();
    }
    let (mut trace, mut of_square) = (0.0, 0.0);
    let mut products = DMatrix::<f64>::zeros(targets, targets);
    for Visit { shares, weight, .. } in by_visit(readings).values() {
        let own: Matrix3<f64> = shares.iter().map(|(&t, h)| of_targets[t] * (h * h)).sum();
        trace += (weight - own).trace();
        of_square += (weight * (weight - own * 2.0)).trace();
        for (&t, h) in shares {
            let others = shares.iter();
            others.for_each(|(&k, other)| products[(t, k)] += h * other);
        }
    }
    for (t, of_t) in of_targets.iter().enumerate() {
        for (k, of_k) in of_targets.iter().enumerate() {
            of_square += products[(t, k)].powi(2) * (of_t * of_k).trace();
        }
    }
    [trace, of_square]
}

impl GroupReading {
    /// Of its own noise, 1/mm².
    fn weight(&self) -> Matrix3<f64> {
        // Coordinates of any instrument have noise in all directions.
        self.own_mm2.try_inverse().unwrap_or_else(Matrix3::zeros)
    }
}

/// Sums over the readings of one visit.
#[derive(Default)]
struct Visit {
    /// The sum of the shares of each target.
    shares: BTreeMap<usize, f64>,
    /// `Σ w` of each target, and of all.
    weights: BTreeMap<usize, Matrix3<f64>>,
    weight: Matrix3<f64>,
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
        let sum = Matrix3::identity() + visit.weight * repeatability_variance_mm2;
        let inverse = sum.try_inverse().unwrap_or_else(Matrix3::zeros);
        inverse * repeatability_variance_mm2
    };
    let shrinkages: BTreeMap<usize, Matrix3<f64>> = visits
        .iter()
        .map(|(&v, visit)| (v, shrinkage(visit)))
        .collect();
    let mut normal = DMatrix::zeros(3 * targets, 3 * targets);
    for (v, visit) in &visits {
        let shrinkage = shrinkages[v];
        for (&a, of_a) in &visit.weights {
            let mut own = normal.fixed_view_mut::<3, 3>(3 * a, 3 * a);
            own += of_a;
            for (&b, of_b) in &visit.weights {
                let mut common = normal.fixed_view_mut::<3, 3>(3 * a, 3 * b);
                common -= of_a * shrinkage * of_b;
            }
        }
    }
    let mut squares = 0.0;
    let mut gradient = DVector::zeros(3 * targets);
    for reading in readings {
        let visit = &visits[&reading.visit];
        let e = reading.off_mean_mm;
        let whitened = reading.weight() * (e - shrinkages[&reading.visit] * visit.weighted);
        squares += e.dot(&whitened);
        let mut of_place = gradient.fixed_rows_mut::<3>(3 * reading.place);
        of_place += whitened;
    }
    // Every target has a reading, and ρ² is finite: the positions are determined.
    if let Some(normal) = normal.cholesky() {
        squares -= gradient.dot(&normal.solve(&gradient));
    }
    (squares.max(0.0), degrees)
}

fn by_visit(readings: &[GroupReading]) -> BTreeMap<usize, Visit> {
    let mut visits: BTreeMap<usize, Visit> = BTreeMap::new();
    for reading in readings {
        let (visit, weight) = (visits.entry(reading.visit).or_default(), reading.weight());
        *visit.shares.entry(reading.place).or_default() += reading.share;
        *visit.weights.entry(reading.place).or_default() += weight;
        visit.weight += weight;
        visit.weighted += weight * reading.off_mean_mm;
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
                own_mm2: form(place) / weight(place, visit),
                share: weight(place, visit) / sum,
                off_mean_mm: e(place, visit) - weighted / sum,
            }
        };
        all.iter().map(reading).collect()
    }

    /// Noise that differs between targets and directions.
    fn form(place: usize) -> Matrix3<f64> {
        let skew = Vector3::new(1.0, -2.0, 0.5 * place as f64);
        Matrix3::from_diagonal_element(0.3 + place as f64) + skew * skew.transpose()
    }

    #[test]
    fn it_is_least_squares_with_the_whole_covariance() {
        let wild = |place: usize, visit: usize| {
            let phase = (7 * place + 3 * visit) as f64;
            Vector3::new(phase.sin(), (2.0 * phase).cos(), (phase * phase).sin())
        };
        let readings = readings(wild);
        let rows = 3 * readings.len();
        let same = |i: usize, j: usize| f64::from(u8::from(i % 3 == j % 3));
        let targets = DMatrix::from_fn(rows, 9, |i, t| match readings[i / 3].place == t / 3 {
            true => same(i, t),
            false => 0.0,
        });
        let common = DMatrix::from_fn(rows, 9, |i, v| match readings[i / 3].visit == v / 3 {
            true => same(i, v),
            false => 0.0,
        });
        let e = DVector::from_fn(rows, |i, _| readings[i / 3].off_mean_mm[i % 3]);
        // What positions of the targets leave.
        let left = |weight: &DMatrix<f64>| {
            let normal = targets.transpose() * weight * &targets;
            let through = weight * &targets * normal.try_inverse().unwrap();
            weight - through * targets.transpose() * weight
        };
        let covariance = |variance: f64| {
            let mut covariance = &common * common.transpose() * variance;
            for (i, reading) in readings.iter().enumerate() {
                let mut own = covariance.fixed_view_mut::<3, 3>(3 * i, 3 * i);
                own += reading.own_mm2;
            }
            covariance
        };
        for variance in [0.0, 0.3, 100.0] {
            let weight = covariance(variance).try_inverse().unwrap();
            let expected = (e.transpose() * left(&weight) * &e)[0];
            let (squares, degrees) = scatter_of_repeats(&readings, 3, variance);
            assert!(
                (squares - expected).abs() < 1e-10 * expected,
                "{squares} {expected}"
            );
            assert_eq!(degrees, 3 * (8 - 3));
        }
        let a = common.transpose() * left(&covariance(0.0).try_inverse().unwrap()) * &common;
        let [trace, of_square] = traces_of_visits(&readings, 3);
        assert!((trace - a.trace()).abs() < 1e-10 * trace);
        assert!((of_square - (&a * &a).trace()).abs() < 1e-10 * of_square);
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
