//! The causes of the lengths that are named.

use trueaxis_multilateration::Noise;

use crate::engine::{Competed, Measured, Omnibus, Search, Suspect, only_wandering};
use crate::lengths::base::Base;
use crate::lengths::omnibus::omnibus;
use crate::lengths::unexplained::unexplained_part;
use crate::{Error, Unexplained};

/// Least share of the structure, disturbances aside, that named causes explain: a remainder removes no name, but a
/// small part of something else is no cause.
const LEAST: f64 = 0.25;

/// The named causes, the disturbances beside them, and what the model with both leaves.
pub(crate) struct Named<'a> {
    pub(crate) competed: Competed<Base<'a>>,
    pub(crate) after: Vec<Omnibus>,
    pub(crate) unexplained: Option<Unexplained>,
}

impl<'a> Named<'a> {
    /// With the tests of a model; `before` are those of the model with neither.
    fn tested(competed: Competed<Base<'a>>, before: &[Omnibus]) -> Self {
        Self {
            after: match competed.is_plain() {
                true => before.to_vec(),
                false => omnibus(&competed.base, &competed.search.adjusted),
            },
            competed,
            unexplained: None,
        }
    }

    fn is_left(&self) -> bool {
        self.after.iter().any(Omnibus::is_clear)
    }

    /// What is left, with the cause that comes closest to it and its share.
    fn left(&self, closest: Option<&(Suspect, f64)>) -> Unexplained {
        let Competed { base, search, .. } = &self.competed;
        unexplained_part(base, &search.adjusted, &self.after, closest)
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
    let mut named = Named::tested(model, before);
    let Search { found, left, .. } = &named.competed.search;
    let is_left = named.is_left();
    if !is_left && *left <= 0.0 {
        return Ok(named);
    }
    let explained: f64 = found.iter().map(|f| f.statistic).sum();
    let excesses = named.after.iter().map(|t| t.excess);
    let share = explained / (explained + excesses.fold(*left, f64::max));
    let closest = found.first().map(|f| (f.suspect.clone(), share));
    if closest.is_some() && share < LEAST {
        named = left_alone(base, plain, before)?;
        // Even if no single test is certain, what several effects share is there.
        named.unexplained = Some(named.left(closest.as_ref()));
    } else if is_left {
        named.unexplained = Some(named.left(None));
    }
    Ok(named)
}

/// The model without causes: disturbances, with the findings of the omnibus tests beside them as unexplained.
pub(crate) fn left_alone<'a>(
    base: &Base<'a>,
    plain: Noise,
    before: &[Omnibus],
) -> Result<Named<'a>, Error> {
    let mut model = only_wandering(base)?;
    if model.is_plain() {
        model.search.adjusted = base.adjust(Vec::new(), Some(plain))?;
    }
    let named = Named::tested(model, before);
    let unexplained = named.is_left().then(|| named.left(None));
    Ok(Named {
        unexplained,
        ..named
    })
}
