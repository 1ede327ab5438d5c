//! The gain of a common cause on readings that its size was not estimated from.
//!
//! Each series alone may show too little of it to predict its own readings; the one size of all does. So a fold is
//! left out of every series at once, and the size follows from the rest. With `x` the effect of a unit, `y` the
//! readings, both in standard deviations, and `M` the projection of a series without this cause, it is ([`LeftOut`])
//!
//! ```text
//! G = Σ (xᵀ M x - ε_xᵀ (M x)_h)   s = Σ (xᵀ M y - ε_xᵀ (M y)_h)   θ = G⁺ s
//! ```
//!
//! summed over the series; the prediction errors are `ε_y - ε_x θ`. A shape is chosen anew on the rest of each fold.

use trueaxis_leastsquares::dot;
use trueaxis_selection::{Gram, add};

use crate::engine::linear::{Chosen, LeftOut};
use crate::engine::{FOLDS, HeldOut, Squares};
use crate::verification::base::count;
use crate::verification::held_out::{folds, other_shapes, pass_blocks};
use crate::verification::series::Series;
use crate::verification::stack::Stack;

/// A series beside its other causes.
struct Beside<'s> {
    series: &'s Series<'s>,
    /// What they leave of its readings.
    y: Vec<f64>,
    /// For each shape a column for each parameter.
    x: Vec<Vec<Column>>,
    /// For each fold, what is left out.
    folds: [LeftOut; FOLDS],
}

/// Effect of a unit of a parameter.
struct Column {
    whole: Vec<f64>,
    /// What the other causes leave of it.
    left: Vec<f64>,
}

/// A size from the rest of all series.
struct Sized {
    shape: usize,
    size: Vec<f64>,
}

impl Stack<'_> {
    /// Gain of a cause with one size for all beside the others; `causes` are those of each series.
    pub(crate) fn gain_of(&self, cause: &Chosen, causes: &[Vec<Chosen>]) -> Option<HeldOut> {
        let candidate = &self.listed.candidates[cause.candidate];
        let shapes = std::iter::once(cause.shape).chain(other_shapes(candidate, cause.shape));
        let columns = shapes.map(|shape| candidate.columns(shape));
        let columns: Vec<Vec<Vec<f64>>> = columns.collect();
        let showing = (0..self.all.len()).filter_map(|number| {
            let own = self.members[cause.candidate][number]?;
            let others = causes[number].iter().filter(|c| c.candidate != own);
            let others: Vec<Chosen> = others.copied().collect();
            Some(self.beside(number, &others, &columns))
        });
        let showing: Vec<Beside<'_>> = showing.collect();
        let sizes: Vec<Option<Sized>> = (0..FOLDS).map(|fold| sized(&showing, fold)).collect();
        let blocks = showing.iter().flat_map(|beside| beside.blocks(&sizes));
        HeldOut::of(&blocks.collect::<Vec<_>>())
    }

    /// A series beside other causes.
    fn beside(&self, number: usize, others: &[Chosen], shapes: &[Vec<Vec<f64>>]) -> Beside<'_> {
        let series = &self.all[number];
        let problem = &series.model.problem;
        let model = problem
            .as_predicted
            .extended(&problem.listed.columns(others));
        let projected = |column: &Vec<f64>| {
            let mut whole = column[self.rows(number)].to_vec();
            whole.resize(model.rows(), 0.0);
            let left = model.left_of(&whole);
            Column { whole, left }
        };
        let of_shape = |columns: &Vec<Vec<f64>>| columns.iter().map(projected).collect();
        let scale = problem.whitening.sigma_um / self.scales_um[number];
        let folds = folds(series.plain.comparison).map(|rows| LeftOut::new(&model, rows));
        Beside {
            series,
            y: model.residuals.iter().map(|y| scale * y).collect(),
            x: shapes.iter().map(of_shape).collect(),
            folds,
        }
    }
}

impl Beside<'_> {
    /// The squares of each block of readings without the cause and with it; expected squares of noise are not needed.
    fn blocks(&self, sizes: &[Option<Sized>]) -> Vec<Squares> {
        let blocks = pass_blocks(self.series.plain.comparison);
        let mut sums = vec![[0.0; 3]; count(&blocks)];
        for (left, sized) in self.folds.iter().zip(sizes) {
            let Some(Sized { shape, size }) = sized else {
                continue;
            };
            let before = left.errors(&self.y);
            let mut after = before.clone();
            for (x, size) in self.x[*shape].iter().zip(size) {
                add(&mut after, &left.errors(&x.left), -size);
            }
            let before = left.determined(before);
            for (i, &row) in left.rows.iter().enumerate() {
                if let Some(before) = before[i] {
                    let sum = &mut sums[blocks[row]];
                    sum[0] += before * before;
                    sum[1] += after[i] * after[i];
                }
            }
        }
        sums
    }
}

/// The shape and size that explain most of the rest of a fold; `None` if the rest does not show it.
fn sized(all: &[Beside<'_>], fold: usize) -> Option<Sized> {
    let shapes = all.first()?.x.len();
    let of_shape = |shape: usize| {
        let parameters = all[0].x[shape].len();
        let mut gram = vec![0.0; parameters * parameters];
        let mut s = vec![0.0; parameters];
        let mut before = vec![0.0; parameters];
        for beside in all {
            let left = &beside.folds[fold];
            let columns = &beside.x[shape];
            for (i, x) in columns.iter().enumerate() {
                let errors = left.errors(&x.left);
                let rest = |z: &[f64]| dot(&x.whole, z) - left.product(&errors, z);
                for (k, z) in columns.iter().enumerate() {
                    gram[i * parameters + k] += rest(&z.left);
                }
                s[i] += rest(&beside.y);
                before[i] += dot(&x.whole, &x.whole);
            }
        }
        let gram = Gram::new(&gram, &before);
        let size = gram.estimates(&s);
        (gram.rank() > 0).then(|| (gram.statistic(&s), Sized { shape, size }))
    };
    let best = (0..shapes)
        .filter_map(of_shape)
        .max_by(|a, b| a.0.total_cmp(&b.0));
    best.map(|(_, sized)| sized)
}
