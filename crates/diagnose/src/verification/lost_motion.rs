//! Lost motion as a free function of the position: worn screws, belts and controls' windows follow no straight line.
//!
//! ```text
//! b(q) = mean + slope (q - q_mid) + Σ c_k r_k(q)
//! ```
//!
//! `r_k` is the half wave `cos kπx`, `k = 2, 3, …`, over the range of the positions, less its regression on the first
//! two terms, so that these keep their meaning. The number of waves is the shape, and their rank is its cost.

use nalgebra::{DMatrix, DVector};
use trueaxis_effects::POSITION_DEPENDENT_BACKLASH;
use trueaxis_leastsquares::dense::Svd;
use trueaxis_selection::{Fit, Hypothesis};

use crate::engine::linear::{Candidate, Chosen};
use crate::engine::{MOST_OF_FREEDOM, SMOOTH_LEVEL, most};
use crate::verification::base::{count, places};
use crate::verification::comparison::Comparison;
use crate::verification::problem::Problem;
use crate::{EstimatedParameter, LostMotionAt};

/// Half waves beside mean and slope up to which each number is tried: a smooth function.
const SMOOTH: usize = 6;

/// Most half waves: with more positions than that a function with a value of its own at each of them is not tried.
/// Time grows with the third power of their number.
const MOST_WAVES: usize = 40;

/// The numbers of waves beside mean and slope tried on a line: up to as many as the positions reached from both sides
/// determine, so with any value at each of them, as far as the repeats distinguish it from noise.
pub(crate) fn numbers_of_waves(comparison: &Comparison<'_>) -> Vec<usize> {
    let both = reached_from_both_sides(comparison).len();
    let freedom = comparison.arrivals.len() - count(&places(comparison));
    let told = both.min(most(MOST_OF_FREEDOM, freedom)).saturating_sub(2);
    let smooth = both.saturating_sub(2).min(SMOOTH);
    let most = told.min(MOST_WAVES);
    let rough = std::iter::successors(Some(smooth), |k| Some((2 * k).min(most)));
    let rough = rough.skip(1).take_while(|k| *k < most).chain([most]);
    (1..=smooth).chain(rough.filter(|k| *k > smooth)).collect()
}

/// Whether a hypothesis is lost motion of the axis of a line.
pub(crate) fn is_of_line(comparison: &Comparison<'_>, hypothesis: &Hypothesis) -> bool {
    hypothesis.effect.is_lost_motion() && hypothesis.subject.axis == comparison.line()
}

/// An arrival at each position that was reached from both sides, in the order of the positions.
pub(crate) fn reached_from_both_sides(comparison: &Comparison<'_>) -> Vec<usize> {
    let numbers = places(comparison);
    let of = |place: usize, forward: bool| {
        let mut arrivals = comparison.arrivals.iter().zip(&numbers);
        arrivals.position(|(a, number)| *number == place && (a.direction > 0.0) == forward)
    };
    (0..count(&numbers))
        .filter_map(|place| of(place, true).and(of(place, false)))
        .collect()
}

/// The difference of the sides of a line beside causes, and the most lost motion of a drive in use, µm or arcsec,
/// where that is less: then it is no lost motion, but what reverses with the axis does not go with time, either.
pub(crate) fn beyond_drives(problem: &Problem<'_>, causes: &[Chosen]) -> Option<[f64; 2]> {
    problem.comparison.line()?;
    let model = problem.listed.with(causes);
    let variance = model.squares() / model.degrees_of_freedom.max(1.0);
    let beyond = |own: &Candidate| {
        let [_, most] = *own.plausible.first()?.as_ref()?;
        let columns = own.columns(own.columns.shapes().next_back()?);
        let fit = Fit::new(&model, &columns);
        let rank = columns.len();
        let [along, _] = own.root_mean_square(&fit, variance);
        let size = match rank {
            1 => fit.estimates[0].abs(),
            _ => along,
        };
        (fit.ln_p(&model, rank) < SMOOTH_LEVEL.ln() && size > most).then_some([size, most])
    };
    let mut candidates = problem.listed.candidates.iter();
    candidates.find_map(|own| {
        let is_form = is_of_line(problem.comparison, &own.hypothesis);
        is_form.then(|| beyond(own)).flatten()
    })
}

