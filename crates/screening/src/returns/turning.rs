//! Rotary axes that stop at a different angle each time.
//!
//! The worm or the clamping turns all targets of a visit together, by more than the repeatability of a coordinate
//! allows: visits would be removed as gross errors, and U would lack the angle of those that stay. The angle is the one
//! at which [`turns`] are as large as the noise makes them.

use std::borrow::Cow;

use trueaxis_leastsquares::median;
use trueaxis_multilateration::Noise;

use super::turns::turns;
use super::{Axes, AxisReturn, PLAIN, Returned, STEPS};
use crate::{Error, Screened};

/// Standard deviations from one at which a ratio of variances is no chance where less is wrong with it, since the stops
/// that show it may have been removed; and at which it is converged.
const LIKELY: f64 = 2.0;
const CONVERGED: f64 = 0.2;

/// A turn that changes lengths by this many times their noise removes no stop at first, or none might be left to show it.
const EXCUSED: f64 = 10.0;

/// Part of the squares in the declared noise that angles must leave where that noise alone is rejected as clearly.
const EXPLAINED: f64 = 0.25;

impl Axes<'_> {
    /// How the axes return where rotary ones do so badly, by an angle.
    pub(super) fn turned(&self, together: Result<&Screened, &Error>) -> Option<Returned> {
        if self.lines.iter().all(Option::is_none) {
            return None;
        }
        let (mut found, limit) = self.start(together)?;
        let mut ratios = self.usual();
        let is_plain = self.improve(&found, &mut ratios, PLAIN);
        // All noise of a lone rotary axis may be that of its angle, beside which this is no excess.
        let squares = found.given_squares;
        let is_noisy =
            self.declared && EXPLAINED * squares > found.solution.degrees_of_freedom() as f64;
        let is_doubted = limit > 0 || is_noisy;
        let is_likely = is_plain || is_doubted && self.improve(&found, &mut ratios, LIKELY);
        if !is_likely {
            if !is_doubted || !self.declared {
                return None;
            }
            let shown = together.ok().filter(|_| !is_noisy);
            let noise = shown.map_or(self.network.noise, |screened| screened.network.noise);
            self.excuse(&found, noise, &mut ratios);
            found = Cow::Owned(self.search(&ratios, noise)?);
        }
        self.iterate(&mut found, &mut ratios, |found, ratios| {
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
            let shown = Screened::as_found(self.network, self.declared, &found).ok()?;
            if !self.improve(&shown, &mut none, PLAIN) {
                return None;
            }
        }
        let turns = ratios.iter().any(|own| own.angle > 0.0);
        let as_much = is_plain || is_explained;
        let explains = found.changes() < limit || as_much && found.changes() == limit;
        (turns && explains).then(|| (ratios, found.into_owned()))
    }

    /// Ratios at which a turn excuses [`EXCUSED`] times the noise of a length.
    fn excuse(&self, adjusted: &Screened, noise: Noise, ratios: &mut [AxisReturn]) {
        let mut levers_mm = vec![Vec::new(); ratios.len()];
        let (network, solution) = (&adjusted.network, &adjusted.solution);
        for visit in &network.visits {
            let (Some(axis), Some(line)) = (self.of_groups[visit.group], &self.lines[visit.group])
            else {
                continue;
            };
            let station_mm = solution.stations[visit.station].position_mm;
            for reading in &network.readings[visit.readings.clone()] {
                let point_mm = solution.points_mm[network.point(visit.group, reading.point)];
                levers_mm[axis].push(line.lever_mm(station_mm, point_mm).abs());
            }
        }
        let sigma_mm = noise.length_sigma_mm.hypot(noise.repeatability_mm);
        for (levers_mm, own) in levers_mm.iter_mut().zip(ratios) {
            let large = median(levers_mm).map(|lever_mm| EXCUSED * sigma_mm / lever_mm);
            let ratio = large.map(|angle| angle / noise.repeatability_mm);
            own.angle = ratio.filter(|ratio| ratio.is_finite()).unwrap_or(0.0);
        }
    }

    /// Steps towards the ratios that the residuals show; false if none of them differs. `limit` is that of axes that did not turn.
    pub(super) fn improve(
        &self,
        adjusted: &Screened,
        ratios: &mut [AxisReturn],
        limit: f64,
    ) -> bool {
        let noise = adjusted.network.noise;
        let sigma_mm = noise.repeatability_mm;
        // Turns may leave none beside them: any unit will do until the noise is estimated with a turn.
        let unit_mm = match sigma_mm > 0.0 {
            true => sigma_mm,
            false => noise.length_sigma_mm,
        };
        let mut improved = false;
        let shown = turns(adjusted, self);
        for (turns, own) in shown.into_iter().zip(ratios) {
            let Some(turns) = turns else {
                continue;
            };
            let differs = match own.angle > 0.0 {
                true => turns.excess.abs() > CONVERGED * turns.chance,
                false => turns.excess > limit * turns.chance,
            };
            if differs {
                let variance = (own.angle * sigma_mm).powi(2) + turns.excess / turns.part;
                own.angle = variance.max(0.0).sqrt() / unit_mm;
                improved = true;
            }
        }
        improved
    }
}
