//! The groups of a network, eight at a time.
//!
//! The groups of a batch are consecutive and have equally many points. Their readings are put in slots
//! ([`crate::slots`]). A group without a reading for a slot has zero weight there: missing readings cost only space,
//! and a campaign measured by a plan has full slots.

use std::ops::Range;
use std::sync::Arc;

use trueaxis_leastsquares::{LANES, Lanes};

use crate::chunks::{chunks, in_parallel};
use crate::lane_vectors::{LaneVector, splat};
use crate::network::Network;
use crate::reflectors::contrast;
use crate::returns::LaneReturn;
use crate::slots::{Layout, SlotVisit, Slots};
use crate::state::POSE;
use crate::{Bodies, Error};

/// Up to eight groups.
#[derive(Debug)]
pub(crate) struct Batch {
    pub(crate) groups: Range<usize>,
    /// Points of each group.
    pub(crate) points: usize,
    /// The body that the points are tied to.
    pub(crate) body: Option<usize>,
    /// Whether the points of all groups have the same order on their body.
    are_alike: bool,
    /// Whether the points are on the bed.
    pub(crate) is_bed: bool,
    /// How the points return, where the groups do not all return alike.
    pub(crate) returns: Option<LaneReturn>,
    /// The first point of the group in each lane; lanes without a group repeat the last one.
    pub(crate) first_points: [usize; LANES],
    pub(crate) layout: Arc<Layout>,
    /// The incremental length of each slot, mm.
    pub(crate) lengths_mm: Vec<Lanes>,
    /// Factors on the variance of a reading's own noise, zero without a reading; empty where all are one.
    factors: Vec<Lanes>,
    /// The dead path of each slot; empty in a network without interruptions.
    pub(crate) zeros: Vec<[usize; LANES]>,
    /// Effect of a unit of each contrast on the constants of the reflectors, point after point; empty in a
    /// network without reflectors.
    pub(crate) contrasts: Vec<Lanes>,
    /// Number of readings.
    pub(crate) readings: usize,
}

/// All batches of a network, in the order of its groups.
pub(crate) fn batches(network: &Network) -> Vec<Batch> {
    let by_group = network.visits_by_group();
    let zeros = if network.interruptions.is_empty() {
        Vec::new()
    } else {
        network.zero_of_readings()
    };
    let kinds = network.groups.iter().enumerate();
    let is_bed = |g: usize| network.bed == Some(g);
    let kinds = kinds.map(|(g, points)| (points.len(), network.body_of(g), is_bed(g)));
    let ranges = side_by_side(kinds);
    let is_inflated = network
        .variance_factors
        .iter()
        .any(|f| f.total_cmp(&1.0).is_ne());
    let of_chunks = in_parallel(chunks(ranges.len()), |numbers| {
        let groups = &ranges[numbers];
        chunk(Slots::new(network, &by_group), &zeros, is_inflated, groups)
    });
    let mut batches = Vec::with_capacity(ranges.len());
    batches.extend(of_chunks.into_iter().flatten());
    batches
}

/// Ranges of up to eight consecutive groups of the same kind.
fn side_by_side<K: PartialEq>(kinds: impl IntoIterator<Item = K>) -> Vec<Range<usize>> {
    let mut ranges: Vec<Range<usize>> = Vec::new();
    let mut of_last = None;
    for (g, kind) in kinds.into_iter().enumerate() {
        let kind = Some(kind);
        match ranges.last_mut() {
            Some(last) if last.len() < LANES && of_last == kind => last.end = g + 1,
            _ => ranges.push(g..g + 1),
        }
        of_last = kind;
    }
    ranges
}

/// The batches of some ranges of groups.
fn chunk(
    mut slots: Slots<'_>,
    zero_of_readings: &[usize],
    is_inflated: bool,
    ranges: &[Range<usize>],
) -> Vec<Batch> {
    let network = slots.network;
    let batch = |groups: &Range<usize>| {
        slots.take(groups.clone());
        let layout = Arc::clone(&slots.layout);
        let first = network.groups[groups.start].start;
        let points = network.groups[groups.start].len();
        let last = groups.len() - 1;
        let count = layout.point_of_slot.len();
        let has_factors = is_inflated || slots.readings() < groups.len() * count;
        let mut batch = Batch {
            groups: groups.clone(),
            points,
            body: network.body_of(groups.start),
            are_alike: network.bodies.as_deref().is_none_or(|bodies| {
                let of_groups = &bodies.of_groups[groups.clone()];
                of_groups.iter().all(|g| g.places == of_groups[0].places)
            }),
            is_bed: network.bed == Some(groups.start),
            returns: LaneReturn::of(network, groups),
            first_points: std::array::from_fn(|lane| first + points * lane.min(last)),
            layout,
            lengths_mm: vec![Lanes::ZERO; count],
            factors: vec![Lanes::ZERO; if has_factors { count } else { 0 }],
            zeros: Vec::new(),
            contrasts: Vec::new(),
            readings: slots.readings(),
        };
        batch.take_contrasts(network);
        batch.take_numbers(&slots, zero_of_readings);
        batch
    };
    ranges.iter().map(batch).collect()
}

pub(crate) fn groups_of(batches: &[Batch], chunks: &[Range<usize>]) -> Vec<Range<usize>> {
    let of_chunk =
        |chunk: &Range<usize>| batches[chunk.start].groups.start..batches[chunk.end - 1].groups.end;
    chunks.iter().map(of_chunk).collect()
}

