//! A cause that several series have in common, as the outcome says it: once, with all its data.

use trueaxis_effects::{Level, Scene};

use crate::engine::Chosen;
use crate::said::Entry;
use crate::verification::lost_motion::{curve, shown_along};
use crate::verification::report::rivals;
use crate::verification::series::Series;
use crate::verification::stack::Stack;
use crate::verification::together::Shared;
use crate::{Cause, Fitted};

/// With the size that the series of these numbers have in common, from observations of this variance; what each shows of it is to
/// be filled in ([`join`]).
pub(crate) fn joint_cause(
    stack: &Stack<'_>,
    scene: &Scene,
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
    let level = (scene, Level::Verification);
    let hypothesis = listed.hypothesis(&causes[k]);
    let along_it = members.flat_map(|number| {
        let plain = &stack.all[number].plain;
        let own = stack.members[causes[k].candidate][number];
        let sizes = own.map_or(&[][..], |own| &plain.listed.candidates[own].sizes);
        let positions = shown_along(plain.comparison, hypothesis);
        positions.zip(sizes.iter().map(Vec::as_slice))
    });
    let mut along_it: Vec<(f64, &[f64])> = along_it.collect();
    along_it.sort_by(|a, b| a.0.total_cmp(&b.0));
    along_it.dedup_by(|a, b| a.0.total_cmp(&b.0).is_eq());
    let (curve, mean_lost_motion) = curve(&along_it, &sized.fit, variance).unzip();
    Some(Cause {
        curve: curve.unwrap_or_default(),
        mean_lost_motion,
        rivals: rivals(listed, &causes[k..=k], &judged),
        ..listed.cause(&judged, level, (&sized.fit, u_shape), variance)
    })
}

/// Puts each shared cause into the entries of all series that show it, in place of what each says of it.
pub(crate) fn join(entries: &mut [Entry], shared: &[Shared], all: &[Series<'_>]) {
    for shared in shared {
        let place = |number: usize| {
            let causes = &entries[number].causes;
            let is_it = |cause: &Cause| cause.effect.is(&shared.cause.effect);
            Some((number, causes.iter().position(is_it)?))
        };
        let shown = (0..entries.len()).filter(|&number| shared.candidates[number].is_some());
        let places: Vec<(usize, usize)> = shown.filter_map(place).collect();
        let of_each = |&(number, k): &(usize, usize)| {
            let (entry, series) = (&entries[number], &all[number]);
            (
                entry,
                &entry.causes[k],
                entry.report.shares.causes[k],
                series,
            )
        };
        let of_each: Vec<_> = places.iter().map(of_each).collect();
        if of_each.len() < 2 {
            continue;
        }
        let readings = |series: &Series<'_>| series.plain.readings() as f64;
        let squares = |series: &Series<'_>| series.plain.listed.base.squares();
        let mean = |value: &dyn Fn(&Cause, f64) -> f64, weight: &dyn Fn(&Series<'_>) -> f64| {
            let all = of_each.iter();
            let sum: f64 = all
                .clone()
                .map(|(_, c, share, s)| value(c, *share) * weight(s))
                .sum();
            sum / all.map(|(.., s)| weight(s)).sum::<f64>()
        };
        let cause = Cause {
            data: of_each
                .iter()
                .map(|(entry, ..)| entry.report.data.clone())
                .collect(),
            explained_rms_um: mean(&|c, _| c.explained_rms_um.powi(2), &readings).sqrt(),
            share: Some(mean(&|_, share| share, &squares)),
            fitted: panels(of_each.iter().map(|(entry, cause, ..)| (*entry, *cause))),
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
