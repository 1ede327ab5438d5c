//! The points without what poses, shapes and causes absorb.
//!
//! The whitened system has a block of six columns for each pose, with the orthonormal basis `O`, and columns for the
//! shapes of all stages, with the basis `T` orthogonal to all `O`; what the data do not determine is in neither.

use std::sync::Arc;

use nalgebra::{DMatrix, SymmetricEigen};
use trueaxis_selection::{Fit, Projection};

use crate::engine::{Suspect, Wanders, whitened};
use crate::numbers::squares;
use crate::points::base::{Base, of_pose};
use crate::points::noise::{Noise, StopWhitening};
use crate::points::readings::Reading;

/// An adjusted model.
pub(crate) struct Model {
    pub(crate) noise: Noise,
    pub(crate) whitening: Arc<Vec<StopWhitening>>,
    /// Weight of each stop: 1, or practically none if it is held out.
    weights: Vec<f64>,
    /// The base model, with disturbances in its covariance.
    pub(crate) bare: Projection,
    /// The base model with the causes.
    pub(crate) projection: Projection,
    /// The causes with their parameters, fitted together.
    pub(crate) suspects: Vec<Suspect>,
}

/// Factor on the coordinates of stops that are to be predicted: their squares then have no weight.
pub(crate) const NO_WEIGHT: f64 = 1e-4;

impl Model {
    /// The model with columns of causes (mm) and given noise; stops that are `held` have practically no weight.
    pub(crate) fn with(
        base: &Base<'_>,
        causes_mm: &[Vec<f64>],
        noise: Noise,
        held: Option<&[bool]>,
    ) -> Self {
        let weight = |stop: usize| match held {
            Some(held) if held[stop] => NO_WEIGHT,
            _ => 1.0,
        };
        let weights: Vec<f64> = (0..base.readings.stops.len()).map(weight).collect();
        let whitening = noise.whitening(&base.readings);
        let bare = eliminated(base, |column| {
            whiten(base, (&whitening, &weights), column);
        });
        let mut model = Self {
            noise,
            whitening: Arc::new(whitening),
            weights,
            projection: bare.clone(),
            bare,
            suspects: Vec::new(),
        };
        for own in &base.disturbances {
            let columns_mm = base.columns_of_unit_mm(own.wanderer);
            let scaled = own.scaled(base.scene, &base.here(), columns_mm);
            let columns = whitened(base, &model, scaled);
            model.bare = model.bare.beside(&columns).0;
        }
        let columns = whitened(base, &model, causes_mm.to_vec());
        model.projection = model.bare.extended(&columns);
        model
    }

    pub(crate) fn whiten(&self, base: &Base<'_>, column: &mut [f64]) {
        whiten(base, (&self.whitening, &self.weights), column);
    }

    /// Undoes the whitening of coordinates of full weight: mm.
    pub(crate) fn colour(&self, base: &Base<'_>, column: &mut [f64]) {
        for (stop, own) in base.readings.stops.iter().zip(self.whitening.iter()) {
            own.colour(&mut column[3 * stop.start..3 * stop.end]);
        }
    }

    /// The same with the parameters of its causes, fitted together.
    pub(crate) fn fitted(self, base: &Base<'_>, suspects: Vec<Suspect>) -> Self {
        let columns = whitened(base, &self, base.columns_of(&suspects));
        let fit = Fit::new(&self.bare, &columns);
        let mut first = 0;
        let of_one = |suspect: Suspect| {
            let own = first..first + suspect.parameters.len();
            first = own.end;
            Suspect::new(
                suspect.hypothesis,
                (suspect.shape, suspect.u_shape),
                &fit.part(own),
            )
        };
        let suspects = suspects.into_iter().map(of_one).collect();
        Self { suspects, ..self }
    }

    /// What poses and shapes leave of a row alone, in squares.
    pub(crate) fn left_of_row(&self, row: usize) -> f64 {
        let taken = [
            self.projection.own_row(row),
            self.projection.shared_row(row),
        ];
        1.0 - taken.into_iter().flatten().map(|x| x * x).sum::<f64>()
    }
}

/// `Xᵀ M X` of columns that are zero except in a few rows of one pose from `first` on; rows one after the other.
pub(crate) fn left_of(projection: &Projection, first: usize, columns: &[Vec<f64>]) -> Vec<f64> {
    let through = |column: &Vec<f64>| {
        let mut sums = vec![0.0; projection.own_width + projection.shared_width];
        for (k, x) in column.iter().enumerate() {
            let rows = [
                projection.own_row(first + k),
                projection.shared_row(first + k),
            ];
            for (sum, value) in sums.iter_mut().zip(rows.into_iter().flatten()) {
                *sum += x * value;
            }
        }
        sums
    };
    let taken: Vec<Vec<f64>> = columns.iter().map(through).collect();
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let pairs = (0..columns.len()).flat_map(|i| (0..columns.len()).map(move |k| (i, k)));
    pairs
        .map(|(i, k)| dot(&columns[i], &columns[k]) - dot(&taken[i], &taken[k]))
        .collect()
}

