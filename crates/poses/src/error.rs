//! Why a campaign gives no poses, named as in the campaign.

/// A campaign that does not yield poses.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the message shows what each field is")]
pub enum Error {
    /// The campaign has neither lengths nor points.
    #[error(
        "the campaign has neither lengths nor points to calibrate from: add `lengths` or `points`; `trueaxis diagnose` judges \
         readings alone"
    )]
    NothingMeasured,
    /// The lengths do not determine stations, points or poses.
    #[error("{what}; {hint}")]
    NotIdentifiable { what: String, hint: String },
    /// The adjustment did not reach a minimum.
    #[error(
        "the adjustment of the lengths did not converge after {iterations} iterations: {termination}"
    )]
    NotConverged {
        iterations: usize,
        termination: String,
    },
    /// So much would have to be removed, or so little shows what, that no result can be trusted.
    #[error("{what}; {hint}")]
    NotTrustworthy { what: String, hint: String },
    /// The lengths contradict each other far beyond their noise.
    #[error(
        "the lengths contradict each other: rms residual {rms_um:.1} µm, {sigma0:.0} times what \
         the noise explains; worst is {worst}; {hint}"
    )]
    Contradictory {
        rms_um: f64,
        /// Standard deviation of unit weight.
        sigma0: f64,
        worst: String,
        hint: &'static str,
    },
    /// The lengths contradict each other so much that the adjustment drove a station away.
    #[error(
        "the lengths contradict each other: the adjustment runs away; {length} is \
         {residual_mm:.1} mm off what the nominal positions say, more than any other: check it, and \
         that every row names its own station"
    )]
    RanAway { length: String, residual_mm: f64 },
    /// A length that no position of its station explains.
    #[error(
        "no position of station {station} explains its {readings} lengths: the best leaves {rms_mm:.1} mm \
         rms; check its name in every row, the units, the \
         directions of the axes and the nominal positions of the targets; a beam that lost its count \
         by centimetres does the same"
    )]
    StationUnexplained {
        station: String,
        readings: usize,
        rms_mm: f64,
    },
    /// Effects on lengths in a campaign that has none.
    #[error(
        "effects are taken out of lengths, but this campaign has none; calibrate it without them"
    )]
    EffectsWithoutLengths,
    /// A covariance or an equation system failed although all checks before it passed.
    #[error("axis {axis}: {what}")]
    Numerical { axis: String, what: String },
}

impl Error {
    /// What is wrong, without the advice what to do about it.
    pub fn what(&self) -> String {
        match self {
            Self::NotIdentifiable { what, .. } | Self::NotTrustworthy { what, .. } => what.clone(),
            other => other.to_string(),
        }
    }

    /// [`Error::NotIdentifiable`].
    pub fn not_identifiable(what: impl Into<String>, hint: impl Into<String>) -> Self {
        Self::NotIdentifiable {
            what: what.into(),
            hint: hint.into(),
        }
    }

    pub(crate) fn not_trustworthy(what: impl Into<String>, hint: impl Into<String>) -> Self {
        Self::NotTrustworthy {
            what: what.into(),
            hint: hint.into(),
        }
    }
}
