//! What is wrong with the lengths, in the words of the campaign.

use trueaxis_campaign::{Campaign, Direction, Lengths, Stop};
use trueaxis_multilateration::{Error as MultilaterationError, Group, Part, StationUnknown};

use crate::{Error, describe};

/// What makes many lengths contradict the others.
const LOOK_AT: &str = "check that every row names its own station and target, that no beam was interrupted, \
                       and that no target or tripod was moved";

/// Pairs of lengths named before the rest is only counted.
const MOST_NAMED: usize = 5;

/// Where positions were approached from both sides, lost motion contradicts itself.
fn lost_motion(campaign: &Campaign, lengths: &Lengths) -> &'static str {
    let mut steps: Vec<Option<Direction>> = vec![None; campaign.steps.len()];
    let both = lengths.stops.iter().any(|stop| {
        let first = *steps[stop.step].get_or_insert(stop.direction);
        first != stop.direction
    });
    match both {
        true => "--by-direction tells lost motion from wrong lengths; ",
        false => "",
    }
}

/// A length as `line 7 (station S1, target P, run x at X = 20 mm)`.
pub(crate) fn length_in_words(campaign: &Campaign, lengths: &Lengths, reading: usize) -> String {
    let stop = stop_of(lengths, reading);
    let length = &lengths.readings[reading];
    format!(
        "line {} (station {}, target {}, {})",
        length.line,
        campaign.stations[stop.station].name,
        campaign.targets[length.target].name,
        describe::step(campaign, stop.step),
    )
}

/// The stop of a reading.
pub(crate) fn stop_of(lengths: &Lengths, reading: usize) -> &Stop {
    let stop = lengths
        .stops
        .partition_point(|stop| stop.readings.end <= reading);
    &lengths.stops[stop]
}

/// A failed adjustment in the words of the campaign; `groups` are those of its network.
pub(crate) fn adjustment_error(
    campaign: &Campaign,
    lengths: &Lengths,
    groups: &[Group],
    error: MultilaterationError,
) -> Error {
    let target_name = |group: usize, point: usize| {
        let target = groups[group].targets[point];
        let step = describe::step(campaign, groups[group].step);
        format!("target {} in {step}", campaign.targets[target].name)
    };
    let station = |j: usize| campaign.stations[j].name.clone();
    match error {
        MultilaterationError::TooFewStations { need, found } => Error::NotIdentifiable {
            what: format!(
                "stations and points together need lengths from at least {need} stations, found {found}"
            ),
            mend: "measure the whole path from more stations".to_owned(),
        },
        MultilaterationError::StationWithoutReadings { station: j } => Error::NotIdentifiable {
            what: format!("station {} has no lengths", station(j)),
            mend: "remove it from `stations`, or add its rows".to_owned(),
        },
        MultilaterationError::PointSeenTooRarely {
            group,
            point,
            seen,
            need,
        } => Error::NotIdentifiable {
            what: format!(
                "{} was measured from {seen} station(s), at least {need} are needed",
                target_name(group, point)
            ),
            mend: "measure it from the missing stations, or leave out the rows of this step"
                .to_owned(),
        },
        MultilaterationError::PointNotDetermined {
            group,
            point,
            pivot,
            limit,
        } => Error::NotIdentifiable {
            what: format!(
                "{}: the beams that meet there lie in one plane (relative pivot {pivot:.1e}, \
                     limit {limit:.1e})",
                target_name(group, point)
            ),
            mend: "place one station well above or below the others".to_owned(),
        },
        MultilaterationError::PoseNotDetermined {
            group,
            lengths,
            pivot,
            limit,
        } => Error::NotIdentifiable {
            what: format!(
                "{}: its {lengths} lengths do not determine the pose of the stage (relative pivot {pivot:.1e}, \
                 limit {limit:.1e})",
                describe::step(campaign, groups[group].step)
            ),
            mend: "measure it from the missing stations, or leave out the rows of this step; if none is missing, \
                   spread the stations in all directions"
                .to_owned(),
        },
        MultilaterationError::TooFewReadings { readings, unknowns } => Error::NotIdentifiable {
            what: format!("{readings} lengths cannot determine {unknowns} unknowns"),
            mend: "measure more steps, targets or stations".to_owned(),
        },
        MultilaterationError::StationsNotDetermined { defect, free, .. } => {
            Error::NotIdentifiable {
                what: format!(
                    "the lengths leave {defect} combination(s) of the stations free: {}",
                    unknowns_in_words(campaign, &free)
                ),
                mend:
                    "spread the stations in all directions around the machine, and let the targets \
                   move in all directions"
                        .to_owned(),
            }
        }
        MultilaterationError::NoStart {
            station: j,
            readings,
            rms_mm,
        } => Error::StationUnexplained {
            station: station(j),
            readings,
            rms_mm,
        },
        MultilaterationError::RanAway {
            reading,
            residual_mm,
        } => Error::RanAway {
            length: length_in_words(campaign, lengths, reading),
            residual_mm,
        },
        MultilaterationError::TooManyGrossErrors {
            removed,
            readings,
            limit,
        } => Error::NotTrustworthy {
            what: format!(
                "{} of {readings} lengths contradict the others, more than the {:.0} % that may be \
                 accidents; most of them: {}",
                removed.len(),
                limit * 100.0,
                most_of(campaign, lengths, &removed)
            ),
            mend: format!(
                "{LOOK_AT}; {}--no-robust adjusts all lengths as they are",
                lost_motion(campaign, lengths)
            ),
        },
        MultilaterationError::PartLost {
            part,
            removed,
            readings,
            ..
        } => Error::NotTrustworthy {
            what: format!(
                "{removed} of the {readings} lengths of {} contradict the others, more than a third",
                match part {
                    Part::Station(j) => format!("station {}", station(j)),
                    Part::Group(g) => describe::step(campaign, groups[g].step),
                }
            ),
            mend: format!(
                "{LOOK_AT}; {}--no-robust adjusts all lengths as they are",
                lost_motion(campaign, lengths)
            ),
        },
        MultilaterationError::Undecidable { pairs } => {
            let in_words = |&(reading, other): &(usize, usize)| {
                format!(
                    "{} and {}",
                    length_in_words(campaign, lengths, reading),
                    length_in_words(campaign, lengths, other)
                )
            };
            let named: Vec<String> = pairs.iter().take(MOST_NAMED).map(in_words).collect();
            let more = match pairs.len().saturating_sub(MOST_NAMED) {
                0 => String::new(),
                more => format!("; and {more} more"),
            };
            Error::NotTrustworthy {
                what: format!(
                    "lengths contradict each other, and nothing tells which one is wrong: {}{more}",
                    named.join("; ")
                ),
                mend: format!(
                    "measure these steps again, or leave out their rows; {}--no-robust adjusts all \
                     lengths as they are",
                    lost_motion(campaign, lengths)
                ),
            }
        }
        other => Error::NotIdentifiable {
            what: chain(&other),
            mend: "check the campaign with `trueaxis check`".to_owned(),
        },
    }
}

