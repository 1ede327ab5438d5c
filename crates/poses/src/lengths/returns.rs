//! How each axis returns to its steps: all alike, or some worse than others, or turned by another angle at each visit.
//!
//! Where the visits of an axis plainly scatter more ([`uneven_axes`]), each has a repeatability of its own, found where they all scatter
//! alike.
//!
//! The worm or the clamping of a rotary axis turns all targets of a visit together, and by more than the repeatability of a coordinate allows: visits
//! would leave as gross errors, and U would lack the angle of those that stay. With the whitened column x of a turn about the
//! axis at a visit, the whitened residuals v and what the adjustment leaves of x,
//!
//! ```text
//! q = xᵀv    e = xᵀMx    var(q) = e + (θ² - θ₀²) e²    (q - δe)²/e ~ χ²(1) if θ = θ₀
//! ```
//!
//! with the standard deviation θ of the angle, θ₀ in the noise of the network, and the median turn δ of the side of approach, which
//! is lost motion. θ is found where the median over the visits, which gross errors hardly change, is that of χ²(1).

use std::borrow::Cow;
use std::sync::Arc;

use nalgebra::{Point3, Vector3};
use trueaxis_campaign::{Campaign, Direction, Lengths};
use trueaxis_kinematics::{AxisKind, Ideal};
use trueaxis_leastsquares::{dot, median};
use trueaxis_multilateration::{Network, Noise, Return, Whitened};
use trueaxis_screening::{Error, Screened, screen_within, uneven_axes};

use crate::lengths::network::Group;
use crate::settings::Settings;
use crate::words::stop_of;

/// Median of χ² with one degree of freedom.
const MEDIAN: f64 = 0.454_936;

/// Standard deviation of the median of as many values as there are visits, relative to it, times their root.
const OF_MEDIAN: f64 = 2.33;

/// Standard deviations from one at which a ratio of variances is no chance (one in 30,000); at which it is none where less is wrong
/// with it, since the stops that show it may have left; and at which it is settled.
const PLAIN: f64 = 4.0;
const LIKELY: f64 = 2.0;
const SETTLED: f64 = 0.2;

/// Part of what a turn does to a length in its noise that takes no stop away at first, where those that show it may all have left.
const EXCUSED: f64 = 10.0;

/// Part of the squares in the declared noise that angles must leave where that noise alone is rejected as clearly.
const EXPLAINED: f64 = 0.25;

/// Visits of an axis below which nothing is said.
const LEAST_VISITS: usize = 16;

/// Part of a turn below which the lengths do not show it.
const VISIBLE: f64 = 1e-6;

/// A repeatability is settled if its variance is right to this.
const RIGHT: f64 = 0.02;

/// Steps towards θ; searches for gross errors with it, after each of which some come back.
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

/// A turn about its axis at a visit.
struct Turn {
    side: Direction,
    /// `xᵀv` and `xᵀMx`.
    q: f64,
    e: f64,
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

    /// The same where one axis plainly returns worse than the others.
    fn uneven(
        &self,
        settings: &Settings,
        mut ratios: Vec<AxisReturn>,
        together: Result<&Screened, &Error>,
    ) -> Option<Found> {
        let (mut found, limit) = self.start(together)?;
        let mut is_known = false;
        self.settle(settings, &mut found, &mut ratios, |found, ratios| {
            let mut adjusted = match is_known {
                true => self.again(ratios, found)?,
                false => found.clone(),
            };
            for _ in 0..STEPS {
                let (network, solution) = (&adjusted.network, &adjusted.solution);
                let axes = (ratios.len(), self.axes.as_slice());
                let scatters = uneven_axes(network, solution, axes, is_known)?;
                is_known = true;
                let settled = scatters.iter().all(|ratio| (ratio - 1.0).abs() < RIGHT);
                // The repeatability of the network is their root mean square.
                let of_axis = |axis: usize| ratios[axis].variance * scatters[axis];
                let measured = (0..ratios.len()).filter(|axis| self.axes.contains(&Some(*axis)));
                let measured: Vec<f64> = measured.map(of_axis).collect();
                let mean = measured.iter().sum::<f64>() / measured.len() as f64;
                for (own, ratio) in ratios.iter_mut().zip(&scatters) {
                    own.variance *= ratio / mean;
                }
                adjusted = self.again(ratios, found)?;
                if self.improve(&adjusted, ratios, PLAIN) {
                    adjusted = self.again(ratios, found)?;
                } else if settled {
                    break;
                }
            }
            Some(adjusted)
        })?;
        (wrong(&found) <= limit).then(|| (ratios, found.into_owned()))
    }

