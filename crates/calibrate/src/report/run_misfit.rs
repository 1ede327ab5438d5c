//! Whether runs of one axis agree, with other axes parked elsewhere or at other times.
//!
//! Where runs share positions, the component errors `E_n` there are the mean of the runs, each with its own placement
//! `g` of its targets. With the noise of the poses and of the bases `b` (the axes outside, which may have other
//! positions in each run) the pose errors are
//!
//! ```text
//! e_i = E_n + Λ_i g_r + A_i ξ_i + C_i t     cov(ξ_i) = D_i     cov(t) = S     t: shared sources, and those of bases
//! ```
//!
//! With `A_i ξ_i` whitened and `E` and `g` eliminated (primed), the generalised least sum of squares follows from the
//! matrix inversion lemma, in a form without `S⁻¹`, as `S` may be indefinite:
//!
//! ```text
//! χ² = |e'|² - fᵀ S (I + G S)⁻¹ f     f = C'ᵀ e'     G = C'ᵀ C'
//! ```
//!
//! with the rows of the poses less the unknowns as degrees of freedom `ν`. Runs contradict each other if they
//! differ by more than their noise, and `√(χ²/ν)` (R. T. Birge, *Physical Review* 40, 207, 1932) is the factor.

use nalgebra::{DMatrix, DVector, Matrix6, Vector6};
use trueaxis_kinematics::Component;
use trueaxis_leastsquares::chi_squared_upper_tail;
use trueaxis_leastsquares::dense::Svd;

use crate::identify::gauge::PER_RUN;
use crate::propagate::propagation::Propagation;
use crate::result::calibration::{AxisResult, RunMisfit, widening_of_components};

/// Probability that any axis of a campaign is reported as having contradictory runs, if all agree.
const LEVEL: f64 = 0.01;

/// Relative singular value of the normal matrix of `g` below which a combination is free, because all runs share it.
const FREE: f64 = 1e-10;

/// For each axis the contradiction of its runs, if there is one.
pub(crate) fn run_misfits(propagation: &Propagation<'_, '_>) -> Vec<Option<RunMisfit>> {
    let data = propagation.dependence.context.data;
    let several = data.iter().filter(|axis| axis.runs.len() > 1).count();
    let of_axis = |k: usize| {
        let found = (data[k].runs.len() > 1).then(|| run_misfit(propagation, k))??;
        (found.p_value < LEVEL / several as f64).then_some(found)
    };
    (0..data.len()).map(of_axis).collect()
}

/// Distances of the average lines, or axes, of the runs of axis `k` from their mean: for each run the resulting
/// standard deviations of the location parameters, mm and rad.
///
/// The parameters `t_r` of a run, relative to those of all runs, are fitted to its pose errors together with the
/// placement of its targets. The line may be anywhere between the first and the last of `R` runs; if the runs
/// represent equally spaced positions, that is a uniform distribution with the covariance
///
/// ```text
/// (R - 1)/(R + 1) · 1/R Σ t_r t_rᵀ
/// ```
pub(crate) fn scatter_of_runs(propagation: &Propagation<'_, '_>, k: usize) -> Vec<DVector<f64>> {
    let (context, identified) = propagation.dependence.parts();
    let (data, gauge) = (&context.data[k], &identified.gauges[k]);
    let errors = context.pose_errors(&identified.state, k);
    let (own, runs) = (gauge.location_parameters, data.runs.len());
    let count = runs as f64;
    let factor = ((count - 1.0) / (count + 1.0) / count).sqrt();
    let of_run = |run: usize| {
        let of_run = (0..data.poses.len()).filter(|&i| data.poses[i].run == run);
        let place = own + PER_RUN * run;
        let rows = of_run.map(|i| {
            let mean = identified.state.axes[k].curve[data.poses[i].node].to_vector();
            let effect = &gauge.effects[i];
            let mut row = DMatrix::zeros(6, own + PER_RUN + 1);
            row.columns_mut(0, own).copy_from(&effect.columns(0, own));
            row.columns_mut(own, PER_RUN)
                .copy_from(&effect.columns(place, PER_RUN));
            row.column_mut(own + PER_RUN).copy_from(&(errors[i] - mean));
            row
        });
        let mut products = DMatrix::zeros(own + PER_RUN + 1, own + PER_RUN + 1);
        rows.for_each(|row| products.gemm_tr(1.0, &row, &row, 1.0));
        Some(solved(&products)?.rows(0, own) * factor)
    };
    (0..runs).filter_map(of_run).collect()
}

/// The solution of normal equations whose last column is the right-hand side, scaled to unit diagonal; `None` if they
/// are singular.
fn solved(products: &DMatrix<f64>) -> Option<DVector<f64>> {
    let count = products.nrows() - 1;
    let size = DVector::from_fn(count, |i, _| products[(i, i)].sqrt());
    let scaled = DMatrix::from_fn(count, count, |i, j| products[(i, j)] / (size[i] * size[j]));
    let right = DVector::from_fn(count, |i, _| products[(i, count)] / size[i]);
    let found = scaled.cholesky()?.solve(&right);
    Some(found.component_div(&size))
}

