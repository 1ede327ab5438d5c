//! The component errors of the nodes of an axis as functions of the sources.
//!
//! With the sources `t` of all axes ([`crate::propagate::sources`]) and the shared sources `s`
//!
//! ```text
//! E = m + L t - F s     cov(E) = B + L S Lᵀ + L Zᵀ + Z Lᵀ + F Σ Fᵀ     B = cov(m), Z = cov(m, t), S = cov(t): own parts
//! ```
//!
//! `L` contains the gauge, as the parameters of an axis are among its sources, and the bases that move.

use std::ops::Range;

use nalgebra::{DMatrix, DVector, Matrix6};

use crate::in_order;
use crate::propagate::axis_noise::AxisForm;
use crate::propagate::propagation::Noise;
use crate::propagate::variance::Variance;

/// Nodes that one thread takes at a time.
const NODES: usize = 128;

/// The functions of some nodes, six rows each.
pub(crate) struct NodeFunctions {
    /// `B` of each node.
    pub(crate) own: Vec<Matrix6<f64>>,
    /// The sources that enter, ascending: columns of `L` and `Z`.
    pub(crate) sources: Vec<usize>,
    /// `L`.
    pub(crate) of_sources: DMatrix<f64>,
    /// The part of `L` through a base that moves, over all sources.
    pub(crate) through_base: Option<DMatrix<f64>>,
    /// `Z`.
    pub(crate) with_sources: DMatrix<f64>,
    /// `-F`.
    pub(crate) of_shared: DMatrix<f64>,
}

impl Noise<'_> {
    /// The results of `f` for the functions of some nodes of axis `k` at a time; `f` also gets the first node.
    pub(crate) fn of_nodes<T: Send>(
        &self,
        k: usize,
        f: impl Fn(usize, NodeFunctions) -> T + Sync + Send,
    ) -> Vec<T> {
        let count = self.dependence.context.data[k].nodes.len();
        in_order::map(count.div_ceil(NODES), |chunk| {
            let first = NODES * chunk;
            f(
                first,
                self.node_functions(k, first..count.min(first + NODES)),
            )
        })
    }

    fn node_functions(&self, k: usize, nodes: Range<usize>) -> NodeFunctions {
        let (dependence, axis) = (self.dependence, &self.axes[k]);
        let gauge = &dependence.identified.gauges[k];
        let own_sources = &dependence.sources.axes[k];
        let form = AxisForm::component_errors(gauge, nodes.clone());
        let rows = form.parameters.nrows();
        // The base of an axis with one run, as most have, stands still: only the axis' own sources enter.
        let through_base = dependence.through_base(k, &form);
        let sources: Vec<usize> = match &through_base {
            Some(_) => (0..dependence.sources.stations).collect(),
            None => own_sources.places.clone(),
        };
        let mut of_sources = match &through_base {
            Some(all) => all.columns(0, sources.len()).into_owned(),
            None => DMatrix::zeros(rows, sources.len()),
        };
        let (own, with_own, of_shared) = axis.mean_errors(nodes, &own_sources.form);
        let mut with_sources = DMatrix::zeros(rows, sources.len());
        for (i, place) in own_sources.places.iter().enumerate() {
            let column = sources.partition_point(|source| source < place);
            if i < form.parameters.ncols() {
                let mut sum = of_sources.column_mut(column);
                sum += form.parameters.column(i);
            }
            let with = with_own.column(i);
            with_sources.column_mut(column).copy_from(&with);
        }
        let shared_of_sources = self.sources.shared.select_rows(&sources);
        NodeFunctions {
            own,
            of_shared: of_shared + &of_sources * shared_of_sources,
            sources,
            of_sources,
            through_base,
            with_sources,
        }
    }

    /// The effect of errors of the sources on the component errors of axis `k` through a base that moves.
    pub(crate) fn through_base(&self, k: usize, errors: &DVector<f64>) -> Vec<f64> {
        let count = self.dependence.context.data[k].nodes.len();
        let gauge = &self.dependence.identified.gauges[k];
        let form = AxisForm::component_errors(gauge, 0..count);
        let through_base = self.dependence.through_base(k, &form);
        through_base.map_or_else(
            || vec![0.0; 6 * count],
            |rows| (rows * errors).as_slice().to_vec(),
        )
    }

    /// Variances of the component errors of axis `k`, for each node.
    pub(crate) fn components(&self, k: usize) -> Vec<[Variance; 6]> {
        let chunks = self.of_nodes(k, |_, functions| self.variances(&functions));
        chunks.into_iter().flatten().collect()
    }

    fn variances(&self, functions: &NodeFunctions) -> Vec<[Variance; 6]> {
        let used = &functions.sources;
        let covariance = self.sources.own.select_rows(used).select_columns(used);
        let of_sources = &functions.of_sources;
        let through_gauge = (of_sources * covariance)
            .component_mul(of_sources)
            .column_sum();
        let mixed = of_sources
            .component_mul(&functions.with_sources)
            .column_sum();
        let through_base = functions.through_base.as_ref();
        let scatter = through_base.map(|rows| self.sources.scatter_of(rows));
        let through = self.poses.through_sources(&functions.of_shared);
        let of_node = |(node, own): (usize, &Matrix6<f64>)| {
            std::array::from_fn(|c| {
                let row = 6 * node + c;
                let uncancelled = own[(c, c)] + through_gauge[row];
                let scatter = scatter.as_ref().map_or(0.0, |s| s[row]);
                let own = uncancelled + 2.0 * mixed[row] + scatter;
                Variance::new(own, uncancelled, &through[row])
            })
        };
        functions.own.iter().enumerate().map(of_node).collect()
    }
}
