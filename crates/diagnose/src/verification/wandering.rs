//! Disturbances beside causes, in readings.

use trueaxis_effects::{CROSS_COUPLING, Layer, Level, POSITION_DEPENDENT_BACKLASH, Shape};
use trueaxis_selection::{ALIKE, Fit, Hypothesis, Projection};

use crate::engine::disturbance::{Disturbance, Wanderer, Who, With};
use crate::engine::form::Form;
use crate::engine::linear::{Candidate, Chosen};
use crate::engine::{
    JudgedDisturbance, SMOOTH_LEVEL, Smooth, Wandering, instead_of_cause, sought, without,
};
use crate::numbers::extremes;
use crate::verification::base::{count, places};
use crate::verification::lost_motion::beyond_drives;
use crate::verification::problem::Problem;
use crate::verification::wandered::{coefficients, curve};
use crate::verification::wanderer::{
    Course, INSTRUMENT, MACHINE, confounded, is_course_of, wanderers,
};
use crate::{Error, Rival};

/// Readings with causes, in which disturbances are sought.
struct Beside<'p, 'a> {
    plain: &'p Problem<'a>,
    causes: &'p [Chosen],
    all: Vec<Wanderer>,
}

/// The disturbances beside causes.
pub(crate) fn wandering(plain: &Problem<'_>, causes: &[Chosen]) -> Vec<JudgedDisturbance> {
    let mut all = wanderers(plain.comparison, plain.calibrated);
    if beyond_drives(plain, causes).is_some() {
        all.retain(|wanderer| wanderer.with != With::Campaign);
    }
    // Position after position, lost motion along the axis and in time are one, whatever their size and slope.
    let effect = |cause: &Chosen| plain.listed.hypothesis(cause).effect;
    let changes = |cause: &Chosen| effect(cause) == POSITION_DEPENDENT_BACKLASH;
    if plain.comparison.is_position_after_position() && causes.iter().any(changes) {
        all.retain(|wanderer| wanderer.with != With::SidesInTime);
    }
    let beside = Beside { plain, causes, all };
    // Nothing is adjusted, so nothing fails.
    sought(&beside).unwrap_or_default()
}

impl<'a> Wandering for Beside<'_, 'a> {
    type Model = Problem<'a>;

    const MOST: usize = 2;

    fn wanderers(&self) -> &[Wanderer] {
        &self.all
    }

    fn fit(
        &self,
        own: &[JudgedDisturbance],
        _: Option<&Problem<'a>>,
    ) -> Result<Problem<'a>, Error> {
        Ok(self.plain.beside(own))
    }

    /// Smooth courses and swings are equally likely a priori, and so is each correlation length and each period.
    fn judge(&self, problem: &Problem<'a>, wanderer: Wanderer) -> Option<JudgedDisturbance> {
        let course = Course {
            comparison: problem.comparison,
            wanderer,
        };
        let model = problem.listed.with(self.causes);
        let smooth = course.smooth();
        let periods = course.periods();
        // What repeats with the cycle is a function of position and side of approach, of whatever form. It may be simpler
        // than a cause of such a form, but beside one it would take a part of it.
        let is_of_position = |cause: &Chosen| !problem.listed.hypothesis(cause).is_of_time();
        let takes_its_part = self.causes.iter().any(is_of_position);
        let is_its_own = |period: &&f64| !takes_its_part || !course.is_of_cycle(**period);
        let swings = periods.iter().filter(is_its_own).filter_map(|&period| {
            let form = [Form::swing(period)];
            Tried::new(problem, &model, course, &form, periods.len())
        });
        let smooth = Tried::new(problem, &model, course, &smooth, 1);
        let all: Vec<Tried> = smooth.into_iter().chain(swings).collect();
        let best = all.iter().max_by(|a, b| {
            (a.smooth.two_ln_b - a.price).total_cmp(&(b.smooth.two_ln_b - b.price))
        })?;
        // What the data do not show is as likely with it as without.
        let most = best.smooth.two_ln_b.max(0.0);
        let unseen = 1.0 - all.iter().map(Tried::weight).sum::<f64>();
        let seen = all
            .iter()
            .map(|own| own.weight() * (0.5 * (own.smooth.two_ln_b - most)).exp());
        let marginal = seen.sum::<f64>() + unseen.max(0.0) * (-0.5 * most).exp();
        let own = JudgedDisturbance {
            disturbance: Disturbance {
                wanderer,
                form: best.form,
                width: best.smooth.width,
            },
            two_ln_b: most + 2.0 * marginal.ln(),
            // Of all that are tried.
            p_value: (self.all.len() as f64 * best.smooth.p_value * best.tried as f64).min(1.0),
            rivals: Vec::new(),
        };
        is_plausible(problem, &model, &own).then_some(own)
    }

    fn confounded(&self, wanderer: Wanderer) -> Option<Wanderer> {
        confounded(self.plain.comparison, wanderer)
    }

    fn hidden(&self, problem: &Problem<'a>, own: &JudgedDisturbance) -> Option<Wanderer> {
        let lost_motion = Wanderer::new(Who::Axis(problem.comparison.axis()), With::Sides);
        hides_lost_motion(problem, self.causes, own).then_some(lost_motion)
    }
}

