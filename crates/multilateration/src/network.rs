//! The lengths and what they connect.

use std::ops::Range;

use nalgebra::Point3;

use crate::{Error, Noise};

/// Lengths between stations and points.
///
/// Points come in *groups*: the targets at one step of the machine, which may be read in one visit
/// and then share its return error. Lengths between points of different groups are independent.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Network {
    /// Rough positions of the stations where known, mm; only a choice between mirror images needs
    /// them.
    pub stations: Vec<Option<Point3<f64>>>,
    /// Nominal positions of all points, group after group, mm. The datum is the best fit of the
    /// points to them.
    pub nominal_mm: Vec<Point3<f64>>,
    /// The points of each group, as ranges of `nominal_mm` without gaps.
    pub groups: Vec<Range<usize>>,
    /// Visits of the machine.
    pub visits: Vec<Visit>,
    /// All readings; visits refer to ranges of them without gaps.
    pub readings: Vec<Reading>,
    /// Standard deviations.
    pub noise: Noise,
}

/// Readings of one station taken while the machine stands still.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Visit {
    /// The station.
    pub station: usize,
    /// The group whose points are read.
    pub group: usize,
    /// The readings.
    pub readings: Range<usize>,
}

/// One length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// The point within the visit's group.
    pub point: usize,
    /// Incremental length `|p - S| - L`, mm.
    pub length_mm: f64,
}

impl Network {
    /// Checks indices and numbers, so that the rest of the crate can rely on them.
    pub(crate) fn check(&self) -> Result<(), Error> {
        let malformed = |what: String| Err(Error::Malformed { what });
        let mut next = 0;
        for (i, group) in self.groups.iter().enumerate() {
            if group.start != next || group.end <= next || group.end > self.nominal_mm.len() {
                return malformed(format!(
                    "group {i} covers points {group:?}, expected from {next}"
                ));
            }
            next = group.end;
        }
        if next != self.nominal_mm.len() {
            return malformed(format!("points from {next} on belong to no group"));
        }
        let mut next = 0;
        for (i, visit) in self.visits.iter().enumerate() {
            let range = &visit.readings;
            if range.start != next || range.end < next || range.end > self.readings.len() {
                return malformed(format!(
                    "visit {i} covers readings {range:?}, expected from {next}"
                ));
            }
            next = range.end;
            if visit.station >= self.stations.len() || visit.group >= self.groups.len() {
                return malformed(format!(
                    "visit {i} names a station or group that is not there"
                ));
            }
            let points = self.groups[visit.group].len();
            if self.readings[range.clone()]
                .iter()
                .any(|reading| reading.point >= points)
            {
                return malformed(format!(
                    "visit {i} reads a point that its group does not have"
                ));
            }
        }
        if next != self.readings.len() {
            return malformed(format!("readings from {next} on belong to no visit"));
        }
        let finite = self
            .readings
            .iter()
            .all(|reading| reading.length_mm.is_finite())
            && self
                .nominal_mm
                .iter()
                .all(|p| p.iter().all(|x| x.is_finite()));
        if !finite {
            return malformed("a length or a nominal position is not finite".to_owned());
        }
        self.noise.check()
    }

    /// The readings of a visit.
    pub(crate) fn readings_of(&self, visit: &Visit) -> &[Reading] {
        &self.readings[visit.readings.clone()]
    }

    /// Index of a point of a group among all points.
    pub(crate) fn point(&self, group: usize, point: usize) -> usize {
        self.groups[group].start + point
    }

    /// The visits of every group, in order.
    pub(crate) fn visits_by_group(&self) -> Vec<Vec<usize>> {
        let mut by_group = vec![Vec::new(); self.groups.len()];
        for (i, visit) in self.visits.iter().enumerate() {
            by_group[visit.group].push(i);
        }
        by_group
    }
}
