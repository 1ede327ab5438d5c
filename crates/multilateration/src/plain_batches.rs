//! Batches of single points, read once from each of some stations, without a datum.
//!
//! The plain case of [`crate::linearise`] and [`trueaxis_leastsquares::BlockBatch`]: a group is a point
//! with three unknowns `x`, and each row is a reading of its own with the weight `w`,
//!
//! ```text
//! w uᵀ x = w (r + uᵀ dS + dL)
//! ```
//!
//! The number of rows is known when it is compiled, nothing is stored but results, and a pass takes a
//! fraction of the time. A batch with a point that is badly determined, or with a station of which the
//! points leave next to nothing, is left to the general way, which is more exact and names what it refuses.

use nalgebra::Point3;
use trueaxis_leastsquares::{GramSchmidt, LANES, LaneSums, Lanes};

use crate::batches::Batch;
use crate::free_points::{PER_STATION, State};

/// The numbers of rows that are compiled for: with one more than unknowns, and up to eight.
const LEAST_ROWS: usize = 4;
const MOST_ROWS: usize = 8;

/// Whether a batch is one of the plain ones.
#[inline(always)]
pub(crate) fn is_plain(batch: &Batch) -> bool {
    batch.layout.is_plain
        && batch.points == 1
        && batch.zeros.is_empty()
        && (LEAST_ROWS..=MOST_ROWS).contains(&batch.slots())
}

/// Adds a plain batch to the sums of the reduced system; false if it is left to the general way, with the
/// sums as they were.
#[inline(always)]
pub(crate) fn add_to(batch: &Batch, weights: &[Lanes], state: &State, sums: &mut LaneSums) -> bool {
    match batch.slots() {
        LEAST_ROWS => add_rows::<LEAST_ROWS>(batch, weights, state, sums),
        5 => add_rows::<5>(batch, weights, state, sums),
        6 => add_rows::<6>(batch, weights, state, sums),
        7 => add_rows::<7>(batch, weights, state, sums),
        MOST_ROWS => add_rows::<MOST_ROWS>(batch, weights, state, sums),
        _ => false,
    }
}

/// Moves the points of a plain batch by `factor` times what follows from the correction `s` of the
/// stations; false if one of them is badly determined.
#[inline(always)]
pub(crate) fn move_points(
    batch: &Batch,
    weights: &[Lanes],
    state: &State,
    step: (&[f64], f64),
    moved: &mut [Point3<f64>],
) -> bool {
    match batch.slots() {
        LEAST_ROWS => move_rows::<LEAST_ROWS>(batch, weights, state, step, moved),
        5 => move_rows::<5>(batch, weights, state, step, moved),
        6 => move_rows::<6>(batch, weights, state, step, moved),
        7 => move_rows::<7>(batch, weights, state, step, moved),
        MOST_ROWS => move_rows::<MOST_ROWS>(batch, weights, state, step, moved),
        _ => false,
    }
}

/// The rows of a batch and their elimination.
struct Rows<'a, const ROWS: usize> {
    weights: &'a [Lanes; ROWS],
    point: [Lanes; 3],
    columns: [[Lanes; ROWS]; 3],
    residual: [Lanes; ROWS],
    eliminated: GramSchmidt<ROWS, 3>,
}

impl<'a, const ROWS: usize> Rows<'a, ROWS> {
    #[inline(always)]
    fn new(weights: &'a [Lanes; ROWS]) -> Self {
        Self {
            weights,
            point: [Lanes::ZERO; 3],
            columns: [[Lanes::ZERO; ROWS]; 3],
            residual: [Lanes::ZERO; ROWS],
            eliminated: GramSchmidt::new(),
        }
    }

