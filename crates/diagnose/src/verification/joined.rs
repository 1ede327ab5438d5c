//! A cause common to several series, as the outcome states it: once, with all its data.

use trueaxis_effects::Level;

use crate::engine::linear::Chosen;
use crate::said::Entry;
use crate::verification::lost_motion::{curve, shown_along};
use crate::verification::series::Series;
use crate::verification::stack::Stack;
use crate::verification::together::Shared;
use crate::{Cause, Fitted};

/// With the size common to the series with these numbers, from observations of this variance; what each shows of it
/// is still to be filled in ([`join`]).
pub(crate) fn joint_cause(
    stack: &Stack<'_>,
    (causes, k): (&[Chosen], usize),
    members: impl Iterator<Item = usize>,
    variance: f64,
) -> Option<Cause> {
    let listed = &stack.listed;
    let judged = listed.judge(causes, k)?;
    let sized = listed.sizes(causes).swap_remove(k);
    let u_shape = sized
        .u_shape
        .map_or(judged.score.u_shape, |u| u * variance.sqrt());
    let level = (stack.all[0].plain.scene, Level::Verification);
    let along_it = members.filter_map(|number| {
        let plain = &stack.all[number].plain;
        let own = stack.members[causes[k].candidate][number]?;
        Some(shown_along(plain.comparison, &plain.listed.candidates[own]))
    });
    let mut along_it: Vec<(f64, &[f64])> = along_it.flatten().collect();
    along_it.sort_by(|a, b| a.0.total_cmp(&b.0));
    along_it.dedup_by(|a, b| a.0.total_cmp(&b.0).is_eq());
    let said = listed.cause(&judged, level, (&sized.fit, u_shape), variance);
    let unit = said.parameters[0].unit;
    let (curve, mean_lost_motion) = curve(&along_it, &sized.fit, variance, unit);
    Some(Cause {
        curve,
        mean_lost_motion,
        rivals: listed.rivals(&judged),
        ..said
    })
}

/// Puts each shared cause into the entries of all series that show it, in place of each series' own statement.
pub(crate) fn join(entries: &mut [Entry], shared: &[Shared], all: &[Series<'_>]) {
    for shared in shared {
        let place = |number: usize| {
            let causes = &entries[number].causes;
            let is_it = |cause: &Cause| cause.effect.is(&shared.cause.effect);
            Some((number, causes.iter().position(is_it)?))
        };
        let shown = (0..entries.len()).filter(|&number| shared.candidates[number].is_some());
        let places: Vec<(usize, usize)> = shown.filter_map(place).collect();
        if places.len() < 2 {
            continue;
        }
        // Mean over those that show it, of values with their weights.
        let mean = |of: &dyn Fn(usize, usize) -> [f64; 2]| {
            let all = places.iter().map(|&(number, k)| of(number, k));
            let [sum, weights] = all.fold([0.0; 2], |[sum, weights], [x, w]| {
                [sum + x * w, weights + w]
            });
            sum / weights
        };
        let square_um = mean(&|number, k| {
            let square_um = entries[number].causes[k].explained_rms_um.powi(2);
            [square_um, all[number].plain.readings() as f64]
        });
        let share = mean(&|number, k| {
            let share = entries[number].report.shares.causes[k];
            [share, all[number].plain.listed.base.squares()]
        });
        let reports = places.iter().map(|(number, _)| &entries[*number].report);
        let own = places
            .iter()
            .map(|&(number, k)| (&entries[number], &entries[number].causes[k]));
        let cause = Cause {
            data: reports.map(|report| report.data.clone()).collect(),
            explained_rms_um: square_um.sqrt(),
            share: Some(share),
            fitted: panels(own),
            ..shared.cause.clone()
        };
        for (number, k) in places {
            entries[number].causes[k] = cause.clone();
        }
    }
}

/// A panel for each series, the one that shows most of the cause first.
fn panels<'e>(of_each: impl Iterator<Item = (&'e Entry, &'e Cause)>) -> Option<Fitted> {
    let mut panels: Vec<(f64, Fitted)> = of_each
        .filter_map(|(entry, cause)| {
            let fitted = cause.fitted.clone()?;
            let of = entry.report.data.clone();
            Some((cause.explained_rms_um, Fitted { of, ..fitted }))
        })
        .collect();
    panels.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut panels = panels.into_iter().map(|(_, panel)| panel);
    let first = panels.next()?;
    Some(Fitted {
        beside: panels.collect(),
        ..first
    })
}
