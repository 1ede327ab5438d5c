//! The same campaign with other errors of its measurement, as often as asked: Monte Carlo, and the
//! effect of single errors.
//!
//! A trial's lengths are those that follow from the adjusted state, plus errors. The poses come from
//! [`trueaxis_multilateration::Trials`] (one factorisation, one corrector step), or from its points by the
//! equations of the calibration; the component and location errors from Newton's method with exact
//! deviations, repeated until the reference frame has settled. Weights stay as they are. In a points
//! campaign the points themselves are drawn.

use nalgebra::{DMatrix, DVector, Isometry3, Vector6};
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
use crate::measure::Measured;
use crate::nine::PointPoses;
use crate::results::NumberedResult;
use crate::settings::{Method, Settings};
use crate::state::State;

/// A calibrated campaign that can be calibrated again with other errors of its measurement.
///
/// As a [`Model`] it draws the noise and gives the results, in the order and units of
/// [`Replay::results`].
pub struct Replay<'a> {
    machine: Machine,
    measured: Measured<'a>,
    data: Vec<AxisData>,
    identified: Identified,
    source: Source,
    /// Results that are not defined by gauge or frame, and their places among all.
    results: Vec<NumberedResult>,
    places: Vec<usize>,
}

/// Where the errors of the poses come from.
enum Source {
    Lengths {
        trials: Box<Trials>,
        /// For each pose the group of the network.
        groups: Vec<usize>,
    },
    /// Cholesky factors of the covariances of the groups of points.
    Points(Vec<DMatrix<f64>>),
}

/// Storage of a trial.
pub struct ReplayWorkspace {
    lengths: Option<trueaxis_multilateration::Workspace>,
    errors_mm: Vec<f64>,
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
    } = parts;
    let source = match &measured.adjusted {
        Some(adjusted) => Source::Lengths {
            trials: Box::new(Trials::new(
                &adjusted.screened.network,
                &adjusted.screened.solution,
            )),
            groups: adjusted.moved(),
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

fn point_factors(measured: &Measured<'_>) -> Result<Vec<DMatrix<f64>>, Error> {
    let groups = measured
        .points
        .iter()
        .flat_map(|(points, _)| &points.noise.own);
    groups
        .enumerate()
        .map(|(group, covariance)| {
            let factor = covariance.clone().cholesky().map(|factor| factor.unpack());
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
        self.measured.screened().map(|screened| &**screened)
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

    /// The poses that the errors of a trial make, and the corrections of the adjusted lengths.
    fn trial_poses<'w>(
        &self,
        workspace: &'w mut ReplayWorkspace,
    ) -> (Vec<Isometry3<f64>>, Option<&'w Corrections>) {
        let ReplayWorkspace { lengths, errors_mm } = workspace;
        match (&self.source, lengths) {
            (Source::Lengths { trials, groups }, Some(lengths)) => {
                let solved = trials.solve(errors_mm, lengths);
                let of_groups: Vec<&[f64]> = groups.iter().map(|&g| solved.group(g)).collect();
                (self.poses(&of_groups), Some(solved))
            }
            _ => {
                let mut rest = &errors_mm[..];
                let mut of_groups = Vec::new();
                for group in self
                    .measured
                    .points
                    .iter()
                    .flat_map(|(points, _)| &points.groups)
                {
                    let (own, behind) = rest.split_at(3 * group.points_mm.len());
                    of_groups.push(own);
                    rest = behind;
                }
                (self.poses(&of_groups), None)
            }
        }
    }

    fn solve(&self, workspace: &mut ReplayWorkspace, results: &mut [f64]) {
        let (poses, corrections) = self.trial_poses(workspace);
        let context = self.measured.context(&self.machine, &poses);
        let Some(state) = self.identified.replayed(&context, &self.data) else {
            results.fill(f64::NAN);
            return;
        };
        let mut all = Vec::new();
        self.collect(&state, corrections, &mut all);
        for ((result, &place), numbered) in results.iter_mut().zip(&self.places).zip(&self.results)
        {
            *result = all[place] / numbered.output.unit().size();
        }
    }

    /// The measured poses with errors: for each group the twist of its pose, or the displacements of its
    /// points.
    fn poses(&self, errors: &[&[f64]]) -> Vec<Isometry3<f64>> {
        let by_equations = self.measured.method != Method::Joint;
        match self.measured.points.as_ref().filter(|_| by_equations) {
            Some((_, found)) => PointPoses::moved(found, errors),
            None => {
                let observations = self.measured.poses().observations.iter();
                let moved = observations.zip(errors);
                moved
                    .map(|(pose, twist)| pose.moved(&Vector6::from_column_slice(twist)))
                    .collect()
            }
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
        let (lengths, errors) = match &self.source {
            Source::Lengths { trials, .. } => (Some(trials.workspace()), trials.readings()),
            Source::Points(factors) => (None, factors.iter().map(DMatrix::nrows).sum()),
        };
        ReplayWorkspace {
            lengths,
            errors_mm: vec![0.0; errors],
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
        let methods = [Method::Joint, Method::Nine];
        for (scenario, method) in SCENARIOS.iter().flat_map(|s| methods.map(|m| (s, m))) {
            let scenario = Scenario::from_json(scenario).unwrap();
            let campaign = simulate(&scenario, 1).unwrap().campaign;
            let settings = Settings {
                method,
                ..Settings::default()
            };
            let (calibration, replay) = calibrate_for_replay(&campaign, &settings).unwrap();
            let mut workspace = replay.workspace();
            let mut found = vec![0.0; replay.outputs()];
            let mut largest = 0.0_f64;
            for trial in 0..3 {
                let mut rng = ChaCha8Rng::seed_from_u64(trial);
                replay.trial(&mut rng, &mut workspace, &mut found);
                let (poses, _) = replay.trial_poses(&mut workspace);
                let context = replay.measured.context(&replay.machine, &poses);
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
