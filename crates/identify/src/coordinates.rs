//! Arithmetic of vectors whose coordinates are numbers, or eight numbers side by side: one formula
//! serves one step and eight of them.

use std::ops::{Add, Div, Mul, Sub};

use trueaxis_leastsquares::Lanes;

/// A number, or one for each lane.
pub(crate) trait Number:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// The same number in every lane.
    fn of(x: f64) -> Self;

    /// The larger one, lane by lane.
    fn larger(self, other: Self) -> Self;
}

impl Number for f64 {
    #[inline(always)]
    fn of(x: f64) -> Self {
        x
    }

    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        if other > self { other } else { self }
    }
}

impl Number for Lanes {
    #[inline(always)]
    fn of(x: f64) -> Self {
        Self::splat(x)
    }

    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        Self::from_fn(|k| self.0[k].larger(other.0[k]))
    }
}

/// x y z.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Coordinates<T>(pub(crate) [T; 3]);

impl<T: Number> Coordinates<T> {
    #[inline(always)]
    pub(crate) fn dot(&self, other: &Self) -> T {
        let ([x, y, z], [u, v, w]) = (self.0, other.0);
        x * u + y * v + z * w
    }

    #[inline(always)]
    pub(crate) fn cross(&self, other: &Self) -> Self {
        let ([x, y, z], [u, v, w]) = (self.0, other.0);
        Self([y * w - z * v, z * u - x * w, x * v - y * u])
    }
}

impl<T: Number> Add for Coordinates<T> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        let ([x, y, z], [u, v, w]) = (self.0, other.0);
        Self([x + u, y + v, z + w])
    }
}

impl<T: Number> Sub for Coordinates<T> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        let ([x, y, z], [u, v, w]) = (self.0, other.0);
        Self([x - u, y - v, z - w])
    }
}

impl<T: Number> Mul<T> for Coordinates<T> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: T) -> Self {
        let [x, y, z] = self.0;
        Self([x * factor, y * factor, z * factor])
    }
}
