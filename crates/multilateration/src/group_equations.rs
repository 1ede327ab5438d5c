//! The normal equations of one group of points: any number of visits, correlated readings,
//! interruptions, missing readings.
//!
//! A visit with unit vectors `u_i`, residuals `r_i` and `W = C⁻¹` adds to the equations of the group's
//! points `q_i` and of its station and dead paths, with `b_i = (u_i, 1)` and
//! `dl_i = u_iᵀ dp - b_iᵀ ds`:
//!
//! ```text
//! AᵀA: Σ_ik u_i W_ik u_kᵀ at (q_i, q_k)      AᵀB: -Σ_i u_i (W b)_iᵀ      Aᵀr: Σ_i u_i (W r)_i
//! BᵀB:  Σ_i b_i (W b)_iᵀ                     Bᵀr: -Σ_i b_i (W r)_i
//! ```
//!
//! No row is whitened and no zero of a row is multiplied, which makes this some times faster than
//! reflecting the rows; groups whose beams nearly lie in a plane are reflected all the same ([`Block`]
//! says when and why).

use nalgebra::Vector3;
use trueaxis_leastsquares::{Block, BlockRows, Error as LeastSquaresError, Reduced};

use crate::free_points::{DATUM, FreePoints, PER_STATION, State, zero_column};

/// Memory for one group after the other.
pub(crate) struct GroupMemory {
    pub(crate) block: Block,
    /// The points' equations alone, for when the shared unknowns are known.
    points: Block,
    beams: Vec<WeightedBeam>,
    rows: BlockRows,
    datum: Vec<f64>,
    closure: [f64; DATUM],
}

/// One reading of a group.
struct WeightedBeam {
    /// Unit vector from the station to the point.
    unit: [f64; 3],
    /// Its row of `W` times the unit vectors of the visit.
    weighted_unit: [f64; 3],
    /// Observed minus computed, mm.
    residual: f64,
    /// Its row of `W` times the residuals of the visit.
    weighted_residual: f64,
    /// The point within the group.
    point: usize,
    /// Column of the dead path.
    zero: usize,
}

impl GroupMemory {
    pub(crate) fn new(model: &FreePoints<'_>) -> Self {
        Self {
            block: Block::new(model.shared(), DATUM),
            points: Block::new(0, 0),
            beams: Vec::new(),
            rows: BlockRows::default(),
            datum: Vec::new(),
            closure: [0.0; DATUM],
        }
    }
}

