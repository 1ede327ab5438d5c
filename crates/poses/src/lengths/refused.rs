//! What is wrong with the lengths, in the words of the campaign.

use trueaxis_campaign::{Campaign, Lengths, Stop};
use trueaxis_files::counted;
use trueaxis_multilateration::{Error as Failure, StationUnknown};
use trueaxis_screening::{Error as Rejection, Part};

use crate::Error;
use crate::lengths::network::Group;
use crate::report::approached_from_both_sides;
use crate::words::{length_in_words, step_in_words, stop_of};

/// What makes many lengths contradict the others.
pub(crate) const LOOK_AT: &str = "check that every row names its own station and target, that no beam was interrupted, \
                       and that no target or tripod was moved";

/// The same where residuals that are noise contradict what is declared of it by a unit: mm for µm.
const ASK_UNIT: &str = "that is little for lengths, and noise may be declared in mm: `length_sigma_um` and `repeatability_um` are in µm";
const A_UNIT: f64 = 100.0;
const NOISE_MM: f64 = 0.02;

/// Pairs of lengths named before the rest is only counted.
const MOST_NAMED: usize = 5;

/// What to do about lengths that contradict others: `first`, or adjust them all. Where positions were
/// approached from both sides, lost motion contradicts itself.
pub(crate) fn or_as_they_are(campaign: &Campaign, first: &str) -> String {
    let by_direction = match approached_from_both_sides(campaign) {
        true => "--by-direction tells lost motion from wrong lengths; ",
        false => "",
    };
    format!("{first}; {ASK_WHY}; {by_direction}{AS_THEY_ARE}")
}

/// Where a contradiction has a cause that has a name.
pub(crate) const ASK_WHY: &str = "`trueaxis diagnose` looks for what explains them";

pub(crate) const AS_THEY_ARE: &str = "--no-robust adjusts all lengths as they are";

impl Error {
    /// What a diagnosis says that is refused as well: without the advice to ask for one, or to calibrate otherwise.
    pub fn of_a_diagnosis(self) -> Self {
        let Self::NotTrustworthy { what, hint } = self else {
            return self;
        };
        let hint = hint
            .split("; ")
            .filter(|advice| ![ASK_WHY, AS_THEY_ARE].contains(advice));
        Self::NotTrustworthy {
            what,
            hint: hint.collect::<Vec<_>>().join("; "),
        }
    }
}

/// A failed adjustment in the words of the campaign; `groups` are those of its network.
pub(crate) fn adjustment_error(
    campaign: &Campaign,
    lengths: &Lengths,
    groups: &[Group],
    failure: Failure,
) -> Error {
    let step = |group: usize| step_in_words(campaign, groups[group].step);
    let target = |group: usize, point: usize| {
        let name = &campaign.targets[groups[group].targets[point]].name;
        format!("target {name} in {}", step(group))
    };
    let station = |j: usize| campaign.stations[j].name.clone();
    match failure {
        Failure::TooFewStations { need, found } => Error::not_identifiable(
            format!(
                "stations and points together need lengths from at least {need} stations, found {found}"
            ),
            "measure the whole path from more stations",
        ),
        Failure::StationWithoutReadings { station: j } => Error::not_identifiable(
            format!("station {} has no lengths", station(j)),
            "remove it from `stations`, or add its rows",
        ),
        Failure::PointSeenTooRarely {
            group,
            point,
            seen,
            need,
        } => Error::not_identifiable(
            format!(
                "{} was measured from {}, at least {need} are needed",
                target(group, point),
                counted(seen, "station")
            ),
            "measure it from the missing stations, or leave out the rows of this step",
        ),
        Failure::PointNotDetermined {
            group,
            point,
            pivot,
            limit,
        } => Error::not_identifiable(
            format!(
                "{}: the beams that meet there lie in one plane (relative pivot {pivot:.1e}, \
                 limit {limit:.1e})",
                target(group, point)
            ),
            "place one station well above or below the others",
        ),
        Failure::PoseNotDetermined {
            group,
            lengths,
            pivot,
            limit,
        } => Error::not_identifiable(
            format!(
                "{}: its {lengths} lengths do not determine the pose of the stage (relative pivot {pivot:.1e}, \
                 limit {limit:.1e})",
                step(group)
            ),
            "measure it from the missing stations, or leave out the rows of this step; if none is missing, \
             spread the stations in all directions",
        ),
        Failure::TooFewReadings { readings, unknowns } => Error::not_identifiable(
            format!("{readings} lengths cannot determine {unknowns} unknowns"),
            "measure more steps, targets or stations",
        ),
        Failure::StationsNotDetermined { defect, free, .. } => Error::not_identifiable(
            format!(
                "the lengths leave {} of the stations free: {}",
                counted(defect, "combination"),
                unknowns_in_words(campaign, &free)
            ),
            "spread the stations in all directions around the machine, and let the targets move in all \
             directions",
        ),
        Failure::ReflectorsNotDetermined { .. } => Error::not_identifiable(
            "the lengths do not determine how the constants of the reflectors differ".to_owned(),
            "declare `reflector_sigma_um` of the instrument, or move one reflector from nest to nest (the same \
             `reflector` for all targets)",
        ),
        Failure::NoStart {
            station: j,
            readings,
            rms_mm,
        } => Error::StationUnexplained {
            station: station(j),
            readings,
            rms_mm,
        },
        Failure::RanAway {
            reading,
            residual_mm,
        } => Error::RanAway {
            length: length_in_words(campaign, lengths, reading),
            residual_mm,
        },
        other => Error::not_identifiable(chain(&other), "check the campaign with `trueaxis check`"),
    }
}

