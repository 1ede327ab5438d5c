//! The search for effects in the curves of a machine ([`Forward`]).

use rayon::prelude::*;
use trueaxis_effects::Scene;
use trueaxis_kinematics::AxisKind;
use trueaxis_selection::{Fit, Null, Scan, Score, by_two_ln_b, cosine, is_rival};

use crate::Error;
use crate::cause::{Cause, Rival};
use crate::components::background::{Background, Smooth, backgrounds, smooth_rests};
use crate::components::bow::{BOW, OfCurve, Pair, cause_of_bow, variance_factor};
use crate::components::candidates::{Candidate, candidates, repeats, shows_its_waves};
use crate::components::curve_set::CurveSet;
use crate::components::estimate::{Estimate, estimate};
use crate::components::family::{Family, LEVEL};
use crate::components::judgement::{Judgement, scan};
use crate::components::report;
use crate::components::smooth_prior::{SmoothLikelihood, SmoothPrior};
use crate::engine::{Forward, is_another, rivals, select};

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
        let first: Vec<Judged> = self
            .sets
            .par_iter()
            .map(|own| own.judged(&own.candidates, &[]))
            .collect();
        for (search, judged) in self.sets.iter().zip(&first) {
            search.count_tests(judged, &mut self.family);
        }
        let pairs = self.straightness_and_angle();
        for _ in &pairs {
            self.family.add(BOW, Null::independent(1.0));
        }
        let family = &self.family;
        let each = self.sets.par_iter_mut().zip(first);
        each.for_each(|(search, first)| {
            let curves = Curves {
                search,
                family,
                first: &first,
            };
            let selected = select(&curves, Vec::new());
            search.found = selected.map_or_else(|_| Vec::new(), |selected| selected.adjusted);
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
                let Estimate { shape, u_shape, .. } = found.estimate;
                shows_its_waves(&search.set, effect, shape)
                    && repeats(&search.set, effect, [shape, u_shape])
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
                let all = search.backgrounds(&[]);
                (kind(search), SmoothLikelihood::new(&all))
            })
            .collect();
        for (i, search) in self.sets.iter_mut().enumerate() {
            let own = kind(search);
            let others = likelihoods.iter().enumerate();
            let others = others.filter(|(j, (kind, _))| *j != i && *kind == own);
            let others: Vec<&SmoothLikelihood> = others.map(|(_, (_, own))| own).collect();
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
    /// The curves for all sizes of the rest, with effects in the model.
    pub(crate) fn backgrounds(&self, effects: &[Found]) -> Vec<Background> {
        let columns = effects.iter().flat_map(|own| own.estimate.columns.clone());
        let model: Vec<Vec<f64>> = self.set.base.iter().cloned().chain(columns).collect();
        backgrounds(&self.set, &self.smooth, &model, &self.prior)
    }

    fn judged(&self, candidates: &[Candidate], effects: &[Found]) -> Judged {
        let backgrounds = self.backgrounds(effects);
        let judgement = |own| Judgement::new(&self.set, &backgrounds, own);
        Judged {
            judgements: candidates.iter().map(judgement).collect(),
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

    /// The candidate with the largest 2 ln B among those that stand out.
    fn best(&self, candidates: &[Candidate], judged: &Judged, family: &Family) -> Option<Found> {
        let numbered = candidates.iter().zip(&judged.judgements).enumerate();
        let scores = numbered.filter_map(|(k, (candidate, judgement))| {
            judgement.score(&judged.backgrounds, candidate, k)
        });
        let scores: Vec<Score> = scores.collect();
        let p_value = |score: &Score| {
            let effect = candidates[score.scan].hypothesis.effect.id;
            family.p_value(effect, score.ln_p)
        };
        let standing_out = scores.iter().filter(|score| p_value(score) <= LEVEL);
        let ranked = by_two_ln_b(standing_out.copied().collect(), |score: &Score| {
            score.two_ln_b
        });
        let leader = *ranked.first()?;
        let candidate = &candidates[leader.scan];
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
        let is_alike = |score: &Score, other: &Fit| is_rival(leader, score, cosine(&own, other));
        let rival = |(score, other): (&Score, Fit)| Rival::Effect {
            effect: self.candidates[score.scan]
                .hypothesis
                .resolved(other.estimates, score.shape),
            delta_bic: score.bic,
        };
        rivals(leader, scores.iter(), fit, is_alike)
            .map(rival)
            .collect()
    }

    /// An effect at its shape beside others; `None` if it does not stand out there.
    fn beside(&self, others: &[Found], own: &Found, family: &Family) -> Option<Found> {
        let at_its_shape = [Candidate {
            shapes: vec![own.estimate.shape],
            ..own.candidate.clone()
        }];
        let judged = self.judged(&at_its_shape, others);
        let found = self.best(&at_its_shape, &judged, family)?;
        Some(Found {
            candidate: own.candidate.clone(),
            rivals: own.rivals.clone(),
            ..found
        })
    }
}

/// The search in one set of curves.
struct Curves<'s> {
    search: &'s SetSearch,
    family: &'s Family,
    /// All candidates without any effect in the model.
    first: &'s Judged,
}

impl Forward for Curves<'_> {
    type Cause = Found;
    type Found = Found;
    type Model = Vec<Found>;

    fn most(&self) -> usize {
        MOST_CAUSES
    }

    fn fit(&self, causes: Vec<Found>) -> Result<Vec<Found>, Error> {
        Ok(causes)
    }

    fn causes(model: &Vec<Found>) -> &[Found] {
        model
    }

    fn best(&self, model: &Vec<Found>, own: Option<&Found>) -> Option<Found> {
        let Self { search, family, .. } = *self;
        let all = &search.candidates;
        match own {
            Some(own) if model.is_empty() => Some(own.clone()),
            Some(own) => search.beside(model, own, family),
            None if model.is_empty() => search.best(all, self.first, family),
            None => search.best(all, &search.judged(all, model), family),
        }
    }

    fn cause(found: &Found) -> &Found {
        found
    }

    fn statistic(found: &Found) -> f64 {
        found.score.statistic
    }

    fn has_moved(before: &Found, now: &Found) -> bool {
        is_another(
            before.estimate.shape,
            (now.estimate.shape, now.estimate.u_shape),
        )
    }

    /// A small effect of a curve stands out from its rest, not from the other effects.
    fn shape_error(&self) -> f64 {
        0.0
    }
}

/// The size of the rest with the largest weight.
fn most_likely(backgrounds: &[Background]) -> Option<&Background> {
    backgrounds
        .iter()
        .max_by(|a, b| a.ln_weight.total_cmp(&b.ln_weight))
}
