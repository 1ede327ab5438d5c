//! Effects that these points cannot show.

use trueaxis_effects::{Level, effect};

use crate::NotObservable;
use crate::engine::{is_tested, of_catalogue, scans, unseen, untested, without_trace};
use crate::points::base::Base;
use crate::points::model::Model;

/// Effects without a trace in these points.
pub(crate) fn not_observable(base: &Base<'_>, model: &Model) -> Vec<NotObservable> {
    let all = of_catalogue(Level::Points, base.scene, |s| is_tested(base.campaign, s));
    let hidden = scans(base, model, &model.bare, &all).without_trace;
    let mut list = without_trace(base.scene, &hidden, |effect| match effect {
        _ if effect.is_lost_motion() => "all its stops are approached from one side",
        _ if effect.is_delay() => {
            "the machine stands still at the stops, or all are approached from one side"
        }
        _ => "poses and shapes of the targets absorb all of it",
    });
    list.extend(untested(Level::Points, base.campaign, base.scene));
    let why = "poses and shapes of the targets stretch with the coordinates";
    let bias = [("calibration", "1 um per m per ppm")];
    list.extend(effect("length_scale").map(|scale| unseen(scale, String::new(), why, bias)));
    list
}
