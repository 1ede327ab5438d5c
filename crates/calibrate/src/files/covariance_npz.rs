//! `covariance.npz`: the covariance of all results in factors, as three `NumPy` arrays.
//!
//! `own` (steps, 6, 6), `sensitivities` (results, shared) and `shared` (shared, shared), for results in the order of
//! [`Calibration::results`] and the units of `calibration.json`:
//!
//! ```text
//! covariance = blockdiag(own, 0) + sensitivities · shared · sensitivitiesᵀ
//! ```

use std::collections::BTreeMap;

use nalgebra::{DMatrix, Matrix6};
use trueaxis_files::{Array, from_npz, to_npy, to_npz};

use crate::files::read_error::CovarianceProblem;
use crate::result::calibration::Calibration;
use crate::result::factored_covariance::FactoredCovariance;

const OWN: &str = "own";
const SENSITIVITIES: &str = "sensitivities";
const SHARED: &str = "shared";

impl FactoredCovariance {
    /// Name of its file, beside `calibration.json`.
    pub const FILE: &str = "covariance.npz";
}

impl Calibration {
    /// The bytes of `covariance.npz`.
    pub fn covariance_npz(&self) -> Vec<u8> {
        let results = self.results().into_iter();
        let per_unit: Vec<f64> = results
            .map(|result| result.output.unit().size().recip())
            .collect();
        let FactoredCovariance {
            own,
            sensitivities,
            shared,
        } = self.factors.scaled(&per_unit);
        let blocks = own.iter().flat_map(|block| block.iter().copied());
        let (rows, columns) = sensitivities.shape();
        to_npz(&[
            // Symmetric: columns are rows.
            (OWN, to_npy(&[own.len(), 6, 6], blocks)),
            (
                SENSITIVITIES,
                to_npy(&[rows, columns], sensitivities.transpose().iter().copied()),
            ),
            (SHARED, to_npy(&[columns, columns], shared.iter().copied())),
        ])
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
        Ok(Self {
            own: own
                .data
                .chunks_exact(36)
                .map(Matrix6::from_row_slice)
                .collect(),
            sensitivities: DMatrix::from_row_slice(results, columns, &sensitivities.data),
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
