//! Corrections and tables against the exact truth of the simulator.

#![expect(
    clippy::print_stdout,
    reason = "the figures of a test are worth reading"
)]

mod by_hand;
mod controllers;
mod export;
mod import;
mod inverse;
mod iso_230_2;
mod levers;
mod onto;
mod parallel_lines;
mod point_checks;
mod remains;
mod single_lines;
mod verify;

use nalgebra::Point3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use trueaxis_calibrate::{Settings, calibrate};
use trueaxis_compensate::{Error, Export, Format, Request, TableSign};
use trueaxis_predict::CalibratedMachine;
use trueaxis_simulate::{Scenario, simulate};

const THREE_AXES: &str = include_str!("../../../../campaigns/fxyz/scenario.json");
const FIVE_AXES: &str = include_str!("../../../../campaigns/five-axis/scenario.json");
const TABLE: &str = include_str!("../../../../campaigns/rotary-stage/scenario.json");

/// The point of the paper's positioning lines.
fn tool() -> Point3<f64> {
    Point3::new(175.6, 497.5, 312.1)
}

/// All tables of a machine for that point.
fn request(machine: &CalibratedMachine) -> Request<'_> {
    Request {
        format: Format::Grid,
        machine,
        at: tool(),
        axis: None,
        step: None,
        sign: None,
        levers: false,
        onto: &[],
    }
}

/// The tables of that request in a format.
fn export(format: Format, request: &Request<'_>) -> Result<Export, Error> {
    trueaxis_compensate::export(&Request { format, ..*request })
}

/// The same for a format, with a sign if it wants one.
fn request_of(format: Format, machine: &CalibratedMachine) -> Request<'_> {
    Request {
        sign: (format == Format::Heidenhain).then_some(TableSign::Error),
        ..request(machine)
    }
}

fn scenario(text: &str) -> Scenario {
    Scenario::from_json(text).unwrap()
}

/// The machine of a scenario as one campaign measures it, the sides of approach apart or not.
fn calibrated(scenario: &Scenario, by_direction: bool) -> CalibratedMachine {
    let mut settings = Settings::default();
    settings.poses.by_direction = by_direction;
    calibrated_with(scenario, &settings)
}

fn calibrated_with(scenario: &Scenario, settings: &Settings) -> CalibratedMachine {
    let simulated = simulate(scenario, 1).unwrap();
    let calibration = calibrate(&simulated.campaign, settings).unwrap();
    calibration.calibrated_machine()
}

/// Positions of all axes at random, inside what was measured.
fn poses(machine: &CalibratedMachine, count: usize) -> Vec<Vec<f64>> {
    let mut rng = ChaCha8Rng::seed_from_u64(17);
    let ranges: Vec<[f64; 2]> = (0..machine.machine().axes().len())
        .map(|axis| {
            let steps = machine.steps(axis);
            [steps[0], steps[steps.len() - 1]]
        })
        .collect();
    let mut pose = || {
        let at = |range: &[f64; 2]| range[0] + (range[1] - range[0]) * rng.random::<f64>();
        ranges.iter().map(at).collect()
    };
    (0..count).map(|_| pose()).collect()
}
