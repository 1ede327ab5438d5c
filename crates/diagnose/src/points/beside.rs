//! The points with disturbances in their covariance.

use trueaxis_effects::Circumstances;

use crate::engine::Wanders;
use crate::engine::coordinate::moved;
use crate::engine::disturbance::{Disturbance, Here, Wanderer, Who, With, targets_and_axes};
use crate::points::base::Base;
use crate::points::model::Model;
use crate::points::noise::Noise;
use crate::points::omnibus::{range, travelled};
use crate::points::readings::Reading;

impl Wanders for Base<'_> {
    const ROWS: usize = 3;

    fn wanderers(&self) -> Vec<Wanderer> {
        let all = [Who::Machine, Who::Frame];
        let mut all = all.map(|who| Wanderer::new(who, With::Campaign)).to_vec();
        all.extend(targets_and_axes(self.scene, |axis, side| {
            let mut readings = self.readings.all.iter();
            readings.any(|r| r.axis == Some(axis) && r.side * side > 0.0)
        }));
        all
    }

    /// A displacement of the frame without rotation is an opposite displacement of the machine.
    fn confounded(&self, wanderer: Wanderer) -> Option<Wanderer> {
        let has_bed = self.readings.all.iter().any(|r| r.pose.is_none());
        (wanderer.who == Who::Machine && !has_bed)
            .then_some(Wanderer::new(Who::Frame, wanderer.with))
    }

    fn here(&self) -> Vec<Here> {
        let travelled = travelled(self);
        let here = |(reading, travelled): (&Reading, f64)| Here {
            station: 0,
            target: reading.target,
            axis: reading.axis,
            time_s: reading.time_s,
            occupation: reading.progress,
            campaign: reading.progress,
            travelled,
            side: reading.side,
        };
        self.readings.all.iter().zip(travelled).map(here).collect()
    }

    fn stops(&self, _: With) -> usize {
        self.readings.stops.len()
    }

    fn ends(&self, axis: usize) -> [f64; 2] {
        range(self, axis)
    }

    fn courses_mm(&self, _: &Model, wanderer: Wanderer) -> Vec<Vec<f64>> {
        self.columns_of_unit_mm(wanderer)
    }

    fn circumstances<'c>(&'c self, _: &Model, reading: usize) -> Circumstances<'c> {
        self.at(reading)
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
        let parts = noise.own_mm.iter().chain(&noise.return_mm);
        parts.map(|sigma| sigma * sigma).sum()
    }
}

impl Base<'_> {
    /// Changes of the coordinates by a unit of each coefficient, mm.
    pub(crate) fn columns_of_unit_mm(&self, wanderer: Wanderer) -> Vec<Vec<f64>> {
        let subject = wanderer.subject();
        wanderer.columns(self.scene, &self.here(), |i, coordinates| {
            let moved = moved(coordinates, &subject, &self.at(i));
            let in_rows = |moved| self.in_rows(i, self.shown_mm(moved)).into();
            moved.iter().map(in_rows).collect()
        })
    }
}
