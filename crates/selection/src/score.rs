//! How well a hypothesis explains the residuals.

use rayon::prelude::*;

use crate::scan::Tried;
use crate::{Projection, Scan, ln_f_test};

/// The best shape of a hypothesis, and its judgement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Score {
    /// Index of the scan.
    pub scan: usize,
    /// Its best shape.
    pub shape: f64,
    /// Standard deviation of the shape over its marginal likelihood, which is uniform for instants within a gap.
    pub u_shape: f64,
    /// Drop of the sum of squares with the best shape, `T`.
    pub statistic: f64,
    /// Number of combinations of the parameters that the data see.
    pub rank: usize,
    /// Logarithm of the p-value of the best tested shape, as if this hypothesis and shape were the only ones.
    pub ln_p: f64,
    /// BIC against the base model, negative if better: `n ln(1 - T/S) + k ln n`, shape counted.
    pub bic: f64,
    /// 2 ln B: twice the logarithm of the Bayes factor against the base model, with the same prior
    /// for every effect: shared among its subjects and their shapes.
    pub two_ln_b: f64,
}

impl Score {
    /// By how much 2 ln B is below twice the logarithm of the likelihood ratio against the base model: what the prior of
    /// the parameters, shapes and subjects costs.
    pub fn price(&self, base: &Projection) -> f64 {
        base.ln_ratio(base.squares() - self.statistic) - self.two_ln_b
    }
}

/// Evidence that differs by less than this is equal but for rounding.
pub const EQUAL: f64 = 1e-3;

/// Sorts by falling 2 ln B; equal ones keep their order, so that rounding does not decide the name of what is confounded.
pub fn by_two_ln_b<T>(all: Vec<T>, two_ln_b: impl Fn(&T) -> f64) -> Vec<T> {
    let mut all: Vec<(usize, T)> = all.into_iter().enumerate().collect();
    all.sort_by(|a, b| two_ln_b(&b.1).total_cmp(&two_ln_b(&a.1)));
    let mut rest = &mut all[..];
    while let Some((_, first)) = rest.first() {
        let least = two_ln_b(first) - EQUAL;
        let is_alike = |(_, one): &&(usize, T)| two_ln_b(one) > least;
        let alike = rest.iter().take_while(is_alike).count();
        let (alike, others) = rest.split_at_mut(alike.max(1));
        alike.sort_by_key(|(number, _)| *number);
        rest = others;
    }
    all.into_iter().map(|(_, one)| one).collect()
}

/// Scores of all scans by their 2 ln B ([`by_two_ln_b`]); equal ones in the order of the scans, and so of the
/// layers instrument, set-up, machine.
pub fn rank(projection: &Projection, scans: &[Box<dyn Scan>]) -> Vec<Score> {
    let numbered = scans.par_iter().enumerate();
    let scored = numbered.filter_map(|(number, scan)| scored(projection, number, scan.as_ref()));
    by_two_ln_b(scored.collect(), |score| score.two_ln_b)
}

/// The score of one scan; `None` if the data do not see it.
fn scored(projection: &Projection, number: usize, scan: &dyn Scan) -> Option<Score> {
    let squares = projection.squares();
    let dof = projection.degrees_of_freedom;
    // With an unknown variance a drop T counts ν ln(S/(S - T)), which is T/σ² for small T.
    let variance = squares / dof;
    let [best, tested] = best_shapes(projection, scan);
    let (shape, statistic, rank) = best?;
    let mut listed: Vec<OfShape> = Vec::new();
    let mut shapes = 0;
    scan.for_each(&projection.residuals, &mut |tried, gram, s| {
        shapes += 1;
        let own = gram.statistic(s);
        if own < statistic - NEGLIGIBLE * variance {
            return;
        }
        let likelihood = projection.ln_ratio(squares - own);
        let left = ((squares - own) / squares).max(f64::MIN_POSITIVE);
        // The price of the prior, in the variance left with this hypothesis in the model.
        let per_deviation = 1.0 / (variance * left).sqrt();
        let in_deviations: Vec<f64> = s.iter().map(|s| s * per_deviation).collect();
        let price = gram.statistic(&in_deviations) - gram.two_ln_b(&in_deviations);
        listed.push(OfShape {
            tried,
            two_ln_b: likelihood - price,
        });
    });
    let hypothesis = scan.hypothesis();
    let all_two_ln_b: Vec<f64> = listed.iter().map(|one| one.two_ln_b).collect();
    let left = ((squares - statistic) / squares).max(f64::MIN_POSITIVE);
    let n = projection.rows() as f64;
    let parameters = rank + usize::from(hypothesis.has_shape());
    Some(Score {
        scan: number,
        shape,
        u_shape: match hypothesis.has_shape() {
            true => deviation(&listed, shape),
            false => 0.0,
        },
        statistic,
        rank,
        ln_p: tested.map_or(0.0, |(_, statistic, rank)| {
            ln_f_test(statistic, squares, rank, dof)
        }),
        bic: n * left.ln() + parameters as f64 * n.ln(),
        two_ln_b: mean_two_ln_b(&all_two_ln_b, shapes) - 2.0 * (hypothesis.subjects as f64).ln(),
    })
}

