//! Whether a line has another curve after a jump: an exchanged encoder has another zero and other errors along the
//! axis, a shifted machine or instrument has not.
//!
//! Columns that are one after the instant at one position each are tested beside the causes (F test). A straight line
//! in the position does not count: the axis may have grown meanwhile.

use trueaxis_effects::{Level, Shape};
use trueaxis_selection::{Fit, Projection};

use crate::Unexplained;
use crate::engine::linear::Chosen;
use crate::engine::{Family, Omnibus};
use crate::verification::base::{indicators, places, times};
use crate::verification::problem::Problem;
use crate::verification::report::rms_of_readings_um;

/// The difference of the curves before and after one of the causes, in what a model with all of them leaves.
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
    let arrivals = || comparison.arrivals.iter();
    let is_later = arrivals().map(|a| f64::from(u8::from(a.time_s > jump.shape)));
    let is_later: Vec<f64> = is_later.collect();
    let later = |column: &Vec<f64>| problem.whiten(&times(column, &is_later));
    let at: Vec<f64> = arrivals().map(|a| a.positions[axis]).collect();
    let straight = after.extended(&[problem.whiten(&is_later), later(&at)]);
    let curve = Family {
        varies_with: "position",
        columns: indicators(&places(comparison)).iter().map(later).collect(),
    };
    let test = Omnibus::of(&curve, &straight).test;
    let is_tested = test.columns > 0 && (test.columns as f64) < straight.degrees_of_freedom;
    (is_tested && test.p_value < problem.level).then(|| {
        let explained = Fit::new(&straight, &curve.columns).explained;
        let rms_um = rms_of_readings_um(problem, &explained);
        let note = "after the jump the axis has another curve, which no shift of the machine or of the instrument explains: see whether an \
               encoder, its reading head or the optics were exchanged, realigned or reset meanwhile, and diagnose the readings before \
               and after it separately";
        let varies_with = vec!["time", "position"];
        Unexplained::new(Level::Verification, rms_um, varies_with, note.to_owned())
    })
}
