//! The adjusted points and stations, with the evidence for them.

use std::sync::Arc;

use nalgebra::{DMatrix, Isometry3, Matrix4, Point3};
use trueaxis_leastsquares::{Covariance, Termination};

use crate::Network;
use crate::batches::Batch;
use crate::known::{Columns, KnownRow};
use crate::reflectors::contrast;
use crate::state::{PER_STATION, State, zero_column};

/// Adjusted stations and points in the datum of the nominal points.
#[derive(Debug, Clone)]
pub struct Solution {
    /// Stations in the order of the network.
    pub stations: Vec<Station>,
    /// Dead path after each interruption of the network, mm.
    pub dead_paths_after_mm: Vec<f64>,
    /// Points in the order of the network, mm.
    pub points_mm: Vec<Point3<f64>>,
    /// Poses of the bodies at each group, datum from home; the nominal pose for a group whose points are free. Empty
    /// in a network without bodies.
    pub poses: Vec<Isometry3<f64>>,
    /// Home positions of the targets of each body, mm; empty in a network without bodies.
    pub shapes_mm: Vec<Vec<Point3<f64>>>,
    /// What the constants of all reflectors have in common, mm, where the network has known dead paths. The dead
    /// paths of the solution are shorter by it than the true ones.
    pub mean_constant_mm: Option<f64>,
    /// Constants of the reflectors, relative to their mean, mm; empty in a network without reflectors.
    pub reflectors_mm: Vec<f64>,
    /// Observed minus computed length of every reading, mm.
    pub residuals_mm: Vec<f64>,
    /// Sum of squares of the whitened residuals.
    pub squares: f64,
    /// Number of lengths, of contrasts of reflectors with a known σ, and of known dead paths.
    pub observations: usize,
    /// Number of unknowns less the six that the datum fixes.
    pub unknowns: usize,
    /// Iterations of the adjustment.
    pub iterations: usize,
    /// The points lie in a plane, and the lengths fit as well with all stations on its other side: results across the
    /// plane may have the wrong sign. An approximate position of one station decides it.
    pub mirror_image_open: bool,
    /// Why the iteration stopped. Check it: a result that is not converged is returned, not hidden.
    pub termination: Termination,
    /// Covariance for the noise as given (its variance factor is one). Blocks are the groups: x y z of each free
    /// point, mm; for a body the translation, mm, and the rotation vector, rad, about the centroid of the group's
    /// adjusted points, both in the datum's axes. Shared unknowns are, in this order, the stations (x y z L of each),
    /// the dead paths after interruptions, mm, the amounts of the deformations of each body, mm, the mean constant if
    /// there is one, and the contrasts of the reflectors' constants, mm. The datum is the best fit to the nominal
    /// points.
    pub covariance: Covariance,
    /// The groups of the network that was solved.
    pub(crate) batches: Arc<Vec<Batch>>,
}

/// An adjusted station.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Station {
    /// Position, mm.
    pub position_mm: Point3<f64>,
    /// Dead path L: the distance at which the interferometer reads zero, mm.
    pub dead_path_mm: f64,
}

impl Solution {
    /// Redundancy of the whole: lengths minus unknowns.
    pub fn degrees_of_freedom(&self) -> usize {
        self.observations.saturating_sub(self.unknowns)
    }

    /// Standard deviation of unit weight, `√(Σ v² / dof)`: about 1 if the noise is as declared. NaN without
    /// redundancy.
    pub fn sigma0(&self) -> f64 {
        (self.squares / self.degrees_of_freedom() as f64).sqrt()
    }

    /// Rms of the residuals, mm.
    pub fn rms_residual_mm(&self) -> f64 {
        let squares: f64 = self.residuals_mm.iter().map(|r| r * r).sum();
        (squares / self.residuals_mm.len().max(1) as f64).sqrt()
    }

    /// Whether the residuals are rounding of the adjustment itself (a picometre): lengths that a program computed. What
    /// they show of each other is nothing.
    pub fn is_of_computed_lengths(&self) -> bool {
        self.rms_residual_mm() < 1e-9
    }

    /// The computed length from a station (with its first dead path) to a point, mm.
    ///
    /// # Panics
    /// If `network`, which must be the one that was solved, has no such station or point.
    pub fn computed_length_mm(&self, network: &Network, station: usize, point: usize) -> f64 {
        let Station {
            position_mm,
            dead_path_mm,
        } = self.stations[station];
        let distance_mm = (self.points_mm[point] - position_mm).norm();
        let reflectors = network.reflectors.as_deref();
        let of_point = reflectors.and_then(|r| self.reflectors_mm.get(r.of_points[point]));
        distance_mm - dead_path_mm + of_point.copied().unwrap_or_default()
    }

