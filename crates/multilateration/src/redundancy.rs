//! Redundancy numbers: how far each length is checked by the others.

use trueaxis_leastsquares::BlockRows;

use crate::influence::Influence;
use crate::noise::unwhiten_row;
use crate::{Network, Solution};

impl Solution {
    /// Redundancy number of every reading: the part of an error in it that shows in its residual, from
    /// 0 (nothing checks it: the error goes wholly into the result) to 1. Lengths of a visit that
    /// correlate through the machine's return may leave this range. Their sum is
    /// [`Solution::degrees_of_freedom`].
    ///
    /// `r = diag(I - J Q Jᵀ C⁻¹)` with the Jacobian `J` and the covariance `Q` of the unknowns.
    /// `network` must be the one that was solved.
    pub fn redundancy_numbers(&self, network: &Network) -> Vec<f64> {
        let influence = Influence::new(network, self);
        let mut numbers = vec![0.0; network.readings.len()];
        let mut memory = BlockRows::default();
        for g in 0..influence.groups() {
            let group = influence.group(g, &mut memory);
            for visit in &group.visits {
                let kept = influence.kept(&group, visit);
                let factor = influence.model().factor(visit.visit);
                let first = network.visits[visit.visit].readings.start;
                for i in 0..visit.count {
                    // (L K L⁻¹)_ii for the whitened rows' K = I - J Q Jᵀ.
                    let unit = influence.unit_error(visit, i);
                    let row = unwhiten_row(factor, i);
                    numbers[first + i] = (0..=i)
                        .map(|j| {
                            let kept: f64 = (0..visit.count).map(|k| kept[(j, k)] * unit[k]).sum();
                            row[j] * kept
                        })
                        .sum();
                }
            }
        }
        numbers
    }
}
