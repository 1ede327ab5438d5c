//! The headline verb: from lengths to points.

use std::sync::Arc;

use trueaxis_leastsquares::{Adjusted, Adjustment, LANES, adjust};

use crate::adjustment::GroupAdjustment;
use crate::batches::{Batch, batches, check_seen};
use crate::chunks::within_pool;
use crate::reflectors::constants_mm;
use crate::start::{Start, start};
use crate::state::{DATUM, PER_STATION, POSE, State, with_interruptions};
use crate::undetermined::named;
use crate::{Error, Network, Solution, Station};

/// Self-calibration needs four stations: with three, every new point brings as many unknowns as
/// lengths and the stations stay unknown.
pub const MIN_STATIONS: usize = 4;

/// A point needs three lengths.
pub const MIN_STATIONS_PER_POINT: usize = 3;

/// Two mirror images whose sums of squares differ by less than this are both possible: the likelihood ratio is below
/// e⁵.
const SAME_SQUARES: f64 = 10.0;

/// Largest number of stations for which both sides of a plane of points are tried; each doubles the attempts.
const MAX_OPEN_SIDES: usize = 8;

/// Finds all points, stations and dead paths of a network.
///
/// # Errors
/// If the network is malformed, or does not determine what is sought: see [`Error`]. Not converging is no error but a
/// [`Solution::termination`].
pub fn solve(network: &Network) -> Result<Solution, Error> {
    network.check()?;
    // First, so that too few lengths are reported as such.
    let batches = batches_of(network)?;
    solve_from_start(network, &batches, start(network)?)
}

/// Solves a checked network of these groups.
pub(crate) fn solve_from_start(
    network: &Network,
    batches: &Arc<Vec<Batch>>,
    start: Start,
) -> Result<Solution, Error> {
    let Start { state, images } = start;
    let first = adjust_from(network, batches, state.clone());
    if images.iter().all(Option::is_none) {
        return first?.solution();
    }
    choose_sides(network, batches, &state, &images, first)
}

/// Adjusts a network from the solution `near` of a similar one: the same stations and groups, but other lengths,
/// weights, interruptions or bodies. Its positions and dead paths are the start and may be some millimetres off.
/// Changing from tied points to free ones, or back, takes an iteration or two.
pub fn refine<'a>(network: &'a Network, near: &Solution) -> Result<Refined<'a>, Error> {
    network.check()?;
    within_pool(network.groups.len().div_ceil(LANES), || {
        refine_batches(network, &batches_of(network)?, near)
    })
}

/// [`refine`] for a checked network of these groups.
fn refine_batches<'a>(
    network: &'a Network,
    batches: &Arc<Vec<Batch>>,
    near: &Solution,
) -> Result<Refined<'a>, Error> {
    let (found, need) = (
        (near.stations.len(), near.points_mm.len()),
        (network.stations.len(), network.nominal_mm.len()),
    );
    if found != need {
        let what = format!("a solution of other stations and points: {found:?}, needed {need:?}");
        return Err(Error::malformed(what));
    }
    let mut state = near.state();
    state.dead_paths_mm = with_interruptions(network, state.dead_paths_mm);
    let sizes = network.bodies.iter().flat_map(|bodies| &bodies.bodies);
    let sizes = sizes.map(|body| body.home_mm.len());
    let poses = network.bodies.as_ref().map_or(0, |_| network.groups.len());
    state.contrasts_mm.resize(network.contrasts(), 0.0);
    if !network.has_mean_constant() {
        state.mean_constant_mm = 0.0;
    }
    let same_ties = state.poses.len() == poses && state.shapes_mm.iter().map(Vec::len).eq(sizes);
    if !same_ties {
        state = State {
            contrasts_mm: state.contrasts_mm,
            mean_constant_mm: state.mean_constant_mm,
            ..State::new(network, state.stations, state.dead_paths_mm, state.points)
        };
    }
    Ok(Refined {
        mirror_image_open: near.mirror_image_open,
        ..adjust_from(network, batches, state)?
    })
}

/// As [`refine`], with the covariance.
pub fn solve_from(network: &Network, near: &Solution) -> Result<Solution, Error> {
    refine(network, near)?.solution()
}

/// Solves a network again that differs from the one of the solution `solved` only in its noise: the groups need not
/// be arranged again.
pub fn solve_with_noise(network: &Network, solved: &Solution) -> Result<Solution, Error> {
    network.noise.check()?;
    refine_batches(network, &solved.batches, solved)?.solution()
}

/// An adjusted network, still without uncertainties.
pub struct Refined<'a> {
    model: GroupAdjustment<'a>,
    adjusted: Adjusted<State>,
    mirror_image_open: bool,
}

impl Refined<'_> {
    /// The whole solution with the covariance of everything.
    pub fn solution(self) -> Result<Solution, Error> {
        let Self {
            model,
            adjusted,
            mirror_image_open,
        } = self;
        let network = model.network;
        let covariance = adjusted.covariance(&model);
        let covariance = covariance.map_err(|error| named(network, error))?;
        let state = &adjusted.state;
        let stations = state.stations.iter().zip(&state.dead_paths_mm);
        let residuals_mm = state.residuals_mm(network);
        Ok(Solution {
            stations: stations
                .map(|(&position_mm, &dead_path_mm)| Station {
                    position_mm,
                    dead_path_mm,
                })
                .collect(),
            dead_paths_after_mm: state.dead_paths_mm[network.stations.len()..].to_vec(),
            residuals_mm,
            squares: adjusted.squares,
            observations: adjusted.observations,
            unknowns: adjusted.unknowns,
            iterations: adjusted.iterations,
            mirror_image_open,
            termination: adjusted.termination,
            covariance,
            batches: model.batches,
            points_mm: adjusted.state.points,
            poses: adjusted.state.poses,
            shapes_mm: adjusted.state.shapes_mm,
            mean_constant_mm: network
                .has_mean_constant()
                .then_some(adjusted.state.mean_constant_mm),
            reflectors_mm: constants_mm(&adjusted.state.contrasts_mm),
        })
    }
}

