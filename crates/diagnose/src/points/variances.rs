//! The variances of the points and of the machine's repeatability, by restricted maximum likelihood.
//!
//! With `V_k` the whitened part of each, by the fixed point of its equations (W. Förstner, *Zeitschrift für
//! Vermessungswesen* 104, 446, 1979):
//!
//! ```text
//! θ_k <- θ_k eᵀV_k e / tr(M V_k)
//! ```
//!
//! The ratio of directions is that of the rows ([`crate::points::noise`]) unless Bartlett's test says otherwise (*Proceedings of the Royal Society* A 160,
//! 268, 1937): fewer variances are known better.

use trueaxis_leastsquares::{chi_squared_upper_tail, dot};

use crate::engine::rms;
use crate::numbers::squares;
use crate::points::base::Base;
use crate::points::model::{Model, left_of};
use crate::points::noise::Noise;

/// Variances rest when they change by less than this part.
const RESTS: f64 = 1e-3;
const MOST_PASSES: usize = 60;

/// From a change by this part on directions are compared.
const NEARLY: f64 = 0.1;

/// Redundancy of a variance below which the data say nothing of it.
const LEAST_REDUNDANCY: f64 = 2.0;

/// Below this part of the variance of a point the machine's repeatability is taken for none.
const NONE: f64 = 1e-4;

/// No direction is better than another by more than the rows say: effects are known along them to some thousandths only.
const MOST_UNLIKE: f64 = 20.0;

/// No instrument is better, mm: coordinates that were made up may have no noise at all.
const LEAST_MM: f64 = 1e-7;

/// Level of the test whether directions differ by another ratio than that of the rows; its degrees of freedom: two
/// ratios, and three for the rows, which follow from the same readings.
const DIFFER: f64 = 1e-3;
const FREE: f64 = 5.0;

/// Redundancy of each direction from which directions get variances of their own.
const TOLD_APART: f64 = 20.0;

/// Squares and redundancy of one part of the noise along each direction.
#[derive(Debug, Clone, Copy, Default)]
struct Part([(f64, f64); 3]);

impl Part {
    /// By what its variances change, alike or apart; none where the data do not say.
    fn factors(&self, apart: bool) -> [Option<f64>; 3] {
        let factor = |squares: f64, redundancy: f64| {
            let is_told = redundancy > LEAST_REDUNDANCY && squares > 0.0;
            is_told.then(|| squares / redundancy)
        };
        match apart {
            true => self
                .0
                .map(|(squares, redundancy)| factor(squares, redundancy)),
            false => {
                let sum = |of: fn(&(f64, f64)) -> f64| self.0.iter().map(of).sum::<f64>();
                [factor(sum(|p| p.0), sum(|p| p.1)); 3]
            }
        }
    }

    /// Whether the directions differ, by Bartlett's test.
    fn differs(&self) -> bool {
        if self.0.iter().any(|&(s, r)| r < TOLD_APART || s <= 0.0) {
            return false;
        }
        let sum = |of: fn(&(f64, f64)) -> f64| self.0.iter().map(of).sum::<f64>();
        let (squares, redundancy) = (sum(|p| p.0), sum(|p| p.1));
        let of_each = self.0.iter().map(|(s, r)| r * (s / r).ln());
        let statistic = redundancy * (squares / redundancy).ln() - of_each.sum::<f64>();
        chi_squared_upper_tail(statistic, FREE) < DIFFER
    }
}

impl Model {
    /// With columns of causes (mm) and the noise that they leave.
    pub(crate) fn estimated(base: &Base<'_>, causes_mm: &[Vec<f64>]) -> Self {
        let declared_um = base.campaign.instrument.repeatability_um;
        let declared_mm = declared_um.map(|um| um * 1e-3);
        let unit = Noise {
            own_mm: [1e-3; 3],
            return_mm: [declared_mm.unwrap_or(1e-3); 3],
        };
        let first = Self::with(base, causes_mm, unit, None);
        let scale = rms(&first.projection);
        let mut noise = Noise {
            own_mm: unit.own_mm.map(|s| s * scale.max(f64::MIN_POSITIVE)),
            return_mm: unit.return_mm.map(|s| s * scale),
        };
        let mut apart = [false; 2];
        let mut model = Self::with(base, causes_mm, noise, None);
        let mut parts = model.parts(base);
        for _ in 0..MOST_PASSES {
            let factors = [parts[0].factors(apart[0]), parts[1].factors(apart[1])];
            let before = noise;
            for (k, (own, back)) in factors[0].into_iter().zip(factors[1]).enumerate() {
                let own = own.unwrap_or(1.0);
                noise.own_mm[k] = (noise.own_mm[k] * own.sqrt()).max(LEAST_MM);
                match back {
                    Some(factor) => noise.return_mm[k] *= factor.sqrt(),
                    // What was taken for none stays none.
                    None if noise.return_mm[k] > 0.0 => {
                        noise.return_mm[k] = declared_mm.unwrap_or(0.0);
                    }
                    None => {}
                }
            }
            let usual_mm2 = squares(&noise.own_mm) / 3.0;
            for return_mm in &mut noise.return_mm {
                if return_mm.powi(2) < NONE * usual_mm2 {
                    *return_mm = 0.0;
                }
            }
            let largest_mm = noise.own_mm.into_iter().fold(0.0, f64::max);
            noise.own_mm = noise.own_mm.map(|own| own.max(largest_mm / MOST_UNLIKE));
            let change = noise.change_since(&before);
            model = Self::with(base, causes_mm, noise, None);
            parts = model.parts(base);
            if change < NEARLY {
                let differ = [0, 1].map(|k| apart[k] || parts[k].differs());
                if differ == apart && change < RESTS {
                    break;
                }
                apart = differ;
            }
        }
        model
    }

    /// The points and the machine's repeatability.
    fn parts(&self, base: &Base<'_>) -> [Part; 2] {
        let mut parts = [Part::default(); 2];
        let e = &self.projection.residuals;
        for (stop, whitening) in base.readings.stops.iter().zip(self.whitening.iter()) {
            let points = &base.readings.all[stop.clone()];
            let own = (0..3 * points.len()).map(|row| (0, row % 3, whitening.own(row)));
            let returns = (0..3).map(|k| {
                let mut column = self.noise.returns(points, k);
                whitening.apply(&mut column);
                (1, k, column)
            });
            let first = 3 * stop.start;
            for (part, direction, column) in own.chain(returns) {
                let along = dot(&column, &e[first..first + column.len()]);
                let left = left_of(&self.projection, first, &[column])[0];
                let of = &mut parts[part].0[direction];
                *of = (of.0 + along * along, of.1 + left);
            }
        }
        parts
    }
}
