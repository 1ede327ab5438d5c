//! A run after ISO 230-2: cycles there and back over one line or several.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use trueaxis_campaign::{Direction, Verification, VerificationKind, VerificationReading};

/// One reading to come.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Place {
    pub(crate) time_s: f64,
    pub(crate) cycle: u32,
    pub(crate) forward: bool,
    /// Number of the position along the line.
    pub(crate) step: usize,
    pub(crate) x_mm: f64,
    /// Number of the line.
    pub(crate) parked: usize,
    /// Where Y is parked.
    pub(crate) y_mm: f64,
    /// Speed with sign, mm/s.
    pub(crate) speed: f64,
}

impl Place {
    /// From below +1, from above -1.
    pub(crate) fn side(&self) -> f64 {
        if self.forward { 1.0 } else { -1.0 }
    }
}

pub(crate) const POSITIONS: usize = 21;
pub(crate) const TARGET_MM: [f64; 3] = [100.0, 300.0, 200.0];
const STEP_MM: f64 = 20.0;

/// Where and when: cycles there and back at `speeds` (one after the other), for each parked position.
pub(crate) fn places(cycles: u32, parked_mm: &[f64], speeds: &[f64]) -> Vec<Place> {
    let mut places = Vec::new();
    let mut time_s = 0.0;
    let mut cycle = 0;
    for (parked, &y_mm) in parked_mm.iter().enumerate() {
        for k in 0..cycles {
            cycle += 1;
            let speed = speeds[k as usize % speeds.len()];
            for forward in [true, false] {
                for i in 0..POSITIONS {
                    let i = if forward { i } else { POSITIONS - 1 - i };
                    let x_mm = STEP_MM * i as f64;
                    places.push(Place {
                        time_s,
                        cycle,
                        forward,
                        step: i,
                        x_mm,
                        parked,
                        y_mm,
                        speed: if forward { speed } else { -speed },
                    });
                    time_s += STEP_MM / speed;
                }
                time_s += 15.0;
            }
        }
    }
    places
}

/// Seconds from one reading to the next of [`there_and_back`].
pub(crate) const STOP_S: f64 = 10.0;
/// Positions of it.
pub(crate) const STOPS: usize = 11;

/// Cycles there and back over so many millimetres with a pause after each, with a clock or in the order of measuring; what is
/// read at each place.
pub(crate) fn there_and_back(
    (cycles, range_mm, timed): (u32, f64, bool),
    pause_s: f64,
    read_um: &mut dyn FnMut(&Place) -> f64,
) -> Verification {
    let mut places = Vec::new();
    for row in 0..2 * STOPS * cycles as usize {
        let (pass, k) = (row / STOPS, row % STOPS);
        let forward = pass % 2 == 0;
        let step = if forward { k } else { STOPS - 1 - k };
        places.push(Place {
            time_s: STOP_S * row as f64 + pause_s * (pass / 2) as f64,
            cycle: 1 + u32::try_from(pass / 2).unwrap(),
            forward,
            step,
            x_mm: range_mm * step as f64 / (STOPS - 1) as f64,
            parked: 0,
            y_mm: 0.0,
            speed: 0.0,
        });
    }
    let values: Vec<f64> = places.iter().map(read_um).collect();
    table(&places, &values, timed)
}

/// A positioning curve: bends and bumps, µm.
pub(crate) fn curve_um(generator: &mut ChaCha8Rng) -> Vec<f64> {
    let [scale, bow, wave]: [f64; 3] = std::array::from_fn(|_| generator.random_range(-4.0..4.0));
    (0..POSITIONS)
        .map(|i| {
            let x = i as f64 / (POSITIONS - 1) as f64;
            let local: f64 = StandardNormal.sample(generator);
            scale * x + bow * x * x + wave * (7.0 * x).sin() + 0.5 * local
        })
        .collect()
}

/// The values of the readings: curve, disturbance and noise, µm.
pub(crate) fn values_um(
    places: &[Place],
    curve_um: &[f64],
    disturbance_um: &[f64],
    sigma_um: f64,
    generator: &mut ChaCha8Rng,
) -> Vec<f64> {
    let rows = places.iter().zip(disturbance_um);
    rows.map(|(place, disturbance)| {
        let noise: f64 = StandardNormal.sample(generator);
        curve_um[place.step] + disturbance + sigma_um * noise
    })
    .collect()
}

/// The table.
pub(crate) fn table(places: &[Place], values_um: &[f64], timed: bool) -> Verification {
    let rows = places.iter().zip(values_um).enumerate();
    let readings = rows.map(|(row, (place, &value_um))| VerificationReading {
        time_s: timed.then_some(place.time_s),
        cycle: place.cycle,
        direction: if place.forward {
            Direction::Forward
        } else {
            Direction::Backward
        },
        positions: vec![place.x_mm, place.y_mm, 0.0],
        value_um,
        line: row + 2,
    });
    Verification {
        name: "LI along X".into(),
        kind: VerificationKind::Positioning {
            axis: 0,
            target_mm: TARGET_MM.into(),
        },
        u_um: None,
        u_ppm: None,
        readings: readings.collect(),
    }
}

/// What the mean curve, and the zero of each line, leave of a trace; by sweeping means to and fro.
pub(crate) fn beyond_the_mean_curve(places: &[Place], trace: &[f64]) -> Vec<f64> {
    let mut left = trace.to_vec();
    let by_x = |p: &Place| p.step;
    let by_y = |p: &Place| p.parked;
    for _ in 0..20 {
        take_means(places, &mut left, by_x);
        take_means(places, &mut left, by_y);
    }
    left
}

fn take_means(places: &[Place], x: &mut [f64], key: impl Fn(&Place) -> usize) {
    let mut sums = std::collections::BTreeMap::<usize, (f64, f64)>::new();
    for (place, x) in places.iter().zip(x.iter()) {
        let sum = sums.entry(key(place)).or_default();
        *sum = (sum.0 + x, sum.1 + 1.0);
    }
    for (place, x) in places.iter().zip(x.iter_mut()) {
        let sum = sums[&key(place)];
        *x -= sum.0 / sum.1;
    }
}

/// Cycles there and back over stops 50 mm apart, without times: `value_um(row, forward, stop)`.
pub(crate) fn table_of_stops(
    cycles: u32,
    stops: usize,
    value_um: &mut dyn FnMut(usize, bool, usize) -> f64,
) -> Verification {
    let mut places = Vec::new();
    let mut values = Vec::new();
    for cycle in 1..=cycles {
        let there = (0..stops).map(|stop| (true, stop));
        let back = (0..stops).rev().map(|stop| (false, stop));
        for (forward, step) in there.chain(back) {
            values.push(value_um(places.len(), forward, step));
            places.push(Place {
                time_s: 0.0,
                cycle,
                forward,
                step,
                x_mm: 50.0 * step as f64,
                parked: 0,
                y_mm: 0.0,
                speed: 0.0,
            });
        }
    }
    table(&places, &values, false)
}
