//! The covariance of all results, linear in the number of steps.
//!
//! ```text
//! cov = blockdiag(B_1, B_2, …, 0) + U M Uᵀ
//! ```
//!
//! `B_n` is the noise of the pose at a node alone, in its six component errors. Everything else is shared by many
//! results: the parameters of the gauge of an axis, the component errors where axes stand while others are measured,
//! stations, dead paths, shapes of targets, the scale of the machine's other axes in its frame. `U` has a row for
//! each result and a column for each of these; `M` is symmetric and, as a gauge takes noise away, not definite.

use nalgebra::{DMatrix, DVector, Matrix6, Matrix6xX, Vector6};

use crate::sensitivities::{Rows, Sensitivities};

/// Covariance of all results of a calibration in mm and rad: the component errors of all axes (for each position all
/// six), the location errors, the stations (x y z and dead path of each).
///
/// What gauge or frame define has zero rows.
#[derive(Debug, Clone, PartialEq)]
pub struct FactoredCovariance {
    /// `B`: of each node of each axis, the part of its six component errors that no other result shares.
    pub own: Vec<Matrix6<f64>>,
    /// `U`: sensitivities of the results (rows) to what is shared (columns).
    pub sensitivities: Sensitivities,
    /// `M`: covariance of what is shared.
    pub shared: DMatrix<f64>,
}

impl FactoredCovariance {
    /// From `B`, rows of `U` that follow each other, and `M` of as many columns; those that no row uses are left out.
    pub fn new(own: Vec<Matrix6<f64>>, rows: Vec<Rows>, shared: &DMatrix<f64>) -> Self {
        let mut sensitivities = Sensitivities::new(shared.nrows(), rows);
        let used = sensitivities.drop_unused_columns();
        Self {
            own,
            sensitivities,
            shared: shared.select_rows(&used).select_columns(&used),
        }
    }

    /// Of results that are taken as exact, those of `nodes` nodes first.
    pub fn zero(nodes: usize, results: usize) -> Self {
        let rows = Rows::new(0, &DMatrix::zeros(results, 0));
        Self {
            own: vec![Matrix6::zeros(); nodes],
            sensitivities: Sensitivities::new(0, vec![rows]),
            shared: DMatrix::zeros(0, 0),
        }
    }

    /// Number of results.
    pub fn results(&self) -> usize {
        self.sensitivities.shape().0
    }

    /// The covariance as one matrix, symmetric to the last bit.
    pub fn dense(&self) -> DMatrix<f64> {
        self.of_results(&(0..self.results()).collect::<Vec<_>>())
    }

    /// The covariance of some results, in this order, as one matrix, symmetric to the last bit.
    pub fn of_results(&self, places: &[usize]) -> DMatrix<f64> {
        let mut sensitivities = DMatrix::zeros(places.len(), self.shared.nrows());
        for (i, &place) in places.iter().enumerate() {
            for (column, x) in self.sensitivities.row(place) {
                sensitivities[(i, column)] = x;
            }
        }
        let through = &sensitivities * &self.shared;
        let mut matrix = through * sensitivities.transpose();
        for (i, a) in places.iter().enumerate() {
            let Some(own) = self.own.get(a / 6) else {
                continue;
            };
            for (j, b) in places.iter().enumerate().filter(|(_, b)| *b / 6 == a / 6) {
                matrix[(i, j)] += own[(a % 6, b % 6)];
            }
        }
        matrix.fill_lower_triangle_with_upper_triangle();
        matrix
    }

    /// Standard uncertainty of a linear function of the results, given by the places of results and coefficients.
    pub fn u(&self, function: &[(usize, f64)]) -> f64 {
        let mut through = DVector::zeros(self.shared.nrows());
        let mut of_nodes: Vec<(usize, Vector6<f64>)> = Vec::with_capacity(function.len());
        for &(place, c) in function {
            for (column, x) in self.sensitivities.row(place) {
                through[column] += x * c;
            }
            if place < 6 * self.own.len() {
                of_nodes.push((place / 6, Vector6::ith(place % 6, c)));
            }
        }
        of_nodes.sort_by_key(|(node, _)| *node);
        let own = of_nodes.chunk_by(|a, b| a.0 == b.0).map(|of_node| {
            let c: Vector6<f64> = of_node.iter().map(|(_, c)| c).sum();
            c.dot(&(self.own[of_node[0].0] * c))
        });
        let variance = through.dot(&(&self.shared * &through)) + own.sum::<f64>();
        variance.max(0.0).sqrt()
    }

    /// Covariance of six functions with six others: coefficients of the results in all six.
    pub(crate) fn of_functions(
        &self,
        a: &[(usize, Vector6<f64>)],
        b: &[(usize, Vector6<f64>)],
    ) -> Matrix6<f64> {
        let through = |functions: &[(usize, Vector6<f64>)]| {
            let mut sum = Matrix6xX::zeros(self.shared.nrows());
            for (place, coefficients) in functions {
                for (column, x) in self.sensitivities.row(*place) {
                    sum.column_mut(column).axpy(x, coefficients, 1.0);
                }
            }
            sum
        };
        let mut covariance = through(a) * &self.shared * through(b).transpose();
        for (i, of_a) in a {
            let Some(own) = self.own.get(i / 6) else {
                continue;
            };
            for (j, of_b) in b.iter().filter(|(j, _)| j / 6 == i / 6) {
                covariance += of_a * of_b.transpose() * own[(i % 6, j % 6)];
            }
        }
        covariance
    }

    /// Each result times a factor.
    pub(crate) fn multiplied(mut self, factors: &[f64]) -> Self {
        for (own, factors) in self.own.iter_mut().zip(factors.chunks_exact(6)) {
            *own = multiplied(own, factors);
        }
        self.sensitivities.multiply(factors);
        self
    }

    /// Adds an error that the results have in common, with this standard deviation in each.
    pub fn add_common(&mut self, change: &[f64]) {
        let columns = self.shared.nrows();
        self.sensitivities.push_column(change);
        let shared = std::mem::replace(&mut self.shared, DMatrix::zeros(0, 0));
        self.shared = shared.resize(columns + 1, columns + 1, 0.0);
        self.shared[(columns, columns)] = 1.0;
    }
}

/// The covariance of six results, each times a factor.
pub(crate) fn multiplied(own: &Matrix6<f64>, factors: &[f64]) -> Matrix6<f64> {
    Matrix6::from_fn(|i, j| own[(i, j)] * (factors[i] * factors[j]))
}
