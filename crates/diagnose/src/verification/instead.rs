//! What explains as much in another form: on a circle away from where the axes were parked a coupling is nearly
//! squareness and scale, and changing lost motion with one cause in time is nearly constant with another.

use trueaxis_effects::{BACKLASH, POSITION_DEPENDENT_BACKLASH};
use trueaxis_selection::{DECISIVE, Score};

use crate::engine::linear::{Candidate, Chosen, without};
use crate::verification::model::{Model, evidence, has, is_coupling, is_left, of_causes};
use crate::verification::problem::Problem;

/// Most effects that are tried, those with the most evidence.
const MOST: usize = 4;

/// Effects of one parameter, or pairs of them, that explain as much as a coupling in its place, significant or not.
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
    as_good(plain, &others, ones.chain(pairs), most)
}

/// Constant lost motion in place of lost motion that changes along the axis, each beside something in time.
pub(crate) fn constant_instead(
    plain: &Problem<'_>,
    best: &Model<'_>,
    most: f64,
) -> Vec<Vec<Chosen>> {
    let listed = &plain.listed;
    let of = |cause: &Chosen| listed.hypothesis(cause);
    let goes_with_time = |cause: &&Chosen| of(cause).is_of_time();
    let changes = |cause: &&Chosen| of(cause).effect == POSITION_DEPENDENT_BACKLASH;
    let (Some(_), Some(lost)) = (
        best.causes.iter().find(goes_with_time),
        best.causes.iter().find(changes),
    ) else {
        return Vec::new();
    };
    let is_constant = |own: &Candidate| {
        own.hypothesis.effect == BACKLASH && own.hypothesis.subject == of(lost).subject
    };
    let Some(candidate) = listed.candidates.iter().position(is_constant) else {
        return Vec::new();
    };
    let constant = Chosen {
        candidate,
        shape: 0.0,
        u_shape: 0.0,
    };
    let kept = best
        .causes
        .iter()
        .filter(|own| !goes_with_time(own) && !changes(own));
    let others: Vec<Chosen> = kept.copied().collect();
    let beside = listed.beside(&[&others[..], &[constant]].concat());
    let is_of_time = |score: &&Score| listed.candidate(&beside, score).hypothesis.is_of_time();
    let of_time = beside.scores.iter().filter(is_of_time).take(MOST);
    let pairs = of_time.map(|score| vec![listed.chosen(&beside, score), constant]);
    as_good(plain, &others, pairs, most)
}

/// Those that explain everything with nearly as much evidence instead of other causes; none that holds a smaller one.
fn as_good(
    plain: &Problem<'_>,
    others: &[Chosen],
    instead: impl Iterator<Item = Vec<Chosen>>,
    most: f64,
) -> Vec<Vec<Chosen>> {
    let mut as_good: Vec<Vec<Chosen>> = Vec::new();
    for own in instead {
        let model = of_causes(plain, [others, &own].concat());
        let has_more = as_good
            .iter()
            .any(|few| few.iter().all(|one| has(&model.causes, one)));
        if !has_more && most - evidence(plain, &model) < DECISIVE && !is_left(&model) {
            as_good.push(model.causes);
        }
    }
    as_good
}