impl FreePoints<'_> {
    /// Eliminates a group at `state`.
    #[inline(always)]
    pub(crate) fn eliminate_group(
        &self,
        state: &State,
        group: usize,
        memory: &mut GroupMemory,
    ) -> Result<(), LeastSquaresError> {
        memory.block.reset(3 * self.network().groups[group].len());
        memory.beams.clear();
        for &v in self.visits_of(group) {
            let first = memory.beams.len();
            self.take_beams(state, v, &mut memory.beams);
            let beams = &mut memory.beams[first..];
            let right = self.shared() + DATUM;
            add_points(beams, self.weights(v), right, &mut memory.block);
            self.add_shared(v, beams, &mut memory.block);
        }
        self.add_datum(state, group, memory);
        let enough = memory.beams.len() >= memory.block.unknowns();
        if enough && memory.block.eliminate().is_ok() {
            return Ok(());
        }
        self.reflect_group(state, group, memory)
    }

    /// The corrections `x` to a group's points that belong to the solution `t = (s, λ)` of the reduced
    /// system at `state`: with the shared unknowns known, `AᵀA x = Aᵀ (r - B s) - H λ`.
    #[inline(always)]
    pub(crate) fn correct_group(
        &self,
        state: &State,
        group: usize,
        t: &[f64],
        memory: &mut GroupMemory,
        x: &mut Vec<f64>,
    ) -> Result<(), LeastSquaresError> {
        let points = self.network().groups[group].clone();
        let (s, multipliers) = t.split_at(self.shared());
        x.clear();
        x.resize(3 * points.len(), 0.0);
        memory.points.reset(x.len());
        memory.beams.clear();
        for &v in self.visits_of(group) {
            let first = memory.beams.len();
            self.take_beams(state, v, &mut memory.beams);
            let beams = &mut memory.beams[first..];
            let station = &s[PER_STATION * self.network().visits[v].station..];
            for beam in &mut *beams {
                let moved = beam.unit.iter().zip(station).map(|(u, s)| u * s);
                beam.residual += moved.sum::<f64>() + s[beam.zero];
            }
            add_points(beams, self.weights(v), 0, &mut memory.points);
        }
        let turn = Vector3::from_column_slice(&multipliers[3..]);
        for (k, point) in points.enumerate() {
            let motion = turn.cross(&self.lever(self.network().nominal_mm[point]));
            for axis in 0..3 {
                memory.points.others_mut(3 * k + axis)[0] -= multipliers[axis] + motion[axis];
            }
        }
        if memory.beams.len() >= x.len() && memory.points.eliminate().is_ok() {
            memory.points.correction(&[], x);
            return Ok(());
        }
        self.reflect_group(state, group, memory)?;
        memory.block.correction(t, x);
        Ok(())
    }

    /// Eliminates a group by its rows: slower, and good for weak pivots.
    #[cold]
    fn reflect_group(
        &self,
        state: &State,
        group: usize,
        memory: &mut GroupMemory,
    ) -> Result<(), LeastSquaresError> {
        let points = self.network().groups[group].clone();
        self.fill_rows(state, group, &mut memory.rows);
        memory.datum.clear();
        // The closure is known already.
        self.datum_of(state, points, &mut memory.datum, &mut [0.0; DATUM]);
        memory
            .block
            .eliminate_rows(group, &mut memory.rows, &memory.datum)
    }

    /// Adds a group to the reduced system after its elimination.
    #[inline(always)]
    pub(crate) fn reduce_group(&self, group: usize, memory: &GroupMemory, reduced: &mut Reduced) {
        reduced.add(&memory.block);
        reduced.close(&memory.closure);
        let right = self.shared() + DATUM;
        let mut squares = 0.0;
        let mut first = 0;
        for &v in self.visits_of(group) {
            let visit = &self.network().visits[v];
            let count = visit.readings.len();
            let beams = &memory.beams[first..first + count];
            first += count;
            let station = PER_STATION * visit.station;
            for (beam, weights) in beams.iter().zip(self.weights(v).chunks_exact(count.max(1))) {
                squares += beam.residual * beam.weighted_residual;
                for (axis, u) in beam.unit.into_iter().enumerate() {
                    let row = reduced.row_mut(station + axis);
                    for (m, w) in row[station..station + 3].iter_mut().zip(beam.weighted_unit) {
                        *m += u * w;
                    }
                    for (other, w) in beams.iter().zip(weights) {
                        row[other.zero] += u * w;
                    }
                    row[right] -= u * beam.weighted_residual;
                }
                let row = reduced.row_mut(beam.zero);
                for (other, w) in beams.iter().zip(weights) {
                    row[other.zero] += w;
                }
                row[right] -= beam.weighted_residual;
            }
        }
        reduced.count(memory.beams.len(), memory.block.unknowns(), squares);
    }

    /// Appends the beams of a visit.
    #[inline(always)]
    fn take_beams(&self, state: &State, v: usize, beams: &mut Vec<WeightedBeam>) {
        let network = self.network();
        let visit = &network.visits[v];
        let stations = network.stations.len();
        for i in visit.readings.clone() {
            let reading = &network.readings[i];
            let point = network.point(visit.group, reading.point);
            let (unit, distance_mm) = state.beam(visit.station, point);
            let zero = self.zero_of(i);
            beams.push(WeightedBeam {
                unit: unit.into(),
                weighted_unit: [0.0; 3],
                residual: reading.length_mm + state.dead_paths_mm[zero] - distance_mm,
                weighted_residual: 0.0,
                point: reading.point,
                zero: zero_column(zero, stations),
            });
        }
    }

    /// Adds `AᵀB` of a visit.
    #[inline(always)]
    fn add_shared(&self, v: usize, beams: &[WeightedBeam], block: &mut Block) {
        let station = PER_STATION * self.network().visits[v].station;
        let weights = self.weights(v).chunks_exact(beams.len().max(1));
        for (beam, weights) in beams.iter().zip(weights) {
            for (axis, u) in beam.unit.into_iter().enumerate() {
                let others = block.others_mut(3 * beam.point + axis);
                for (m, x) in others[station..station + 3]
                    .iter_mut()
                    .zip(beam.weighted_unit)
                {
                    *m -= u * x;
                }
                for (other, w) in beams.iter().zip(weights) {
                    others[other.zero] -= u * w;
                }
            }
        }
    }

    /// Writes `H` of a group's points (as [`FreePoints::datum_of`] has it) and its closure.
    #[inline(always)]
    fn add_datum(&self, state: &State, group: usize, memory: &mut GroupMemory) {
        let columns = self.shared()..self.shared() + DATUM;
        memory.closure = [0.0; DATUM];
        for (k, point) in self.network().groups[group].clone().enumerate() {
            let nominal = self.network().nominal_mm[point];
            let r = self.lever(nominal);
            let deviation = state.points[point] - nominal;
            let moment = r.cross(&deviation);
            let motions = [
                [1.0, 0.0, 0.0, 0.0, r.z, -r.y],
                [0.0, 1.0, 0.0, -r.z, 0.0, r.x],
                [0.0, 0.0, 1.0, r.y, -r.x, 0.0],
            ];
            for (axis, row) in motions.iter().enumerate() {
                memory.block.others_mut(3 * k + axis)[columns.clone()].copy_from_slice(row);
                memory.closure[axis] -= deviation[axis];
                memory.closure[3 + axis] -= moment[axis];
            }
        }
    }
}

/// Weights the beams of a visit and adds its `AᵀA` and `Aᵀr`; `right` is the column of the right side.
#[inline(always)]
fn add_points(beams: &mut [WeightedBeam], weights: &[f64], right: usize, block: &mut Block) {
    for (i, weights) in weights.chunks_exact(beams.len().max(1)).enumerate() {
        let (mut weighted_unit, mut weighted_residual) = ([0.0; 3], 0.0);
        for (other, w) in beams.iter().zip(weights) {
            for (sum, u) in weighted_unit.iter_mut().zip(other.unit) {
                *sum += w * u;
            }
            weighted_residual += w * other.residual;
        }
        let beam = &mut beams[i];
        (beam.weighted_unit, beam.weighted_residual) = (weighted_unit, weighted_residual);
        let beam = &beams[i];
        for (axis, u) in beam.unit.into_iter().enumerate() {
            let own = block.own_mut(3 * beam.point + axis);
            // The lower triangle is not read.
            let pairs = beams.iter().zip(weights);
            for (other, w) in pairs.filter(|(other, _)| other.point >= beam.point) {
                let part = &mut own[3 * other.point..3 * other.point + 3];
                for (m, x) in part.iter_mut().zip(other.unit) {
                    *m += u * w * x;
                }
            }
            block.others_mut(3 * beam.point + axis)[right] += u * weighted_residual;
        }
    }
}
