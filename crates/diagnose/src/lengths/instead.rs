//! What moves instead.
//!
//! Where all targets are on the machine (targets on the bed, which do not move, would show it):
//!
//! - A machine that shifts while one station is occupied: the lengths show an opposite jump of that tripod. Later
//!   stations are determined against the shifted machine. If one name is found, both are given.
//! - A machine that is larger instead of lengths that are shown too long. From one station a whole machine that grew by
//!   s is a scale s of its lengths: `u (p - c) s = l s - u (c - station) s`, where the station's position absorbs the
//!   rest. Over time it does not, but the difference is small.
//!
//! With any targets, a reflector whose error differs from station to station instead of one that slips between two
//! occupations: it is turned to the next station then, and stands in its nest otherwise, or is seen at another angle.

use std::collections::HashMap;

use trueaxis_effects::{Shape, Subject, effect};
use trueaxis_selection::{DECISIVE, Fit, Hypothesis};

use crate::Error;
use crate::engine::disturbance::{Wanderer, Who, With};
use crate::engine::{Found, Measured, Suspect, without};
use crate::lengths::adjusted::Adjusted;
use crate::lengths::base::Base;

/// Adds to the slip of a target a reflector that was turned, to a shift of the machine the jump of a tripod at the same
/// instant, and to a scale of lengths a machine that grows in the same course, if it explains nearly as much.
pub(crate) fn add_what_moves_instead(
    base: &Base<'_>,
    adjusted: &Adjusted,
    found: &mut [Found],
) -> Result<(), Error> {
    add_turned_reflectors(base, adjusted, found)?;
    let Some(jump) = effect("station_jump").filter(|_| !base.scene.has_bed_targets()) else {
        return Ok(());
    };
    for (k, found) in found.iter_mut().enumerate() {
        let (hypothesis, shape) = (found.suspect.hypothesis, found.suspect.shape);
        let effect = hypothesis.effect;
        let is_jump = |(rival, _): &(Suspect, f64)| rival.hypothesis.effect == jump;
        let is_shift = effect.moves_machine() && effect.shape == Shape::Instant;
        let may_jump = is_shift && !found.rivals.iter().any(is_jump);
        // The temperature of the air is not that of the machine.
        let may_grow = effect.scales_lengths() && hypothesis.subject.column.is_none();
        if !may_jump && !may_grow {
            continue;
        }
        let without = base.adjust_near(adjusted, without(&adjusted.suspects, k))?;
        let fit = |columns: &[Vec<f64>]| Fit::new(&without.projection, columns);
        let columns = base.columns(&without);
        let fit_of = |own: &Hypothesis| fit(&columns(own, shape));
        let own = fit_of(&hypothesis).gained();
        if may_jump {
            let stations = (0..base.scene.stations.len()).map(Subject::station);
            let jumps = Hypothesis::of_each(jump, stations.collect());
            let jumps = jumps.into_iter().map(|jump| (jump, fit_of(&jump)));
            let best = jumps.max_by(|(_, a), (_, b)| a.gained().total_cmp(&b.gained()));
            let best = best.filter(|(_, fit)| own - fit.gained() < DECISIVE);
            found.rivals.extend(best.map(|(jump, fit)| {
                let bic = found.bic + own - fit.gained();
                (
                    Suspect::new(jump, (shape, found.suspect.u_shape), &fit),
                    bic,
                )
            }));
        }
        // The point where the machine is held is no finding, so it costs nothing.
        let grown = may_grow.then(|| fit(&grown(base, &without, &hypothesis, shape)).gained());
        let machine = Wanderer::new(Who::Machine, With::Campaign);
        let grown = grown.filter(|gained| own - gained < DECISIVE);
        found
            .wandering
            .extend(grown.map(|gained| (machine, gained)));
    }
    Ok(())
}

/// Adds to the slip of a target its reflector, if it may have slipped between two occupations.
fn add_turned_reflectors(
    base: &Base<'_>,
    adjusted: &Adjusted,
    found: &mut [Found],
) -> Result<(), Error> {
    for (k, found) in found.iter_mut().enumerate() {
        let (hypothesis, shape) = (found.suspect.hypothesis, found.suspect.shape);
        let slips = hypothesis.effect.id == "target_slip";
        let Some(target) = hypothesis.subject.target.filter(|_| slips) else {
            continue;
        };
        let without = base.adjust_near(adjusted, without(&adjusted.suspects, k))?;
        let columns = base.columns(&without);
        let gained =
            |shape: f64| Fit::new(&without.projection, &columns(&hypothesis, shape)).gained();
        let between = between_occupations(base, target).into_iter();
        let turned = between.map(gained).max_by(f64::total_cmp);
        let turned = turned.filter(|turned| gained(shape) - turned < DECISIVE);
        let reflector = Wanderer::new(Who::Target(target), With::Campaign);
        let is_new = found.wandering.iter().all(|(own, _)| *own != reflector);
        found
            .wandering
            .extend(turned.filter(|_| is_new).map(|gained| (reflector, gained)));
    }
    Ok(())
}

/// Instants after which no station sees a target that saw it before, s.
fn between_occupations(base: &Base<'_>, target: usize) -> Vec<f64> {
    let own = base.readings.iter().filter(|r| r.target == target);
    let mut own: Vec<(f64, usize)> = own.map(|r| (r.time_s, r.station)).collect();
    own.sort_by(|a, b| a.0.total_cmp(&b.0));
    let last: HashMap<usize, usize> = own.iter().enumerate().map(|(k, r)| (r.1, k)).collect();
    // The last reading of all stations that have seen it so far.
    let mut reach = 0;
    let instants = (1..own.len()).filter(|&k| {
        reach = reach.max(last[&own[k - 1].1]);
        reach < k && own[k - 1].0 < own[k].0
    });
    instants.map(|k| 0.5 * (own[k - 1].0 + own[k].0)).collect()
}

/// Whitened columns of a machine that grows in the course of a scale of lengths, about the origin and any point.
fn grown(base: &Base<'_>, adjusted: &Adjusted, scale: &Hypothesis, shape: f64) -> Vec<Vec<f64>> {
    let observations = base.observations(&adjusted.solution);
    let of_lengths = base.columns_at(&observations, scale, shape).swap_remove(0);
    let with_course = |of: &dyn Fn(usize) -> f64| {
        let course = |i: usize| of_lengths[i] / observations[i].at.distance_mm;
        let mut column: Vec<f64> = (0..observations.len()).map(|i| course(i) * of(i)).collect();
        adjusted.whitened.whiten(&mut column);
        column
    };
    // A metre, so that all columns have similar length.
    let held = (0..3).map(|c| with_course(&|i| 1e3 * observations[i].beam[c]));
    let grows = with_course(&|i| {
        observations[i]
            .beam
            .dot(&observations[i].at.point_mm.coords)
    });
    [grows].into_iter().chain(held).collect()
}
