//! The noise of the points and their whitening, stop by stop.
//!
//! With `w` the declared standard deviations of the points of one stop in relative units, the coordinates along each
//! direction have the covariance `C = σ² diag(w²) + σ_m² 1 1ᵀ`; its part of rank one lets `C^-½` take only a few
//! operations for each point. The three directions are those of [`Base`](crate::points::base::Base): an instrument
//! that measures angles is worse across its beam than along it.

use crate::points::readings::{Reading, Readings};

/// The noise of the coordinates along each direction, mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Noise {
    /// Standard deviation where 1 µm, or nothing, is declared.
    pub(crate) own_mm: [f64; 3],
    /// Standard deviation of the machine's repeatability.
    pub(crate) return_mm: [f64; 3],
}

impl Noise {
    /// Multiplies coordinates of all points by `C^-½` of their stop, and by `weight` of the stop.
    pub(crate) fn whiten(&self, readings: &Readings, column: &mut [f64], weight: &[f64]) {
        for (stop, weight) in readings.stops.iter().zip(weight) {
            let rows = &mut column[3 * stop.start..3 * stop.end];
            self.whiten_stop(&readings.all[stop.clone()], rows, *weight);
        }
    }

    /// The same for the points of one stop.
    pub(crate) fn whiten_stop(&self, points: &[Reading], rows: &mut [f64], weight: f64) {
        for direction in 0..3 {
            let return_mm = self.return_of_mm(points, direction);
            let unit = |k: usize| points[k].weight * self.own_mm[direction];
            let squares = (0..points.len()).map(|k| (return_mm / unit(k)).powi(2));
            let squares: f64 = squares.sum();
            // The share that is taken from the common part of the points.
            let goes = match squares > 0.0 {
                true => (1.0 - 1.0 / (1.0 + squares).sqrt()) / squares,
                false => 0.0,
            };
            let mut common = 0.0;
            for k in 0..points.len() {
                let row = &mut rows[3 * k + direction];
                *row *= weight / unit(k);
                common += *row * return_mm / unit(k);
            }
            for k in 0..points.len() {
                rows[3 * k + direction] -= goes * common * return_mm / unit(k);
            }
        }
    }

    /// Undoes the whitening of coordinates of full weight, by `C^½`: mm.
    pub(crate) fn colour(&self, readings: &Readings, column: &mut [f64]) {
        for stop in &readings.stops {
            let points = &readings.all[stop.clone()];
            let rows = &mut column[3 * stop.start..3 * stop.end];
            for direction in 0..3 {
                let return_mm = self.return_of_mm(points, direction);
                let unit = |k: usize| points[k].weight * self.own_mm[direction];
                let relative = |k: usize| return_mm / unit(k);
                let squares: f64 = (0..points.len()).map(|k| relative(k).powi(2)).sum();
                let comes = match squares > 0.0 {
                    true => ((1.0 + squares).sqrt() - 1.0) / squares,
                    false => 0.0,
                };
                let along = |k: usize| rows[3 * k + direction] * relative(k);
                let common: f64 = (0..points.len()).map(along).sum();
                for k in 0..points.len() {
                    let row = &mut rows[3 * k + direction];
                    *row = unit(k) * (*row + comes * common * relative(k));
                }
            }
        }
    }

    /// Repeatability along a direction for the points of a stop; targets on the bed have none.
    fn return_of_mm(&self, points: &[Reading], direction: usize) -> f64 {
        match points.first() {
            Some(reading) if reading.pose.is_none() => 0.0,
            _ => self.return_mm[direction],
        }
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

    /// Variance of a point along each direction, mm².
    pub(crate) fn variances_mm2(&self, reading: &Reading) -> [f64; 3] {
        let repeatability = |k: usize| reading.pose.map_or(0.0, |_| self.return_mm[k].powi(2));
        std::array::from_fn(|k| (reading.weight * self.own_mm[k]).powi(2) + repeatability(k))
    }

    /// Standard deviation of a coordinate, mean over the points, µm.
    pub(crate) fn mean_um(&self, readings: &Readings) -> f64 {
        let squares = |of: [f64; 3]| of.iter().map(|x| x * x).sum::<f64>() / 3.0;
        let variance = |r: &Reading| {
            let of_repeatability = r.pose.map_or(0.0, |_| squares(self.return_mm));
            r.weight * r.weight * squares(self.own_mm) + of_repeatability
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
