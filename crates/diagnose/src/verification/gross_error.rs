//! A reading that is left out, and the notice of it.

use trueaxis_campaign::Verification;

use crate::Rejected;

/// What a reading contradicts.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Contradicts {
    All,
    /// All other stops, as do the other readings of its own stop.
    OtherStops,
    /// The other reading at its position (and side, where sides were repeated), which is left out, too.
    TheOther,
    /// The reading of its position from the other side, as its neighbours do.
    TheOtherSide,
    ItsStop,
}

impl Contradicts {
    fn reason(self) -> &'static str {
        match self {
            Self::All => "contradicts all other readings: written down wrongly, or read too early",
            Self::OtherStops => {
                "its stop contradicts all others: the axis was elsewhere, or the instrument was touched"
            }
            Self::TheOther => {
                "contradicts the other reading of its position: one of the two was written down wrongly, or read too early"
            }
            Self::TheOtherSide => {
                "contradicts the other side of its position, which its neighbours confirm: written down wrongly, or read too early"
            }
            Self::ItsStop => {
                "contradicts the other readings of its stop: written down wrongly, or a fault of the instrument"
            }
        }
    }

    /// The words after "is off by … against" in a notice.
    pub(crate) fn against(self) -> &'static str {
        match self {
            Self::All => "all others and was left out",
            Self::OtherStops => "all other stops and was left out, as were those of its stop",
            Self::TheOther => {
                "the other one of its position; nothing tells which is wrong, so both were left out: read it again"
            }
            Self::TheOtherSide => "the other side of its position and was left out",
            Self::ItsStop => "the others of its stop and was left out",
        }
    }
}

/// A reading of a table that is left out.
pub(crate) struct GrossError {
    /// Its index.
    pub(crate) reading: usize,
    pub(crate) rejected: Rejected,
    pub(crate) contradicts: Contradicts,
}

impl GrossError {
    /// With its error and the standard uncertainty of that, µm.
    pub(crate) fn new(
        verification: &Verification,
        reading: usize,
        (error_um, u_um): (f64, f64),
        contradicts: Contradicts,
    ) -> Self {
        let rejected = Rejected {
            file: verification.name.clone(),
            row: verification.readings[reading].line,
            error_um,
            u_um,
            reason: contradicts.reason().to_owned(),
        };
        Self {
            reading,
            rejected,
            contradicts,
        }
    }
}