    /// The same where only rotary axes return badly, by an angle.
    fn turned(&self, settings: &Settings, together: Result<&Screened, &Error>) -> Option<Found> {
        if self.lines.iter().all(Option::is_none) {
            return None;
        }
        let declared = self.campaign.instrument.declares_noise();
        let (mut found, limit) = self.start(together)?;
        let mut ratios = self.usual();
        let is_plain = self.improve(&found, &mut ratios, PLAIN);
        // Of a lone table all noise that the residuals show is that of its angle, beside which this is no excess.
        let squares = found.given_squares;
        let is_noisy = declared && EXPLAINED * squares > found.solution.degrees_of_freedom() as f64;
        let is_doubted = limit > 0 || is_noisy;
        let is_likely = is_plain || is_doubted && self.improve(&found, &mut ratios, LIKELY);
        if !is_likely {
            if !is_doubted || !declared {
                return None;
            }
            let shown = together.ok().filter(|_| !is_noisy);
            let noise = shown.map_or(self.network.noise, |screened| screened.network.noise);
            self.excuse(&found, noise, &mut ratios);
            found = Cow::Owned(self.search(settings, &ratios, noise)?);
        }
        self.settle(settings, &mut found, &mut ratios, |found, ratios| {
            let mut adjusted = self.again(ratios, found)?;
            for _ in 0..STEPS {
                if !self.improve(&adjusted, ratios, PLAIN) {
                    break;
                }
                adjusted = self.again(ratios, found)?;
            }
            Some(adjusted)
        })?;
        let is_explained = is_noisy && found.given_squares < EXPLAINED * squares;
        if !is_likely && !is_explained {
            let mut none = self.usual();
            let shown = Screened::as_found(self.network, declared, &found).ok()?;
            if !self.improve(&shown, &mut none, PLAIN) {
                return None;
            }
        }
        let turns = ratios.iter().any(|own| own.angle > 0.0);
        let as_much = is_plain || is_explained;
        let explains = wrong(&found) < limit || as_much && wrong(&found) == limit;
        (turns && explains).then(|| (ratios, found.into_owned()))
    }

