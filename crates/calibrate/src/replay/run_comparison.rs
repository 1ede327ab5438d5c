//! Comparison of the runs of an axis, as data for the search for the cause of a contradiction.
//!
//! Where runs with other axes parked elsewhere share positions, their pose errors are, with the noise
//! of the poses and of the bases (notation as in the misfit of runs of the report),
//!
//! ```text
//! e_i = E_n + Λ_i g_r + A_i ξ_i + C_i t        V = diag(A D Aᵀ) + C S Cᵀ
//! ```
//!
//! Here everything is whitened by the Cholesky factor of `V`: the observations, and the columns of `E` and `g`, which
//! may always be common to the runs or differ between them.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn, Vector6};
use trueaxis_campaign::Direction;
use trueaxis_poses::{LengthsAdjustment, PoseNoise};

use crate::calibrate::found;
use crate::identify::state::State;
use crate::propagate::dependence::Dependence;
use crate::propagate::propagation::Noise;
use crate::replay::{Replay, Responses};

/// The runs of one axis at the positions that they share.
pub struct RunComparison {
    /// Index of the axis in the machine.
    pub axis: usize,
    /// Names of the runs.
    pub runs: Vec<String>,
    /// Whitened pose errors, six for each pose.
    pub observations: Vec<f64>,
    /// Whitened columns of what the runs share, and of what each run has alone.
    pub base: Vec<Vec<f64>>,
    /// Standard deviation of the position of one pose, mean over the poses and directions, mm.
    pub sigma_mm: f64,
    /// The compared poses, in the order of the observations.
    pub poses: Vec<ComparedPose>,
    /// Indices of the poses among those of the axis.
    axis_poses: Vec<usize>,
    /// Index among the axes of the calibration.
    data: usize,
    factor: Cholesky<f64, Dyn>,
    /// Unit of each observation: mm and rad of one axis differ by orders of magnitude.
    units: DVector<f64>,
}

/// One pose of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ComparedPose {
    /// Index into [`RunComparison::runs`].
    pub run: usize,
    /// Position of the axis, mm or rad.
    pub position: f64,
    /// Side of approach, if the sides are kept apart.
    pub direction: Option<Direction>,
}

/// Most poses that are compared: further positions than these, evenly spaced, show no more, and the work grows with
/// the cube.
const MOST_RECORDS: usize = 240;

impl Replay<'_> {
    /// Each axis with several runs that share positions.
    pub fn run_comparisons(&self) -> Vec<RunComparison> {
        let poses = &self.trials.measured.poses;
        let measured = found(poses);
        let context = self.context(&measured);
        let stations = self.trials.measured.of_lengths(LengthsAdjustment::stations);
        let dependence = Dependence::new(&context, &self.identified, &stations);
        let noise = Noise::new(&dependence, &poses.noise);
        let axes = 0..self.data.len();
        axes.filter_map(|k| comparison(&dependence, &poses.noise, &noise, k))
            .collect()
    }

    /// The lengths that a calibration uses, by their numbers in measuring order; empty for a points campaign.
    pub fn used_lengths(&self) -> &[usize] {
        self.trials.used_lengths()
    }
}

impl Responses<'_> {
    /// Changes of the whitened observations of comparisons by errors of the used lengths (mm, as in
    /// [`Responses::to`]); `None` if the identification does not converge.
    pub fn of_runs_to(
        &mut self,
        comparisons: &[RunComparison],
        errors_mm: &[f64],
    ) -> Option<Vec<Vec<f64>>> {
        let before = self.pose_errors(comparisons, &vec![0.0; errors_mm.len()])?;
        let after = self.pose_errors(comparisons, errors_mm)?;
        let changes = comparisons.iter().zip(before.iter().zip(&after));
        Some(
            changes
                .map(|(comparison, (before, after))| comparison.whitened(&(after - before)))
                .collect(),
        )
    }

    fn pose_errors(
        &mut self,
        comparisons: &[RunComparison],
        errors_mm: &[f64],
    ) -> Option<Vec<DVector<f64>>> {
        self.set(errors_mm);
        let replay = self.replay;
        let trial = replay.trials.solve(&mut self.workspace);
        let context = replay.context(&trial.poses);
        let state: State = replay.identified.replayed(&context)?;
        let of = |comparison: &RunComparison| {
            let errors = context.pose_errors(&state, comparison.data);
            stacked(&comparison.axis_poses, |i| errors[i])
        };
        Some(comparisons.iter().map(of).collect())
    }
}

impl RunComparison {
    /// Weights with which whitened values add up to component `component` (δ in mm, ε in rad) of pose `pose`: a row of
    /// the factor of `V`.
    pub fn weights(&self, pose: usize, component: usize) -> Vec<f64> {
        let row = 6 * pose + component;
        let factor = self.factor.l_dirty().row(row);
        let up_to_own = (0..self.units.len()).map(|k| if k <= row { factor[k] } else { 0.0 });
        up_to_own.map(|weight| weight * self.units[row]).collect()
    }

