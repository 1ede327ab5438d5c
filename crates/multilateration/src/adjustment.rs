//! The adjustment of a network: the linearised lengths, group by group.
//!
//! Block unknowns are those of the groups: the coordinates of free points, or the six of the pose of a
//! body ([`crate::linearise`]). Shared unknowns are the stations and dead paths, four each: `x y z L`, behind
//! them the dead paths after interruptions, and behind these the deformations of all bodies.

use std::ops::Range;
use std::sync::Arc;

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use trueaxis_leastsquares::{Adjustment, Error as LeastSquaresError, Factors, Lanes, Reduced};

use crate::Network;
use crate::batches::Batch;
use crate::bodies::Deformations;
use crate::datum::Datum;
use crate::linearise::{Beams, Tie, fill, fill_weights};
use crate::passes::{
    self, At, Gauge, Memories, Memory, in_parallel, pieces, split_mut, try_in_parallel,
};
use crate::state::{PER_STATION, POSE, State, centroid, zero_column};

/// A network as an adjustment model.
pub(crate) struct GroupAdjustment<'a> {
    network: &'a Network,
    datum: Datum,
    deformations: Deformations,
    batches: Arc<Vec<Batch>>,
    /// Whether weights depend on the beams at all.
    by_beams: bool,
    /// The weights of each batch: within a piece, the same ones as of the batch before if they are equal.
    weight_ranges: Vec<Range<usize>>,
    memories: Memories,
}

/// The points and poses of the groups of some batches, to be moved.
struct Moved<'a> {
    points: &'a mut [Point3<f64>],
    /// Empty in a network without bodies.
    poses: &'a mut [Isometry3<f64>],
}

impl<'a> GroupAdjustment<'a> {
    /// The model of a network with these groups.
    pub(crate) fn new(network: &'a Network, batches: &Arc<Vec<Batch>>) -> Self {
        let behind = PER_STATION * network.stations.len() + network.interruptions.len();
        let noise = &network.noise;
        let correlated = || network.visits.iter().any(|v| v.readings.len() > 1);
        let by_beams =
            noise.length_sigma_relative > 0.0 || noise.return_sigma_mm > 0.0 && correlated();
        let mut weight_ranges: Vec<Range<usize>> = Vec::with_capacity(batches.len());
        let mut end = 0;
        for piece in pieces(batches.len()) {
            for b in piece.clone() {
                let batch = &batches[b];
                let is_new = by_beams || b == piece.start || !batch.is_weighted_as(&batches[b - 1]);
                if is_new {
                    end += batch.weights();
                }
                weight_ranges.push(end - batch.weights()..end);
            }
        }
        Self {
            network,
            datum: Datum::new(network),
            deformations: Deformations::new(network.bodies.as_deref(), behind),
            batches: Arc::clone(batches),
            by_beams,
            weight_ranges,
            memories: Memories::default(),
        }
    }

    pub(crate) fn datum(&self) -> &Datum {
        &self.datum
    }

    pub(crate) fn batches(&self) -> &[Batch] {
        &self.batches
    }

    pub(crate) fn memories(&self) -> &Memories {
        &self.memories
    }

