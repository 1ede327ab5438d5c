//! Lengths without gross errors, stations without lost counts, and the noise of what is left.
//!
//! In turn:
//!
//! 1. Lengths far from what the nominal positions predict are removed before the first adjustment.
//! 2. Redescending weights release lengths that stand out from their neighbours in time. Among the rest, jumps of the
//!    zero of a station are sought; a jump that nothing else explains as well splits the station's occupation.
//! 3. Redescending weights release all far lengths.
//! 4. Data snooping (Baarda): in each group the length with the largest test is removed, or else the one that fits
//!    again comes back, one at a time, until nothing changes. The level is that of all tests together.
//! 5. Lengths that nothing checks without those that were removed are removed, too.
//! 6. The noise is estimated from the rest; if the tests ask for changes with it, 2 to 5 are repeated.
//! 7. If lengths of a station, a target or a part of the campaign scatter more than the others, the search is repeated
//!    with less weight for these; what it leaves is taken if fewer lengths are removed.
//! 8. A final adjustment of the remaining lengths, all with full weight.
//!
//! A campaign without gross errors passes after one adjustment and its tests.

use trueaxis_multilateration::{Network, Noise};

use crate::Error;
use crate::estimate_noise::level;
use crate::guard::MOST_REMOVED;
use crate::screened::Screened;
use crate::search::Search;

/// Ratio of the repeatability to the noise of a length where the repeatability is guessed to be the larger part.
const MUCH_LARGER: f64 = 10.0;

/// A larger repeatability must be declared, mm: otherwise a mistake is more likely.
const MOST_RETURN_MM: f64 = 0.01;

/// Most estimates of the noise, each followed by new tests.
const MAX_NOISE_UPDATES: usize = 5;

/// Solves a network without its gross errors. `declared` says whether its noise is more than a
/// guess.
///
/// # Errors
/// Those of the adjustment; [`Error::TooManyGrossErrors`], [`Error::PartLost`] and [`Error::Undecidable`] if too much
/// would have to be removed or nothing shows which.
pub fn screen(network: &Network, declared: bool) -> Result<Screened, Error> {
    screen_within(network, declared, MOST_REMOVED)
}

/// As [`screen`], where at most the share `most_removed` of the readings may be removed: a search that would remove
/// more is given up early.
pub fn screen_within(
    network: &Network,
    declared: bool,
    most_removed: f64,
) -> Result<Screened, Error> {
    screen_unless(network, declared, most_removed, || None)
}

/// As [`screen_within`]; where something contradicts the others, `explained` is asked before it is sought.
pub fn screen_unless(
    network: &Network,
    declared: bool,
    most_removed: f64,
    explained: impl Fn() -> Option<Screened>,
) -> Result<Screened, Error> {
    let tried = |noise: Noise| {
        let work = |network: &Network| Search::new(network, noise, declared, most_removed);
        let mut first = work(network)?;
        if first.suspicious()?
            && let Some(found) = explained()
        {
            return Ok(found);
        }
        let found = screen_by(network, &mut first);
        // By the noise of all, many lengths that only scatter more are gross errors.
        if found
            .as_ref()
            .map_or_else(Error::is_contradiction, |found| found.changes() > 0)
            && let Some(weighed) = first.weighed(network)?
            && let Ok(of_weighed) = screen_by(&weighed, &mut work(&weighed)?)
            && found
                .as_ref()
                .map_or(true, |found| of_weighed.changes() < found.changes())
        {
            return Screened::as_found(network, declared, &of_weighed);
        }
        match found {
            // A zero that wanders far looks like many gross errors; split it may be acceptable.
            Err(error) if error.is_contradiction() => {
                let mut work = work(network)?;
                work.splits_what_wanders = true;
                screen_by(network, &mut work)
            }
            done => done,
        }
    };
    if declared {
        return tried(network.noise);
    }
    // The guess covers bad returns: lengths of a visit that are off together are then no gross errors.
    let alike = level(network.noise);
    let returns_badly = Noise {
        repeatability_mm: MUCH_LARGER * alike.repeatability_mm,
        ..alike
    };
    match tried(alike) {
        Err(error) if error.is_contradiction() => {
            tried(returns_badly).ok().filter(returns).ok_or(error)
        }
        done => done,
    }
}

/// Whether an undeclared repeatability may be as large as that.
fn returns(screened: &Screened) -> bool {
    screened.noise.repeatability.sigma_mm < MOST_RETURN_MM
}

/// Whether nothing contradicts the others in an adjustment, in the noise that it shows.
pub fn is_clean(adjusted: &Screened) -> bool {
    let network = &adjusted.network;
    let sought = || {
        let mut work = Search::new(network, network.noise, true, MOST_REMOVED)?;
        work.go_on_from(adjusted)?;
        work.suspicious()
    };
    sought().is_ok_and(|is_suspicious| !is_suspicious)
}

fn screen_by(network: &Network, work: &mut Search) -> Result<Screened, Error> {
    for _ in 0..MAX_NOISE_UPDATES {
        work.clean()?;
        let mut screened = work.finished(network)?;
        work.go_on_from(&screened)?;
        if !work.suspicious()? {
            screened.removed = work.removed()?;
            screened.tests = work.tests_at(&screened.solution);
            return Ok(screened);
        }
    }
    let screened = work.finished(network)?;
    Ok(Screened {
        converged: false,
        ..screened
    })
}
