//! Readings of the shipped five-axis machine: lines of X, Y and Z as on three axes, of A and C with the reflector on the table
//! (arc lengths), a ball bar on the tool and one on the table, and places of the tool with all axes moving.

use nalgebra::{Isometry3, Point3, Rotation3, UnitQuaternion, Vector3};
use trueaxis_campaign::{
    Campaign, Direction, PointCheck, PointCheckReading, Verification, VerificationKind,
};
use trueaxis_compensate::Error;
use trueaxis_kinematics::{GeometricErrors, Ideal, MICROMETRE};
use trueaxis_simulate::TrueMachine;

use super::{CENTRE_MM, INSTRUMENT_UM, REPEATABILITY_UM, Readings, SIDES, Stand, TOOL, U_UM};
use super::{circle, line, readings_alone};

/// A point of the tool, and one on the table, at home.
const TOOL_MM: [f64; 3] = [110.0, 95.0, 450.0];
const TABLE_MM: [f64; 3] = [312.0, 186.0, 120.0];

/// The outermost axis of the workpiece, and the one that carries it.
const C: usize = 4;
const A: usize = 3;

/// A point on each, mm.
const ON_A_MM: [f64; 3] = [0.0, 200.0, 40.0];
const ON_C_MM: [f64; 3] = [200.0, 200.0, 0.0];

/// The campaign with readings alone, under another name.
///
/// # Errors
/// None: nothing is compensated.
pub fn five_axis_readings(
    campaign: &Campaign,
    truth: &TrueMachine,
    name: &str,
) -> Result<Campaign, Error> {
    let mut readings = Readings::new(truth, None, 2029);
    let tool_mm = Point3::from(TOOL_MM);
    let mut all = Vec::new();
    for (axis, letter) in ["X", "Y", "Z"].into_iter().enumerate() {
        let kind = VerificationKind::Positioning {
            axis,
            target_mm: tool_mm,
        };
        let stands = with_table_at_home(line(axis));
        all.push(readings.of(&format!("LI along {letter}"), kind, &stands)?);
    }
    all.push(arc(&mut readings, "LI about A", A, ON_A_MM)?);
    all.push(arc(&mut readings, "LI about C", C, ON_C_MM)?);
    let kind = VerificationKind::Ballbar {
        ball_mm: tool_mm,
        ball_carrier: TOOL,
        center_mm: tool_mm + Vector3::from(CENTRE_MM),
        length_is_calibrated: false,
    };
    all.push(readings.of("DBB in XY", kind, &with_table_at_home(circle()))?);
    all.push(bar_on_the_table(&mut readings)?);
    Ok(Campaign {
        point_checks: vec![ball_plate(&mut readings)],
        ..readings_alone(campaign, all, name)
    })
}

fn with_table_at_home(stands: Vec<Stand>) -> Vec<Stand> {
    let wider = stands.into_iter().map(|(cycle, direction, mut positions)| {
        positions.extend([0.0, 0.0]);
        (cycle, direction, positions)
    });
    wider.collect()
}

/// 13 positions of A from -90° to 90°, or of C over a turn, five runs from each side.
fn turns(axis: usize) -> Vec<Stand> {
    let [first, step] = if axis == A {
        [-90.0, 15.0]
    } else {
        [0.0, 30.0]
    };
    let mut stands = Vec::new();
    for cycle in 1..=5 {
        for direction in SIDES {
            for k in 0..=12 {
                let k = if direction == Direction::Forward {
                    k
                } else {
                    12 - k
                };
                let mut positions = vec![0.0; 5];
                positions[axis] = (first + step * f64::from(k)).to_radians();
                stands.push((cycle, direction, positions));
            }
        }
    }
    stands
}