    /// The weights of a batch: `L⁻¹` of each visit, the rows of its triangle one after the other.
    #[inline(always)]
    pub(crate) fn weights_of<'w>(&self, weights: &'w [Lanes], b: usize) -> &'w [Lanes] {
        &weights[self.weight_ranges[b].clone()]
    }

    /// Number of shared unknowns.
    pub(crate) fn shared(&self) -> usize {
        self.deformations.shared
    }

    /// Makes the equations of batch `b`.
    #[inline(always)]
    pub(crate) fn fill(
        &self,
        (state, weights): At<'_>,
        b: usize,
        gauge: Gauge,
        memory: &mut Memory,
    ) {
        let batch = &self.batches[b];
        let Memory {
            beams,
            equations,
            tie,
        } = memory;
        beams.fill(batch, state);
        let is_tied = self.fill_tie((state, b), &beams.points, tie);
        let content = (batch, self.weights_of(weights, b));
        let datum = (gauge == Gauge::Datum).then_some((&self.datum, &self.network.nominal_mm[..]));
        let sizes = (self.network.stations.len(), self.shared());
        fill(
            content,
            is_tied.then_some(&*tie),
            datum,
            beams,
            sizes,
            equations,
        );
    }

    /// Takes what ties the points of batch `b`; false if they are free.
    #[inline(always)]
    pub(crate) fn fill_tie(
        &self,
        (state, b): (&State, usize),
        points: &[Lanes],
        tie: &mut Tie,
    ) -> bool {
        let batch = &self.batches[b];
        let Some((body, bodies)) = batch.body.zip(self.network.bodies.as_deref()) else {
            return false;
        };
        let Deformations {
            of_bodies, first, ..
        } = &self.deformations;
        let deformations = (first[body], &of_bodies[body][..]);
        tie.fill(batch, (state, points), bodies, deformations);
        true
    }

    /// Moves stations, dead paths and shapes by `factor` times the correction `s`.
    fn step_shared(&self, state: &State, s: &[f64], factor: f64, next: &mut State) {
        let stations = state.stations.len();
        next.stations.clone_from(&state.stations);
        for (position, x) in next.stations.iter_mut().zip(s.chunks_exact(PER_STATION)) {
            *position += Vector3::new(x[0], x[1], x[2]) * factor;
        }
        next.dead_paths_mm.clone_from(&state.dead_paths_mm);
        for (zero, dead_path) in next.dead_paths_mm.iter_mut().enumerate() {
            *dead_path += s[zero_column(zero, stations)] * factor;
        }
        next.shapes_mm.clone_from(&state.shapes_mm);
        let deformations = &self.deformations;
        for (b, shape_mm) in next.shapes_mm.iter_mut().enumerate() {
            let amounts = s[deformations.first[b]..].iter().map(|x| x * factor);
            for (deformation, amount) in deformations.of_bodies[b].iter().zip(amounts) {
                for (place, point) in shape_mm.iter_mut().enumerate() {
                    *point += deformation.fixed_rows::<3>(3 * place) * amount;
                }
            }
        }
    }

    /// Moves the points of batch `b` by `factor` times what follows from the correction `s`; the bodies
    /// have the new shapes.
    #[inline(always)]
    fn step_groups(
        &self,
        (at, b): (At<'_>, usize),
        (s, factor): (&[f64], f64),
        shapes_mm: &[Vec<Point3<f64>>],
        memory: &mut Memory,
        moved: &mut Moved<'_>,
    ) -> Result<(), LeastSquaresError> {
        let batch = &self.batches[b];
        passes::eliminate(self, at, b, Gauge::Free, memory)?;
        let (state, _) = at;
        let x = memory.equations.correction(s);
        let of_lanes = moved.points.chunks_exact_mut(batch.points);
        for (lane, (group, moved_points)) in batch.groups.clone().zip(of_lanes).enumerate() {
            let points = &state.points[self.network.groups[group].clone()];
            let vector =
                |first: usize| Vector3::from_fn(|axis, _| x[first + axis].0[lane] * factor);
            match (batch.body, self.network.bodies.as_deref()) {
                (Some(body), Some(bodies)) => {
                    let pose = moved_pose(&state.poses[group], points, [vector(0), vector(3)]);
                    bodies.of_groups[group].put(&pose, &shapes_mm[body], moved_points);
                    moved.poses[lane] = pose;
                }
                _ => {
                    for (k, (point, moved)) in points.iter().zip(moved_points).enumerate() {
                        *moved = point + vector(3 * k);
                    }
                }
            }
        }
        Ok(())
    }
}

/// A pose moved by a shift and a turn about the centroid of its points.
fn moved_pose(
    pose: &Isometry3<f64>,
    points: &[Point3<f64>],
    [shift, turn]: [Vector3<f64>; 2],
) -> Isometry3<f64> {
    let centre = centroid(points).coords;
    let turn = UnitQuaternion::from_scaled_axis(turn);
    Translation3::from(shift + centre) * turn * Translation3::from(-centre) * pose
}

