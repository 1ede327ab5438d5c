//! What the adjustment leaves of each length.

use crate::Residual;
use crate::lengths::LengthsAdjustment;

impl LengthsAdjustment<'_> {
    /// The residuals of all lengths, in measuring order.
    pub(crate) fn residuals(&self) -> Vec<Residual> {
        let screened = &self.screened;
        let solution = &screened.solution;
        let tests = screened.tests();
        let used = screened.kept.iter().zip(&solution.residuals_mm);
        let used = used.zip(&tests.readings);
        let used = used.map(|((&reading, &residual_mm), test)| Residual {
            reading,
            coordinate: None,
            residual_mm,
            standardized: test.w,
            redundancy: Some(test.redundancy),
        });
        let removed = screened.removed.iter().map(|removed| Residual {
            reading: removed.reading,
            coordinate: None,
            residual_mm: removed.error_mm,
            standardized: removed.error_mm / removed.u_mm,
            redundancy: None,
        });
        let mut residuals: Vec<Residual> = used.chain(removed).collect();
        residuals.sort_by_key(|residual| residual.reading);
        residuals
    }
}
