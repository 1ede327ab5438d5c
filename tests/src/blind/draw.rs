//! Draws a disturbance: subject, direction, rough size and instants from a seed.

use std::f64::consts::TAU;

use super::dice::Dice;
use super::layout::Layout;
use super::random::{Purpose, Random};
use super::schedule::Schedule;
use super::{Act, Course, Hidden, Kind};

/// Effects of the catalogue that can be seen in lengths.
pub const CATALOGUED: &[&str] = &[
    "dead_path_drift",
    "dead_path_jump",
    "refraction_drift",
    "timestamp_offset",
    "station_drift",
    "station_jump",
    "target_slip",
    "target_creep",
    "fixture_expansion",
    "machine_drift",
    "warm_up",
    "machine_shift",
    "axis_expansion",
    "backlash",
    "stage_bending",
    "station_scale",
    "station_settling",
];

/// So many of them stand before those that are not in the catalogue in [`names`], whose order seeds the draws: new
/// ones are appended.
const FIRST: usize = 15;

/// Effects that the catalogue does not hold.
pub const UNCATALOGUED: [&str; 6] = [
    "air_conditioning",
    "tripod_sway",
    "opposed_warm_ups",
    "cross_talk",
    "warping_axis",
    "loosening_drive",
];

/// So many of these stand before the later ones of the catalogue.
const FIRST_UNCATALOGUED: usize = 4;

/// Station drift that is the same in every occupation, about as a machine that drifts in each of them.
/// Drawn as a `station_drift` of no single station.
pub const COMMON_STATION_DRIFT: &str = "common_station_drift";

/// A disturbance of that name for campaigns of that kind, a few µm large; `None` if there is no such
/// disturbance, or it would leave no trace in campaigns of that kind (lost motion that is always on
/// the same side, a growing linear axis without one, late readings at standstill).
pub fn draw(kind: &Kind, name: &str, seed: u64) -> Option<Hidden> {
    let layout = Layout::new(kind);
    let schedule = Schedule::new(kind, &layout);
    let mut known = names().zip(0..);
    let (own_name, number) = known.find(|(known, _)| *known == name)?;
    let mut dice = Dice {
        random: Random::new(seed, Purpose::Hidden(number)),
        occupations_s: &schedule.occupations_s,
        layout: &layout,
    };
    let occupation = Course::Occupation { bend: 0.0 };
    let campaign = Course::Campaign { bend: 0.0 };
    let drawn = match name {
        "dead_path_drift" => {
            let station = dice.station();
            // Every fourth time all stations, each by its own rate.
            let station = (!dice.random.happens(0.25)).then_some(station);
            on_station(station, dice.zeros(station), occupation)
        }
        "dead_path_jump" => {
            let station = dice.station();
            let jump = dice.jump_at(station);
            on_station(Some(station), dice.zeros(Some(station)), jump)
        }
        "refraction_drift" => on_all(Act::Scale(dice.size()), campaign),
        "timestamp_offset" if kind.on_the_fly && kind.both_directions => {
            let axis = dice.any_axis();
            on_axis(axis, Act::Late(0.1 * dice.size()))
        }
        "station_drift" => {
            let station = dice.station();
            on_station(Some(station), Act::Tripod(dice.vector()), occupation)
        }
        COMMON_STATION_DRIFT => on_all(Act::Tripod(dice.vector()), occupation),
        "station_jump" => {
            let station = dice.station();
            let jump = dice.jump_at(station);
            on_station(Some(station), Act::Tripod(dice.vector()), jump)
        }
        "station_scale" => {
            let station = dice.station();
            on_station(Some(station), Act::Scale(dice.size()), Course::Constant)
        }
        "station_settling" => {
            let station = dice.station();
            let [from_s, to_s] = schedule.occupations_s[station];
            let course = Course::Settling {
                time_constant_s: (to_s - from_s) * dice.random.between(0.03, 0.3),
                exponent: 1.0,
            };
            // Every fourth time all tripods alike.
            let station = (!dice.random.happens(0.25)).then_some(station);
            on_station(station, Act::Tripod(dice.vector()), course)
        }
        "target_slip" => {
            let target = dice.target();
            let station = dice.station();
            let jump = dice.jump_at(station);
            on_target(target, Act::Target(dice.vector()), jump)
        }
        "target_creep" => {
            let target = dice.target();
            on_target(target, Act::Target(dice.vector()), campaign)
        }
        "fixture_expansion" => on_all(Act::Growth(10.0 * dice.size()), campaign),
        "machine_drift" => on_all(Act::Machine(dice.vector()), campaign),
        "warm_up" => {
            let [_, end_s] = schedule.span_s();
            let course = Course::WarmUp {
                time_constant_s: end_s * dice.random.between(0.08, 0.5),
                exponent: 1.0,
            };
            on_all(Act::Machine(dice.vector()), course)
        }
        "machine_shift" => {
            let station = dice.station();
            let jump = dice.jump_at(station);
            on_all(Act::Machine(dice.vector()), jump)
        }
        "axis_expansion" => {
            let axis = dice.linear_axis()?;
            Hidden {
                course: campaign,
                ..on_axis(axis, Act::AxisScale(3.0 * dice.size()))
            }
        }
        "backlash" if kind.both_directions => {
            let axis = dice.any_axis();
            on_axis(axis, Act::LostMotion(dice.size()))
        }
        "stage_bending" => dice.bending(),
        "air_conditioning" => dice.air(),
        "tripod_sway" => dice.sway(),
        "opposed_warm_ups" => {
            let course = Course::OpposedWarmUps {
                fast_s: 600.0 * dice.random.between(0.7, 1.4),
                slow_s: 7200.0 * dice.random.between(0.7, 1.4),
                ratio: dice.random.between(1.0, 2.0),
            };
            on_all(Act::Machine(dice.vector()), course)
        }
        "cross_talk" => {
            let act = Act::CrossTalk {
                amplitude_um: dice.size(),
                waves: dice.random.between(2.0, 4.0),
                phase_rad: dice.random.between(0.0, TAU),
            };
            on_station(Some(dice.station()), act, Course::Constant)
        }
        "warping_axis" => {
            let axis = dice.linear_axis()?;
            let bend_um = dice.vector();
            let act = Act::Warping {
                guide_um: 2.0 * dice.vector(),
                bend_um,
                turn_arcsec: dice.vector(),
            };
            Hidden {
                course: dice.warming(schedule.span_s()),
                ..on_axis(axis, act)
            }
        }
        "loosening_drive" if kind.both_directions => {
            let axis = dice.any_axis();
            let act = Act::LostMotion(2.0 * dice.size());
            Hidden {
                course: dice.warming(schedule.span_s()),
                ..on_axis(axis, act)
            }
        }
        _ => return None,
    };
    let name = match own_name {
        COMMON_STATION_DRIFT => "station_drift",
        own => own,
    };
    Some(Hidden { name, ..drawn })
}

