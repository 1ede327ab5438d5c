//! The factors of all eliminated blocks: what a covariance needs of them.

use std::ops::Range;

/// `R⁻¹` (columns contiguous) and `Z = R⁻¹ [C | W]` (rows contiguous) of every block, blocks in order.
#[derive(Debug, Clone, Default)]
pub struct Factors {
    /// Columns of `Z`.
    width: usize,
    /// Where the unknowns of each block start among those of all blocks; behind them their number.
    starts: Vec<usize>,
    inverse_factor_starts: Vec<usize>,
    inverse_factors: Vec<f64>,
    couplings: Vec<f64>,
}

/// The factors of some blocks in a row, to be filled.
#[derive(Debug)]
pub struct FactorsMut<'a> {
    first_block: usize,
    width: usize,
    starts: &'a [usize],
    inverse_factor_starts: &'a [usize],
    inverse_factors: &'a mut [f64],
    couplings: &'a mut [f64],
}

impl Factors {
    /// Zero factors of blocks of the given numbers of unknowns.
    pub fn zeros(width: usize, unknowns: impl Iterator<Item = usize>) -> Self {
        let (mut starts, mut inverse_factor_starts) = (vec![0], vec![0]);
        let (mut own, mut squared) = (0, 0);
        for n in unknowns {
            own += n;
            squared += n * n;
            starts.push(own);
            inverse_factor_starts.push(squared);
        }
        Self {
            width,
            starts,
            inverse_factor_starts,
            inverse_factors: vec![0.0; squared],
            couplings: vec![0.0; own * width],
        }
    }

    /// Columns of `Z`.
    pub(crate) fn width(&self) -> usize {
        self.width
    }

    /// Splits all blocks into ranges that follow each other.
    ///
    /// # Panics
    /// If there are fewer blocks than the ranges name.
    pub fn split_mut(&mut self, ranges: &[Range<usize>]) -> Vec<FactorsMut<'_>> {
        let (mut inverse_factors, mut couplings) =
            (&mut self.inverse_factors[..], &mut self.couplings[..]);
        let mut parts = Vec::with_capacity(ranges.len());
        for range in ranges {
            let starts = &self.starts[range.start..=range.end];
            let inverse_factor_starts = &self.inverse_factor_starts[range.start..=range.end];
            let length = |starts: &[usize]| starts[starts.len() - 1] - starts[0];
            let (own, rest) = inverse_factors.split_at_mut(length(inverse_factor_starts));
            inverse_factors = rest;
            let (coupled, rest) = couplings.split_at_mut(length(starts) * self.width);
            couplings = rest;
            parts.push(FactorsMut {
                first_block: range.start,
                width: self.width,
                starts,
                inverse_factor_starts,
                inverse_factors: own,
                couplings: coupled,
            });
        }
        parts
    }

    /// Number of unknowns of block `i`.
    pub fn unknowns(&self, i: usize) -> usize {
        self.starts[i + 1] - self.starts[i]
    }

    /// `R⁻¹` of block `i`, columns contiguous.
    pub fn inverse_factor(&self, i: usize) -> &[f64] {
        &self.inverse_factors[self.inverse_factor_starts[i]..self.inverse_factor_starts[i + 1]]
    }

    /// `Z` of block `i`, rows contiguous.
    pub fn coupling(&self, i: usize) -> &[f64] {
        &self.couplings[self.starts[i] * self.width..self.starts[i + 1] * self.width]
    }
}

impl FactorsMut<'_> {
    /// `R⁻¹` of block `i`, columns contiguous, and `Z`, rows contiguous.
    #[inline(always)]
    pub fn block_mut(&mut self, i: usize) -> (&mut [f64], &mut [f64]) {
        let i = i - self.first_block;
        let place = |starts: &[usize], factor| {
            (starts[i] - starts[0]) * factor..(starts[i + 1] - starts[0]) * factor
        };
        (
            &mut self.inverse_factors[place(self.inverse_factor_starts, 1)],
            &mut self.couplings[place(self.starts, self.width)],
        )
    }
}
