//! The same measurement with other errors, as often as asked.
//!
//! A trial's lengths are those that follow from the adjusted state, plus errors. The poses come from
//! [`trueaxis_multilateration::Trials`] (one factorisation, one corrector step), or from its points by the
//! equations that made the poses. Weights stay as they are. In a points campaign the points themselves are
//! drawn.

use nalgebra::{DMatrix, DVector, Isometry3, Vector6};
use rand::Rng;
use rand_distr::{Distribution, StandardNormal};
use trueaxis_multilateration::{Station, Trials, Workspace};

use crate::Error;
use crate::measure::MeasuredPoses;

/// Measured poses that can be measured again with other errors.
pub struct PoseTrials<'a> {
    /// As they were measured.
    pub measured: MeasuredPoses<'a>,
    source: Source,
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
pub struct TrialWorkspace {
    lengths: Option<Workspace>,
    /// The errors: one for each used length, then one for each known contrast of reflectors in measuring order, or x y z of each point, mm.
    pub errors_mm: Vec<f64>,
}

/// What a trial measures.
pub struct Trial {
    /// The poses: datum from home.
    pub poses: Vec<Isometry3<f64>>,
    /// The stations, in the datum; none for a points campaign.
    pub stations: Vec<Station>,
}

impl<'a> PoseTrials<'a> {
    /// Gets ready for other errors.
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
                let factor = |(step, covariance): (usize, &DMatrix<f64>)| {
                    let factor = covariance.clone().cholesky().map(|factor| factor.unpack());
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

    /// The readings of the campaign whose lengths were used, in measuring order; none in a points
    /// campaign.
    pub fn used_lengths(&self) -> &[usize] {
        let lengths = self.measured.lengths.as_ref();
        lengths.map_or(&[], |lengths| &lengths.screened.kept)
    }

    /// Storage for trials, with errors zero.
    pub fn workspace(&self) -> TrialWorkspace {
        let (lengths, errors) = match &self.source {
            Source::Lengths { trials, .. } => (Some(trials.workspace()), trials.errors()),
            Source::Points(factors) => (None, factors.iter().map(DMatrix::nrows).sum()),
        };
        TrialWorkspace {
            lengths,
            errors_mm: vec![0.0; errors],
        }
    }

    /// Draws errors from the noise of the measurement.
    pub fn draw<R: Rng + ?Sized>(&self, rng: &mut R, workspace: &mut TrialWorkspace) {
        let errors_mm = &mut workspace.errors_mm;
        match &self.source {
            Source::Lengths { trials, .. } => trials.draw(rng, errors_mm),
            Source::Points(factors) => {
                let mut rest = &mut errors_mm[..];
                for factor in factors {
                    let normal =
                        DVector::from_fn(factor.nrows(), |_, _| StandardNormal.sample(rng));
                    let (own, behind) = rest.split_at_mut(factor.nrows());
                    own.copy_from_slice((factor * normal).as_slice());
                    rest = behind;
                }
            }
        }
    }

    /// What is measured with the errors of the workspace.
    pub fn solve(&self, workspace: &mut TrialWorkspace) -> Trial {
        let TrialWorkspace { lengths, errors_mm } = workspace;
        let mut errors: Vec<&[f64]> = Vec::new();
        let mut stations = Vec::new();
        match (&self.source, lengths) {
            (Source::Lengths { trials, groups }, Some(lengths)) => {
                let solved = trials.solve(errors_mm, lengths);
                errors.extend(groups.iter().map(|&g| solved.group(g)));
                let adjusted = self.measured.stations().iter().enumerate();
                stations.extend(adjusted.map(|(j, adjusted)| Station {
                    position_mm: adjusted.position_mm + solved.station_mm(j),
                    dead_path_mm: adjusted.dead_path_mm + solved.dead_path_mm(j),
                }));
            }
            (Source::Points(factors), _) => {
                let mut rest = &errors_mm[..];
                for factor in factors {
                    let (own, behind) = rest.split_at(factor.nrows());
                    errors.push(own);
                    rest = behind;
                }
            }
            (Source::Lengths { .. }, None) => unreachable!("a workspace of this measurement"),
        }
        Trial {
            poses: self.moved(&errors),
            stations,
        }
    }

    /// The measured poses with errors: for each group the displacements of its points, or the twist of its
    /// pose.
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