    /// False if a point is badly determined.
    #[inline(always)]
    fn eliminate(&mut self, batch: &Batch, state: &State) -> bool {
        for lane in 0..LANES {
            let point = &state.points[batch.first_points[lane]];
            for axis in 0..3 {
                self.point[axis].0[lane] = point[axis];
            }
        }
        let lengths_mm = &batch.lengths_mm()[..ROWS];
        let visits = &batch.layout.visits[..ROWS];
        for i in 0..ROWS {
            let station = state.stations[visits[i].station];
            let dead_path = Lanes::splat(state.dead_paths_mm[visits[i].station]);
            let x = self.point[0] - Lanes::splat(station.x);
            let y = self.point[1] - Lanes::splat(station.y);
            let z = self.point[2] - Lanes::splat(station.z);
            let distance_mm = z.mul_add(z, y.mul_add(y, x * x)).sqrt();
            let scale = self.weights[i] / distance_mm;
            self.columns[0][i] = x * scale;
            self.columns[1][i] = y * scale;
            self.columns[2][i] = z * scale;
            self.residual[i] = self.weights[i] * (lengths_mm[i] + dead_path - distance_mm);
        }
        self.eliminated.eliminate(&self.columns)
    }
}

/// Part of the variance of a station's readings that their residuals must keep in the mean. `P_ii` is one
/// less what the point takes, of which rounding is then no more than 1e-14. That the columns of `Q` may be
/// less orthogonal does not hide what is free: for a motion of the whole, which is one of the point as
/// well, `B v = A w`, their products `F` enter as `wᵀRᵀ F R w`, and `R` is as small as `F` is large.
const LEAST_KEPT: f64 = 1e-2;

#[inline(always)]
fn add_rows<const ROWS: usize>(
    batch: &Batch,
    weights: &[Lanes],
    state: &State,
    sums: &mut LaneSums,
) -> bool {
    let Ok(weights) = weights.try_into() else {
        return false;
    };
    let mut rows = Rows::<ROWS>::new(weights);
    if !rows.eliminate(batch, state) {
        return false;
    }
    // Lanes without a group count for nothing.
    let used = batch.groups.len();
    let mask = Lanes::from_fn(|lane| f64::from(u8::from(lane < used)));
    let mut projection = [[Lanes::ZERO; ROWS]; ROWS];
    rows.eliminated.fill_projection(&mut projection);
    for (i, row) in projection.iter().enumerate() {
        // Slots without a reading keep all of nothing.
        let read = Lanes::from_fn(|lane| f64::from(u8::from(weights[i].0[lane] > 0.0))) * mask;
        if (row[i] * read).sum() < LEAST_KEPT * read.sum() {
            return false;
        }
    }
    for r in &mut rows.residual {
        *r = *r * mask;
    }
    sums.add_squares(squares(&rows.residual));
    let mut along = [Lanes::ZERO; 3];
    sums.add_taken(rows.eliminated.explain(&mut rows.residual, &mut along));
    let mut runs = [[Lanes::ZERO; PER_STATION]; ROWS];
    for (i, run) in runs.iter_mut().enumerate() {
        for (x, column) in run.iter_mut().zip(&rows.columns) {
            *x = -(column[i] * mask);
        }
        run[PER_STATION - 1] = -(weights[i] * mask);
    }
    let firsts = (0..ROWS).map(
        #[inline(always)]
        |i| first_unknown(batch, i),
    );
    sums.add_runs(firsts, &runs, &projection, &rows.residual);
    true
}

/// First shared unknown of the station of a row.
#[inline(always)]
fn first_unknown(batch: &Batch, row: usize) -> usize {
    PER_STATION * batch.layout.visits[row].station
}

