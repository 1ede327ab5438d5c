//! Lengths that depend on others of their visit, because the machine's return is common to them.
//!
//! They are taken in measuring order: residuals of all rows, weights visit by visit, then what each
//! row adds.

use std::ops::Range;

use nalgebra::Vector3;

use super::coordinates::Coordinates;
use super::tracks::Row;
use super::unknowns::Unknowns;
use crate::noise::whiten;

/// The rows, visit after visit.
#[derive(Debug, Clone, Default)]
pub(crate) struct CorrelatedVisits {
    rows: Vec<Row>,
    visits: Vec<Range<usize>>,
    /// `P = L⁻ᵀ L⁻¹` of each visit, row by row.
    weights: Vec<f64>,
}

/// Numbers of each row that a step passes on.
#[derive(Debug, Clone, Default)]
pub(crate) struct Storage {
    lengths: Vec<f64>,
    weighted: Vec<f64>,
    beams: Vec<Vector3<f64>>,
}

impl CorrelatedVisits {
    /// Adds a visit with the factor `L` of its covariance.
    pub(crate) fn push(&mut self, rows: impl Iterator<Item = Row>, factor: &[f64]) {
        let first = self.rows.len();
        self.rows.extend(rows);
        let visit = first..self.rows.len();
        self.weights.extend(inverse(factor, visit.len()));
        self.visits.push(visit);
    }

    pub(crate) fn storage(&self) -> Storage {
        let count = self.rows.len();
        Storage {
            lengths: vec![0.0; count],
            weighted: vec![0.0; count],
            beams: vec![Vector3::zeros(); count],
        }
    }

    /// Adds the exact gradient at the corrections `at`.
    #[inline(always)]
    pub(crate) fn add_gradient(
        &self,
        errors_mm: &[f64],
        at: &Unknowns,
        gradient: &mut Unknowns,
        storage: &mut Storage,
    ) {
        for (i, row) in self.rows.iter().enumerate() {
            let shift = at.points.get(row.point) - row.station(&at.shared);
            let beam = row.distance_mm * row.beam() + shift;
            let distance = beam.norm();
            let change = distance - row.distance_mm - at.shared[row.dead_path];
            storage.lengths[i] = errors_mm[row.reading] - change;
            storage.beams[i] = beam / distance;
        }
        self.weigh(storage);
        for ((row, weighted), beam) in self.rows.iter().zip(&storage.weighted).zip(&storage.beams) {
            gradient.points.add_at(row.point, beam * *weighted);
            row.add_to_shared(-weighted, beam, &mut gradient.shared);
        }
    }

    /// Takes `Bᵀ P A y` off `shared`.
    #[inline(always)]
    pub(crate) fn reduce_shared(
        &self,
        points: &Coordinates,
        shared: &mut [f64],
        storage: &mut Storage,
    ) {
        for (length, row) in storage.lengths.iter_mut().zip(&self.rows) {
            *length = row.beam().dot(&points.get(row.point));
        }
        self.weigh(storage);
        for (row, weighted) in self.rows.iter().zip(&storage.weighted) {
            row.add_to_shared(*weighted, &row.beam(), shared);
        }
    }

    /// Takes `Aᵀ P B s` off `points`.
    #[inline(always)]
    pub(crate) fn reduce_points(
        &self,
        shared: &[f64],
        points: &mut Coordinates,
        storage: &mut Storage,
    ) {
        for (length, row) in storage.lengths.iter_mut().zip(&self.rows) {
            *length = row.beam().dot(&row.station(shared)) + shared[row.dead_path];
        }
        self.weigh(storage);
        for (row, weighted) in self.rows.iter().zip(&storage.weighted) {
            points.add_at(row.point, row.beam() * *weighted);
        }
    }

    /// `P` times the lengths.
    #[inline(always)]
    fn weigh(&self, storage: &mut Storage) {
        let mut weights = self.weights.as_slice();
        for visit in &self.visits {
            let lengths = &storage.lengths[visit.clone()];
            for weighted in &mut storage.weighted[visit.clone()] {
                let (row, rest) = weights.split_at(lengths.len());
                weights = rest;
                *weighted = match (row, lengths) {
                    // Three targets are usual, and a loop over three takes longer than its work.
                    ([p, q, r], [a, b, c]) => p * a + q * b + r * c,
                    _ => row.iter().zip(lengths).map(|(p, l)| p * l).sum(),
                };
            }
        }
    }
}

impl Row {
    #[inline(always)]
    fn beam(&self) -> Vector3<f64> {
        self.beam.into()
    }

    #[inline(always)]
    fn station(&self, shared: &[f64]) -> Vector3<f64> {
        let first = self.station;
        Vector3::new(shared[first], shared[first + 1], shared[first + 2])
    }

    #[inline(always)]
    fn add_to_shared(&self, weighted: f64, beam: &Vector3<f64>, shared: &mut [f64]) {
        for (axis, u) in beam.iter().enumerate() {
            shared[self.station + axis] += weighted * u;
        }
        shared[self.dead_path] += weighted;
    }
}

/// `L⁻ᵀ L⁻¹`, row by row.
fn inverse(factor: &[f64], rows: usize) -> impl Iterator<Item = f64> {
    let whitened_units: Vec<Vec<f64>> = (0..rows)
        .map(|i| {
            let mut unit = vec![0.0; rows];
            unit[i] = 1.0;
            whiten(factor, &mut unit);
            unit
        })
        .collect();
    (0..rows * rows).map(move |k| {
        let (a, b) = (&whitened_units[k / rows], &whitened_units[k % rows]);
        a.iter().zip(b).map(|(a, b)| a * b).sum()
    })
}
