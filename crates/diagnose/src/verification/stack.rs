//! All series of readings as one system, below each other.
//!
//! ```text
//! y = [ y_1/s_1 ]   M = block diagonal of the M_f   X = [ X_1/s_1 ]
//!     [   ...   ]                                       [   ...   ]
//! ```
//!
//! `M_f` is the projection that removes the base model of a series, its disturbances and what it alone shows; `s_f`
//! is the standard deviation of a reading beside all its causes. The prediction errors are those of one calibration:
//! they join the covariance of all series. A hypothesis has a column for each parameter over all.

use trueaxis_effects::Shape;
use trueaxis_leastsquares::dot;
use trueaxis_predict::CalibratedMachine;
use trueaxis_selection::{Fit, Hypothesis, Projection, ShapeColumns};

use crate::engine::linear::{Candidate, Chosen, Finer, Listed};
use crate::engine::without;
use crate::verification::hypotheses::is_continuous;
use crate::verification::prediction_error::prediction_directions;
use crate::verification::problem::Problem;
use crate::verification::series::Series;
use crate::verification::whitening::Whitening;

/// The system and what may be common to its series.
pub(crate) struct Stack<'s> {
    pub(crate) listed: Listed<'s>,
    /// For each hypothesis its number in each series that shows it.
    pub(crate) members: Vec<Vec<Option<usize>>>,
    /// `s_f`, µm.
    pub(crate) scales_um: Vec<f64>,
    pub(crate) all: &'s [Series<'s>],
}

/// Share of the mean of what a cause explains that a series must show of it.
const SHOWN: f64 = 0.1;

/// Whether an effect of a series is the same in another: it belongs to the machine or to the way in which it is read,
/// not to the time of one series or to the range of its positions.
pub(crate) fn is_of_all(series: &Series<'_>, candidate: &Candidate<'_>) -> bool {
    let effect = candidate.hypothesis.effect;
    // Without a clock lag is in units of the time between two readings of this series.
    let counts_readings = effect.is_delay() && !series.plain.comparison.timed;
    let is_of_its_clock =
        counts_readings || candidate.hypothesis.is_of_time() || effect.grows_axis();
    let has_shape_of_all = matches!(effect.shape, Shape::Fixed | Shape::Period | Shape::Waves(_));
    has_shape_of_all && !is_of_its_clock && !candidate.is_free
}

