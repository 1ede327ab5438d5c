//! The same campaign with other errors of its measurement, as often as asked: Monte Carlo, and the
//! effect of single errors.
//!
//! A trial's lengths are those that follow from the adjusted state, plus errors. The points come from
//! [`trueaxis_multilateration::Trials`] (one factorisation, one corrector step), the component and
//! location errors from Newton's method with the operators of the calibration and exact deviations,
//! repeated until the reference frame has settled; what holding the operators costs is some 3e-5 of
//! a standard uncertainty. Weights stay as they are. In a points campaign the points themselves are drawn.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector, Point3, Vector3};
use rand_distr::{Distribution, StandardNormal};
use trueaxis_campaign::Campaign;
use trueaxis_kinematics::Machine;
use trueaxis_montecarlo::{ChaCha8Rng, Model};
use trueaxis_multilateration::{Corrections, Screened, Trials};

use crate::Error;
use crate::axis_data::AxisData;
use crate::calibrate::{Parts, calibrate_in_parts};
use crate::calibration::Calibration;
use crate::identify_axes::Identified;
use crate::measured::Measured;
use crate::records::Context;
use crate::results::NumberedResult;
use crate::settings::{Method, Settings};
use crate::state::State;

/// A calibrated campaign that can be calibrated again with other errors of its measurement.
///
/// As a [`Model`] it draws the noise and gives the results, in the order and units of
/// [`Replay::results`].
pub struct Replay<'a> {
    campaign: &'a Campaign,
    method: Method,
    machine: Machine,
    measured: Measured,
    data: Vec<AxisData>,
    identified: Identified,
    source: Source,
    /// Results that are not defined by gauge or frame, and their places among all.
    results: Vec<NumberedResult>,
    places: Vec<usize>,
}

/// Where the errors of the points come from.
enum Source {
    Lengths {
        trials: Box<Trials>,
        screened: Arc<Screened>,
    },
    /// Cholesky factors of the covariances of the groups.
    Points(Vec<DMatrix<f64>>),
}

/// Storage of a trial.
pub struct ReplayWorkspace {
    lengths: Option<trueaxis_multilateration::Workspace>,
    errors_mm: Vec<f64>,
    points_mm: Vec<Point3<f64>>,
    all: Vec<f64>,
}

/// Calibrates a campaign and keeps what other errors of its measurement need.
///
/// # Errors
/// Those of [`crate::calibrate`].
pub fn calibrate_for_replay<'a>(
    campaign: &'a Campaign,
    settings: &Settings,
) -> Result<(Calibration, Replay<'a>), Error> {
    let (calibration, parts) = calibrate_in_parts(campaign, settings)?;
    let Parts {
        machine,
        measured,
        data,
        identified,
        screened,
    } = parts;
    let source = match screened {
        Some(screened) => Source::Lengths {
            trials: Box::new(Trials::new(&screened.network, &screened.solution)),
            screened,
        },
        None => Source::Points(point_factors(&measured)?),
    };
    let (places, results) = calibration
        .results()
        .into_iter()
        .enumerate()
        .filter(|(_, result)| result.u > 0.0)
        .unzip();
    let replay = Replay {
        campaign,
        method: settings.method,
        machine,
        measured,
        data,
        identified,
        source,
        results,
        places,
    };
    Ok((calibration, replay))
}

fn point_factors(measured: &Measured) -> Result<Vec<DMatrix<f64>>, Error> {
    (0..measured.groups.len())
        .map(|group| {
            let covariance = measured
                .noise
                .total(group, measured.groups[group].points.len());
            let factor = covariance.cholesky().map(|factor| factor.unpack());
            factor.ok_or_else(|| Error::Numerical {
                axis: "all".to_owned(),
                what: format!("the covariance of the points of step {group} is not positive"),
            })
        })
        .collect()
}

