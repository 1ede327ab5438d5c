//! Two instruments read one motion, each with lost motion of its own.

use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};
use trueaxis_campaign::Verification;

use crate::iso_run::{Place, table};
use crate::{found_in, generator};

const STOPS: usize = 9;
const STEP_MM: f64 = 5.0;
const LATE_S: f64 = -1.9;

/// Five cycles at a feed that varies by 1 %, from stop to stop.
fn places(generator: &mut impl RngExt) -> Vec<Place> {
    let mut places = Vec::new();
    let mut time_s = 0.0;
    for pass in 0..10 {
        let forward = pass % 2 == 0;
        for k in 0..STOPS {
            let step = if forward { k } else { STOPS - 1 - k };
            places.push(Place {
                time_s,
                cycle: pass / 2 + 1,
                forward,
                step,
                x_mm: STEP_MM * step as f64,
                parked: 0,
                y_mm: 0.0,
                speed: 0.0,
            });
            time_s += 28.5 + 0.2 * f64::from(generator.random_range(-1_i32..=1));
        }
        time_s -= 12.0;
    }
    places
}

/// Speed at each place with sign, of a straight line through its neighbours in the same pass, mm/s.
fn speeds(places: &[Place]) -> Vec<f64> {
    let speed = |i: usize| {
        let first = i / STOPS * STOPS;
        let from = &places[i.max(first + 1) - 1];
        let to = &places[(i + 1).min(first + STOPS - 1)];
        (to.x_mm - from.x_mm) / (to.time_s - from.time_s)
    };
    (0..places.len()).map(speed).collect()
}

/// Both read what varies with the feed as late time stamps would show it, without what is the same on each side. An offset of two seconds
/// and lost motion of -640 and -670 µm took each other away but for the 37 and 9 µm that are there.
#[test]
fn lost_motion_of_each_and_late_readings_of_both_do_not_take_each_other_away() {
    for seed in 0..4 {
        let mut generator = generator(seed, 92);
        let places = places(&mut generator);
        let speeds = speeds(&places);
        let mean = speeds.iter().map(|v| v.abs()).sum::<f64>() / speeds.len() as f64;
        let mut read_by = |name: &str, lost_um: f64, noise_um: f64| {
            let values = places.iter().zip(&speeds).map(|(place, speed)| {
                let side = place.side();
                let noise: f64 = StandardNormal.sample(&mut generator);
                1e3 * LATE_S * (speed - side * mean) - 0.5 * side * lost_um + noise_um * noise
            });
            let values: Vec<f64> = values.collect();
            Verification {
                name: name.into(),
                ..table(&places, &values, true)
            }
        };
        let both = vec![read_by("laser", 37.0, 2.0), read_by("resolver", 9.3, 1.3)];
        let found = found_in(both);
        assert!(!found.causes.is_empty(), "seed {seed}");
        for cause in &found.causes {
            let size = &cause.parameters[0];
            let most = match cause.effect.effect.id {
                "timestamp_offset" => 300.0,
                _ => 60.0,
            };
            assert!(size.value.abs() < most, "seed {seed}: {size:?}");
        }
    }
}
