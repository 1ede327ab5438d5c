//! The records of an axis that are worked on side by side.
//!
//! Each stands in the lane that its group has in its batch, so that the errors of its points come from the
//! batch as a whole ([`crate::point_noise`]). Eight at a time they fill the widest registers; the matrices
//! of one are too small for that.

use std::ops::Range;

use trueaxis_leastsquares::{LANES, Lanes, side_by_side};

use crate::axis_data::Record;

/// Up to eight records whose targets have the same places in their groups.
#[derive(Debug, Clone)]
pub(crate) struct Chunk {
    /// The groups of the batch.
    pub(crate) groups: Range<usize>,
    /// The record in each lane.
    lanes: [Option<usize>; LANES],
    /// Of the targets in their group.
    pub(crate) places: Vec<usize>,
}

impl Chunk {
    fn new(groups: Range<usize>, record: &Record) -> Self {
        Self {
            groups,
            lanes: [None; LANES],
            places: record.places().collect(),
        }
    }

    /// Lanes that have a record, and its number.
    pub(crate) fn records(&self) -> impl Iterator<Item = (usize, usize)> {
        let lanes = self.lanes.iter().enumerate();
        lanes.filter_map(|(lane, &record)| record.map(|record| (lane, record)))
    }

    /// Number of coordinates of the targets.
    pub(crate) fn coordinates(&self) -> usize {
        3 * self.places.len()
    }

    /// Puts a matrix of each record side by side, its elements as they lie: so many. Lanes without a record
    /// have zeros.
    #[inline(always)]
    pub(crate) fn take<'m>(
        &self,
        length: usize,
        of_record: impl Fn(usize) -> &'m [f64],
        lanes: &mut Vec<Lanes>,
    ) {
        let mut slices: [&[f64]; LANES] = [&[]; LANES];
        for (slice, record) in slices.iter_mut().zip(self.lanes) {
            if let Some(record) = record {
                *slice = of_record(record);
            }
        }
        side_by_side(slices, length, lanes);
    }
}

/// All records in chunks, for these batches of groups.
pub(crate) fn chunks(records: &[Record], batches: &[Range<usize>]) -> Vec<Chunk> {
    let mut chunks: Vec<Chunk> = Vec::new();
    for (i, record) in records.iter().enumerate() {
        let batch = &batches[batch_of(record.group, batches)];
        let lane = record.group - batch.start;
        let fits = |last: &Chunk| {
            last.groups == *batch
                && last.lanes[lane].is_none()
                && record.places().eq(last.places.iter().copied())
        };
        if !chunks.last().is_some_and(fits) {
            chunks.push(Chunk::new(batch.clone(), record));
        }
        if let Some(last) = chunks.last_mut() {
            last.lanes[lane] = Some(i);
        }
    }
    chunks
}

/// The batch of a group.
pub(crate) fn batch_of(group: usize, batches: &[Range<usize>]) -> usize {
    batches.partition_point(|batch| batch.end <= group)
}
