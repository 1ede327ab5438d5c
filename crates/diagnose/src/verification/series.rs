//! One series of readings with its causes, and the disturbances beside them.

use trueaxis_effects::Level;
use trueaxis_selection::{Fit, Projection, Score, add};

use crate::engine::linear::{Beside, Chosen};
use crate::engine::{Coefficients, JudgedDisturbance, Omnibus, without};
use crate::said::Entry;
use crate::verification::another_curve::another_curve;
use crate::verification::competition::compete;
use crate::verification::doubted::doubted;
use crate::verification::held_out::{Predicted, gain, held_out};
use crate::verification::model::{Model, have_same, is_left, only};
use crate::verification::omnibus::{omnibus, repeats_with_cycle};
use crate::verification::problem::Problem;
use crate::verification::report;
use crate::verification::wandered::{coefficients, wandered};
use crate::verification::wandering::wandering;
use crate::{LevelReport, Misfit, Shares, Unexplained};

/// The readings of one verification: a line or the sweeps of a ball bar.
pub(crate) struct Series<'a> {
    /// The base model without causes and disturbances.
    pub(crate) plain: Problem<'a>,
    pub(crate) model: Model<'a>,
    /// Standard deviation of an arrival that is stated, µm.
    pub(crate) noise_floor_um: f64,
    /// Two levels between which readings jump that are otherwise clean.
    pub(crate) levels: Option<Unexplained>,
}

impl<'a> Series<'a> {
    /// Finds the causes of a verification, and disturbances beside them or instead of them.
    pub(crate) fn new(plain: Problem<'a>) -> Self {
        Self {
            noise_floor_um: plain.reading_um(),
            model: compete(&plain),
            levels: None,
            plain,
        }
    }

    /// Whether nothing is found or left.
    pub(crate) fn is_clean(&self) -> bool {
        let model = &self.model;
        model.causes.is_empty() && model.wandering.is_empty() && !is_left(model)
    }

    /// The model with its causes.
    pub(crate) fn after(&self) -> Projection {
        self.model.problem.listed.with(&self.model.causes)
    }

    /// Rms per degree of freedom of what its model leaves, µm.
    pub(crate) fn left_um(&self) -> f64 {
        self.plain.rms_um(&self.after())
    }

    /// Replaces the causes, with the disturbances beside them.
    pub(crate) fn set_causes(&mut self, causes: Vec<Chosen>) {
        if !have_same(&causes, &self.model.causes) {
            self.model = only(&self.plain, wandering(&self.plain, &causes));
        }
        self.model.causes = causes;
    }

    /// Its outcome; the `first` of its causes come first, then the one without which most is left.
    pub(crate) fn entry(&self, first: &[usize]) -> Entry {
        let plain = &self.plain;
        let (problem, wandering) = (&self.model.problem, &self.model.wandering);
        let chosen = &self.model.causes;
        let before = &plain.listed.base;
        let tests = omnibus(plain, before);
        let ranked = |k: usize| {
            let left = problem.listed.with(&without(chosen, k)).squares();
            let place = first.iter().position(|own| *own == chosen[k].candidate);
            (place.unwrap_or(first.len()), left, chosen[k])
        };
        let mut ranked: Vec<(usize, f64, Chosen)> = (0..chosen.len()).map(ranked).collect();
        ranked.sort_by(|a, b| a.0.cmp(&b.0).then(b.1.total_cmp(&a.1)));
        let chosen: Vec<Chosen> = ranked.into_iter().map(|(.., cause)| cause).collect();
        let after = problem.listed.with(&chosen);
        let tests_after = omnibus(problem, &after);
        let courses = wandering
            .iter()
            .map(|own| (own, coefficients(problem, own, &after)));
        let courses: Vec<(&JudgedDisturbance, Coefficients)> = courses.collect();
        let mut course = vec![0.0; before.rows()];
        for (_, own) in &courses {
            add(&mut course, &own.effect, 1.0);
        }
        let mut causes = report::causes(
            problem,
            &chosen,
            (&plain.as_predicted, &after),
            (wandering, &course),
        );
        for others in &self.model.as_good {
            report::add_rivals(&problem.listed, &chosen, others, &mut causes);
        }
        let is_plain = chosen.is_empty() && wandering.is_empty();
        let of_tests = || {
            let left = unexplained(problem, &after, &tests_after)?;
            Some(match is_plain {
                true => with_closest(problem, left),
                false => left,
            })
        };
        let unexplained = doubted(problem, &after)
            .or_else(|| another_curve(problem, &chosen, &after))
            .or_else(|| {
                is_plain
                    .then(|| impossible(problem, &tests_after))
                    .flatten()
            })
            .or_else(of_tests)
            .or_else(|| self.levels.clone().filter(|_| is_plain));
        let columns = chosen.iter().map(|cause| problem.listed.columns_of(cause));
        let smooth = wandering.iter().map(|w| w.columns(plain));
        let held_before = held_out(plain, &[]);
        let held_after = held_out(problem, &chosen);
        let gain = gain(problem, &held_before, &held_after);
        let is_single = chosen.len() + wandering.len() == 1;
        let gain = gain
            .map(|held| held.gain(held.squares))
            .filter(|_| !is_plain);
        let disturbances = wandered(
            problem,
            before,
            &courses,
            &after,
            gain.filter(|_| is_single),
        );
        let misfit = |problem: &Problem<'_>, causes: &[Chosen], held: &Predicted| Misfit {
            rms_um: problem.seen_rms_um(causes),
            heldout_rms_um: held.rms().map(|rms| rms * problem.whitening.sigma_um),
        };
        let given = unexplained.as_ref().map_or(0.0, |left| left.share);
        let shares = Shares::of_parts(before, columns, smooth, unexplained.is_some());
        let before = misfit(plain, &[], &held_before);
        // What repeats scatter by contains what has a share of its own.
        let noise_floor_um = match given > 0.0 {
            true => (before.rms_um * (1.0 - given).sqrt()).min(self.noise_floor_um),
            false => self.noise_floor_um,
        };
        Entry {
            report: LevelReport {
                level: Level::Verification,
                data: plain.comparison.name.to_owned(),
                noise_floor_um,
                prediction_u_um: plain.prediction_u_um,
                before,
                after: misfit(problem, &chosen, &held_after),
                gain,
                shares: shares.with_unexplained(given),
                unexplained,
                tests: Omnibus::tests(tests),
                tests_after: Omnibus::tests(tests_after),
                places: report::places(problem, &plain.as_predicted, &problem.part(&chosen)),
            },
            causes,
            disturbances,
        }
    }
}

