//! Whether the curve of a line is another one after a jump: an encoder that was exchanged has another zero and other errors along the
//! axis, a machine or an instrument that shifts has not.
//!
//! Columns that are one after the instant at one position each are tested beside the causes (F test). What a straight line in the
//! position takes is none of it: the axis may have grown meanwhile.

use trueaxis_effects::{Level, Shape};

use crate::engine::Chosen;
use crate::selection::{Projection, ln_f_test};
use crate::verification::base::{indicators, places};
use crate::verification::problem::Problem;
use crate::verification::report::rms_of_readings_um;
use crate::{Unexplained, selection::Fit};

/// What differs between the curves before and after one of the causes, in what a model with all of them leaves.
pub(crate) fn another_curve(
    problem: &Problem<'_>,
    causes: &[Chosen],
    after: &Projection,
) -> Option<Unexplained> {
    let comparison = problem.comparison;
    let axis = comparison.line()?;
    let is_jump = |cause: &&Chosen| {
        let effect = problem.listed.hypothesis(cause).effect;
        effect.shape == Shape::Instant
    };
    let jump = causes.iter().find(is_jump)?;
    let is_later = |row: usize| comparison.arrivals[row].time_s > jump.shape;
    let later = |column: &[f64]| {
        let cut = column.iter().enumerate();
        let cut = cut.map(|(row, x)| if is_later(row) { *x } else { 0.0 });
        problem.whiten(&cut.collect::<Vec<f64>>())
    };
    let at: Vec<f64> = comparison
        .arrivals
        .iter()
        .map(|a| a.positions[axis])
        .collect();
    let straight = after.extended(&[later(&vec![1.0; at.len()]), later(&at)]);
    let curve: Vec<Vec<f64>> = indicators(&places(comparison))
        .iter()
        .map(|c| later(c))
        .collect();
    let with = straight.extended(&curve);
    let (drop, freedom) = (
        straight.squares() - with.squares(),
        straight.degrees_of_freedom,
    );
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a count"
    )]
    let rank = (freedom - with.degrees_of_freedom).max(0.0) as usize;
    let ln_p = ln_f_test(drop, straight.squares(), rank, freedom);
    let explained = || Fit::new(&straight, &curve).explained;
    (rank > 0 && with.degrees_of_freedom > 0.0 && ln_p < problem.level.ln()).then(|| Unexplained {
        level: Level::Verification,
        data: String::new(),
        rms_um: rms_of_readings_um(problem, &explained()),
        share: 0.0,
        is_of_tests: false,
        varies_with: vec!["time", "position"],
        note: "after the jump the curve along the axis is another one, which no shift of the machine or of the instrument makes: see \
               whether an encoder, its reading head or the optics were exchanged, aligned or set anew meanwhile, and diagnose the readings \
               before and after it apart"
            .to_owned(),
    })
}
