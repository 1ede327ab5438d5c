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

use nalgebra::{DMatrix, DVector, Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use trueaxis_leastsquares::{
    Adjustment, Arrowhead, BlockRows, Correction, Datum, Error as LeastSquaresError,
};

use crate::Network;
use crate::bodies::{Bodies, rigid_motions};
use crate::free_points::{DATUM, FreePoints, State};

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

/// The model with its weights, which stay as they are while it is adjusted.
pub(crate) struct RigidStages<'a> {
    free: FreePoints<'a>,
    network: &'a Network,
    bodies: &'a Bodies,
    deformations: Vec<Vec<DVector<f64>>>,
    /// Where the deformations of each body are among the shared unknowns.
    first_deformation: Vec<usize>,
    shared: usize,
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

    fn place_points(&mut self, network: &Network, bodies: &Bodies) {
        for (g, group) in network.groups.iter().enumerate() {
            let shape_mm = &self.shapes_mm[bodies.body_of_group[g]];
            for (point, &place) in group.clone().zip(&bodies.places[g]) {
                self.free.points[point] = self.poses[g] * shape_mm[place];
            }
        }
    }

    /// Centroid of the points of a group.
    fn centroid(&self, network: &Network, group: usize) -> Point3<f64> {
        let points = &self.free.points[network.groups[group].clone()];
        let sum: Vector3<f64> = points.iter().map(|p| p.coords).sum();
        Point3::from(sum / points.len() as f64)
    }
}

impl<'a> RigidStages<'a> {
    pub(crate) fn new(network: &'a Network, bodies: &'a Bodies, state: &RigidState) -> Self {
        let free = FreePoints::new(network, &state.free);
        let deformations: Vec<_> = bodies.bodies.iter().map(|b| b.deformations()).collect();
        let mut shared = free.shared();
        let mut first_deformation = Vec::new();
        for own in &deformations {
            first_deformation.push(shared);
            shared += own.len();
        }
        Self {
            free,
            network,
            bodies,
            deformations,
            first_deformation,
            shared,
        }
    }

    pub(crate) fn update_weights(&mut self, state: &RigidState) {
        self.free.update_weights(&state.free);
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
        let deformations = &self.deformations[self.bodies.body_of_group[group]];
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
        rows.reset(count, POSE, self.shared);
        let (moved, deformed) = self.ties(state, group);
        let first = self.first_deformation[self.bodies.body_of_group[group]];
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

impl Adjustment for RigidStages<'_> {
    type State = RigidState;

    fn linearise(&self, state: &RigidState) -> Result<(Arrowhead, Datum), LeastSquaresError> {
        let mut system = Arrowhead::new(self.shared, DATUM);
        let (mut memory, mut rows) = (BlockRows::default(), BlockRows::default());
        let mut closure = vec![0.0; DATUM];
        let mut of_points = Vec::new();
        for (g, group) in self.network.groups.iter().enumerate() {
            self.fill_rows(state, g, &mut memory, &mut rows);
            // The datum of the points, by way of the pose. That the shape moves them, too, the next
            // iteration sees in the closure.
            of_points.clear();
            self.free
                .datum_of(&state.free, group.clone(), &mut of_points, &mut closure);
            let (moved, _) = self.ties(state, g);
            let datum: Vec<f64> = of_points
                .chunks_exact(3 * group.len())
                .flat_map(|h| {
                    (0..POSE)
                        .map(|k| moved.column(k).iter().zip(h).map(|(m, h)| m * h).sum())
                        .collect::<Vec<f64>>()
                })
                .collect();
            system.eliminate(&mut rows, &datum)?;
        }
        let free_motions = self.free.free_motions(&state.free, self.shared);
        Ok((
            system,
            Datum {
                free_motions,
                closure,
            },
        ))
    }

    fn squares(&self, state: &RigidState) -> f64 {
        self.free.squares(&state.free)
    }

    fn moved(&self, state: &RigidState, correction: &Correction, factor: f64) -> RigidState {
        let mut moved = state.clone();
        self.free.move_stations(&mut moved.free, correction, factor);
        for (g, pose) in moved.poses.iter_mut().enumerate() {
            let x = correction.block(g);
            let centre = state.centroid(self.network, g).coords;
            let turn = UnitQuaternion::from_scaled_axis(Vector3::new(x[3], x[4], x[5]) * factor);
            let shift = Vector3::new(x[0], x[1], x[2]) * factor;
            *pose = Translation3::from(shift + centre) * turn * Translation3::from(-centre) * *pose;
        }
        for (b, shape_mm) in moved.shapes_mm.iter_mut().enumerate() {
            for (k, deformation) in self.deformations[b].iter().enumerate() {
                let amount = correction.shared[self.first_deformation[b] + k] * factor;
                for (place, point) in shape_mm.iter_mut().enumerate() {
                    *point += deformation.fixed_rows::<3>(3 * place) * amount;
                }
            }
        }
        moved.place_points(self.network, self.bodies);
        moved
    }
}
