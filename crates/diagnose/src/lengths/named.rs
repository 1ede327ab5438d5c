//! The causes of the lengths that are named.

use trueaxis_multilateration::Noise;

use crate::engine::{Competed, Found, JudgedDisturbance, Omnibus, only_wandering};
use crate::lengths::adjusted::Adjusted;
use crate::lengths::base::Base;
use crate::lengths::omnibus::omnibus;
use crate::lengths::unexplained::unexplained_part;
use crate::{Error, Unexplained};

/// Least share of the structure, disturbances aside, that named causes explain: a remainder removes no name, but a
/// small part of something else is no cause.
const LEAST: f64 = 0.25;

/// The named causes, the model with them and the disturbances beside them, and what they leave.
pub(crate) struct Named<'a> {
    /// The lengths, with the disturbances in their covariance.
    pub(crate) base: Base<'a>,
    pub(crate) found: Vec<Found>,
    pub(crate) wandering: Vec<JudgedDisturbance>,
    pub(crate) adjusted: Adjusted,
    pub(crate) after: Vec<Omnibus>,
    pub(crate) unexplained: Option<Unexplained>,
}

impl Named<'_> {
    pub(crate) fn is_plain(&self) -> bool {
        self.found.is_empty() && self.wandering.is_empty()
    }
}

/// Names the causes of a model if they explain enough of the structure beside the disturbances, otherwise none.
/// `before` are the tests of the model without causes, in the noise `plain`.
pub(crate) fn named<'a>(
    base: &Base<'a>,
    model: Competed<Base<'a>>,
    plain: Noise,
    before: &[Omnibus],
) -> Result<Named<'a>, Error> {
    let Competed {
        base: here,
        search,
        wandering,
    } = model;
    let mut named = Named {
        after: match search.found.is_empty() && wandering.is_empty() {
            true => before.to_vec(),
            false => omnibus(&here, &search.adjusted),
        },
        base: here,
        found: search.found,
        wandering,
        adjusted: search.adjusted,
        unexplained: None,
    };
    let is_left = named.after.iter().any(Omnibus::is_clear);
    if !is_left && search.left <= 0.0 {
        return Ok(named);
    }
    let explained: f64 = named.found.iter().map(|f| f.statistic).sum();
    let excesses = named.after.iter().map(|t| t.excess);
    let share = explained / (explained + excesses.fold(search.left, f64::max));
    let closest = named.found.first().map(|f| (f.suspect.clone(), share));
    if closest.is_some() && share < LEAST {
        named = left_alone(base, plain, before)?;
        // Even if no single test is certain, what several effects share is there.
        let part = unexplained_part(&named.base, &named.adjusted, &named.after, closest.as_ref());
        named.unexplained = Some(part);
    } else if is_left {
        let part = unexplained_part(&named.base, &named.adjusted, &named.after, None);
        named.unexplained = Some(part);
    }
    Ok(named)
}

/// The model without causes: disturbances, with the findings of the omnibus tests beside them as unexplained.
pub(crate) fn left_alone<'a>(
    base: &Base<'a>,
    plain: Noise,
    before: &[Omnibus],
) -> Result<Named<'a>, Error> {
    let model = only_wandering(base)?;
    let is_plain = model.wandering.is_empty();
    let adjusted = match is_plain {
        true => base.adjust(Vec::new(), Some(plain))?,
        false => model.search.adjusted,
    };
    let after = match is_plain {
        true => before.to_vec(),
        false => omnibus(&model.base, &adjusted),
    };
    let is_left = after.iter().any(Omnibus::is_clear);
    Ok(Named {
        found: Vec::new(),
        unexplained: is_left.then(|| unexplained_part(&model.base, &adjusted, &after, None)),
        base: model.base,
        wandering: model.wandering,
        adjusted,
        after,
    })
}
