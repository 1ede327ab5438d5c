//! The covariance of all results as one matrix, for who asks for it.

use trueaxis_kinematics::Machine;

use crate::Error;
use crate::identify::axis_data::AxisData;
use crate::result::factored_covariance::FactoredCovariance;
use crate::result::numbered::NumberedResult;
use crate::result::output::OutputCovariance;

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

impl OutputCovariance {
    /// Of these results, all of their calibration.
    pub(crate) fn new(factors: &FactoredCovariance, results: Vec<NumberedResult>) -> Self {
        let sizes = results.iter().map(|result| result.output.unit().size());
        let sizes: Vec<f64> = sizes.collect();
        let mut matrix = factors.dense();
        for (j, mut column) in matrix.column_iter_mut().enumerate() {
            for (value, size) in column.iter_mut().zip(&sizes) {
                *value /= size * sizes[j];
            }
        }
        let outputs = results.into_iter().map(|result| result.output).collect();
        Self { outputs, matrix }
    }
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
