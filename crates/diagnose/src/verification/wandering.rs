//! Disturbances beside causes: judged as with lengths, by their evidence ([`Smooth`]) and a p-value of all together.

use trueaxis_effects::{CROSS_COUPLING, Layer, POSITION_DEPENDENT_BACKLASH, Shape};
use trueaxis_selection::{ALIKE, DECISIVE, Fit, Hypothesis, Projection, by_evidence, ln_f_test};

use crate::Rival;
use crate::engine::linear::{Candidate, Chosen, without};
use crate::engine::{Posterior, SMOOTH_LEVEL, Smooth};
use crate::extremes::extremes;
use crate::verification::form::Form;
use crate::verification::lost_motion::beyond_drives;
use crate::verification::problem::Problem;
use crate::verification::wandered::curve;
use crate::verification::wanderer::{Wanderer, wanderers};

/// Most disturbances: more at once cannot be separated.
const MOST: usize = 2;

/// A disturbance, with its judgement beside the others.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct FittedProcess {
    pub(crate) wanderer: Wanderer,
    pub(crate) form: Form,
    /// w, in standard deviations of an arrival.
    pub(crate) width: f64,
    pub(crate) evidence: f64,
    pub(crate) p_value: f64,
    /// What explains as much.
    pub(crate) rivals: Vec<Wanderer>,
}

/// The disturbances beside causes, one after the other.
pub(crate) fn wandering(plain: &Problem<'_>, causes: &[Chosen]) -> Vec<FittedProcess> {
    let mut all = wanderers(plain.comparison, plain.calibrated);
    if beyond_drives(plain, causes).is_some() {
        all.retain(|wanderer| !wanderer.is_of_time());
    }
    // Position after position, lost motion along the axis and in time are one, whatever their size and slope.
    let effect = |cause: &Chosen| plain.listed.hypothesis(cause).effect;
    let changes = |cause: &Chosen| effect(cause) == POSITION_DEPENDENT_BACKLASH;
    if plain.comparison.is_position_after_position() && causes.iter().any(changes) {
        all.retain(|wanderer| *wanderer != Wanderer::SidesInTime);
    }
    let mut own: Vec<FittedProcess> = Vec::new();
    // Each round adds one, and one that another makes superfluous leaves at most once.
    for _ in 0..2 * MOST {
        if own.len() == MOST {
            break;
        }
        let here = plain.beside(&own);
        let is_other = |w: &&Wanderer| own.iter().all(|o| o.wanderer != **w);
        let others = all.iter().filter(is_other);
        let judged = others.filter_map(|&wanderer| judge(&here, causes, wanderer, all.len()));
        let judged = by_evidence(judged.collect(), |one: &FittedProcess| one.evidence);
        let Some((next, others)) = judged.split_first() else {
            break;
        };
        if next.p_value >= SMOOTH_LEVEL {
            break;
        }
        let is_rival = |other: &&FittedProcess| next.evidence - other.evidence < DECISIVE;
        let rivals = others.iter().filter(is_rival).map(|other| other.wanderer);
        let rivals = rivals.flat_map(|w| w.names(plain.comparison));
        let twin = next.wanderer.names(plain.comparison).skip(1);
        let lost_motion = hides_lost_motion(&here, causes, next).then_some(Wanderer::Sides);
        let rivals = twin.chain(rivals).chain(lost_motion);
        let rivals: Vec<Wanderer> = rivals.collect();
        own.push(FittedProcess {
            rivals,
            ..next.clone()
        });
        own = again(plain, causes, own, all.len());
    }
    own
}

/// Each with its size beside the others; without those that are not significant there.
fn again(
    plain: &Problem<'_>,
    causes: &[Chosen],
    mut own: Vec<FittedProcess>,
    family: usize,
) -> Vec<FittedProcess> {
    for k in 0..own.len() {
        let mut others = own.clone();
        let FittedProcess {
            wanderer, rivals, ..
        } = others.remove(k);
        match judge(&plain.beside(&others), causes, wanderer, family) {
            Some(judged) => own[k] = FittedProcess { rivals, ..judged },
            None => own[k].p_value = 1.0,
        }
    }
    own.retain(|judged| judged.p_value < SMOOTH_LEVEL);
    own
}

