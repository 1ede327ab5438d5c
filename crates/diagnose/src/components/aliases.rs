//! Aliases of waves in a thinned curve: at the kept positions, `H` apart, a wave of the frequency `f` looks like
//!
//! ```text
//! |m/H ± f|      m = 1, 2, …
//! ```
//!
//! up to the highest frequency that the measured positions show. All are fitted to the kept positions, where they
//! look alike; the distances of the others from straight lines between their kept neighbours decide.

use std::f64::consts::TAU;

use trueaxis_effects::Shape;
use trueaxis_selection::{DECISIVE, add};

use crate::Rival;
use crate::components::candidates::{Candidate, measured_most};
use crate::components::curve_set::{CurveSet, Thinned};
use crate::components::estimate::{Estimate, estimate};
use crate::components::search::SetSearch;
use crate::engine::without;

/// Tolerance for whole numbers of waves per turn.
const WHOLE: f64 = 1e-6;

impl SetSearch {
    /// Gives each wave the period that fits all positions best; those that fit nearly as well become its rivals.
    pub(crate) fn tell_aliases_apart(&mut self) {
        let Some(thinned) = self.set.thinned.clone() else {
            return;
        };
        let mut left = thinned.values.clone();
        for i in 0..self.found.len() {
            let (candidate, shape) = (&self.found[i].candidate, self.found[i].estimate.shape);
            let backgrounds = self.backgrounds(&without(&self.found, i));
            let own = |shape: f64| {
                let own = estimate(&self.set, &backgrounds, candidate, shape);
                let less = less(&self.set, &thinned, candidate, &own, &left);
                (squares_between(&self.set, &thinned, &less), own, less)
            };
            let mut all: Vec<(f64, Estimate, Vec<f64>)> = vec![own(shape)];
            all.extend(aliases(&self.set, candidate, shape).into_iter().map(own));
            all.sort_by(|a, b| a.0.total_cmp(&b.0));
            let between =
                (self.set.components.len() * (thinned.nodes.len() - self.set.nodes.len())) as f64;
            let least = all[0].0;
            let worse = |squares: f64| match squares > least {
                true => between * (squares / least).ln(),
                false => 0.0,
            };
            let bic = self.found[i].score.bic;
            let as_good = all[1..]
                .iter()
                .take_while(|other| worse(other.0) < DECISIVE);
            let rivals = as_good.map(|(squares, own, _)| Rival::Effect {
                effect: candidate
                    .hypothesis
                    .resolved(own.parameters.clone(), own.shape),
                delta_bic: bic + worse(*squares),
            });
            let rivals: Vec<Rival> = rivals.collect();
            let (_, best, less) = all.swap_remove(0);
            left = less;
            self.found[i].estimate = best;
            self.found[i].rivals.extend(rivals);
        }
    }
}

/// The shapes that look the same at the kept positions.
fn aliases(set: &CurveSet, candidate: &Candidate, shape: f64) -> Vec<f64> {
    let of_shape: fn(f64) -> f64 = match candidate.hypothesis.effect.shape {
        Shape::Period => f64::recip,
        Shape::Waves(_) => |waves| waves / TAU,
        _ => return Vec::new(),
    };
    let (frequency, sampling, most) = (of_shape(shape), set.step().recip(), measured_most(set));
    let multiples = std::iter::successors(Some(sampling), |m| Some(m + sampling));
    let multiples = multiples.take_while(|m| m - frequency <= most);
    let both = multiples.flat_map(|m| [m - frequency, m + frequency]);
    let told = both.filter(|f| *f <= most);
    match candidate.hypothesis.effect.shape {
        Shape::Period => told.map(f64::recip).collect(),
        _ => {
            let waves = told.map(|f| f * TAU);
            let whole = waves.filter(|waves| (waves - waves.round()).abs() < WHOLE * waves);
            whole.map(f64::round).collect()
        }
    }
}

/// Values at all positions less an effect with these parameters.
fn less(
    set: &CurveSet,
    thinned: &Thinned,
    candidate: &Candidate,
    own: &Estimate,
    values: &[f64],
) -> Vec<f64> {
    let mut left = values.to_vec();
    let columns = set.columns_at(&thinned.nodes, candidate, own.shape);
    for (column, value) in columns.iter().zip(&own.parameters) {
        add(&mut left, column, -value);
    }
    left
}

/// Squares of the distances from the straight lines between kept positions of a side, all curves together.
fn squares_between(set: &CurveSet, thinned: &Thinned, values: &[f64]) -> f64 {
    let nodes = &thinned.nodes;
    let mut squares = 0.0;
    for curve in values.chunks_exact(nodes.len()) {
        for side in [1.0, -1.0] {
            let of_side = |node: &(f64, f64)| node.1 * side > 0.0;
            let all = nodes.iter().zip(curve).filter(|(node, _)| of_side(node));
            let all: Vec<(f64, f64)> = all.map(|(node, value)| (node.0, *value)).collect();
            let kept = set.nodes.iter().filter(|node| of_side(node));
            let kept: Vec<f64> = kept.map(|node| node.0).collect();
            let is_kept = |at: f64| kept.binary_search_by(|own| own.total_cmp(&at)).is_ok();
            let kept: Vec<(f64, f64)> =
                all.iter().copied().filter(|(at, _)| is_kept(*at)).collect();
            for pair in kept.windows(2) {
                let [(from, a), (to, b)] = [pair[0], pair[1]];
                let between = all.iter().filter(|(at, _)| from < *at && *at < to);
                let off = between.map(|(at, y)| y - a - (b - a) * (at - from) / (to - from));
                squares += off.map(|off| off * off).sum::<f64>();
            }
        }
    }
    squares
}

#[cfg(test)]
mod tests {
    use nalgebra::{Point3, Vector3};
    use trueaxis_effects::{Subject, effect};
    use trueaxis_kinematics::{Axis, Component, Machine};

    use super::*;
    use crate::components::scene_of;

    /// Of 600 positions a turn 300 are kept: seven waves look like 293 and 307 there; 600 positions show only 293.
    #[test]
    fn waves_of_a_turn_have_whole_aliases() {
        let axis = Axis::rotary("C", Vector3::z(), [0.0, TAU], Point3::origin()).unwrap();
        let machine = Machine::new(vec![axis.clone()], vec![0], vec![]).unwrap();
        let scene = scene_of(&machine, vec![0]);
        let positions = (0..600).map(|k| f64::from(k) * TAU / 600.0).collect();
        let component = Component::ALL[5];
        let (values, variances) = (vec![0.0; 600], vec![1.0; 600]);
        let set = CurveSet::of_line(0, &axis, component, positions, values, variances);
        let worm = effect("worm_gear").unwrap();
        let candidate = Candidate::new(worm, Subject::axis(0), vec![7.0], &scene);
        assert_eq!(aliases(&set, &candidate, 7.0), [293.0]);
    }
}
