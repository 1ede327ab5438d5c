//! Why a campaign cannot be calibrated, named as in the campaign.

/// A campaign that does not yield a calibration.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the message shows what each field is")]
pub enum Error {
    /// The campaign does not yield poses, or the poses do not determine the errors of an axis or their uncertainty.
    #[error(transparent)]
    Poses(#[from] trueaxis_poses::Error),
    /// The component errors did not converge.
    #[error(
        "the component errors did not converge after {passes} passes (last change {change_mm:.1e} mm, of axis {axis}): the measured motion is far \
         from the nominal one; check direction, sign and position of all axes: where one is reversed another may fit worst"
    )]
    NotConverged {
        passes: usize,
        change_mm: f64,
        axis: String,
    },
    /// The measured motion is not the commanded one.
    #[error(
        "axis {axis} does not move as commanded: in {step} the points deviate by {translation_mm:.1} mm and \
         {rotation_deg:.1}° from it; check the direction, sign and unit of this axis in the campaign, its \
         positions in the table, that coordinates are right-handed, and that nobody touched the targets; if all is \
         right, the axis is to be repaired before it can be calibrated"
    )]
    NotThatMotion {
        axis: String,
        step: String,
        translation_mm: f64,
        /// Largest component of ε there, degrees.
        rotation_deg: f64,
    },
    /// The targets of a run are displaced once.
    #[error(transparent)]
    DisplacedOnce(#[from] trueaxis_mistakes::DisplacedOnce),
    /// More than one axis moves in a run.
    #[error(
        "run {run} is of axis {axis}, but {other} moves as well ({step}): its errors would be taken for \
         those of {axis}; give these rows a run of {other}"
    )]
    SeveralAxesMove {
        run: String,
        axis: String,
        other: String,
        step: String,
    },
    /// The data contradict each other, and a usual mistake explains it.
    #[error("likely cause: {explanation}; {error}")]
    Mistaken {
        error: Box<Error>,
        explanation: String,
    },
    /// A matrix that would not fit.
    #[error("{matrix} takes {gib:.1} GiB, at most {limit_gib} GiB are made; {instead}")]
    TooLarge {
        matrix: String,
        gib: f64,
        limit_gib: f64,
        instead: &'static str,
    },
}

impl Error {
    /// The same error as a diagnosis states it.
    pub fn of_a_diagnosis(self) -> Self {
        match self {
            Self::Poses(error) => Self::Poses(error.of_a_diagnosis()),
            Self::Mistaken { error, explanation } => Self::Mistaken {
                error: Box::new(error.of_a_diagnosis()),
                explanation,
            },
            other => other,
        }
    }

    /// What is wrong, without the advice what to do about it.
    pub fn what(&self) -> String {
        match self {
            Self::Poses(error) => error.what(),
            Self::Mistaken { error, explanation } => {
                format!("likely cause: {explanation}; {}", error.what())
            }
            other => other.to_string(),
        }
    }

    /// Whether the data contradict each other or the machine, as they do after a mistake.
    pub(crate) fn is_contradiction(&self) -> bool {
        use trueaxis_poses::Error as Poses;
        matches!(
            self,
            Self::NotConverged { .. }
                | Self::NotThatMotion { .. }
                | Self::DisplacedOnce(_)
                | Self::Poses(
                    Poses::NotConverged { .. }
                        | Poses::NotTrustworthy { .. }
                        | Poses::Contradictory { .. }
                        | Poses::RanAway { .. }
                        | Poses::StationUnexplained { .. }
                )
        )
    }
}
