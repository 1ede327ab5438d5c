//! Problems for benchmarks and peers: campaigns of the paper's three-axis machine with more or fewer steps.

mod adjust;

use trueaxis_campaign::Campaign;
use trueaxis_simulate::{Scenario, StationSpec, simulate};

pub use adjust::{Model, Problem, Solved};

/// Name, stations, steps: three targets at each, once from every station.
pub const SIZES: [(&str, usize, usize); 4] = [
    ("P-A", 4, 65),
    ("P-B", 4, 650),
    ("P-C", 4, 33_333),
    ("P-D", 8, 33_333),
];

/// Where the tracker stands beside the four stations of the scenario, and its dead paths, mm.
const MORE_STATIONS: [([f64; 3], f64); 4] = [
    ([1700.0, 800.0, 1300.0], 1234.0),
    ([-900.0, 700.0, 200.0], 1567.0),
    ([300.0, -1100.0, 900.0], 1089.0),
    ([500.0, 1900.0, 700.0], 1410.0),
];

const SEED: u64 = 1;

/// The scenario of the shipped three-axis campaign: 2,340 lengths in three repeats.
///
/// # Panics
/// If the file does not hold a scenario.
pub fn fxyz() -> Scenario {
    let text = include_str!("../../campaigns/fxyz/scenario.json");
    Scenario::from_json(text).expect("a scenario")
}

/// One repeat of it with other numbers of stations (at most eight) and steps, evenly spaced over the three axes.
pub fn scenario(stations: usize, steps: usize) -> Scenario {
    let mut scenario = fxyz();
    scenario.repeats = 1;
    let more = MORE_STATIONS
        .iter()
        .zip(5..)
        .map(|(&(position_mm, dead_path_mm), i)| StationSpec {
            name: format!("S{i}"),
            position_mm,
            dead_path_mm,
            declare_approx: false,
            dead_path_sigma_mm: None,
        });
    scenario.stations.extend(more);
    scenario.stations.truncate(stations);
    let runs = scenario.runs.len();
    for (i, run) in scenario.runs.iter_mut().enumerate() {
        let last = steps / runs + usize::from(i < steps % runs) - 1;
        let stop = run.sweep.take().map_or(0.0, |sweep| sweep.stop);
        run.positions = Some((0..=last).map(|k| stop * k as f64 / last as f64).collect());
    }
    scenario
}

/// The lengths of a scenario, with errors drawn.
///
/// # Panics
/// If the scenario contradicts itself.
pub fn measured(scenario: &Scenario) -> Campaign {
    simulate(scenario, SEED).expect("a campaign").campaign
}

/// The problem of this name among [`SIZES`].
///
/// # Panics
/// If there is none, or it cannot be solved.
pub fn problem(name: &str) -> Problem {
    let size = SIZES.iter().find(|(known, ..)| *known == name);
    let &(_, stations, steps) = size.expect("a name of SIZES");
    Problem::of(&measured(&scenario(stations, steps)))
}
