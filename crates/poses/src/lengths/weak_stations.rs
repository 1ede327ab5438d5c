//! Stations that the lengths hardly determine.

use crate::Error;
use crate::lengths::LengthsAdjustment;
use crate::lengths::refused::{LOOK_AT, or_as_they_are};

/// Second-order error of a length, in standard deviations of its noise, from which a station is
/// worth a notice, and from which nothing that follows from it can be trusted.
const WEAK_STATION: f64 = 1.0;
const HOPELESS_STATION: f64 = 5.0;

impl LengthsAdjustment<'_> {
    /// Stations that are so poorly determined that first-order uncertainties mean little: the length to a station that is
    /// off by u across the beam is off by u²/2d, which no linear propagation sees. The last argument is the noise of a
    /// length, and by how many times that the lengths contradict each other.
    pub(crate) fn weak_stations(
        &self,
        residuals_mm: &[f64],
        (noise_mm, sigma0): (f64, f64),
    ) -> Result<Vec<String>, Error> {
        let (campaign, lengths, solution) = (self.campaign, self.lengths, &self.screened.solution);
        let mut nearest_mm = vec![f64::INFINITY; solution.stations.len()];
        for stop in &lengths.stops {
            for i in stop.readings.clone() {
                let station = &solution.stations[stop.station];
                let distance_mm =
                    lengths.readings[i].length_mm + station.dead_path_mm - residuals_mm[i];
                nearest_mm[stop.station] = nearest_mm[stop.station].min(distance_mm.abs());
            }
        }
        let mut weak = Vec::new();
        for (j, (station, distance_mm)) in campaign.stations.iter().zip(nearest_mm).enumerate() {
            let covariance = solution.station_covariance(j);
            let position = covariance.fixed_view::<3, 3>(0, 0).into_owned();
            let variance_mm2 = position.symmetric_eigenvalues().max();
            let second_order = variance_mm2 / (2.0 * distance_mm) / noise_mm;
            let what = format!(
                "station {} is known to {:.1} mm only (standard uncertainty), so poorly that first-order \
                 uncertainties",
                station.name,
                variance_mm2.sqrt()
            );
            let is_hopeless = second_order.is_nan() || second_order > HOPELESS_STATION;
            if is_hopeless && second_order <= HOPELESS_STATION * sigma0 * sigma0 {
                // With the declared noise it would be well enough known.
                if !self.settings.asks_why {
                    return Err(Error::not_trustworthy(
                        format!(
                            "the lengths contradict each other by {sigma0:.0} times their noise, and so much that {what} mean nothing"
                        ),
                        or_as_they_are(campaign, LOOK_AT),
                    ));
                }
            } else if is_hopeless {
                return Err(Error::not_identifiable(
                    format!("{what} mean nothing"),
                    "spread the stations in all directions, heights included; let the targets move through a \
                     larger volume",
                ));
            }
            if second_order > WEAK_STATION {
                weak.push(format!("{what} may be too small: spread the stations more"));
            }
        }
        Ok(weak)
    }
}
