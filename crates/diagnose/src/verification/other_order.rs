//! Causes that hinge on an order of measuring that the readings leave open.
//!
//! Such a table is judged in both orders. A cause that both name with one size is as sure as in either. One that both
//! name with two sizes of one sign is uncertain by both: the mean square from the stated size is half the square of
//! the distance. Any other has what the other order shows as rivals.

use std::f64::consts::SQRT_2;

use trueaxis_effects::Level;

use crate::engine::disturbance::{Wanderer, Who, With};
use crate::said::Entry;
use crate::verification::comparison::Comparison;
use crate::verification::wanderer::with_time;
use crate::{Cause, Rival};

/// Sizes that differ by no more standard uncertainties are one.
const COVERAGE: f64 = 2.0;

/// Puts what the other order shows beside the causes of an entry; `None` where it could not be judged. `are_open` are
/// the data whose order is open: what another file shows, too, does not hinge on it.
pub(crate) fn doubt(
    entry: &mut Entry,
    other: Option<&Entry>,
    comparison: &Comparison<'_>,
    are_open: &[&str],
) {
    let others = other.map_or(&[][..], |other| &other.causes);
    let known: Vec<_> = entry.causes.iter().map(|own| own.effect.clone()).collect();
    for cause in &mut entry.causes {
        if cause.data.iter().any(|data| !are_open.contains(&&**data)) {
            continue;
        }
        let partner = others.iter().find(|own| are_alike(own, cause));
        if partner.is_some_and(|partner| is_in_both(cause, partner)) {
            continue;
        }
        let news = others
            .iter()
            .filter(|own| !known.iter().any(|effect| effect.is(&own.effect)));
        let named = news.map(|own| Rival::Effect {
            effect: own.effect.clone(),
            delta_bic: own.delta_bic,
        });
        let two_ln_b = -cause.delta_bic;
        let wanders = other.iter().flat_map(|other| &other.disturbances);
        let wanders = wanders.map(|own| Rival::Disturbance {
            whose: own.whose,
            two_ln_b,
        });
        let mut rivals: Vec<Rival> = named.chain(wanders).collect();
        if rivals.is_empty() {
            let of_order = of_order(cause, comparison).into_iter();
            rivals.extend(of_order.map(|own| Rival::of(Level::Verification, own, two_ln_b)));
        }
        cause.rivals.extend(rivals);
    }
}

/// Whether two causes are one effect, lost motion in either form.
fn are_alike(a: &Cause, b: &Cause) -> bool {
    let are_lost_motion = a.effect.effect.is_lost_motion() && b.effect.effect.is_lost_motion();
    a.effect.is(&b.effect) || are_lost_motion && a.effect.subject == b.effect.subject
}

/// Whether a cause is there in both orders; its uncertainty then contains both sizes.
fn is_in_both(cause: &mut Cause, other: &Cause) -> bool {
    let are_two_forms = !cause.effect.is(&other.effect);
    let (own, others) = (cause.told_parameters(), other.told_parameters());
    // An instant or a time constant counts readings, which each order counts in its own way.
    let width = match are_two_forms {
        true => 1,
        false => cause.covariance.len().isqrt(),
    };
    let pairs = || own.iter().zip(&others).take(width);
    let is_one = pairs().all(|(a, b)| (a.value - b.value).abs() <= COVERAGE * a.u.hypot(b.u));
    if is_one {
        return true;
    }
    if pairs().any(|(a, b)| a.value * b.value <= 0.0) {
        return false;
    }
    let stride = cause.covariance.len().isqrt();
    let distances: Vec<f64> = pairs().map(|(a, b)| (a.value - b.value) / SQRT_2).collect();
    for (k, distance) in distances.into_iter().enumerate() {
        let own = &mut cause.parameters[k];
        own.u = own.u.hypot(distance);
        cause.covariance[k * stride + k] += distance * distance;
        if let Some(mean) = cause.mean_lost_motion.as_mut().filter(|_| k == 0) {
            mean.u = mean.u.hypot(distance);
        }
    }
    true
}

/// What takes the place of a cause if the other order shows nothing: what wanders where lost motion was seen, and the
/// other way round.
fn of_order(cause: &Cause, comparison: &Comparison<'_>) -> Vec<Wanderer> {
    if cause.effect.effect.is_lost_motion() {
        return with_time(comparison).collect();
    }
    vec![Wanderer::new(Who::Axis(comparison.axis()), With::Sides)]
}
