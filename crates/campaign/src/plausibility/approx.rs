//! Lengths against the rough positions of the stations.
//!
//! From `approx_mm` the changes of all lengths can be predicted to some mm (a station that is 100 mm off at 2 m sees the motion
//! from an angle 3° off). Nothing is said unless the lengths are [`LEAST_MISFIT_MM`] from the prediction and fit [`BETTER`] times
//! better in another unit, or from another station's place.

use std::path::Path;

use nalgebra::Point3;

use super::hypothesis::{self, Hypothesis};
use super::nominal::NominalPoints;
use crate::reading::readings_of;
use crate::{Campaign, Error, Lengths, Place, Problem};

/// Misfit, mm, that rough positions may have without anything being wrong.
const LEAST_MISFIT_MM: f64 = 20.0;

/// How many times better another explanation must fit.
const BETTER: f64 = 20.0;

/// Part of the readings that the misfit describes; the others may be wrong altogether.
const COUNTED_PART: f64 = 0.8;

/// Readings of a station that are compared, evenly taken from all.
const SAMPLE: usize = 1000;

/// Fewer readings of a station prove nothing.
const LEAST_SAMPLE: usize = 10;

/// Refuses lengths in another unit and lengths under the name of another station.
pub(crate) fn check(
    file: &Path,
    campaign: &Campaign,
    lengths: &Lengths,
    nominal: &NominalPoints,
) -> Result<(), Error> {
    let samples = samples(lengths, nominal, campaign.stations.len());
    let seen: Option<Vec<Seen>> = (campaign.stations.iter().zip(samples).enumerate())
        .filter(|(_, (_, sample))| sample.readings.len() >= LEAST_SAMPLE)
        .map(|(station, (entry, sample))| {
            let approx_mm = entry.approx_mm?;
            Some(Seen {
                station,
                approx_mm,
                misfit_mm: sample.misfit_mm(approx_mm, 1.0),
                sample,
            })
        })
        .collect();
    let seen = seen.filter(|seen| seen.len() >= 2).unwrap_or_default();
    for station in &seen {
        check_unit(file, campaign, station)?;
    }
    check_names(file, campaign, &seen)
}

/// A station with its rough position and some of its lengths.
struct Seen {
    station: usize,
    approx_mm: Point3<f64>,
    /// Of the lengths to it as they are, mm.
    misfit_mm: f64,
    sample: Sample,
}

/// Nominal points and the lengths measured to them.
#[derive(Default, Clone)]
struct Sample {
    first_line: usize,
    readings: Vec<(Point3<f64>, f64)>,
}

impl Sample {
    /// How far the lengths times `factor` are from the distances to `station`, mm, for all but a
    /// fifth of them. The dead path is the median difference.
    fn misfit_mm(&self, station: Point3<f64>, factor: f64) -> f64 {
        let difference_mm = |(point, length_mm): &(Point3<f64>, f64)| {
            factor * length_mm - nalgebra::distance(point, &station)
        };
        let differences: Vec<f64> = self.readings.iter().map(difference_mm).collect();
        let dead_path_mm = quantile(differences.clone(), 0.5);
        let deviations = differences.iter().map(|d| (d - dead_path_mm).abs());
        quantile(deviations.collect(), COUNTED_PART)
    }
}

/// The value that a `part` of all values does not exceed; zero if there is none.
fn quantile(mut values: Vec<f64>, part: f64) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    // Exact for all sample sizes: a part of a count is far below 2^53.
    #[expect(clippy::cast_possible_truncation, reason = "the part is below one")]
    let index = (part * values.len() as f64) as usize;
    values.get(index).copied().unwrap_or_default()
}

fn samples(lengths: &Lengths, nominal: &NominalPoints, stations: usize) -> Vec<Sample> {
    let mut counts = vec![0_usize; stations];
    for stop in &lengths.stops {
        counts[stop.station] += stop.readings.len();
    }
    let mut passed = vec![0_usize; stations];
    let mut samples = vec![Sample::default(); stations];
    for stop in &lengths.stops {
        let (sample, passed) = (&mut samples[stop.station], &mut passed[stop.station]);
        let every = counts[stop.station].div_ceil(SAMPLE).max(1);
        for reading in readings_of(stop, &lengths.readings) {
            if *passed == 0 {
                sample.first_line = reading.line;
            }
            if passed.is_multiple_of(every) {
                let point = nominal.at(stop.step, reading.target);
                sample.readings.push((point, reading.length_mm));
            }
            *passed += 1;
        }
    }
    samples
}

fn is_overwhelming(own_mm: f64, other_mm: f64) -> bool {
    own_mm > LEAST_MISFIT_MM && BETTER * other_mm < own_mm
}

fn check_unit(file: &Path, campaign: &Campaign, seen: &Seen) -> Result<(), Error> {
    let misfit_mm = seen.misfit_mm;
    let fits = |hypothesis: &Hypothesis| {
        let factor = hypothesis.measured_factor(seen.station);
        is_overwhelming(misfit_mm, seen.sample.misfit_mm(seen.approx_mm, factor))
    };
    let suspects = hypothesis::for_small_lengths(campaign);
    match suspects.into_iter().find(fits).and_then(|h| h.mistake) {
        Some(mistake) => Err(Problem::ScaleAgainstApprox {
            station: campaign.stations[seen.station].name.clone(),
            misfit_mm,
            mistake,
        }
        .at(Place::column(file, seen.sample.first_line, "length_mm"))),
        None => Ok(()),
    }
}

/// A station is refused only if the one that it seems to be is refused too: names were exchanged
/// among some stations. One wrong `approx_mm` alone harms nobody.
fn check_names(file: &Path, campaign: &Campaign, seen: &[Seen]) -> Result<(), Error> {
    let seems_to_be = |one: &Seen| {
        let misfits = seen.iter().map(|s| one.sample.misfit_mm(s.approx_mm, 1.0));
        let best = misfits.enumerate().min_by(|a, b| a.1.total_cmp(&b.1));
        best.filter(|&(_, best_mm)| is_overwhelming(one.misfit_mm, best_mm))
    };
    let seems_to_be: Vec<Option<(usize, f64)>> = seen.iter().map(seems_to_be).collect();
    for (one, other) in seen.iter().zip(&seems_to_be) {
        let Some((index, fits_misfit_mm)) = *other else {
            continue;
        };
        if seems_to_be[index].is_some() {
            return Err(Problem::SwappedStations {
                station: campaign.stations[one.station].name.clone(),
                fits: campaign.stations[seen[index].station].name.clone(),
                own_misfit_mm: one.misfit_mm,
                fits_misfit_mm,
            }
            .at(Place::column(file, one.sample.first_line, "station")));
        }
    }
    Ok(())
}
