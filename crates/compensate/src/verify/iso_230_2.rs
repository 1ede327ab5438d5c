//! Accuracy and repeatability of positioning by ISO 230-2:2014, 3: from deviations at target positions that were approached
//! several times from both sides.
//!
//! With the mean `x̄_i↑` and the standard deviation `s_i↑` of the passes at position i from below (`↓` from above):
//!
//! ```text
//! B_i = x̄_i↑ - x̄_i↓                          B = max |B_i|     B̄ = mean B_i
//! R_i↑ = 4 s_i↑                               R_i = max(2 s_i↑ + 2 s_i↓ + |B_i|, R_i↑, R_i↓)
//! E↑ = max x̄_i↑ - min x̄_i↑                    E = max(x̄_i↑, x̄_i↓) - min(x̄_i↑, x̄_i↓)
//! M = max x̄_i - min x̄_i                       x̄_i = (x̄_i↑ + x̄_i↓) / 2
//! A↑ = max(x̄_i↑ + 2 s_i↑) - min(x̄_i↑ - 2 s_i↑)  A: the same over both sides
//! ```
//!
//! `B_i` is the opposite of lost motion. The zero of the instrument is in none of them.

use trueaxis_campaign::Direction;

use crate::export::rising;
use crate::verify::SAME;

/// Passes from each side that the standard wants.
const PASSES: usize = 5;

/// The quantities, µm. Those of a side that was not approached are not there.
#[derive(Debug, Clone, PartialEq)]
pub struct Positioning {
    /// Fewest passes at a position from a side.
    pub passes: usize,
    /// Whether there are fewer than the five of the standard.
    pub is_short: bool,
    /// From below, from above, both sides.
    pub sides: [Option<Side>; 3],
    /// Reversal value B: the largest amount.
    pub b_um: Option<f64>,
    /// Its mean, B̄, with its sign.
    pub mean_b_um: Option<f64>,
    /// Range of the mean bidirectional deviation M.
    pub m_um: Option<f64>,
}

/// Quantities of one side or both, µm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Side {
    /// Accuracy A; not with one pass.
    pub a_um: Option<f64>,
    /// Systematic deviation E.
    pub e_um: f64,
    /// Repeatability R; not with one pass.
    pub r_um: Option<f64>,
}

/// Mean and standard deviation of the passes at a position from a side.
#[derive(Debug, Clone, Copy)]
struct Passes {
    count: usize,
    mean: f64,
    s: f64,
}

impl Passes {
    fn of(values: &[f64]) -> Option<Self> {
        let count = values.len();
        let mean = values.iter().sum::<f64>() / count as f64;
        let squares: f64 = values.iter().map(|x| (x - mean).powi(2)).sum();
        (count > 0).then(|| Self {
            count,
            mean,
            s: if count > 1 {
                (squares / (count - 1) as f64).sqrt()
            } else {
                f64::NAN
            },
        })
    }
}

impl Positioning {
    /// From deviations (µm, actual minus commanded) at commanded positions.
    pub fn new(deviations: &[(f64, Direction, f64)]) -> Self {
        let positions = rising(deviations.iter().map(|(position, ..)| *position), SAME);
        let at = |position: &f64, side: Direction| {
            let own = deviations
                .iter()
                .filter(|(q, d, _)| *d == side && (q - position).abs() <= SAME);
            Passes::of(&own.map(|(.., x)| *x).collect::<Vec<_>>())
        };
        let pairs: Vec<[Option<Passes>; 2]> = positions
            .iter()
            .map(|q| [at(q, Direction::Forward), at(q, Direction::Backward)])
            .collect();
        let both: Vec<[Passes; 2]> = pairs
            .iter()
            .filter_map(|[f, b]| Some([(*f)?, (*b)?]))
            .collect();
        let reversal: Vec<f64> = both.iter().map(|[f, b]| f.mean - b.mean).collect();
        let mean: Vec<f64> = both.iter().map(|[f, b]| 0.5 * (f.mean + b.mean)).collect();
        let one_side = |side: usize| {
            let passes: Vec<Passes> = pairs.iter().filter_map(|pair| pair[side]).collect();
            let repeatability = passes.iter().map(|pass| 4.0 * pass.s);
            Side::of(&passes, repeatability.collect())
        };
        let bidirectional = both.iter().map(|[f, b]| {
            let sum = 2.0 * f.s + 2.0 * b.s + (f.mean - b.mean).abs();
            let [f, b] = [4.0 * f.s, 4.0 * b.s];
            // Not a number for a single pass, which `max` would hide.
            if sum.is_finite() {
                sum.max(f).max(b)
            } else {
                f64::NAN
            }
        });
        let all: Vec<Passes> = both.iter().flatten().copied().collect();
        let passes = pairs.iter().flatten().flatten().map(|pass| pass.count);
        let passes = passes.min().unwrap_or(0);
        Self {
            passes,
            is_short: passes < PASSES,
            sides: [
                one_side(0),
                one_side(1),
                Side::of(&all, bidirectional.collect()),
            ],
            b_um: reversal.iter().map(|b| b.abs()).reduce(f64::max),
            mean_b_um: (!reversal.is_empty())
                .then(|| reversal.iter().sum::<f64>() / reversal.len() as f64),
            m_um: range(mean.iter().copied()),
        }
    }
}

impl Side {
    fn of(passes: &[Passes], repeatability: Vec<f64>) -> Option<Self> {
        let known = |x: &f64| x.is_finite();
        let high = passes.iter().map(|pass| pass.mean + 2.0 * pass.s);
        let low = passes.iter().map(|pass| pass.mean - 2.0 * pass.s);
        let all: Vec<f64> = high.chain(low).collect();
        Some(Self {
            a_um: range(all.iter().copied()).filter(|_| all.iter().all(known)),
            e_um: range(passes.iter().map(|pass| pass.mean))?,
            r_um: repeatability
                .iter()
                .copied()
                .reduce(f64::max)
                .filter(|_| repeatability.iter().all(known)),
        })
    }
}

fn range(values: impl Iterator<Item = f64> + Clone) -> Option<f64> {
    Some(values.clone().reduce(f64::max)? - values.reduce(f64::min)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use Direction::Forward;

    #[test]
    fn one_pass_has_no_repeatability_and_one_side_no_reversal() {
        let found = Positioning::new(&[(0.0, Forward, 1.0), (10.0, Forward, 4.0)]);
        let forward = found.sides[0].unwrap();
        assert_eq!((forward.a_um, forward.r_um), (None, None));
        assert!((forward.e_um - 3.0).abs() < 1e-12);
        assert_eq!((found.sides[1], found.sides[2]), (None, None));
        assert_eq!((found.b_um, found.m_um), (None, None));
        assert_eq!((found.passes, found.is_short), (1, true));
    }
}
