//! Measured deviations of the tool at single places against what a calibration predicts.
//!
//! A deviation is the displacement that [`CalibratedMachine::predict`] gives. Where the instrument, or the artefact on the
//! table, has its zero and how the tool was set is not the machine's: each point of the tool leaves a constant of each coordinate open.

use nalgebra::{DMatrix, Point3};
use trueaxis_campaign::PointCheck;
use trueaxis_kinematics::{Ideal, MICROMETRE};
use trueaxis_predict::CalibratedMachine;

use crate::verify::{Checked, Point, SAME, Verified, are_same, judge, u_of_length_um};
use crate::{Error, Moved, correct};

/// All readings of a place: commanded positions of all axes and the point of the tool at home.
struct Place<'a> {
    positions: &'a [f64],
    tool_home_mm: Point3<f64>,
    /// Of each coordinate the number of readings and their mean.
    readings: [(usize, f64); 3],
}

/// A point check against its prediction.
pub(crate) fn verified_points(
    machine: &CalibratedMachine,
    check: &PointCheck,
    is_compensated: bool,
) -> Result<Verified, Error> {
    let nominal = machine.machine();
    let places = places(check, machine.reference_point_mm());
    let mut points = Vec::new();
    let mut measured = Vec::new();
    for (number, place) in places.iter().enumerate() {
        let (positions, tool_home_mm) = (place.positions, place.tool_home_mm);
        let error = nominal.tool_error(machine, positions, tool_home_mm);
        let predicted = error.translation_mm;
        let corrected = correct(nominal, machine, positions, tool_home_mm, Moved::Linear)?;
        let commanded = nominal.tool_in_workpiece(&Ideal, positions) * tool_home_mm;
        let from_home_mm = (commanded - tool_home_mm).norm();
        for (coordinate, &(readings, mean_um)) in place.readings.iter().enumerate() {
            if readings == 0 {
                continue;
            }
            measured.push(3 * number + coordinate);
            let predicted_um = predicted[coordinate] / MICROMETRE;
            points.push(Point {
                checked: Some(Checked {
                    tool_home_mm,
                    coordinate,
                }),
                readings,
                predicted_um,
                first_order_um: predicted_um,
                compensated_um: corrected.left.translation_mm[coordinate] / MICROMETRE,
                u_reading_um: u_of_length_um(check.u_um, check.u_ppm, from_home_mm),
                ..Point::new(positions, mean_um)
            });
        }
    }
    let of_places: Vec<_> = places
        .iter()
        .map(|p| (p.positions, p.tool_home_mm))
        .collect();
    let covariance = machine.covariance_of_displacements(&of_places);
    let covariance = covariance.select_rows(&measured).select_columns(&measured);
    let set_up = zeros(&points);
    let p_value = judge(machine, &mut points, &covariance, &set_up, is_compensated);
    Ok(Verified {
        name: check.name.clone(),
        kind: None,
        points,
        positioning: Vec::new(),
        circular: None,
        p_value,
    })
}

/// In the order in which they first occur.
fn places(check: &PointCheck, reference_mm: Point3<f64>) -> Vec<Place<'_>> {
    let mut places: Vec<Place<'_>> = Vec::new();
    for reading in &check.readings {
        let tool_home_mm = reading.tool_home_mm.unwrap_or(reference_mm);
        let is_same = |place: &Place<'_>| {
            are_same(place.positions, &reading.positions)
                && are_one(&place.tool_home_mm, &tool_home_mm)
        };
        let number = places.iter().position(is_same).unwrap_or_else(|| {
            places.push(Place {
                positions: &reading.positions,
                tool_home_mm,
                readings: [(0, 0.0); 3],
            });
            places.len() - 1
        });
        for ((readings, mean), value) in
            places[number].readings.iter_mut().zip(reading.deviation_um)
        {
            if let Some(value) = value {
                *readings += 1;
                *mean += (value - *mean) / *readings as f64;
            }
        }
    }
    places
}

/// A column for the zero of each coordinate with each point of the tool.
fn zeros(points: &[Point]) -> DMatrix<f64> {
    let mut zeros: Vec<Checked> = Vec::new();
    let numbers: Vec<usize> = points
        .iter()
        .filter_map(|point| point.checked)
        .map(|own| {
            let is_own = |zero: &Checked| {
                zero.coordinate == own.coordinate && are_one(&zero.tool_home_mm, &own.tool_home_mm)
            };
            zeros.iter().position(is_own).unwrap_or_else(|| {
                zeros.push(own);
                zeros.len() - 1
            })
        })
        .collect();
    DMatrix::from_fn(points.len(), zeros.len(), |row, column| {
        f64::from(u8::from(numbers[row] == column))
    })
}

fn are_one(a: &Point3<f64>, b: &Point3<f64>) -> bool {
    (a - b).norm() <= SAME
}