/// By which arc a reflector on the table is farther than commanded, seen along the tangent.
fn arc(
    readings: &mut Readings<'_>,
    name: &str,
    axis: usize,
    on_axis_mm: [f64; 3],
) -> Result<Verification, Error> {
    let target_mm = Point3::from(TABLE_MM);
    let kind = VerificationKind::Positioning { axis, target_mm };
    readings.with(name, kind, &turns(axis), |readings, _, commanded| {
        let along = if axis == A {
            Vector3::x_axis()
        } else {
            Vector3::z_axis()
        };
        let lever = Rotation3::from_axis_angle(&along, commanded[axis])
            * (target_mm - Point3::from(on_axis_mm));
        let wanted = Point3::from(on_axis_mm) + lever;
        let tangent = along.cross(&lever).normalize();
        let machine = readings.truth.machine();
        let actual = machine.position(readings.truth, C, commanded, target_mm);
        Ok(tangent.dot(&(actual - wanted)) / MICROMETRE)
    })
}

/// A ball on the table that turns about C, and the other on the axis above it.
fn bar_on_the_table(readings: &mut Readings<'_>) -> Result<Verification, Error> {
    let ball_mm = Point3::from(TABLE_MM);
    let center_mm = Point3::new(ON_C_MM[0], ON_C_MM[1], TABLE_MM[2]);
    let kind = VerificationKind::Ballbar {
        ball_mm,
        ball_carrier: C,
        center_mm,
        length_is_calibrated: false,
    };
    readings.with(
        "DBB on the table",
        kind,
        &turns(C),
        |readings, set_up_mm, commanded| {
            let machine = readings.truth.machine();
            let actual = machine.position(readings.truth, C, commanded, ball_mm);
            // However the table turns, the ball is as far from its axis.
            let wanted = (ball_mm - center_mm).norm();
            Ok(((actual - (center_mm + set_up_mm)).norm() - wanted) / MICROMETRE)
        },
    )
}

/// 36 places with all axes moving, by the golden ratio; every third is measured along z alone.
fn ball_plate(readings: &mut Readings<'_>) -> PointCheck {
    let zero_um = Vector3::from_fn(|_, _| 5.0 * readings.deviate());
    let tool_home_mm = Point3::from(TOOL_MM);
    let places = (0..36).map(|k| {
        let share = |i: i32| (f64::from(k) * 0.5_f64.sqrt() * (f64::from(i) + 1.618)).fract();
        let degrees = |x: f64| x.round().to_radians();
        let [x, y, z] = [0, 1, 2].map(|i| (400.0 * share(i)).round());
        let positions = vec![
            x,
            y,
            z,
            degrees(160.0 * share(3) - 80.0),
            degrees(360.0 * share(4)),
        ];
        let truth = readings.truth;
        let actual = seen_from_the_table(truth, truth, &positions, tool_home_mm);
        let wanted = seen_from_the_table(truth, &Ideal, &positions, tool_home_mm);
        let exact_um = (actual - wanted) / MICROMETRE + zero_um;
        let deviation_um = [0, 1, 2].map(|c| {
            let noise_um =
                INSTRUMENT_UM * readings.deviate() + REPEATABILITY_UM * readings.deviate();
            let value = ((exact_um[c] + noise_um) * 1e3).round() / 1e3;
            (c == 2 || k % 3 != 2).then_some(value)
        });
        PointCheckReading {
            time_s: None,
            cycle: None,
            positions,
            tool_home_mm: Some(tool_home_mm),
            deviation_um,
            line: usize::try_from(k).unwrap_or_default() + 2,
        }
    });
    PointCheck {
        name: "places of the tool".to_owned(),
        u_um: Some(U_UM),
        u_ppm: None,
        readings: places.collect(),
    }
}

/// The point of the tool as an observer on the table sees it, from where three marks on the table are, mm.
fn seen_from_the_table(
    truth: &TrueMachine,
    errors: &impl GeometricErrors,
    positions: &[f64],
    tool_home_mm: Point3<f64>,
) -> Point3<f64> {
    let machine = truth.machine();
    let mark = |home: Point3<f64>| machine.position(errors, C, positions, home);
    let origin = mark(Point3::origin());
    let [x, y] = [Vector3::x(), Vector3::y()].map(|along| mark(Point3::from(along)) - origin);
    let turned = Rotation3::from_basis_unchecked(&[x, y, x.cross(&y)]);
    let table = Isometry3::from_parts(origin.into(), UnitQuaternion::from_rotation_matrix(&turned));
    table.inverse() * machine.position(errors, TOOL, positions, tool_home_mm)
}
