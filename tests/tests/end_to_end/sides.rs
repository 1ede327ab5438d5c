//! What an axis does otherwise from one side than from the other, across itself or in angle, is no lost motion.

use nalgebra::Vector3;
use trueaxis_calibrate::calibrate;
use trueaxis_campaign::Campaign;
use trueaxis_diagnose::{CurvePoint, Diagnosis, Rival, Settings, Verdict, diagnose};
use trueaxis_kinematics::{ARCSEC, MICROMETRE};
use trueaxis_tests::blind::{self, Kind};
use trueaxis_tests::in_parallel;

/// An axis of three, by how much what it carries stands otherwise after arrival in the positive direction, µm, and how far
/// it is turned about its home, arc seconds; the opposite after arrival in the negative direction.
#[derive(Debug, Clone, Copy)]
struct BySide {
    axis: usize,
    shift_um: [f64; 3],
    turn_arcsec: [f64; 3],
}

/// Clean lengths of both sides, and what `by` adds to them along the beams from where the stations are found, to the first order.
fn campaign(by: BySide, seed: u64) -> Campaign {
    let mut campaign = blind::campaign(&Kind::three_axis().forward_and_backward(), &[], seed);
    let stations = calibrate(&campaign, &trueaxis_calibrate::Settings::default());
    let stations = stations.unwrap().stations;
    let mut lengths = campaign.lengths.take().unwrap();
    let (shift_mm, turn) = (
        Vector3::from(by.shift_um) * MICROMETRE,
        Vector3::from(by.turn_arcsec) * ARCSEC,
    );
    for stop in &lengths.stops {
        if campaign.axis_under_test(stop.step) != Some(by.axis) {
            continue;
        }
        let moved = campaign.machine.axes().iter();
        let moved = moved.zip(&campaign.steps[stop.step].positions);
        let moved: Vector3<f64> = moved
            .map(|(axis, q)| axis.direction().into_inner() * *q)
            .sum();
        let station_mm = stations[stop.station].position_mm;
        for reading in &mut lengths.readings[stop.readings.clone()] {
            let home_mm = campaign.targets[reading.target].home_mm;
            let beam = (home_mm + moved - station_mm).normalize();
            let added_mm = shift_mm + turn.cross(&home_mm.coords);
            reading.length_mm += f64::from(stop.direction.sign()) * added_mm.dot(&beam);
        }
    }
    campaign.lengths = Some(lengths);
    campaign
}

fn diagnosed(by: BySide, seed: u64) -> Diagnosis {
    let settings = Settings {
        explain_curves: false,
        ..Settings::default()
    };
    diagnose(&campaign(by, seed), &settings).unwrap()
}

/// A straightness or an angle that differs by side was clean, or the lost motion of the axis, or a tripod that wanders: all of
/// 18. It is nobody's known effect: the axis is said, and that it goes with the side.
#[test]
fn what_differs_by_side_is_told_of_its_axis() {
    let cases = [
        (1, [0.0, 3.0, 0.0], [0.0; 3]),
        (2, [0.0, 0.0, -3.0], [0.0; 3]),
        (3, [0.0; 3], [0.0, 2.0, 0.0]),
        (4, [0.0; 3], [0.0, 0.0, 2.0]),
    ];
    let wrong: Vec<String> = in_parallel(cases, |(seed, shift_um, turn_arcsec)| {
        let by = BySide {
            axis: 0,
            shift_um,
            turn_arcsec,
        };
        let found = diagnosed(by, seed);
        let mut wanders = found.disturbances.iter().map(|own| &own.whose);
        let is_told = wanders
            .any(|own| own.varies_with == ["direction"] && own.subject.axis == Some(by.axis));
        // An angle about home moves the targets along the axis, too: lost motion may be named with the angle as a rival.
        let is_it = |rival: &Rival| matches!(rival, Rival::Disturbance { whose, .. } if whose.varies_with == ["direction"]);
        let mut causes = found.causes.iter();
        let are_fair = causes.all(|cause| cause.rivals.iter().any(is_it));
        let right = found.verdict != Verdict::Named && is_told && are_fair;
        // Of the displacements the curve shows all, positive less negative side.
        let shown = found.disturbances.iter().flat_map(|own| &own.curve);
        let is_off = |(k, point): (usize, &CurvePoint)| {
            turn_arcsec.iter().all(|turn| turn.abs() < 1e-9)
                && (point.value_um[k] - 2.0 * shift_um[k]).abs() > 4.0 * point.u_um[k] + 1e-9
        };
        let off = shown
            .flat_map(|point| (0..3).map(move |k| (k, point)))
            .filter(|own| is_off(*own));
        let right = right && off.count() == 0;
        let said: Vec<String> = found
            .disturbances
            .iter()
            .map(|own| format!("{:?}", own.whose))
            .collect();
        (!right).then(|| format!("{by:?}: {} {said:?}", found.verdict.name()))
    })
    .into_iter()
    .flatten()
    .collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn sides_that_agree_are_clean() {
    let by = BySide {
        axis: 0,
        shift_um: [0.0; 3],
        turn_arcsec: [0.0; 3],
    };
    assert_eq!(diagnosed(by, 1).verdict, Verdict::Clean);
}
