//! Many solutions of one network with new errors: one factorisation serves them all.
//!
//! A trial's lengths are those computed from the solved network, plus errors. With the derivatives `A`, `B` of the
//! lengths by the unknowns of the groups and by the shared ones, the weights `P = C⁻¹` and the residuals `r`, the
//! gradient
//!
//! ```text
//! g = Aᵀ P r      b = Bᵀ P r
//! ```
//!
//! leads to a correction by elimination of the groups, with the factors `D = R⁻¹R⁻ᵀ`, `Z` and `Σ` of the solution
//! ([`trueaxis_leastsquares::Covariance`]):
//!
//! ```text
//! (s, λ) = Σ ( (b, h) - Σ_groups Zᵀ g )      shared unknowns; multipliers of the datum
//! dx     = D g - Z (s, λ)                    groups
//! ```
//!
//! where `h` is the closure of the constraints of the datum.
//!
//! The first correction is the linear solution. Further ones, with the same factors, start from the exact gradient
//! after the previous ones, with the residuals and beams there: the rotation of beams under residuals of the size of
//! the noise matters as much as the curvature of the lengths. With errors of the size of the noise the linear
//! solution is off by some 1e-4 standard uncertainties, with errors ten times as large by some 1e-2; after the last
//! correction less than 1e-6 remains.

mod errors;
mod groups;

use nalgebra::Vector3;
use rand::{Rng, RngExt};
use rand_distr::StandardNormal;
use trueaxis_leastsquares::{Lanes, dot, in_widest_registers, zeros};

use self::errors::ErrorNoise;
use self::groups::{At, TrialGroups};
use crate::batch_influence::{BatchInfluence, BatchRows};
use crate::known::KnownRow;
use crate::network::Network;
use crate::slots::Slots;
use crate::solution::Solution;
use crate::state::{DATUM, PER_STATION, zero_column};

/// A solved network, ready to be solved again with new errors, from any number of threads.
///
/// The weights of the solution serve all trials. Where weights depend on the beams (correlated lengths, a part
/// proportional to the distance), a full solve of the same lengths would use those of its own beams, which differ by
/// 1e-6.
#[derive(Debug, Clone)]
pub struct Trials {
    noise: ErrorNoise,
    /// What is known beside the lengths.
    known: Vec<KnownRow>,
    groups: Vec<TrialGroups>,
    /// `Σ`, rows one after the other.
    reduced_inverse: Vec<f64>,
    /// Those of a trial without errors.
    corrections: Corrections,
}

/// Effect of the errors of one trial on the solution.
#[derive(Debug, Clone, PartialEq)]
pub struct Corrections {
    points: Vec<Vector3<f64>>,
    groups: Vec<f64>,
    /// Start of the unknowns of each group, and last their number.
    starts: Vec<usize>,
    shared: Vec<f64>,
    stations: usize,
    mean_constant: Option<usize>,
}

/// Storage of trials.
#[derive(Debug, Clone)]
pub struct Workspace {
    corrections: Corrections,
    batches: Vec<OfBatch>,
    /// The errors of what is known beside the lengths, in standard deviations.
    of_known: Vec<f64>,
    /// The gradient of the shared unknowns and the right side of the datum.
    shared: Vec<Lanes>,
    /// `(s, λ)`.
    step: Vec<f64>,
    of_batch: groups::Scratch,
}

/// The errors of the slots of a batch, and corrections and gradients of the unknowns of its groups.
#[derive(Debug, Clone)]
struct OfBatch {
    errors_mm: Vec<Lanes>,
    corrections: Vec<Lanes>,
    gradient: Vec<Lanes>,
}

/// Most that the omitted corrections may move any unknown, in standard uncertainties. It is estimated from the last
/// two corrections; in thousands of trials the true value was up to four times as much.
const LEFT_OUT: f64 = 2e-7;

/// Errors that need more corrections than this are not noise.
const MAX_CORRECTIONS: usize = 20;

impl Trials {
    /// `network` must be the one that `solution` solved.
    pub fn new(network: &Network, solution: &Solution) -> Self {
        let influence = BatchInfluence::new(network, solution);
        let by_group = network.visits_by_group();
        let (mut slots, mut rows) = (Slots::new(network, &by_group), BatchRows::default());
        let mut noise = ErrorNoise::new(network);
        let mut groups = Vec::with_capacity(influence.batches().len());
        let mut starts = vec![0];
        for b in 0..influence.batches().len() {
            influence.fill(b, &mut rows);
            let batch = &influence.batches()[b];
            slots.take(batch.groups.clone());
            noise.take((batch, &rows), &slots);
            let of_batch = TrialGroups::new(&influence, b, &rows, &slots);
            for _ in batch.groups.clone() {
                starts.push(starts[starts.len() - 1] + of_batch.unknowns());
            }
            groups.push(of_batch);
        }
        Self {
            noise,
            known: solution.known_rows(network),
            groups,
            reduced_inverse: influence.sigma().as_slice().to_vec(),
            corrections: Corrections {
                points: vec![Vector3::zeros(); network.nominal_mm.len()],
                groups: vec![0.0; starts[starts.len() - 1]],
                starts,
                shared: vec![0.0; solution.covariance.shared().nrows()],
                stations: network.stations.len(),
                mean_constant: solution.mean_constant_column(),
            },
        }
    }

