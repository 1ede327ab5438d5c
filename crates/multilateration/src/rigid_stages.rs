//! The adjustment model with rigid stages: the points of a step are tied to one pose.
//!
//! With the home positions `r_k` of the body's targets, common to all steps, and a free pose at each
//! of them,
//!
//! ```text
//! p_k = R r_k + t       dp_k = dt + dω × (p_k - c) + R N_k ds
//! ```
//!
//! where `s` are the deformations of the body that no motion makes (three for a triangle). Block
//! unknowns are the six of a pose, shared ones the stations and dead paths as with free points
//! ([`crate::free_points`]) and behind them the deformations of all bodies. Against free points this
//! ties nine coordinates of a triangle to six unknowns.

use nalgebra::{DMatrix, DVector, Isometry3, Point3, Vector3};
use trueaxis_leastsquares::BlockRows;

use crate::Network;
use crate::bodies::{Bodies, rigid_motions};
use crate::free_points::{FreePoints, State};

/// Unknowns of a pose.
pub(crate) const POSE: usize = 6;

/// Values of all unknowns.
#[derive(Debug, Clone)]
pub(crate) struct RigidState {
    /// Stations and dead paths, and the points that follow from poses and shapes.
    pub(crate) free: State,
    /// Reference frame from home, one for each group.
    pub(crate) poses: Vec<Isometry3<f64>>,
    /// Home positions of the targets of each body, mm.
    pub(crate) shapes_mm: Vec<Vec<Point3<f64>>>,
}

/// The deformations of all bodies as shared unknowns.
pub(crate) struct Deformations {
    /// For each body the deformations that no motion makes, as displacements of its targets.
    pub(crate) of_bodies: Vec<Vec<DVector<f64>>>,
    /// Where the deformations of each body are among the shared unknowns.
    pub(crate) first: Vec<usize>,
    /// Number of all shared unknowns.
    pub(crate) shared: usize,
}

impl Deformations {
    /// Behind as many shared unknowns as the model with free points has.
    pub(crate) fn new(bodies: &Bodies, with_free_points: usize) -> Self {
        let mut new = Self {
            of_bodies: bodies.bodies.iter().map(|b| b.deformations()).collect(),
            first: Vec::new(),
            shared: with_free_points,
        };
        for own in &new.of_bodies {
            new.first.push(new.shared);
            new.shared += own.len();
        }
        new
    }
}

/// Whitened rows of rigid stages, group by group in measuring order.
pub(crate) struct RigidStages<'a> {
    free: FreePoints<'a>,
    network: &'a Network,
    bodies: &'a Bodies,
    deformations: Deformations,
}

impl RigidState {
    /// Stations and dead paths as given, bodies at their nominal places.
    pub(crate) fn nominal(network: &Network, bodies: &Bodies, stations: State) -> Self {
        let mut state = Self {
            free: stations,
            poses: bodies.ref_from_home.clone(),
            shapes_mm: bodies.bodies.iter().map(|b| b.home_mm.clone()).collect(),
        };
        state.place_points(network, bodies);
        state
    }

    pub(crate) fn place_points(&mut self, network: &Network, bodies: &Bodies) {
        for (g, group) in network.groups.iter().enumerate() {
            let shape_mm = &self.shapes_mm[bodies.body_of_group[g]];
            for (point, &place) in group.clone().zip(&bodies.places[g]) {
                self.free.points[point] = self.poses[g] * shape_mm[place];
            }
        }
    }

    /// Centroid of the points of a group.
    pub(crate) fn centroid(&self, network: &Network, group: usize) -> Point3<f64> {
        let points = &self.free.points[network.groups[group].clone()];
        let sum: Vector3<f64> = points.iter().map(|p| p.coords).sum();
        Point3::from(sum / points.len() as f64)
    }
}

impl<'a> RigidStages<'a> {
    pub(crate) fn new(network: &'a Network, bodies: &'a Bodies, state: &RigidState) -> Self {
        let free = FreePoints::new(network, &state.free);
        Self {
            deformations: Deformations::new(bodies, free.shared()),
            free,
            network,
            bodies,
        }
    }

    pub(crate) fn free(&self) -> &FreePoints<'a> {
        &self.free
    }

    /// How the coordinates of a group's points follow its pose, and the deformations of its body.
    fn ties(&self, state: &RigidState, group: usize) -> (DMatrix<f64>, DMatrix<f64>) {
        let centroid = state.centroid(self.network, group);
        let points = &state.free.points[self.network.groups[group].clone()];
        let arms_mm: Vec<Vector3<f64>> = points.iter().map(|p| p - centroid).collect();
        let places = &self.bodies.places[group];
        let deformations = &self.deformations.of_bodies[self.bodies.body_of_group[group]];
        let rotation = state.poses[group].rotation;
        let deformed = DMatrix::from_fn(3 * points.len(), deformations.len(), |row, k| {
            let at_home = deformations[k].fixed_rows::<3>(3 * places[row / 3]);
            (rotation * at_home.into_owned())[row % 3]
        });
        (rigid_motions(&arms_mm), deformed)
    }

    /// The whitened rows of a group, visit after visit; `memory` is storage.
    pub(crate) fn fill_rows(
        &self,
        state: &RigidState,
        group: usize,
        memory: &mut BlockRows,
        rows: &mut BlockRows,
    ) {
        self.free.fill_rows(&state.free, group, memory);
        let count = memory.rows();
        rows.reset(count, POSE, self.deformations.shared);
        let (moved, deformed) = self.ties(state, group);
        let first = self.deformations.first[self.bodies.body_of_group[group]];
        for coordinate in 0..moved.nrows() {
            let column = memory.block_mut(coordinate);
            for k in 0..POSE {
                add(rows.block_mut(k), column, moved[(coordinate, k)]);
            }
            for k in 0..deformed.ncols() {
                add(
                    rows.shared_mut(first + k),
                    column,
                    deformed[(coordinate, k)],
                );
            }
        }
        for k in 0..self.free.shared() {
            rows.shared_mut(k).copy_from_slice(memory.shared_mut(k));
        }
        rows.residual_mut().copy_from_slice(memory.residual_mut());
    }
}

/// `sum += factor · column`.
fn add(sum: &mut [f64], column: &[f64], factor: f64) {
    for (s, x) in sum.iter_mut().zip(column) {
        *s += factor * x;
    }
}
