//! The same measurement with new errors, as often as needed.
//!
//! A trial's lengths are those computed from the adjusted state, plus errors. The poses come from
//! [`trueaxis_multilateration::Trials`] (one factorisation, a few corrections), or from its points by the equations
//! that gave the measured poses. Weights stay as they are. In a points campaign the points themselves are drawn.

use std::ops::Range;

use nalgebra::{DMatrix, DVector, Isometry3, Point3, Vector6};
use rand::Rng;
use rand_distr::{Distribution, StandardNormal};
use trueaxis_kinematics::centroid;
use trueaxis_multilateration::{Station, Trials, Workspace};

use crate::Error;
use crate::lengths::LengthsAdjustment;
use crate::lengths::scale::at_scale;
use crate::measure::MeasuredPoses;

/// Measured poses that can be measured again with new errors.
pub struct PoseTrials<'a> {
    /// The poses as measured.
    pub measured: MeasuredPoses<'a>,
    source: Source,
}

/// The source of the errors of the poses.
enum Source {
    Lengths {
        trials: Box<Trials>,
        /// For each pose the group of the network.
        groups: Vec<usize>,
    },
    /// For each group of points the range of its errors, and the Cholesky factor of their covariance.
    Points(Vec<(Range<usize>, DMatrix<f64>)>),
}

/// Number of errors of the scale alone ([`Scale::change`]).
const OF_SCALE: usize = 2;

/// Storage of a trial.
pub struct TrialWorkspace {
    lengths: Option<Workspace>,
    /// The errors: one for each used length, mm, in measuring order, then one for each known value of reflectors and
    /// dead paths, in standard deviations; or x y z of each point, mm. Last those of the scale alone, in standard
    /// deviations.
    pub errors: Vec<f64>,
}

/// The results of a trial.
pub struct Trial {
    /// The poses: datum from home.
    pub poses: Vec<Isometry3<f64>>,
    /// The stations, in the datum; none for a points campaign.
    pub stations: Vec<Station>,
}

impl<'a> PoseTrials<'a> {
    /// Prepares trials of these poses.
    ///
    /// # Errors
    /// [`Error::Numerical`] if the points of a step have no positive covariance.
    pub fn new(measured: MeasuredPoses<'a>) -> Result<Self, Error> {
        let source = match &measured.lengths {
            Some(lengths) => Source::Lengths {
                trials: Box::new(Trials::new(
                    &lengths.screened.network,
                    &lengths.screened.solution,
                )),
                groups: lengths.moved(),
            },
            None => {
                let groups = measured
                    .points
                    .iter()
                    .flat_map(|(points, _)| &points.noise.own);
                let mut end = 0;
                let factor = |(step, covariance): (usize, &DMatrix<f64>)| {
                    let own = end..end + covariance.nrows();
                    end = own.end;
                    let factor = covariance.clone().cholesky();
                    let factor = factor.map(|factor| (own, factor.unpack()));
                    factor.ok_or_else(|| Error::Numerical {
                        axis: "all".to_owned(),
                        what: format!(
                            "the covariance of the points of step {step} is not positive"
                        ),
                    })
                };
                Source::Points(groups.enumerate().map(factor).collect::<Result<_, _>>()?)
            }
        };
        Ok(Self { measured, source })
    }

    /// The readings of the campaign whose lengths were used, in measuring order; empty for a points campaign.
    pub fn used_lengths(&self) -> &[usize] {
        let lengths = self.measured.lengths.as_ref();
        lengths.map_or(&[], |lengths| &lengths.screened.kept)
    }

    /// Storage for trials, with zero errors.
    pub fn workspace(&self) -> TrialWorkspace {
        let (lengths, errors) = match &self.source {
            Source::Lengths { trials, .. } => (Some(trials.workspace()), trials.errors()),
            Source::Points(factors) => (None, factors.last().map_or(0, |(own, _)| own.end)),
        };
        TrialWorkspace {
            lengths,
            errors: vec![0.0; errors + OF_SCALE],
        }
    }

    /// Draws errors from the noise of the measurement.
    pub fn draw<R: Rng + ?Sized>(&self, rng: &mut R, workspace: &mut TrialWorkspace) {
        let all = workspace.errors.len() - OF_SCALE;
        let (errors, of_scale) = workspace.errors.split_at_mut(all);
        of_scale.fill_with(|| StandardNormal.sample(rng));
        match &self.source {
            Source::Lengths { trials, .. } => trials.draw(rng, errors),
            Source::Points(factors) => {
                for (own, factor) in factors {
                    let normal = DVector::from_fn(own.len(), |_, _| StandardNormal.sample(rng));
                    errors[own.clone()].copy_from_slice((factor * normal).as_slice());
                }
            }
        }
    }

    /// The results with the errors of the workspace.
    pub fn solve(&self, workspace: &mut TrialWorkspace) -> Trial {
        let TrialWorkspace { lengths, errors } = workspace;
        let (all, of_scale) = errors.split_at(errors.len() - OF_SCALE);
        let mut errors: Vec<&[f64]> = Vec::new();
        let mut stations = Vec::new();
        // Relative error of the scale: how far lengths or coordinates are shown too large.
        let mut scale = self.measured.declared_scale() * of_scale[0];
        match (&self.source, lengths) {
            (Source::Lengths { trials, groups }, Some(lengths)) => {
                let solved = trials.solve(all, lengths);
                errors.extend(groups.iter().map(|&g| solved.group(g)));
                let adjustment = self.measured.lengths.as_ref();
                let of_lengths = adjustment.and_then(|lengths| lengths.scale.as_ref());
                scale = of_lengths.map_or(0.0, |of| of.change(solved, [of_scale[0], of_scale[1]]));
                let mean_constant_mm = solved.mean_constant_mm();
                let adjusted = self.measured.of_lengths(LengthsAdjustment::stations);
                let adjusted = adjusted.into_iter().enumerate();
                stations.extend(adjusted.map(|(j, adjusted)| Station {
                    position_mm: (adjusted.position_mm + solved.station_mm(j)) / (1.0 + scale),
                    dead_path_mm: adjusted.dead_path_mm + solved.dead_path_mm(j) + mean_constant_mm,
                }));
            }
            (Source::Points(factors), _) => {
                errors.extend(factors.iter().map(|(own, _)| &all[own.clone()]));
            }
            (Source::Lengths { .. }, None) => unreachable!("a workspace of this measurement"),
        }
        let bodies = self.measured.poses.bodies.iter();
        let centres: Vec<Point3<f64>> = bodies.map(|body| centroid(&body.home_mm)).collect();
        let of_poses = self.moved(&errors);
        let of_poses = of_poses.iter().zip(&self.measured.poses.observations);
        Trial {
            poses: of_poses
                .map(|(pose, observed)| at_scale(pose, &centres[observed.body], scale))
                .collect(),
            stations,
        }
    }

    /// The measured poses with errors: the displacements of the points of each group, or the twists of the poses.
    fn moved(&self, errors: &[&[f64]]) -> Vec<Isometry3<f64>> {
        let poses = &self.measured.poses;
        if let Some((_, equations)) = &self.measured.points {
            return equations.moved(poses, errors);
        }
        let moved = poses.observations.iter().zip(errors);
        moved
            .map(|(pose, twist)| pose.moved(&Vector6::from_column_slice(twist)))
            .collect()
    }
}