/// Eigenvalue of a normal matrix of columns of unit length below which the data do not determine a combination.
const DETERMINED: f64 = 1e-10;

/// Whitens a column stop by stop, with a weight for each.
fn whiten(base: &Base<'_>, (whitening, weights): (&[StopWhitening], &[f64]), column: &mut [f64]) {
    let stops = base.readings.stops.iter().zip(whitening).zip(weights);
    for ((stop, whitening), weight) in stops {
        let rows = &mut column[3 * stop.start..3 * stop.end];
        whitening.apply(rows);
        rows.iter_mut().for_each(|row| *row *= weight);
    }
}

/// Projects out poses and shapes.
fn eliminated(base: &Base<'_>, whiten: impl Fn(&mut Vec<f64>)) -> Projection {
    let readings = &base.readings;
    let rows = 3 * readings.all.len();
    let mut residuals = base.misfit_mm.clone();
    whiten(&mut residuals);
    let own = (0..6).map(|k| {
        let by_pose = base.by_pose.iter();
        let values = by_pose.flat_map(|by| by.column(k).into_owned().data.0[0]);
        let mut column: Vec<f64> = values.collect();
        whiten(&mut column);
        column
    });
    let own: Vec<Vec<f64>> = own.collect();
    let mut shapes = vec![vec![0.0; rows]; 3 * readings.shapes.len()];
    for (i, (reading, by)) in readings.all.iter().zip(&base.by_shape).enumerate() {
        for k in 0..3 {
            let column = &mut shapes[3 * reading.shape + k];
            (0..3).for_each(|row| column[3 * i + row] = by[(row, k)]);
        }
    }
    shapes.iter_mut().for_each(&whiten);
    let lengths: Vec<f64> = shapes.iter().map(|column| squares(column).sqrt()).collect();

    // O, and everything else orthogonal to it.
    let mut basis = vec![0.0; 6 * rows];
    let mut degrees_of_freedom = rows as f64;
    // Targets on the bed have no pose: they are one more group, without columns.
    let groups = readings.steps.len() + 1;
    for points in &of_pose(readings) {
        let of: Vec<usize> = points.iter().flat_map(|i| 3 * i..3 * i + 3).collect();
        let values = DMatrix::from_fn(of.len(), 6, |i, k| own[k][of[i]]);
        let lengths: Vec<f64> = values.column_iter().map(|c| c.norm()).collect();
        let unit = orthonormal(values, &lengths);
        degrees_of_freedom -= unit.ncols() as f64;
        for (i, &row) in of.iter().enumerate() {
            for k in 0..unit.ncols() {
                basis[6 * row + k] = unit[(i, k)];
            }
        }
        for column in shapes.iter_mut().chain([&mut residuals]) {
            for k in 0..unit.ncols() {
                let rows = || of.iter().enumerate();
                let along: f64 = rows().map(|(i, &r)| unit[(i, k)] * column[r]).sum();
                rows().for_each(|(i, &r)| column[r] -= along * unit[(i, k)]);
            }
        }
    }
    let values = DMatrix::from_fn(rows, shapes.len(), |i, k| shapes[k][i]);
    let unit = orthonormal(values, &lengths);
    degrees_of_freedom -= unit.ncols() as f64;
    for column in unit.column_iter() {
        let along: f64 = column.iter().zip(&residuals).map(|(t, e)| t * e).sum();
        residuals
            .iter_mut()
            .zip(column.iter())
            .for_each(|(e, t)| *e -= along * t);
    }
    let group_of = |r: &Reading| r.pose.unwrap_or(groups - 1);
    let group_of_row = readings.all.iter().flat_map(|r| [group_of(r); 3]);
    Projection {
        degrees_of_freedom,
        group_of_row: Arc::new(group_of_row.collect()),
        groups,
        own: Arc::new(basis),
        own_width: 6,
        shared_width: unit.ncols(),
        shared: Arc::new(unit.transpose().iter().copied().collect()),
        ..Projection::of_nothing(residuals)
    }
}

/// Orthonormal columns that span those of a matrix, without those that are rounding.
///
/// Columns are first divided by their `lengths` before any projection: where the repeatability is much larger than
/// the noise of the instrument, whitening makes columns common to a stop small.
fn orthonormal(mut columns: DMatrix<f64>, lengths: &[f64]) -> DMatrix<f64> {
    for (mut column, &length) in columns.column_iter_mut().zip(lengths) {
        if length > 0.0 {
            column /= length;
        }
    }
    let eigen = SymmetricEigen::new(columns.transpose() * &columns);
    let kept = (0..eigen.eigenvalues.len()).filter(|&k| eigen.eigenvalues[k] > DETERMINED);
    let vectors = kept.map(|k| eigen.eigenvectors.column(k) / eigen.eigenvalues[k].sqrt());
    let vectors: Vec<_> = vectors.collect();
    match vectors.is_empty() {
        true => DMatrix::zeros(columns.nrows(), 0),
        false => columns * DMatrix::from_columns(&vectors),
    }
}
