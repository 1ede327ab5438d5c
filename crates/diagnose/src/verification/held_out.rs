//! How well a model predicts readings that it was not fitted to.
//!
//! Each pass (cycle and direction) is cut into five blocks of neighbouring stops; fold k leaves out block k of the
//! first pass, block k - 1 of the second and so on. So what is left out has hardly any neighbours in the fit, and yet
//! every cycle, direction and position is known from the rest: a warm-up that is over after the first cycle could not
//! be predicted from the others. The prediction errors of the readings of a fold follow from the projection of all
//! ([`LeftOut`]). Shapes are chosen anew on the rest of each fold; which effects there are is known from all data. Where
//! several instants are equal for the rest, since all of them lie in what is left out, the readings on which they differ
//! are not predicted: rounding would choose one of them.
//!
//! With a calibration the prediction is taken as it is: unknowns for its errors would learn from the other cycles
//! what the calibration did not know.
//!
//! The interval of a ratio of rms comes from a bootstrap over these blocks, which keeps what neighbours have in
//! common. Whole passes would be too few: an effect of one pass is missing from one draw in three.

use trueaxis_selection::Projection;

use crate::engine::linear::{Candidate, Chosen, LeftOut};
use crate::engine::{FOLDS, HeldOut, in_blocks, without};
use crate::numbers::root_mean_square;
use crate::verification::arrivals::is_same;
use crate::verification::comparison::Comparison;
use crate::verification::problem::Problem;

/// Relative difference of squares that may be rounding.
const EQUAL: f64 = 1e-9;

/// Prediction errors of the readings, in standard deviations of an arrival.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Predicted {
    /// For each reading; `None` where it cannot be predicted without its fold.
    pub(crate) errors: Vec<Option<f64>>,
    /// Expectation of their squares from noise alone.
    pub(crate) expected: Vec<f64>,
}

/// The readings of each fold.
pub(crate) fn folds(comparison: &Comparison<'_>) -> [Vec<usize>; FOLDS] {
    let mut folds = [const { Vec::new() }; FOLDS];
    for (row, block) in pass_blocks(comparison).into_iter().enumerate() {
        // Block b of pass p.
        folds[(block % FOLDS + block / FOLDS) % FOLDS].push(row);
    }
    folds
}

/// Each pass cut into as many blocks as there are folds; the number of the block of each reading.
pub(crate) fn pass_blocks(comparison: &Comparison<'_>) -> Vec<usize> {
    let mut numbers = Vec::new();
    for (pass, rows) in comparison.passes.chunk_by(|a, b| a == b).enumerate() {
        let count = rows.len();
        numbers.extend((0..count).map(|i| pass * FOLDS + i * FOLDS / count));
    }
    numbers
}

/// Held-out errors of a model with causes.
pub(crate) fn held_out(problem: &Problem<'_>, causes: &[Chosen]) -> Predicted {
    // The causes as they are, and with each other value of one of the shapes.
    let mut variants = vec![causes.to_vec()];
    for (k, cause) in causes.iter().enumerate() {
        let candidate = &problem.listed.candidates[cause.candidate];
        for shape in other_shapes(candidate, cause.shape) {
            let mut variant = causes.to_vec();
            variant[k].shape = shape;
            variants.push(variant);
        }
    }
    let with = |v: &Vec<Chosen>| problem.as_predicted.extended(&problem.listed.columns(v));
    let models: Vec<Projection> = variants.iter().map(with).collect();
    let readings = problem.readings();
    let mut result = Predicted {
        errors: vec![None; readings],
        expected: vec![1.0; readings],
    };
    for rows in folds(problem.comparison) {
        // With the squares that the fit to the rest leaves.
        let fitted = models.iter().map(|model| {
            let left = LeftOut::new(model, rows.clone());
            let errors = left.errors(&model.residuals);
            let rest = model.squares() - left.product(&errors, &model.residuals);
            (rest, left, errors)
        });
        let fitted: Vec<(f64, LeftOut, Vec<f64>)> = fitted.collect();
        let least = fitted.iter().map(|f| f.0).fold(f64::INFINITY, f64::min);
        let limit = least + EQUAL * (1.0 + models[0].squares());
        let mut equal = fitted.into_iter().filter(|(rest, ..)| *rest <= limit);
        let Some((_, left, errors)) = equal.next() else {
            continue;
        };
        let mut are_told = vec![true; rows.len()];
        for (.., others) in equal {
            let pairs = errors.iter().zip(&others);
            for (is_told, (one, other)) in are_told.iter_mut().zip(pairs) {
                *is_told &= (one - other).abs() < EQUAL.sqrt();
            }
        }
        let predicted = left.determined(errors).into_iter().zip(left.expected());
        let predicted = predicted.zip(are_told);
        for (row, ((error, expected), is_told)) in rows.into_iter().zip(predicted) {
            result.errors[row] = error.filter(|_| is_told);
            result.expected[row] = expected * (1.0 - problem.hidden);
        }
    }
    result
}

/// The shapes that may suit the rest better. More waves of a free form always do.
pub(crate) fn other_shapes(candidate: &Candidate<'_>, shape: f64) -> impl Iterator<Item = f64> {
    let is_sought = candidate.hypothesis.has_shape();
    let shapes = candidate.columns.shapes();
    shapes.filter(move |other| is_sought && !is_same(*other, shape))
}

impl Predicted {
    /// Root mean square, standard deviations; `None` if nothing could be held out.
    pub(crate) fn rms(&self) -> Option<f64> {
        let errors: Vec<f64> = self.errors.iter().flatten().copied().collect();
        (!errors.is_empty()).then(|| root_mean_square(&errors))
    }
}

/// How well causes predict readings that the models were not fitted to: `after` against `before`.
pub(crate) fn gain(
    problem: &Problem<'_>,
    before: &Predicted,
    after: &Predicted,
) -> Option<HeldOut> {
    let blocks = pass_blocks(problem.comparison).into_iter().enumerate();
    HeldOut::of(&in_blocks(blocks.map(|(row, block)| {
        let squares = match (before.errors[row], after.errors[row]) {
            (Some(a), Some(b)) => [a * a, b * b, before.expected[row]],
            _ => [0.0; 3],
        };
        (block, squares)
    })))
}

/// The gain of one cause beside the others.
pub(crate) fn gain_of(problem: &Problem<'_>, causes: &[Chosen], k: usize) -> Option<HeldOut> {
    let before = held_out(problem, &without(causes, k));
    gain(problem, &before, &held_out(problem, causes))
}
