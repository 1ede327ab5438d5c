//! An adjusted network as whitened rows in measuring order: what a test for further effects in the lengths needs.
//!
//! For whitened columns `x` of further unknowns, `M x = x - O Oᵀx - T Σ Tᵀx` is what the adjustment
//! cannot absorb, with the factors of [`crate::batch_influence`]. The rows of `O` and `T` are kept, so the
//! size is linear in the number of lengths.

use std::ops::Range;

use trueaxis_leastsquares::dot;

use crate::batch_influence::{BatchInfluence, BatchRows};
use crate::batches::{Batch, groups_of};
use crate::chunks::split_mut;
use crate::noise::factor_len;
use crate::slots::Slots;
use crate::{Network, Solution};

/// The whitened rows of an adjusted network, visit after visit in measuring order.
///
/// A visit has as many rows as readings, in the order of its points, which [`Whitened::whiten`] knows.
#[derive(Debug, Clone)]
pub struct Whitened {
    /// The group of each row.
    pub group_of_row: Vec<usize>,
    /// Number of groups.
    pub groups: usize,
    /// Columns of `O`: those of the group with the most unknowns, zeros in the others.
    pub own_width: usize,
    /// `O`, row after row: one column for each unknown of the row's group.
    pub own: Vec<f64>,
    /// Columns of `T`.
    pub shared_width: usize,
    /// `T`, row after row: one column for each shared unknown and datum multiplier.
    pub shared: Vec<f64>,
    /// `Σ`, row after row: symmetric, indefinite.
    pub reduced_inverse: Vec<f64>,
    /// Whitened residuals, observed minus computed.
    pub residuals: Vec<f64>,
    /// Redundancy.
    pub degrees_of_freedom: usize,
    /// The rows of each visit.
    pub visits: Vec<Range<usize>>,
    /// The reading that each row has on the diagonal of `L⁻¹`; the rows of a visit are in the order of its weights.
    reading_of_row: Vec<usize>,
    /// `L⁻¹` of each visit by rows up to the diagonal, one visit after the other.
    weights: Vec<f64>,
    weight_starts: Vec<usize>,
}

impl Whitened {
    /// The rows of a network; `solution` must be the network's.
    pub fn new(network: &Network, solution: &Solution) -> Self {
        let factors = &solution.covariance.factors;
        let sizes = (0..network.groups.len()).map(|g| factors.unknowns(g));
        let widths = (sizes.max().unwrap_or(0), factors.width());
        Self::with_columns(network, solution, widths)
    }

    /// The same without `O` and `T`, which are most of it: visits are whitened, and nothing is absorbed.
    pub fn of_visits(network: &Network, solution: &Solution) -> Self {
        Self::with_columns(network, solution, (0, 0))
    }

