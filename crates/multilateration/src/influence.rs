//! How the whitened lengths enter an adjusted network: the rows of the hat matrix, factored.
//!
//! With the whitened Jacobian `J = [A | B]` of a group and the factors `R⁻¹`, `Z`, `Σ` of the
//! covariance ([`trueaxis_leastsquares::Covariance`]):
//!
//! ```text
//! J Q Jᵀ = [same group] O Oᵀ + T Σ Tᵀ      O = A R⁻¹      T = B - A Z
//! ```
//!
//! so what needs the hat matrix is linear in the number of lengths. Here it is group by group, for what is
//! asked seldom, or what it is made of, for sums of its rows ([`crate::step_tests`]);
//! [`crate::batch_influence`] has eight groups at a time.

use faer::{Mat, MatRef};
use trueaxis_leastsquares::{BlockRows, Covariance};

use crate::bodies::Bodies;
use crate::free_points::{FreePoints, State};
use crate::network::Network;
use crate::noise::whiten;
use crate::rigid_stages::{RigidStages, RigidState};
use crate::{RigidSolution, Solution};

/// The solved network, ready to say what each group contributed.
pub(crate) struct Influence<'a> {
    network: &'a Network,
    model: Model<'a>,
    state: State,
    covariance: &'a Covariance,
}

/// What ties the points.
enum Model<'a> {
    Free(FreePoints<'a>),
    Rigid(Box<(RigidStages<'a>, RigidState)>),
}

/// One group's share.
pub(crate) struct GroupRows {
    /// Where each visit's readings are among the rows.
    pub(crate) visits: Vec<VisitRows>,
    /// `O`: one column for each unknown of the group.
    pub(crate) own: Mat<f64>,
    /// `T`: one column for each shared unknown and datum multiplier.
    pub(crate) shared: Mat<f64>,
    /// Whitened residuals, observed minus computed.
    pub(crate) residuals: Vec<f64>,
}

/// One visit's rows.
#[derive(Debug, Clone)]
pub(crate) struct VisitRows {
    /// The visit.
    pub(crate) visit: usize,
    /// First row within the group.
    pub(crate) first: usize,
    /// Number of rows.
    pub(crate) count: usize,
}

impl<'a> Influence<'a> {
    /// `network` must be the one that `solution` solved.
    pub(crate) fn new(network: &'a Network, solution: &'a Solution) -> Self {
        let state = solution.state();
        Self {
            network,
            model: Model::Free(FreePoints::new(network, &state)),
            state,
            covariance: &solution.covariance,
        }
    }

    /// The same with rigid stages.
    pub(crate) fn rigid(
        network: &'a Network,
        bodies: &'a Bodies,
        solution: &'a RigidSolution,
    ) -> Self {
        let state = solution.state();
        Self {
            network,
            state: state.free.clone(),
            model: Model::Rigid(Box::new((RigidStages::new(network, bodies, &state), state))),
            covariance: &solution.covariance,
        }
    }

    /// The model of the lengths between stations and points, whatever ties the points.
    pub(crate) fn model(&self) -> &FreePoints<'a> {
        match &self.model {
            Model::Free(model) => model,
            Model::Rigid(model) => model.0.free(),
        }
    }

    pub(crate) fn network(&self) -> &'a Network {
        self.network
    }

    /// Stations, dead paths and points.
    pub(crate) fn state(&self) -> &State {
        &self.state
    }

    /// The factors of the covariance, whose blocks are the unknowns of the groups: coordinates only where
    /// the points are free.
    pub(crate) fn covariance(&self) -> &'a Covariance {
        self.covariance
    }

    /// Unit vector from the station to the point of a reading.
    pub(crate) fn beam(&self, reading: usize, visit: usize) -> [f64; 3] {
        let content = &self.network.visits[visit];
        let point = self
            .network
            .point(content.group, self.network.readings[reading].point);
        self.state.beam(content.station, point).0.into()
    }

    /// `Σ`.
    pub(crate) fn reduced_inverse(&self) -> MatRef<'a, f64> {
        self.covariance.reduced_inverse()
    }

    /// The rows of `Σ`, one after the other.
    pub(crate) fn sigma(&self) -> &'a [f64] {
        self.covariance.reduced_inverse_rows()
    }

    /// Number of columns of `T`.
    pub(crate) fn width(&self) -> usize {
        self.covariance.width()
    }

    /// Number of groups.
    pub(crate) fn groups(&self) -> usize {
        self.network.groups.len()
    }

    /// The rows of a group; `rows` is memory to work in.
    pub(crate) fn group(&self, group: usize, rows: &mut BlockRows) -> GroupRows {
        match &self.model {
            Model::Free(model) => model.fill_rows(&self.state, group, rows),
            Model::Rigid(model) => {
                model
                    .0
                    .fill_rows(&model.1, group, &mut BlockRows::default(), rows);
            }
        }
        let count = rows.rows();
        let factor = self.covariance.inverse_factor(group);
        let block = Mat::from_fn(count, factor.nrows(), |i, k| rows.block_mut(k)[i]);
        let own = &block * factor;
        let mut shared = -(&block * self.covariance.coupling(group));
        for k in 0..self.covariance.shared().ncols() {
            for (i, b) in rows.shared_mut(k).iter().enumerate() {
                shared[(i, k)] += b;
            }
        }
        let mut first = 0;
        let visit_rows = |&visit: &usize| {
            let count = self.network.visits[visit].readings.len();
            first += count;
            VisitRows {
                visit,
                first: first - count,
                count,
            }
        };
        GroupRows {
            visits: self
                .model()
                .visits_of(group)
                .iter()
                .map(visit_rows)
                .collect(),
            own,
            shared,
            residuals: rows.residual_mut().to_vec(),
        }
    }

    /// `I - J Q Jᵀ` of one visit's whitened rows: the part of their noise that the residuals keep.
    pub(crate) fn kept(&self, group: &GroupRows, visit: &VisitRows) -> Mat<f64> {
        let own = group.own.as_ref().subrows(visit.first, visit.count);
        let shared = group.shared.as_ref().subrows(visit.first, visit.count);
        let adjusted = own * own.transpose() + shared * self.reduced_inverse() * shared.transpose();
        Mat::from_fn(visit.count, visit.count, |i, j| {
            f64::from(u8::from(i == j)) - adjusted[(i, j)]
        })
    }

    /// `L⁻¹ e_i`: a unit error of one of the `count` readings of a visit, whitened.
    pub(crate) fn unit_error_into(
        &self,
        visit: usize,
        count: usize,
        reading: usize,
        unit: &mut Vec<f64>,
    ) {
        unit.clear();
        unit.resize(count, 0.0);
        unit[reading] = 1.0;
        whiten(self.model().factor(visit), unit);
    }

    /// The same as a vector of its own.
    pub(crate) fn unit_error(&self, visit: &VisitRows, reading: usize) -> Vec<f64> {
        let mut unit = Vec::new();
        self.unit_error_into(visit.visit, visit.count, reading, &mut unit);
        unit
    }
}
