//! Lengths without gross errors, stations without lost counts, and the noise of what is left.
//!
//! In turn:
//!
//! 1. Lengths far from what the nominal positions let expect leave before the first adjustment.
//! 2. Redescending weights let go of lengths that stand out from their neighbours in time. In what is
//!    left, steps in the zero of a station are sought; a step that nothing else explains as well
//!    splits the station's occupation.
//! 3. Redescending weights let go of all far lengths.
//! 4. Data snooping (Baarda): the length whose test is largest leaves its group, the one that fits
//!    again comes back, one in a group at a time, until nothing changes. The level is that of all
//!    tests together.
//! 5. Lengths that nothing checks beside one that left have to leave, too.
//! 6. The noise is estimated from what is left; if the tests look different with it, 2 to 5 are
//!    repeated.
//! 7. A clean adjustment of the lengths that are left, all with full weight.
//!
//! A campaign without gross errors passes after one adjustment and its tests.

use trueaxis_multilateration::{Network, Settings};

use crate::Error;
use crate::guard::MOST_REMOVED;
use crate::screened::Screened;
use crate::search::Search;

/// Estimates of the noise, each followed by another look at the tests.
const MAX_NOISE_UPDATES: usize = 5;

/// Solves a network without its gross errors. `declared` says whether its noise is more than a
/// guess.
///
/// # Errors
/// Those of the adjustment; [`Error::TooManyGrossErrors`], [`Error::PartLost`] and
/// [`Error::Undecidable`] if too much would have to be removed or nothing tells what.
pub fn screen(network: &Network, declared: bool, settings: &Settings) -> Result<Screened, Error> {
    screen_within(network, declared, MOST_REMOVED, settings)
}

/// As [`screen`], where no more than a share `most_removed` of the readings may leave: a search that would take more away is
/// given up early.
///
/// # Errors
/// Those of [`screen`].
pub fn screen_within(
    network: &Network,
    declared: bool,
    most_removed: f64,
    settings: &Settings,
) -> Result<Screened, Error> {
    let work = || Search::new(network, declared, most_removed, settings);
    match screen_by(network, work()?) {
        // A zero that wanders far looks like many gross errors; cut in pieces it may be bearable.
        Err(
            Error::TooManyGrossErrors { .. } | Error::PartLost { .. } | Error::Undecidable { .. },
        ) => {
            let mut work = work()?;
            work.cuts_what_wanders = true;
            screen_by(network, work)
        }
        done => done,
    }
}

fn screen_by(network: &Network, mut work: Search<'_>) -> Result<Screened, Error> {
    for _ in 0..MAX_NOISE_UPDATES {
        work.clean()?;
        let mut screened = work.finished(network)?;
        work.go_on_from(&screened)?;
        if !work.suspicious()? {
            screened.removed = work.removed()?;
            screened.reliability = work.reliability(&screened.solution);
            return Ok(screened);
        }
    }
    let screened = work.finished(network)?;
    Ok(Screened {
        settled: false,
        ..screened
    })
}