    fn with_columns(
        network: &Network,
        solution: &Solution,
        (own_width, shared_width): (usize, usize),
    ) -> Self {
        let influence = BatchInfluence::new(network, solution);
        let rows = network.readings.len();
        let weight_starts = network.factor_starts();
        let mut whitened = Self {
            group_of_row: vec![0; rows],
            groups: network.groups.len(),
            own_width,
            own: vec![0.0; rows * own_width],
            shared_width,
            shared: vec![0.0; rows * shared_width],
            reduced_inverse: influence.sigma().as_slice()[..shared_width * shared_width].to_vec(),
            residuals: vec![0.0; rows],
            degrees_of_freedom: solution.degrees_of_freedom(),
            visits: network.visits.iter().map(|v| v.readings.clone()).collect(),
            reading_of_row: vec![0; rows],
            weights: vec![0.0; weight_starts[network.visits.len()]],
            weight_starts,
        };
        let by_group = network.visits_by_group();
        let mut places: Vec<_> = whitened.by_visit(network).into_iter().map(Some).collect();
        let of_chunk = |chunk: Range<usize>| {
            let visits = groups_of(influence.batches(), &[chunk])[0].clone();
            let visits = visits.flat_map(|group| &by_group[group]);
            visits.filter_map(|&visit| places[visit].take()).collect()
        };
        let parts = influence.chunks().map(of_chunk).collect();
        influence.with_chunks(parts, |chunk, places: Vec<VisitRows<'_>>, hat| {
            let (mut slots, mut places) = (Slots::new(network, &by_group), places.into_iter());
            for b in chunk {
                let batch = &influence.batches()[b];
                influence.fill(b, hat);
                slots.take(batch.groups.clone());
                for (lane, group) in batch.groups.clone().enumerate() {
                    // The slots first: a zip asks its left side once more than its right.
                    let visits = slots.visits((lane, group));
                    for ((_, own), place) in visits.zip(&mut places) {
                        place.fill(own, (batch, hat, lane));
                    }
                }
            }
        });
        for visit in &network.visits {
            whitened.group_of_row[visit.readings.clone()].fill(visit.group);
        }
        whitened
    }

    fn by_visit(&mut self, network: &Network) -> Vec<VisitRows<'_>> {
        let counts = || network.visits.iter().map(|visit| visit.readings.len());
        let of_rows = |width: usize| counts().map(move |count| count * width);
        let own = split_mut(&mut self.own, of_rows(self.own_width)).into_iter();
        let shared = split_mut(&mut self.shared, of_rows(self.shared_width));
        let residuals = split_mut(&mut self.residuals, counts());
        let readings = split_mut(&mut self.reading_of_row, counts());
        let weights = split_mut(&mut self.weights, counts().map(factor_len));
        let rows = own.zip(shared).zip(residuals).zip(readings).zip(weights);
        let of_visit = |((((own, shared), residuals), readings), weights)| VisitRows {
            own,
            shared,
            residuals,
            readings,
            weights,
        };
        rows.map(of_visit).collect()
    }

    /// Whitens a column of changes of the lengths (mm), one for each reading in measuring order, in place.
    pub fn whiten(&self, column: &mut [f64]) {
        self.whiten_from(0, column);
    }

    /// The same for the visits from `first_visit` on, whose first reading the column starts with.
    pub fn whiten_from(&self, first_visit: usize, column: &mut [f64]) {
        let first = self.visits.get(first_visit).map_or(0, |rows| rows.start);
        let mut by_row = Vec::new();
        for (visit, rows) in self.visits.iter().enumerate().skip(first_visit) {
            if rows.end - first > column.len() {
                break;
            }
            let own = rows.start - first..rows.end - first;
            if column[own.clone()].iter().all(|x| *x == 0.0) {
                continue;
            }
            by_row.clear();
            let readings = self.reading_of_row[rows.clone()].iter();
            by_row.extend(readings.map(|reading| column[reading - first]));
            let mut weights = self.weights[self.weight_starts[visit]..].iter();
            for (i, x) in column[own].iter_mut().enumerate() {
                // The elements first: a zip asks its left side once more than its right.
                let weighted = by_row[..=i].iter().zip(&mut weights);
                *x = weighted.map(|(x, weight)| weight * x).sum();
            }
        }
    }

    /// What the adjustment cannot absorb of a whitened column, in place: `x <- M x`.
    pub fn project(&self, x: &mut [f64]) {
        let mut of_groups = vec![0.0; self.groups * self.own_width];
        let mut of_shared = vec![0.0; self.shared_width];
        for (row, &value) in x.iter().enumerate().filter(|(_, value)| **value != 0.0) {
            let of_group = &mut of_groups[self.columns_of_group(row)];
            self.add_row(row, value, of_group, &mut of_shared);
        }
        let rows = self.reduced_inverse.chunks_exact(self.shared_width.max(1));
        let through: Vec<f64> = rows.map(|row| dot(row, &of_shared)).collect();
        for (row, value) in x.iter_mut().enumerate() {
            *value -= dot(self.own_row(row), &of_groups[self.columns_of_group(row)])
                + dot(self.shared_row(row), &through);
        }
    }

    /// Writes a whitened unit error of a reading of a visit: an element for each row of the visit.
    pub fn unit_error(&self, visit: usize, reading: usize, unit: &mut Vec<f64>) {
        unit.clear();
        let rows = self.visits[visit].clone();
        let place = |row: usize| self.reading_of_row[row] == reading;
        let column = rows.clone().position(place);
        let weights = &self.weights[self.weight_starts[visit]..];
        let element = |i: usize| {
            let row = &weights[factor_len(i)..factor_len(i + 1)];
            column.and_then(|column| row.get(column)).copied()
        };
        unit.extend((0..rows.len()).map(|i| element(i).unwrap_or_default()));
    }

    /// Range of the unknowns of a row's group among those of all groups, [`Whitened::own_width`] for each.
    pub fn columns_of_group(&self, row: usize) -> Range<usize> {
        let group = self.group_of_row[row];
        group * self.own_width..(group + 1) * self.own_width
    }

    /// Row of `O`.
    pub fn own_row(&self, row: usize) -> &[f64] {
        &self.own[row * self.own_width..][..self.own_width]
    }

    /// Adds a row of `O` and of `T`, times a factor, to the sums of its group and of all rows.
    pub fn add_row(&self, row: usize, factor: f64, own: &mut [f64], shared: &mut [f64]) {
        add_times(own, factor, self.own_row(row));
        add_times(shared, factor, self.shared_row(row));
    }

    /// Row of `T`.
    pub fn shared_row(&self, row: usize) -> &[f64] {
        &self.shared[row * self.shared_width..][..self.shared_width]
    }
}

/// `sum += factor x`.
fn add_times(sum: &mut [f64], factor: f64, x: &[f64]) {
    for (sum, x) in sum.iter_mut().zip(x) {
        *sum += factor * x;
    }
}

struct VisitRows<'a> {
    own: &'a mut [f64],
    shared: &'a mut [f64],
    residuals: &'a mut [f64],
    readings: &'a mut [usize],
    weights: &'a mut [f64],
}

impl VisitRows<'_> {
    /// Takes the rows of a visit whose readings are in these slots.
    fn fill(self, places: &[(usize, usize)], (batch, hat, lane): (&Batch, &BatchRows, usize)) {
        let Some((of_slots, places)) = batch.layout.in_order(places) else {
            return;
        };
        let Some(part) = hat.visits(batch).nth(of_slots) else {
            return;
        };
        let start = part.slots.start;
        let (own, shared) = (hat.hat.own(), hat.hat.shared());
        let own_width = self.own.len() / places.len();
        let shared_width = self.shared.len() / places.len();
        let mut weights = self.weights.iter_mut();
        for (row, &(slot, reading)) in places.iter().enumerate() {
            self.readings[row] = reading;
            self.residuals[row] = hat.hat.residual()[slot].0[lane];
            let of_own = self.own[row * own_width..].iter_mut().zip(own.row(slot));
            of_own.for_each(|(x, lanes)| *x = lanes.0[lane]);
            let of_shared = self.shared[row * shared_width..].iter_mut();
            let of_shared = of_shared.zip(shared.row(slot));
            of_shared.for_each(|(x, lanes)| *x = lanes.0[lane]);
            // The places first: a zip asks its left side once more than its right.
            for (&(other, _), weight) in places[..=row].iter().zip(&mut weights) {
                *weight = part.unit_errors.at(slot - start, other - start).0[lane];
            }
        }
    }
}