    /// Covariance of a station and its dead path: x y z L, mm².
    pub fn station_covariance(&self, station: usize) -> Matrix4<f64> {
        let first = PER_STATION * station;
        let shared = self.covariance.shared();
        shared.fixed_view::<4, 4>(first, first).into_owned()
    }

    /// By how much one dead path is longer than another, with the standard uncertainty, mm. Dead paths are numbered
    /// by station, then by interruption.
    ///
    /// # Panics
    /// If there are no such dead paths.
    pub fn difference_of_dead_paths(&self, longer: usize, shorter: usize) -> (f64, f64) {
        let dead_paths_mm = self.state().dead_paths_mm;
        let column = |zero| zero_column(zero, self.stations.len());
        let (i, j) = (column(longer), column(shorter));
        let covariance = self.covariance.shared();
        let variance = covariance[(i, i)] + covariance[(j, j)] - 2.0 * covariance[(i, j)];
        (
            dead_paths_mm[longer] - dead_paths_mm[shorter],
            variance.max(0.0).sqrt(),
        )
    }

    /// Index of the mean constant among the shared unknowns, where it is one.
    pub fn mean_constant_column(&self) -> Option<usize> {
        let contrasts = self.reflectors_mm.len().saturating_sub(1);
        let column = self.covariance.shared().nrows() - contrasts;
        self.mean_constant_mm.map(|_| column - 1)
    }

    /// The constants of the reflectors with their covariance, mm and mm²: absolute where dead paths are known,
    /// relative to their mean otherwise; none where there is one reflector and no known dead path.
    pub fn reflector_constants(&self) -> (Vec<f64>, DMatrix<f64>) {
        let Some(mean_mm) = self.mean_constant_mm else {
            return (self.reflectors_mm.clone(), self.reflector_covariance());
        };
        let relative = |i: usize| self.reflectors_mm.get(i).copied().unwrap_or_default();
        let constants = (0..self.reflectors_mm.len().max(1)).map(|i| mean_mm + relative(i));
        (constants.collect(), self.covariance_of_constants(1))
    }

    /// Covariance of the reflectors' constants, relative to their mean, mm².
    pub fn reflector_covariance(&self) -> DMatrix<f64> {
        self.covariance_of_constants(0)
    }

    /// Covariance of the last shared unknowns: `means` mean constants (one or none) and the contrasts.
    fn covariance_of_constants(&self, means: usize) -> DMatrix<f64> {
        let columns = self.reflectors_mm.len().saturating_sub(1) + means;
        let shared = self.covariance.shared();
        let first = shared.nrows() - columns;
        let h = DMatrix::from_fn(self.reflectors_mm.len().max(means), columns, |i, m| {
            m.checked_sub(means).map_or(1.0, |m| contrast(i, m))
        });
        &h * shared.view((first, first), (columns, columns)) * h.transpose()
    }

    fn contrasts_mm(&self) -> Vec<f64> {
        let constants = || self.reflectors_mm.iter().enumerate();
        let of = |m: usize| constants().map(|(r, k)| contrast(r, m) * k).sum();
        let contrasts = 0..self.reflectors_mm.len().saturating_sub(1);
        contrasts.map(of).collect()
    }

    /// The part of the lengths in [`Solution::squares`] and in the redundancy, without that of what is known beside
    /// them, whose noise is not that of lengths. `network` must be the one that was solved.
    pub fn of_lengths(&self, network: &Network) -> (f64, f64) {
        let (mut squares, mut redundancy) = (self.squares, self.degrees_of_freedom() as f64);
        let shared = self.covariance.shared();
        for row in self.known_rows(network) {
            squares -= row.residual * row.residual;
            redundancy -= 1.0 - row.variance(|i, j| shared[(i, j)]);
        }
        (squares.max(0.0), redundancy.max(0.0))
    }

    /// The observations of shared unknowns beside the lengths, at the solution.
    pub(crate) fn known_rows(&self, network: &Network) -> Vec<KnownRow> {
        let known_last = network.contrasts() + usize::from(network.has_mean_constant());
        let behind = self.covariance.shared().nrows() - known_last;
        network.known_rows(Columns::new(network, behind), &self.state())
    }

    /// The values of all unknowns.
    pub(crate) fn state(&self) -> State {
        let dead_paths = self.stations.iter().map(|s| s.dead_path_mm);
        State {
            stations: self.stations.iter().map(|s| s.position_mm).collect(),
            dead_paths_mm: dead_paths
                .chain(self.dead_paths_after_mm.iter().copied())
                .collect(),
            points: self.points_mm.clone(),
            poses: self.poses.clone(),
            shapes_mm: self.shapes_mm.clone(),
            mean_constant_mm: self.mean_constant_mm.unwrap_or_default(),
            contrasts_mm: self.contrasts_mm(),
        }
    }
}
