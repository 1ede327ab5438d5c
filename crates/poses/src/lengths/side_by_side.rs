//! What is wrong with lengths where both sides of approach share a pose.
//!
//! Lost motion makes the lengths of one side contradict those of the other. Of two sides one would leave at every step, now
//! this one, now that one, and the curve would jump between them with a small uncertainty; or a station that sees all of it
//! would seem interrupted between the sides; or all of it together would be refused. Whether something is wrong is then asked of
//! the lengths of each side by itself. With the same lengths, S and ν of poses that each side has for itself, S₀ and ν₀ of
//! common ones, all in the noise of the former and with all jumps that either way finds, the sides differ if
//!
//! ```text
//! F = (S₀ - S)/(ν₀ - ν) / (S/ν)     ~ F(ν₀ - ν, ν) if they do not
//! ```

use std::sync::Arc;

use trueaxis_leastsquares::f_upper_tail;
use trueaxis_multilateration::{Interruption, solve};
use trueaxis_screening::{Error, Jump, Screened, adjust_as_a_set, screen_within};

use crate::lengths::network::network_from_campaign;
use crate::lengths::returns::{AxisReturn, Returns};
use crate::settings::{Method, Settings};

/// Probability of sides that differ as much by chance.
const LEVEL: f64 = 1e-3;

/// The adjustment without what contradicts its own side, if less does so than in `together`, and the sides differ;
/// `ratios` are those of [`Returns`].
pub(crate) fn side_by_side(
    returns: &Returns<'_>,
    settings: &Settings,
    ratios: &[AxisReturn],
    together: Result<&Screened, &Error>,
) -> Option<Screened> {
    let (wrong, jumps) = match together {
        Ok(screened) => (count(screened), screened.jumps.as_slice()),
        Err(error) if error.is_contradiction() => (usize::MAX, Default::default()),
        Err(_) => return None,
    };
    // A diagnosis has lost motion among its causes.
    if wrong == 0 || settings.by_direction || settings.asks_why || !settings.robust {
        return None;
    }
    let Returns {
        campaign,
        lengths,
        network,
        ..
    } = *returns;
    let of_sides = network_from_campaign(campaign, lengths, true);
    let mut apart = of_sides.network;
    if apart.groups.len() == network.groups.len() {
        return None;
    }
    if settings.method != Method::Joint {
        apart.bodies = None;
    }
    let joined = returns.with(ratios);
    apart = Returns::new(campaign, lengths, (&apart, &of_sides.groups)).with(ratios);
    if let (Some(own), Some(of_all)) = (&mut apart.reflectors, &joined.reflectors) {
        Arc::make_mut(own).sigma_mm = of_all.sigma_mm;
    }
    let declared = campaign.instrument.declares_noise();
    let apart = adjust_as_a_set(
        &mut apart,
        |screened: &Screened| &screened.solution,
        |network| screen_within(network, declared, settings.most_removed),
    );
    let apart = apart.ok().filter(|apart| count(apart) < wrong)?;
    let joined = Screened::as_found(&joined, declared, &apart).ok()?;
    differ(&joined, &apart, jumps).then_some(joined)
}

/// How much is wrong.
fn count(screened: &Screened) -> usize {
    screened.removed.len() + screened.jumps.len() + screened.wandering.len()
}

/// Whether poses that both sides share leave more than those of each side by more than chance, and than these `jumps`
/// explain.
fn differ(joined: &Screened, apart: &Screened, jumps: &[Jump]) -> bool {
    let with_jumps = |screened: &Screened| {
        let mut network = screened.network.clone();
        network.noise = apart.network.noise;
        network.interruptions.extend(jumps.iter().map(|jump| {
            Interruption {
                station: jump.station,
                first_reading: screened
                    .kept
                    .partition_point(|&kept| kept < jump.first_reading),
            }
        }));
        network
            .interruptions
            .sort_unstable_by_key(|i| (i.first_reading, i.station));
        network.interruptions.dedup();
        solve(&network)
    };
    let (Ok(shared), Ok(own)) = (with_jumps(joined), with_jumps(apart)) else {
        return false;
    };
    let below = own.degrees_of_freedom() as f64;
    let above = shared.degrees_of_freedom() as f64 - below;
    let ratio = (shared.squares - own.squares) / above * below / own.squares;
    f_upper_tail(ratio, above, below) < LEVEL
}
