//! A target that shifts in its nest.
//!
//! From an instant on the target is displaced by d in the frame of its stage, for good or until the tracker goes to another station. With the
//! whitened columns X of the three coordinates of d and what the adjustment leaves of them, M X,
//!
//! ```text
//! G = Xᵀ M X     s = Xᵀ v     d = G⁺ s     S = sᵀ G⁺ s     S/3 / ((vᵀv - S)/(ν - 3)) ~ F(3, ν - 3) without a displacement
//! ```
//!
//! Steps that were read once from each station absorb most of a slip, so that no single length shows it. A machine that
//! deforms may look the same.

use std::ops::Range;

use nalgebra::{DMatrix, DMatrixView, Matrix3, RowVector3, SymmetricEigen, Vector3};
use trueaxis_leastsquares::f_upper_tail;
use trueaxis_multilateration::{CHECKED_TOL, Network, Solution, Visit, Whitened};

use crate::jump_tests::largest_jumps;
use crate::screened::Screened;
use crate::uneven::place_of;

/// Instants that are tried for each target, from each station and from all.
const INSTANTS: usize = 128;

/// Coordinates of a displacement, and the redundancy beside them below which nothing is said.
const COORDINATES: f64 = 3.0;
const LEAST_DEGREES: f64 = 10.0;

/// Probability that a target of a clean campaign is said to have slipped.
const LEVEL: f64 = 1e-3;

/// Lead of a slip, in squares, that rules out that of another target or the jump of a zero.
const AHEAD: f64 = 10.0;

/// Groups of a campaign whose rows of the hat matrix would take too much memory.
const MANY_GROUPS: usize = 1000;

/// A target that slipped.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slip {
    /// The body, and the place on it.
    pub place: (usize, usize),
    /// The station from which it stood elsewhere; none where it stayed there.
    pub station: Option<usize>,
    /// First reading after it, by the instants tried.
    pub first_reading: usize,
    /// Where it moved, in the frame of its stage, mm.
    pub moved_mm: Vector3<f64>,
    /// Standard uncertainty of how far, mm.
    pub u_mm: f64,
    /// S.
    pub statistic: f64,
    /// Probability of as much by chance, anywhere.
    pub p_value: f64,
}

/// What may have slipped.
#[derive(Debug, Clone)]
pub struct Slips {
    /// The target that most plainly slipped, and those whose slips explain nearly as much.
    pub targets: Vec<Slip>,
    /// The rows of the network with the residuals that the first slip leaves.
    pub left: Whitened,
}

impl Screened {
    /// What slipped, if anything did.
    pub fn slips(&self) -> Option<Slips> {
        let (network, solution) = (&self.network, &*self.solution);
        let bodies = network.bodies.iter().flat_map(|bodies| &bodies.bodies);
        let places = bodies.enumerate();
        let places = places.flat_map(|(b, body)| (0..body.home_mm.len()).map(move |k| (b, k)));
        let redundancy = solution.degrees_of_freedom() as f64 - COORDINATES;
        if network.groups.len() > MANY_GROUPS || redundancy < LEAST_DEGREES {
            return None;
        }
        let mut rows = Whitened::new(network, solution);
        let (mut slips, mut tried) = (Vec::new(), 0);
        for place in places {
            let all = visits((network, solution), place, &rows);
            let of_one = |station: Option<usize>| {
                let seen = |visit: &&Columns| station.is_none_or(|j| visit.station == j);
                let own: Vec<&Columns> = all.iter().filter(seen).collect();
                slips_of(place, station, &rows, &own)
            };
            let stations = (0..network.stations.len()).map(Some);
            let own: Vec<Slip> = stations.chain([None]).flat_map(of_one).collect();
            tried += own.len();
            let plainest = |a: &Slip, b: &Slip| a.statistic.total_cmp(&b.statistic);
            slips.extend(own.into_iter().max_by(plainest));
        }
        slips.sort_by(|a, b| b.statistic.total_cmp(&a.statistic));
        let most = slips.first().map_or(0.0, |slip| slip.statistic);
        let left = rows.residuals.iter().map(|v| v * v).sum::<f64>() - most;
        let ratio = most / COORDINATES / (left / redundancy);
        let p_value = (f_upper_tail(ratio, COORDINATES, redundancy) * tried as f64).min(1.0);
        let jumps = largest_jumps(network, &rows).into_iter();
        let least = jumps.fold(most, |most, jump| most.max(jump.w * jump.w)) - AHEAD;
        slips.retain(|slip| p_value < LEVEL && slip.statistic > least);
        slips.iter_mut().for_each(|slip| slip.p_value = p_value);
        let first = slips.first()?;
        let mut by_slip = vec![0.0; rows.residuals.len()];
        for visit in visits((network, solution), first.place, &rows) {
            let is_after = visit.first_reading >= first.first_reading;
            if is_after && first.station.is_none_or(|j| visit.station == j) {
                for (row, x) in visit.rows.zip(&visit.of_rows) {
                    by_slip[row] = x.transpose().dot(&first.moved_mm);
                }
            }
        }
        rows.project(&mut by_slip);
        let residuals = rows.residuals.iter_mut().zip(&by_slip);
        residuals.for_each(|(residual, x)| *residual -= x);
        Some(Slips {
            targets: slips,
            left: rows,
        })
    }
}

