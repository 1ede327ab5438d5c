//! The search for effects: one at a time with the earlier ones in the model; at the end each with all others.

use rayon::prelude::*;
use trueaxis_effects::Scene;
use trueaxis_kinematics::AxisKind;
use trueaxis_selection::{Fit, Null, Scan, Score, by_evidence, cosine, is_rival};

use crate::cause::{Cause, Rival};
use crate::components::background::{Background, Smooth, backgrounds, smooth_rests};
use crate::components::bow::{BOW, OfCurve, Pair, cause_of_bow, variance_factor};
use crate::components::candidates::{Candidate, candidates, shows_its_waves};
use crate::components::curve_set::CurveSet;
use crate::components::estimate::{Estimate, estimate};
use crate::components::family::{Family, LEVEL};
use crate::components::judgement::{Judgement, scan};
use crate::components::report;
use crate::components::smooth_prior::{SmoothLikelihood, SmoothPrior};

/// The search over all curves of a machine.
pub(crate) struct Search<'a> {
    scene: &'a Scene,
    family: Family,
    sets: Vec<SetSearch>,
}

/// One set of curves.
pub(crate) struct SetSearch {
    pub(crate) set: CurveSet,
    /// Prior of the size of its smooth rest.
    pub(crate) prior: SmoothPrior,
    candidates: Vec<Candidate>,
    smooth: Vec<Smooth>,
    /// The effects found so far.
    pub(crate) found: Vec<Found>,
}

/// An effect that stands out.
#[derive(Debug, Clone)]
pub(crate) struct Found {
    pub(crate) candidate: Candidate,
    pub(crate) estimate: Estimate,
    /// Its judgement with all others in the model.
    pub(crate) score: Score,
    /// Family-wise p-value.
    pub(crate) p_value: f64,
    /// Other explanations that fit the curves nearly as well.
    pub(crate) rivals: Vec<Rival>,
}

/// Most effects of one set: more would describe a curve, not explain it.
const MOST_CAUSES: usize = 4;

impl<'a> Search<'a> {
    pub(crate) fn new(scene: &'a Scene, sets: Vec<CurveSet>) -> Self {
        let sets = sets.into_par_iter().map(|set| SetSearch {
            candidates: candidates(&set, scene),
            smooth: smooth_rests(&set),
            prior: SmoothPrior::default(),
            found: Vec::new(),
            set,
        });
        Self {
            scene,
            family: Family::default(),
            sets: sets.collect(),
        }
    }

    /// All causes, the most certain first.
    pub(crate) fn causes(mut self) -> Vec<Cause> {
        self.share_size_of_rest();
        // Counts the tests before anything is judged.
        let first: Vec<Judged> = self.sets.par_iter().map(SetSearch::judged).collect();
        for (search, judged) in self.sets.iter().zip(&first) {
            search.count_tests(judged, &mut self.family);
        }
        let pairs = self.straightness_and_angle();
        for _ in &pairs {
            self.family.add(BOW, Null::independent(1.0));
        }
        let family = &self.family;
        let each = self.sets.par_iter_mut().zip(first);
        each.for_each(|(search, judged)| {
            search.select(judged, family);
            search.confirm(family);
            search.tell_aliases_apart();
        });
        let pairs = pairs.into_iter().filter_map(|(straightness, angle)| {
            let (a, b) = (&self.sets[straightness], &self.sets[angle]);
            Some((&a.set, Pair::new(a, b, self.scene)?))
        });
        let (bent, straight): (Vec<_>, Vec<_>) = pairs.partition(|(_, pair)| pair.is_bent());
        let factor = |curve: fn(&Pair) -> &OfCurve| {
            let squares = straight.iter().map(|(_, pair)| curve(pair).square());
            variance_factor(&squares.collect::<Vec<_>>())
        };
        let factors = [
            factor(|pair| &pair.straightness),
            factor(|pair| &pair.angle),
        ];
        let mut causes: Vec<Cause> = Vec::new();
        for search in &self.sets {
            let named = search.found.iter().filter(|found| {
                let effect = found.candidate.hypothesis.effect;
                shows_its_waves(&search.set, effect, found.estimate.shape)
            });
            for found in named {
                let mut found = found.clone();
                // A scale is the slope of a positioning curve, as a bow is that of an angle.
                if found.candidate.hypothesis.effect.is_scale_of_axis() {
                    found.estimate.covariance *= factors[1];
                }
                causes.push(report::cause(&search.set, &found, self.scene));
            }
        }
        for (set, pair) in bent {
            let mut found = pair.found(factors);
            found.p_value = self.family.p_value(BOW, found.score.ln_p);
            if found.p_value <= LEVEL {
                causes.push(cause_of_bow(set, &found, self.scene));
            }
        }
        causes.sort_by(|a, b| {
            let by_p = a.p_value.total_cmp(&b.p_value);
            by_p.then(a.delta_bic.total_cmp(&b.delta_bic))
        });
        causes
    }

