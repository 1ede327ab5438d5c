//! The circumstances of the readings at a stop, and what the effects make of them.
//!
//! Instants are on the clock of the campaign (`time_s` of `lengths.csv`), warming up counts from the first
//! reading. Progress is the part of the time that is over:
//!
//! ```text
//! τ = (t - t_first) / (t_last - t_first)        over all readings of the campaign
//! w = (t - t_first) / (t_last - t_first)        over the readings of the station's occupation
//! ```

use std::ops::Range;

use nalgebra::{Point3, Vector3};
use trueaxis_effects::{Circumstances, Displaced, TemperatureHistory};

use crate::plan::Plan;
use crate::schedule::Visit;

/// One stop of the machine.
pub(crate) struct StopCircumstances<'a> {
    pub(crate) plan: &'a Plan,
    pub(crate) visit: &'a Visit<'a>,
    /// Commanded positions of all axes, mm or rad.
    pub(crate) positions: &'a [f64],
    pub(crate) progress: &'a Progress,
    pub(crate) temperatures: &'a [TemperatureHistory],
}

impl StopCircumstances<'_> {
    /// What all effects together do to the readings of the stop, in the order of the run's targets.
    ///
    /// `points_mm` are the targets where they are without the effects. Each effect sees these
    /// circumstances and not what another effect makes of them. `acts` is set for those that do something.
    pub(crate) fn displaced(
        &self,
        station_mm: Point3<f64>,
        points_mm: &[Point3<f64>],
        acts: &mut [bool],
    ) -> Vec<Displaced> {
        let (plan, visit, progress) = (self.plan, self.visit, self.progress);
        let turn_s = progress.occupations_s.get(visit.station);
        let readings = visit.targets.iter().zip(&visit.times_s).zip(points_mm);
        let displaced = readings.map(|((&target, &time_s), &point_mm)| {
            let carrier = plan.targets[target].carrier;
            let at = Circumstances {
                time_s,
                elapsed_s: time_s - progress.campaign_s.start,
                progress: part(&progress.campaign_s, time_s),
                occupation_progress: turn_s.map_or(0.0, |turn_s| part(turn_s, time_s)),
                occupation_elapsed_s: turn_s.map_or(0.0, |turn_s| time_s - turn_s.start),
                station: visit.station,
                target,
                carrier,
                axis: visit.run.map_or(0, |run| run.axis),
                direction: f64::from(visit.direction.sign()),
                // The machine stands still at a stop.
                speed_per_s: 0.0,
                positions: self.positions,
                point_mm,
                centroid_mm: self.centroid_mm(carrier, points_mm),
                distance_mm: (point_mm - station_mm).norm(),
                temperatures: self.temperatures,
                ..Circumstances::new(&plan.machine)
            };
            let effects = plan.effects.iter().zip(&mut *acts);
            let displaced = effects.map(|(effect, acts)| {
                let displaced = effect.displaced(&at);
                *acts |= displaced != Displaced::default();
                displaced
            });
            displaced.sum()
        });
        displaced.collect()
    }

    /// Centroid of the targets measured at this stop that sit on the stage of axis `carrier`.
    fn centroid_mm(&self, carrier: Option<usize>, points_mm: &[Point3<f64>]) -> Point3<f64> {
        let measured = self.visit.targets.iter().zip(points_mm);
        let on_stage =
            measured.filter(|&(&target, _)| self.plan.targets[target].carrier == carrier);
        let (mut sum, mut count) = (Vector3::zeros(), 0.0);
        for (_, point_mm) in on_stage {
            sum += point_mm.coords;
            count += 1.0;
        }
        Point3::from(sum / count)
    }
}

/// First and last reading of the campaign and of each station's occupation.
pub(crate) struct Progress {
    /// s.
    pub(crate) campaign_s: Range<f64>,
    /// By station, s.
    occupations_s: Vec<Range<f64>>,
}

impl Progress {
    /// Of visits in the order of the stations.
    pub(crate) fn new(visits: &[Visit<'_>]) -> Self {
        let occupations = visits.chunk_by(|a, b| a.station == b.station);
        Self {
            campaign_s: span_s(visits),
            occupations_s: occupations.map(span_s).collect(),
        }
    }
}

/// From the first to the last reading, s.
fn span_s(visits: &[Visit<'_>]) -> Range<f64> {
    let mut times_s = visits
        .iter()
        .flat_map(|visit| visit.times_s.iter().copied());
    let start = times_s.next().unwrap_or(0.0);
    start..times_s.last().unwrap_or(start)
}

/// The part of the span that is over at a time, 0 to 1; 0 if there is only one instant.
fn part(span_s: &Range<f64>, time_s: f64) -> f64 {
    let length_s = span_s.end - span_s.start;
    if length_s > 0.0 {
        (time_s - span_s.start) / length_s
    } else {
        0.0
    }
}
