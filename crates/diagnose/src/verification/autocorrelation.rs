//! Errors of stops that follow each other may be alike: those of air that stirs slowly, of a probe, or of a filter.
//!
//! Taken as independent they look like drifts, jumps and courses, and mean values of neighbours look more certain than they are. Their
//! correlation ρ is told by what repeats do not reproduce: of the readings beside a value of each position and side, an offset and a
//! slope of each pass, and the causes, restricted maximum likelihood
//!
//! ```text
//! -2 ln L(ρ) = (n - p) ln(rᵀV⁻¹r) + ln det V + ln det XᵀV⁻¹X        V_ij = ρ^(time between i and j)
//! ```
//!
//! asks for it ([`Whitening`]). What is alike over three stops or more is a course that wanders, so ρ ends at `e^-⅓`. A series is
//! taken to have such noise if ρ is significant there, or possible where something was found, and if with it the causes and what wanders have together more evidence than
//! without: what really wanders, or repeats, is explained better as such.

use trueaxis_selection::{Projection, lengths_beside_earlier};

use crate::engine::golden_section;
use crate::verification::base::{cells, indicators};
use crate::verification::model::{evidence, is_left};
use crate::verification::noise_floor::pass_columns;
use crate::verification::series::Series;
use crate::verification::whitening::Whitening;

/// Correlation of neighbours in noise that is alike over three stops.
const MOST: f64 = 0.716_531_310_573_789_3;

/// Drop of the deviance for one parameter on the edge of its range, at a level of 5 %.
const SIGNIFICANT: f64 = 2.706;

/// The same at a level of 24 %, where a series is not clean: correlated noise is then one of its explanations, and which is the best
/// their evidence says.
const POSSIBLE: f64 = 0.5;

/// Degrees of freedom below which ρ is too uncertain (`1/√n`).
const LEAST_DEGREES_OF_FREEDOM: f64 = 20.0;

/// Positions and sides that are looked at, at most; neighbours of those are as alike as the others.
const MOST_CELLS: usize = 120;

/// How well ρ is to be known.
const TOLERANCE: f64 = 0.01;

/// Noise of arrivals.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Noise {
    /// Standard deviation of one, µm.
    pub(crate) sigma_um: f64,
    /// Of those that follow each other.
    pub(crate) correlation: f64,
}

impl Noise {
    /// Of arrivals that are independent.
    pub(crate) fn white(sigma_um: f64) -> Self {
        Self {
            sigma_um,
            correlation: 0.0,
        }
    }
}

/// A series with correlated noise, if that explains it better than it is explained without.
pub(crate) fn alike_neighbours<'a>(
    found: &Series<'a>,
    with: impl Fn(Noise) -> Series<'a>,
) -> Option<Series<'a>> {
    let is_clean =
        found.model.causes.is_empty() && found.model.wandering.is_empty() && !is_left(&found.model);
    let least = if is_clean { SIGNIFICANT } else { POSSIBLE };
    let first = with(noise(found, least)?);
    // Beside the causes that are left.
    let last = with(noise(&first, least)?);
    // Twice the logarithm of the likelihood of the readings with a noise, but for what is the same with any.
    let (base, white) = (&found.plain.listed.base, &found.plain.whitening);
    let total = |series: &Series<'a>| {
        let base = Restricted::new(base, white, series.plain.whitening.correlation);
        evidence(&series.plain, &series.model) - base.deviance
    };
    (total(&last) > total(found)).then_some(last)
}

/// The noise of a series beside its causes, if neighbours are alike by a drop of the deviance.
fn noise(series: &Series<'_>, least: f64) -> Option<Noise> {
    let comparison = series.plain.comparison;
    let cells = cells(comparison).into_iter().enumerate();
    let (rows, cells): (Vec<usize>, Vec<usize>) =
        cells.filter(|(_, cell)| *cell < MOST_CELLS).unzip();
    let causes = series.model.problem.listed.columns(&series.model.causes);
    let causes = causes.iter().map(|column| series.plain.um(column));
    let others = pass_columns(comparison, true).into_iter().chain(causes);
    let cut = |column: &[f64]| rows.iter().map(|&row| column[row]).collect::<Vec<f64>>();
    let mut columns = indicators(&cells);
    columns.extend(others.map(|column| cut(&column)));
    let follows = |(i, &row): (usize, &usize)| match i > 0 && rows[i - 1] + 1 == row {
        true => comparison.lags[row],
        false => f64::INFINITY,
    };
    let lags: Vec<f64> = rows.iter().enumerate().map(follows).collect();
    let white = Whitening {
        lags: &lags,
        sigma_um: 1.0,
        correlation: 0.0,
        pseudo: 0,
    };
    let beside = Projection::dense(cut(&comparison.difference_um), &columns);
    if beside.degrees_of_freedom < LEAST_DEGREES_OF_FREEDOM {
        return None;
    }
    let at = |correlation: f64| Restricted::new(&beside, &white, correlation);
    let is_close = |low: f64, high: f64| high - low < TOLERANCE;
    let correlation = golden_section([0.0, MOST], is_close, |rho| -at(rho).deviance);
    let best = at(correlation);
    (at(0.0).deviance - best.deviance > least).then(|| Noise {
        sigma_um: (best.squares / beside.degrees_of_freedom).sqrt(),
        correlation,
    })
}

/// A model of readings that are alike.
struct Restricted {
    /// `-2 ln L` but for what is the same with every correlation.
    deviance: f64,
    /// Of what the model leaves, `rᵀV⁻¹r`.
    squares: f64,
}

impl Restricted {
    /// `beside` is that of independent ones, whitened so.
    fn new(beside: &Projection, white: &Whitening<'_>, correlation: f64) -> Self {
        let whitening = Whitening {
            correlation,
            ..*white
        };
        let again = |column: Vec<f64>| {
            let mut row = whitening.whiten(&white.um(&column));
            let readings = white.lags.len();
            row[readings..].copy_from_slice(&column[readings..]);
            row
        };
        let width = beside.shared_width;
        let of_base = (0..width).map(|k| {
            let rows = 0..beside.rows();
            rows.map(|row| beside.shared_row(row)[k]).collect()
        });
        let columns = of_base.chain([beside.residuals.clone()]).map(again);
        let lengths = lengths_beside_earlier(&columns.collect::<Vec<_>>());
        let (left, lengths) = (lengths[width], &lengths[..width]);
        let squares = left.powi(2).max(f64::MIN_POSITIVE);
        let ln_determinant = 2.0 * lengths.iter().map(|x| x.ln()).sum::<f64>();
        Self {
            deviance: beside.degrees_of_freedom * squares.ln()
                + whitening.ln_determinant()
                + ln_determinant,
            squares,
        }
    }
}
