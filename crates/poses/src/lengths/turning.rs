//! The angle by which a rotary axis misses a step, another one at each visit.
//!
//! Its worm or its clamping turns all targets of a visit together, and by more than the repeatability of a coordinate allows: visits
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
use trueaxis_multilateration::{Network, Noise, Turning, Whitened};
use trueaxis_screening::{Error, Screened, screen_within};

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

/// Visits of an axis below which nothing is said.
const LEAST_VISITS: usize = 16;

/// Part of a turn below which the lengths do not show it.
const VISIBLE: f64 = 1e-6;

/// Steps towards θ; searches for gross errors with it, after each of which some come back.
const STEPS: usize = 10;
const SEARCHES: usize = 4;

/// How rotary axes return.
pub(crate) struct Returns<'a> {
    pub(crate) campaign: &'a Campaign,
    pub(crate) lengths: &'a Lengths,
    pub(crate) network: &'a Network,
    /// For each group the rotary axis that its run moves, with the unit vector along it.
    lines: Vec<Option<(usize, Turning)>>,
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
        let of_group = |group: &Group| {
            let step = &campaign.steps[group.step];
            let axis = campaign.runs[step.run?].axis;
            let moving = &machine.axes()[axis];
            if !group.moved || moving.kind() != AxisKind::Rotary {
                return None;
            }
            let before = machine.chain(axis).iter().rev().nth(1).copied();
            let base = machine.motion(&Ideal, before, &step.positions);
            let turning = Turning {
                point_mm: base * moving.point_mm(),
                rad_per_mm: base * moving.direction().into_inner(),
            };
            Some((axis, turning))
        };
        Self {
            campaign,
            lengths,
            network,
            lines: groups.iter().map(of_group).collect(),
        }
    }

    /// For each axis of the machine the ratio of the standard deviations of angle and coordinate (rad/mm), and the
    /// adjustment with it; none if no axis turns, or if more is wrong then than in `together`.
    pub(crate) fn found(
        &self,
        settings: &Settings,
        together: Result<&Screened, &Error>,
    ) -> Option<(Vec<f64>, Screened)> {
        if self.lines.iter().all(Option::is_none) || settings.asks_why || !settings.robust {
            return None;
        }
        let declared = self.campaign.instrument.declares_noise();
        let (mut found, limit) = match together {
            Ok(screened) => (Cow::Borrowed(screened), wrong(screened)),
            Err(error) if error.is_contradiction() => {
                let plain = Screened::plain(self.network, declared).ok()?;
                (Cow::Owned(plain), usize::MAX)
            }
            Err(_) => return None,
        };
        let mut ratios = vec![0.0; self.campaign.machine.axes().len()];
        let is_plain = self.improve(&found, &mut ratios, PLAIN);
        let is_likely = is_plain || limit > 0 && self.improve(&found, &mut ratios, LIKELY);
        if !is_likely {
            if limit == 0 || !declared {
                return None;
            }
            let noise = together.map_or(self.network.noise, |screened| screened.network.noise);
            self.excuse(&found, noise, &mut ratios);
            let network = Network {
                noise,
                ..self.with(&ratios)
            };
            found = Cow::Owned(screen_within(&network, true, settings.most_removed).ok()?);
        }
        for _ in 0..SEARCHES {
            let again = |ratios: &[f64], found: &Screened| {
                Screened::as_found(&self.with(ratios), declared, found).ok()
            };
            let mut adjusted = again(&ratios, &found)?;
            for _ in 0..STEPS {
                if !self.improve(&adjusted, &mut ratios, PLAIN) {
                    break;
                }
                adjusted = again(&ratios, &found)?;
            }
            let as_shown = Network {
                noise: adjusted.network.noise,
                ..self.with(&ratios)
            };
            let next = screen_within(&as_shown, true, settings.most_removed).ok()?;
            let is_same = wrong(&next) == wrong(&found);
            found = Cow::Owned(again(&ratios, &next)?);
            if is_same {
                break;
            }
        }
        if !is_likely {
            let mut none = vec![0.0; ratios.len()];
            let shown = Screened::as_found(self.network, declared, &found).ok()?;
            if !self.improve(&shown, &mut none, PLAIN) {
                return None;
            }
        }
        let turns = ratios.iter().any(|ratio| *ratio > 0.0);
        let explains = wrong(&found) < limit || is_plain && wrong(&found) == limit;
        (turns && explains).then(|| (ratios, found.into_owned()))
    }

    /// Ratios at which a turn excuses [`EXCUSED`] times the noise of a length.
    fn excuse(&self, adjusted: &Screened, noise: Noise, ratios: &mut [f64]) {
        let mut levers_mm = vec![Vec::new(); ratios.len()];
        let (network, solution) = (&adjusted.network, &adjusted.solution);
        for visit in &network.visits {
            let Some((axis, line)) = &self.lines[visit.group] else {
                continue;
            };
            let station_mm = solution.stations[visit.station].position_mm;
            for reading in &network.readings[visit.readings.clone()] {
                let point_mm = solution.points_mm[network.point(visit.group, reading.point)];
                levers_mm[*axis].push(lever_mm(line, station_mm, point_mm).abs());
            }
        }
        let sigma_mm = noise.length_sigma_mm.hypot(noise.repeatability_mm);
        for (levers_mm, ratio) in levers_mm.iter_mut().zip(ratios) {
            let large = median(levers_mm).map(|lever_mm| EXCUSED * sigma_mm / lever_mm);
            let own = large.map(|angle| angle / noise.repeatability_mm);
            *ratio = own.filter(|ratio| ratio.is_finite()).unwrap_or(0.0);
        }
    }

    /// The network whose axes return so.
    pub(crate) fn with(&self, ratios: &[f64]) -> Network {
        let of_group = |line: &Option<(usize, Turning)>| {
            let (axis, line) = (*line)?;
            let ratio = *ratios.get(axis)?;
            (ratio > 0.0).then(|| Turning {
                rad_per_mm: line.rad_per_mm * ratio,
                ..line
            })
        };
        let turning: Vec<Option<Turning>> = self.lines.iter().map(of_group).collect();
        Network {
            turning: turning
                .iter()
                .any(Option::is_some)
                .then(|| Arc::new(turning)),
            ..self.network.clone()
        }
    }

    /// Steps towards the ratios that the residuals show; false if none of them differs. `limit` is that of axes that did not turn.
    fn improve(&self, adjusted: &Screened, ratios: &mut [f64], limit: f64) -> bool {
        let sigma_mm = adjusted.network.noise.repeatability_mm;
        let mut improved = false;
        for (turns, ratio) in self.turns(adjusted).iter().zip(ratios) {
            let part = median(&mut turns.iter().map(|turn| turn.e).collect::<Vec<f64>>());
            let (Some(excess), Some(part)) = (excess(turns), part.filter(|_| sigma_mm > 0.0))
            else {
                continue;
            };
            let chance = OF_MEDIAN / (turns.len() as f64).sqrt();
            let differs = match *ratio > 0.0 {
                true => excess.abs() > SETTLED * chance,
                false => excess > limit * chance,
            };
            if differs {
                let variance = (*ratio * sigma_mm).powi(2) + excess / part;
                *ratio = variance.max(0.0).sqrt() / sigma_mm;
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
                lever_mm(&line, station_mm, point_mm)
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

/// By how much a length changes for a turn about an axis, mm/rad.
pub(crate) fn lever_mm(line: &Turning, station_mm: Point3<f64>, point_mm: Point3<f64>) -> f64 {
    let moved: Vector3<f64> = line.rad_per_mm.cross(&(point_mm - line.point_mm));
    (point_mm - station_mm).normalize().dot(&moved)
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
