//! The groups of a network, eight at a time.
//!
//! The groups of a batch follow each other and have as many points each. Their readings are put in
//! *slots*: a slot is a station, the how manieth visit of the station to the group, and a point. A
//! group that lacks a reading has a zero weight in its slot, so that missing readings cost nothing but
//! space, and a campaign measured by a plan has full slots.

use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;
use trueaxis_leastsquares::{LANES, Lanes};

use crate::network::{Network, VisitsByGroup};

/// Up to eight groups.
pub(crate) struct Batch {
    pub(crate) groups: Range<usize>,
    /// Points of each group.
    pub(crate) points: usize,
    /// The first point of the group in each lane; lanes without a group repeat the last one.
    pub(crate) first_points: [usize; LANES],
    pub(crate) layout: Arc<Layout>,
    /// Of each slot the incremental length, mm, then of each the factor on the variance of a reading's
    /// own noise, zero without a reading; then the nominal places of the points, x y z of each, mm.
    numbers: Vec<Lanes>,
    /// The dead path of each slot; empty in a network without interruptions.
    pub(crate) zeros: Vec<[usize; LANES]>,
    /// Number of readings.
    pub(crate) readings: usize,
}

/// What slots a batch has; batches of a campaign measured by a plan share one.
#[derive(Debug, Default)]
pub(crate) struct Layout {
    keys: Vec<Key>,
    pub(crate) visits: Vec<SlotVisit>,
    /// The point within the group of each slot.
    pub(crate) point_of_slot: Vec<usize>,
}

/// The slots of a visit.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct SlotVisit {
    pub(crate) station: usize,
    pub(crate) slots: Range<usize>,
}

/// What tells slots apart, in their order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Key {
    station: usize,
    /// Visits of the station to the group before this one.
    ordinal: usize,
    point: usize,
    /// Readings of the point in the visit before this one.
    again: usize,
}

/// All batches of a network, in the order of its groups.
pub(crate) fn batches(network: &Network) -> Vec<Batch> {
    let by_group = network.visits_by_group();
    let zeros = if network.interruptions.is_empty() {
        Vec::new()
    } else {
        network.zero_of_readings()
    };
    let ranges = ranges(network);
    let pieces: Vec<_> = ranges
        .par_chunks(PIECE)
        .map(|piece| {
            let mut memory = Memory::default();
            let batch = |groups: &Range<usize>| {
                Batch::new(network, &by_group, &zeros, groups.clone(), &mut memory)
            };
            piece.iter().map(batch).collect::<Vec<_>>()
        })
        .collect();
    pieces.into_iter().flatten().collect()
}

/// Memory for one batch after the other.
#[derive(Default)]
struct Memory {
    /// The slots of all readings, group after group, and the readings.
    keys: Vec<(Key, usize)>,
    /// Where those of each group end.
    ends: Vec<usize>,
    slots: Vec<Key>,
    layout: Arc<Layout>,
}

/// Batches that are worth handing to a thread.
const PIECE: usize = 256;

/// Up to eight groups in a row with as many points each.
fn ranges(network: &Network) -> Vec<Range<usize>> {
    let mut ranges: Vec<Range<usize>> = Vec::with_capacity(network.groups.len() / LANES + 1);
    for (g, group) in network.groups.iter().enumerate() {
        match ranges.last_mut() {
            Some(last) if last.len() < LANES && network.groups[last.start].len() == group.len() => {
                last.end = g + 1;
            }
            _ => ranges.push(g..g + 1),
        }
    }
    ranges
}