/// Whether lost motion of a line explains something that a disturbance in time explains as well, as where one side
/// was read before the other: then the disturbance takes what the readings show of it.
fn hides_lost_motion(problem: &Problem<'_>, causes: &[Chosen], own: &FittedProcess) -> bool {
    let comparison = problem.comparison;
    if comparison.line().is_none() || !own.wanderer.is_of_time() {
        return false;
    }
    let sides: Vec<f64> = comparison.arrivals.iter().map(|a| a.direction).collect();
    let lost_motion = [problem.whiten(&sides)];
    let model = problem.listed.with(causes);
    let alone = Fit::new(&model, &lost_motion);
    let beside = Fit::new(&model.beside(&own.columns(problem)).0, &lost_motion);
    let ln_p = ln_f_test(alone.gained(), model.squares(), 1, model.degrees_of_freedom);
    ln_p < SMOOTH_LEVEL.ln()
        && alone.seen[0]
        && (!beside.seen[0] || alone.covariance[0] < (1.0 - ALIKE * ALIKE) * beside.covariance[0])
}

/// Disturbances that may replace cause `k` of several: those with more evidence, as with lengths.
pub(crate) fn rival_disturbances(
    problem: &Problem<'_>,
    known: &[FittedProcess],
    causes: &[Chosen],
    k: usize,
    evidence: f64,
) -> Vec<Rival> {
    let comparison = problem.comparison;
    let all = wanderers(comparison, problem.calibrated);
    let hypothesis = problem.listed.hypothesis(&causes[k]);
    let others = without(causes, k);
    let is_known = |w: Wanderer| known.iter().any(|own| own.wanderer == w);
    let of_same = all.iter().copied();
    let of_same = of_same.filter(|w| w.is_course_of(hypothesis) && !is_known(*w));
    let judged = of_same.filter_map(|wanderer| judge(problem, &others, wanderer, all.len()));
    let as_good = judged.filter(|own| own.evidence > evidence);
    let names = as_good.flat_map(|own| {
        let names = own.wanderer.names(comparison);
        names.map(move |name| (name, own.evidence))
    });
    let mut names: Vec<(Wanderer, f64)> = names.collect();
    let is_new = |twin: &Wanderer| names.iter().all(|(name, _)| name != twin);
    let twin = twin(problem, hypothesis).filter(is_new);
    names.extend(twin.map(|twin| (twin, evidence)));
    let rivals = names.into_iter();
    rivals
        .map(|(name, evidence)| name.rival(comparison, evidence))
        .collect()
}

/// What one file cannot separate from a cause, without a name in the catalogue. No shift or drift of the machine
/// turns a rotary axis: a slipping encoder, clamp or belt is the machine with time; an instrument warms up, too. On a
/// circle a coupling `c x y` of X is a bow `c x²` of X to Y (both `c r² cos²φ sin φ`); only a calibration knows bows.
fn twin(problem: &Problem<'_>, hypothesis: &Hypothesis) -> Option<Wanderer> {
    let comparison = problem.comparison;
    let is_bow = hypothesis.effect == CROSS_COUPLING && !problem.calibrated;
    if is_bow && comparison.line().is_none() {
        return Some(Wanderer::Position);
    }
    let of_instrument = hypothesis.is_of_time() && hypothesis.effect.layer == Layer::Instrument;
    if of_instrument && comparison.is_of_rotary_axis() {
        return Some(Wanderer::Machine);
    }
    let warms_up = hypothesis.effect.shape == Shape::TimeConstant && comparison.line().is_some();
    warms_up.then_some(Wanderer::Instrument)
}

