//! Values of all unknowns of a network.

use std::ops::Range;

use nalgebra::{Isometry3, Matrix3, Point3, Vector3};
use rayon::prelude::*;
use trueaxis_kinematics::{centroid, polished};

use crate::bodies::{Bodies, Placed};
use crate::chunks::split_mut;
use crate::network::Network;
use crate::reflectors::constants_mm;

/// Unknowns of the datum: position and orientation.
pub(crate) const DATUM: usize = 6;

/// Unknowns of a station.
pub(crate) const PER_STATION: usize = 4;

/// Least number of groups to hand to another thread: some 20 µs.
const LEAST_GROUPS: usize = 128;

/// Unknowns of a pose.
pub(crate) const POSE: usize = 6;

/// Column of a dead path among the shared unknowns.
pub(crate) fn zero_column(zero: usize, stations: usize) -> usize {
    if zero < stations {
        PER_STATION * zero + PER_STATION - 1
    } else {
        PER_STATION * stations + zero - stations
    }
}

/// Stations, dead paths, and points with what ties them.
#[derive(Debug, Clone)]
pub(crate) struct State {
    pub(crate) stations: Vec<Point3<f64>>,
    /// One for each station, then one for each interruption.
    pub(crate) dead_paths_mm: Vec<f64>,
    /// All points; those of tied groups follow from poses and shapes.
    pub(crate) points: Vec<Point3<f64>>,
    /// Datum from home, one for each group, the nominal one for a group with free points; empty in a network without
    /// bodies.
    pub(crate) poses: Vec<Isometry3<f64>>,
    /// Home positions of the targets of each body, mm.
    pub(crate) shapes_mm: Vec<Vec<Point3<f64>>>,
    /// What the constants of all reflectors have in common ([`crate::known`]); zero where no dead path is known.
    pub(crate) mean_constant_mm: f64,
    /// Contrasts of the constants of reflectors ([`crate::reflectors`]).
    pub(crate) contrasts_mm: Vec<f64>,
}

/// What all lengths have in common.
#[derive(Clone, Copy)]
pub(crate) struct Common<'a> {
    pub(crate) stations: &'a [Point3<f64>],
    pub(crate) dead_paths_mm: &'a [f64],
    pub(crate) contrasts_mm: &'a [f64],
}

impl State {
    /// Stations, their first dead paths and points as given; bodies in the pose that fits the points best.
    pub(crate) fn new(
        network: &Network,
        stations: Vec<Point3<f64>>,
        dead_paths_mm: Vec<f64>,
        points: Vec<Point3<f64>>,
    ) -> Self {
        let mut state = Self {
            stations,
            dead_paths_mm: with_interruptions(network, dead_paths_mm),
            points,
            poses: Vec::new(),
            shapes_mm: Vec::new(),
            mean_constant_mm: 0.0,
            contrasts_mm: vec![0.0; network.contrasts()],
        };
        if let Some(bodies) = network.bodies.as_deref() {
            state.place_bodies(network, bodies);
        }
        state
    }

    fn place_bodies(&mut self, network: &Network, bodies: &Bodies) {
        let shapes = bodies.bodies.iter().map(|body| body.home_mm.clone());
        self.shapes_mm = shapes.collect();
        self.poses = bodies.of_groups.iter().map(|g| g.ref_from_home).collect();
        let points = split_mut(&mut self.points, network.groups.iter().map(Range::len));
        let groups = points.into_par_iter().zip(&mut self.poses);
        let groups = groups.zip(&bodies.of_groups).with_min_len(LEAST_GROUPS);
        groups.for_each(|((points, pose), placed)| {
            if let Some(body) = placed.body {
                let shape_mm = &self.shapes_mm[body];
                *pose = placed.best_fit(shape_mm, points);
                placed.put(pose, shape_mm, points);
            }
        });
    }

    /// What all lengths have in common.
    pub(crate) fn common(&self) -> Common<'_> {
        Common {
            stations: &self.stations,
            dead_paths_mm: &self.dead_paths_mm,
            contrasts_mm: &self.contrasts_mm,
        }
    }

    /// Moves all positions as a whole; dead paths stay.
    pub(crate) fn move_by(&mut self, motion: &Isometry3<f64>) {
        for place in self.stations.iter_mut().chain(&mut self.points) {
            *place = motion * *place;
        }
        for pose in &mut self.poses {
            *pose = motion * *pose;
        }
    }

    /// Observed minus computed length of every reading, mm.
    pub(crate) fn residuals_mm(&self, network: &Network) -> Vec<f64> {
        let zeros = network.zero_of_readings();
        let constants_mm = constants_mm(&self.contrasts_mm);
        let constant_mm = |point: usize| match &network.reflectors {
            Some(reflectors) if !constants_mm.is_empty() => {
                constants_mm[reflectors.of_points[point]]
            }
            _ => 0.0,
        };
        let mut residuals = Vec::with_capacity(network.readings.len());
        for visit in &network.visits {
            let station = self.stations[visit.station];
            for i in visit.readings.clone() {
                let reading = &network.readings[i];
                let point = network.point(visit.group, reading.point);
                let distance_mm = (self.points[point] - station).norm();
                let computed_mm = distance_mm - self.dead_paths_mm[zeros[i]] + constant_mm(point);
                residuals.push(reading.length_mm - computed_mm);
            }
        }
        residuals
    }
}

/// The first dead paths of the stations, then those after the interruptions of a network, which start with the value
/// of their station: lengths are linear in dead paths.
pub(crate) fn with_interruptions(network: &Network, mut dead_paths_mm: Vec<f64>) -> Vec<f64> {
    dead_paths_mm.truncate(network.stations.len());
    for interruption in &network.interruptions {
        dead_paths_mm.push(dead_paths_mm[interruption.station]);
    }
    dead_paths_mm
}

impl Placed {
    /// Writes the positions of the points of a body in a pose.
    pub(crate) fn put(
        &self,
        pose: &Isometry3<f64>,
        shape_mm: &[Point3<f64>],
        points: &mut [Point3<f64>],
    ) {
        for (point, &place) in points.iter_mut().zip(&self.places) {
            *point = pose * shape_mm[place];
        }
    }

    /// The pose near the nominal one in which the shape fits some points best, to second order in the distance from
    /// nominal.
    fn best_fit(&self, shape_mm: &[Point3<f64>], points: &[Point3<f64>]) -> Isometry3<f64> {
        let home = |k: usize| shape_mm[self.places[k]];
        let homes = (0..points.len()).map(|k| home(k).coords);
        let sum: Vector3<f64> = homes.sum();
        let (home_centre, centre) = (sum / points.len() as f64, centroid(points));
        let mut products = Matrix3::zeros();
        for (k, p) in points.iter().enumerate() {
            products += (home(k).coords - home_centre) * (p - centre).transpose();
        }
        let turn = polished(self.ref_from_home.rotation, &products);
        Isometry3::from_parts((centre.coords - turn * home_centre).into(), turn)
    }
}
