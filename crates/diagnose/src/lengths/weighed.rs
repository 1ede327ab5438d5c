//! Lengths of stations that scatter more than the others weigh less.

use trueaxis_multilateration::{Network, Settings, Solution, solve_from};
use trueaxis_screening::{estimate_noise, factors_of_readings, station_factors};

use crate::Error;

/// Gives the readings of such stations their factors, and the solution with them; which stations they are. `declared` says whether
/// the network's noise is more than a guess.
pub(crate) fn weigh_stations(
    network: &mut Network,
    solution: &mut Solution,
    declared: bool,
) -> Result<Vec<usize>, Error> {
    let settings = Settings::default();
    let factors = station_factors(network, solution, |network| {
        let mut solution = solve_from(network, solution, &settings)?;
        estimate_noise(network, &mut solution, declared, &settings)?;
        Ok::<Solution, Error>(solution)
    })?;
    let uneven: Vec<usize> = (0..factors.len()).filter(|&j| factors[j] > 1.0).collect();
    if !uneven.is_empty() {
        network.variance_factors = factors_of_readings(network, &factors);
        *solution = solve_from(network, solution, &settings)?;
    }
    Ok(uneven)
}
