//! The equations of eight groups, linearised.
//!
//! A length and, with the beam `u = (p - S) / |p - S|`, its change:
//!
//! ```text
//! l = |p - S| - L + hᵀ a      dl = uᵀ dp - uᵀ dS - dL + hᵀ da
//! ```
//!
//! with the contrasts `a` of the reflectors' constants ([`crate::reflectors`]). A free point has three unknowns `dp`.
//! Points of a body have home positions `r_k`, common to all groups, and a pose in each:
//!
//! ```text
//! p_k = R r_k + t       dp_k = dt + dω × (p_k - c) + R N_k ds
//! ```
//!
//! with the centroid `c` of the group's points and the deformations `s` of the body that no rigid motion makes (three
//! for a triangle). Six unknowns thus replace the nine coordinates of a free triangle. Rows are then multiplied by
//! the weights of their visit ([`crate::visit_weights`]).

use nalgebra::Point3;
use trueaxis_leastsquares::{BlockBatch, Lanes, RowMut, Shape};

use crate::batches::Batch;
use crate::beams::{Beam, Beams, take_points};
use crate::datum::Datum;
use crate::lane_vectors::{at, cross, dot, minus, splat, times};
use crate::state::{DATUM, PER_STATION, POSE};
use crate::tie::Tie;

/// Fills the equations of a batch, not yet whitened; `shared` is the number of all shared unknowns. The datum comes
/// with the nominal points; without a datum there are no constraints. `tie` is needed where the points belong to a
/// body.
#[inline(always)]
pub(crate) fn fill(
    batch: &Batch,
    tie: Option<&Tie>,
    datum: Option<(&Datum, &[Point3<f64>])>,
    beams: &mut Beams,
    (stations, shared): (usize, usize),
    equations: &mut BlockBatch,
) {
    let in_quads = PER_STATION * stations;
    equations.reset(Shape {
        rows: batch.slots(),
        unknowns: tie.map_or(3 * batch.points, |_| POSE),
        in_quads,
        shared,
        datum: if datum.is_some() { DATUM } else { 0 },
    });
    for visit in &batch.layout.visits {
        for slot in visit.slots.clone() {
            let row = equations.row_mut(slot);
            *row.start = PER_STATION * visit.station;
            fill_row(
                (batch, slot),
                &beams.of_slots[slot],
                tie,
                (stations, in_quads),
                row,
            );
        }
    }
    if let Some((datum, nominal_mm)) = datum {
        take_points(batch, batch.own(nominal_mm), &mut beams.nominal);
        fill_datum(datum, beams, tie, equations);
    }
    equations.use_only(batch.groups.len());
}

/// The derivatives of a length by all unknowns: nothing else computes them.
#[inline(always)]
fn fill_row(
    (batch, slot): (&Batch, usize),
    beam: &Beam,
    tie: Option<&Tie>,
    (stations, in_quads): (usize, usize),
    row: RowMut<'_>,
) {
    let point = batch.layout.point_of_slot[slot];
    let u = beam.unit;
    row.others.fill(Lanes::ZERO);
    match tie {
        None => {
            row.own.fill(Lanes::ZERO);
            row.own[3 * point..3 * point + 3].copy_from_slice(&u);
        }
        Some(tie) => {
            row.own[..3].copy_from_slice(&u);
            row.own[3..].copy_from_slice(&cross(at(&tie.arms_mm, point), u));
            let moved = tie.deformations.chunks_exact(3 * batch.points);
            for (moved, x) in moved.zip(&mut row.others[tie.first - in_quads..]) {
                *x = dot(u, at(moved, point));
            }
        }
    }
    // The contrasts are the last shared unknowns.
    let contrasts = batch.contrasts_of(point);
    let first = row.others.len() - contrasts.len();
    row.others[first..].copy_from_slice(contrasts);
    for (x, u) in row.quad.iter_mut().zip(u) {
        *x = -u;
    }
    *row.residual = beam.residual_mm;
    let minus = Lanes::splat(-1.0);
    row.quad[PER_STATION - 1] = Lanes::ZERO;
    let Some(zeros) = batch.zeros.get(slot) else {
        row.quad[PER_STATION - 1] = minus;
        return;
    };
    for (lane, &zero) in zeros.iter().enumerate() {
        match zero.checked_sub(stations) {
            None => row.quad[PER_STATION - 1].0[lane] = -1.0,
            Some(after) => row.others[after].0[lane] = -1.0,
        }
    }
}

/// `H` of the points, or of the poses that tie them, and the closure of the constraints. The datum takes shapes as
/// they are.
#[inline(always)]
fn fill_datum(datum: &Datum, beams: &Beams, tie: Option<&Tie>, equations: &mut BlockBatch) {
    let centroid = splat(datum.centroid.x, datum.centroid.y, datum.centroid.z);
    let per_radius = Lanes::splat(1.0 / datum.radius_mm);
    let (one, zero) = (Lanes::splat(1.0), Lanes::ZERO);
    for point in 0..beams.points.len() / 3 {
        let (place, nominal) = (at(&beams.points, point), at(&beams.nominal, point));
        let lever = times(minus(nominal, centroid), per_radius);
        let [rx, ry, rz] = lever;
        let motions = [
            [one, zero, zero],
            [zero, one, zero],
            [zero, zero, one],
            [zero, -rz, ry],
            [rz, zero, -rx],
            [-ry, rx, zero],
        ];
        let shift = minus(place, nominal);
        let turn = cross(lever, shift);
        let missed = shift.into_iter().chain(turn);
        for (k, (motion, missed)) in motions.into_iter().zip(missed).enumerate() {
            let column = equations.datum_mut(k);
            match tie {
                None => column[3 * point..3 * point + 3].copy_from_slice(&motion),
                Some(tie) => {
                    let turned = cross(at(&tie.arms_mm, point), motion);
                    for (x, h) in column.iter_mut().zip(motion.into_iter().chain(turned)) {
                        *x += h;
                    }
                }
            }
            equations.closure_mut()[k] -= missed;
        }
    }
}
