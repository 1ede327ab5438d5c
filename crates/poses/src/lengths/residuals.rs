//! What the adjustment leaves of each length.

use crate::lengths::LengthsAdjustment;

/// The residual of one length, observed minus computed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LengthResidual {
    /// The reading of the campaign.
    pub reading: usize,
    /// Its residual, mm; of a length that was removed what it differs by from what the others say.
    pub residual_mm: f64,
    /// In units of its standard deviation (Baarda's w): standard normal if nothing is wrong.
    pub standardized: f64,
    /// Redundancy number, the part of an error in the length that its residual shows; `None` of a length that
    /// was removed.
    pub redundancy: Option<f64>,
}

impl LengthsAdjustment<'_> {
    /// The residuals of all lengths, in measuring order.
    pub fn residuals(&self) -> Vec<LengthResidual> {
        let screened = &self.screened;
        let solution = &screened.solution;
        let reliability = solution.reliability(&screened.network);
        let used = screened.kept.iter().zip(&solution.residuals_mm);
        let used = used.zip(&reliability);
        let used = used.map(|((&reading, &residual_mm), reliability)| LengthResidual {
            reading,
            residual_mm,
            standardized: reliability.standardized,
            redundancy: Some(reliability.redundancy),
        });
        let removed = screened.removed.iter().map(|removed| LengthResidual {
            reading: removed.reading,
            residual_mm: removed.error_mm,
            standardized: removed.error_mm / removed.u_mm,
            redundancy: None,
        });
        let mut residuals: Vec<LengthResidual> = used.chain(removed).collect();
        residuals.sort_by_key(|residual| residual.reading);
        residuals
    }
}
