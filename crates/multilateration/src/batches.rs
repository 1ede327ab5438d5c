//! The groups of a network, eight at a time.
//!
//! The groups of a batch follow each other and have as many points each. Their readings are put in
//! *slots*: a slot is a station, the how manieth visit of the station to the group, and a point. A
//! group that lacks a reading has a zero weight in its slot, so that missing readings cost nothing but
//! space, and a campaign measured by a plan has full slots.

use std::ops::Range;

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
    pub(crate) visits: Vec<SlotVisit>,
    /// The point within the group of each slot.
    pub(crate) point_of_slot: Vec<usize>,
    /// Incremental lengths of each slot, mm.
    pub(crate) lengths_mm: Vec<Lanes>,
    /// Factors on the variance of a reading's own noise; zero without a reading.
    pub(crate) variance_factors: Vec<Lanes>,
    /// The dead path of each slot; empty in a network without interruptions.
    pub(crate) zeros: Vec<[usize; LANES]>,
    /// Nominal places of the points, x y z of each, mm.
    pub(crate) nominal_mm: Vec<Lanes>,
    /// Number of readings.
    pub(crate) readings: usize,
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
    let batches = ranges(network).into_par_iter();
    batches
        .with_min_len(MIN_BATCHES)
        .map(|groups| Batch::new(network, &by_group, &zeros, groups))
        .collect()
}

/// Batches that are worth handing to a thread.
const MIN_BATCHES: usize = 256;

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
    ) -> Self {
        let mut readings = Vec::new();
        let mut slots: Vec<Key> = Vec::new();
        for group in groups.clone() {
            let own = keys(network, by_group.of(group));
            if !own.iter().map(|(key, _)| key).eq(&slots) {
                slots.extend(own.iter().map(|(key, _)| key));
                slots.sort_unstable();
                slots.dedup();
            }
            readings.push(own);
        }
        let last = groups.len() - 1;
        let lane_of = |lane: usize| lane.min(last);
        let mut batch = Self {
            points: network.groups[groups.start].len(),
            first_points: std::array::from_fn(|lane| {
                network.groups[groups.start + lane_of(lane)].start
            }),
            visits: slot_visits(&slots),
            point_of_slot: slots.iter().map(|key| key.point).collect(),
            lengths_mm: vec![Lanes::ZERO; slots.len()],
            variance_factors: vec![Lanes::ZERO; slots.len()],
            zeros: Vec::new(),
            nominal_mm: Vec::new(),
            readings: readings.iter().map(Vec::len).sum(),
            groups,
        };
        if !zero_of_readings.is_empty() {
            let stations = slots.iter().map(|key| [key.station; LANES]);
            batch.zeros = stations.collect();
        }
        for lane in 0..LANES {
            let mut own = readings[lane_of(lane)].iter().peekable();
            for (slot, key) in slots.iter().enumerate() {
                let Some(&(_, i)) = own.next_if(|(own, _)| own == key) else {
                    continue;
                };
                batch.lengths_mm[slot].0[lane] = network.readings[i].length_mm;
                batch.variance_factors[slot].0[lane] = network.variance_factor(i);
                if let Some(zeros) = batch.zeros.get_mut(slot) {
                    zeros[lane] = zero_of_readings[i];
                }
            }
        }
        for point in 0..batch.points {
            for axis in 0..3 {
                let of_lane =
                    |lane: usize| network.nominal_mm[batch.first_points[lane] + point][axis];
                batch.nominal_mm.push(Lanes::from_fn(of_lane));
            }
        }
        batch
    }

    /// Number of the group in a lane, and of its readings.
    pub(crate) fn number(&self, lane: usize) -> (usize, usize) {
        let lane = lane.min(self.groups.len() - 1);
        let read = self.variance_factors.iter().filter(|f| f.0[lane] > 0.0);
        (self.groups.start + lane, read.count())
    }
}

/// The readings of a group in the order of their slots.
fn keys(network: &Network, visits: &[usize]) -> Vec<(Key, usize)> {
    let mut keys: Vec<(Key, usize)> = Vec::new();
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
    keys.sort_unstable();
    keys
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
