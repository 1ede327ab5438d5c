//! Lengths to points, with errors in the words of the campaign.

use trueaxis_campaign::{Campaign, Lengths};
use trueaxis_kinematics::MICROMETRE;
use trueaxis_multilateration::{
    CampaignNetwork, Error as MultilaterationError, Solution, StationUnknown,
    network_from_campaign, solve,
};

use crate::measured::{Measured, MeasuredGroup, NoiseSource, PointNoise};
use crate::{Error, describe};

/// A residual this many times its noise in the mean is no noise: something in the data is wrong.
const CONTRADICTORY_SIGMA0: f64 = 100.0;

/// The adjusted points, the solution they come from, and notices.
pub(crate) fn measure(
    campaign: &Campaign,
    lengths: &Lengths,
    by_direction: bool,
) -> Result<(Measured, Solution, Vec<String>), Error> {
    let CampaignNetwork { network, groups } =
        network_from_campaign(campaign, lengths, by_direction);
    let target_name = |group: usize, point: usize| {
        let target = groups[group].targets[point];
        let step = describe::step(campaign, groups[group].step);
        format!("target {} in {step}", campaign.targets[target].name)
    };
    let solution = solve(&network, &trueaxis_multilateration::Settings::default())
        .map_err(|error| in_words(campaign, lengths, error, &target_name))?;
    let weak = weak_stations(campaign, lengths, &solution)?;
    if !solution.termination.is_converged() {
        let termination = solution.termination.to_string();
        return Err(Error::NotConverged {
            iterations: solution.iterations,
            termination,
        });
    }
    if solution.sigma0() > CONTRADICTORY_SIGMA0 {
        return Err(contradictory(campaign, lengths, &solution));
    }
    let mut measured_groups = Vec::new();
    for (group, points) in groups.into_iter().zip(&network.groups) {
        measured_groups.push(MeasuredGroup {
            step: group.step,
            direction: group.direction,
            targets: group.targets,
            points: points.clone(),
        });
    }
    let measured = Measured {
        groups: measured_groups,
        points_mm: solution.points_mm.clone(),
        noise: PointNoise {
            source: NoiseSource::Adjusted(solution.covariance.clone()),
            variance_factor: 1.0,
        },
        repeat_scatter: (0.0, 0),
    };
    Ok((measured, solution, weak))
}

/// Second-order error of a length, in standard deviations of its noise, from which a station is
/// worth a notice, and from which nothing that follows from it can be trusted.
const WEAK_STATION: f64 = 1.0;
const HOPELESS_STATION: f64 = 5.0;

/// Stations that are so poorly determined that uncertainties of first order mean little: the length
/// to a station that is off by u across the beam is off by u²/2d, which no linear propagation sees.
fn weak_stations(
    campaign: &Campaign,
    lengths: &Lengths,
    solution: &Solution,
) -> Result<Vec<String>, Error> {
    let noise_mm = campaign.instrument.length_sigma_um.unwrap_or(1.0) * MICROMETRE;
    let mut nearest_mm = vec![f64::INFINITY; solution.stations.len()];
    for stop in &lengths.stops {
        for i in stop.readings.clone() {
            let station = &solution.stations[stop.station];
            let distance_mm =
                lengths.readings[i].length_mm + station.dead_path_mm - solution.residuals_mm[i];
            nearest_mm[stop.station] = nearest_mm[stop.station].min(distance_mm.abs());
        }
    }
    let mut weak = Vec::new();
    for (j, (station, distance_mm)) in campaign.stations.iter().zip(nearest_mm).enumerate() {
        let covariance = solution.station_covariance(j);
        let position = covariance.fixed_view::<3, 3>(0, 0).into_owned();
        let variance_mm2 = position.symmetric_eigenvalues().max();
        let second_order = variance_mm2 / (2.0 * distance_mm) / noise_mm;
        let what = format!(
            "station {} is known to {:.1} mm only (standard uncertainty), so poorly that first-order \
             uncertainties",
            station.name,
            variance_mm2.sqrt()
        );
        if second_order.is_nan() || second_order > HOPELESS_STATION {
            return Err(Error::NotIdentifiable {
                what: format!("{what} mean nothing"),
                mend: "spread the stations in all directions, heights included; let the targets \
                       move through a larger volume"
                    .to_owned(),
            });
        }
        if second_order > WEAK_STATION {
            weak.push(format!("{what} may be too small: spread the stations more"));
        }
    }
    Ok(weak)
}

/// The length with the largest residual, in words.
pub(crate) fn worst_length(campaign: &Campaign, lengths: &Lengths, solution: &Solution) -> String {
    let residuals = solution.residuals_mm.iter().map(|v| v.abs()).enumerate();
    residuals
        .max_by(|a, b| a.1.total_cmp(&b.1))
        .map_or_else(String::new, |(i, residual_mm)| {
            format!(
                "{} with {:.1} µm",
                length_in_words(campaign, lengths, i),
                residual_mm / MICROMETRE
            )
        })
}

/// A length as `line 7 (station S1, target P, run x at X = 20 mm)`.
fn length_in_words(campaign: &Campaign, lengths: &Lengths, reading: usize) -> String {
    let stop = lengths
        .stops
        .partition_point(|stop| stop.readings.end <= reading);
    let stop = &lengths.stops[stop];
    let length = &lengths.readings[reading];
    format!(
        "line {} (station {}, target {}, {})",
        length.line,
        campaign.stations[stop.station].name,
        campaign.targets[length.target].name,
        describe::step(campaign, stop.step),
    )
}

fn in_words(
    campaign: &Campaign,
    lengths: &Lengths,
    error: MultilaterationError,
    target_name: &impl Fn(usize, usize) -> String,
) -> Error {
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
        other => Error::NotIdentifiable {
            what: chain(&other),
            mend: "check the campaign with `trueaxis check`".to_owned(),
        },
    }
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

/// Says where the residuals are worst: by station, then by run.
fn contradictory(campaign: &Campaign, lengths: &Lengths, solution: &Solution) -> Error {
    let mut stations = vec![(0.0_f64, 0_usize); campaign.stations.len()];
    let mut runs = vec![(0.0_f64, 0_usize); campaign.runs.len()];
    let mut worst = (0.0_f64, 0);
    for stop in &lengths.stops {
        for i in stop.readings.clone() {
            let v = solution.residuals_mm[i];
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
        rms_um: solution.rms_residual_mm() * 1e3,
        sigma0: solution.sigma0(),
        worst: format!(
            "station {} ({:.1} µm rms), run {} ({:.1} µm rms), line {} of the lengths ({:.1} µm)",
            campaign.stations[j].name,
            station_rms * 1e3,
            campaign.runs[r].name,
            run_rms * 1e3,
            worst.1,
            worst.0 * 1e3
        ),
        hint: "check that every row names its own station, that no beam was interrupted, and that \
               no target or tripod was moved"
            .to_owned(),
    }
}