    fn whitened(&self, errors: &DVector<f64>) -> Vec<f64> {
        let mut scaled = errors.component_div(&self.units);
        self.factor
            .l_dirty()
            .solve_lower_triangular_mut(&mut scaled);
        scaled.as_slice().to_vec()
    }
}

/// Six numbers of each pose, in one column.
fn stacked(axis_poses: &[usize], of_pose: impl Fn(usize) -> Vector6<f64>) -> DVector<f64> {
    let parts = axis_poses.iter().map(|&i| of_pose(i)).collect::<Vec<_>>();
    DVector::from_iterator(6 * parts.len(), parts.iter().flatten().copied())
}

/// The comparison of the runs of axis `k`; `None` if none share a position or the poses' noise is not known.
fn comparison(
    dependence: &Dependence<'_>,
    noise: &PoseNoise,
    whole: &Noise<'_>,
    k: usize,
) -> Option<RunComparison> {
    let (context, identified) = (dependence.context, dependence.identified);
    let data = &context.data[k];
    let shared = data.poses_of.iter().enumerate();
    let shared = shared.filter(|(_, axis_poses)| axis_poses.len() > 1);
    let nodes: Vec<usize> = shared.map(|(number, _)| number).collect();
    let all: usize = nodes.iter().map(|&n| data.poses_of[n].len()).sum();
    let nodes: Vec<usize> = nodes
        .into_iter()
        .step_by(all.div_ceil(MOST_RECORDS).max(1))
        .collect();
    let axis_poses = nodes.iter().flat_map(|&n| data.poses_of[n].clone());
    let axis_poses: Vec<usize> = axis_poses.collect();
    if data.runs.len() < 2 || axis_poses.is_empty() || noise.own.is_empty() {
        return None;
    }
    let rows = 6 * axis_poses.len();

    // V = diag(A D Aᵀ) + C S Cᵀ, first for the sources of the bases, then for what all poses share.
    let sources = &whole.sources;
    let mut of_bases = DMatrix::zeros(rows, sources.own.nrows());
    let mut of_shared = DMatrix::zeros(rows, noise.width());
    let mut covariance = DMatrix::zeros(rows, rows);
    for (place, &i) in axis_poses.iter().enumerate() {
        covariance
            .fixed_view_mut::<6, 6>(6 * place, 6 * place)
            .copy_from(&whole.own_of_pose(k, i));
        let [through_bases, through_shared] = whole.sources_of_pose(k, i);
        of_bases.rows_mut(6 * place, 6).copy_from(&through_bases);
        of_shared.rows_mut(6 * place, 6).copy_from(&through_shared);
    }
    covariance += &of_bases * &sources.own * of_bases.transpose();
    covariance += &of_shared * &noise.shared * of_shared.transpose();
    let units = DVector::from_fn(rows, |row, _| covariance[(row, row)].sqrt());
    let scaled = DMatrix::from_fn(rows, rows, |i, j| {
        0.5 * (covariance[(i, j)] + covariance[(j, i)]) / (units[i] * units[j])
    });
    let of_position = (0..rows).filter(|row| row % 6 < 3).map(|row| units[row]);
    let sigma_mm = of_position.sum::<f64>() / (rows / 2) as f64;

    let errors = context.pose_errors(&identified.state, k);
    let of_pose = |i: usize| {
        let pose = &data.poses[i];
        let node = data.nodes[pose.node];
        ComparedPose {
            run: pose.run,
            position: node.position,
            direction: node.direction,
        }
    };
    let mut comparison = RunComparison {
        axis: data.axis,
        runs: context.run_names(k),
        observations: Vec::new(),
        base: Vec::new(),
        sigma_mm,
        poses: axis_poses.iter().map(|&i| of_pose(i)).collect(),
        data: k,
        factor: Cholesky::new(scaled)?,
        units,
        axis_poses,
    };
    let column = |of_pose: &dyn Fn(usize) -> Vector6<f64>| {
        comparison.whitened(&stacked(&comparison.axis_poses, of_pose))
    };
    let effects = &identified.gauges[k].effects;
    let mut base = Vec::new();
    for node in nodes {
        let here = |i: usize| f64::from(u8::from(data.poses[i].node == node));
        base.extend((0..6).map(|component| column(&|i| Vector6::ith(component, here(i)))));
    }
    for parameter in identified.gauges[k].location_parameters..effects[0].ncols() {
        base.push(column(&|i| effects[i].column(parameter).into_owned()));
    }
    comparison.observations = column(&|i| errors[i]);
    comparison.base = base;
    Some(comparison)
}
