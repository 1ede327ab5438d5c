//! The groups of a network, eight at a time.
//!
//! The groups of a batch follow each other and have as many points each. Their readings are put in
//! slots ([`crate::slots`]). A group that lacks a reading has a zero weight in its slot, so that missing
//! readings cost nothing but space, and a campaign measured by a plan has full slots.

use std::ops::Range;
use std::sync::Arc;

use trueaxis_leastsquares::{LANES, Lanes};

use crate::Error;
use crate::network::{Network, VisitsByGroup};
use crate::noise::factor_len;
use crate::passes::{in_parallel, pieces};
use crate::slots::{Layout, Slots};

/// Up to eight groups.
pub(crate) struct Batch {
    pub(crate) groups: Range<usize>,
    /// Points of each group.
    pub(crate) points: usize,
    /// The first point of the group in each lane; lanes without a group repeat the last one.
    pub(crate) first_points: [usize; LANES],
    pub(crate) layout: Arc<Layout>,
    /// The numbers of several batches, and where those of this one start: of each slot the incremental
    /// length, mm, and behind them, if they are not all one, the factors on the variance of a reading's
    /// own noise, zero without a reading.
    numbers: Arc<Vec<Lanes>>,
    first_number: usize,
    has_factors: bool,
    /// The dead path of each slot; empty in a network without interruptions.
    pub(crate) zeros: Vec<[usize; LANES]>,
    /// Number of readings.
    pub(crate) readings: usize,
}

/// All batches of a network, in the order of its groups; each point must be seen from at least
/// `stations_per_point` stations.
///
/// # Errors
/// [`Error::PointSeenTooRarely`].
pub(crate) fn batches(network: &Network, stations_per_point: usize) -> Result<Vec<Batch>, Error> {
    let by_group = network.visits_by_group();
    let zeros = if network.interruptions.is_empty() {
        Vec::new()
    } else {
        network.zero_of_readings()
    };
    let ranges = ranges(network);
    let of_pieces = in_parallel(pieces(ranges.len()), |numbers| {
        let groups = &ranges[numbers];
        piece((network, &by_group), &zeros, stations_per_point, groups)
    });
    let mut batches = Vec::with_capacity(ranges.len());
    for piece in of_pieces {
        batches.append(&mut piece?);
    }
    Ok(batches)
}

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

/// The batches of some ranges of groups.
fn piece(
    (network, by_group): (&Network, &VisitsByGroup),
    zero_of_readings: &[usize],
    stations_per_point: usize,
    ranges: &[Range<usize>],
) -> Result<Vec<Batch>, Error> {
    let (mut slots, mut numbers) = (Slots::new(stations_per_point), Vec::new());
    let none = Arc::new(Vec::new());
    let batch = |groups: &Range<usize>| {
        slots.take(network, by_group, groups.clone())?;
        let layout = Arc::clone(slots.layout());
        let first = network.groups[groups.start].start;
        let points = network.groups[groups.start].len();
        let last = groups.len() - 1;
        let mut batch = Batch {
            groups: groups.clone(),
            points,
            first_points: std::array::from_fn(|lane| first + points * lane.min(last)),
            layout,
            numbers: Arc::clone(&none),
            first_number: numbers.len(),
            has_factors: slots.readings() < groups.len() * slots.layout().point_of_slot.len()
                || !network.variance_factors.is_empty(),
            zeros: Vec::new(),
            readings: slots.readings(),
        };
        batch.append_numbers(network, &slots, &mut numbers);
        if !zero_of_readings.is_empty() {
            batch.take_zeros(&slots, zero_of_readings);
        }
        Ok(batch)
    };
    let mut batches: Vec<Batch> = ranges.iter().map(batch).collect::<Result<_, Error>>()?;
    let numbers = Arc::new(numbers);
    for batch in &mut batches {
        batch.numbers = Arc::clone(&numbers);
    }
    Ok(batches)
}

impl Batch {
    fn append_numbers(&self, network: &Network, slots: &Slots, numbers: &mut Vec<Lanes>) {
        let (first, count) = (numbers.len(), self.slots());
        let each = if self.has_factors { 2 } else { 1 };
        numbers.resize(first + each * count, Lanes::ZERO);
        let (lengths_mm, factors) = numbers[first..].split_at_mut(count);
        for lane in 0..LANES {
            for &(slot, i) in slots.places(lane.min(self.groups.len() - 1)) {
                lengths_mm[slot].0[lane] = network.readings[i].length_mm;
                if let Some(factor) = factors.get_mut(slot) {
                    factor.0[lane] = network.variance_factor(i);
                }
            }
        }
    }

    fn take_zeros(&mut self, slots: &Slots, zero_of_readings: &[usize]) {
        for visit in &self.layout.visits {
            self.zeros.resize(visit.slots.end, [visit.station; LANES]);
        }
        for lane in 0..LANES {
            for &(slot, i) in slots.places(lane.min(self.groups.len() - 1)) {
                self.zeros[slot][lane] = zero_of_readings[i];
            }
        }
    }

    #[inline(always)]
    pub(crate) fn slots(&self) -> usize {
        self.layout.point_of_slot.len()
    }

    #[inline(always)]
    fn numbers(&self) -> &[Lanes] {
        &self.numbers[self.first_number..]
    }

    /// Incremental lengths of each slot, mm.
    #[inline(always)]
    pub(crate) fn lengths_mm(&self) -> &[Lanes] {
        &self.numbers()[..self.slots()]
    }

    /// Factors on the variance of a reading's own noise; zero without a reading.
    #[inline(always)]
    pub(crate) fn variance_factor(&self, slot: usize) -> Lanes {
        if self.has_factors {
            self.numbers()[self.slots() + slot]
        } else {
            Lanes::splat(1.0)
        }
    }

    /// Whether the weights of another batch are its own, if noise is the same for all beams.
    pub(crate) fn is_weighted_as(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.layout, &other.layout) && !self.has_factors && !other.has_factors
    }

    /// Number of weights: the triangles of all visits.
    pub(crate) fn weights(&self) -> usize {
        let visits = self.layout.visits.iter();
        visits.map(|visit| factor_len(visit.slots.len())).sum()
    }

    /// Number of the group in a lane, and of its readings.
    pub(crate) fn number(&self, lane: usize) -> (usize, usize) {
        let lane = lane.min(self.groups.len() - 1);
        let read = (0..self.slots()).filter(|&slot| self.variance_factor(slot).0[lane] > 0.0);
        (self.groups.start + lane, read.count())
    }
}
