//! What is wrong with lengths where both sides of approach share a pose.
//!
//! Lost motion makes the lengths of one side contradict those of the other. At every step one side would be removed, now
//! this one, now that one, and the curve would jump between them with a small uncertainty; or a station that sees all of
//! it would seem interrupted between the sides; or the whole would be refused. The lengths of each side are therefore
//! searched by themselves. With the same lengths, S and ν of poses that each side has for itself, S₀ and ν₀ of common
//! ones, all in the noise of the former and with all jumps that either way finds, the sides differ if
//!
//! ```text
//! F = (S₀ - S)/(ν₀ - ν) / (S/ν)     ~ F(ν₀ - ν, ν) if they do not
//! ```

use std::sync::Arc;

use trueaxis_campaign::{Campaign, Lengths};
use trueaxis_leastsquares::f_upper_tail;
use trueaxis_multilateration::{Interruption, Network, solve};
use trueaxis_screening::{
    Axes, AxisReturn, Error, Screened, Sweep, adjust_as_a_set, is_clean, screen_within,
};

use crate::lengths::network::network_from_campaign;
use crate::lengths::returns::axes_of;
use crate::settings::{Method, Settings};

/// Probability of sides that differ as much by chance.
const LEVEL: f64 = 1e-3;

/// The adjustment without what contradicts its own side, if less does so than in `together`, and the sides differ;
/// `ratios` are those of the axes.
pub(crate) fn side_by_side(
    measured: (&Campaign, &Lengths),
    axes: &Axes<'_>,
    settings: &Settings,
    (ratios, together): (&[AxisReturn], Result<&Screened, &Error>),
) -> Option<Screened> {
    let (wrong, jumps) = match together {
        Ok(screened) => (count(screened), screened.jumps.as_slice()),
        Err(error) if error.is_contradiction() => (usize::MAX, Default::default()),
        Err(_) => return None,
    };
    if wrong == 0 {
        return None;
    }
    let of_sides = of_sides(measured, axes, settings, ratios, |network| {
        let apart = screen_within(network, axes.declared, axes.most_removed);
        apart.ok().filter(|apart| count(apart) < wrong)
    });
    let (joined, apart) = of_sides?;
    let jumps = jumps.iter().map(|jump| (jump.station, jump.first_reading));
    differ(&joined, &apart, &jumps.collect::<Vec<_>>()).then_some(joined)
}

/// The same where nothing contradicts its own side, and axes return as usual: a search in common poses would be in
/// vain. The sides must differ even if the zero of any station jumps from sweep to sweep.
pub(crate) fn sides_alone(
    measured: (&Campaign, &Lengths),
    axes: &Axes<'_>,
    settings: &Settings,
) -> Option<Screened> {
    let of_sides = of_sides(measured, axes, settings, &[], |network| {
        Screened::plain(network, axes.declared).ok()
    });
    let (joined, apart) = of_sides?;
    let first = |sweep: &Sweep| &joined.network.visits[sweep.visits[0]];
    let starts = axes.sweeps.iter().map(first).collect::<Vec<_>>();
    let of_station = |station: usize| {
        let own = starts.iter().filter(|visit| visit.station == station);
        let jumps = own.skip(1).map(|visit| (station, visit.readings.start));
        jumps.collect::<Vec<_>>()
    };
    let mut stations = 0..joined.network.stations.len();
    let is_all = differ(&joined, &apart, &[])
        && is_clean(&apart)
        && stations.all(|station| differ(&joined, &apart, &of_station(station)))
        && axes.return_as_usual(&joined);
    is_all.then_some(joined)
}

/// The adjustment in common poses of what `adjust` leaves of the lengths in poses of each side, and that one.
fn of_sides(
    (campaign, lengths): (&Campaign, &Lengths),
    axes: &Axes<'_>,
    settings: &Settings,
    ratios: &[AxisReturn],
    adjust: impl Fn(&Network) -> Option<Screened>,
) -> Option<(Screened, Screened)> {
    // A diagnosis has lost motion among its causes.
    if settings.by_direction || settings.asks_why || !settings.robust {
        return None;
    }
    let joined = axes.with(ratios);
    let of_sides = network_from_campaign(campaign, lengths, true);
    let mut apart = of_sides.network;
    if apart.groups.len() == joined.groups.len() {
        return None;
    }
    if settings.method != Method::Joint {
        apart.bodies = None;
    }
    apart.noise = joined.noise;
    let of_both = (&apart, &of_sides.groups[..]);
    apart = axes_of((campaign, lengths), of_both, settings).with(ratios);
    if let (Some(own), Some(of_all)) = (&mut apart.reflectors, &joined.reflectors) {
        Arc::make_mut(own).sigma_mm = of_all.sigma_mm;
    }
    let apart = adjust_as_a_set(
        &mut apart,
        |screened: &Screened| &screened.solution,
        |network| adjust(network).ok_or(()),
    );
    let apart = apart.ok()?;
    let joined = Screened::as_found(&joined, axes.declared, &apart).ok()?;
    Some((joined, apart))
}

/// How much is wrong.
fn count(screened: &Screened) -> usize {
    screened.changes() + screened.wandering.len()
}

/// Whether poses that both sides share leave more than those of each side by more than chance, and than these `jumps`
/// (stations, and the first readings after them) explain.
fn differ(joined: &Screened, apart: &Screened, jumps: &[(usize, usize)]) -> bool {
    let with_jumps = |screened: &Screened| {
        let mut network = screened.network.clone();
        network.noise = apart.network.noise;
        let jumps = jumps.iter().map(|&(station, first)| Interruption {
            station,
            first_reading: screened.kept.partition_point(|&kept| kept < first),
        });
        network.interruptions.extend(jumps);
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
