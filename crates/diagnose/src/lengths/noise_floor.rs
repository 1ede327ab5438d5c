//! The noise of one length by the repeats.

use std::collections::HashMap;

use trueaxis_campaign::Direction;

use crate::lengths::adjusted::Adjusted;
use crate::lengths::base::Base;

/// Fewest degrees of freedom with which repeats show more than the adjustment.
const LEAST_DEGREES_OF_FREEDOM: usize = 30;

/// Station, step, side of approach, target.
type Visited = (usize, usize, Direction, usize);

/// Standard deviation of a length among its repeats (same station, step, side of approach and target), less the
/// effects of the causes, µm; without enough repeats the mean noise by the adjustment.
pub(crate) fn noise_floor_um(base: &Base<'_>, adjusted: &Adjusted) -> f64 {
    let mut groups: HashMap<Visited, (usize, f64, f64)> = HashMap::new();
    for (reading, length) in base.readings.iter().zip(&adjusted.network.readings) {
        let key = (
            reading.station,
            reading.step,
            reading.direction,
            reading.target,
        );
        // Welford's sums: lengths are a million times their scatter.
        let (count, mean, squares) = groups.entry(key).or_insert((0, 0.0, 0.0));
        *count += 1;
        let from_mean = length.length_mm - *mean;
        *mean += from_mean / *count as f64;
        *squares += from_mean * (length.length_mm - *mean);
    }
    let degrees_of_freedom: usize = groups.values().map(|g| g.0 - 1).sum();
    // In a fixed order: the sum must not depend on the order of the map.
    let mut squares: Vec<f64> = groups.values().map(|g| g.2).collect();
    squares.sort_by(f64::total_cmp);
    if degrees_of_freedom >= LEAST_DEGREES_OF_FREEDOM {
        let variance = squares.iter().sum::<f64>() / degrees_of_freedom as f64;
        return variance.sqrt() * 1e3;
    }
    mean_noise_um(base, adjusted)
}

/// Standard deviation of a length by its own noise and the machine's repeatability, mean over the lengths, µm.
pub(crate) fn mean_noise_um(base: &Base<'_>, adjusted: &Adjusted) -> f64 {
    let noise = &adjusted.network.noise;
    let variances = base.readings.iter().map(|reading| {
        let station = &adjusted.solution.stations[reading.station];
        let point = adjusted.solution.points_mm[reading.point];
        let distance_mm = (point - station.position_mm).norm();
        noise.length_sigma_at_mm(distance_mm).powi(2) + noise.repeatability_mm.powi(2)
    });
    (variances.sum::<f64>() / base.readings.len() as f64).sqrt() * 1e3
}