/// Whether lost motion of a line explains something that a disturbance in time explains as well, as where one side
/// was read before the other, or where the zero swings once in each cycle, as lost motion with a bow does: then the
/// disturbance takes what the readings show of it, and would have its name alone (`tests/diagnose/orders.rs`).
fn hides_lost_motion(problem: &Problem<'_>, causes: &[Chosen], own: &JudgedDisturbance) -> bool {
    let comparison = problem.comparison;
    if comparison.line().is_none() || own.wanderer().with != With::Campaign {
        return false;
    }
    let sides: Vec<f64> = comparison.arrivals.iter().map(|a| a.direction).collect();
    let lost_motion = [problem.whiten(&sides)];
    let model = problem.listed.with(causes);
    let alone = Fit::new(&model, &lost_motion);
    let beside = Fit::new(&model.beside(&own.columns(problem)).0, &lost_motion);
    let period = own.disturbance.form.period;
    let is_of_cycle = period.is_some_and(|period| problem.course(own).is_of_cycle(period));
    alone.ln_p(&model, 1) < SMOOTH_LEVEL.ln()
        && alone.seen[0]
        && (is_of_cycle
            || !beside.seen[0]
            || alone.covariance[0] < (1.0 - ALIKE * ALIKE) * beside.covariance[0])
}

/// Disturbances that may replace cause `k` of several: those with a larger 2 ln B, as with lengths.
pub(crate) fn rival_disturbances(
    problem: &Problem<'_>,
    known: &[JudgedDisturbance],
    causes: &[Chosen],
    k: usize,
    two_ln_b: f64,
) -> Vec<Rival> {
    let hypothesis = problem.listed.hypothesis(&causes[k]);
    let beside = Beside {
        plain: problem,
        causes: &without(causes, k),
        all: wanderers(problem.comparison, problem.calibrated),
    };
    let is_new = |w: &&Wanderer| known.iter().all(|own| own.wanderer() != **w);
    let of_same = beside.all.iter().filter(|w| is_course_of(**w, hypothesis));
    let of_same: Vec<Wanderer> = of_same.filter(is_new).copied().collect();
    let mut all = instead_of_cause(&beside, problem, &of_same, two_ln_b);
    let is_new = |other: &Wanderer| all.iter().all(|(name, _)| name != other);
    let other = inseparable(problem, hypothesis).filter(is_new);
    all.extend(other.map(|other| (other, two_ln_b)));
    let rival = |(name, two_ln_b)| Rival::of(Level::Verification, name, two_ln_b);
    all.into_iter().map(rival).collect()
}

/// What one file cannot separate from a cause, without a name in the catalogue: without it a warm-up that a line shows
/// would be that of the machine alone. A curve that changed since its calibration may do so at each of a few positions. No shift or drift of the machine
/// turns a rotary axis: a slipping encoder, clamp or belt is the machine with time; an instrument warms up, too. On a
/// circle a coupling `c x y` of X is a bow `c x²` of X to Y (both `c r² cos²φ sin φ`); only a calibration knows bows.
fn inseparable(problem: &Problem<'_>, hypothesis: &Hypothesis) -> Option<Wanderer> {
    let comparison = problem.comparison;
    let is_bow = hypothesis.effect == CROSS_COUPLING && !problem.calibrated;
    if is_bow && comparison.line().is_none() {
        return Some(Wanderer::new(Who::Machine, With::Position));
    }
    let is_wave = matches!(hypothesis.effect.shape, Shape::Period | Shape::Waves(_));
    let few = count(&places(comparison)) < FEW_POSITIONS;
    if let Some(axis) = comparison
        .line()
        .filter(|_| is_wave && few && problem.calibrated)
    {
        return Some(Wanderer::new(Who::Axis(axis), With::Position));
    }
    let of_instrument = hypothesis.is_of_time() && hypothesis.effect.layer == Layer::Instrument;
    if of_instrument && comparison.is_of_rotary_axis() {
        return Some(MACHINE);
    }
    let warms_up = hypothesis.effect.shape == Shape::TimeConstant && comparison.line().is_some();
    warms_up.then_some(INSTRUMENT)
}