/// A visit that reads a target, with the whitened columns of its displacement: a row for each of the visit.
struct Columns {
    station: usize,
    first_reading: usize,
    rows: Range<usize>,
    of_rows: Vec<RowVector3<f64>>,
}

/// The visits that read a place of a body.
fn visits(
    (network, solution): (&Network, &Solution),
    (body, place): (usize, usize),
    rows: &Whitened,
) -> Vec<Columns> {
    let mut unit = Vec::new();
    let of_visit = |(number, visit): (usize, &Visit)| {
        let of_place = |i: &usize| place_of(network, number, *i) == Some((body, place));
        let readings = visit.readings.clone().filter(of_place).collect::<Vec<_>>();
        let mut of_rows = vec![RowVector3::zeros(); visit.readings.len()];
        for &reading in &readings {
            let point = network.point(visit.group, network.readings[reading].point);
            let station_mm = solution.stations[visit.station].position_mm;
            let beam = (solution.points_mm[point] - station_mm).normalize();
            let on_stage = solution.poses[visit.group].inverse_transform_vector(&beam);
            rows.unit_error(number, reading, &mut unit);
            for (row, x) in of_rows.iter_mut().zip(&unit) {
                *row += on_stage.transpose() * *x;
            }
        }
        (!readings.is_empty()).then(|| Columns {
            station: visit.station,
            first_reading: visit.readings.start,
            rows: rows.visits[number].clone(),
            of_rows,
        })
    };
    network
        .visits
        .iter()
        .enumerate()
        .filter_map(of_visit)
        .collect()
}

/// The slips before each instant that is tried.
fn slips_of(
    place: (usize, usize),
    station: Option<usize>,
    rows: &Whitened,
    visits: &[&Columns],
) -> Vec<Slip> {
    let width = rows.shared_width;
    let sigma = DMatrixView::from_slice(&rows.reduced_inverse, width, width);
    let mut of_groups = DMatrix::<f64>::zeros(3, rows.groups * rows.own_width);
    let mut of_shared = DMatrix::<f64>::zeros(3, width);
    let (mut gram, mut score) = (Matrix3::zeros(), Vector3::zeros());
    let every = visits.len().div_ceil(INSTANTS).max(1);
    let mut slips = Vec::new();
    for (k, visit) in visits.iter().enumerate().skip(1).rev() {
        for (row, x) in visit.rows.clone().zip(&visit.of_rows) {
            let x = x.transpose();
            gram += x * x.transpose();
            score += x * rows.residuals[row];
            for (column, o) in rows.columns_of_group(row).zip(rows.own_row(row)) {
                of_groups.column_mut(column).axpy(*o, &x, 1.0);
            }
            for (mut sum, t) in of_shared.column_iter_mut().zip(rows.shared_row(row)) {
                sum.axpy(*t, &x, 1.0);
            }
        }
        if k % every != 0 {
            continue;
        }
        let absorbed =
            &of_groups * of_groups.transpose() + &of_shared * sigma * of_shared.transpose();
        let left = SymmetricEigen::new(gram - absorbed.fixed_view::<3, 3>(0, 0));
        let along = left.eigenvectors.tr_mul(&score);
        let least = CHECKED_TOL * gram.trace();
        let inverse = left
            .eigenvalues
            .map(|x| if x > least { x.recip() } else { 0.0 });
        let moved = along.component_mul(&inverse);
        let variance = moved.component_mul(&moved).dot(&inverse) / moved.norm_squared();
        slips.push(Slip {
            place,
            station,
            first_reading: visit.first_reading,
            moved_mm: left.eigenvectors * moved,
            u_mm: variance.sqrt(),
            statistic: moved.dot(&along),
            p_value: 1.0,
        });
    }
    slips
}
