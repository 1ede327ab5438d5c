//! Less weight for the lengths of stations that scatter more than the others.

use trueaxis_multilateration::{Network, Solution, solve_from};
use trueaxis_screening::{estimate_noise, factors_of_readings, station_factors};

use crate::Error;

/// Gives the readings of such stations their factors, and updates the solution; returns these stations. `declared`
/// says whether the network's noise is more than a guess.
pub(crate) fn weigh_stations(
    network: &mut Network,
    solution: &mut Solution,
    declared: bool,
) -> Result<Vec<usize>, Error> {
    let factors = station_factors(network, solution, |network| {
        let mut solution = solve_from(network, solution)?;
        estimate_noise(network, &mut solution, declared)?;
        Ok::<Solution, Error>(solution)
    })?;
    let uneven: Vec<usize> = (0..factors.len()).filter(|&j| factors[j] > 1.0).collect();
    if !uneven.is_empty() {
        network.variance_factors = factors_of_readings(network, &factors);
        *solution = solve_from(network, solution)?;
    }
    Ok(uneven)
}