impl Adjustment for GroupAdjustment<'_> {
    type State = State;
    /// As [`fill_weights`] makes them, batch after batch.
    type Weights = Vec<Lanes>;

    fn weights(&self, state: &State) -> Vec<Lanes> {
        let pieces = pieces(self.batches.len());
        let ranges = &self.weight_ranges;
        let mut weights = vec![Lanes::ZERO; ranges.last().map_or(0, |last| last.end)];
        let lengths = pieces
            .iter()
            .map(|p| ranges[p.end - 1].end - ranges[p.start].start);
        let parts = split_mut(&mut weights, lengths);
        let (batches, noise) = (&self.batches, &self.network.noise);
        in_parallel(
            pieces.into_iter().zip(parts).collect(),
            #[inline(always)]
            |(piece, part): (Range<usize>, &mut [Lanes])| {
                let (mut beams, mut factor) = (Beams::default(), Vec::new());
                let (first, mut filled) = (ranges[piece.start].start, 0);
                for (batch, range) in batches[piece.clone()].iter().zip(&ranges[piece]) {
                    let (start, end) = (range.start - first, range.end - first);
                    if end == filled {
                        continue;
                    }
                    filled = end;
                    if self.by_beams {
                        beams.fill(batch, state);
                    }
                    let beams = self.by_beams.then_some(&beams);
                    fill_weights(batch, noise, beams, &mut factor, &mut part[start..end]);
                }
            },
        );
        weights
    }

    fn reduce(&self, state: &State, weights: &Vec<Lanes>) -> Result<Reduced, LeastSquaresError> {
        passes::reduce(self, (state, weights), Gauge::Free)
    }

    fn reduce_with_datum(
        &self,
        state: &State,
        weights: &Vec<Lanes>,
    ) -> Result<Reduced, LeastSquaresError> {
        passes::reduce(self, (state, weights), Gauge::Datum)
    }

    fn squares(&self, state: &State, weights: &Vec<Lanes>) -> f64 {
        let of_pieces = in_parallel(
            pieces(self.batches.len()),
            #[inline(always)]
            |piece| {
                let (mut beams, mut sum) = (Beams::default(), Lanes::ZERO);
                for b in piece {
                    beams.fill(&self.batches[b], state);
                    sum += beams.squares(&self.batches[b], self.weights_of(weights, b));
                }
                sum.sum()
            },
        );
        of_pieces.into_iter().sum()
    }

    fn step(
        &self,
        (state, weights): (&State, &Vec<Lanes>),
        s: &[f64],
        factor: f64,
        next: &mut State,
    ) -> Result<(), LeastSquaresError> {
        self.step_shared(state, s, factor, next);
        let batches = &self.batches;
        let pieces = pieces(batches.len());
        let groups = |piece: &Range<usize>| {
            batches[piece.start].groups.start..batches[piece.end - 1].groups.end
        };
        let of_pieces = |all: &Range<usize>| {
            let ends = &self.network.groups;
            ends[all.end - 1].end - ends[all.start].start
        };
        let points = pieces.iter().map(|piece| of_pieces(&groups(piece)));
        let points = split_mut(&mut next.points, points);
        let has_poses = !next.poses.is_empty();
        let poses = pieces
            .iter()
            .map(|piece| if has_poses { groups(piece).len() } else { 0 });
        let poses = split_mut(&mut next.poses, poses);
        let shapes_mm = &next.shapes_mm;
        let parts = points.into_iter().zip(poses);
        try_in_parallel(
            pieces.into_iter().zip(parts).collect(),
            #[inline(always)]
            |(piece, (points, poses)): (Range<usize>, (&mut [_], &mut [_]))| {
                self.memories.lend(
                    #[inline(always)]
                    |memory| {
                        let (mut points, mut poses) = (points, poses);
                        for b in piece {
                            let groups = batches[b].groups.len();
                            let own_points;
                            (own_points, points) = points.split_at_mut(groups * batches[b].points);
                            let own_poses;
                            (own_poses, poses) =
                                poses.split_at_mut(if has_poses { groups } else { 0 });
                            let mut moved = Moved {
                                points: own_points,
                                poses: own_poses,
                            };
                            self.step_groups(
                                ((state, weights), b),
                                (s, factor),
                                shapes_mm,
                                memory,
                                &mut moved,
                            )?;
                        }
                        Ok(())
                    },
                )
            },
        )?;
        Ok(())
    }

    fn factors(&self, state: &State, weights: &Vec<Lanes>) -> Result<Factors, LeastSquaresError> {
        passes::factors(self, (state, weights))
    }

    fn free_motions(&self, state: &State) -> Vec<Vec<f64>> {
        self.datum.free_motions(state, self.shared())
    }

    fn settle(&self, state: &mut State) {
        let motion = self.datum.motion(self.network, &state.points);
        state.move_by(&motion);
    }
}

