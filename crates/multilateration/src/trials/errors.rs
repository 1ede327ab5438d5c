//! Errors of lengths, drawn from the noise that determines the weights.
//!
//! With the factor `C = L Lᵀ` of the covariance of one visit's lengths, errors are `e = L z` with
//! standard normal `z`.

use rand::{Rng, RngExt};
use rand_distr::StandardNormal;

use crate::batch_influence::BatchRows;
use crate::batches::Batch;
use crate::network::Network;
use crate::slots::Slots;

/// Factors of all visits in measuring order.
#[derive(Debug, Clone)]
pub(crate) struct ErrorNoise {
    /// The number of readings of each visit.
    counts: Vec<usize>,
    /// For each visit the readings in the order of the rows of `L`, one visit after the other.
    order: Vec<usize>,
    /// `L`, row by row up to the diagonal.
    factors: Vec<f64>,
    starts: Vec<usize>,
}

impl ErrorNoise {
    pub(crate) fn new(network: &Network) -> Self {
        let starts = network.factor_starts();
        Self {
            counts: network.visits.iter().map(|v| v.readings.len()).collect(),
            order: (0..network.readings.len()).collect(),
            factors: vec![0.0; starts[network.visits.len()]],
            starts,
        }
    }

    /// Takes the factors of the visits to the groups of a batch.
    pub(crate) fn take(&mut self, (batch, rows): (&Batch, &BatchRows), slots: &Slots<'_>) {
        let visits: Vec<_> = rows.visits(batch).collect();
        let mut row = Vec::new();
        for (lane, group) in batch.groups.clone().enumerate() {
            for (v, places) in slots.visits((lane, group)) {
                let Some((visit, own)) = batch.layout.in_order(places) else {
                    continue;
                };
                let (visit, first) = (&visits[visit], slots.network.visits[v].readings.start);
                let mut factor = self.factors[self.starts[v]..].iter_mut();
                for (k, &(slot, reading)) in own.iter().enumerate() {
                    self.order[first + k] = reading;
                    visit.fill_factor_row(slot - visit.slots.start, &mut row);
                    for (&(other, _), l) in own[..=k].iter().zip(&mut factor) {
                        *l = row[other - visit.slots.start].0[lane];
                    }
                }
            }
        }
    }

    /// Number of lengths.
    pub(crate) fn readings(&self) -> usize {
        self.order.len()
    }

    /// One error for each reading, mm.
    pub(crate) fn draw<R: Rng + ?Sized>(&self, rng: &mut R, errors_mm: &mut [f64]) {
        let mut factors = self.factors.as_slice();
        let mut order = self.order.as_slice();
        let mut normal = [0.0; 8];
        let mut more = Vec::new();
        for &count in &self.counts {
            let (own, rest) = order.split_at(count);
            order = rest;
            let normal = match normal.get_mut(..count) {
                Some(normal) => normal,
                None => {
                    more.resize(count, 0.0);
                    &mut more[..]
                }
            };
            for z in &mut *normal {
                *z = rng.sample(StandardNormal);
            }
            for (i, &reading) in own.iter().enumerate() {
                let (row, rest) = factors.split_at(i + 1);
                factors = rest;
                errors_mm[reading] = row.iter().zip(&*normal).map(|(l, z)| l * z).sum();
            }
        }
    }
}
