//! The misfit of the runs without a cause, and what the cause explains of it.

use trueaxis_calibrate::{ComparedPose, RunComparison};
use trueaxis_effects::Scene;
use trueaxis_kinematics::{ARCSEC, Component, MICROMETRE};
use trueaxis_leastsquares::dot;
use trueaxis_selection::Projection;

use crate::engine::linear::Judged;
use crate::fitted::{Fitted, Row};
use crate::numbers::squares_about_mean;

/// The figure for one run: the three displacements or the three rotations of its poses, whichever vary more along the
/// axis, without what the runs share and what each may have alone.
pub(super) fn fitted(
    scene: &Scene,
    comparisons: &[RunComparison],
    judged: &Judged,
) -> Option<Fitted> {
    let mut runs = Vec::new();
    let mut first = 0;
    for comparison in comparisons {
        for run in 0..comparison.runs.len() {
            runs.extend([false, true].map(|is_angular| Shown {
                comparison,
                first,
                run,
                is_angular,
            }));
        }
        first += comparison.observations.len();
    }
    let runs = runs.iter().map(|shown| (shown, shown.rows(judged)));
    let shown = runs.max_by(|(_, a), (_, b)| variation(a).total_cmp(&variation(b)));
    let (shown, rows) = shown?;
    let fitted = Fitted::new(&rows, 3, |group| shown.name(group, scene), scene)?;
    Some(fitted.of_angles(shown.is_angular))
}

/// Squares of the effect about the mean of each coordinate, in units of the noise: a constant along an axis is no
/// course.
fn variation(rows: &[Row]) -> f64 {
    let of_coordinate = |group: usize| {
        let own = rows.iter().filter(|row| row.group == group);
        squares_about_mean(&own.map(|row| row.fitted / row.u).collect::<Vec<f64>>())
    };
    (0..3).map(of_coordinate).sum()
}

/// The displacements or the rotations of the poses of a run.
struct Shown<'a> {
    comparison: &'a RunComparison,
    /// Start of its observations among those of all comparisons.
    first: usize,
    run: usize,
    is_angular: bool,
}

impl Shown<'_> {
    /// Three rows for each pose, µm or arcsec.
    fn rows(&self, judged: &Judged) -> Vec<Row> {
        let (model, fit) = (&judged.beside.model, &judged.fit);
        let (offset, unit) = match self.is_angular {
            true => (3, ARCSEC),
            false => (0, MICROMETRE),
        };
        let poses = self.comparison.poses.iter().enumerate();
        let own = poses.filter(|(_, pose)| pose.run == self.run);
        let rows = own.flat_map(|(k, pose)| (0..3).map(move |group| (k, pose, group)));
        let row = |(k, pose, group): (usize, &ComparedPose, usize)| {
            let mut weights = vec![0.0; model.rows()];
            let own = self.comparison.weights(k, offset + group);
            weights[self.first..][..own.len()].copy_from_slice(&own);
            Row {
                group,
                time_s: 0.0,
                moving: vec![(self.comparison.axis, pose.position)],
                direction: pose.direction.map_or(1.0, |side| f64::from(side.sign())),
                misfit: dot(&weights, &model.residuals) / unit,
                fitted: dot(&weights, &fit.explained) / unit,
                u: left(model, &weights) / unit,
            }
        };
        rows.map(row).collect()
    }

    /// Name such as `EZY of run y2 (µm)`.
    fn name(&self, group: usize, scene: &Scene) -> String {
        let component = Component::ALL[group + if self.is_angular { 3 } else { 0 }];
        let axis = scene.axis_name(self.comparison.axis);
        format!(
            "{} of run {}",
            component.name(axis),
            self.comparison.runs[self.run]
        )
    }
}

/// Length of what a model leaves of a column: the standard deviation for noise of unit variance.
fn left(model: &Projection, column: &[f64]) -> f64 {
    dot(column, &model.left_of(column)).max(0.0).sqrt()
}
