//! Errors of consecutive stops may be alike: errors of slowly moving air, of a probe, or of a filter.
//!
//! Taken as independent they look like drifts, jumps and courses, and means of neighbours look more certain than they
//! are. Their correlation ρ follows from what repeats do not reproduce: from the readings, with a value for each
//! position and side, an offset and a slope for each pass, and the causes in the model, restricted maximum likelihood
//!
//! ```text
//! -2 ln L(ρ) = (n - p) ln(rᵀV⁻¹r) + ln det V + ln det XᵀV⁻¹X        V_ij = ρ^(time between i and j)
//! ```
//!
//! gives it ([`Whitening`]). What is alike over three stops or more is a wandering course, so ρ is at most `e^-⅓`. A
//! series has such noise if ρ is significant, or possible where something was found, and if with it causes and
//! disturbances together have a larger 2 ln B: real disturbances and repeating effects are explained better as such.

use trueaxis_selection::{Projection, lengths_beside_earlier};

use crate::engine::golden_section;
use crate::verification::base::{cells, indicators};
use crate::verification::model::two_ln_b;
use crate::verification::noise_floor::pass_columns;
use crate::verification::series::Series;
use crate::verification::whitening::Whitening;

/// Correlation of neighbours in noise that is alike over three stops.
const MOST: f64 = 0.716_531_310_573_789_3;

/// Drop of the deviance for one parameter at the edge of its range, at a level of 5 %.
const SIGNIFICANT: f64 = 2.706;

/// The same at a level of 24 %, where a series is not clean: correlated noise is then one of its explanations, and
/// 2 ln B decides which is the best.
const POSSIBLE: f64 = 0.5;

/// Degrees of freedom below which ρ is too uncertain (`1/√n`).
const LEAST_DEGREES_OF_FREEDOM: f64 = 20.0;

/// Most positions and sides considered; neighbours among these are as alike as among the others.
const MOST_CELLS: usize = 120;

/// Tolerance of ρ.
const TOLERANCE: f64 = 0.01;

/// Noise of arrivals.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Noise {
    /// Standard deviation of one arrival, µm.
    pub(crate) sigma_um: f64,
    /// Correlation of consecutive arrivals.
    pub(crate) correlation: f64,
}

impl Noise {
    /// Noise of independent arrivals.
    pub(crate) fn white(sigma_um: f64) -> Self {
        Self {
            sigma_um,
            correlation: 0.0,
        }
    }
}

/// A series with correlated noise, if that explains it better than independent noise does.
pub(crate) fn alike_neighbours<'a>(
    found: &Series<'a>,
    with: impl Fn(Noise) -> Series<'a>,
) -> Option<Series<'a>> {
    let least = if found.is_clean() {
        SIGNIFICANT
    } else {
        POSSIBLE
    };
    let first = with(noise(found, least)?);
    // Beside the causes that are left.
    let last = with(noise(&first, least)?);
    // Twice the logarithm of the likelihood of the readings with a noise, up to what is the same for any noise.
    let (base, white) = (&found.plain.listed.base, &found.plain.whitening);
    let total = |series: &Series<'a>| {
        let base = Restricted::new(base, white, series.plain.whitening.correlation);
        two_ln_b(&series.plain, &series.model) - base.deviance
    };
    (total(&last) > total(found)).then_some(last)
}

/// The noise of a series beside its causes, if correlation of neighbours lowers the deviance by `least`.
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

/// A model of readings with correlated noise.
struct Restricted {
    /// `-2 ln L`, up to what is the same for every correlation.
    deviance: f64,
    /// Weighted squares of the residuals, `rᵀV⁻¹r`.
    squares: f64,
}

impl Restricted {
    /// `beside` is the model of independent readings, whitened accordingly.
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