/// Positions below which the best of all periods, with amplitude and phase, follows most of any values at them.
const FEW_POSITIONS: usize = 12;

/// Whether an axis grows and shrinks by no more than an axis can, allowing for three standard uncertainties.
fn is_plausible(problem: &Problem<'_>, model: &Projection, own: &JudgedDisturbance) -> bool {
    let comparison = problem.comparison;
    let is_growth = |candidate: &&Candidate| {
        candidate.hypothesis.effect.grows_axis()
            && candidate.hypothesis.subject.axis == Some(comparison.axis())
    };
    let growth = problem.listed.candidates.iter().find(is_growth);
    let range = growth.and_then(|candidate| candidate.plausible[0]);
    let Wanderer { who, with } = own.wanderer();
    let (Who::Axis(_), With::Campaign, Some([_, most_ppm])) = (who, with, range) else {
        return true;
    };
    let [low, high] = comparison.range;
    let most_um = most_ppm * (high - low) / MM_PER_UM_PPM;
    // On a line so short that no growth shows, what would wander is the zero alone, by any amount.
    if most_um < problem.whitening.sigma_um {
        return false;
    }
    let with = model.beside(&own.columns(problem)).0;
    let coefficients = coefficients(problem, own, &with);
    let curve = curve(problem, own, &coefficients, problem.rms_um(&with));
    // The second coordinate is one end against the other.
    let [least, most] = extremes(curve.iter().map(|point| point.value_um[1]));
    let u = curve.iter().map(|point| point.u_um[1]).fold(0.0, f64::max);
    most - least < most_um + 3.0 * u
}

/// Millimetres of which a part in a million is a micrometre.
const MM_PER_UM_PPM: f64 = 1e3;

/// Forms with common columns, judged.
struct Tried {
    form: Form,
    smooth: Smooth,
    /// Number of forms of its kind.
    tried: usize,
    /// `-2 ln` of their prior probability.
    price: f64,
}

impl Tried {
    fn new(
        problem: &Problem<'_>,
        model: &Projection,
        course: Course<'_, '_>,
        forms: &[Form],
        tried: usize,
    ) -> Option<Self> {
        let columns = course.columns(*forms.first()?).into_iter();
        let columns: Vec<Vec<f64>> = columns.map(|c| problem.whiten(&c)).collect();
        let roots = forms.iter().map(|&form| course.roots(form));
        let roots: Vec<Vec<f64>> = roots.collect();
        let smooth = Smooth::new(model, &columns, &roots)?;
        Some(Self {
            form: forms[smooth.spectrum],
            smooth,
            tried,
            price: 2.0 * ((KINDS * tried) as f64).ln(),
        })
    }

    /// Prior probability.
    fn weight(&self) -> f64 {
        (-0.5 * self.price).exp()
    }
}

/// Smooth courses and swings.
const KINDS: usize = 2;

impl JudgedDisturbance {
    /// Effect of an a priori standard deviation of each coefficient on the whitened readings.
    pub(crate) fn columns(&self, problem: &Problem<'_>) -> Vec<Vec<f64>> {
        let Disturbance { form, width, .. } = self.disturbance;
        let course = problem.course(self);
        let scaled = course.columns(form).into_iter().zip(course.roots(form));
        let scaled = scaled.map(|(column, root)| {
            let column = column.iter().map(|x| x * width * root);
            problem.whiten(&column.collect::<Vec<f64>>())
        });
        scaled.collect()
    }

    /// Prior standard deviations of the coefficients.
    pub(crate) fn roots(&self, problem: &Problem<'_>) -> Vec<f64> {
        let roots = problem.course(self).roots(self.disturbance.form);
        let scaled = roots.iter().map(|root| root * self.disturbance.width);
        scaled.collect()
    }

    /// Number of forms tried that are equally likely a priori.
    pub(crate) fn tried(&self, problem: &Problem<'_>) -> usize {
        let course = problem.course(self);
        let of_kind = match self.disturbance.form.period {
            None => course.smooth().len(),
            Some(_) => course.periods().len(),
        };
        of_kind * KINDS
    }
}