    /// Gives each curve the prior from the other curves of its kind.
    fn share_size_of_rest(&mut self) {
        let kind = |search: &SetSearch| {
            let angular = search.set.components[0].is_angular();
            (search.set.content.kind(), angular)
        };
        let likelihoods: Vec<_> = self
            .sets
            .par_iter()
            .map(|search| {
                let all = search.backgrounds(None);
                (kind(search), SmoothLikelihood::new(&all))
            })
            .collect();
        for (i, search) in self.sets.iter_mut().enumerate() {
            let own = kind(search);
            let others: Vec<&SmoothLikelihood> = likelihoods
                .iter()
                .enumerate()
                .filter(|(j, (kind, _))| *j != i && *kind == own)
                .map(|(_, (_, likelihood))| likelihood)
                .collect();
            search.prior = SmoothPrior::from_others(&others);
        }
    }

    /// Indices of each straightness and of the angle that is its slope.
    fn straightness_and_angle(&self) -> Vec<(usize, usize)> {
        let mut pairs = Vec::new();
        for (i, own) in self.sets.iter().enumerate() {
            if own.set.content.kind() != AxisKind::Linear || !own.set.is_straightness() {
                continue;
            }
            // The angle is about the direction normal to the axis and to the straightness.
            let (along, across) = (own.set.content.principal(), own.set.components[0].index());
            let angle = self.sets.iter().position(|other| {
                other.set.axis == own.set.axis
                    && other.set.components[0].index() == 3 + (3 - along - across)
            });
            pairs.extend(angle.map(|angle| (i, angle)));
        }
        pairs
    }
}

/// The candidates of a set, judged for every size of the rest.
struct Judged {
    backgrounds: Vec<Background>,
    judgements: Vec<Judgement>,
}

impl SetSearch {
    /// The curves for all sizes of the rest, with all effects found, except `without`, in the model.
    pub(crate) fn backgrounds(&self, without: Option<usize>) -> Vec<Background> {
        let model = self.model(without);
        backgrounds(&self.set, &self.smooth, &model, &self.prior)
    }

    /// The base and all effects found, except `without`.
    fn model(&self, without: Option<usize>) -> Vec<Vec<f64>> {
        let mut base = self.set.base.clone();
        for (i, found) in self.found.iter().enumerate() {
            if Some(i) != without {
                base.extend(found.estimate.columns.iter().cloned());
            }
        }
        base
    }

    fn judged(&self) -> Judged {
        let backgrounds = self.backgrounds(None);
        let judgements = self.candidates.iter();
        Judged {
            judgements: judgements
                .map(|candidate| Judgement::new(&self.set, &backgrounds, candidate))
                .collect(),
            backgrounds,
        }
    }

    /// The effective number of tests of each effect, for the most likely rest.
    fn count_tests(&self, judged: &Judged, family: &mut Family) {
        let Some(likely) = most_likely(&judged.backgrounds) else {
            return;
        };
        for candidate in &self.candidates {
            let Some(scan) = scan(&self.set, likely, candidate) else {
                continue;
            };
            let tests = if candidate.shapes.len() == 1 {
                Null::independent(1.0)
            } else {
                let scans: [Box<dyn Scan>; 1] = [Box::new(scan)];
                let along = |noise: Vec<f64>| likely.whitening.turned(&noise);
                Null::simulated_in(&likely.projection, &scans, along)
            };
            family.add(candidate.hypothesis.effect.id, tests);
        }
    }