impl Batch {
    fn new(
        network: &Network,
        by_group: &VisitsByGroup,
        zero_of_readings: &[usize],
        groups: Range<usize>,
        memory: &mut Memory,
    ) -> Self {
        memory.take_slots(network, by_group, &groups);
        let Memory {
            keys, ends, layout, ..
        } = memory;
        let (slots, last) = (layout.keys.len(), groups.len() - 1);
        let points = network.groups[groups.start].len();
        let mut batch = Self {
            points,
            first_points: std::array::from_fn(|lane| {
                network.groups[groups.start + lane.min(last)].start
            }),
            layout: Arc::clone(layout),
            numbers: vec![Lanes::ZERO; 2 * slots + 3 * points],
            zeros: Vec::new(),
            readings: keys.len(),
            groups,
        };
        if !zero_of_readings.is_empty() {
            let stations = layout.keys.iter().map(|key| [key.station; LANES]);
            batch.zeros = stations.collect();
        }
        for lane in 0..LANES {
            let group = lane.min(last);
            let first = group.checked_sub(1).map_or(0, |before| ends[before]);
            let mut own = keys[first..ends[group]].iter().peekable();
            for (slot, key) in layout.keys.iter().enumerate() {
                let Some(&(_, i)) = own.next_if(|(own, _)| own == key) else {
                    continue;
                };
                batch.numbers[slot].0[lane] = network.readings[i].length_mm;
                batch.numbers[slots + slot].0[lane] = network.variance_factor(i);
                if let Some(zeros) = batch.zeros.get_mut(slot) {
                    zeros[lane] = zero_of_readings[i];
                }
            }
            let nominal = &network.nominal_mm[batch.first_points[lane]..][..points];
            let nominal = nominal.iter().flat_map(|p| p.iter());
            for (x, value) in batch.numbers[2 * slots..].iter_mut().zip(nominal) {
                x.0[lane] = *value;
            }
        }
        batch
    }

    #[inline(always)]
    pub(crate) fn slots(&self) -> usize {
        self.layout.point_of_slot.len()
    }

    /// Incremental lengths of each slot, mm.
    #[inline(always)]
    pub(crate) fn lengths_mm(&self) -> &[Lanes] {
        &self.numbers[..self.slots()]
    }

    /// Factors on the variance of a reading's own noise; zero without a reading.
    #[inline(always)]
    pub(crate) fn variance_factors(&self) -> &[Lanes] {
        &self.numbers[self.slots()..2 * self.slots()]
    }

    /// Nominal places of the points, x y z of each, mm.
    #[inline(always)]
    pub(crate) fn nominal_mm(&self) -> &[Lanes] {
        &self.numbers[2 * self.slots()..]
    }

    /// Number of the group in a lane, and of its readings.
    pub(crate) fn number(&self, lane: usize) -> (usize, usize) {
        let lane = lane.min(self.groups.len() - 1);
        let read = self.variance_factors().iter().filter(|f| f.0[lane] > 0.0);
        (self.groups.start + lane, read.count())
    }
}

impl Memory {
    /// Takes the slots of some groups; makes another layout only if they differ from the ones before.
    fn take_slots(&mut self, network: &Network, by_group: &VisitsByGroup, groups: &Range<usize>) {
        self.keys.clear();
        self.ends.clear();
        self.slots.clear();
        for group in groups.clone() {
            let first = self.keys.len();
            append_keys(network, by_group.of(group), &mut self.keys);
            self.ends.push(self.keys.len());
            let own = &self.keys[first..];
            if !own.iter().map(|(key, _)| key).eq(&self.slots) {
                self.slots.extend(own.iter().map(|(key, _)| key));
                self.slots.sort_unstable();
                self.slots.dedup();
            }
        }
        if self.slots != self.layout.keys {
            self.layout = Arc::new(Layout {
                visits: slot_visits(&self.slots),
                point_of_slot: self.slots.iter().map(|key| key.point).collect(),
                keys: self.slots.clone(),
            });
        }
    }
}

/// Appends the readings of a group in the order of their slots.
fn append_keys(network: &Network, visits: &[usize], keys: &mut Vec<(Key, usize)>) {
    let first = keys.len();
    for (k, &v) in visits.iter().enumerate() {
        let visit = &network.visits[v];
        let same = |&&before: &&usize| network.visits[before].station == visit.station;
        let ordinal = visits[..k].iter().filter(same).count();
        for i in visit.readings.clone() {
            let point = network.readings[i].point;
            let before = &network.readings[visit.readings.start..i];
            let again = before.iter().filter(|r| r.point == point).count();
            let key = Key {
                station: visit.station,
                ordinal,
                point,
                again,
            };
            keys.push((key, i));
        }
    }
    keys[first..].sort_unstable();
}

fn slot_visits(slots: &[Key]) -> Vec<SlotVisit> {
    let mut visits: Vec<SlotVisit> = Vec::new();
    for (slot, key) in slots.iter().enumerate() {
        let goes_on = slot > 0 && {
            let before = &slots[slot - 1];
            (before.station, before.ordinal) == (key.station, key.ordinal)
        };
        match visits.last_mut() {
            Some(visit) if goes_on => visit.slots.end = slot + 1,
            _ => visits.push(SlotVisit {
                station: key.station,
                slots: slot..slot + 1,
            }),
        }
    }
    visits
}
