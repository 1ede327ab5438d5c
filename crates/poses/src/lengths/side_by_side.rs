//! Gross errors where both sides of approach share a pose.
//!
//! Lost motion makes the lengths of one side contradict those of the other; of two sides one would leave at every step, now
//! this one, now that one, and the curve would jump between them with a small uncertainty. Whether a length is wrong is then
//! asked of the lengths of its own side. With the same lengths, S and ν of poses that each side has for itself, S₀ and ν₀ of
//! common ones, all in the noise of the former, the sides differ if
//!
//! ```text
//! F = (S₀ - S)/(ν₀ - ν) / (S/ν)     ~ F(ν₀ - ν, ν) if they do not
//! ```

use std::sync::Arc;

use trueaxis_campaign::{Campaign, Lengths};
use trueaxis_leastsquares::f_upper_tail;
use trueaxis_multilateration::{Network, solve};
use trueaxis_screening::{Screened, screen_within};

use crate::lengths::network::network_from_campaign;
use crate::settings::{Method, Settings};

/// Probability of sides that differ as much by chance.
const LEVEL: f64 = 1e-3;

/// The adjustment of `network` without the lengths that contradict others of their own side, if fewer leave so than left
/// in `together`, and the sides differ.
pub(crate) fn side_by_side(
    campaign: &Campaign,
    lengths: &Lengths,
    settings: &Settings,
    network: &Network,
    together: &Screened,
) -> Option<Screened> {
    // A diagnosis has lost motion among its causes.
    if together.removed.is_empty() || settings.by_direction || settings.asks_why {
        return None;
    }
    let mut apart = network_from_campaign(campaign, lengths, true).network;
    if apart.groups.len() == network.groups.len() {
        return None;
    }
    if settings.method != Method::Joint {
        apart.bodies = None;
    }
    if let (Some(own), Some(of_all)) = (&mut apart.reflectors, &network.reflectors) {
        Arc::make_mut(own).sigma_mm = of_all.sigma_mm;
    }
    let declared = campaign.instrument.declares_noise();
    let apart = screen_within(&apart, declared, settings.most_removed).ok()?;
    if apart.removed.len() >= together.removed.len() {
        return None;
    }
    let joined = Screened::as_found(network, declared, &apart).ok()?;
    differ(&joined.network, &apart).then_some(joined)
}

/// Whether poses that both sides share leave more than those of each side by more than chance.
fn differ(joined: &Network, apart: &Screened) -> bool {
    let joined = Network {
        noise: apart.network.noise,
        ..joined.clone()
    };
    let Ok(shared) = solve(&joined) else {
        return false;
    };
    let below = apart.solution.degrees_of_freedom() as f64;
    let above = shared.degrees_of_freedom() as f64 - below;
    let ratio = (shared.squares - apart.solution.squares) / above * below / apart.solution.squares;
    f_upper_tail(ratio, above, below) < LEVEL
}
