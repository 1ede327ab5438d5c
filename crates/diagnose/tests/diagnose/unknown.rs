//! Disturbances that the catalogue does not have: no confident wrong cause.

use std::f64::consts::TAU;

use rand_distr::{Distribution, StandardNormal};

use trueaxis_diagnose::{Disturbance, Verdict, Wandering};

use crate::counts::summary;
use crate::iso_run::{
    Place, beyond_the_mean_curve, curve_um, places, table, table_of_stops, values_um,
};
use crate::{found, generator, length, report};

const SIGMA_UM: f64 = 0.5;
const LAMBDA: f64 = 20.0;

/// Air conditioning, a scale that breathes with it, and a wandering zero: at least 95 % have no name, and in at least 90 % what wanders is
/// the zero of the instrument or the machine (a pair), or the scale of the axis. A zero that walks at random has a course that a drift or
/// a jump describes as well in one of ten: such a one counts as a name, though it is always one of several.
/// A cycle takes 450 s; ten periods are near that, the others anywhere from 300 to 600 s.
fn assert_unknown(seeds: std::ops::Range<u64>) {
    let (mut all, mut all_unknown, mut all_described) = (0, 0, 0);
    for what in ["air conditioning", "breathing scale", "wandering zero"] {
        let (mut unknown, mut described, mut odd) = (0, 0, Vec::new());
        for seed in seeds.clone() {
            let mut generator = generator(seed, 6);
            let period_s = match seed {
                0..10 => 431.0,
                _ => 300.0 + (37 * seed % 300) as f64,
            };
            let places = places(5, &[0.0], &[2.0]);
            let mut zero = 0.0;
            let mut form = |p: &Place| {
                let step: f64 = StandardNormal.sample(&mut generator);
                zero += step;
                match what {
                    "air conditioning" => (TAU * p.time_s / period_s + seed as f64).sin(),
                    "breathing scale" => p.x_mm * (TAU * p.time_s / period_s + seed as f64).sin(),
                    _ => zero,
                }
            };
            let trace: Vec<f64> = places.iter().map(&mut form).collect();
            let size = LAMBDA * SIGMA_UM / length(&beyond_the_mean_curve(&places, &trace));
            let disturbance: Vec<f64> = trace.iter().map(|x| size * x).collect();
            let curve = curve_um(&mut generator);
            let values = values_um(&places, &curve, &disturbance, SIGMA_UM, &mut generator);
            let found = found(table(&places, &values, true));
            if found.verdict == Verdict::Unknown {
                unknown += 1;
            }
            let is_own = |w: &Wandering| {
                w.varies_with == ["time"] && w.subject.axis.is_some() == (what == "breathing scale")
            };
            let is_among = |d: &Disturbance| is_own(&d.whose) || d.rivals.iter().any(is_own);
            if found.disturbances.iter().any(is_among) {
                described += 1;
            }
            if found.verdict != Verdict::Unknown || !found.causes.is_empty() {
                odd.push(summary(&found));
            }
        }
        let count = seeds.end - seeds.start;
        report(&format!(
            "{what}: {unknown} of {count} unknown, {described} with what wanders or a pair; {odd:?}"
        ));
        all += count;
        all_unknown += unknown;
        all_described += described;
    }
    let line = format!("{all_unknown} of {all} unknown, {all_described} with what wanders");
    assert!(
        100 * all_unknown >= 95 * all && 10 * all_described >= 9 * all,
        "{line}"
    );
}

#[test]
fn what_is_not_in_the_catalogue_gets_no_name() {
    assert_unknown(0..1);
}

#[test]
#[ignore = "study: 120 diagnoses"]
fn what_is_not_in_the_catalogue_hardly_ever_gets_a_name() {
    assert_unknown(0..40);
}

/// Sides that differ by 5 to 6 mm in each of three cycles, more than any drive loses: the zero of the instrument was said to wander with
/// time instead, there and back with the axis.
#[test]
fn what_turns_round_with_the_axis_does_not_go_with_time() {
    let mut generator = generator(1, 48);
    let table = table_of_stops(3, 11, &mut |_, forward, stop| {
        let noise: f64 = StandardNormal.sample(&mut generator);
        let behind_um = 2500.0 + 50.0 * stop as f64;
        noise - if forward { behind_um } else { -behind_um }
    });
    let found = found(table);
    assert_eq!(found.verdict, Verdict::Unknown);
    assert!(found.disturbances.is_empty(), "{:?}", found.disturbances);
    let says_so = |notice: &String| notice.contains("the sides of approach differ by 550");
    assert!(found.notices.iter().any(says_so), "{:?}", found.notices);
}

/// Two limit switches half a millimetre apart, each reached from its own side in ten cycles: one drifts by 80 µm, the other by -8 µm. As
/// expansion of the axis that is impossible, and where nothing tested how positions change in time, they were called clean.
#[test]
fn what_fits_with_an_impossible_size_only_is_not_clean() {
    let mut generator = generator(3, 48);
    let mut table = table_of_stops(10, 2, &mut |row, forward, _| {
        let noise: f64 = StandardNormal.sample(&mut generator);
        noise + row as f64 * if forward { 2.0 } else { -0.2 }
    });
    for reading in &mut table.readings {
        reading.positions[0] *= 0.01;
    }
    table
        .readings
        .retain(|reading| (reading.positions[0] > 0.0) == (reading.direction.sign() > 0));
    let found = found(table);
    assert!(found.verdict.is_misfit());
    let left = found.unexplained.unwrap();
    assert_eq!(left.varies_with, ["position", "time"], "{}", left.note);
}