/// Shapes that explain less than the best by this many units of variance are left out of the mean likelihood: a
/// factor of e⁻²⁰ each.
const NEGLIGIBLE: f64 = 40.0;

/// A shape with its statistic and rank.
type Best = (f64, f64, usize);

/// The shape whose statistic is least likely by noise.
pub fn best_shape(projection: &Projection, scan: &dyn Scan) -> Option<Best> {
    let [best, _] = best_shapes(projection, scan);
    best
}

/// The best of all shapes, and the best of those that are tested.
fn best_shapes(projection: &Projection, scan: &dyn Scan) -> [Option<Best>; 2] {
    // The largest statistic of each rank.
    let mut of_ranks: [Vec<(f64, f64)>; 2] = Default::default();
    scan.for_each(&projection.residuals, &mut |tried, gram, s| {
        let (rank, statistic) = (gram.rank(), gram.statistic(s));
        let asked = if tried.is_tested { 2 } else { 1 };
        for own in &mut of_ranks[..asked] {
            if own.len() <= rank {
                own.resize(rank + 1, (0.0, f64::NEG_INFINITY));
            }
            if statistic > own[rank].1 {
                own[rank] = (tried.shape, statistic);
            }
        }
    });
    let (squares, dof) = (projection.squares(), projection.degrees_of_freedom);
    let ln_p = |rank: usize, statistic: f64| ln_f_test(statistic, squares, rank, dof);
    of_ranks.map(|own| {
        let seen = own.into_iter().enumerate().skip(1);
        seen.filter(|(_, (_, statistic))| statistic.is_finite())
            .map(|(rank, (shape, statistic))| (shape, statistic, rank))
            .min_by(|a, b| ln_p(a.2, a.1).total_cmp(&ln_p(b.2, b.1)))
    })
}

/// A shape with twice the logarithm of its marginal likelihood.
struct OfShape {
    tried: Tried,
    two_ln_b: f64,
}

/// `2 ln` of the mean marginal likelihood over all `shapes`; it is zero for those not listed.
pub fn mean_two_ln_b(listed: &[f64], shapes: usize) -> f64 {
    let top = listed.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let likelihoods = listed.iter().map(|two_ln_b| (0.5 * (two_ln_b - top)).exp());
    let total: f64 = likelihoods.sum();
    top + 2.0 * (total / shapes as f64).ln()
}

/// Standard deviation of the shape about the best one, over its marginal likelihood.
///
/// An instant is equally likely in each second of a gap: a gap between two occupations has the weight of its length,
/// and the instant is anywhere in it.
fn deviation(listed: &[OfShape], best: f64) -> f64 {
    let all_two_ln_b = listed.iter().map(|one| one.two_ln_b);
    let top = all_two_ln_b.fold(f64::NEG_INFINITY, f64::max);
    let (mut squares, mut weights) = (0.0, 0.0);
    for one in listed {
        let Tried { shape, gap_s, .. } = one.tried;
        let weight = (0.5 * (one.two_ln_b - top)).exp() * gap_s.unwrap_or(1.0);
        let within = gap_s.map_or(0.0, |gap| gap * gap / 12.0);
        squares += weight * ((shape - best).powi(2) + within);
        weights += weight;
    }
    (squares / weights).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_ones_stay_in_their_order() {
        let all = vec![
            ('a', 1.0),
            ('b', 7.0),
            ('c', 7.0 + 1e-9),
            ('d', -1.0),
            ('e', 7.1),
        ];
        let sorted = by_two_ln_b(all, |one| one.1);
        let names: String = sorted.iter().map(|one| one.0).collect();
        assert_eq!(names, "ebcad");
        let none = by_two_ln_b(vec![f64::NEG_INFINITY, 1.0, f64::NAN], |x| *x);
        assert!(none[0].is_nan() && none[1..] == [1.0, f64::NEG_INFINITY]);
    }
}
