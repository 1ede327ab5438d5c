//! Points without gross errors, beside causes whose instants may lie on either side of a gross error.

use nalgebra::Vector3;
use trueaxis_campaign::{Campaign, Points};
use trueaxis_effects::{ResolvedEffect, Scene, Shape};

use crate::engine::Suspect;
use crate::points::base::Base;
use crate::points::gross_errors::{Gross, are_accidents, stand_out};
use crate::points::model::Model;
use crate::points::weighed::weighed;

/// The points without gross errors.
pub(super) struct Screened<'a> {
    pub(super) base: Base<'a>,
    pub(super) gross: Vec<Gross>,
    /// Whether there are too many, or several consecutive ones: then none is left out.
    pub(super) are_many: bool,
    /// Targets that scatter more than the others, and weigh less.
    pub(super) uneven: Vec<usize>,
}

impl<'a> Screened<'a> {
    /// Screens points beside causes.
    pub(super) fn beside(
        campaign: &'a Campaign,
        points: &Points,
        scene: &'a Scene,
        causes: &[Suspect],
    ) -> Self {
        let adjusted = |points: &Points, removed: &[usize]| {
            let base = Base::new(campaign, scene, points, removed);
            let model = Model::estimated(&base, &base.columns_of(causes));
            (base, model)
        };
        let (mut base, mut model) = adjusted(points, &[]);
        let of_all = weighed(points, (&base, &model), |points| adjusted(points, &[]));
        let (points, uneven) = match &of_all {
            Some((points, uneven)) => {
                (base, model) = adjusted(points, &[]);
                (points, uneven.clone())
            }
            None => (points, Vec::new()),
        };
        let mut gross: Vec<Gross> = Vec::new();
        loop {
            let next = stand_out(&base, &model);
            let are_many = !are_accidents(&[&gross[..], &next[..]].concat(), &base, points);
            if are_many {
                gross.clear();
                base = Base::new(campaign, scene, points, &[]);
            }
            if next.is_empty() || are_many {
                gross.sort_by_key(|g| g.points[0].number);
                return Self {
                    base,
                    gross,
                    are_many,
                    uneven,
                };
            }
            gross.extend(next);
            (base, model) = adjusted(points, &numbers(&gross));
        }
    }

    /// Screens beside causes as they are, or with an instant on the other side of an adjacent point that is left out:
    /// an instant found without that point is uncertain there.
    pub(super) fn beside_any(
        campaign: &'a Campaign,
        points: &Points,
        scene: &'a Scene,
        mut causes: Vec<Suspect>,
    ) -> Self {
        let mut best = Self::beside(campaign, points, scene, &causes);
        if best.gross.is_empty() {
            return best;
        }
        let all = Base::new(campaign, scene, points, &[]);
        for number in best.numbers() {
            for k in 0..causes.len() {
                let left_out = best.numbers();
                let Some(shape) = beyond(&all, &causes[k], number, &left_out) else {
                    continue;
                };
                let mut moved = causes.clone();
                moved[k].shape = shape;
                let other = Self::beside(campaign, points, scene, &moved);
                if !other.are_many && other.gross.len() < best.gross.len() {
                    (best, causes) = (other, moved);
                }
            }
        }
        best
    }

    pub(super) fn numbers(&self) -> Vec<usize> {
        numbers(&self.gross)
    }
}

/// The points except those with these numbers; a stop without points disappears.
pub(super) fn without(points: &Points, removed: &[usize]) -> Points {
    let mut kept = Points::default();
    for stop in &points.stops {
        let first = kept.readings.len();
        let own = stop.readings.clone().filter(|k| !removed.contains(k));
        let own = own.map(|number| points.readings[number].clone());
        kept.readings.extend(own);
        if kept.readings.len() > first {
            let mut stop = stop.clone();
            stop.readings = first..kept.readings.len();
            kept.stops.push(stop);
        }
    }
    kept
}

/// The numbers of the points that are left out, ascending.
fn numbers(gross: &[Gross]) -> Vec<usize> {
    let points = gross.iter().flat_map(|g| &g.points);
    let mut numbers: Vec<usize> = points.map(|point| point.number).collect();
    numbers.sort_unstable();
    numbers
}

/// The instant of a cause on the other side of a point that is left out, s, if no kept point that shows the effect is between the two.
fn beyond(all: &Base<'_>, cause: &Suspect, number: usize, left_out: &[usize]) -> Option<f64> {
    let from_the_beginning = [ResolvedEffect {
        shape: f64::NEG_INFINITY,
        ..cause.resolved()
    }];
    let shows = |i: usize| all.effect_mm(i, &from_the_beginning) != Vector3::zeros();
    let readings = &all.readings.all;
    let own = readings.iter().position(|r| r.number == number)?;
    let is_instant = cause.hypothesis.effect.shape == Shape::Instant;
    if !is_instant || !left_out.contains(&number) || !shows(own) {
        return None;
    }
    let (time_s, instant_s) = (readings[own].time_s, cause.shape);
    let is_between = |s: f64| match instant_s < time_s {
        true => instant_s < s && s < time_s,
        false => time_s < s && s <= instant_s,
    };
    let mut kept = readings.iter().enumerate();
    let is_parted =
        kept.any(|(i, r)| is_between(r.time_s) && !left_out.contains(&r.number) && shows(i));
    // A point at the very instant is before it.
    let beyond_s = match instant_s < time_s {
        true => time_s,
        false => time_s.next_down(),
    };
    (!is_parted).then_some(beyond_s)
}
