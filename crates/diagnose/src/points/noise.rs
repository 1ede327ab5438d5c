//! The noise of the points and their whitening, stop by stop.
//!
//! The coordinates of a stop have the covariance `C = D + Σ ρ_k² u_k u_kᵀ`: along the rows of each point its own noise,
//! independent (`D`; [`trueaxis_screening::CoordinateNoise`] says along which directions, and in which ratio), and the
//! machine's repeatability along its axes, common to all points of the stop (`u_k`: that axis along the rows of each). Its
//! parts of rank one are taken out one after the other, which takes only a few operations for each point:
//!
//! ```text
//! W C Wᵀ = 1     W = P_3 P_2 P_1 D^-½     P_k = 1 - (1 - 1/√(1 + v_kᵀv_k)) v_k v_kᵀ / v_kᵀv_k     v_k = ρ_k P_{k-1} .. P_1 D^-½ u_k
//! ```

use nalgebra::Vector3;
use trueaxis_leastsquares::dot;

use crate::points::readings::{Reading, Readings};

/// The noise of the coordinates, mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Noise {
    /// Standard deviation along each row for one that is relatively 1 ([`Reading::relative`]).
    pub(crate) own_mm: [f64; 3],
    /// Standard deviation of the machine's repeatability along each of its axes.
    pub(crate) return_mm: [f64; 3],
}

/// The whitening of the coordinates of one stop.
#[derive(Debug, Clone)]
pub(crate) struct StopWhitening {
    /// Of the own noise of each coordinate, mm.
    sigmas_mm: Vec<f64>,
    /// `v_k`.
    common: [Vec<f64>; 3],
    /// `v_kᵀv_k`.
    squares: [f64; 3],
}

impl StopWhitening {
    /// Multiplies coordinates by `W`.
    pub(crate) fn apply(&self, rows: &mut [f64]) {
        rows.iter_mut()
            .zip(&self.sigmas_mm)
            .for_each(|(row, sigma)| *row /= sigma);
        (0..3).for_each(|k| self.take_out(k, rows));
    }

    fn take_out(&self, k: usize, rows: &mut [f64]) {
        let square = self.squares[k];
        if square > 0.0 {
            let share = (1.0 - 1.0 / (1.0 + square).sqrt()) / square;
            add(-share * dot(&self.common[k], rows), &self.common[k], rows);
        }
    }

    /// Multiplies whitened coordinates by `W⁻¹`: mm.
    pub(crate) fn colour(&self, rows: &mut [f64]) {
        for (common, square) in self.common.iter().zip(self.squares).rev() {
            if square > 0.0 {
                let share = ((1.0 + square).sqrt() - 1.0) / square;
                add(share * dot(common, rows), common, rows);
            }
        }
        rows.iter_mut()
            .zip(&self.sigmas_mm)
            .for_each(|(row, sigma)| *row *= sigma);
    }

    /// The whitened own noise of a coordinate.
    pub(crate) fn own(&self, row: usize) -> Vec<f64> {
        let mut column = vec![0.0; self.sigmas_mm.len()];
        column[row] = self.sigmas_mm[row];
        self.apply(&mut column);
        column
    }
}

fn add(factor: f64, of: &[f64], to: &mut [f64]) {
    to.iter_mut()
        .zip(of)
        .for_each(|(to, of)| *to += factor * of);
}

impl Noise {
    pub(crate) fn whitening(&self, readings: &Readings) -> Vec<StopWhitening> {
        let stops = readings.stops.iter();
        let of_stop = |stop: &std::ops::Range<usize>| self.of_stop(&readings.all[stop.clone()]);
        stops.map(of_stop).collect()
    }

    fn of_stop(&self, points: &[Reading]) -> StopWhitening {
        let sigmas = points
            .iter()
            .flat_map(|r| self.own_variances_mm2(r).map(f64::sqrt));
        let mut whitening = StopWhitening {
            sigmas_mm: sigmas.collect(),
            common: Default::default(),
            squares: [0.0; 3],
        };
        for k in 0..3 {
            // What is not yet set takes nothing out.
            let mut common = self.returns(points, k);
            whitening.apply(&mut common);
            whitening.squares[k] = dot(&common, &common);
            whitening.common[k] = common;
        }
        whitening
    }

    /// The coordinates of a stop for one standard deviation of the machine's repeatability along an axis, mm.
    pub(crate) fn returns(&self, points: &[Reading], axis: usize) -> Vec<f64> {
        let of_point = |r: &Reading| {
            let axis_in_rows: Vector3<f64> = r.rows_from_machine.column(axis).into();
            <[f64; 3]>::from(axis_in_rows * self.return_variances_mm2(r)[axis].sqrt())
        };
        points.iter().flat_map(of_point).collect()
    }

    /// The largest relative change of a variance; one that is now zero does not count. A variance held by a bound has
    /// not changed, whatever the data suggest.
    pub(crate) fn change_since(&self, before: &Self) -> f64 {
        let now = self.own_mm.iter().chain(&self.return_mm);
        let pairs = now.zip(before.own_mm.iter().chain(&before.return_mm));
        let changes = pairs
            .filter(|(now, _)| **now > 0.0)
            .map(|(now, before)| ((now / before).powi(2) - 1.0).abs());
        changes.fold(0.0, f64::max)
    }

    /// Variances of a point's own noise along its rows, mm².
    pub(crate) fn own_variances_mm2(&self, reading: &Reading) -> [f64; 3] {
        std::array::from_fn(|k| (reading.relative[k] * self.own_mm[k]).powi(2))
    }

    /// Variances of its repeatability along the machine's axes, mm²; targets on the bed have none.
    pub(crate) fn return_variances_mm2(&self, reading: &Reading) -> [f64; 3] {
        let is_moved = reading.pose.is_some();
        self.return_mm
            .map(|sigma| if is_moved { sigma * sigma } else { 0.0 })
    }

    /// Standard deviation of a coordinate, mean over the points, µm.
    pub(crate) fn mean_um(&self, readings: &Readings) -> f64 {
        let variance = |r: &Reading| {
            let of = self.own_variances_mm2(r).into_iter();
            of.chain(self.return_variances_mm2(r)).sum::<f64>() / 3.0
        };
        let sum: f64 = readings.all.iter().map(variance).sum();
        (sum / readings.all.len().max(1) as f64).sqrt() * 1e3
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A direction without noise stays at its bound; only real changes continue an iteration.
    #[test]
    fn what_a_bound_holds_does_not_change() {
        let before = Noise {
            own_mm: [2e-3, 1e-3, 1e-4],
            return_mm: [1e-3, 1e-3, 0.0],
        };
        let mut now = before;
        assert!(now.change_since(&before) < f64::MIN_POSITIVE);
        now.return_mm[0] = 0.0;
        assert!(now.change_since(&before) < f64::MIN_POSITIVE);
        now.own_mm[1] *= 2.0;
        assert!((now.change_since(&before) - 3.0).abs() < 1e-12);
        now.return_mm[2] = 1e-3;
        assert!(now.change_since(&before).is_infinite());
    }
}
