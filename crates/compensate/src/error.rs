//! What can go wrong.

/// A correction that cannot be found, or a table that cannot be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the message shows what each field is")]
pub enum Error {
    /// The errors change too fast with the position for the iteration.
    #[error(
        "no corrected positions for {positions:?} (mm, rad): each iteration leaves {contraction:.2} of the one before, \
         expected less than {limit}; the errors jump or are larger than those of a machine"
    )]
    NotContracting {
        /// Commanded positions of all axes, mm or rad.
        positions: Vec<f64>,
        /// Largest ratio of two corrections that follow each other.
        contraction: f64,
        /// The largest ratio that is accepted.
        limit: f64,
    },
    /// The calibration of another machine.
    #[error(transparent)]
    OtherMachine(#[from] trueaxis_predict::OtherMachine),
    /// A campaign with nothing to compare.
    #[error(
        "the campaign has no verification readings to compare with the predictions; add them to `verification` of \
         campaign.json"
    )]
    NothingRead,
    /// An axis that the machine does not have, or that was not measured.
    #[error("axis {axis} was not measured; measured are {measured}")]
    NoSuchAxis { axis: String, measured: String },
    /// Nothing that the format could hold.
    #[error("{format} takes {takes}; {lacks}")]
    Unsuitable {
        format: &'static str,
        takes: &'static str,
        lacks: String,
    },
    /// A table that cannot be used.
    #[error("{file} line {line}: {found:?}; expected {expected}")]
    Table {
        file: String,
        /// Number of the line, from 1.
        line: usize,
        found: String,
        expected: String,
    },
    /// A file that is no table of the format, where its old ones are asked for.
    #[error(
        "{file} is no old table of {format} for this machine; expected {expected}: the name says for which axis it is"
    )]
    NoOldTable {
        file: String,
        format: &'static str,
        expected: String,
    },
    /// Tables whose sign only a test on the machine tells.
    #[error(
        "{format}: no public page that was found says which sign a value in a table has; find out on the machine, with an \
         axis that is free to move and a table of zeros with +0.050 mm at one point: at that point, read a dial gauge or a \
         laser with the table off and on; if with it the tool stands 0.050 mm farther in the negative direction of the axis \
         (against the workpiece, as positions count), give --sign error, if in the positive one, --sign correction"
    )]
    NoSign { format: &'static str },
    /// Angles of a machine without a length to compare them with.
    #[error(
        "the machine has no linear axis whose travel turns an angle into micrometres; give the standard uncertainty of the \
         angles, too (--u-arcsec)"
    )]
    NoLever,
    /// A spacing that does not end at the last step.
    #[error(
        "axis {axis}: a spacing of {step} {unit} does not divide the range of its steps, {range} {unit}; \
         {nearest} {unit} does"
    )]
    Step {
        axis: String,
        /// The spacing, mm or degrees.
        step: f64,
        /// From the first to the last step, mm or degrees.
        range: f64,
        nearest: f64,
        /// `mm` or `degrees`.
        unit: &'static str,
    },
    /// Steps of unequal distances for a control that wants equal ones.
    #[error(
        "axis {axis}: its steps are between {least} and {most} {unit} apart, and {format} wants equal distances; \
         give a spacing with --step"
    )]
    UnequalSteps {
        axis: String,
        format: &'static str,
        /// Smallest distance, mm or degrees.
        least: f64,
        /// Largest distance, mm or degrees.
        most: f64,
        /// `mm` or `degrees`.
        unit: &'static str,
    },
    /// More points than the control holds.
    #[error(
        "{what}: {points} points, and {format} holds {most} at most; give a wider spacing with --step"
    )]
    TooManyPoints {
        what: String,
        format: &'static str,
        points: usize,
        most: usize,
    },
    /// Values that change too fast from one point to the next.
    #[error(
        "axis {axis}: the correction changes by {slope:.4} per unit of travel, and {format} takes less than {most}: \
         these are no errors of a machine"
    )]
    Slope {
        axis: String,
        format: &'static str,
        slope: f64,
        most: f64,
    },
}