impl<'s> Stack<'s> {
    /// Of all series; the causes `own` of each are its own.
    pub(crate) fn new(
        all: &'s [Series<'s>],
        own: &[Vec<Chosen>],
        is_wanted: impl Fn(&Hypothesis) -> bool,
        calibration: Option<&CalibratedMachine>,
    ) -> Self {
        let left_um = |series: &Series<'_>| series.plain.noise_um(&series.after());
        let scales_um: Vec<f64> = all.iter().map(left_um).collect();
        let with_own = all.iter().zip(own);
        let parts = with_own.map(|(series, own)| series.model.problem.part(own));
        let parts: Vec<Projection> = parts.collect();
        let rows = all.iter().map(|series| series.plain.readings());
        let scales = all.iter().zip(&scales_um);
        let scales = scales.map(|(series, scale)| scale / series.plain.whitening.sigma_um);
        let numbered = parts.iter().zip(rows).zip(scales);
        let mut base = Projection::stacked(numbered.map(|((part, rows), s)| (part, rows, s)));
        if let Some(calibration) = calibration {
            let comparisons: Vec<_> = all.iter().map(|series| series.plain.comparison).collect();
            let finest_um = scales_um.iter().copied().fold(f64::INFINITY, f64::min);
            let directions = prediction_directions(&comparisons, calibration, finest_um);
            let whitened = directions.iter().map(|column| {
                let mut rest = column.as_slice();
                let parts = all.iter().zip(&scales_um).flat_map(|(series, &um)| {
                    let (own, others) = rest.split_at(series.plain.readings());
                    rest = others;
                    in_scale(&series.plain, own, um)
                });
                parts.collect()
            });
            let whitened: Vec<Vec<f64>> = whitened.collect();
            if !whitened.is_empty() {
                base = base.beside(&whitened).0;
            }
        }
        let mut stack = Self {
            listed: Listed::new(base, Vec::new().into()),
            members: Vec::new(),
            scales_um,
            all,
        };
        let mut candidates: Vec<Candidate<'s>> = Vec::new();
        for series in all {
            for candidate in series.plain.listed.candidates.iter() {
                let hypothesis = &candidate.hypothesis;
                let is_listed = |other: &Candidate<'_>| other.hypothesis.is(hypothesis);
                if is_of_all(series, candidate)
                    && is_wanted(hypothesis)
                    && !candidates.iter().any(is_listed)
                {
                    let (candidate, members) = stack.joined(hypothesis);
                    candidates.push(candidate);
                    stack.members.push(members);
                }
            }
        }
        stack.listed = Listed::new(stack.listed.base, candidates.into());
        stack
    }

    /// One hypothesis over all series, with the shapes of the series that tries most.
    fn joined(&self, hypothesis: &Hypothesis) -> (Candidate<'s>, Vec<Option<usize>>) {
        let members: Vec<Option<usize>> = self
            .all
            .iter()
            .map(|series| {
                let mut candidates = series.plain.listed.candidates.iter();
                candidates.position(|c| is_of_all(series, c) && c.hypothesis.is(hypothesis))
            })
            .collect();
        let own = members.iter().enumerate().filter_map(|(series, number)| {
            Some(&self.all[series].plain.listed.candidates[(*number)?])
        });
        let sizes = own.clone().flat_map(|candidate| candidate.sizes.clone());
        let sizes: Vec<Vec<f64>> = sizes.collect();
        let largest = own.max_by_key(|candidate| candidate.columns.shapes().len());
        let shortest = largest.and_then(|candidate| candidate.finer.as_ref());
        let shortest = shortest.map_or(f64::NEG_INFINITY, |finer| finer.shortest);
        let (shapes, plausible) = largest.map_or_else(Default::default, |candidate| {
            let shapes: Vec<f64> = candidate.columns.shapes().collect();
            (shapes, candidate.plausible.clone())
        });
        let (all, scales_um) = (self.all, self.scales_um.clone());
        let (hypothesis, of_each, count) = (*hypothesis, members.clone(), plausible.len());
        let columns = move |shape: f64| -> Vec<Vec<f64>> {
            let column = |k: usize| {
                let of_each = all.iter().zip(&of_each).zip(&scales_um);
                let columns = of_each.flat_map(|((series, member), &um)| {
                    let plain = &series.plain;
                    match member {
                        Some(_) => {
                            let column = plain.comparison.column(&hypothesis, k, shape);
                            in_scale(plain, &column, um)
                        }
                        None => vec![0.0; plain.readings()],
                    }
                });
                columns.collect()
            };
            (0..count).map(column).collect()
        };
        let candidate = Candidate {
            hypothesis,
            columns: ShapeColumns::of_each(&shapes, &columns).into(),
            plausible,
            is_free: false,
            sizes,
            finer: is_continuous(hypothesis.effect.shape).then(|| Finer {
                columns: Box::new(columns),
                gaps_s: None,
                nearby: 0,
                shortest,
            }),
        };
        (candidate, members)
    }

    /// The rows of a series.
    pub(crate) fn rows(&self, number: usize) -> std::ops::Range<usize> {
        let count = |series: &Series<'_>| series.plain.readings();
        let first = self.all[..number].iter().map(count).sum();
        first..first + count(&self.all[number])
    }

    /// Every cause of the machine that a series named, once.
    pub(crate) fn named(&self) -> Vec<Chosen> {
        let named = (0..self.members.len()).filter_map(|candidate| {
            let mut shapes = (0..self.all.len()).filter_map(|k| self.own_shape(candidate, k));
            Some(Chosen {
                candidate,
                shape: shapes.next()?,
                u_shape: 0.0,
            })
        });
        named.collect()
    }

    /// The shape at which a series named a hypothesis.
    fn own_shape(&self, candidate: usize, series: usize) -> Option<f64> {
        let member = self.members[candidate][series]?;
        let mut causes = self.all[series].model.causes.iter();
        causes.find(|c| c.candidate == member).map(|c| c.shape)
    }

    /// A column over the rows of one series, zero for the others.
    fn of_series(&self, number: usize, column: &[f64]) -> Vec<f64> {
        let mut own = vec![0.0; column.len()];
        let rows = self.rows(number);
        own[rows.clone()].copy_from_slice(&column[rows]);
        own
    }

    /// Number of shapes beyond one of a cause if each series has the shape at which it was named.
    pub(crate) fn more_shapes(&self, cause: &Chosen) -> usize {
        let shape = |k| self.own_shape(cause.candidate, k).unwrap_or(cause.shape);
        let mut shapes: Vec<f64> = (0..self.all.len()).map(shape).collect();
        shapes.sort_by(f64::total_cmp);
        shapes.dedup();
        shapes.len() - 1
    }

    /// The columns of a cause with its own size, and where it was named its own shape, in each series.
    pub(crate) fn apart(&self, cause: &Chosen) -> Vec<Vec<f64>> {
        let candidate = &self.listed.candidates[cause.candidate];
        let of_series = |number: usize| {
            let shape = self.own_shape(cause.candidate, number);
            let columns = candidate.columns(shape.unwrap_or(cause.shape));
            let columns = columns.iter().map(|column| self.of_series(number, column));
            columns.collect::<Vec<_>>()
        };
        (0..self.all.len()).flat_map(of_series).collect()
    }

    /// The causes of each series: its own and those common ones that it shows.
    pub(crate) fn of_each(&self, own: &[Vec<Chosen>], causes: &[Chosen]) -> Vec<Vec<Chosen>> {
        let mut all = own.to_vec();
        for (k, cause) in causes.iter().enumerate() {
            let members = &self.members[cause.candidate];
            for (number, is_shown) in self.shows(causes, k).into_iter().enumerate() {
                if let (Some(candidate), true) = (members[number], is_shown) {
                    all[number].push(Chosen {
                        candidate,
                        ..*cause
                    });
                }
            }
        }
        all
    }

    /// What a cause with the common size explains in each series, squares.
    pub(crate) fn explained(&self, causes: &[Chosen], k: usize) -> Vec<f64> {
        let model = self.listed.with(&without(causes, k));
        let of_all = Fit::new(&model, &self.listed.columns_of(&causes[k])).effect;
        let explained = (0..self.all.len()).map(|number| {
            let made = self.of_series(number, &of_all);
            dot(&made, &model.left_of(&made))
        });
        explained.collect()
    }

    /// Whether each series shows a cause: more than its columns explain of noise, or where it is weak in all of them,
    /// a share of what it explains in the mean.
    fn shows(&self, causes: &[Chosen], k: usize) -> Vec<bool> {
        let explained = self.explained(causes, k);
        let of_members = explained.iter().zip(&self.members[causes[k].candidate]);
        let of_members = of_members.filter_map(|(x, member)| member.map(|_| *x));
        let of_members: Vec<f64> = of_members.collect();
        let mean = of_members.iter().sum::<f64>() / of_members.len().max(1) as f64;
        let least = (SHOWN * mean).min(self.of_noise(&causes[k]));
        let shows = explained.into_iter().map(|explained| explained > least);
        shows.collect()
    }

    /// What the columns of a cause explain of noise, squares.
    pub(crate) fn of_noise(&self, cause: &Chosen) -> f64 {
        self.listed.columns_of(cause).len() as f64
    }
}

/// A column over the readings of a series, in µm, as one of all series, in units of this standard deviation.
fn in_scale(plain: &Problem<'_>, column: &[f64], scale_um: f64) -> Vec<f64> {
    let whitening = Whitening {
        sigma_um: scale_um,
        pseudo: 0,
        ..plain.whitening
    };
    whitening.whiten(column)
}