/// Mean and slope whose columns differ by less than this share have the same effect on the readings.
const PROPORTIONAL: f64 = 1e-12;

/// The columns of a number of waves: the change of each reading by a unit of lost motion times `r_k` there.
/// `straight` are those of a unit of its mean and of its slope.
pub(crate) fn waves(
    comparison: &Comparison<'_>,
    [of_unit, of_slope]: &[Vec<f64>; 2],
    count: usize,
) -> Vec<Vec<f64>> {
    let rows = of_unit.len();
    let straight = DMatrix::from_fn(rows, 2, |i, k| [of_unit[i], of_slope[i]][k]);
    let inverse = Svd::new(&straight).map(|svd| svd.pseudo_inverse(PROPORTIONAL * svd.largest()));
    let waves = comparison.waves_of_position(count + 1, vec![0; rows]);
    waves
        .into_iter()
        .skip(1)
        .map(|wave| {
            let column = DVector::from_fn(rows, |i, _| of_unit[i] * wave[i]);
            let rest = match &inverse {
                Ok(inverse) => &column - &straight * (inverse * &column),
                Err(_) => column,
            };
            rest.as_slice().to_vec()
        })
        .collect()
}

/// At the positions reached from both sides the lost motion there for a unit of each parameter; `columns` are the
/// changes of the readings, the first for a unit everywhere.
pub(crate) fn sizes(comparison: &Comparison<'_>, columns: &[Vec<f64>]) -> Vec<Vec<f64>> {
    // Where the measured point lies on a rotary axis it shows no lost motion.
    let rows = reached_from_both_sides(comparison).into_iter();
    let rows = rows.filter(|&row| columns[0][row].abs() > 0.0);
    let size = |row: usize| columns.iter().map(|c| c[row] / columns[0][row]).collect();
    rows.map(size).collect()
}

/// The positions, mm or degrees, at which readings show how lost motion changes along their axis, those reached from
/// both sides, with its [`sizes`] there.
pub(crate) fn shown_along<'c>(
    comparison: &Comparison<'_>,
    cause: &'c Candidate<'_>,
) -> impl Iterator<Item = (f64, &'c [f64])> {
    let own = &cause.hypothesis;
    let changes = own.effect == POSITION_DEPENDENT_BACKLASH;
    let axis = comparison
        .line()
        .filter(|&axis| changes && own.subject.axis == Some(axis));
    let positions = axis.into_iter().flat_map(move |axis| {
        let kind = comparison.machine.axes()[axis].kind();
        let arrivals = reached_from_both_sides(comparison).into_iter();
        arrivals.map(move |row| kind.position_in_file(comparison.arrivals[row].positions[axis]))
    });
    positions.zip(cause.sizes.iter().map(Vec::as_slice))
}

/// The function at some positions ([`sizes`]), and its mean over these, the opposite of the mean reversal value of
/// ISO 230-2: `fit` is that of the cause, for observations of this variance, and `unit` that of lost motion. Nothing
/// without positions.
pub(crate) fn curve(
    shown: &[(f64, &[f64])],
    fit: &Fit,
    variance: f64,
    unit: &'static str,
) -> (Vec<LostMotionAt>, Option<EstimatedParameter>) {
    let n = fit.estimates.len();
    if shown.is_empty() {
        return (Vec::new(), None);
    }
    let estimates = DVector::from_column_slice(&fit.estimates);
    let covariance = DMatrix::from_row_slice(n, n, &fit.covariance) * variance;
    let told = |there: &DVector<f64>| {
        let variance = (&covariance * there).dot(there);
        (there.dot(&estimates), variance.max(0.0).sqrt())
    };
    let mut sum = DVector::zeros(n);
    let point = |&(at, there): &(f64, &[f64])| {
        let there = DVector::from_column_slice(&there[..n]);
        sum += &there;
        let (value, u) = told(&there);
        LostMotionAt { at, value, u }
    };
    let curve: Vec<LostMotionAt> = shown.iter().map(point).collect();
    let (value, u) = told(&(sum / curve.len() as f64));
    let mean = EstimatedParameter {
        name: "mean_lost_motion".to_owned(),
        value,
        u,
        unit,
    };
    (curve, Some(mean))
}
