//! What the shape of the three targets gives away.

use nalgebra::{Point3, Rotation3, Vector3};
use trueaxis_calibrate::{Settings, calibrate};
use trueaxis_campaign::{
    Campaign, Direction, Instrument, PointReading, Points, Run, Step, Stop, Target,
};
use trueaxis_kinematics::{Axis, Machine};
use trueaxis_simulate::{Scenario, simulate};

use crate::round_trip::SHIPPED;

/// Section 5.2 of the paper prints the targets in two frames that contradict each other by up to
/// 157 µm. A campaign with the stage coordinates as nominal and points that follow the tracker
/// coordinates is calibrated, and the contradiction is reported side by side.
#[test]
fn contradictory_coordinates_of_the_paper_are_noticed() {
    let in_tracker = [
        [1005.6648, -140.3849, -222.6797],
        [1240.2676, -187.6319, -183.0147],
        [1136.3720, -386.5078, -207.4099],
    ]
    .map(Point3::from);
    let in_stage = [
        [-105.8046, 135.3414, 0.0],
        [128.8513, 87.8158, 39.9797],
        [24.9026, -110.8575, 15.2662],
    ];
    let axis = Vector3::new(1111.44, -275.63, -222.73);
    let machine = Machine::new(
        vec![Axis::rotary("C", Vector3::z(), [0.0, 6.3], Point3::origin()).unwrap()],
        vec![],
        vec![0],
    )
    .unwrap();
    let mut campaign = Campaign {
        name: "rotary stage of the paper".to_owned(),
        date: None,
        operator: None,
        machine_name: "rotary stage".to_owned(),
        machine,
        expansions: Vec::new(),
        instrument: Instrument::default(),
        targets: ["P", "Q", "K"]
            .iter()
            .zip(in_stage)
            .map(|(name, home)| Target {
                name: (*name).to_owned(),
                home_mm: Point3::from(home),
                carrier: Some(0),
                ..Target::default()
            })
            .collect(),
        stations: Vec::new(),
        known_lengths: Vec::new(),
        runs: vec![Run {
            name: "c".to_owned(),
            axis: 0,
        }],
        steps: Vec::new(),
        lengths: None,
        points: None,
        verification: Vec::new(),
        point_checks: Vec::new(),
        notices: Vec::new(),
    };
    let mut points = Points::default();
    for k in 0..18_u32 {
        let angle = f64::from(20 * k).to_radians();
        let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), angle);
        let first = points.readings.len();
        for (target, p) in in_tracker.iter().enumerate() {
            let position_mm = Point3::from(axis + turn * (p.coords - axis));
            points.readings.push(PointReading {
                time_s: f64::from(k),
                target,
                position_mm,
                sigma_um: Some(1.0),
                line: first + target + 2,
            });
        }
        campaign.steps.push(Step {
            run: Some(0),
            positions: vec![angle],
        });
        points.stops.push(Stop {
            station: 0,
            repeat: 1,
            step: campaign.steps.len() - 1,
            direction: Direction::Forward,
            readings: first..first + 3,
        });
    }
    campaign.points = Some(points);
    let calibration = calibrate(&campaign, &Settings::default()).unwrap();
    let differences: Vec<(String, f64)> = calibration
        .triangle
        .iter()
        .map(|side| {
            (
                side.targets.concat(),
                (side.nominal_mm - side.measured_mm) * 1e3,
            )
        })
        .collect();
    let expected = [("PQ", 157.0), ("PK", 67.0), ("QK", -119.0)];
    assert_eq!(differences.len(), 3, "{differences:?}");
    for ((sides, um), (name, expected)) in differences.iter().zip(expected) {
        assert_eq!(sides, name);
        assert!((um - expected).abs() < 0.5, "{name}: {um}");
    }
    // The triangle moves rigidly, so nothing is wrong with single steps.
    assert!(calibration.misfits.is_empty());
}

/// A target that is read 20 µm off at one step from every station: that step is named, no other.
#[test]
fn a_step_that_is_no_rigid_triangle_is_named() {
    let (_, fxyz) = SHIPPED[0];
    let scenario = Scenario::from_json(fxyz).unwrap();
    let mut simulated = simulate(&scenario, 3).unwrap();
    let clean = calibrate(&simulated.campaign, &Settings::default()).unwrap();
    assert!(clean.misfits.is_empty(), "{:?}", clean.misfits);

    let campaign = &mut simulated.campaign;
    let (target, step) = (1, 7);
    let truth = Point3::new(157.1, 332.6, 324.9);
    let shift = Vector3::new(0.0, 0.02, 0.0);
    let lengths = campaign.lengths.as_mut().unwrap();
    for stop in lengths.stops.iter().filter(|stop| stop.step == step) {
        let station = simulated.truth.stations[stop.station].position_mm;
        let moved = truth + Vector3::x() * campaign.steps[step].positions[0];
        let beam = (moved - station).normalize();
        for reading in &mut lengths.readings[stop.readings.clone()] {
            if reading.target == target {
                reading.length_mm += beam.dot(&shift);
            }
        }
    }
    let calibration = calibrate(campaign, &Settings::default()).unwrap();
    let steps: Vec<&str> = calibration
        .misfits
        .iter()
        .map(|m| m.step.as_str())
        .collect();
    assert_eq!(steps, ["run x at X = 140 mm, Y = 0 mm, Z = 0 mm"]);
}
