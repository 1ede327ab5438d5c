//! `covariance.npz`: the covariance of all results in factors, as three `NumPy` arrays.
//!
//! `own` (steps, 6, 6), `sensitivities` (results, shared) and `shared` (shared, shared), for results in the order of
//! [`Calibration::results`] and the units of `calibration.json`:
//!
//! ```text
//! covariance = blockdiag(own, 0) + sensitivities · shared · sensitivitiesᵀ
//! ```

use std::collections::BTreeMap;
use std::io::{self, Cursor, Seek, Write};

use nalgebra::{DMatrix, Matrix6};
use trueaxis_files::{Array, NpzWriter, from_npz};

use crate::files::read_error::CovarianceProblem;
use crate::result::calibration::Calibration;
use crate::result::factored_covariance::{FactoredCovariance, scaled};
use crate::result::sensitivities::{Rows, Sensitivities};

const OWN: &str = "own";
const SENSITIVITIES: &str = "sensitivities";
const SHARED: &str = "shared";

/// Rows of sensitivities that are taken at a time.
const ROWS: usize = 768;

impl FactoredCovariance {
    /// Name of its file, beside `calibration.json`.
    pub const FILE: &str = "covariance.npz";
}

impl Calibration {
    /// The bytes of `covariance.npz`.
    pub fn covariance_npz(&self) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        // Memory takes everything, and the names differ.
        self.write_covariance_npz(&mut bytes)
            .expect("memory can be written");
        bytes.into_inner()
    }

    /// Writes `covariance.npz`.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn write_covariance_npz(&self, out: impl Write + Seek) -> io::Result<()> {
        let results = self.results().into_iter();
        let per_unit: Vec<f64> = results
            .map(|result| result.output.unit().size().recip())
            .collect();
        let FactoredCovariance {
            own,
            sensitivities,
            shared,
        } = &self.factors;
        let (rows, columns) = sensitivities.shape();
        let blocks = own.iter().zip(per_unit.chunks_exact(6));
        let blocks = blocks.map(|(own, factors)| scaled(own, factors).data.0);
        let elements = sensitivities.elements().enumerate();
        let mut npz = NpzWriter::new(out);
        // Symmetric: columns are rows.
        let blocks = blocks.flatten().flatten();
        npz.array(OWN, &[own.len(), 6, 6], blocks)?;
        let elements = elements.map(|(i, x)| x * per_unit[i / columns]);
        npz.array(SENSITIVITIES, &[rows, columns], elements)?;
        npz.array(SHARED, &[columns, columns], shared.iter().copied())?;
        npz.finish()?;
        Ok(())
    }
}

impl FactoredCovariance {
    /// The covariance of `results` results with so many nodes from the bytes of a file, in its units.
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
        let rows = sensitivities.data.chunks(ROWS * columns.max(1));
        let rows = rows.enumerate().map(|(i, piece)| {
            let count = piece.len() / columns.max(1);
            Rows::new(ROWS * i, &DMatrix::from_row_slice(count, columns, piece))
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