/// All names that can be drawn.
pub fn names() -> impl Iterator<Item = &'static str> {
    let (first, later) = CATALOGUED.split_at(FIRST);
    let (uncatalogued, added) = UNCATALOGUED.split_at(FIRST_UNCATALOGUED);
    let all = first.iter().chain(uncatalogued);
    let all = all.chain([&COMMON_STATION_DRIFT]).chain(later);
    all.chain(added).copied()
}

/// The same disturbance with a shape slightly other than the ideal one: a jump takes up to ten
/// seconds, a drift is bent, a warm-up has no single time constant, a bending no whole power.
#[must_use]
pub fn misshapen(hidden: &Hidden, seed: u64) -> Hidden {
    let mut random = Random::new(seed, Purpose::Shape);
    let part = random.sign() * random.between(0.5, 1.0);
    let mut hidden = hidden.clone();
    hidden.course = hidden.course.misshapen(part);
    if let Act::Bending { exponent, .. } = &mut hidden.act {
        *exponent = 2.0 + 0.3 * part;
    }
    hidden
}

pub(super) fn on_all(act: Act, course: Course) -> Hidden {
    Hidden {
        name: "",
        act,
        course,
        station: None,
        target: None,
        axis: None,
    }
}

pub(super) fn on_station(station: Option<usize>, act: Act, course: Course) -> Hidden {
    Hidden {
        station,
        ..on_all(act, course)
    }
}

pub(super) fn on_target(target: usize, act: Act, course: Course) -> Hidden {
    Hidden {
        target: Some(target),
        ..on_all(act, course)
    }
}

fn on_axis(axis: usize, act: Act) -> Hidden {
    Hidden {
        axis: Some(axis),
        ..on_all(act, Course::Constant)
    }
}
