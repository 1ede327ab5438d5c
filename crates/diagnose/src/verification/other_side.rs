//! Readings of a single cycle there and back that contradict the other side of their position.
//!
//! Where no position was read twice from one side, the difference of the sides is the only check of a reading. It may
//! vary along the axis, and step where something jumped, but a difference far from both its neighbours on the same
//! side of them is that of one wrong reading. At an end of the axis the one neighbour must stay where those beyond it
//! are. Two neighbouring ones, or more than a few, are structure.
//!
//! The mean of both sides moves by half of the error, which tells which reading is wrong where the curve is smooth.

use trueaxis_campaign::Verification;
use trueaxis_leastsquares::median;

use crate::engine::{ACCIDENTS, most};
use crate::verification::base::{count, stands};
use crate::verification::comparison::Comparison;
use crate::verification::doubted::{FAR, OF_MEDIAN};
use crate::verification::gross_error::{Contradicts, GrossError};
use crate::verification::gross_errors::{IS_ON_ITS_WAY, readings_of};

/// Positions with both sides from which on a difference may be left out: noise has one as far off in 0.3 % of tables
/// of ten.
const LEAST_PAIRS: usize = 10;

/// Share of the error within which the mean of both sides must have moved by half of it.
const AGREES: f64 = 0.25;

/// Arrivals at one position, forward and backward.
type Pair = [usize; 2];

/// The readings of a table that are gross errors against the other side, in its order.
pub(crate) fn against_other_side(
    verification: &Verification,
    comparison: &Comparison<'_>,
) -> Vec<GrossError> {
    let pairs = match comparison.line() {
        Some(axis) => pairs(comparison, axis),
        None => Vec::new(),
    };
    if pairs.len() < LEAST_PAIRS {
        return Vec::new();
    }
    let of_pairs = |part: [f64; 2]| -> Vec<f64> {
        let y = &comparison.difference_um;
        let value = |&[a, b]: &Pair| part[0] * y[a] + part[1] * y[b];
        pairs.iter().map(value).collect()
    };
    let mut difference = of_pairs([1.0, -1.0]);
    let half_sum = of_pairs([0.5, 0.5]);
    let digit_um = 12.0_f64.sqrt() * comparison.resolution_um().unwrap_or_default();
    let u_um = noise_um(&difference).max(digit_um);
    close_turn(&mut difference, &pairs, comparison);
    let is_far = |k: &usize| off(&difference, *k).abs() > FAR * u_um;
    let far: Vec<usize> = (0..pairs.len()).filter(is_far).collect();
    let are_alone = far.windows(2).all(|two| two[0] + 1 < two[1]);
    if far.len() > most(ACCIDENTS, 2 * pairs.len()) || !are_alone {
        return Vec::new();
    }
    let of_mean = noise_um(&half_sum).max(digit_um);
    let mut left_out: Vec<(usize, [f64; 2], Contradicts)> = Vec::new();
    for k in far {
        // Less the mean of two neighbours, or at an end less one.
        let (error_um, of_variance) = match bend(&difference, k) {
            Some(bend) => (bend, 1.5),
            None => (off(&difference, k), 2.0),
        };
        let u_um = u_um * f64::sqrt(of_variance);
        // Where the curve is rough, the mean tells nothing.
        let is_smooth = 2.0 * FAR * of_mean < error_um.abs();
        let moved = bend(&half_sum, k).filter(|_| is_smooth);
        let agrees = |part: f64| {
            moved.is_some_and(|moved| (moved - part * error_um).abs() < AGREES * error_um.abs())
        };
        let [forward, backward] = pairs[k];
        let is_forward = agrees(0.5);
        let is_told = is_forward != agrees(-0.5);
        let contradicts = match is_told {
            true => Contradicts::TheOtherSide,
            false => Contradicts::TheOther,
        };
        if is_forward || !is_told {
            left_out.push((forward, [error_um, u_um], contradicts));
        }
        if !is_forward || !is_told {
            left_out.push((backward, [-error_um, u_um], contradicts));
        }
    }
    left_out.sort_by_key(|(arrival, ..)| *arrival);
    let readings = left_out
        .into_iter()
        .flat_map(|(arrival, [error_um, u_um], why)| {
            let own = readings_of(comparison, arrival);
            own.map(move |reading| GrossError::new(verification, reading, (error_um, u_um), why))
        });
    readings.collect()
}

/// The positions that were read once from either side, in the order of the axis.
fn pairs(comparison: &Comparison<'_>, axis: usize) -> Vec<Pair> {
    let stands = stands(comparison);
    let mut of_stands: Vec<Vec<usize>> = vec![Vec::new(); count(&stands)];
    for (arrival, stand) in stands.into_iter().enumerate() {
        of_stands[stand].push(arrival);
    }
    let arrivals = &comparison.arrivals;
    let pair = |own: Vec<usize>| match own[..] {
        [a, b] if arrivals[a].direction > arrivals[b].direction => Some([a, b]),
        [a, b] if arrivals[a].direction < arrivals[b].direction => Some([b, a]),
        _ => None,
    };
    let mut pairs: Vec<Pair> = of_stands.into_iter().filter_map(pair).collect();
    let at = |pair: &Pair| arrivals[pair[0]].positions[axis];
    pairs.sort_by(|a, b| at(a).total_cmp(&at(b)));
    pairs
}

/// Where an axis turned without overrun, its lost motion beside the nearest positions may be missing in any part: that
/// is no error.
fn close_turn(difference: &mut [f64], pairs: &[Pair], comparison: &Comparison<'_>) {
    if comparison.is_position_after_position() {
        return;
    }
    let last = pairs.len() - 1;
    for (end, nearest) in [(0, 1..4), (last, last - 3..last)] {
        let [a, b] = pairs[end];
        let near = median(&mut difference[nearest].to_vec()).filter(|_| a.abs_diff(b) == 1);
        if let Some(near) = near {
            difference[end] += near - difference[end].clamp(near.min(0.0), near.max(0.0));
        }
    }
}

/// How far a value is off both its neighbours: less far off one of them, none if it is between them. At an end how
/// far off the neighbour.
fn off(values: &[f64], k: usize) -> f64 {
    let to = |other: usize| values[k] - values[other];
    let last = values.len() - 1;
    let mean = |a: usize, b: usize| 0.5 * (values[a] + values[b]);
    let (off, near, far) = match k {
        0 => (to(1), values[1], mean(2, 3)),
        k if k == last => (to(k - 1), values[k - 1], mean(k - 2, k - 3)),
        k => {
            let [before, after] = [to(k - 1), to(k + 1)];
            let off = match before * after > 0.0 {
                true => before.abs().min(after.abs()).copysign(before),
                false => 0.0,
            };
            let far = mean(k.saturating_sub(2), (k + 2).min(last));
            (off, mean(k - 1, k + 1), far)
        }
    };
    match (near - far).abs() > IS_ON_ITS_WAY * off.abs() {
        true => 0.0,
        false => off,
    }
}

/// How far a value is off the mean of its neighbours; `None` at an end.
fn bend(values: &[f64], k: usize) -> Option<f64> {
    let before = values.get(k.checked_sub(1)?)?;
    Some(values[k] - 0.5 * (before + values.get(k + 1)?))
}

/// Standard deviation of values beside a course, from their bends.
fn noise_um(values: &[f64]) -> f64 {
    let bends = (0..values.len()).filter_map(|k| bend(values, k));
    let mut bends: Vec<f64> = bends.map(f64::abs).collect();
    OF_MEDIAN * median(&mut bends).unwrap_or_default() / 1.5_f64.sqrt()
}