    /// Ratios at which a turn excuses [`EXCUSED`] times the noise of a length.
    fn excuse(&self, adjusted: &Screened, noise: Noise, ratios: &mut [AxisReturn]) {
        let mut levers_mm = vec![Vec::new(); ratios.len()];
        let (network, solution) = (&adjusted.network, &adjusted.solution);
        for visit in &network.visits {
            let Some((axis, line)) = &self.lines[visit.group] else {
                continue;
            };
            let station_mm = solution.stations[visit.station].position_mm;
            for reading in &network.readings[visit.readings.clone()] {
                let point_mm = solution.points_mm[network.point(visit.group, reading.point)];
                levers_mm[*axis].push(line.lever_mm(station_mm, point_mm).abs());
            }
        }
        let sigma_mm = noise.length_sigma_mm.hypot(noise.repeatability_mm);
        for (levers_mm, own) in levers_mm.iter_mut().zip(ratios) {
            let large = median(levers_mm).map(|lever_mm| EXCUSED * sigma_mm / lever_mm);
            let ratio = large.map(|angle| angle / noise.repeatability_mm);
            own.angle = ratio.filter(|ratio| ratio.is_finite()).unwrap_or(0.0);
        }
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

    /// Steps towards the ratios that the residuals show; false if none of them differs. `limit` is that of axes that did not turn.
    fn improve(&self, adjusted: &Screened, ratios: &mut [AxisReturn], limit: f64) -> bool {
        let noise = adjusted.network.noise;
        let sigma_mm = noise.repeatability_mm;
        // Turns may leave none beside them: any unit will do until the noise is estimated with a turn.
        let unit_mm = match sigma_mm > 0.0 {
            true => sigma_mm,
            false => noise.length_sigma_mm,
        };
        let mut improved = false;
        for (turns, own) in self.turns(adjusted).iter().zip(ratios) {
            let part = median(&mut turns.iter().map(|turn| turn.e).collect::<Vec<f64>>());
            let (Some(excess), Some(part)) = (excess(turns), part) else {
                continue;
            };
            let chance = OF_MEDIAN / (turns.len() as f64).sqrt();
            let differs = match own.angle > 0.0 {
                true => excess.abs() > SETTLED * chance,
                false => excess > limit * chance,
            };
            if differs {
                let variance = (own.angle * sigma_mm).powi(2) + excess / part;
                own.angle = variance.max(0.0).sqrt() / unit_mm;
                improved = true;
            }
        }
        improved
    }

    /// The turns of each axis at the visits of its runs.
    fn turns(&self, adjusted: &Screened) -> Vec<Vec<Turn>> {
        let (network, solution) = (&adjusted.network, &adjusted.solution);
        let whitened = Whitened::new(network, solution);
        let mut turns: Vec<Vec<Turn>> = Vec::new();
        turns.resize_with(self.campaign.machine.axes().len(), Vec::new);
        for (number, visit) in network.visits.iter().enumerate() {
            let rows = visit.readings.clone();
            let Some((axis, line)) = self.lines[visit.group].filter(|_| !rows.is_empty()) else {
                continue;
            };
            let station_mm = solution.stations[visit.station].position_mm;
            let lever = |i: usize| {
                let point_mm =
                    solution.points_mm[network.point(visit.group, network.readings[i].point)];
                line.lever_mm(station_mm, point_mm)
            };
            let mut x: Vec<f64> = rows.clone().map(lever).collect();
            whitened.whiten_from(number, &mut x);
            let mut own = vec![0.0; whitened.own_width];
            let mut shared = vec![0.0; whitened.shared_width];
            let (mut q, mut whole) = (0.0, 0.0);
            for (row, &x) in rows.clone().zip(&x) {
                q += x * whitened.residuals[row];
                whole += x * x;
                whitened.add_row(row, x, &mut own, &mut shared);
            }
            let through = whitened.reduced_inverse.chunks_exact(shared.len());
            let absorbed: f64 = through
                .zip(&shared)
                .map(|(row, s)| s * dot(row, &shared))
                .sum();
            let e = whole - dot(&own, &own) - absorbed;
            if e > VISIBLE * whole {
                let side = stop_of(self.lengths, adjusted.kept[rows.start]).direction;
                turns[axis].push(Turn { side, q, e });
            }
        }
        turns
    }
}

/// What is wrong.
fn wrong(screened: &Screened) -> usize {
    screened.removed.len() + screened.jumps.len()
}

/// By how much the ratio of the variance of the turns to that of the noise exceeds one.
fn excess(turns: &[Turn]) -> Option<f64> {
    if turns.len() < LEAST_VISITS {
        return None;
    }
    let mean = |side: Direction| {
        let own = turns.iter().filter(|turn| turn.side == side);
        median(&mut own.map(|turn| turn.q / turn.e).collect::<Vec<f64>>()).unwrap_or_default()
    };
    let (forward, backward) = (mean(Direction::Forward), mean(Direction::Backward));
    let mut squares: Vec<f64> = turns
        .iter()
        .map(|turn| {
            let side = match turn.side {
                Direction::Forward => forward,
                Direction::Backward => backward,
            };
            (turn.q - side * turn.e).powi(2) / turn.e
        })
        .collect();
    Some(median(&mut squares)? / MEDIAN - 1.0)
}
