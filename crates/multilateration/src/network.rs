//! The lengths and what they connect.

use std::ops::Range;
use std::sync::Arc;

use nalgebra::Point3;

use crate::noise::factor_len;
use crate::{Bodies, Error, Noise, Reflectors, Return};

/// Lengths between stations and points.
///
/// Points come in *groups*: the targets at one step of the machine. Points that are read in one visit share its
/// repeatability error. Lengths to points of different groups are independent.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Network {
    /// Rough positions of the stations where known, mm, needed only to choose between mirror images.
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
    /// Instants at which a station's beam was interrupted, in the order of the readings: from then on its
    /// interferometer has a new zero, with a dead path of its own.
    pub interruptions: Vec<Interruption>,
    /// Factor on the variance of each reading's own noise; empty where all are one.
    pub variance_factors: Vec<f64>,
    /// Which points keep their distances. Without bodies all points are free, with three unknowns each. With bodies
    /// the points of a group that has one are tied to its pose, with six unknowns, and all groups share the shape.
    pub bodies: Option<Arc<Bodies>>,
    /// Which reflector is at each point: the constants are then unknowns. Without reflectors all are equal.
    pub reflectors: Option<Arc<Reflectors>>,
    /// The group of the targets on the bed, if there is one: no axis moves it, so its lengths have no repeatability
    /// error.
    pub bed: Option<usize>,
    /// How the machine returns to the points of each group; `None` where it returns to all alike and turns none.
    pub returns: Option<Arc<Vec<Return>>>,
    /// Dead paths that are known, at most one for each station.
    pub dead_paths: Vec<KnownDeadPath>,
}

/// A lost count of a station's interferometer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Interruption {
    /// The station.
    pub station: usize,
    /// The first reading with the new zero; readings are in measuring order.
    pub first_reading: usize,
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

/// A dead path that is known beforehand: `|p - S| = l + L` for a reflector without a constant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KnownDeadPath {
    /// The station. The dead path is its first, before any interruption.
    pub station: usize,
    /// L, mm.
    pub length_mm: f64,
    /// Its standard uncertainty, mm.
    pub sigma_mm: f64,
}

impl Network {
    /// Checks indices and numbers, so that the rest of the crate can rely on them.
    pub(crate) fn check(&self) -> Result<(), Error> {
        let malformed = |what: String| Err(Error::malformed(what));
        check_parts(&self.groups, ("group", "points"), self.nominal_mm.len())?;
        if let Some(i) = self.groups.iter().position(Range::is_empty) {
            return malformed(format!("group {i} has no points"));
        }
        let of_visits = self.visits.iter().map(|visit| &visit.readings);
        check_parts(of_visits, ("visit", "readings"), self.readings.len())?;
        let mut finite = true;
        for (i, visit) in self.visits.iter().enumerate() {
            if visit.station >= self.stations.len() || visit.group >= self.groups.len() {
                return malformed(format!("visit {i} has no such station or group"));
            }
            let points = self.groups[visit.group].len();
            for reading in self.readings_of(visit) {
                if reading.point >= points {
                    return malformed(format!("visit {i} reads a point that is not there"));
                }
                finite &= reading.length_mm.is_finite();
            }
        }
        let mut places = self.nominal_mm.iter();
        if !finite || !places.all(|p| p.iter().all(|x| x.is_finite())) {
            return malformed("a length or a nominal position is not finite".to_owned());
        }
        let mut earlier = None;
        for interruption in &self.interruptions {
            let next = (interruption.first_reading, interruption.station);
            let known = interruption.station < self.stations.len();
            if !known || earlier >= Some(next) || next.0 >= self.readings.len() {
                return malformed(format!("{interruption:?} is out of range or out of order"));
            }
            earlier = Some(next);
        }
        let factors = &self.variance_factors;
        let count = factors.len();
        if count != 0 && count != self.readings.len() {
            let readings = self.readings.len();
            return malformed(format!("{count} variance factors for {readings} readings"));
        }
        if !factors.iter().all(|f| f.is_finite() && *f > 0.0) {
            return malformed("a variance factor is not positive and finite".to_owned());
        }
        if let Some(bodies) = &self.bodies {
            bodies.check(&self.groups)?;
        }
        if let Some(returns) = &self.returns {
            let (count, groups) = (returns.len(), self.groups.len());
            if count != groups || !returns.iter().all(|r| r.variance_ratio >= 0.0) {
                let what = format!("{count} returns, or a negative one, for {groups} groups");
                return malformed(what);
            }
        }
        if let Some(reflectors) = &self.reflectors {
            reflectors.check(self.nominal_mm.len())?;
        }
        for known in &self.dead_paths {
            let numbers_are_good =
                known.length_mm.is_finite() && known.sigma_mm.is_finite() && known.sigma_mm > 0.0;
            if !numbers_are_good || known.station >= self.stations.len() {
                return malformed(format!("{known:?} is no dead path of a station"));
            }
        }
        self.noise.check()
    }

