//! Vectors of three coordinates, eight side by side.
//!
//! Written out: closures over arrays may stay calls, which do not use the dispatched registers.

use trueaxis_leastsquares::Lanes;

/// A vector in each lane.
pub(crate) type LaneVector = [Lanes; 3];

/// The vector of a point, from those of all points, one after the other.
#[inline(always)]
pub(crate) fn at(all: &[Lanes], point: usize) -> LaneVector {
    [all[3 * point], all[3 * point + 1], all[3 * point + 2]]
}

#[inline(always)]
pub(crate) fn plus([a, b, c]: LaneVector, [x, y, z]: LaneVector) -> LaneVector {
    [a + x, b + y, c + z]
}

#[inline(always)]
pub(crate) fn minus([a, b, c]: LaneVector, [x, y, z]: LaneVector) -> LaneVector {
    [a - x, b - y, c - z]
}

#[inline(always)]
pub(crate) fn times([a, b, c]: LaneVector, factor: Lanes) -> LaneVector {
    [a * factor, b * factor, c * factor]
}

/// `sum + factor x`.
#[inline(always)]
pub(crate) fn plus_times(
    [a, b, c]: LaneVector,
    factor: Lanes,
    [x, y, z]: LaneVector,
) -> LaneVector {
    [
        factor.mul_add(x, a),
        factor.mul_add(y, b),
        factor.mul_add(z, c),
    ]
}

#[inline(always)]
pub(crate) fn dot([a, b, c]: LaneVector, [x, y, z]: LaneVector) -> Lanes {
    c.mul_add(z, b.mul_add(y, a * x))
}

#[inline(always)]
pub(crate) fn cross([a, b, c]: LaneVector, [x, y, z]: LaneVector) -> LaneVector {
    [b * z - c * y, c * x - a * z, a * y - b * x]
}

#[inline(always)]
pub(crate) fn splat(x: f64, y: f64, z: f64) -> LaneVector {
    [Lanes::splat(x), Lanes::splat(y), Lanes::splat(z)]
}

/// Adds a vector to the front of a slice.
#[inline(always)]
pub(crate) fn add(sum: &mut [Lanes], [x, y, z]: LaneVector) {
    sum[0] += x;
    sum[1] += y;
    sum[2] += z;
}
