//! Constants of the reflectors: all lengths to a reflector are too long by its constant.
//!
//! ```text
//! l = |p - S| - L + k_r
//! ```
//!
//! The part common to all constants is absorbed by the dead paths. The unknowns are therefore `K - 1` contrasts `a`
//! of the `K` constants, with orthonormal columns of sum zero (Helmert's):
//!
//! ```text
//! k = H a     1ᵀH = 0     HᵀH = I
//! ```
//!
//! so that constants are relative to their mean, and no reflector is preferred. If the constants are independent with
//! a standard deviation `σ`, so are the contrasts.

use crate::Error;

/// Which reflector is at each point of a network.
#[derive(Debug, Clone, PartialEq)]
pub struct Reflectors {
    /// Number of reflectors.
    pub count: usize,
    /// Standard deviation of the constants of a set, where known, mm: each contrast is then observed as zero with
    /// this σ.
    pub sigma_mm: Option<f64>,
    /// The reflector at each point, in the order of the network.
    pub of_points: Vec<usize>,
}

impl Reflectors {
    /// Number of unknowns.
    pub fn contrasts(&self) -> usize {
        self.count.saturating_sub(1)
    }

    /// Checks that each point has a reflector that exists.
    pub(crate) fn check(&self, points: usize) -> Result<(), Error> {
        let is_usable = |sigma: f64| sigma.is_finite() && sigma > 0.0;
        if !self.sigma_mm.is_none_or(is_usable) {
            let what = "the standard deviation of reflectors is not positive and finite";
            return Err(Error::malformed(what));
        }
        let found = self.of_points.len();
        let largest = self.of_points.iter().max();
        if found != points || largest.is_some_and(|&r| r >= self.count) {
            let count = self.count;
            let what = format!("reflectors are named for {found} of {points} points, of {count}");
            return Err(Error::malformed(what));
        }
        Ok(())
    }
}

/// `H`: effect of a unit of contrast `m` on the constant of a reflector.
pub fn contrast(reflector: usize, m: usize) -> f64 {
    let before = (m + 1) as f64;
    let length = (before * (before + 1.0)).sqrt();
    match reflector {
        r if r <= m => 1.0 / length,
        r if r == m + 1 => -before / length,
        _ => 0.0,
    }
}

pub(crate) fn constants_mm(contrasts_mm: &[f64]) -> Vec<f64> {
    let constant = |r: usize| {
        let all = contrasts_mm.iter().enumerate();
        all.map(|(m, a)| contrast(r, m) * a).sum()
    };
    match contrasts_mm.len() {
        0 => Vec::new(),
        n => (0..=n).map(constant).collect(),
    }
}