/// One cycle over 0.3 mm, in which 100 µm are lost and taken up over 0.03 mm behind each turn. The scale was said to wander by 200 µm there,
/// a million ppm, and left lost motion of -57 ± 19 µm: no axis grows by as much as its readings scatter on so short a line.
#[test]
fn no_scale_wanders_on_a_line_too_short_for_it() {
    for seed in 0..4 {
        let mut generator = generator(seed, 49);
        let there = (0..31).map(|step| (true, step));
        let back = (0..31).rev().map(|step| (false, step));
        let place = |(row, (forward, step)): (usize, (bool, usize))| Place {
            time_s: 0.35 * row as f64,
            cycle: 1,
            forward,
            step,
            x_mm: 0.01 * step as f64,
            parked: 0,
            y_mm: 0.0,
            speed: 0.0,
        };
        let places: Vec<Place> = there.chain(back).enumerate().map(place).collect();
        let value = |place: &Place| {
            let (from_turn_mm, side) = match place.forward {
                true => (place.x_mm, 1.0),
                false => (0.3 - place.x_mm, -1.0),
            };
            let noise: f64 = StandardNormal.sample(&mut generator);
            side * (100.0 * (-from_turn_mm / 0.03).exp() - 50.0) + noise
        };
        let values: Vec<f64> = places.iter().map(value).collect();
        let found = found(table(&places, &values, true));
        let of_axis =
            |d: &Disturbance| d.whose.varies_with == ["time"] && d.whose.subject.axis.is_some();
        assert!(
            !found.disturbances.iter().any(of_axis),
            "{}",
            summary(&found)
        );
        for cause in found
            .causes
            .iter()
            .filter(|c| c.effect.effect.is_lost_motion())
        {
            let lost = &cause.parameters[0];
            assert!(lost.value > -2.0 * lost.u, "seed {seed}: {lost:?}");
        }
    }
}

/// The curve of what wanders is the one that was hidden, within its uncertainty: 33 points of each of four lines, of which
/// some 5 % are outside two standard uncertainties; a fifth would be by chance with a probability below 1e-6 if they were independent,
/// and a smooth course has some ten independent parts.
#[test]
fn what_wanders_has_its_curve() {
    let (mut inside, mut all) = (0, 0);
    for seed in 0..4 {
        let mut generator = generator(seed, 9);
        let places = places(5, &[0.0], &[2.0]);
        let last_s = places.iter().map(|p| p.time_s).fold(0.0, f64::max);
        let first_s = places.iter().map(|p| p.time_s).fold(last_s, f64::min);
        // Settles, swings, and goes on.
        let course = |time_s: f64| {
            let x = (time_s - first_s) / (last_s - first_s);
            6.0 * (-3.0 * x).exp() + 2.0 * (5.0 * x + seed as f64).sin()
        };
        let hidden: Vec<f64> = places.iter().map(|p| course(p.time_s)).collect();
        let curve = curve_um(&mut generator);
        let values = values_um(&places, &curve, &hidden, SIGMA_UM, &mut generator);
        let found = found(table(&places, &values, true));
        let [wandering] = found.disturbances.as_slice() else {
            panic!("{}", summary(&found));
        };
        assert!(wandering.heldout_gain.unwrap() > 0.3, "{wandering:?}");
        // From its mean over the points, as the curve from its own.
        let points = &wandering.curve;
        let mean =
            |f: &dyn Fn(usize) -> f64| (0..points.len()).map(f).sum::<f64>() / points.len() as f64;
        let off = mean(&|k| points[k].value_um[0] - course(points[k].at));
        for point in points {
            let error = point.value_um[0] - course(point.at) - off;
            inside += usize::from(error.abs() < 2.0 * point.u_um[0]);
            all += 1;
        }
    }
    report(&format!(
        "{inside} of {all} points inside two standard uncertainties"
    ));
    assert!(5 * inside >= 4 * all, "{inside} of {all}");
}

/// Lost motion keeps its name and its size, within four standard uncertainties, beside an air conditioning as large.
#[test]
fn lost_motion_is_named_beside_what_wanders() {
    let mut wandering = 0;
    // Without a clock: at one feed a time offset would be its rival.
    for seed in 0..6 {
        let mut generator = generator(seed, 10);
        let places = places(5, &[0.0], &[2.0]);
        let hidden: Vec<f64> = places
            .iter()
            .map(|p| {
                let lost = if p.forward { -2.0 } else { 2.0 };
                lost + 2.0 * (TAU * p.time_s / 997.0 + seed as f64).sin()
            })
            .collect();
        let curve = curve_um(&mut generator);
        let values = values_um(&places, &curve, &hidden, SIGMA_UM, &mut generator);
        let found = found(table(&places, &values, false));
        let [cause] = found.causes.as_slice() else {
            panic!("{}", summary(&found));
        };
        // In one of a hundred it seems to change along the axis.
        let names = ["backlash", "position_dependent_backlash"];
        assert!(
            names.contains(&cause.effect.effect.id),
            "{}",
            summary(&found)
        );
        let lost = &cause.parameters[0];
        assert!((lost.value - 4.0).abs() < 4.0 * lost.u, "{lost:?}");
        wandering += found.disturbances.len();
    } // One of each, and a second one in 0.2 %.
    assert!((6..=7).contains(&wandering), "{wandering} in 6");
}
