//! What wanders beside causes: judged as in the lengths, by its evidence ([`Smooth`]) and a p-value of all together.

use crate::engine::{Chosen, SMOOTH_LEVEL, Smooth};
use crate::selection::DECISIVE;
use crate::verification::problem::Problem;
use crate::verification::wanderer::{Wanderer, wanderers};

/// More that wander at once are not told apart.
const MOST: usize = 2;

/// Something that wanders, with its judgement beside the others.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Wandering {
    pub(crate) wanderer: Wanderer,
    /// ℓ, as a part of the range of the argument.
    pub(crate) length: f64,
    /// w, in standard deviations of an arrival.
    pub(crate) width: f64,
    pub(crate) evidence: f64,
    pub(crate) p_value: f64,
    /// What explains as much.
    pub(crate) rivals: Vec<Wanderer>,
}

/// What wanders beside causes, one after the other.
pub(crate) fn wandering(plain: &Problem<'_>, causes: &[Chosen]) -> Vec<Wandering> {
    let all = wanderers(plain.comparison, plain.calibrated);
    let mut own: Vec<Wandering> = Vec::new();
    // Each round adds one; one that another makes superfluous gives its place free once.
    for _ in 0..2 * MOST {
        if own.len() == MOST {
            break;
        }
        let here = plain.beside(&own);
        let is_other = |w: &&Wanderer| own.iter().all(|o| o.wanderer != **w);
        let others = all.iter().filter(is_other);
        let mut judged: Vec<Wandering> = others
            .filter_map(|&wanderer| judge(&here, causes, wanderer, all.len()))
            .collect();
        judged.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
        let Some((next, others)) = judged.split_first() else {
            break;
        };
        if next.p_value >= SMOOTH_LEVEL {
            break;
        }
        let is_rival = |other: &&Wandering| next.evidence - other.evidence < DECISIVE;
        let rivals = others.iter().filter(is_rival).map(|other| other.wanderer);
        let twins = |w: Wanderer| [Some(w), w.twin(plain.comparison)].into_iter().flatten();
        let rivals: Vec<Wanderer> = twins(next.wanderer)
            .skip(1)
            .chain(rivals.flat_map(twins))
            .collect();
        own.push(Wandering {
            rivals,
            ..next.clone()
        });
        own = again(plain, causes, own, all.len());
    }
    own
}

/// Each with the size that it has beside the others; without those that are not significant there.
fn again(
    plain: &Problem<'_>,
    causes: &[Chosen],
    mut own: Vec<Wandering>,
    family: usize,
) -> Vec<Wandering> {
    for k in 0..own.len() {
        let mut others = own.clone();
        let Wandering {
            wanderer, rivals, ..
        } = others.remove(k);
        match judge(&plain.beside(&others), causes, wanderer, family) {
            Some(judged) => own[k] = Wandering { rivals, ..judged },
            None => own[k].p_value = 1.0,
        }
    }
    own.retain(|judged| judged.p_value < SMOOTH_LEVEL);
    own
}

/// What one explains of what a model with causes leaves.
fn judge(
    problem: &Problem<'_>,
    causes: &[Chosen],
    wanderer: Wanderer,
    family: usize,
) -> Option<Wandering> {
    let comparison = problem.comparison;
    let columns = wanderer.columns(comparison).into_iter();
    let columns: Vec<Vec<f64>> = columns.map(|c| problem.whiten(&c)).collect();
    let lengths = wanderer.lengths(comparison);
    let roots = lengths
        .iter()
        .map(|&length| wanderer.roots(comparison, length));
    let roots: Vec<Vec<f64>> = roots.collect();
    let smooth = Smooth::new(&problem.listed.with(causes), &columns, &roots)?;
    Some(Wandering {
        wanderer,
        length: lengths[smooth.spectrum],
        width: smooth.width,
        evidence: smooth.evidence,
        p_value: (family as f64 * smooth.p_value).min(1.0),
        rivals: Vec::new(),
    })
}

impl Wandering {
    /// What a standard deviation beforehand of each coefficient does to the whitened readings.
    pub(crate) fn columns(&self, problem: &Problem<'_>) -> Vec<Vec<f64>> {
        let columns = self.wanderer.columns(problem.comparison);
        let roots = self.wanderer.roots(problem.comparison, self.length);
        let scaled = columns.into_iter().zip(roots).map(|(column, root)| {
            let column = column.iter().map(|x| x * self.width * root);
            problem.whiten(&column.collect::<Vec<f64>>())
        });
        scaled.collect()
    }
}