impl GroupAdjustment<'_> {
    /// Number of unknowns of each group of a batch.
    pub(crate) fn unknowns(&self, batch: &Batch) -> usize {
        match batch.body {
            Some(_) => POSE,
            None => 3 * batch.points,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::batches::batches;
    use crate::bodies::{Bodies, Body, Placed};
    use crate::{Interruption, Noise, Reading, Visit};

    /// Three points read from two stations, one of them interrupted.
    fn network(is_tied: bool) -> Network {
        let home_mm = vec![
            Point3::new(0.0, 0.0, 0.0),
            Point3::new(100.0, 50.0, -30.0),
            Point3::new(-40.0, 80.0, 60.0),
        ];
        let bodies = Bodies {
            of_groups: vec![Placed {
                body: Some(0),
                places: vec![0, 1, 2],
                ref_from_home: Isometry3::identity(),
            }],
            bodies: vec![Body {
                home_mm: home_mm.clone(),
            }],
        };
        Network {
            interruptions: vec![Interruption {
                station: 1,
                first_reading: 4,
            }],
            variance_factors: vec![1.0, 4.0, 1.0, 1.0, 1.0, 1.0],
            stations: vec![None; 2],
            nominal_mm: home_mm,
            groups: std::iter::once(0..3).collect(),
            visits: (0..2)
                .map(|station| Visit {
                    station,
                    group: 0,
                    readings: 3 * station..3 * station + 3,
                })
                .collect(),
            readings: [
                (0, 700.0),
                (1, 810.0),
                (2, 640.0),
                (0, 500.0),
                (1, 420.0),
                (2, 390.0),
            ]
            .map(|(point, length_mm)| Reading { point, length_mm })
            .to_vec(),
            noise: Noise {
                return_sigma_mm: 2e-3,
                ..Noise::default()
            },
            bodies: is_tied.then(|| Arc::new(bodies)),
        }
    }

    /// Analytic equations against central differences of the whitened residuals, for both kinds of groups.
    #[test]
    fn equations_are_the_derivatives_of_the_lengths() {
        for is_tied in [false, true] {
            let network = network(is_tied);
            let stations = vec![
                Point3::new(600.0, 300.0, 200.0),
                Point3::new(-300.0, 400.0, 100.0),
            ];
            let turned = Isometry3::new(Vector3::new(3.0, -2.0, 1.0), Vector3::new(0.4, -0.3, 0.5));
            let points = network.nominal_mm.iter().map(|p| turned * p).collect();
            let state = State::new(&network, stations, vec![3.0, 4.0, 5.0], points);
            let batches = Arc::new(batches(&network));
            let model = GroupAdjustment::new(&network, &batches);
            let weights = model.weights(&state);
            let unknowns = model.unknowns(&batches[0]);
            let residuals = |k: usize, by: f64| {
                let mut moved = state.clone();
                let mut s = vec![0.0; model.shared()];
                if k >= unknowns {
                    s[k - unknowns] = 1.0;
                }
                model.step_shared(&state, &s, by, &mut moved);
                let own = |i: usize| if i == k { by } else { 0.0 };
                match &network.bodies {
                    Some(bodies) => {
                        let twist = [0, 3].map(|i| Vector3::new(own(i), own(i + 1), own(i + 2)));
                        let pose = moved_pose(&state.poses[0], &state.points, twist);
                        let placed = &bodies.of_groups[0];
                        placed.put(&pose, &moved.shapes_mm[0], &mut moved.points);
                        moved.poses[0] = pose;
                    }
                    None => {
                        for (i, point) in moved.points.iter_mut().enumerate() {
                            *point += Vector3::from_fn(|axis, _| own(3 * i + axis));
                        }
                    }
                }
                let mut memory = Memory::default();
                model.fill((&moved, &weights), 0, Gauge::Free, &mut memory);
                [0, 1, 2, 3, 4, 5].map(|row| memory.equations.residual(row))
            };
            let mut memory = Memory::default();
            model.fill((&state, &weights), 0, Gauge::Free, &mut memory);
            let equations = &mut memory.equations;
            for k in 0..unknowns + model.shared() {
                let step = if is_tied && (3..6).contains(&k) {
                    1e-6
                } else {
                    1e-4
                };
                let (plus, minus) = (residuals(k, step), residuals(k, -step));
                for row in 0..6 {
                    let mut shared = vec![Lanes::ZERO; model.shared()];
                    equations.copy_shared_row(row, &mut shared);
                    let analytic = match k.checked_sub(unknowns) {
                        None => equations.own_row(row)[k],
                        Some(k) => shared[k],
                    };
                    let difference = (minus[row].0[0] - plus[row].0[0]) / (2.0 * step);
                    // Whitened rows are of the order 1e3 per mm and 1e5 per rad; differences are good to
                    // 1e-9 of that.
                    let limit = 1e-4 * 1e-4 / step;
                    assert!(
                        (analytic.0[0] - difference).abs() < limit,
                        "{is_tied} column {k}: {} {difference}",
                        analytic.0[0]
                    );
                }
            }
        }
    }
}
