//! The budget of a lengths campaign: what is left with the stations known.
//!
//! With known stations the points of each step are adjusted alone: with the unit vectors `U` of the
//! beams, `D = (Uᵀ C⁻¹ U)⁻¹` for all noise, and `D Uᵀ C⁻¹ C_l C⁻¹ U D` for that of the lengths. Six
//! equations are not weighted, so results depend on points in the same way wherever these come
//! from, and this way follows from a points campaign.

use trueaxis_identify::SixRows;

use super::*;
use crate::propagation::lengths::covariances;
use crate::propagation::points::{points_campaign, response};

/// Covariances of all coordinates with the stations known, for the lengths' own and for all noise,
/// in the order of the points campaign; mm².
fn with_known_stations(
    campaign: &Campaign,
    calibration: &Calibration,
    of_points: &Campaign,
) -> [DMatrix<f64>; 2] {
    let lengths = campaign.lengths.as_ref().unwrap();
    let points = of_points.points.as_ref().unwrap();
    let [own, whole] = covariances(campaign, calibration);
    let errors = calibration.calibrated_machine();
    let count = 3 * points.readings.len();
    let mut all = [DMatrix::zeros(count, count), DMatrix::zeros(count, count)];
    for step in &points.stops {
        // The beams to the points of this step: length, place of the point, direction.
        let mut beams = Vec::new();
        let same = |stop: &&Stop| (stop.step, stop.direction) == (step.step, step.direction);
        for stop in lengths.stops.iter().filter(same) {
            let station = calibration.stations[stop.station].position_mm;
            for i in stop.readings.clone() {
                let target = lengths.readings[i].target;
                let mut readings = points.readings[step.readings.clone()].iter();
                let place = readings.position(|r| r.target == target).unwrap();
                let beam = target_at(campaign, (calibration, &errors), stop, target) - station;
                beams.push((i, place, beam.normalize()));
            }
        }
        let unknowns = 3 * step.readings.len();
        let mut u = DMatrix::zeros(beams.len(), unknowns);
        for (row, (_, place, beam)) in beams.iter().enumerate() {
            let mut direction = u.fixed_view_mut::<1, 3>(row, 3 * place);
            direction.copy_from(&beam.transpose());
        }
        let select = |c: &DMatrix<f64>| {
            DMatrix::from_fn(beams.len(), beams.len(), |i, j| c[(beams[i].0, beams[j].0)])
        };
        let weights = select(&whole).try_inverse().unwrap();
        let d = (u.transpose() * &weights * &u).try_inverse().unwrap();
        let from_lengths = &d * u.transpose() * weights;
        let of_lengths = &from_lengths * select(&own) * from_lengths.transpose();
        let first = 3 * step.readings.start;
        for (all, block) in all.iter_mut().zip([of_lengths, d]) {
            let mut place = all.view_mut((first, first), (unknowns, unknowns));
            place.copy_from(&block);
        }
    }
    all
}

#[test]
fn the_budget_is_that_of_known_stations() {
    let method = Method::Six(SixRows::PAPER);
    let campaign = simulated(&two_branches());
    let of_points = points_campaign(campaign.clone(), 1, &Isometry3::identity());
    let stations_known = response(&of_points, method);
    let stated = Response {
        stated: calibrate(&campaign, &settings(method)).unwrap(),
        derivatives: DMatrix::zeros(0, 0),
    };
    let covariances = with_known_stations(&campaign, &stated.stated, &of_points);
    let [laser, known] = covariances.map(|c| stations_known.propagated(&c).diagonal());

    let mut geometry = 0.0_f64;
    for (i, (budget, _)) in stated.budgets().into_iter().enumerate() {
        let limit = COVARIANCE_TOL * budget.variance().max(ROUNDING * ROUNDING);
        assert!((budget.laser - laser[i]).abs() <= limit, "{i}: {budget:?}");
        let difference = budget.repeatability - (known[i] - laser[i]);
        assert!(difference.abs() <= limit, "{i}: {budget:?}");
        assert!(budget.station_geometry >= 0.0, "{i}: {budget:?}");
        geometry = geometry.max(budget.station_geometry / budget.variance().max(known[i]));
    }
    // The test would prove little if the stations did not matter.
    assert!(geometry > 0.1, "{geometry}");
}
