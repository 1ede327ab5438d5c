//! Where the lengths to one target say that it is, when all others are where the campaign has them.
//!
//! A point `q` with the distances `l + L` from known points `p` follows from linear equations:
//!
//! ```text
//! 2 pᵀq + 2 l L - (|q|² - L²) = |p|² - l²
//! ```
//!
//! so first each station, from the nominal places of the other targets, with its dead path as `L`; then the target at home, from the
//! stations as its stage sees them, with the constant of its reflector as `-L`.

use nalgebra::{DMatrix, Point3, distance};
use trueaxis_campaign::Campaign;
use trueaxis_kinematics::Ideal;
use trueaxis_leastsquares::dense;

/// A target nearer than this to its nominal position is there, mm: the nominal motion is not known better.
const THERE_MM: f64 = 20.0;

/// A point fits whose distances are off by less than this part of the largest of them: nominal places are better.
const FITTING: f64 = 1e-2;

/// By which axis a target is carried, and where it is at home; nothing if it is where the campaign has it.
pub(crate) fn elsewhere(campaign: &Campaign, target: usize) -> Vec<(usize, Point3<f64>)> {
    let (machine, given) = (&campaign.machine, &campaign.targets[target]);
    let (Some(declared), Some(lengths)) = (given.carrier, &campaign.lengths) else {
        return Vec::new();
    };
    let station = |number: usize| {
        let mut seen = Vec::new();
        for stop in lengths.stops.iter().filter(|stop| stop.station == number) {
            let positions = &campaign.steps[stop.step].positions;
            let readings = lengths.readings[stop.readings.clone()].iter();
            seen.extend(readings.filter(|r| r.target != target).map(|reading| {
                let other = &campaign.targets[reading.target];
                let place = machine.position(&Ideal, other.carrier, positions, other.home_mm);
                (place, reading.length_mm)
            }));
        }
        located(&seen)
    };
    let stations: Vec<_> = (0..campaign.stations.len()).map(station).collect();
    let place = |carrier: usize| {
        let mut seen = Vec::new();
        for stop in &lengths.stops {
            let Some((place, dead_path_mm)) = stations[stop.station] else {
                continue;
            };
            let positions = &campaign.steps[stop.step].positions;
            let from_stage = machine.motion(&Ideal, carrier, positions).inverse() * place;
            let readings = lengths.readings[stop.readings.clone()].iter();
            let of_target = readings.filter(|r| r.target == target);
            seen.extend(of_target.map(|r| (from_stage, r.length_mm + dead_path_mm)));
        }
        let (home_mm, _) = located(&seen)?;
        let is_there = distance(&home_mm, &given.home_mm) < THERE_MM;
        Some((carrier, if is_there { given.home_mm } else { home_mm }))
    };
    match place(declared) {
        Some(place) => vec![place],
        None => (0..machine.axes().len()).filter_map(place).collect(),
    }
}

/// The point with the distances `l + L` from some points, and `L`.
fn located(seen: &[(Point3<f64>, f64)]) -> Option<(Point3<f64>, f64)> {
    let design = DMatrix::from_fn(seen.len(), 5, |i, k| match k {
        0..3 => 2.0 * seen[i].0[k],
        3 => 2.0 * seen[i].1,
        _ => -1.0,
    });
    let right = seen.iter().map(|(p, l)| p.coords.norm_squared() - l * l);
    let fit = dense::solve(&design, &right.collect::<Vec<_>>()).ok()?;
    let [x, y, z, constant_mm] = *fit.unknowns.first_chunk()?;
    let point = Point3::new(x, y, z);
    let off_mm = |(p, l): &(Point3<f64>, f64)| (distance(p, &point) - l - constant_mm).abs();
    let worst_mm = seen.iter().map(off_mm).fold(0.0, f64::max);
    let far_mm = seen
        .iter()
        .map(|(p, _)| distance(p, &point))
        .fold(0.0, f64::max);
    (worst_mm < FITTING * far_mm).then_some((point, constant_mm))
}
