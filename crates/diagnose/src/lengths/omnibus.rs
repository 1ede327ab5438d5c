//! The quantities with which the lengths are tested to vary ([`crate::engine`]).
//!
//! | varies with | columns |
//! | --- | --- |
//! | `time` | 24 half waves, so twelve periods, in the occupation of each station |
//! | `position` | twelve half waves of the position of each axis as one station sees it |
//! | `target` | four of each axis as one target shows it; each target from each station |
//! | `direction` | the side of approach as each target shows it; how each axis moves and turns otherwise from one side than from the other, all along and times a half wave of its position |

use rayon::prelude::*;
use trueaxis_poses::{LengthCircumstances as Reading, Observation};

use crate::engine::{Family, Omnibus, waves_of};
use crate::lengths::adjusted::Adjusted;
use crate::lengths::base::Base;

const OF_TIME: usize = 24;
const OF_POSITION: usize = 12;
const OF_TARGET: usize = 4;
const OF_DIRECTION: usize = 1;

/// All tests of what an adjusted model leaves.
pub(crate) fn omnibus(base: &Base<'_>, adjusted: &Adjusted) -> Vec<Omnibus> {
    let stations = base.scene.stations.len();
    let axes = base.scene.machine.axes().len();
    let places = |place: &dyn Fn(&Reading) -> (usize, f64)| -> Vec<Option<(usize, f64)>> {
        base.readings.iter().map(|r| Some(place(r))).collect()
    };
    let of_target = places(&|r| (r.target * axes + r.axis, travelled(base, r)));
    let from_station = places(&|r| (r.target * stations + r.station, 0.0));
    let of_time = places(&|r| (r.station, r.occupation_progress));
    let of_position = places(&|r| (r.station * axes + r.axis, travelled(base, r)));
    let mut families = vec![
        ("time", waves_of(of_time, false, OF_TIME)),
        ("position", waves_of(of_position, false, OF_POSITION)),
        (
            "target",
            [
                waves_of(of_target.clone(), false, OF_TARGET),
                waves_of(from_station, true, 0),
            ]
            .concat(),
        ),
    ];
    let mut sides = base.readings.iter().map(Reading::sign);
    let first = sides.next();
    if sides.any(|side| Some(side) != first) {
        let of_axis = places(&|r| (r.axis, travelled(base, r)));
        let by_axis = waves_of(of_axis, true, OF_DIRECTION);
        let observations = base.observations(&adjusted.solution);
        let moved: Vec<[f64; 6]> = observations.iter().map(moved).collect();
        let moving = by_axis.iter().flat_map(|column| {
            let of_component = |k: usize| column.iter().zip(&moved).map(move |(x, by)| x * by[k]);
            (0..6).map(move |k| of_component(k).collect())
        });
        let mut columns = waves_of(of_target, true, 0);
        columns.extend(moving);
        for column in &mut columns {
            let of_rows = column.iter_mut().zip(&base.readings);
            of_rows.for_each(|(x, reading)| *x *= reading.sign());
        }
        families.push(("direction", columns));
    }
    let whitened = families.into_par_iter().map(|(varies_with, mut columns)| {
        let of_columns = columns.iter_mut();
        of_columns.for_each(|column| adjusted.whitened.whiten(column));
        Family {
            varies_with,
            columns,
        }
    });
    let families: Vec<Family> = whitened.collect();
    Omnibus::of_all(&adjusted.projection, &families, 1.0)
}

/// How much longer a length is for a unit of each translation of what the axis carries, and for one of each rotation about
/// the origin of the machine, over a metre.
fn moved(Observation { at, beam }: &Observation<'_>) -> [f64; 6] {
    if at.carrier.is_none() {
        return [0.0; 6];
    }
    let turned = at.point_mm.coords.cross(beam) / 1000.0;
    [beam.x, beam.y, beam.z, turned.x, turned.y, turned.z]
}

/// Position of an axis in its travel, 0 to 1.
pub(crate) fn travelled(base: &Base<'_>, reading: &Reading) -> f64 {
    let [low, high] = base.scene.machine.axes()[reading.axis].travel();
    let position = base.campaign.steps[reading.step].positions[reading.axis];
    if high > low {
        (position - low) / (high - low)
    } else {
        0.0
    }
}
