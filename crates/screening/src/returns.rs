//! How each axis returns to its steps: all alike, some worse than others, or at a different angle at each visit.

mod growing;
mod turning;
mod turns;
mod uneven;

use std::borrow::Cow;
use std::sync::Arc;

use nalgebra::{Point3, Vector3};
use trueaxis_multilateration::{Network, Noise, Return};

use crate::uneven::uneven_axes;
use crate::{Error, Screened, screen_within};

/// Standard deviations from one at which a ratio of variances is not put down to chance (one in 30,000).
const PLAIN: f64 = 4.0;

/// Most steps towards the ratios.
const STEPS: usize = 40;

/// Most searches for gross errors with new ratios: after each, some of the lengths that were removed come back.
const SEARCHES: usize = 4;

/// How an axis returns to its steps, in units of the repeatability of the network.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisReturn {
    /// Variance of a coordinate.
    pub variance: f64,
    /// Standard deviation of the angle of a rotary axis, rad/mm.
    pub angle: f64,
}

impl AxisReturn {
    const USUAL: Self = Self {
        variance: 1.0,
        angle: 0.0,
    };
}

/// How axes return, and the adjustment with it.
pub type Returned = (Vec<AxisReturn>, Screened);

/// The visits of a sweep.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Sweep {
    /// The axis that moves.
    pub axis: usize,
    /// The numbers of the visits.
    pub visits: Vec<usize>,
}

/// A network whose groups are steps of axes.
#[derive(Debug, Clone)]
pub struct Axes<'a> {
    /// The network.
    pub network: &'a Network,
    /// Whether its noise is more than a guess.
    pub declared: bool,
    /// Share of the readings that may be removed.
    pub most_removed: f64,
    /// Number of axes.
    pub count: usize,
    /// For each group the axis that moves it.
    pub of_groups: Vec<Option<usize>>,
    /// If it is a rotary one, the unit vector along it.
    pub lines: Vec<Option<Return>>,
    /// The sweeps, in measuring order.
    pub sweeps: Vec<Sweep>,
}

impl Axes<'_> {
    /// How each axis returns; none if all do so alike and none turns, or if more is wrong then than in `together`, the
    /// result of [`screen_within`].
    pub fn returned(&self, together: Result<&Screened, &Error>) -> Option<Returned> {
        let turned = self.turned(together);
        let uneven = match &turned {
            Some((ratios, screened)) => self.uneven(ratios.clone(), Ok(screened)),
            None => self.uneven(self.usual(), together),
        };
        uneven.or(turned)
    }

    /// Whether in an adjustment no axis plainly returns worse than the others, or turned.
    pub fn return_as_usual(&self, adjusted: &Screened) -> bool {
        let (network, solution) = (&adjusted.network, &adjusted.solution);
        uneven_axes(network, solution, (self.count, &self.sweeps), false).is_none()
            && !self.improve(adjusted, &mut self.usual(), PLAIN)
    }

    fn usual(&self) -> Vec<AxisReturn> {
        vec![AxisReturn::USUAL; self.count]
    }

    /// Where to start from, and how much is wrong there.
    fn start<'s>(
        &self,
        together: Result<&'s Screened, &Error>,
    ) -> Option<(Cow<'s, Screened>, usize)> {
        match together {
            Ok(screened) if !screened.solution.termination.is_converged() => None,
            Ok(screened) if screened.solution.is_of_computed_lengths() => None,
            Ok(screened) => Some((Cow::Borrowed(screened), screened.changes())),
            Err(error) if error.is_contradiction() => {
                let plain = Screened::plain(self.network, self.declared).ok()?;
                Some((Cow::Owned(plain), usize::MAX))
            }
            Err(_) => None,
        }
    }

    /// The adjustment of the lengths that `found` kept, where axes return so.
    fn again(&self, ratios: &[AxisReturn], found: &Screened) -> Option<Screened> {
        Screened::as_found(&self.with(ratios), self.declared, found).ok()
    }

    /// The search for gross errors with the noise of an adjustment.
    fn search(&self, ratios: &[AxisReturn], noise: Noise) -> Option<Screened> {
        let network = Network {
            noise,
            ..self.with(ratios)
        };
        screen_within(&network, true, self.most_removed).ok()
    }

    /// Seeks gross errors again in the noise of what `adjusted` makes of those found, until as many are left.
    fn iterate(
        &self,
        found: &mut Cow<'_, Screened>,
        ratios: &mut [AxisReturn],
        mut adjusted: impl FnMut(&Screened, &mut [AxisReturn]) -> Option<Screened>,
    ) -> Option<()> {
        for _ in 0..SEARCHES {
            let noise = adjusted(found, ratios)?.network.noise;
            let next = self.search(ratios, noise)?;
            let is_same = next.changes() == found.changes();
            *found = Cow::Owned(self.again(ratios, &next)?);
            if is_same {
                break;
            }
        }
        Some(())
    }

    /// The network whose axes return so.
    pub fn with(&self, ratios: &[AxisReturn]) -> Network {
        let of_group = |(axis, line): (&Option<usize>, &Option<Return>)| {
            let own = axis.and_then(|axis| ratios.get(axis));
            let own = own.unwrap_or(&AxisReturn::USUAL);
            Return {
                variance_ratio: own.variance,
                point_mm: line.map_or(Point3::origin(), |line| line.point_mm),
                rad_per_mm: line.map_or(Vector3::zeros(), |line| line.rad_per_mm * own.angle),
            }
        };
        let all = || self.of_groups.iter().zip(&self.lines).map(of_group);
        let is_special = ratios
            .iter()
            .any(|own| own.angle > 0.0 || own.variance.total_cmp(&1.0).is_ne());
        Network {
            returns: is_special.then(|| Arc::new(all().collect())),
            ..self.network.clone()
        }
    }
}