/// Checks that each free point is seen from at least `need` stations; points of bodies are exempt.
///
/// # Errors
/// [`Error::PointSeenTooRarely`].
pub(crate) fn check_seen(batches: &[Batch], need: usize) -> Result<(), Error> {
    let mut full: Option<&Arc<Layout>> = None;
    for batch in batches {
        // Where no reading is missing, batches of the same layout need only one check.
        let is_full = batch.is_full();
        if batch.body.is_some() {
            continue;
        }
        if is_full && full.is_some_and(|layout| Arc::ptr_eq(layout, &batch.layout)) {
            continue;
        }
        full = is_full.then_some(&batch.layout).or(full);
        for (lane, group) in batch.groups.clone().enumerate() {
            for point in 0..batch.points {
                let seen = batch.stations_that_see(lane, point);
                if seen < need {
                    return Err(Error::PointSeenTooRarely {
                        group,
                        point,
                        seen,
                        need,
                    });
                }
            }
        }
    }
    Ok(())
}

impl Batch {
    /// Takes lengths, variance factors and, if the network has interruptions, dead paths.
    fn take_numbers(&mut self, slots: &Slots<'_>, zero_of_readings: &[usize]) {
        let network = slots.network;
        if !zero_of_readings.is_empty() {
            for visit in &self.layout.visits {
                self.zeros.resize(visit.slots.end, [visit.station; LANES]);
            }
        }
        for lane in 0..LANES {
            for &(slot, i) in slots.places(lane.min(self.groups.len() - 1)) {
                self.lengths_mm[slot].0[lane] = network.readings[i].length_mm;
                if let Some(factor) = self.factors.get_mut(slot) {
                    factor.0[lane] = network.variance_factor(i);
                }
                if let Some(zeros) = self.zeros.get_mut(slot) {
                    zeros[lane] = zero_of_readings[i];
                }
            }
        }
    }

    fn take_contrasts(&mut self, network: &Network) {
        let Some(reflectors) = &network.reflectors else {
            return;
        };
        for point in 0..self.points {
            let of_lanes = self
                .first_points
                .map(|first| reflectors.of_points[first + point]);
            let contrasts = (0..reflectors.contrasts())
                .map(|m| Lanes::from_fn(|lane| contrast(of_lanes[lane], m)));
            self.contrasts.extend(contrasts);
        }
    }

    /// Effect of a unit of each contrast on the constant of the reflector at a point.
    #[inline(always)]
    pub(crate) fn contrasts_of(&self, point: usize) -> &[Lanes] {
        if self.contrasts.is_empty() {
            return &[];
        }
        let each = self.contrasts.len() / self.points;
        &self.contrasts[point * each..][..each]
    }

    #[inline(always)]
    pub(crate) fn slots(&self) -> usize {
        self.layout.point_of_slot.len()
    }

    /// Whether no reading is missing, and all variance factors are one.
    #[inline(always)]
    pub(crate) fn is_full(&self) -> bool {
        self.factors.is_empty()
    }

    /// Factors on the variance of a reading's own noise; zero without a reading.
    #[inline(always)]
    pub(crate) fn variance_factor(&self, slot: usize) -> Lanes {
        self.factors.get(slot).copied().unwrap_or(Lanes::splat(1.0))
    }

    /// Number of stations that see a point of the group in a lane.
    fn stations_that_see(&self, lane: usize, point: usize) -> usize {
        let sees = |visit: &&SlotVisit| {
            visit.slots.clone().any(|slot| {
                self.layout.point_of_slot[slot] == point && self.variance_factor(slot).0[lane] > 0.0
            })
        };
        // The visits of a station follow each other.
        let (mut seen, mut last) = (0, None);
        for visit in self.layout.visits.iter().filter(sees) {
            seen += usize::from(last.replace(visit.station) != Some(visit.station));
        }
        seen
    }

    /// What belongs to the place that a point of each group has on its body.
    #[inline(always)]
    pub(crate) fn of_places<'v>(
        &self,
        bodies: &Bodies,
        point: usize,
        vector: impl Fn(usize) -> &'v [f64],
    ) -> LaneVector {
        let of_groups = &bodies.of_groups[self.groups.clone()];
        let of = |lane: usize| vector(of_groups[lane.min(of_groups.len() - 1)].places[point]);
        if self.are_alike {
            let all = of(0);
            return splat(all[0], all[1], all[2]);
        }
        let part = |axis: usize| Lanes::from_fn(|lane| of(lane)[axis]);
        [part(0), part(1), part(2)]
    }

    #[inline(always)]
    pub(crate) fn own<'p, T>(&self, points: &'p [T]) -> &'p [T] {
        &points[self.first_points[0]..][..self.groups.len() * self.points]
    }

    /// Number of unknowns of each group.
    pub(crate) fn unknowns(&self) -> usize {
        match self.body {
            Some(_) => POSE,
            None => 3 * self.points,
        }
    }

    /// The group in a lane, and the number of its readings.
    pub(crate) fn number(&self, lane: usize) -> (usize, usize) {
        let lane = lane.min(self.groups.len() - 1);
        let read = (0..self.slots()).filter(|&slot| self.variance_factor(slot).0[lane] > 0.0);
        (self.groups.start + lane, read.count())
    }
}