/// Failed screening in the words of the campaign; `groups` are those of its network.
pub(crate) fn screening_error(
    campaign: &Campaign,
    lengths: &Lengths,
    groups: &[Group],
    rejection: Rejection,
) -> Error {
    let length = |reading: usize| length_in_words(campaign, lengths, reading);
    match rejection {
        Rejection::Adjustment(failure) => adjustment_error(campaign, lengths, groups, failure),
        Rejection::TooManyGrossErrors {
            removed,
            readings,
            limit,
        } => Error::not_trustworthy(
            format!(
                "{} of {readings} lengths contradict the others, more than the {:.0} % that may be \
                 accidents; most of them: {}",
                removed.len(),
                limit * 100.0,
                most_of(campaign, lengths, &removed)
            ),
            or_as_they_are(campaign, LOOK_AT),
        ),
        Rejection::PartLost {
            part,
            removed,
            readings,
            ..
        } => Error::not_trustworthy(
            format!(
                "{removed} of the {readings} lengths of {} contradict the others, more than a third",
                match part {
                    Part::Station(j) => format!("station {}", campaign.stations[j].name),
                    Part::Group(g) => step_in_words(campaign, groups[g].step),
                }
            ),
            or_as_they_are(campaign, LOOK_AT),
        ),
        Rejection::Undecidable { pairs } => {
            let named = pairs.iter().take(MOST_NAMED);
            let named = named.map(|&(one, other)| format!("{} and {}", length(one), length(other)));
            let named: Vec<String> = named.collect();
            let more = match pairs.len().saturating_sub(MOST_NAMED) {
                0 => String::new(),
                more => format!("; and {more} more"),
            };
            Error::not_trustworthy(
                format!(
                    "lengths contradict each other, and nothing tells which one is wrong: {}{more}",
                    named.join("; ")
                ),
                or_as_they_are(
                    campaign,
                    "measure these steps again, or leave out their rows",
                ),
            )
        }
    }
}

/// Says where the residuals are worst: by station, then by run.
pub(crate) fn contradictory(
    campaign: &Campaign,
    lengths: &Lengths,
    sigma0: f64,
    residuals_mm: &[f64],
) -> Error {
    let worst_of = |count: usize, place: &dyn Fn(&Stop) -> Option<usize>| {
        let mut sums = vec![(0.0, 0_usize); count];
        for stop in &lengths.stops {
            let Some(place) = place(stop) else { continue };
            let (squares, lengths) = &mut sums[place];
            *lengths += stop.readings.len();
            for v in &residuals_mm[stop.readings.clone()] {
                *squares += v * v;
            }
        }
        let rms = |&(squares, count): &(f64, usize)| (squares / count.max(1) as f64).sqrt();
        let all = sums.iter().map(rms).enumerate();
        // The first of equal ones.
        all.rev()
            .max_by(|a, b| a.1.total_cmp(&b.1))
            .unwrap_or_default()
    };
    let (_, rms) = worst_of(1, &|_| Some(0));
    let (j, station_rms) = worst_of(campaign.stations.len(), &|stop| Some(stop.station));
    let (r, run_rms) = worst_of(campaign.runs.len(), &|stop| campaign.steps[stop.step].run);
    let sizes = residuals_mm.iter().map(|v| v.abs()).zip(&lengths.readings);
    let worst = sizes.rev().max_by(|a, b| a.0.total_cmp(&b.0));
    let (worst_mm, line) = worst.map_or((0.0, 0), |(size_mm, reading)| (size_mm, reading.line));
    Error::Contradictory {
        rms_um: rms * 1e3,
        sigma0,
        worst: format!(
            "station {} ({:.1} µm rms), run {} ({:.1} µm rms), line {} of the lengths ({:.1} µm)",
            campaign.stations[j].name,
            station_rms * 1e3,
            campaign.runs[r].name,
            run_rms * 1e3,
            line,
            worst_mm * 1e3
        ),
        hint: match sigma0 > A_UNIT && rms < NOISE_MM {
            true => ASK_UNIT,
            false => LOOK_AT,
        },
    }
}

/// Where some lengths come from mostly: their commonest station, run and target.
fn most_of(campaign: &Campaign, lengths: &Lengths, readings: &[usize]) -> String {
    let mut stations = vec![0; campaign.stations.len()];
    let mut runs = vec![0; campaign.runs.len()];
    let mut targets = vec![0; campaign.targets.len()];
    for &reading in readings {
        let stop = stop_of(lengths, reading);
        stations[stop.station] += 1;
        if let Some(run) = campaign.steps[stop.step].run {
            runs[run] += 1;
        }
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