    /// The body that the points of a group are tied to.
    pub fn body_of(&self, group: usize) -> Option<usize> {
        let bodies = self.bodies.as_deref()?;
        bodies.of_groups[group].body
    }

    /// Number of contrasts of reflectors that are unknown.
    pub(crate) fn contrasts(&self) -> usize {
        let reflectors = self.reflectors.as_deref();
        reflectors.map_or(0, Reflectors::contrasts)
    }

    /// Standard deviation of the contrasts, where it is known, mm.
    pub(crate) fn contrast_sigma_mm(&self) -> Option<f64> {
        self.reflectors.as_deref()?.sigma_mm
    }

    /// Number of dead paths: one for each station and one for each interruption.
    pub fn zeros(&self) -> usize {
        self.stations.len() + self.interruptions.len()
    }

    /// The network without some readings (ascending), and the previous number of each reading that is left.
    /// Interruptions and variance factors are not copied.
    pub fn without(&self, removed: &[usize]) -> (Self, Vec<usize>) {
        let left = |i: &usize| removed.binary_search(i).is_err();
        let kept: Vec<usize> = (0..self.readings.len()).filter(left).collect();
        let place = |i: usize| i - removed.partition_point(|&r| r < i);
        let visits = self.visits.iter().map(|visit| Visit {
            readings: place(visit.readings.start)..place(visit.readings.end),
            ..visit.clone()
        });
        let network = Self {
            visits: visits.collect(),
            readings: kept.iter().map(|&i| self.readings[i]).collect(),
            interruptions: Vec::new(),
            variance_factors: Vec::new(),
            ..self.clone()
        };
        (network, kept)
    }

    /// The dead path of every reading: that of its station, or of the last interruption before it.
    pub fn zero_of_readings(&self) -> Vec<usize> {
        let mut current: Vec<usize> = (0..self.stations.len()).collect();
        let mut interruptions = self.interruptions.iter().enumerate().peekable();
        let mut zeros = Vec::with_capacity(self.readings.len());
        for visit in &self.visits {
            for reading in visit.readings.clone() {
                while let Some((k, next)) =
                    interruptions.next_if(|(_, i)| i.first_reading <= reading)
                {
                    current[next.station] = self.stations.len() + k;
                }
                zeros.push(current[visit.station]);
            }
        }
        zeros
    }

    /// Factor on the variance of a reading's own noise.
    pub fn variance_factor(&self, reading: usize) -> f64 {
        self.variance_factors.get(reading).copied().unwrap_or(1.0)
    }

    pub(crate) fn readings_of(&self, visit: &Visit) -> &[Reading] {
        &self.readings[visit.readings.clone()]
    }

    /// Start of the triangle of each visit in one list ([`factor_len`]), and last its end.
    pub(crate) fn factor_starts(&self) -> Vec<usize> {
        let mut starts = vec![0];
        for visit in &self.visits {
            starts.push(starts[starts.len() - 1] + factor_len(visit.readings.len()));
        }
        starts
    }

    /// Index of a point of a group among all points.
    pub fn point(&self, group: usize, point: usize) -> usize {
        self.groups[group].start + point
    }

    /// The visits of every group, in order.
    pub(crate) fn visits_by_group(&self) -> Vec<Vec<usize>> {
        let mut visits = vec![Vec::new(); self.groups.len()];
        for (i, visit) in self.visits.iter().enumerate() {
            visits[visit.group].push(i);
        }
        visits
    }
}

/// Checks that the parts of the owners are consecutive and cover all.
fn check_parts<'r>(
    parts: impl IntoIterator<Item = &'r Range<usize>>,
    (owner, what): (&str, &str),
    all: usize,
) -> Result<(), Error> {
    let mut next = 0;
    for (i, part) in parts.into_iter().enumerate() {
        if part.start != next || part.end < next || part.end > all {
            let what = format!("{owner} {i} covers {what} {part:?}, expected from {next}");
            return Err(Error::malformed(what));
        }
        next = part.end;
    }
    match next == all {
        true => Ok(()),
        false => Err(Error::malformed(format!(
            "{what} from {next} on belong to no {owner}"
        ))),
    }
}
