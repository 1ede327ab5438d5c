//! Lost motion that changes while it is measured: a drive that warms up or works loose.

use rand::RngExt;
use trueaxis_diagnose::{Diagnosis, Wandering};

use crate::counts::summary;
use crate::iso_run::{Place, curve_um, places, table, values_um};
use crate::{found, generator, report};

const SIGMA_UM: f64 = 0.5;

/// What is lost at an instant, from 2 to 7 µm at the start by 3 to 8 µm more or less at the end.
struct Drive {
    first_um: f64,
    change_um: f64,
    /// Time constant, as a part of the table.
    constant: f64,
}

impl Drive {
    fn lost_um(&self, x: f64) -> f64 {
        self.first_um + self.change_um * (1.0 - (-x / self.constant).exp())
    }
}

/// On average, and from the start to the end.
struct Lost {
    mean_um: f64,
    change_um: f64,
}

/// A line of so many cycles, with a clock or in the order of measuring, and what was lost on average.
fn measured(seed: u64, cycles: u32, timed: bool) -> (Diagnosis, Lost) {
    let mut generator = generator(seed, 77);
    let drive = Drive {
        first_um: generator.random_range(2.0..7.0),
        change_um: generator.random_range(3.0..8.0)
            * if seed.is_multiple_of(2) { 1.0 } else { -1.0 },
        constant: generator.random_range(0.3..1.0),
    };
    // At one feed late readings would be the same.
    let places = places(cycles, &[0.0], &[2.0, 3.0]);
    let last_s = places.last().map_or(1.0, |place| place.time_s);
    let lost_um = |place: &Place| drive.lost_um(place.time_s / last_s);
    let behind = places.iter().map(|place| {
        let side = place.side();
        -0.5 * side * lost_um(place)
    });
    let behind: Vec<f64> = behind.collect();
    let curve = curve_um(&mut generator);
    let values = values_um(&places, &curve, &behind, SIGMA_UM, &mut generator);
    let mean_um = places.iter().map(lost_um).sum::<f64>() / places.len() as f64;
    let lost = Lost {
        mean_um,
        change_um: drive.change_um,
    };
    (found(table(&places, &values, timed)), lost)
}

/// Whether it is said that lost motion changes with time.
fn is_told(found: &Diagnosis) -> bool {
    let is_it = |whose: &Wandering| whose.varies_with == ["time", "direction"];
    let mut all = found.disturbances.iter();
    all.any(|own| is_it(&own.whose) || own.rivals.iter().any(is_it))
}

/// Whether its course rises.
fn rises(found: &Diagnosis) -> Option<bool> {
    let mut all = found.disturbances.iter();
    let own = all.find(|own| own.whose.varies_with == ["time", "direction"])?;
    let (first, last) = (own.curve.first()?, own.curve.last()?);
    Some(last.value_um[0] > first.value_um[0])
}

/// A mean above this has its name, µm: ten standard uncertainties or more.
const PLAIN_UM: f64 = 2.0;

/// In how many of how many tables it is told, and in how many of those with a mean to be named this has its name, inside three standard
/// uncertainties. The course rises where more and more is lost, and no other cause than lost motion has a name.
fn study(seeds: std::ops::Range<u64>) -> [usize; 4] {
    let (mut told, mut named, mut plain, mut all) = (0, 0, 0, 0);
    for seed in seeds {
        for cycles in [5, 8] {
            for timed in [false, true] {
                let (found, Lost { mean_um, change_um }) = measured(seed, cycles, timed);
                let line = format!("seed {seed}, {cycles}, {timed}: {}", summary(&found));
                let is_lost = |id: &str| id.contains("backlash");
                // With rivals it says that it may be something else.
                let alone = found.causes.iter().filter(|cause| cause.rivals.is_empty());
                let ids = alone.map(|cause| cause.effect.effect.id);
                let wrong: Vec<&str> = ids.filter(|id| !is_lost(id)).collect();
                assert!(wrong.is_empty(), "{line}");
                all += 1;
                told += usize::from(is_told(&found));
                let mut own = found.causes.iter();
                let own = own.find(|cause| is_lost(cause.effect.effect.id));
                let own = own.map(|cause| &cause.parameters[0]);
                let is_in = own.map(|b| (b.value - mean_um).abs() < 3.0 * b.u);
                let is_plain = mean_um.abs() > PLAIN_UM;
                plain += usize::from(is_plain);
                named += usize::from(is_plain && is_in == Some(true));
                assert!(
                    rises(&found).is_none_or(|up| up == (change_um > 0.0)),
                    "{line}"
                );
                if !is_told(&found) || is_in == Some(false) || is_plain && is_in.is_none() {
                    report(&format!("{line}; {mean_um:.2}"));
                }
            }
        }
    }
    report(&format!(
        "{told} of {all} told, {named} of {plain} plain means named and inside"
    ));
    [told, all, named, plain]
}

/// Of four tables all are told (in the study 236 of 240 were).
#[test]
fn lost_motion_that_changes_with_time_is_told() {
    let [told, all, named, plain] = study(0..1);
    assert_eq!((told, named), (all, plain));
    assert!(plain >= 2, "{plain}");
}

#[test]
#[ignore = "study: 240 diagnoses"]
fn lost_motion_that_changes_with_time_is_told_in_nineteen_of_twenty() {
    let [told, all, named, plain] = study(100..160);
    assert!(20 * told >= 19 * all && 20 * named >= 19 * plain);
}
