//! An adjusted network as whitened rows in measuring order: what is needed to test whether anything
//! else is in the lengths.
//!
//! For whitened columns `x` of further unknowns, `M x = x - O Oᵀx - T Σ Tᵀx` is what the adjustment
//! cannot absorb, with the factors of [`crate::influence`]. The rows of `O` and `T` are kept, so the
//! size is linear in the number of lengths.

use faer::Mat;
use trueaxis_leastsquares::BlockRows;

use crate::bodies::Bodies;
use crate::influence::Influence;
use crate::noise::{factor_len, whiten};
use crate::{Network, RigidSolution};

/// The whitened rows of an adjusted network; rows are the readings in measuring order.
#[derive(Debug, Clone)]
pub struct Whitened {
    /// The group of each row.
    pub group_of_row: Vec<usize>,
    /// Number of groups.
    pub groups: usize,
    /// `O`: one column for each unknown of the row's group.
    pub own: Mat<f64>,
    /// `T`: one column for each shared unknown and datum multiplier.
    pub shared: Mat<f64>,
    /// `Σ`: symmetric, indefinite.
    pub reduced_inverse: Mat<f64>,
    /// Whitened residuals, observed minus computed.
    pub residuals: Vec<f64>,
    /// Redundancy.
    pub degrees_of_freedom: usize,
    /// The readings of each visit, and its factor.
    visits: Vec<(std::ops::Range<usize>, Vec<f64>)>,
}

impl Whitened {
    /// The rows of a network with rigid stages; `solution` must be the network's.
    pub fn rigid(network: &Network, bodies: &Bodies, solution: &RigidSolution) -> Self {
        let influence = Influence::rigid(network, bodies, solution);
        let rows = network.readings.len();
        let mut memory = BlockRows::default();
        let first = influence.group(0, &mut memory);
        let mut whitened = Self {
            group_of_row: vec![0; rows],
            groups: influence.groups(),
            own: Mat::zeros(rows, first.own.ncols()),
            shared: Mat::zeros(rows, influence.width()),
            reduced_inverse: influence.reduced_inverse().to_owned(),
            residuals: vec![0.0; rows],
            degrees_of_freedom: solution.degrees_of_freedom(),
            visits: Vec::with_capacity(network.visits.len()),
        };
        for g in 0..influence.groups() {
            let group = influence.group(g, &mut memory);
            for visit in &group.visits {
                let start = network.visits[visit.visit].readings.start;
                for i in 0..visit.count {
                    let (row, from) = (start + i, visit.first + i);
                    whitened.group_of_row[row] = g;
                    whitened.residuals[row] = group.residuals[from];
                    for k in 0..group.own.ncols() {
                        whitened.own[(row, k)] = group.own[(from, k)];
                    }
                    for k in 0..group.shared.ncols() {
                        whitened.shared[(row, k)] = group.shared[(from, k)];
                    }
                }
            }
        }
        for (v, visit) in network.visits.iter().enumerate() {
            let factor = influence.model().factor(v);
            debug_assert_eq!(factor.len(), factor_len(visit.readings.len()));
            let content = (visit.readings.clone(), factor.to_vec());
            whitened.visits.push(content);
        }
        whitened
    }

    /// Whitens a column of changes of the lengths (mm), one for each reading.
    pub fn whiten(&self, column: &mut [f64]) {
        for (readings, factor) in &self.visits {
            whiten(factor, &mut column[readings.clone()]);
        }
    }
}
