//! Common causes of several series that cancel causes of a single one.
//!
//! Two instruments read one motion: an offset of the time stamps in both, and lost motion of another size in each,
//! cancel each other as they do in one series (`engine/opposed.rs`).

use trueaxis_leastsquares::dot;
use trueaxis_selection::add;

use crate::engine::linear::Chosen;
use crate::engine::{are_opposed, fitted_effects};
use crate::verification::stack::Stack;

/// Whether the `k`th common cause of the series, and causes of only one of them (`own`, for each series), cancel each
/// other.
pub(crate) fn takes_own_away(
    stack: &Stack<'_>,
    own: &[Vec<Chosen>],
    common: &[Chosen],
    k: usize,
) -> bool {
    let of_all = common.iter().map(|cause| stack.listed.columns_of(cause));
    let of_all = fitted_effects(&stack.listed.base, &of_all.collect::<Vec<_>>());
    (0..own.len()).any(|number| {
        let series = &stack.all[number];
        let base = &series.model.problem.listed.base;
        let to_sigma = stack.scales_um[number] / series.plain.whitening.sigma_um;
        let rows = stack.rows(number);
        let in_series = of_all.iter().map(|effect| {
            let mut column: Vec<f64> = effect[rows.clone()].iter().map(|x| x * to_sigma).collect();
            column.resize(base.rows(), 0.0);
            column
        });
        let in_series: Vec<Vec<f64>> = in_series.collect();
        if own[number].is_empty() || dot(&in_series[k], &in_series[k]) == 0.0 {
            return false;
        }
        let mut left = base.residuals.clone();
        for column in &in_series {
            add(&mut left, column, -1.0);
        }
        let left = base.with_residuals(&left);
        let of_own = own[number].iter();
        let of_own = of_own.map(|cause| series.model.problem.listed.columns_of(cause));
        let mut effects = fitted_effects(&left, &of_own.collect::<Vec<_>>());
        effects.push(in_series[k].clone());
        are_opposed(base, &effects)
    })
}