    /// Adds effects until no other stands out.
    fn select(&mut self, mut judged: Judged, family: &Family) {
        while self.found.len() < MOST_CAUSES {
            let Some(found) = self.best(&judged, family) else {
                return;
            };
            self.found.push(found);
            judged = self.judged();
        }
    }

    /// The effect with the most evidence among those that stand out.
    fn best(&self, judged: &Judged, family: &Family) -> Option<Found> {
        let numbered = self.candidates.iter().zip(&judged.judgements).enumerate();
        let scores: Vec<Score> = numbered
            .filter_map(|(k, (candidate, judgement))| {
                judgement.score(&judged.backgrounds, candidate, k)
            })
            .collect();
        let p_value = |score: &Score| {
            let effect = self.candidates[score.scan].hypothesis.effect.id;
            family.p_value(effect, score.ln_p)
        };
        let standing_out = scores.iter().filter(|score| p_value(score) <= LEVEL);
        let ranked = by_evidence(standing_out.copied().collect(), |score: &Score| {
            score.evidence
        });
        let leader = *ranked.first()?;
        let candidate = &self.candidates[leader.scan];
        Some(Found {
            estimate: estimate(&self.set, &judged.backgrounds, candidate, leader.shape),
            candidate: candidate.clone(),
            p_value: p_value(&leader),
            rivals: self.rivals(&judged.backgrounds, &leader, &scores),
            score: leader,
        })
    }

    /// The other effects that cannot be distinguished from the leader.
    fn rivals(&self, backgrounds: &[Background], leader: &Score, scores: &[Score]) -> Vec<Rival> {
        let Some(background) = most_likely(backgrounds) else {
            return Vec::new();
        };
        let fit = |score: &Score| {
            let columns = self.set.columns(&self.candidates[score.scan], score.shape);
            let whitened = columns
                .iter()
                .map(|column| background.whitening.whiten(column));
            Fit::new(&background.projection, &whitened.collect::<Vec<_>>())
        };
        let own = fit(leader);
        let others = scores.iter().filter(|score| score.scan != leader.scan);
        others
            .filter_map(|score| {
                let other = fit(score);
                let hypothesis = &self.candidates[score.scan].hypothesis;
                is_rival(leader, score, cosine(&own, &other)).then(|| Rival::Effect {
                    effect: hypothesis.resolved(other.estimates, score.shape),
                    delta_bic: score.bic,
                })
            })
            .collect()
    }

    /// Judges each effect with all others in the model: removes those that do not stand out, and updates the values
    /// of the rest.
    fn confirm(&mut self, family: &Family) {
        if self.found.len() < 2 {
            return;
        }
        let mut i = 0;
        while i < self.found.len() {
            let backgrounds = self.backgrounds(Some(i));
            let mut candidate = self.found[i].candidate.clone();
            let shape = self.found[i].estimate.shape;
            candidate.shapes = vec![shape];
            let judgement = Judgement::new(&self.set, &backgrounds, &candidate);
            let score = judgement.score(&backgrounds, &candidate, self.found[i].score.scan);
            let id = candidate.hypothesis.effect.id;
            let judged = score.map(|score| (score, family.p_value(id, score.ln_p)));
            match judged.filter(|(_, p_value)| *p_value <= LEVEL) {
                Some((score, p_value)) => {
                    let estimate = estimate(&self.set, &backgrounds, &candidate, shape);
                    let found = &mut self.found[i];
                    (found.score, found.p_value, found.estimate) = (score, p_value, estimate);
                    i += 1;
                }
                None => {
                    self.found.remove(i);
                }
            }
        }
    }
}

/// The size of the rest with the largest weight.
fn most_likely(backgrounds: &[Background]) -> Option<&Background> {
    backgrounds
        .iter()
        .max_by(|a, b| a.ln_weight.total_cmp(&b.ln_weight))
}
