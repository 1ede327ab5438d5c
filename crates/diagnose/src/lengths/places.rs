//! Where the misfit lives.

use trueaxis_campaign::Direction;
use trueaxis_poses::LengthCircumstances as Reading;

use crate::Place;
use crate::lengths::base::Base;

/// Parts of the travel and of the campaign's time.
const PARTS: usize = 4;

/// Rms of the residuals (mm) by station, target, axis, direction, repeat, position and time, before and
/// after; `scale` makes them per degree of freedom.
pub(crate) fn places(
    base: &Base<'_>,
    before_mm: &[f64],
    after_mm: &[f64],
    scale: [f64; 2],
) -> Vec<Place> {
    let scene = &base.scene;
    let first_s = base.readings.first().map_or(0.0, |r| r.time_s);
    let last_s = base.readings.last().map_or(0.0, |r| r.time_s);
    let bounds = (1..PARTS).map(|k| k as f64 / PARTS as f64);
    let quarter = |x: f64| bounds.clone().filter(|bound| x >= *bound).count();
    let group = |by: &str, r: &Reading| -> (usize, String) {
        match by {
            "station" => (r.station, scene.stations[r.station].clone()),
            "target" => (r.target, scene.targets[r.target].name.clone()),
            "axis" => (r.axis, scene.axis_name(r.axis).to_owned()),
            "direction" => match r.direction {
                Direction::Forward => (0, "+1".to_owned()),
                Direction::Backward => (1, "-1".to_owned()),
            },
            "repeat" => (r.repeat as usize, r.repeat.to_string()),
            "position" => {
                let [low, high] = scene.machine.axes()[r.axis].travel();
                let q = base.campaign.steps[r.step].positions[r.axis];
                let k = quarter((q - low) / (high - low));
                let name = format!(
                    "{}, quarter {} of its travel",
                    scene.axis_name(r.axis),
                    k + 1
                );
                (PARTS * r.axis + k, name)
            }
            _ => {
                let k = quarter((r.time_s - first_s) / (last_s - first_s));
                let at = |k: usize| first_s + (last_s - first_s) * k as f64 / PARTS as f64;
                (k, format!("{:.0} to {:.0} s", at(k), at(k + 1)))
            }
        }
    };
    let mut places = Vec::new();
    for by in [
        "station",
        "target",
        "axis",
        "direction",
        "repeat",
        "position",
        "time",
    ] {
        let mut groups: Vec<(usize, Place, [f64; 2])> = Vec::new();
        for (i, reading) in base.readings.iter().enumerate() {
            let (key, name) = group(by, reading);
            let place = match groups.binary_search_by_key(&key, |g| g.0) {
                Ok(place) => place,
                Err(place) => {
                    let new = Place {
                        by,
                        name,
                        readings: 0,
                        before_um: 0.0,
                        after_um: 0.0,
                    };
                    groups.insert(place, (key, new, [0.0; 2]));
                    place
                }
            };
            let (_, place, squares) = &mut groups[place];
            place.readings += 1;
            squares[0] += before_mm[i].powi(2);
            squares[1] += after_mm[i].powi(2);
        }
        // One group alone says nothing about where.
        if groups.len() > 1 {
            places.extend(groups.into_iter().map(|(_, place, squares)| {
                let rms = |k: usize| (squares[k] / place.readings as f64).sqrt() * scale[k] * 1e3;
                Place {
                    before_um: rms(0),
                    after_um: rms(1),
                    ..place
                }
            }));
        }
    }
    places
}