/// Says where the residuals are worst: by station, then by run.
pub(crate) fn contradictory(
    campaign: &Campaign,
    lengths: &Lengths,
    sigma0: f64,
    residuals_mm: &[f64],
) -> Error {
    let mut stations = vec![(0.0_f64, 0_usize); campaign.stations.len()];
    let mut runs = vec![(0.0_f64, 0_usize); campaign.runs.len()];
    let mut worst = (0.0_f64, 0);
    for stop in &lengths.stops {
        for i in stop.readings.clone() {
            let v = residuals_mm[i];
            for sum in [
                &mut stations[stop.station],
                &mut runs[campaign.steps[stop.step].run],
            ] {
                sum.0 += v * v;
                sum.1 += 1;
            }
            if v.abs() > worst.0 {
                worst = (v.abs(), lengths.readings[i].line);
            }
        }
    }
    let largest = |sums: &[(f64, usize)]| {
        let rms = |&(squares, count): &(f64, usize)| (squares / count.max(1) as f64).sqrt();
        let all = sums.iter().map(rms).enumerate();
        all.fold(
            (0, 0.0),
            |best, (k, rms)| if rms > best.1 { (k, rms) } else { best },
        )
    };
    let ((j, station_rms), (r, run_rms)) = (largest(&stations), largest(&runs));
    Error::Contradictory {
        rms_um: rms(residuals_mm) * 1e3,
        sigma0,
        worst: format!(
            "station {} ({:.1} µm rms), run {} ({:.1} µm rms), line {} of the lengths ({:.1} µm)",
            campaign.stations[j].name,
            station_rms * 1e3,
            campaign.runs[r].name,
            run_rms * 1e3,
            worst.1,
            worst.0 * 1e3
        ),
        hint: LOOK_AT.to_owned(),
    }
}

fn rms(values: &[f64]) -> f64 {
    let squares: f64 = values.iter().map(|v| v * v).sum();
    (squares / values.len().max(1) as f64).sqrt()
}

/// Where some lengths come from mostly: their commonest station, run and target.
fn most_of(campaign: &Campaign, lengths: &Lengths, readings: &[usize]) -> String {
    let mut stations = vec![0; campaign.stations.len()];
    let mut runs = vec![0; campaign.runs.len()];
    let mut targets = vec![0; campaign.targets.len()];
    for &reading in readings {
        let stop = stop_of(lengths, reading);
        stations[stop.station] += 1;
        runs[campaign.steps[stop.step].run] += 1;
        targets[lengths.readings[reading].target] += 1;
    }
    let most = |counts: &[usize]| (0..counts.len()).max_by_key(|&k| counts[k]).unwrap_or(0);
    let (j, r, t) = (most(&stations), most(&runs), most(&targets));
    format!(
        "station {} ({}), run {} ({}), target {} ({})",
        campaign.stations[j].name,
        stations[j],
        campaign.runs[r].name,
        runs[r],
        campaign.targets[t].name,
        targets[t]
    )
}

/// An error with its sources.
fn chain(error: &dyn std::error::Error) -> String {
    match error.source() {
        Some(source) => format!("{error}: {}", chain(source)),
        None => error.to_string(),
    }
}

fn unknowns_in_words(campaign: &Campaign, free: &[StationUnknown]) -> String {
    let names = ["x", "y", "z", "dead path"];
    let word = |u: &StationUnknown| {
        format!(
            "{} of {}",
            names[u.unknown], campaign.stations[u.station].name
        )
    };
    free.iter().map(word).collect::<Vec<_>>().join(", ")
}
