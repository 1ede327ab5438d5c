//! Whether causes describe the course that they name, where something wanders beside them.

use trueaxis_effects::Shape;
use trueaxis_leastsquares::dot;
use trueaxis_selection::combined;

use crate::engine::disturbance::With;
use crate::engine::linear::Among;
use crate::engine::{JudgedDisturbance, PART, without};
use crate::verification::model::{Model, only};
use crate::verification::problem::Problem;
use crate::verification::wanderer::is_course_of;
use crate::verification::wandering::wandering;

/// A wave along an axis whose curve wanders with position is a remainder of the curve if it explains less than this
/// share of it or is longer than this share of the correlation length: the curve may take this course by itself.
const REST: f64 = 0.25;
const OWN_COURSE: f64 = 0.75;

/// Squares of the effect of a cause of a model on the readings, in variances of the noise.
fn squares_of(plain: &Problem<'_>, model: &Model<'_>, k: usize) -> f64 {
    let listed = &model.problem.listed;
    let columns = listed.columns_of(&model.causes[k]);
    let sizes = listed.sizes(&model.causes);
    let effect = combined(plain.listed.base.rows(), &columns, &sizes[k].fit.estimates);
    let effect = plain.listed.base.left_of(&effect);
    dot(&effect, &effect)
}

/// The model without causes that do not describe the course that they name.
pub(crate) fn described<'a>(plain: &Problem<'a>, mut model: Model<'a>) -> Model<'a> {
    loop {
        let listed = &model.problem.listed;
        let wanders_on = |k: usize| {
            let hypothesis = listed.hypothesis(&model.causes[k]);
            let explained = || {
                let beside = listed.beside(&without(&model.causes, k));
                beside.score_of(&model.causes[k]).map_or(0.0, |score| {
                    let after = listed.with(&model.causes);
                    score.statistic * after.degrees_of_freedom / after.squares()
                })
            };
            let is_wave = hypothesis.effect.shape == Shape::Period;
            let of_curve = |own: &JudgedDisturbance| {
                let others = model.wandering.iter();
                let others = others.filter(|w| w.wanderer() != own.wanderer());
                let others: Vec<JudgedDisturbance> = others.cloned().collect();
                let without = plain.beside(&others).listed.with(&model.causes).squares();
                without - listed.with(&model.causes).squares()
            };
            let is_rest = |own: &JudgedDisturbance| {
                let [first, last] = plain.comparison.range;
                let is_long = plain.comparison.line().is_some()
                    && model.causes[k].shape
                        > OWN_COURSE * own.disturbance.form.length * (last - first);
                is_long || squares_of(plain, &model, k) < REST * of_curve(own)
            };
            model.wandering.iter().any(|own| match own.wanderer() {
                wanderer if is_wave && wanderer.with == With::Position => is_rest(own),
                wanderer if is_course_of(wanderer, hypothesis) => own.two_ln_b > PART * explained(),
                _ => false,
            })
        };
        let Some(undescribed) = (0..model.causes.len()).find(|&k| wanders_on(k)) else {
            return model;
        };
        let mut others = model.causes.clone();
        others.remove(undescribed);
        model = only(plain, wandering(plain, &others));
        let search = Among {
            further: plain.level,
            ..Among::by_name(&model.problem.listed, plain.level)
        };
        model.causes = search.revised(others);
    }
}
