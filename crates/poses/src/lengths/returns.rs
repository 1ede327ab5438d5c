//! How each axis returns to its steps: all alike, or some worse than others, or turned by another angle at each visit.

mod turning;
mod uneven;

use std::borrow::Cow;
use std::sync::Arc;

use nalgebra::{Point3, Vector3};
use trueaxis_campaign::{Campaign, Lengths};
use trueaxis_kinematics::{AxisKind, Ideal};
use trueaxis_multilateration::{Network, Noise, Return};
use trueaxis_screening::{Error, Screened, screen_within};

use crate::lengths::network::Group;
use crate::settings::Settings;

/// Standard deviations from one at which a ratio of variances is no chance (one in 30,000).
const PLAIN: f64 = 4.0;

/// Steps towards the ratios; searches for gross errors with them, after each of which some come back.
const STEPS: usize = 40;
const SEARCHES: usize = 4;

/// How an axis returns to its steps, in units of the repeatability of the network.
#[derive(Debug, Clone, Copy)]
pub(crate) struct AxisReturn {
    /// Variance of a coordinate.
    pub(crate) variance: f64,
    /// Standard deviation of the angle of a rotary axis, rad/mm.
    pub(crate) angle: f64,
}

impl AxisReturn {
    const USUAL: Self = Self {
        variance: 1.0,
        angle: 0.0,
    };
}

/// How the axes of a campaign return, and the adjustment with it.
pub(crate) type Found = (Vec<AxisReturn>, Screened);

/// How axes return.
pub(crate) struct Returns<'a> {
    pub(crate) campaign: &'a Campaign,
    pub(crate) lengths: &'a Lengths,
    pub(crate) network: &'a Network,
    /// For each group the axis that its run moves.
    axes: Vec<Option<usize>>,
    /// If it is a rotary one, it too, with the unit vector along it.
    lines: Vec<Option<(usize, Return)>>,
}

impl<'a> Returns<'a> {
    /// Of the axes that the runs of some groups of the network move.
    pub(crate) fn new(
        campaign: &'a Campaign,
        lengths: &'a Lengths,
        (network, groups): (&'a Network, &[Group]),
    ) -> Self {
        let machine = &campaign.machine;
        let axis = |group: &Group| {
            let run = campaign.steps[group.step].run?;
            group.moved.then(|| campaign.runs[run].axis)
        };
        let line = |group: &Group| {
            let (step, axis) = (&campaign.steps[group.step], axis(group)?);
            let moving = &machine.axes()[axis];
            if moving.kind() != AxisKind::Rotary {
                return None;
            }
            let before = machine.chain(axis).iter().rev().nth(1).copied();
            let base = machine.motion(&Ideal, before, &step.positions);
            let turning = Return {
                variance_ratio: 1.0,
                point_mm: base * moving.point_mm(),
                rad_per_mm: base * moving.direction().into_inner(),
            };
            Some((axis, turning))
        };
        Self {
            campaign,
            lengths,
            network,
            axes: groups.iter().map(axis).collect(),
            lines: groups.iter().map(line).collect(),
        }
    }

    /// How each axis of the machine returns; none if all do so alike and none turns, or if more is wrong then than in
    /// `together`.
    pub(crate) fn found(
        &self,
        settings: &Settings,
        together: Result<&Screened, &Error>,
    ) -> Option<Found> {
        if settings.asks_why || !settings.robust {
            return None;
        }
        let turned = self.turned(settings, together);
        let uneven = match &turned {
            Some((ratios, screened)) => self.uneven(settings, ratios.clone(), Ok(screened)),
            None => self.uneven(settings, self.usual(), together),
        };
        uneven.or(turned)
    }

    fn usual(&self) -> Vec<AxisReturn> {
        vec![AxisReturn::USUAL; self.campaign.machine.axes().len()]
    }

    /// Where to start from, and how much is wrong there.
    fn start<'s>(
        &self,
        together: Result<&'s Screened, &Error>,
    ) -> Option<(Cow<'s, Screened>, usize)> {
        match together {
            Ok(screened) => Some((Cow::Borrowed(screened), wrong(screened))),
            Err(error) if error.is_contradiction() => {
                let declared = self.campaign.instrument.declares_noise();
                let plain = Screened::plain(self.network, declared).ok()?;
                Some((Cow::Owned(plain), usize::MAX))
            }
            Err(_) => None,
        }
    }

    /// The lengths that `found` kept, where axes return so.
    fn again(&self, ratios: &[AxisReturn], found: &Screened) -> Option<Screened> {
        let declared = self.campaign.instrument.declares_noise();
        Screened::as_found(&self.with(ratios), declared, found).ok()
    }

    /// The search for gross errors with the noise of an adjustment.
    fn search(&self, settings: &Settings, ratios: &[AxisReturn], noise: Noise) -> Option<Screened> {
        let network = Network {
            noise,
            ..self.with(ratios)
        };
        screen_within(&network, true, settings.most_removed).ok()
    }

    /// Seeks gross errors again in the noise of what `adjusted` makes of those found, until as many are left.
    fn settle(
        &self,
        settings: &Settings,
        found: &mut Cow<'_, Screened>,
        ratios: &mut [AxisReturn],
        mut adjusted: impl FnMut(&Screened, &mut [AxisReturn]) -> Option<Screened>,
    ) -> Option<()> {
        for _ in 0..SEARCHES {
            let noise = adjusted(found, ratios)?.network.noise;
            let next = self.search(settings, ratios, noise)?;
            let is_same = wrong(&next) == wrong(found);
            *found = Cow::Owned(self.again(ratios, &next)?);
            if is_same {
                break;
            }
        }
        Some(())
    }

    /// The network whose axes return so.
    pub(crate) fn with(&self, ratios: &[AxisReturn]) -> Network {
        let of_group = |(axis, line): (&Option<usize>, &Option<(usize, Return)>)| {
            let own = axis.and_then(|axis| ratios.get(axis));
            let own = own.unwrap_or(&AxisReturn::USUAL);
            let line = line.map(|(_, line)| line);
            Return {
                variance_ratio: own.variance,
                point_mm: line.map_or(Point3::origin(), |line| line.point_mm),
                rad_per_mm: line.map_or(Vector3::zeros(), |line| line.rad_per_mm * own.angle),
            }
        };
        let all = || self.axes.iter().zip(&self.lines).map(of_group);
        let is_special = ratios
            .iter()
            .any(|own| own.angle > 0.0 || own.variance.total_cmp(&1.0).is_ne());
        Network {
            returns: is_special.then(|| Arc::new(all().collect())),
            ..self.network.clone()
        }
    }
}

/// What is wrong.
fn wrong(screened: &Screened) -> usize {
    screened.removed.len() + screened.jumps.len()
}
