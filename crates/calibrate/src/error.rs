//! Why a campaign cannot be calibrated, in the words of the campaign.

/// A campaign that does not yield a calibration.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Error {
    /// The campaign has neither lengths nor points.
    #[error(
        "the campaign has neither lengths nor points to calibrate from: add `lengths` or `points`"
    )]
    NothingMeasured,
    /// The lengths do not determine points and stations.
    #[error("{what}; {mend}")]
    NotIdentifiable {
        /// What cannot be determined, by name.
        what: String,
        /// What would determine it.
        mend: String,
    },
    /// The adjustment did not reach a minimum.
    #[error(
        "the adjustment of the lengths did not converge after {iterations} iterations: {termination}"
    )]
    NotConverged {
        /// Iterations used.
        iterations: usize,
        /// Why it stopped, with numbers.
        termination: String,
    },
    /// So much would have to be removed, or so little tells what, that no result can be trusted.
    #[error("{what}; {mend}")]
    NotTrustworthy {
        /// What contradicts what.
        what: String,
        /// What to do.
        mend: String,
    },
    /// The lengths contradict each other far beyond their noise.
    #[error(
        "the lengths contradict each other: rms residual {rms_um:.1} µm, {sigma0:.0} times what \
         the noise explains; worst is {worst}; {hint}"
    )]
    Contradictory {
        /// Rms of the residuals, µm.
        rms_um: f64,
        /// Standard deviation of unit weight.
        sigma0: f64,
        /// Where the misfit is largest.
        worst: String,
        /// What to look at.
        hint: String,
    },
    /// The lengths contradict each other so much that the adjustment drove a station away.
    #[error(
        "the lengths contradict each other: the adjustment runs away; {length} is \
         {residual_mm:.1} mm off what the nominal positions say, more than any other: check it, and \
         that every row names its own station"
    )]
    RanAway {
        /// The length with the largest misfit, in words.
        length: String,
        /// Its misfit, mm.
        residual_mm: f64,
    },
    /// A length that no position of its station explains.
    #[error(
        "no position of station {station} explains its {readings} lengths: the best leaves {rms_mm:.1} mm \
         rms; check its name in every row, the units, the \
         directions of the axes and the nominal positions of the targets; a beam that lost its count \
         by centimetres does the same"
    )]
    StationUnexplained {
        /// Name of the station.
        station: String,
        /// Number of its lengths.
        readings: usize,
        /// Rms of the best attempt, mm.
        rms_mm: f64,
    },
    /// The component errors did not settle.
    #[error(
        "the component errors did not settle after {passes} passes (last change {change_mm:.1e} mm): \
         the measured motion is far from the nominal one; check the direction and position of axis {axis}"
    )]
    NotSettled {
        /// Passes made.
        passes: usize,
        /// Largest change of a coordinate in the last pass, mm.
        change_mm: f64,
        /// The axis that changed most.
        axis: String,
    },
    /// What was measured is another motion than the commanded one.
    #[error(
        "axis {axis} does not move as commanded: the points deviate by up to {translation_mm:.1} mm and \
         {rotation_deg:.1}° from it; check the direction, sign and unit of this axis in the campaign"
    )]
    NotThatMotion {
        /// The axis.
        axis: String,
        /// Largest component of δ, mm.
        translation_mm: f64,
        /// Largest component of ε, degrees.
        rotation_deg: f64,
    },
    /// More than one axis moves in a run.
    #[error(
        "run {run} is of axis {axis}, but {other} moves as well ({step}): its errors would be taken for \
         those of {axis}; give these rows a run of {other}"
    )]
    SeveralAxesMove {
        /// Name of the run.
        run: String,
        /// Its axis.
        axis: String,
        /// The other axis.
        other: String,
        /// The first step at which it has moved.
        step: String,
    },
    /// Effects on lengths in a campaign that has none.
    #[error(
        "effects are taken out of lengths, but this campaign has none; calibrate it without them"
    )]
    EffectsWithoutLengths,
    /// The covariance of all results does not fit.
    #[error(
        "the covariance of all {outputs} results takes {gib:.1} GiB, at most {limit_gib} GiB are \
         written; calibrate without it, or calibrate the runs of fewer axes at a time"
    )]
    CovarianceTooLarge {
        /// Number of results.
        outputs: usize,
        /// Size of their covariance, GiB.
        gib: f64,
        /// Largest size, GiB.
        limit_gib: u32,
    },
    /// The table of what each length does to each result would not fit.
    #[error(
        "the effects of {lengths} lengths on {results} results take {gib:.1} GiB, more than \
         {limit_gib:.0} GiB; calibrate fewer runs at a time"
    )]
    ReliabilityTooLarge {
        /// Lengths.
        lengths: usize,
        /// Results.
        results: usize,
        /// Size, GiB.
        gib: f64,
        /// Largest size, GiB.
        limit_gib: f64,
    },
    /// A covariance or an equation system failed although all checks before it passed.
    #[error("axis {axis}: {what}")]
    Numerical {
        /// The axis.
        axis: String,
        /// What failed, with numbers.
        what: String,
    },
}
