//! How the noise of the points depends on place and direction, from what rigid motions and repeats leave of them.

use nalgebra::Matrix3;
use trueaxis_campaign::Points;
use trueaxis_screening::{CoordinateNoise, CoordinateReading, StepReadings};

use crate::points::equations::PointPoses;
use crate::points::{MeasuredPoints, UNDECLARED_SIGMA_UM};

/// The noise that readings show beside these poses. The rotation leads from the instrument's frame into the datum.
pub(crate) fn noise_of_coordinates(
    points: &Points,
    measured: &MeasuredPoints,
    found: &PointPoses,
    datum_from_instrument: &Matrix3<f64>,
) -> CoordinateNoise {
    let instrument_from_datum = datum_from_instrument.transpose();
    let bodies = &found.equations.bodies;
    let firsts = bodies.iter().scan(0, |next, body| {
        let first = *next;
        *next += body.shape_mm.len();
        Some(first)
    });
    let firsts: Vec<usize> = firsts.collect();
    let mut steps = Vec::new();
    for source in &found.equations.sources {
        let step = &bodies[source.body].steps[source.step];
        for side in [1, -1] {
            let readings = measured.readings[source.group]
                .iter()
                .filter_map(|reading| {
                    let t = source
                        .places
                        .iter()
                        .position(|place| *place == reading.place)?;
                    let of_campaign = &points.readings[reading.reading];
                    let is_own = points.stops[reading.visit].direction.sign() == side;
                    is_own.then(|| CoordinateReading {
                        visit: reading.visit,
                        target: firsts[source.body] + t,
                        sigma: of_campaign.sigma_um.unwrap_or(UNDECLARED_SIGMA_UM),
                        point_mm: of_campaign.position_mm,
                        misfit_mm: instrument_from_datum
                            * (reading.off_mean_mm + step.deltas_mm[t]),
                    })
                });
            let mut readings: Vec<CoordinateReading> = readings.collect();
            readings.sort_by_key(|own| own.visit);
            if !readings.is_empty() {
                steps.push(StepReadings {
                    rotation: instrument_from_datum * step.home_from_points.transpose(),
                    readings,
                });
            }
        }
    }
    CoordinateNoise::estimated(&steps)
}
