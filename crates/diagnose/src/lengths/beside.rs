//! The lengths with disturbances in their covariance.

use rayon::prelude::*;
use trueaxis_effects::Circumstances;
use trueaxis_multilateration::{Noise, Solution, Whitened, solve_from};
use trueaxis_poses::{LengthCircumstances as Reading, Observation};
use trueaxis_selection::Projection;

use crate::Error;
use crate::engine::Wanders;
use crate::engine::coordinate::moved;
use crate::engine::disturbance::{Disturbance, Here, Wanderer, Who, With, targets_and_axes};
use crate::lengths::adjusted::{Adjusted, is_projected};
use crate::lengths::base::Base;
use crate::lengths::omnibus::travelled;

impl Wanders for Base<'_> {
    const ROWS: usize = 1;

    fn wanderers(&self) -> Vec<Wanderer> {
        let scene = &self.scene;
        let of_occupation = |who| Wanderer::new(who, With::Occupation);
        let mut all = vec![of_occupation(Who::Machine)];
        if scene.has_bed_targets() {
            all.push(of_occupation(Who::Tripods));
        }
        all.push(of_occupation(Who::Air));
        for station in (0..scene.stations.len()).map(Who::Station) {
            all.extend([
                of_occupation(station),
                Wanderer::new(station, With::Position),
            ]);
        }
        all.extend(targets_and_axes(scene, |axis, side| {
            let mut readings = self.readings.iter();
            readings.any(|r| r.axis == axis && r.sign() * side > 0.0)
        }));
        all
    }

    fn confounded(&self, wanderer: Wanderer) -> Option<Wanderer> {
        let has_bed = self.scene.has_bed_targets();
        (wanderer.who == Who::Machine && !has_bed)
            .then_some(Wanderer::new(Who::Tripods, wanderer.with))
    }

    fn here(&self) -> Vec<Here> {
        let [first, last] = self.span_s;
        let here = |reading: &Reading| Here {
            station: reading.station,
            target: reading.target,
            axis: Some(reading.axis),
            time_s: reading.time_s,
            occupation: reading.occupation_progress,
            campaign: (reading.time_s - first) / (last - first).max(f64::MIN_POSITIVE),
            travelled: travelled(self, reading),
            side: reading.sign(),
        };
        self.readings.iter().map(here).collect()
    }

    fn stops(&self, with: With) -> usize {
        let stops = self.network.visits.len();
        match with {
            With::Campaign | With::SidesInTime | With::TimeAndPosition => stops,
            _ => stops / self.scene.stations.len().max(1),
        }
    }

    fn ends(&self, axis: usize) -> [f64; 2] {
        self.scene.machine.axes()[axis].travel()
    }

    fn courses_mm(&self, model: &Adjusted, wanderer: Wanderer) -> Vec<Vec<f64>> {
        self.columns_of(&self.here(), &model.solution, wanderer)
    }

    fn circumstances<'c>(&'c self, model: &Adjusted, reading: usize) -> Circumstances<'c> {
        let reading = &self.readings[reading];
        self.observation(reading, &model.solution).at
    }

    fn beside(&self, disturbances: Vec<Disturbance>) -> Self {
        let mut beside = self.clone();
        beside.disturbances = disturbances;
        beside
    }

    fn disturbances(&self) -> &[Disturbance] {
        &self.disturbances
    }

    fn variance(noise: &Noise) -> f64 {
        noise.length_sigma_mm.powi(2) + noise.repeatability_mm.powi(2)
    }
}

impl Base<'_> {
    /// Changes of the lengths by a unit of each coefficient, mm.
    fn columns_of(&self, all: &[Here], solution: &Solution, wanderer: Wanderer) -> Vec<Vec<f64>> {
        let subject = wanderer.subject();
        wanderer.columns(&self.scene, all, |i, coordinates| {
            let Observation { at, beam } = self.observation(&self.readings[i], solution);
            let moved = moved(coordinates, &subject, &at);
            moved.iter().map(|moved| [moved.along(&beam)]).collect()
        })
    }

    /// The projection without causes, with disturbances in the covariance.
    pub(crate) fn before_causes(&self, whitened: &Whitened, solution: &Solution) -> Projection {
        let mut projection = Projection {
            is_soft: !is_projected(whitened, &whitened.residuals),
            ..Projection::of_network(whitened)
        };
        let all = self.here();
        for own in &self.disturbances {
            let mut columns = own.scaled(
                &self.scene,
                &all,
                self.columns_of(&all, solution, own.wanderer),
            );
            let each = columns.par_iter_mut();
            each.for_each(|column| whitened.whiten(column));
            projection = projection.beside(&columns).0;
        }
        projection
    }

    /// The model adjusted to its lengths less the disturbances: its poses and stations are then those of generalised
    /// least squares.
    pub(crate) fn less(&self, adjusted: &Adjusted, wandered_mm: &[f64]) -> Result<Adjusted, Error> {
        let mut network = adjusted.network.clone();
        for (reading, wandered_mm) in network.readings.iter_mut().zip(wandered_mm) {
            reading.length_mm -= wandered_mm;
        }
        let solution = solve_from(&network, &adjusted.solution)?;
        Ok(Adjusted {
            network,
            solution,
            ..adjusted.clone()
        })
    }
}
