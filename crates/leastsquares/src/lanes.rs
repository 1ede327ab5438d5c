//! Eight numbers side by side: the arithmetic of eight blocks at once.
//!
//! Loops over the rows of one small block are too short for wide registers, and sums along them are
//! chains that a compiler may not regroup. With one block in each lane every operation is eight
//! independent ones. Which products are fused with a sum is written out ([`Lanes::mul_add`]), so
//! results are the same bits with any instruction set; a dispatch around a pass chooses the widest one at
//! run time.

use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// Blocks that are worked on side by side.
pub const LANES: usize = 8;

/// One number of each of [`LANES`] blocks.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[repr(align(64))]
pub struct Lanes(pub [f64; LANES]);

impl Lanes {
    /// Zero in every lane.
    pub const ZERO: Self = Self([0.0; LANES]);

    /// The same number in every lane.
    #[inline(always)]
    pub fn splat(x: f64) -> Self {
        Self([x; LANES])
    }

    /// The number of each lane.
    #[inline(always)]
    pub fn from_fn(mut of_lane: impl FnMut(usize) -> f64) -> Self {
        // Written out: `array::from_fn` may stay a call, outside the registers that a dispatch chose, and
        // thousands of loops of eight rounds in a pass take minutes to compile.
        Self([
            of_lane(0),
            of_lane(1),
            of_lane(2),
            of_lane(3),
            of_lane(4),
            of_lane(5),
            of_lane(6),
            of_lane(7),
        ])
    }

    /// One in the first `used` lanes, zero in the others.
    #[inline(always)]
    pub fn mask(used: usize) -> Self {
        Self::from_fn(|lane| f64::from(u8::from(lane < used)))
    }

    /// `self · factor + sum`, rounded once. Without an instruction for it (x86-64 outside
    /// [`crate::in_widest_registers`], or before 2013) it is slow.
    #[inline(always)]
    pub fn mul_add(self, factor: Self, sum: Self) -> Self {
        Self::from_fn(|i| self.0[i].mul_add(factor.0[i], sum.0[i]))
    }

    /// Square roots.
    #[inline(always)]
    pub fn sqrt(self) -> Self {
        Self::from_fn(|i| self.0[i].sqrt())
    }

    /// Sum over the lanes, always in the same order.
    #[inline(always)]
    pub fn sum(self) -> f64 {
        let [a, b, c, d, e, f, g, h] = self.0;
        ((a + e) + (c + g)) + ((b + f) + (d + h))
    }
}

macro_rules! lane_by_lane {
    ($trait:ident, $method:ident, $operator:tt) => {
        impl $trait for Lanes {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self::from_fn(|i| self.0[i] $operator other.0[i])
            }
        }
    };
}

lane_by_lane!(Add, add, +);
lane_by_lane!(Sub, sub, -);
lane_by_lane!(Mul, mul, *);
lane_by_lane!(Div, div, /);

impl Neg for Lanes {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self::from_fn(|i| -self.0[i])
    }
}

impl AddAssign for Lanes {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl SubAssign for Lanes {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

/// Keeps a loop over rows or columns from being vectorised itself, which would gather one number of each
/// [`Lanes`] instead of taking eight as they lie. It makes no instruction.
#[inline(always)]
pub fn lanes_only() {
    std::hint::black_box(());
}

/// Replaces the contents by `count` zeros.
#[inline(always)]
pub fn zeros<T: Copy + Default>(all: &mut Vec<T>, count: usize) {
    all.clear();
    all.resize(count, T::default());
}

/// Elements that a loop takes at a time: one alone costs less than the loop around it.
const FOUR: usize = 4;

/// `sum += factor x`, element by element.
#[inline(always)]
pub fn add_times(sum: &mut [Lanes], factor: Lanes, x: &[Lanes]) {
    let (sums, sum_rest) = sum.as_chunks_mut::<FOUR>();
    let (fours, rest) = x.as_chunks::<FOUR>();
    for ([a, b, c, d], [p, q, r, s]) in sums.iter_mut().zip(fours) {
        lanes_only();
        *a = factor.mul_add(*p, *a);
        *b = factor.mul_add(*q, *b);
        *c = factor.mul_add(*r, *c);
        *d = factor.mul_add(*s, *d);
    }
    for (sum, x) in sum_rest.iter_mut().zip(rest) {
        lanes_only();
        *sum = factor.mul_add(*x, *sum);
    }
}

/// `sum += Σ factor x` over a few slices, element by element, in their order: what one [`add_times`] after the other
/// gives, to the bit, but each element of the sum is loaded and stored once.
#[inline(always)]
pub(crate) fn add_several_times<const N: usize>(
    sum: &mut [Lanes],
    factors: [Lanes; N],
    x: [&[Lanes]; N],
) {
    let x = x.map(|x| x[..sum.len()].as_chunks::<FOUR>());
    let (fours, rest) = sum.as_chunks_mut::<FOUR>();
    for (i, four) in fours.iter_mut().enumerate() {
        lanes_only();
        let [mut a, mut b, mut c, mut d] = *four;
        for k in 0..N {
            let [p, q, r, s] = &x[k].0[i];
            a = factors[k].mul_add(*p, a);
            b = factors[k].mul_add(*q, b);
            c = factors[k].mul_add(*r, c);
            d = factors[k].mul_add(*s, d);
        }
        *four = [a, b, c, d];
    }
    for (i, sum) in rest.iter_mut().enumerate() {
        lanes_only();
        let mut result = *sum;
        for k in 0..N {
            result = factors[k].mul_add(x[k].1[i], result);
        }
        *sum = result;
    }
}

/// `x <- factor x`, element by element.
#[inline(always)]
pub(crate) fn multiply(x: &mut [Lanes], factor: Lanes) {
    let (fours, rest) = x.as_chunks_mut::<FOUR>();
    for [a, b, c, d] in fours {
        lanes_only();
        *a = *a * factor;
        *b = *b * factor;
        *c = *c * factor;
        *d = *d * factor;
    }
    for x in rest {
        lanes_only();
        *x = *x * factor;
    }
}
