//! Points, stations and dead paths from lengths to 27 points.

#![expect(clippy::print_stdout, reason = "an example shows its result")]

use nalgebra::Point3;
use trueaxis_multilateration::{Network, Reading, Visit, solve};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let truth = [
        (Point3::new(1500.0, 200.0, 900.0), 12.0), // station, dead path
        (Point3::new(-700.0, 1200.0, 300.0), 34.0),
        (Point3::new(-400.0, -900.0, 1200.0), 56.0),
        (Point3::new(900.0, -800.0, -100.0), 78.0),
    ];
    let mut network = Network {
        stations: vec![None; 4],
        ..Network::default()
    };
    for i in 0..27 {
        let grid = |d: i32| f64::from(i / d % 3) * 200.0;
        network
            .nominal_mm
            .push(Point3::new(grid(1), grid(3), grid(9)));
        network.groups.push(i as usize..i as usize + 1);
    }
    for (group, point) in network.nominal_mm.clone().iter().enumerate() {
        for (station, (position, dead_path)) in truth.iter().enumerate() {
            let length_mm = (point - position).norm() - dead_path;
            let next = network.readings.len();
            network.readings.push(Reading {
                point: 0,
                length_mm,
            });
            network.visits.push(Visit {
                station,
                group,
                readings: next..next + 1,
            });
        }
    }
    let solution = solve(&network)?;
    assert!((solution.stations[2].position_mm - truth[2].0).norm() < 1e-6);
    assert!((solution.stations[2].dead_path_mm - 56.0).abs() < 1e-6);
    assert_eq!(solution.degrees_of_freedom(), 108 - (81 + 16 - 6));
    println!("station 2 at {:.4} mm", solution.stations[2].position_mm);
    Ok(())
}