/// What looks like a cause, but of a size that no machine has: few readings may leave no other test room. If a test
/// finds anything, that which explains most of it is told.
fn impossible(problem: &Problem<'_>, tests: &[Omnibus]) -> Option<Unexplained> {
    let beside = problem.listed.beside(&[]);
    let best = beside.impossible.first()?;
    let candidate = problem.listed.candidate(&beside, best);
    let own = &candidate.hypothesis;
    let varies_with = match own.effect {
        effect if effect.is_lost_motion() => vec!["direction"],
        effect if effect.grows_axis() => vec!["position", "time"],
        _ if own.is_of_time() => vec!["time"],
        _ => vec!["position"],
    };
    let possible = beside.scores.first();
    let is_best = possible.is_none_or(|possible| possible.two_ln_b < best.two_ln_b);
    let is_left = tests.iter().any(|t| t.test.p_value < problem.level);
    let share = share_of(&beside, best);
    let is_clear = match is_left {
        true => is_best && share > 0.5,
        false => beside.is_significant(best, problem.level),
    };
    is_clear.then(|| {
        let note = format!(
            "it varies with {} as {} does, but by more than on any machine",
            varies_with.join(" and "),
            own.effect.id.replace('_', " ")
        );
        let rms_um = problem.slow_rms_um(best.statistic);
        let left = Unexplained::new(Level::Verification, rms_um, varies_with, note);
        if !own.effect.grows_axis() {
            return left;
        }
        let fit = Fit::new(&beside.model, &candidate.columns(best.shape));
        let size = fit.estimates.first().map_or(0.0, |size| size.abs());
        Unexplained {
            note: format!("{}: by some {size:.0} ppm", left.note),
            share,
            action: Some(MOVES_APART),
            ..left
        }
    })
}

/// What changes a length by more than an axis grows.
const MOVES_APART: &str = "look for parts that move apart: a stop, clamp, coupling or scale that slips or works loose; and for the scale of the \
     instrument (wavelength, gain, another unit)";

/// Share of the misfit that a hypothesis explains, without that of noise.
fn share_of(beside: &Beside, score: &Score) -> f64 {
    let (squares, rank) = (beside.model.squares(), score.rank as f64);
    let free = (beside.model.degrees_of_freedom - rank).max(1.0);
    let noise = rank * (squares - score.statistic).max(0.0) / free;
    (score.statistic - noise).max(0.0) / squares
}

/// With the cause that explains most of it, where none is clear enough to name.
fn with_closest(problem: &Problem<'_>, left: Unexplained) -> Unexplained {
    let beside = problem.listed.beside(&[]);
    let Some(closest) = beside.scores.first() else {
        return left;
    };
    let effect = problem.listed.candidate(&beside, closest).hypothesis.effect;
    let note = format!(
        "{}; {} comes closest and explains {:.0} % of the misfit, which is not enough to name it",
        left.note,
        effect.id.replace('_', " "),
        100.0 * share_of(&beside, closest)
    );
    Unexplained { note, ..left }
}

/// Structure that the causes leave.
fn unexplained(
    problem: &Problem<'_>,
    after: &Projection,
    tests: &[Omnibus],
) -> Option<Unexplained> {
    let clear = || tests.iter().filter(|t| t.test.p_value < problem.level);
    // Squares beyond what noise leaves in the columns of the clearest test.
    let excess = clear().map(|t| {
        let columns = t.test.columns as f64;
        let rest = after.squares() - t.drop;
        t.drop - columns * rest / (after.degrees_of_freedom - columns).max(1.0)
    });
    let excess = excess.reduce(f64::max)?;
    let mut varies_with: Vec<&'static str> = Vec::new();
    // `direction in time` is both.
    for with in clear().flat_map(|t| t.test.varies_with.split(" in ")) {
        if !varies_with.contains(&with) {
            varies_with.push(with);
        }
    }
    let period = clear().find_map(|t| t.test.detail.as_deref());
    let note = match period {
        Some(period) if repeats_with_cycle(problem, after) => {
            // No air conditioning keeps step with the machine.
            varies_with.retain(|with| !["time", "position", "direction"].contains(with));
            varies_with.extend(["position", "direction"]);
            let others = match varies_with.contains(&"cycle") {
                true => "; it varies with cycle, too",
                false => "",
            };
            format!(
                "it repeats with the cycle (a period near {period}): a function of position and side of approach that the model does not \
                 follow{others}"
            )
        }
        Some(period) => {
            let with = varies_with.join(" and ");
            format!("it varies with {with}, with a period near {period}")
        }
        None => format!("it varies with {}", varies_with.join(" and ")),
    };
    let rms_um = problem.slow_rms_um(excess);
    Some(Unexplained {
        is_of_tests: true,
        ..Unexplained::new(Level::Verification, rms_um, varies_with, note)
    })
}