impl Replay<'_> {
    /// The results of the calibration, without those that gauge or frame define.
    pub fn results(&self) -> &[NumberedResult] {
        &self.results
    }

    /// The readings of the campaign whose lengths were used, in measuring order; none in a points
    /// campaign.
    pub(crate) fn used_lengths(&self) -> &[usize] {
        self.screened().map_or(&[], |screened| &screened.kept)
    }

    /// The adjusted lengths; none in a points campaign.
    pub(crate) fn screened(&self) -> Option<&Screened> {
        match &self.source {
            Source::Lengths { screened, .. } => Some(screened),
            Source::Points(_) => None,
        }
    }

    /// The results for these errors of the used lengths (mm), beyond those of the calibration; in the
    /// units of the results' [`crate::Output::unit`]. Not a number if they do not settle: errors so
    /// large belong to another machine.
    ///
    /// # Panics
    /// If there is not one error for each used length and one place for each result.
    pub fn respond(&self, errors_mm: &[f64], workspace: &mut ReplayWorkspace, results: &mut [f64]) {
        workspace.errors_mm.copy_from_slice(errors_mm);
        self.solve(workspace, results);
    }

    fn solve(&self, workspace: &mut ReplayWorkspace, results: &mut [f64]) {
        let ReplayWorkspace {
            lengths,
            errors_mm,
            points_mm,
            all,
        } = workspace;
        let mut corrections: Option<&Corrections> = None;
        match (&self.source, lengths) {
            (Source::Lengths { trials, .. }, Some(lengths)) => {
                let solved = trials.solve(errors_mm, lengths);
                let moved = self.measured.points_mm.iter().zip(solved.points_mm());
                for (point, (own, by)) in points_mm.iter_mut().zip(moved) {
                    *point = own + by;
                }
                corrections = Some(solved);
            }
            _ => {
                let errors = errors_mm.chunks_exact(3);
                for ((point, own), error) in points_mm
                    .iter_mut()
                    .zip(&self.measured.points_mm)
                    .zip(errors)
                {
                    *point = own + Vector3::from_column_slice(error);
                }
            }
        }
        let context = Context {
            campaign: self.campaign,
            machine: &self.machine,
            measured: &self.measured,
            points_mm,
            method: self.method,
        };
        let Some(state) = self.identified.replayed(&context, &self.data) else {
            results.fill(f64::NAN);
            return;
        };
        all.clear();
        self.collect(&state, corrections, all);
        for ((result, &place), numbered) in results.iter_mut().zip(&self.places).zip(&self.results)
        {
            *result = all[place] / numbered.output.unit().size();
        }
    }

    /// All results in mm and rad, in the order of [`Calibration::results`].
    fn collect(&self, state: &State, corrections: Option<&Corrections>, all: &mut Vec<f64>) {
        for axis in &state.axes {
            for error in &axis.curve {
                all.extend(error.to_vector().iter());
            }
        }
        let reported = &self.identified.reported;
        for (components, values) in reported.iter().zip(&state.axes) {
            all.extend(components.iter().map(|c| c.of(&values.location)));
        }
        if let (Some(screened), Some(corrections)) = (self.screened(), corrections) {
            for (j, station) in screened.solution.stations.iter().enumerate() {
                let moved = station.position_mm + corrections.station_mm(j);
                all.extend((state.ref_from_datum * moved).iter());
                all.push(station.dead_path_mm + corrections.dead_path_mm(j));
            }
        }
    }
}

impl Model for Replay<'_> {
    type Workspace = ReplayWorkspace;

    fn outputs(&self) -> usize {
        self.results.len()
    }

    fn workspace(&self) -> ReplayWorkspace {
        let points_mm = self.measured.points_mm.clone();
        let (lengths, errors) = match &self.source {
            Source::Lengths { trials, .. } => (Some(trials.workspace()), trials.readings()),
            Source::Points(_) => (None, 3 * points_mm.len()),
        };
        ReplayWorkspace {
            lengths,
            errors_mm: vec![0.0; errors],
            points_mm,
            all: Vec::new(),
        }
    }

    fn trial(&self, rng: &mut ChaCha8Rng, workspace: &mut ReplayWorkspace, outputs: &mut [f64]) {
        match &self.source {
            Source::Lengths { trials, .. } => trials.draw(rng, &mut workspace.errors_mm),
            Source::Points(factors) => {
                let mut first = 0;
                for factor in factors {
                    let normal =
                        DVector::from_fn(factor.nrows(), |_, _| StandardNormal.sample(rng));
                    let error = factor * normal;
                    workspace.errors_mm[first..first + error.len()]
                        .copy_from_slice(error.as_slice());
                    first += error.len();
                }
            }
        }
        self.solve(workspace, outputs);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identify_axes::identify_axes;
    use rand::SeedableRng;
    use trueaxis_simulate::{Scenario, simulate};

    const SCENARIOS: [&str; 3] = [
        include_str!("../../../campaigns/fxyz/scenario.json"),
        include_str!("../../../campaigns/rotary-stage/scenario.json"),
        include_str!("../../../campaigns/five-axis/scenario.json"),
    ];

    /// A replay against the whole identification of the same points from the start: new operators,
    /// new average lines. The operators differ by the noise of the levers, a part in 1e5, of what
    /// they find rigid.
    #[test]
    #[expect(clippy::print_stdout, reason = "the figure of the docs")]
    fn agrees_with_the_whole_identification() {
        for scenario in SCENARIOS {
            let scenario = Scenario::from_json(scenario).unwrap();
            let campaign = simulate(&scenario, 1).unwrap().campaign;
            let settings = Settings::default();
            let (calibration, replay) = calibrate_for_replay(&campaign, &settings).unwrap();
            let mut workspace = replay.workspace();
            let mut found = vec![0.0; replay.outputs()];
            let mut largest = 0.0_f64;
            for trial in 0..3 {
                let mut rng = ChaCha8Rng::seed_from_u64(trial);
                replay.trial(&mut rng, &mut workspace, &mut found);
                let context = Context {
                    campaign: &campaign,
                    machine: &replay.machine,
                    measured: &replay.measured,
                    points_mm: &workspace.points_mm,
                    method: settings.method,
                };
                let whole = identify_axes(&context, &replay.data).unwrap();
                let mut all = Vec::new();
                replay.collect(&whole.state, None, &mut all);
                for ((found, &place), result) in
                    found.iter().zip(&replay.places).zip(replay.results())
                {
                    if let Some(value) = all.get(place) {
                        let found = found * result.output.unit().size();
                        largest = largest.max((found - value).abs() / result.u);
                    }
                }
            }
            println!("{}: {largest:.1e} u", calibration.campaign);
            assert!(largest < 1e-4);
        }
    }
}