/// The contradiction of the runs of axis `k`; `None` if they share no position or their noise is not known.
fn run_misfit(propagation: &Propagation<'_, '_>, k: usize) -> Option<RunMisfit> {
    let (context, identified) = propagation.dependence.parts();
    let data = &context.data[k];
    let errors = context.pose_errors(&identified.state, k);
    let (products, covariance) = products(propagation, k, &errors)?;
    let (of_runs, of_sources) = (identified.gauges[k].parameters(), covariance.nrows());
    // The runs' own parameters are eliminated first.
    let own = products.view((0, 0), (of_runs, of_runs)).into_owned();
    let own = Svd::new(&own).ok()?;
    let limit = FREE * own.largest();
    let redundant = 6 * (data.poses.len() - data.nodes.len());
    let degrees_of_freedom = redundant.checked_sub(own.rank(limit));
    let degrees_of_freedom = degrees_of_freedom.filter(|dof| *dof > 0)?;
    let coupling = products
        .columns_range(of_runs..)
        .rows(0, of_runs)
        .into_owned();
    let others = products.view_range(of_runs.., of_runs..);
    let left = others - coupling.transpose() * own.pseudo_inverse(limit) * &coupling;
    let g = left.view((0, 0), (of_sources, of_sources));
    let f = left.column(of_sources).rows(0, of_sources).into_owned();
    let inner = DMatrix::identity(of_sources, of_sources) + g * &covariance;
    let through = covariance * inner.lu().solve(&f)?;
    let chi_squared = left[(of_sources, of_sources)] - f.dot(&through);

    // The largest difference between poses of a position, in units of the noise of a pose.
    let mut largest = (0.0, 0, Component::ALL[0], 0.0);
    for (node, poses) in data.poses_of.iter().enumerate() {
        let own = propagation.whole.own_of_pose(k, poses[0]);
        for component in Component::ALL {
            let c = component.index();
            let values = poses.iter().map(|&i| errors[i][c]);
            let [low, high] = [values.clone().reduce(f64::min), values.reduce(f64::max)];
            let difference = high.unwrap_or_default() - low.unwrap_or_default();
            let significance = difference / own[(c, c)].sqrt();
            if significance > largest.0 {
                largest = (significance, node, component, difference);
            }
        }
    }
    let (_, node, component, difference) = largest;
    let off = data.poses.iter().zip(&errors).map(|(pose, error)| {
        let mean_mm = identified.state.axes[k].curve[pose.node].translation_mm;
        (error.fixed_rows::<3>(0) - mean_mm).norm_squared()
    });
    let rms_mm = (off.sum::<f64>() / data.poses.len() as f64).sqrt();
    Some(RunMisfit {
        runs: context.run_names(k),
        rms_mm,
        chi_squared,
        degrees_of_freedom,
        p_value: chi_squared_upper_tail(chi_squared, degrees_of_freedom as f64),
        component,
        position: data.nodes[node].position,
        difference,
    })
}

/// The products of the columns of `g`, of `C`, and of `e`, whitened and without what is common to a position; and the
/// covariance `S` of the sources.
fn products(
    propagation: &Propagation<'_, '_>,
    k: usize,
    errors: &[Vector6<f64>],
) -> Option<(DMatrix<f64>, DMatrix<f64>)> {
    let (context, identified) = propagation.dependence.parts();
    let (data, noise) = (&context.data[k], &context.poses.noise);
    if noise.own.is_empty() {
        return None;
    }
    let whole = &propagation.whole;
    let of_bases = whole.sources.own.nrows();
    let sources = of_bases + noise.width();
    let mut covariance = whole.sources.own.clone().resize(sources, sources, 0.0);
    let mut of_shared = covariance.view_range_mut(of_bases.., of_bases..);
    of_shared.copy_from(&noise.shared);

    let gauge = &identified.gauges[k];
    let width = gauge.parameters() + sources + 1;
    let of_pose = |i: usize| -> Option<(Matrix6<f64>, DMatrix<f64>)> {
        let pose = &data.poses[i];
        let whitening = whole.own_of_pose(k, i).cholesky()?.l().try_inverse()?;
        let mut row = DMatrix::zeros(6, width);
        let mut put = |first: usize, block: &DMatrix<f64>| {
            row.columns_mut(first, block.ncols())
                .copy_from(&(whitening * block));
        };
        let dynamic = |block: &[f64]| DMatrix::from_column_slice(6, block.len() / 6, block);
        put(0, &dynamic(gauge.effects[i].as_slice()));
        let [through_bases, through_shared] = whole.sources_of_pose(k, i);
        put(gauge.parameters(), &through_bases);
        put(gauge.parameters() + of_bases, &through_shared);
        let mean = identified.state.axes[k].curve[pose.node].to_vector();
        put(width - 1, &dynamic((errors[i] - mean).as_slice()));
        Some((whitening, row))
    };
    let mut products = DMatrix::zeros(width, width);
    for poses in &data.poses_of {
        let poses: Option<Vec<_>> = poses.iter().map(|&i| of_pose(i)).collect();
        let poses = poses?;
        // The common part of all poses of the position is its component errors.
        let mut normal = Matrix6::zeros();
        let mut right: DMatrix<f64> = DMatrix::zeros(6, width);
        for (whitening, row) in &poses {
            normal += whitening.transpose() * whitening;
            right += whitening.transpose() * row;
        }
        let common = normal.cholesky()?.inverse() * right;
        for (whitening, row) in &poses {
            let left = row - whitening * &common;
            products.gemm_tr(1.0, &left, &left, 1.0);
        }
    }
    Some((products, covariance))
}

/// Widens the uncertainties of the component errors of axes with contradictory runs.
pub(crate) fn widen(axes: &mut [AxisResult]) {
    for axis in axes {
        let factor = widening_of_components(axis);
        let dof = axis
            .runs
            .as_ref()
            .map_or(f64::INFINITY, |runs| runs.degrees_of_freedom as f64);
        for node in &mut axis.nodes {
            for c in 0..6 {
                node.u[c] *= factor;
                node.dof[c] = node.dof[c].min(dof);
                node.budget[c] = node.budget[c].times(factor * factor);
            }
        }
    }
}
