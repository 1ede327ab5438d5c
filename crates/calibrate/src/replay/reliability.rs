//! Which error of a length would be found, and how an undetected one changes the results.
//!
//! Internal reliability is the minimal detectable error of each length (of `trueaxis-screening`); external
//! reliability its effect on each result if undetected, through the whole calibration ([`Replay::responses`]).

use nalgebra::DMatrix;
use trueaxis_montecarlo::Model;

use crate::Error;
use crate::matrix_size::check_size;
use crate::replay::Replay;

/// Reliability of all used lengths.
#[derive(Debug, Clone, PartialEq)]
pub struct LengthsReliability {
    /// The used lengths in measuring order.
    pub lengths: Vec<LengthReliability>,
    /// The effect of the minimal detectable error of each length (row) on each result (column, in the order and units
    /// of [`Replay::results`]); zero where nothing checks the length.
    pub effects: DMatrix<f64>,
}

/// Reliability of one length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LengthReliability {
    /// The reading of the campaign.
    pub reading: usize,
    /// Redundancy number.
    pub redundancy: f64,
    /// Smallest error that is found with a probability of 80 %, mm; infinite where nothing checks the length.
    pub minimal_detectable_mm: f64,
    /// The result on which that error has the largest effect in units of its standard uncertainty, and that effect.
    pub worst: (usize, f64),
}

impl Replay<'_> {
    /// Reliability of the used lengths; `None` in a points campaign.
    ///
    /// # Errors
    /// [`Error::TooLarge`] if the matrix of effects would not fit.
    pub fn reliability(&self) -> Result<Option<LengthsReliability>, Error> {
        let Some(lengths) = &self.trials.measured.lengths else {
            return Ok(None);
        };
        let screened = &lengths.screened;
        let (rows, columns) = (screened.kept.len(), self.outputs());
        let matrix = || format!("what {rows} lengths do to {columns} results");
        check_size(matrix, [rows, columns], "calibrate fewer runs at a time")?;
        let mut responses = self.responses();
        let mut errors_mm = vec![0.0; rows];
        let mut effects = DMatrix::zeros(rows, columns);
        let mut lengths = Vec::with_capacity(rows);
        let tests = screened.tests();
        let detectable = screened.minimal_detectable();
        for (row, (test, &reading)) in tests.readings.iter().zip(&screened.kept).enumerate() {
            let mut worst = (0, 0.0);
            let minimal_detectable_mm = detectable * test.sigma_mm;
            if minimal_detectable_mm.is_finite() {
                errors_mm[row] = minimal_detectable_mm;
                let changes = responses.to(&errors_mm);
                errors_mm[row] = 0.0;
                for (column, (effect, result)) in changes.iter().zip(self.results()).enumerate() {
                    effects[(row, column)] = *effect;
                    let in_u = effect.abs() * result.output.unit().size() / result.u;
                    if in_u > worst.1 {
                        worst = (column, in_u);
                    }
                }
            }
            lengths.push(LengthReliability {
                reading,
                redundancy: test.redundancy,
                minimal_detectable_mm,
                worst,
            });
        }
        Ok(Some(LengthsReliability { lengths, effects }))
    }
}
