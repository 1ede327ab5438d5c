//! What a cause makes responsible, and whether two causes are the same trouble under two names.

use trueaxis_effects::Shape;

use crate::lengths::base::{Base, Suspect};
use crate::lengths::causes::Found;
use crate::lengths::disturbance::{Wanderer, Who, With};
use crate::selection::Hypothesis;

/// What a cause, or a rival of it, makes responsible.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Culprit {
    /// What happens at a station, or to the machine during its occupation, at an instant or not.
    Station(usize, bool),
    Target(usize, bool),
    /// An axis in one way.
    Axis(usize, &'static str),
    /// Something that goes on through every occupation.
    EveryOccupation,
    /// The whole campaign in one way.
    Everything(&'static str),
}

/// Whether two causes have an explanation in common: then the second is no cause of its own but a sign
/// that neither has the right shape. A tripod that sways is no pile of jumps; a tripod that creeps and was
/// bumped has two troubles.
pub(crate) fn overlap(base: &Base<'_>, a: &Found, b: &Found) -> bool {
    let culprits = |found: &Found| -> Vec<Culprit> {
        let rivals = found.rivals.iter().map(|(suspect, _)| suspect);
        rivals
            .chain([&found.suspect])
            .map(|suspect| culprit(base, suspect))
            .collect()
    };
    let others = culprits(b);
    culprits(a).iter().any(|c| others.contains(c))
}

/// Whether what wanders is what a cause makes responsible, in time: then the cause may be no more than a part of a
/// course that it does not describe.
pub(crate) fn is_of(base: &Base<'_>, found: &Found, wanderer: Wanderer) -> bool {
    let rivals = found.rivals.iter().map(|(suspect, _)| suspect);
    let culprits = rivals.chain([&found.suspect]);
    let mut culprits = culprits.map(|suspect| culprit(base, suspect));
    culprits.any(|culprit| match (culprit, wanderer.who, wanderer.with) {
        (Culprit::Station(own, _), Who::Station(other), With::Occupation)
        | (Culprit::Target(own, _), Who::Target(other), With::Campaign) => own == other,
        (Culprit::EveryOccupation, Who::Machine | Who::Tripods, _) => true,
        (Culprit::Everything(id), Who::Air, _) => id == "refraction_drift",
        _ => false,
    })
}

fn culprit(base: &Base<'_>, suspect: &Suspect) -> Culprit {
    let Hypothesis {
        effect, subject, ..
    } = suspect.hypothesis;
    let during = || {
        let after = base.readings.iter().find(|r| r.time_s > suspect.shape);
        after.map_or(0, |r| r.station)
    };
    let at_an_instant = effect.shape == Shape::Instant;
    if subject.carrier.is_some() {
        return Culprit::EveryOccupation;
    }
    if let Some(axis) = subject.axis {
        return Culprit::Axis(axis, effect.id);
    }
    if let Some(target) = subject.target {
        return Culprit::Target(target, at_an_instant);
    }
    match subject.station {
        Some(station) => Culprit::Station(station, at_an_instant),
        None if at_an_instant => Culprit::Station(during(), true),
        None => match effect.id {
            "dead_path_drift" | "station_drift" | "station_settling" | "machine_drift"
            | "warm_up" => Culprit::EveryOccupation,
            id => Culprit::Everything(id),
        },
    }
}