fn adjust_from<'a>(
    network: &'a Network,
    batches: &Arc<Vec<Batch>>,
    start: State,
) -> Result<Refined<'a>, Error> {
    within_pool(batches.len(), || {
        let model = GroupAdjustment::new(network, batches);
        let adjusted = adjust(&model, &start)
            .map_err(|error| ran_away(network, &model, &start, named(network, error)))?;
        Ok(Refined {
            model,
            adjusted,
            mirror_image_open: false,
        })
    })
}

/// A length that is nearer than this to what the nominal positions say drives no adjustment away, mm.
const ABSURD_MM: f64 = 1.0;

/// A length that is off by more than this at the start, relative to the size of the network, contradicts the others:
/// nominal positions are never that wrong.
const CONTRADICTION: f64 = 0.02;

/// Distinguishes a station that is not determined from one that contradictory lengths drove away.
fn ran_away(network: &Network, model: &GroupAdjustment<'_>, start: &State, error: Error) -> Error {
    if !matches!(error, Error::StationsNotDetermined { .. }) {
        return error;
    }
    let determined = model
        .reduce(start, &mut Vec::new())
        .and_then(|system| system.shortest_correction(&model.free_motions(start)))
        .is_ok();
    let worst = start
        .residuals_mm(network)
        .into_iter()
        .enumerate()
        .max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
    match worst {
        Some((reading, residual_mm))
            if determined && residual_mm.abs() >= ABSURD_MM
                || residual_mm.abs() > CONTRADICTION * model.datum.radius_mm =>
        {
            Error::RanAway {
                reading,
                residual_mm,
            }
        }
        _ => error,
    }
}

/// For the stations whose side of the plane of points is open, tries all combinations of sides, and tests whether the
/// mirror image of the whole fits as well as the best one.
///
/// Moving one station at a time would be cheaper, but fails with two on the wrong side.
fn choose_sides<'a>(
    network: &'a Network,
    batches: &Arc<Vec<Batch>>,
    start: &State,
    images: &[Option<Station>],
    first: Result<Refined<'a>, Error>,
) -> Result<Solution, Error> {
    let open: Vec<usize> = (0..images.len()).filter(|&j| images[j].is_some()).collect();
    let tried = open.len().min(MAX_OPEN_SIDES);
    let with_sides = |choice: usize| {
        let mut state = start.clone();
        for (bit, &j) in open[..tried].iter().enumerate() {
            if let Some(image) = images[j].filter(|_| choice >> bit & 1 == 1) {
                state.stations[j] = image.position_mm;
                state.dead_paths_mm[j] = image.dead_path_mm;
            }
        }
        adjust_from(network, batches, state)
    };
    let (mut best, mut chosen) = (first, 0);
    let all = (1 << tried) - 1;
    for choice in 1..=all {
        // A wrong combination may not even be solvable.
        let Ok(attempt) = with_sides(choice) else {
            continue;
        };
        let better =
            |best: &Refined<'_>| attempt.adjusted.squares < best.adjusted.squares - SAME_SQUARES;
        if best.as_ref().map_or(true, better) {
            (best, chosen) = (Ok(attempt), choice);
        }
    }
    let mut best = best?;
    // If sides were not tried, the image is open, too.
    best.mirror_image_open = tried < open.len()
        || open.len() == images.len()
            && with_sides(all ^ chosen).is_ok_and(|image| {
                (image.adjusted.squares - best.adjusted.squares).abs() < SAME_SQUARES
            });
    best.solution()
}

/// The groups of a network, after checking that every station and point has enough lengths.
pub(crate) fn batches_of(network: &Network) -> Result<Arc<Vec<Batch>>, Error> {
    let mut used = vec![false; network.stations.len()];
    for visit in &network.visits {
        // Unconditional stores would each wait for the one before.
        if !used[visit.station] {
            used[visit.station] = !visit.readings.is_empty();
        }
    }
    let (need, found) = (MIN_STATIONS, used.iter().filter(|&&used| used).count());
    if found < need {
        return Err(Error::TooFewStations { need, found });
    }
    if let Some(station) = used.iter().position(|used| !used) {
        return Err(Error::StationWithoutReadings { station });
    }
    let batches = batches(network);
    check_seen(&batches, MIN_STATIONS_PER_POINT)?;
    let readings = network.readings.len();
    // A mean constant needs no length: known dead paths determine it.
    let shared = PER_STATION * found + network.interruptions.len();
    let of_batch = |batch: &Batch| batch.groups.len() * batch.unknowns();
    let of_groups: usize = batches.iter().map(of_batch).sum();
    let bodies = network.bodies.iter().flat_map(|bodies| &bodies.bodies);
    let shapes: usize = bodies
        .map(|body| (3 * body.home_mm.len()).saturating_sub(POSE))
        .sum();
    // Neither do contrasts with a known σ.
    let contrasts = match network.contrast_sigma_mm() {
        Some(_) => 0,
        None => network.contrasts(),
    };
    let unknowns = of_groups + shared + shapes + contrasts - DATUM;
    if readings < unknowns {
        return Err(Error::TooFewReadings { readings, unknowns });
    }
    Ok(Arc::new(batches))
}
