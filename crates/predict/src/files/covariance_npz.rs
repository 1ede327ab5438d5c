//! `covariance.npz`: the covariance of all results in factors, as three `NumPy` arrays.
//!
//! `own` (steps, 6, 6), `sensitivities` (results, shared) and `shared` (shared, shared), for results in the order of
//! a calibration's results and the units of `calibration.json`:
//!
//! ```text
//! covariance = blockdiag(own, 0) + sensitivities · shared · sensitivitiesᵀ
//! ```

use std::collections::BTreeMap;
use std::io;

use nalgebra::{DMatrix, Matrix6};
use trueaxis_files::{Array, NpzWriter, WriteSeek, from_npz};

use crate::factored_covariance::{FactoredCovariance, multiplied};
use crate::files::read_error::CovarianceProblem;
use crate::sensitivities::{Rows, Sensitivities};

const OWN: &str = "own";
const SENSITIVITIES: &str = "sensitivities";
const SHARED: &str = "shared";

/// Rows of sensitivities that are taken at a time.
const ROWS: usize = 768;

impl FactoredCovariance {
    /// Name of its file, beside `calibration.json`.
    pub const FILE: &str = "covariance.npz";

    /// Writes `covariance.npz`, each result times a factor: one over the size of its unit.
    pub fn write_npz(&self, out: &mut dyn WriteSeek, per_unit: &[f64]) -> io::Result<()> {
        let (rows, columns) = self.sensitivities.shape();
        let blocks = self.own.iter().zip(per_unit.chunks_exact(6));
        let blocks = blocks.map(|(own, factors)| multiplied(own, factors).data.0);
        let elements = self.sensitivities.elements().enumerate();
        let mut npz = NpzWriter::new(out);
        // Symmetric: columns are rows.
        let blocks = blocks.flatten().flatten();
        npz.array(OWN, &[self.own.len(), 6, 6], blocks)?;
        let elements = elements.map(|(i, x)| x * per_unit[i / columns]);
        npz.array(SENSITIVITIES, &[rows, columns], elements)?;
        npz.array(SHARED, &[columns, columns], self.shared.iter().copied())?;
        npz.finish().map(drop)
    }

    /// The covariance of `results` results, those of `nodes` nodes first, from the bytes of a file, in its units.
    pub(crate) fn from_npz(
        bytes: &[u8],
        nodes: usize,
        results: usize,
    ) -> Result<Self, CovarianceProblem> {
        let mut arrays = from_npz(bytes)?;
        let own = taken(&mut arrays, OWN, &[Some(nodes), Some(6), Some(6)])?;
        let sensitivities = taken(&mut arrays, SENSITIVITIES, &[Some(results), None])?;
        let columns = sensitivities.shape[1];
        let shared = taken(&mut arrays, SHARED, &[Some(columns), Some(columns)])?;
        let rows = (0..results).step_by(ROWS).map(|first| {
            let count = ROWS.min(results - first);
            let rows = &sensitivities.data[first * columns..(first + count) * columns];
            Rows::new(first, &DMatrix::from_row_slice(count, columns, rows))
        });
        Ok(Self {
            own: own
                .data
                .chunks_exact(36)
                .map(Matrix6::from_row_slice)
                .collect(),
            sensitivities: Sensitivities::new(columns, rows.collect()),
            shared: DMatrix::from_row_slice(columns, columns, &shared.data),
        })
    }
}

/// An array of this shape, in which `None` is any size.
fn taken(
    arrays: &mut BTreeMap<String, Array>,
    name: &'static str,
    shape: &[Option<usize>],
) -> Result<Array, CovarianceProblem> {
    let array = arrays.remove(name);
    let array = array.ok_or(CovarianceProblem::NoArray { name })?;
    let as_wanted = |(wanted, found): (&Option<usize>, &usize)| wanted.is_none_or(|n| n == *found);
    let fits = array.shape.len() == shape.len() && shape.iter().zip(&array.shape).all(as_wanted);
    if !fits {
        let sizes = shape
            .iter()
            .map(|size| size.map_or("any".to_owned(), |n| n.to_string()));
        let expected = sizes.collect::<Vec<_>>().join(" by ");
        let found = array.shape;
        return Err(CovarianceProblem::Shape {
            name,
            found,
            expected,
        });
    }
    if !array.data.iter().all(|x| x.is_finite()) {
        return Err(CovarianceProblem::NotFinite { name });
    }
    Ok(array)
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;

    /// 2,000 results, more than are taken at a time; the last file has nothing that they share.
    #[test]
    fn rows_come_back_also_if_nothing_is_shared() {
        const NODES: usize = 333;
        for columns in [2, 0] {
            let results = 6 * NODES + 2;
            let mut npz = NpzWriter::new(Cursor::new(Vec::new()));
            let unit = (0..36 * NODES).map(|i| f64::from(u8::from(i % 36 % 7 == 0)));
            npz.array(OWN, &[NODES, 6, 6], unit).unwrap();
            let sensitivities = (0..results * columns).map(|i| i as f64);
            npz.array(SENSITIVITIES, &[results, columns], sensitivities)
                .unwrap();
            let shared = (0..columns * columns).map(|i| [1.0, 0.0, 0.0, 1.0][i]);
            npz.array(SHARED, &[columns, columns], shared).unwrap();
            let bytes = npz.finish().unwrap().into_inner();
            let read = FactoredCovariance::from_npz(&bytes, NODES, results).unwrap();
            for place in [0, 767, 768, 1997, 1999] {
                let row = (0..columns).map(|k| ((place * columns + k) as f64).powi(2));
                let own = if place < 6 * NODES { 1.0 } else { 0.0 };
                let found = read.u(&[(place, 1.0)]);
                let expected = (own + row.sum::<f64>()).sqrt();
                assert!((found - expected).abs() < 1e-9, "{place}: {found}");
            }
        }
    }
}