    /// Number of errors that a trial needs: one for each reading, mm, then, in standard deviations, one for each
    /// contrast of the reflectors with a known σ and for each known dead path.
    pub fn errors(&self) -> usize {
        self.noise.readings() + self.known.len()
    }

    /// Number of points of the network.
    pub fn points(&self) -> usize {
        self.corrections.points.len()
    }

    /// Storage for trials, one for each thread. It carries nothing from one trial to the next.
    pub fn workspace(&self) -> Workspace {
        let of_batch = |groups: &TrialGroups| OfBatch {
            errors_mm: vec![Lanes::ZERO; groups.slots()],
            corrections: vec![Lanes::ZERO; groups.unknowns()],
            gradient: vec![Lanes::ZERO; groups.unknowns()],
        };
        let width = self.reduced_inverse.len().isqrt();
        Workspace {
            corrections: self.corrections.clone(),
            batches: self.groups.iter().map(of_batch).collect(),
            of_known: vec![0.0; self.known.len()],
            shared: vec![Lanes::ZERO; width],
            step: vec![0.0; width],
            of_batch: Default::default(),
        }
    }

    /// Draws all errors. Those of readings follow the noise of the network: a return of the machine for each visit,
    /// `N(0, σ_m² I)`, and each length's own part, `N(0, σ_l²)`. Those of what else is known are `N(0, 1)`.
    ///
    /// The return acts to first order, by its part along the beam (the rest is 1e-6 of it). The errors of a visit are
    /// then normal with the covariance `C = L Lᵀ` that weights its lengths, and are drawn as `L z`, with one normal
    /// number for each reading, in measuring order.
    ///
    /// # Panics
    /// If `errors` does not hold [`Trials::errors`] numbers.
    pub fn draw<R: Rng + ?Sized>(&self, rng: &mut R, errors: &mut [f64]) {
        assert_eq!(errors.len(), self.errors(), "an error for each observation");
        let (errors_mm, known) = errors.split_at_mut(self.noise.readings());
        known.fill_with(|| rng.sample(StandardNormal));
        self.noise.draw(rng, errors_mm);
    }

