//! The same campaign with new errors, as often as needed: Monte Carlo, and the effect of single errors.
//!
//! The poses of a trial come from [`PoseTrials`], the component and location errors from Newton's method with
//! exact deviations, repeated until the reference frame has converged.

pub(crate) mod reliability;
pub(crate) mod run_comparison;
pub(crate) mod with_effects;

use nalgebra::Isometry3;
use trueaxis_campaign::Campaign;
use trueaxis_kinematics::Machine;
use trueaxis_montecarlo::{ChaCha8Rng, Model};
use trueaxis_poses::{PoseTrials, Station, TrialWorkspace};

use crate::Error;
use crate::calibrate::calibrate_in_parts;
use crate::identify::axis_data::AxisData;
use crate::identify::context::Context;
use crate::identify::identify_axes::Identified;
use crate::identify::state::State;
use crate::report::expansion::since_20_degrees;
use crate::result::calibration::Calibration;
use crate::result::numbered::NumberedResult;
use crate::settings::Settings;

/// A calibrated campaign that can be calibrated again with new errors of its measurement.
///
/// As a [`Model`] it draws the noise and gives the results, in the order and units of [`Replay::results`].
pub struct Replay<'a> {
    campaign: &'a Campaign,
    machine: Machine,
    pub(crate) trials: PoseTrials<'a>,
    data: Vec<AxisData>,
    identified: Identified,
    /// Results that gauge or frame do not define, and their indices among all.
    results: Vec<NumberedResult>,
    places: Vec<usize>,
}

/// Calibrates a campaign and keeps what trials with new errors need; its lengths should hold [at one
/// temperature](trueaxis_poses::at_one_temperature).
pub fn calibrate_for_replay<'a>(
    campaign: &'a Campaign,
    settings: &Settings,
) -> Result<(Calibration, Replay<'a>), Error> {
    let (calibration, parts) = calibrate_in_parts(campaign, settings)?;
    let results = calibration.results().into_iter().enumerate();
    let (places, results) = results.filter(|(_, result)| result.u > 0.0).unzip();
    let replay = Replay {
        campaign,
        machine: parts.machine,
        trials: PoseTrials::new(parts.measured)?,
        data: parts.data,
        identified: parts.identified,
        results,
        places,
    };
    Ok((calibration, replay))
}

impl Replay<'_> {
    /// The results of the calibration, without those that gauge or frame define.
    pub fn results(&self) -> &[NumberedResult] {
        &self.results
    }

    /// How the results change with errors of the used lengths.
    pub fn responses(&self) -> Responses<'_> {
        let mut workspace = self.workspace();
        let mut undisturbed = vec![0.0; self.outputs()];
        self.solve(&mut workspace, &mut undisturbed);
        Responses {
            replay: self,
            workspace,
            undisturbed,
        }
    }

    fn solve(&self, workspace: &mut TrialWorkspace, results: &mut [f64]) {
        let trial = self.trials.solve(workspace);
        let context = self.context(&trial.poses);
        let Some(state) = self.identified.replayed(&context) else {
            results.fill(f64::NAN);
            return;
        };
        let all = self.collect(&state, &trial.stations);
        for ((result, &place), numbered) in results.iter_mut().zip(&self.places).zip(&self.results)
        {
            *result = all[place] / numbered.output.unit().size();
        }
    }

    /// The input of the identification with these poses (datum from home).
    fn context<'b>(&'b self, measured: &'b [Isometry3<f64>]) -> Context<'b> {
        Context {
            campaign: self.campaign,
            machine: &self.machine,
            poses: &self.trials.measured.poses,
            measured,
            data: &self.data,
        }
    }

    /// All results in mm and rad, in the order of [`Calibration::results`].
    fn collect(&self, state: &State, stations: &[Station]) -> Vec<f64> {
        let mut all = Vec::new();
        for (data, axis) in self.data.iter().zip(&state.axes) {
            let longer = since_20_degrees(self.campaign, data.axis);
            for (node, error) in data.nodes.iter().zip(&axis.curve) {
                all.extend((error.translation_mm - longer * node.position).iter());
                all.extend(error.rotation_rad.iter());
            }
        }
        for (components, values) in self.identified.reported.iter().zip(&state.axes) {
            all.extend(components.iter().map(|c| c.of(&values.location)));
        }
        for station in stations {
            all.extend((state.ref_from_datum * station.position_mm).iter());
            all.push(station.dead_path_mm);
        }
        all
    }
}

/// See [`Replay::responses`].
pub struct Responses<'a> {
    replay: &'a Replay<'a>,
    workspace: TrialWorkspace,
    /// The results without errors.
    undisturbed: Vec<f64>,
}

impl Responses<'_> {
    /// The change of each result by errors of the used lengths in measuring order, or of the points (x y z of each), mm;
    /// in the unit of the result ([`trueaxis_predict::Output::unit`]). NaN if it does not converge: errors so large belong
    /// to another machine.
    ///
    /// # Panics
    /// If there are more errors than the measurement has.
    pub fn to(&mut self, errors_mm: &[f64]) -> Vec<f64> {
        self.set(errors_mm);
        let mut changes = vec![0.0; self.undisturbed.len()];
        self.replay.solve(&mut self.workspace, &mut changes);
        for (change, undisturbed) in changes.iter_mut().zip(&self.undisturbed) {
            *change -= undisturbed;
        }
        changes
    }

    /// Sets the errors of the lengths, and zero for everything else that is known.
    fn set(&mut self, errors_mm: &[f64]) {
        let (of_lengths, known) = self.workspace.errors.split_at_mut(errors_mm.len());
        of_lengths.copy_from_slice(errors_mm);
        known.fill(0.0);
    }
}

impl Model for Replay<'_> {
    type Workspace = TrialWorkspace;

    fn outputs(&self) -> usize {
        self.results.len()
    }

    fn workspace(&self) -> TrialWorkspace {
        self.trials.workspace()
    }

    fn trial(&self, rng: &mut ChaCha8Rng, workspace: &mut TrialWorkspace, outputs: &mut [f64]) {
        self.trials.draw(rng, workspace);
        self.solve(workspace, outputs);
    }
}
