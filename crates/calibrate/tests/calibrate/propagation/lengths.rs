//! From lengths: the covariance of all results, and what the laser has in it.

use super::*;
use crate::with_one_reflector;

/// Covariances of the lengths, mm²: of their own noise, and with the machine's repeatability, which moves
/// all targets of a visit alike.
pub(crate) fn covariances(campaign: &Campaign, calibration: &Calibration) -> [DMatrix<f64>; 2] {
    let lengths = campaign.lengths.as_ref().unwrap();
    let count = lengths.readings.len();
    let mut own = DMatrix::zeros(count, count);
    let mut returns = DMatrix::zeros(count, count);
    let constant_mm = campaign.instrument.length_sigma_um.unwrap() * MICROMETRE;
    let relative = campaign.instrument.length_sigma_ppm.unwrap() * 1e-6;
    let errors = calibration.calibrated_machine();
    for stop in &lengths.stops {
        let station = calibration.stations[stop.station].position_mm;
        let beam = |i: usize| {
            let target = lengths.readings[i].target;
            target_at(campaign, (calibration, &errors), stop, target) - station
        };
        for i in stop.readings.clone() {
            own[(i, i)] = constant_mm.powi(2) + (relative * beam(i).norm()).powi(2);
            for j in stop.readings.clone() {
                let cosine = beam(i).normalize().dot(&beam(j).normalize());
                returns[(i, j)] = repeatability_variance_mm2(campaign) * cosine;
            }
        }
    }
    [own.clone(), own + returns]
}

#[test]
fn lengths_propagate_to_everything_jointly() {
    assert_propagates("joint adjustment", Method::Joint);
}

#[test]
fn lengths_propagate_to_everything_by_nine_equations() {
    assert_propagates("nine equations", Method::Nine);
}

fn assert_propagates(what: &str, method: Method) {
    let campaign = with_one_reflector(&two_branches());
    let count = campaign.lengths.as_ref().unwrap().readings.len();
    let response = Response::new(count, |i, step_mm| {
        let mut changed = campaign.clone();
        changed.lengths.as_mut().unwrap().readings[i].length_mm += step_mm;
        calibrate(&changed, &settings(method)).unwrap()
    });
    let [own, whole] = covariances(&campaign, &response.stated);
    response.assert_stated(what, &whole);

    let (of_laser, all) = (response.propagated(&own), response.propagated(&whole));
    for (i, (budget, dof)) in response.budgets().into_iter().enumerate() {
        let difference = (budget.laser_in_all - of_laser[(i, i)]).abs();
        let limit = COVARIANCE_TOL * all[(i, i)].max(ROUNDING * ROUNDING);
        assert!(difference <= limit, "{i}: {budget:?}");
        // The noise is declared, and residuals of zero do not contradict it.
        assert!(dof.is_infinite());
    }
}

/// Without repeatability all of it is the laser's.
#[test]
fn a_machine_that_returns_exactly_has_no_part() {
    let mut campaign = with_one_reflector(&two_branches());
    campaign.instrument.repeatability_um = Some(0.0);
    let calibration = calibrate(&campaign, &settings(Method::Joint)).unwrap();
    let nodes = calibration.axes.iter().flat_map(|axis| &axis.nodes);
    let locations = calibration
        .axes
        .iter()
        .flat_map(|axis| &axis.location_errors);
    let budgets = nodes.flat_map(|node| node.budget);
    for budget in budgets.chain(locations.map(|location| location.budget)) {
        let rounding = 1e-9 * budget.variance();
        assert!(budget.repeatability.abs() <= rounding, "{budget:?}");
        assert!(
            (budget.laser_in_all - budget.variance()).abs() <= rounding,
            "{budget:?}"
        );
    }
}

/// The two statements of one uncertainty agree, and what is zero by definition is so exactly.
#[test]
fn covariance_and_uncertainties_agree() {
    let campaign = with_one_reflector(&two_branches());
    let calibration = calibrate(&campaign, &settings(Method::Joint)).unwrap();
    let covariance = calibration.covariance.as_ref().unwrap();
    let matrix = &covariance.matrix;
    assert_eq!(*matrix, matrix.transpose());
    let nodes = calibration.axes.iter().flat_map(|axis| &axis.nodes);
    let locations = calibration
        .axes
        .iter()
        .flat_map(|axis| &axis.location_errors);
    let stations = calibration.stations.iter();
    let u: Vec<f64> = nodes
        .flat_map(|node| node.u)
        .chain(locations.map(|location| location.u))
        .chain(stations.flat_map(|s| s.u_mm.into_iter().chain([s.u_dead_path_mm])))
        .collect();
    assert_eq!(u.len(), covariance.outputs.len());
    for (i, (output, u)) in covariance.outputs.iter().zip(u).enumerate() {
        let variance = (u / output.unit().size()).powi(2);
        let difference = (matrix[(i, i)] - variance).abs();
        assert!(difference <= 1e-9 * variance, "{output:?}: {difference:e}");
    }
    // At home the gauge defines EYY, the angles of Y, EZC and ECC; of X the means of both sides.
    let zeros = (0..matrix.nrows()).filter(|&i| matrix.row(i).iter().all(|c| *c == 0.0));
    let names: Vec<String> = zeros.map(|i| covariance.outputs[i].name()).collect();
    assert_eq!(names.join(" "), "EYY EAY EBY ECY EZC ECC");
}

/// What an axis does beyond its steps enters the squareness of others that are measured while it stands there: by 5 mm this was
/// twice the U that was stated.
#[test]
fn an_axis_parked_beyond_its_steps_is_said_not_to_be_in_u() {
    let lacks = |first_of_x: f64| {
        let mut scenario = two_branches();
        // Another run has X at 60 mm.
        scenario.runs[0].positions = Some(vec![first_of_x, 210.0, 400.0]);
        let calibration = calibrate(&simulated(&scenario), &settings(Method::Joint)).unwrap();
        let mut lacks = calibration.uncertainty.lacks.into_iter();
        lacks.find(|part| part.starts_with("errors of axes beyond their steps"))
    };
    assert_eq!(lacks(60.0), None);
    let said = lacks(65.0).unwrap();
    assert!(
        said.contains("run y2 at X = 60 mm") && said.ends_with("X stood where it was not measured"),
        "{said}"
    );
}

/// Errors are those from home on; without a step there nothing tells its part of them, and a prediction had no word of it.
#[test]
fn the_way_from_home_to_the_steps_is_said_not_to_be_in_u() {
    let said = |first_of_x: f64| {
        let mut scenario = two_branches();
        scenario.runs[0].positions = Some(vec![first_of_x, 60.0, 210.0, 400.0]);
        let calibration = calibrate(&simulated(&scenario), &settings(Method::Joint)).unwrap();
        let mut lacks = calibration.uncertainty.lacks.iter();
        lacks.any(|part| part.starts_with("way from home to the steps of X:"))
    };
    assert!(!said(0.0) && said(10.0));
}
