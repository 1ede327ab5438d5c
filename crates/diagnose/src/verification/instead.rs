//! What explains as much as a coupling: on a circle away from where the axes were parked it is nearly squareness and scale.

use trueaxis_selection::{DECISIVE, Score};

use crate::engine::linear::Chosen;
use crate::engine::without;
use crate::verification::model::{Model, has, is_coupling, is_left, of_causes, two_ln_b};
use crate::verification::problem::Problem;

/// Most effects that are tried, those with the largest 2 ln B.
const MOST: usize = 4;

/// Effects of one parameter, or pairs of them, that explain everything with nearly as large a 2 ln B in the place of a
/// coupling, significant or not; none that holds a smaller one. Without them squareness and scale that changed since the
/// calibration are now and then a clear coupling (`tests/diagnose/coupling.rs`).
pub(crate) fn simple_instead(plain: &Problem<'_>, best: &Model<'_>, most: f64) -> Vec<Vec<Chosen>> {
    let coupling = |cause: &Chosen| is_coupling(plain, cause.candidate);
    let Some(coupling) = best.causes.iter().position(coupling) else {
        return Vec::new();
    };
    let listed = &plain.listed;
    let others = without(&best.causes, coupling);
    let beside = listed.beside(&others);
    let is_simple = |score: &&Score| listed.candidate(&beside, score).is_simple();
    let simple = beside.scores.iter().filter(is_simple).take(MOST);
    let simple: Vec<Chosen> = simple.map(|score| listed.chosen(&beside, score)).collect();
    let ones = (0..simple.len()).map(|i| vec![simple[i]]);
    let pairs = (0..simple.len()).flat_map(|i| (0..i).map(move |j| [j, i]));
    let pairs = pairs.map(|pair| pair.map(|i| simple[i]).to_vec());
    let mut as_good: Vec<Vec<Chosen>> = Vec::new();
    for own in ones.chain(pairs) {
        let model = of_causes(plain, [&others[..], &own].concat());
        let has_more = as_good
            .iter()
            .any(|few| few.iter().all(|one| has(&model.causes, one)));
        if !has_more && most - two_ln_b(plain, &model) < DECISIVE && !is_left(&model) {
            as_good.push(model.causes);
        }
    }
    as_good
}
