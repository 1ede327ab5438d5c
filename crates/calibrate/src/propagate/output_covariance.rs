//! The covariance of all results as one matrix, for who asks for it.

use trueaxis_kinematics::Machine;

use crate::Error;
use crate::identify::axis_data::AxisData;

/// Largest covariance that is made, GiB.
const LIMIT_GIB: u32 = 1;

/// Refuses a covariance that would not fit.
pub(crate) fn check_size(
    machine: &Machine,
    data: &[AxisData],
    stations: usize,
) -> Result<(), Error> {
    let of_axis = |axis: &AxisData| {
        6 * axis.nodes.len() + machine.axes()[axis.axis].location_components().len()
    };
    require_size(data.iter().map(of_axis).sum::<usize>() + 4 * stations)
}

fn require_size(outputs: usize) -> Result<(), Error> {
    let gib = (outputs as f64).powi(2) * size_of::<f64>() as f64 / 1024_f64.powi(3);
    if gib > f64::from(LIMIT_GIB) {
        return Err(Error::CovarianceTooLarge {
            outputs,
            gib,
            limit_gib: LIMIT_GIB,
        });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_does_not_fit_is_refused_with_its_size() {
        assert_eq!(require_size(11_585), Ok(()));
        let refused = require_size(40_000).map_err(|error| error.to_string());
        let text = refused.unwrap_err();
        assert!(text.contains("40000 results takes 11.9 GiB"), "{text}");
    }
}