#[inline(always)]
fn move_rows<const ROWS: usize>(
    batch: &Batch,
    weights: &[Lanes],
    state: &State,
    (s, factor): (&[f64], f64),
    moved: &mut [Point3<f64>],
) -> bool {
    let Ok(weights) = weights.try_into() else {
        return false;
    };
    let mut rows = Rows::<ROWS>::new(weights);
    if !rows.eliminate(batch, state) {
        return false;
    }
    for (i, weight) in weights.iter().enumerate() {
        let first = first_unknown(batch, i);
        let own = &s[first..first + PER_STATION];
        let dead_path = Lanes::splat(own[PER_STATION - 1]);
        let mut right = weight.mul_add(dead_path, rows.residual[i]);
        for (column, x) in rows.columns.iter().zip(own) {
            right = column[i].mul_add(Lanes::splat(*x), right);
        }
        rows.residual[i] = right;
    }
    let mut correction = [Lanes::ZERO; 3];
    rows.eliminated.explain(&mut rows.residual, &mut correction);
    rows.eliminated.solve(&mut correction);
    let factor = Lanes::splat(factor);
    for (x, correction) in rows.point.iter_mut().zip(&correction) {
        *x = correction.mul_add(factor, *x);
    }
    let [x, y, z] = &rows.point;
    for (lane, moved) in moved.iter_mut().enumerate() {
        *moved = Point3::new(x.0[lane], y.0[lane], z.0[lane]);
    }
    true
}