    /// Solves the network for its computed lengths plus these errors (observed minus true), in the
    /// datum of the solution.
    ///
    /// The result agrees with the full nonlinear adjustment with the same weights to 1e-6 standard uncertainties.
    /// Errors so large that no solution is found give NaN for all unknowns.
    ///
    /// # Panics
    /// If `errors` does not hold [`Trials::errors`] numbers.
    pub fn solve<'w>(&self, errors: &[f64], workspace: &'w mut Workspace) -> &'w Corrections {
        assert_eq!(errors.len(), self.errors(), "an error for each observation");
        in_widest_registers(
            #[inline(always)]
            || self.fill(errors, workspace),
        );
        &workspace.corrections
    }

    #[inline(always)]
    fn fill(&self, errors: &[f64], workspace: &mut Workspace) {
        self.start(errors, workspace);
        // Corrections shrink by a constant factor, so the omitted ones are about the square of the last over the one
        // before. The linear solution counts with one unknown's share, because the direction that shrinks least is
        // one of many.
        let unknowns = self.corrections.groups.len() + self.corrections.shared.len();
        let mut before = self.correct(workspace) / (unknowns as f64).sqrt();
        for _ in 0..MAX_CORRECTIONS {
            let length = self.correct(workspace);
            if length * length <= LEFT_OUT * before {
                self.hand_out(workspace);
                return;
            }
            before = length;
        }
        let Corrections {
            points,
            groups,
            shared,
            ..
        } = &mut workspace.corrections;
        points.fill(Vector3::repeat(f64::NAN));
        groups.fill(f64::NAN);
        shared.fill(f64::NAN);
    }

    /// Takes the errors of a trial, and clears the corrections.
    #[inline(always)]
    fn start(&self, errors: &[f64], workspace: &mut Workspace) {
        let (errors_mm, known) = errors.split_at(self.noise.readings());
        for (groups, own) in self.groups.iter().zip(&mut workspace.batches) {
            groups.take_errors(errors_mm, &mut own.errors_mm);
            own.corrections.fill(Lanes::ZERO);
        }
        workspace.of_known.copy_from_slice(known);
        workspace.corrections.shared.fill(0.0);
    }

    /// Adds the correction that follows from the exact gradient after the previous ones, and returns its length in
    /// standard uncertainties.
    #[inline(always)]
    fn correct(&self, workspace: &mut Workspace) -> f64 {
        let Workspace {
            corrections,
            batches,
            of_known,
            shared,
            step,
            of_batch,
        } = workspace;
        let width = step.len();
        zeros(shared, width);
        let mut squares = 0.0;
        let mut closure = [Lanes::ZERO; DATUM];
        let mut gradient = vec![Lanes::ZERO; corrections.shared.len()];
        for (groups, own) in self.groups.iter().zip(&mut *batches) {
            let at = At {
                own: &own.corrections,
                shared: &corrections.shared,
            };
            let gradients = (&mut own.gradient[..], &mut gradient[..]);
            groups.gradient(&own.errors_mm, &at, gradients, of_batch);
            groups.add_to_closure(&mut closure, of_batch);
            groups.reduce(&own.gradient, shared);
        }
        for (known, error) in self.known.iter().zip(&*of_known) {
            let left = error - known.of(&corrections.shared);
            for &(column, derivative) in &known.columns {
                gradient[column].0[0] += derivative * left;
            }
        }
        let mut right: Vec<f64> = shared.iter().map(|x| x.sum()).collect();
        for (right, gradient) in right.iter_mut().zip(&gradient) {
            *right += gradient.sum();
        }
        for (right, missed) in right[gradient.len()..].iter_mut().zip(&closure) {
            *right -= missed.sum();
        }
        for (step, row) in step
            .iter_mut()
            .zip(self.reduced_inverse.chunks_exact(width))
        {
            *step = dot(row, &right);
        }
        let of_shared = corrections.shared.iter_mut().zip(&*step).zip(&gradient);
        for ((value, step), gradient) in of_shared {
            *value += step;
            squares += step * gradient.sum();
        }
        let mut along = Lanes::ZERO;
        for (groups, own) in self.groups.iter().zip(batches) {
            along += groups.correct(step, &own.gradient, &mut own.corrections);
        }
        (squares + along.sum()).abs().sqrt()
    }

    /// Writes the corrections of groups and points.
    #[inline(always)]
    fn hand_out(&self, workspace: &mut Workspace) {
        let Workspace {
            corrections,
            batches,
            of_batch,
            ..
        } = workspace;
        for (groups, own) in self.groups.iter().zip(batches) {
            let at = At {
                own: &own.corrections,
                shared: &corrections.shared,
            };
            groups.hand_out(
                &at,
                (&mut corrections.groups, &corrections.starts),
                &mut corrections.points,
                of_batch,
            );
        }
    }
}

impl Corrections {
    /// Corrections of all points, in the order of the network, mm.
    pub fn points_mm(&self) -> &[Vector3<f64>] {
        &self.points
    }

    /// Corrections of the unknowns of a group, in the order of its covariance ([`Solution::covariance`]): x y z of
    /// each free point, mm; or for a pose the translation of the centroid of its points, mm, and the rotation vector
    /// about it, rad, in the datum's axes.
    ///
    /// # Panics
    /// If the network has no such group.
    pub fn group(&self, group: usize) -> &[f64] {
        &self.groups[self.starts[group]..self.starts[group + 1]]
    }

    /// Corrections of all shared unknowns, in the order of the covariance, mm: x y z L of each station, the dead
    /// paths after interruptions, the deformations of bodies, the mean constant and the contrasts of reflectors.
    pub fn shared_mm(&self) -> &[f64] {
        &self.shared
    }

    /// Correction of the position of a station, mm.
    ///
    /// # Panics
    /// If the network has no such station.
    pub fn station_mm(&self, station: usize) -> Vector3<f64> {
        assert!(station < self.stations, "no station {station}");
        let first = PER_STATION * station;
        Vector3::from_column_slice(&self.shared[first..first + PER_STATION - 1])
    }

    /// Correction of the mean constant of the reflectors, mm; zero where it is no unknown.
    pub fn mean_constant_mm(&self) -> f64 {
        self.mean_constant.map_or(0.0, |column| self.shared[column])
    }

    /// Correction of a dead path, mm. Dead paths are numbered by station, then by interruption.
    ///
    /// # Panics
    /// If the network has no such dead path.
    pub fn dead_path_mm(&self, dead_path: usize) -> f64 {
        self.shared[zero_column(dead_path, self.stations)]
    }
}
