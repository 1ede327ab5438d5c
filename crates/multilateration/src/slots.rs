//! The places of the readings of groups in their batch.
//!
//! A *slot* is a station, the index of its visit to the group, and a point. The slots of a batch are all those that
//! any of its groups has. Most groups of a campaign are measured by one plan: the places of the readings of the first
//! are found, and those of the others are only compared with them.

use std::ops::Range;
use std::sync::Arc;

use crate::network::Network;
use crate::noise::factor_len;

/// The slots of a batch; batches of a campaign measured by a plan share one layout.
#[derive(Debug, Default)]
pub(crate) struct Layout {
    pub(crate) visits: Vec<SlotVisit>,
    /// The point within the group of each slot.
    pub(crate) point_of_slot: Vec<usize>,
    /// Number of weights: the triangles of all visits.
    pub(crate) weights: usize,
}

impl Layout {
    pub(crate) fn visit_of(&self, slot: usize) -> usize {
        self.visits.partition_point(|visit| visit.slots.end <= slot)
    }

    /// The readings of a visit in the order of their slots, after the index of the visit; `None` without readings.
    pub(crate) fn in_order(
        &self,
        places: &[(usize, usize)],
    ) -> Option<(usize, Vec<(usize, usize)>)> {
        let mut places = places.to_vec();
        places.sort_unstable();
        let &(first, _) = places.first()?;
        Some((self.visit_of(first), places))
    }
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct SlotVisit {
    pub(crate) station: usize,
    pub(crate) slots: Range<usize>,
}

/// What distinguishes slots, in their order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Key {
    station: usize,
    /// Earlier visits of the station to the group.
    ordinal: usize,
    point: usize,
    /// Earlier readings of the point in the visit.
    again: usize,
}

/// The slots of a batch, for one batch after the other.
#[derive(Debug)]
pub(crate) struct Slots<'n> {
    pub(crate) network: &'n Network,
    /// Its visits by group.
    by_group: &'n [Vec<usize>],
    /// Of the batch.
    pub(crate) layout: Arc<Layout>,
    /// Slot and reading, group after group.
    places: Vec<(usize, usize)>,
    /// Where those of each group end.
    ends: Vec<usize>,
    plan: Plan,
    keys: Vec<(Key, usize)>,
}

/// The readings of a group that has a reading in every slot of its batch, in measuring order.
#[derive(Debug, Default)]
struct Plan {
    /// Points of the group.
    points: usize,
    /// The station of each visit and its readings.
    visits: Vec<(usize, Range<usize>)>,
    /// Point and slot of each reading.
    readings: Vec<(usize, usize)>,
}

impl<'n> Slots<'n> {
    /// No slots yet of a network with these visits of each group ([`Network::visits_by_group`]).
    pub(crate) fn new(network: &'n Network, by_group: &'n [Vec<usize>]) -> Self {
        Self {
            network,
            by_group,
            layout: Arc::default(),
            places: Vec::new(),
            ends: Vec::new(),
            plan: Plan::default(),
            keys: Vec::new(),
        }
    }

    pub(crate) fn take(&mut self, groups: Range<usize>) {
        self.places.clear();
        self.ends.clear();
        let mut of_groups = groups.clone();
        if !of_groups.all(|group| self.place_by_plan(group)) {
            self.place_by_keys(groups);
        }
    }

    /// Slot and index of each reading of the `k`th group.
    pub(crate) fn places(&self, k: usize) -> &[(usize, usize)] {
        let first = k.checked_sub(1).map_or(0, |before| self.ends[before]);
        &self.places[first..self.ends[k]]
    }

    /// The visits of `group` of the network, the `k`th of the batch, each with slot and index of its readings.
    pub(crate) fn visits(
        &self,
        (k, group): (usize, usize),
    ) -> impl Iterator<Item = (usize, &[(usize, usize)])> {
        let mut places = self.places(k);
        self.by_group[group].iter().map(move |&visit| {
            let own;
            (own, places) = places.split_at(self.network.visits[visit].readings.len());
            (visit, own)
        })
    }

    /// Number of readings of all groups.
    pub(crate) fn readings(&self) -> usize {
        self.places.len()
    }

    /// Appends the places of a group; false if it was not measured by the plan.
    fn place_by_plan(&mut self, group: usize) -> bool {
        let (network, visits) = (self.network, &self.by_group[group]);
        let points = network.groups[group].len();
        if (points, visits.len()) != (self.plan.points, self.plan.visits.len()) {
            return false;
        }
        for (&v, (station, readings)) in visits.iter().zip(&self.plan.visits) {
            let visit = &network.visits[v];
            if visit.station != *station || visit.readings.len() != readings.len() {
                return false;
            }
            let planned = &self.plan.readings[readings.clone()];
            for (i, &(point, slot)) in visit.readings.clone().zip(planned) {
                if network.readings[i].point != point {
                    return false;
                }
                self.places.push((slot, i));
            }
        }
        self.ends.push(self.places.len());
        true
    }

    /// Finds the slots of groups that differ; if all are the same, the first group becomes the plan.
    fn place_by_keys(&mut self, groups: Range<usize>) {
        self.keys.clear();
        self.places.clear();
        self.ends.clear();
        for group in groups.clone() {
            append_keys(self.network, &self.by_group[group], &mut self.keys);
            self.ends.push(self.keys.len());
        }
        let mut slots: Vec<Key> = self.keys.iter().map(|&(key, _)| key).collect();
        slots.sort_unstable();
        slots.dedup();
        let place = |&(key, i): &(Key, usize)| (slots.partition_point(|slot| *slot < key), i);
        self.places.extend(self.keys.iter().map(place));
        let visits = slot_visits(&slots);
        let weights = visits.iter().map(|visit| factor_len(visit.slots.len()));
        self.layout = Arc::new(Layout {
            weights: weights.sum(),
            visits,
            point_of_slot: slots.iter().map(|key| key.point).collect(),
        });
        self.plan = Plan::default();
        if self.places.len() == slots.len() * groups.len() {
            self.plan = self.plan_of(groups.start);
        }
    }

    /// The plan by which the first group of the batch was measured.
    fn plan_of(&self, group: usize) -> Plan {
        let network = self.network;
        let mut plan = Plan {
            points: network.groups[group].len(),
            ..Plan::default()
        };
        for (v, own) in self.visits((0, group)) {
            let first = plan.readings.len();
            let of_own = own.iter();
            plan.readings
                .extend(of_own.map(|&(slot, i)| (network.readings[i].point, slot)));
            let station = network.visits[v].station;
            plan.visits.push((station, first..plan.readings.len()));
        }
        plan
    }
}

/// Appends the readings of a group in measuring order.
fn append_keys(network: &Network, visits: &[usize], keys: &mut Vec<(Key, usize)>) {
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
}

fn slot_visits(slots: &[Key]) -> Vec<SlotVisit> {
    let of_visits = slots.chunk_by(|a, b| (a.station, a.ordinal) == (b.station, b.ordinal));
    let visit = |end: &mut usize, keys: &[Key]| {
        let first = *end;
        *end += keys.len();
        Some(SlotVisit {
            station: keys[0].station,
            slots: first..*end,
        })
    };
    of_visits.scan(0, visit).collect()
}
