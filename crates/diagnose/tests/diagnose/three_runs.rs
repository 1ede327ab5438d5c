//! Points of three targets on the stage, at 21 positions of each of three linear axes.

use nalgebra::Point3;
use trueaxis_campaign::{Campaign, Direction, PointReading, Points, Run, Step, Stop, Target};

use crate::campaign;

const HOMES_MM: [[f64; 3]; 3] = [
    [20.0, 450.0, 120.0],
    [160.0, 330.0, 320.0],
    [250.0, 600.0, 410.0],
];

/// The axes that stand are at `parked_mm`; `point_mm` is where a target is found, from the positions and its place at home.
pub(crate) fn three_runs(
    parked_mm: [f64; 3],
    sigma_um: f64,
    mut point_mm: impl FnMut(&[f64], [f64; 3]) -> Point3<f64>,
) -> Campaign {
    let mut all = campaign(Vec::new());
    let targets = ["P", "Q", "K"].iter().zip(HOMES_MM);
    let targets = targets.map(|(name, home)| Target {
        name: (*name).into(),
        home_mm: home.into(),
        carrier: Some(2),
        ..Target::default()
    });
    all.targets = targets.collect();
    let (mut stops, mut readings) = (Vec::new(), Vec::new());
    for axis in 0..3 {
        all.runs.push(Run {
            name: ["x", "y", "z"][axis].into(),
            axis,
        });
        for i in 0..21 {
            let mut positions = parked_mm.to_vec();
            positions[axis] = 20.0 * f64::from(i);
            let first = readings.len();
            for (target, home) in HOMES_MM.into_iter().enumerate() {
                readings.push(PointReading {
                    time_s: readings.len() as f64,
                    target,
                    position_mm: point_mm(&positions, home),
                    sigma_um: Some(sigma_um),
                    line: readings.len() + 2,
                });
            }
            stops.push(Stop {
                station: 0,
                repeat: 1,
                step: all.steps.len(),
                direction: Direction::Forward,
                readings: first..readings.len(),
            });
            all.steps.push(Step {
                run: Some(axis),
                positions,
            });
        }
    }
    all.points = Some(Points { stops, readings });
    all
}
