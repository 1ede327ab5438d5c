//! A wrong length and an interrupted beam among lengths to 60 points.

#![expect(clippy::print_stdout, reason = "an example shows its result")]

use nalgebra::Point3;
use trueaxis_multilateration::{Network, Reading, Visit};
use trueaxis_screening::screen;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let stations = [
        Point3::new(1500.0, 200.0, 900.0),
        Point3::new(-700.0, 1200.0, 300.0),
        Point3::new(-400.0, -900.0, 1200.0),
        Point3::new(900.0, -800.0, -100.0),
        Point3::new(400.0, 1700.0, 1500.0),
        Point3::new(1300.0, 1300.0, 100.0),
    ];
    let mut network = Network {
        stations: vec![None; stations.len()],
        ..Network::default()
    };
    for i in 0..60_u32 {
        let grid = |d: u32| f64::from(i / d % 4) * 100.0;
        let nominal_mm = Point3::new(grid(1), grid(4), grid(16));
        network.nominal_mm.push(nominal_mm);
        network.groups.push(i as usize..i as usize + 1);
    }
    for (station, position_mm) in stations.iter().enumerate() {
        for (group, point_mm) in network.nominal_mm.iter().enumerate() {
            let reading = network.readings.len();
            // Errors of a micrometre, as the noise of the network says.
            let error_mm = 1.4e-3 * (reading as f64 * 2.3).sin();
            let length_mm = (point_mm - position_mm).norm() + error_mm;
            network.readings.push(Reading {
                point: 0,
                length_mm,
            });
            network.visits.push(Visit {
                station,
                group,
                readings: reading..reading + 1,
            });
        }
    }
    network.readings[17].length_mm += 0.05;
    let of_station_3 = 3 * 60..4 * 60;
    for reading in &mut network.readings[of_station_3][25..] {
        reading.length_mm -= 0.2;
    }

    let screened = screen(&network, true)?;
    let [removed] = screened.removed[..] else {
        return Err("one length is wrong".into());
    };
    assert_eq!(removed.reading, 17);
    let [jump] = screened.jumps[..] else {
        return Err("one beam was interrupted".into());
    };
    assert_eq!((jump.station, jump.first_reading), (3, 3 * 60 + 25));
    assert!((jump.change_mm + 0.2).abs() < 4.0 * jump.u_mm);
    println!(
        "reading {} is {:.4} mm off; station {} jumped by {:.4} mm",
        removed.reading, removed.error_mm, jump.station, jump.change_mm
    );
    Ok(())
}
