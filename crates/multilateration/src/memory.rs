//! Working memory of a pass over the batches of a network.

use std::sync::{Mutex, PoisonError};

use trueaxis_leastsquares::{BlockBatch, LaneSums, Lanes};

use crate::beams::Beams;
use crate::state::DATUM;
use crate::tie::Tie;

/// What stands beside the equations of the lengths, to choose among results that differ by a motion of the whole.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Constraints {
    None,
    /// Those of the datum.
    Datum,
}

impl Constraints {
    pub(crate) fn count(self) -> usize {
        match self {
            Self::None => 0,
            Self::Datum => DATUM,
        }
    }
}

/// Working memory, used for one batch after the other.
#[derive(Debug, Default)]
pub(crate) struct Memory {
    pub(crate) beams: Beams,
    /// `L⁻¹` of each visit, the rows of its triangle one after the other; and `L` of one.
    pub(crate) weights: Vec<Lanes>,
    pub(crate) factor: Vec<Lanes>,
    pub(crate) equations: BlockBatch,
    pub(crate) sums: LaneSums,
    pub(crate) tie: Tie,
}

/// Memory that one pass leaves for the next.
#[derive(Debug, Default)]
pub(crate) struct Memories(Mutex<Vec<Memory>>);

impl Memories {
    /// Lends memory to `work`; its contents are arbitrary.
    #[inline(always)]
    pub(crate) fn lend<T>(&self, work: impl FnOnce(&mut Memory) -> T) -> T {
        let pool = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let mut memory = pool().pop().unwrap_or_default();
        let result = work(&mut memory);
        pool().push(memory);
        result
    }
}
