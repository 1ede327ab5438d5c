//! How the parameters of an axis and its component errors follow from the measured points.
//!
//! With the record's operator `P_i`, the shape error `w` of the targets on the stage (the mean over
//! the run of what no rigid motion explains, which the identification subtracts) and the gauge:
//!
//! ```text
//! e_i = P_i (dp_i - Q_iᵀ w)      w = mean Π_i Q_i dp_i      x = Σ Γ_i e_i      E_k = mean e - Λ x
//! ```
//!
//! (`Q`: stage at home from datum, `Π`: what is left after an unweighted rigid fit.) So with the
//! parameters `y = (x, w)` of an axis everything is linear: `y = Σ Y_i dp_i`, and
//! `E_k = mean P_i dp_i - Λ̂_k y`.

use nalgebra::{DMatrix, Matrix6xX};

use crate::axis_data::AxisData;
use crate::gauge::Gauge;
use crate::in_order;
use crate::matrix_products::add_product;
use crate::node_records::NodeRecords;
use crate::records::RecordFit;

/// The linear maps of one axis.
pub(crate) struct Sensitivity {
    /// Number of the axis' own parameters, which come first in `y`, and of the whole gauge `x`.
    pub(crate) location_parameters: usize,
    gauge_parameters: usize,
    /// For each run and target of it the first of the three elements of `w` in `y`.
    pub(crate) shapes: Vec<Vec<usize>>,
    /// `Y` of each record; columns are the coordinates of its points in the datum.
    pub(crate) parameters: Vec<DMatrix<f64>>,
    /// `Λ̂` of each node.
    pub(crate) node_effects: Vec<Matrix6xX<f64>>,
    width: usize,
}

impl Sensitivity {
    pub(crate) fn new(axis: &AxisData, gauge: &Gauge, fits: &[RecordFit]) -> Self {
        let gauge_parameters = gauge.parameters();
        let mut width = gauge_parameters;
        let shapes: Vec<Vec<usize>> = axis
            .runs
            .iter()
            .map(|run| {
                let first = width;
                width += 3 * run.targets.len();
                (0..run.targets.len()).map(|t| first + 3 * t).collect()
            })
            .collect();
        let mut new = Self {
            location_parameters: gauge.location_parameters,
            gauge_parameters,
            shapes,
            parameters: Vec::new(),
            node_effects: Vec::new(),
            width,
        };
        new.add_nodes(axis, gauge, fits);
        new.add_records(axis, gauge, fits);
        new
    }

    /// Number of parameters `y`.
    pub(crate) fn width(&self) -> usize {
        self.width
    }

    /// What the shape of the record's run does to its pose error: `P Qᵀ`, placed in `y`.
    fn shape_effect(&self, axis: &AxisData, record: usize, fit: &RecordFit) -> Matrix6xX<f64> {
        let mut effect = Matrix6xX::zeros(self.width);
        let datum_from_stage = (fit.stage_from_base * fit.base_from_datum).transpose();
        for (place, &first) in self.shapes[axis.records[record].run].iter().enumerate() {
            let block = fit.from_points.fixed_columns::<3>(3 * place) * datum_from_stage;
            effect.fixed_columns_mut::<3>(first).copy_from(&block);
        }
        effect
    }

    fn add_nodes(&mut self, axis: &AxisData, gauge: &Gauge, fits: &[RecordFit]) {
        let records = NodeRecords::new(axis);
        self.node_effects = in_order::map(axis.nodes.len(), |node| {
            let mut effect = Matrix6xX::zeros(self.width);
            let of_gauge = &gauge.node_effects[node];
            effect.columns_mut(0, of_gauge.ncols()).copy_from(of_gauge);
            let records = records.of(node);
            for &i in records {
                effect += self.shape_effect(axis, i, &fits[i]) / records.len() as f64;
            }
            effect
        });
    }

    fn add_records(&mut self, axis: &AxisData, gauge: &Gauge, fits: &[RecordFit]) {
        // x = Σ Γ P dp - (Σ Γ P Qᵀ) w
        let zero = || DMatrix::zeros(self.gauge_parameters, self.width);
        let add = |sum: &mut DMatrix<f64>, i: usize| {
            add_product(sum, &gauge.shares[i], &self.shape_effect(axis, i, &fits[i]));
        };
        let by_shape = in_order::sum(fits.len(), zero, add);
        self.parameters = in_order::map(fits.len(), |i| {
            let fit = &fits[i];
            let mut y = DMatrix::zeros(self.width, fit.from_points.ncols());
            let run = axis.records[i].run;
            for (place, &first) in self.shapes[run].iter().enumerate() {
                let rows = fit.distortion_from_points.rows(3 * place, 3);
                y.rows_mut(first, 3)
                    .copy_from(&(rows / axis.runs[run].records as f64));
            }
            let mut x = DMatrix::zeros(self.gauge_parameters, y.ncols());
            add_product(&mut x, &by_shape, &y);
            x.neg_mut();
            add_product(&mut x, &gauge.shares[i], &fit.from_points);
            y.rows_mut(0, self.gauge_parameters).copy_from(&x);
            y
        });
    }
}