#[inline(always)]
fn squares(x: &[Lanes]) -> Lanes {
    let mut sum = Lanes::ZERO;
    for x in x {
        sum = x.mul_add(*x, sum);
    }
    sum
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use trueaxis_leastsquares::Adjustment;

    use super::*;
    use crate::batches::batches;
    use crate::free_adjustment::FreeAdjustment;
    use crate::passes::{self, Gauge, GroupModel, Memory, pieces};
    use crate::{Network, Reading, Visit};

    /// Points in batches of which the last is not full, not all seen from all of `stations`; the sixth
    /// batch is far away, and what is behind the seventieth point is not seen from the last station.
    fn network(stations: usize, points: usize) -> (Network, State) {
        let wave = |i: usize, k: f64| (k * (i as f64 + 0.7)).sin();
        let place = |i: usize, size: f64| {
            Point3::new(wave(i, 1.3), wave(i, 2.9), wave(i, 4.7)) * size + nalgebra::Vector3::x()
        };
        let mut network = Network {
            stations: vec![None; stations],
            nominal_mm: (0..points).map(|i| place(i, 400.0)).collect(),
            groups: (0..points).map(|i| i..i + 1).collect(),
            ..Network::default()
        };
        let mut state = State {
            stations: (0..stations).map(|i| place(i + 20, 2000.0)).collect(),
            dead_paths_mm: (0..stations).map(|i| 10.0 * i as f64).collect(),
            points: network.nominal_mm.clone(),
        };
        for far in state.points.iter_mut().skip(40).take(8) {
            *far += nalgebra::Vector3::repeat(1e7);
        }
        for station in 0..stations {
            for group in 0..points {
                let unseen = (group + station) % 9 == 4 || group > 70 && station + 1 == stations;
                if stations > 4 && unseen {
                    continue;
                }
                let distance = (state.points[group] - state.stations[station]).norm();
                let first = network.readings.len();
                network.readings.push(Reading {
                    point: 0,
                    length_mm: distance + wave(first, 3.3),
                });
                network.visits.push(Visit {
                    station,
                    group,
                    readings: first..first + 1,
                });
            }
        }
        (network, state)
    }

    /// A pass in the widest registers against one without.
    #[test]
    fn any_registers_give_the_same_bits() {
        for stations in LEAST_ROWS..=MOST_ROWS {
            let (network, state) = network(stations, 30);
            let batches = Arc::new(batches(&network));
            assert_eq!(pieces(batches.len()).len(), 1);
            let model = FreeAdjustment::new(&network, &batches, &state);
            let mut sums = LaneSums::new(PER_STATION * stations, 0);
            for (b, batch) in batches.iter().enumerate() {
                assert!(add_to(batch, model.weights_of(b), &state, &mut sums));
            }
            let motions = model.free_motions(&state);
            let narrow = sums.into_reduced().shortest_correction(&motions).unwrap();
            let wide = model.reduce(&state).unwrap();
            let wide = wide.shortest_correction(&motions).unwrap();
            assert_eq!(narrow.shared, wide.shared);
            assert_eq!(narrow.decrease.to_bits(), wide.decrease.to_bits());
        }
    }

    /// Stations next to each other, seen from afar: what they tell of a point is nearly one number.
    #[test]
    fn badly_determined_points_are_left_to_the_general_way() {
        for stations in LEAST_ROWS..=MOST_ROWS {
            let (network, mut state) = network(stations, 30);
            for station in &mut state.stations {
                *station = Point3::new(5000.0, 0.0, 0.0) + station.coords * 1e-5;
            }
            let batches = Arc::new(batches(&network));
            let model = FreeAdjustment::new(&network, &batches, &state);
            let mut sums = LaneSums::new(PER_STATION * stations, 0);
            let mut moved = vec![Point3::origin(); 8];
            let s = vec![0.0; PER_STATION * stations];
            for (b, batch) in batches.iter().enumerate() {
                let weights = model.weights_of(b);
                assert!(!add_to(batch, weights, &state, &mut sums));
                assert!(!move_points(batch, weights, &state, (&s, 1.0), &mut moved));
            }
            assert_eq!(sums.into_reduced().squares().to_bits(), 0);
        }
    }

    /// Sums and steps against those of the general equations; the batch that is far away is left to these.
    #[test]
    fn agrees_with_the_general_way() {
        for stations in LEAST_ROWS..=MOST_ROWS {
            let (network, state) = network(stations, 150);
            let batches = Arc::new(batches(&network));
            assert!(batches.iter().all(is_plain));
            let model = FreeAdjustment::new(&network, &batches, &state);
            let mut general = LaneSums::new(PER_STATION * stations, 0);
            let mut memory = Memory::default();
            let mut corrections = Vec::new();
            let s: Vec<f64> = (0..PER_STATION * stations)
                .map(|k| (k as f64).cos())
                .collect();
            for (b, batch) in batches.iter().enumerate() {
                let mut sums = LaneSums::new(PER_STATION * stations, 0);
                let is_short = add_to(batch, model.weights_of(b), &state, &mut sums);
                assert_eq!(is_short, b != 5);
                passes::eliminate(&model, &state, b, Gauge::Free, &mut memory).unwrap();
                let x = memory.equations.correction(&s);
                for lane in 0..batch.groups.len() {
                    corrections.push([0, 1, 2].map(|axis| x[axis].0[lane]));
                }
                memory.equations.add_to(&mut general);
            }
            let motions = model.free_motions(&state);
            let general = general.into_reduced();
            let plain = model.reduce(&state).unwrap();
            let same = |a: f64, b: f64, size: f64| (a - b).abs() < 1e-9 * size;
            assert!(same(plain.squares(), general.squares(), general.squares()));
            let general = general.shortest_correction(&motions).unwrap();
            let plain = plain.shortest_correction(&motions).unwrap();
            assert!(same(plain.decrease, general.decrease, general.decrease));
            let size = general
                .shared
                .iter()
                .fold(0.0_f64, |max, x| max.max(x.abs()));
            assert!(size > 0.1, "{size}");
            for (a, b) in plain.shared.iter().zip(&general.shared) {
                assert!(same(*a, *b, size), "{a} {b}");
            }
            let mut next = state.clone();
            model.step(&state, &s, 0.5, &mut next).unwrap();
            for ((moved, point), x) in next.points.iter().zip(&state.points).zip(&corrections) {
                for axis in 0..3 {
                    let expected = point[axis] + 0.5 * x[axis];
                    let size = expected.abs().max(1.0);
                    assert!(same(moved[axis], expected, size), "{moved} {expected}");
                }
            }
        }
    }
}