/// What one explains of what a model with causes leaves. Smooth courses and swings are equally likely a priori, and
/// so is each correlation length and each period.
fn judge(
    problem: &Problem<'_>,
    causes: &[Chosen],
    wanderer: Wanderer,
    family: usize,
) -> Option<FittedProcess> {
    let comparison = problem.comparison;
    let model = problem.listed.with(causes);
    let smooth = wanderer.smooth(comparison);
    let periods = wanderer.periods(comparison);
    // What repeats with the cycle is a function of position and side of approach, of whatever form. It may be simpler
    // than a cause of such a form, but beside one it would take a part of it.
    let is_of_position = |cause: &Chosen| !problem.listed.hypothesis(cause).is_of_time();
    let takes_its_part = causes.iter().any(is_of_position);
    let is_its_own =
        |period: &&f64| !takes_its_part || !Wanderer::is_of_cycle(comparison, **period);
    let swings = periods.iter().filter(is_its_own).filter_map(|&period| {
        let form = [Form::Swing(period)];
        Judged::new(problem, &model, wanderer, &form, periods.len())
    });
    let smooth = Judged::new(problem, &model, wanderer, &smooth, 1);
    let all: Vec<Judged> = smooth.into_iter().chain(swings).collect();
    let best = all
        .iter()
        .max_by(|a, b| (a.smooth.evidence - a.price).total_cmp(&(b.smooth.evidence - b.price)))?;
    // What the data do not show is as likely with it as without.
    let most = best.smooth.evidence.max(0.0);
    let unseen = 1.0 - all.iter().map(Judged::weight).sum::<f64>();
    let seen = all
        .iter()
        .map(|own| own.weight() * (0.5 * (own.smooth.evidence - most)).exp());
    let marginal = seen.sum::<f64>() + unseen.max(0.0) * (-0.5 * most).exp();
    let own = FittedProcess {
        wanderer,
        form: best.form,
        width: best.smooth.width,
        evidence: most + 2.0 * marginal.ln(),
        // Of all that are tried.
        p_value: (family as f64 * best.smooth.p_value * best.tried as f64).min(1.0),
        rivals: Vec::new(),
    };
    is_plausible(problem, &model, &own).then_some(own)
}

/// Whether an axis grows and shrinks by no more than an axis can, allowing for three standard uncertainties.
fn is_plausible(problem: &Problem<'_>, model: &Projection, own: &FittedProcess) -> bool {
    let comparison = problem.comparison;
    let is_growth = |candidate: &&Candidate| {
        candidate.hypothesis.effect.grows_axis()
            && candidate.hypothesis.subject.axis == Some(comparison.axis())
    };
    let growth = problem.listed.candidates.iter().find(is_growth);
    let range = growth.and_then(|candidate| candidate.plausible[0]);
    let (Wanderer::Scale, Some([_, most_ppm])) = (own.wanderer, range) else {
        return true;
    };
    let columns = own.columns(problem);
    let with = model.beside(&columns).0;
    let posterior = Posterior::new(&with, &columns);
    let curve = curve(problem, own, &posterior, problem.rms_um(&with));
    // The second coordinate is one end against the other.
    let [least, most] = extremes(curve.iter().map(|point| point.value_um[1]));
    let u = curve.iter().map(|point| point.u_um[1]).fold(0.0, f64::max);
    let [low, high] = comparison.range;
    most - least < most_ppm * (high - low) / MM_PER_UM_PPM + 3.0 * u
}

/// Millimetres of which a part in a million is a micrometre.
const MM_PER_UM_PPM: f64 = 1e3;

/// Forms with common columns, judged.
struct Judged {
    form: Form,
    smooth: Smooth,
    /// Number of forms of its kind.
    tried: usize,
    /// `-2 ln` of their prior probability.
    price: f64,
}

impl Judged {
    fn new(
        problem: &Problem<'_>,
        model: &Projection,
        wanderer: Wanderer,
        forms: &[Form],
        tried: usize,
    ) -> Option<Self> {
        let comparison = problem.comparison;
        let columns = wanderer.columns(comparison, *forms.first()?).into_iter();
        let columns: Vec<Vec<f64>> = columns.map(|c| problem.whiten(&c)).collect();
        let roots = forms.iter().map(|&form| wanderer.roots(comparison, form));
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

impl FittedProcess {
    /// Effect of an a priori standard deviation of each coefficient on the whitened readings.
    pub(crate) fn columns(&self, problem: &Problem<'_>) -> Vec<Vec<f64>> {
        let columns = self.wanderer.columns(problem.comparison, self.form);
        let roots = self.wanderer.roots(problem.comparison, self.form);
        let scaled = columns.into_iter().zip(roots).map(|(column, root)| {
            let column = column.iter().map(|x| x * self.width * root);
            problem.whiten(&column.collect::<Vec<f64>>())
        });
        scaled.collect()
    }

    /// Number of forms tried that are equally likely a priori.
    pub(crate) fn tried(&self, problem: &Problem<'_>) -> usize {
        let comparison = problem.comparison;
        let of_kind = match self.form {
            Form::Smooth { .. } => self.wanderer.smooth(comparison).len(),
            Form::Swing(_) => self.wanderer.periods(comparison).len(),
        };
        of_kind * KINDS
    }
}
