//! Low harmonics of a coordinate: what a smooth dependence on it looks like.

use std::f64::consts::PI;

/// `cos(kπx)` for `k` from 1 to `count`, x from 0 to 1: half waves, so that a trend needs few of them.
pub(crate) fn half_waves(x: f64, count: u32) -> impl Iterator<Item = f64> {
    (1..=count).map(move |k| (f64::from(k) * PI * x).cos())
}
