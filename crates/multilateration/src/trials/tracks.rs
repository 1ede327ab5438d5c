//! Lengths that depend on no other one, in an order that suits loops.
//!
//! A *track* is a stretch of readings of one station under one dead path at points with consecutive
//! numbers. Readings are sorted into as few tracks as possible, and tracks are filled up with rows
//! of weight zero, so that one loop takes the beams and the coordinates of its points from arrays
//! side by side, eight at a time.

use std::collections::BTreeMap;
use std::hint::black_box;
use std::ops::Range;

use trueaxis_leastsquares::{LANES, Lanes, lanes_only};

use super::coordinates::Coordinates;
use super::unknowns::Unknowns;
use crate::free_points::PER_STATION;

/// One length, as the loops need it.
#[derive(Debug, Clone)]
pub(crate) struct Row {
    pub(crate) reading: usize,
    pub(crate) point: usize,
    /// First column of the station among the shared unknowns.
    pub(crate) station: usize,
    /// Column of the dead path.
    pub(crate) dead_path: usize,
    /// Unit vector from the station to the point.
    pub(crate) beam: [f64; 3],
    pub(crate) distance_mm: f64,
}

/// All rows, track after track.
#[derive(Debug, Clone, Default)]
pub(crate) struct Tracks {
    tracks: Vec<Track>,
    /// The reading of each row; rows that fill up have any.
    readings: Vec<[usize; LANES]>,
    beams: [Vec<Lanes>; 3],
    distances_mm: Vec<Lanes>,
    /// Inverse variance of each row.
    weights: Vec<Lanes>,
}

#[derive(Debug, Clone)]
struct Track {
    station: Range<usize>,
    dead_path: usize,
    first_point: usize,
    /// Places in the arrays.
    rows: Range<usize>,
}

impl Tracks {
    /// Sorts rows with their standard deviations, which come in measuring order.
    pub(crate) fn new(rows: Vec<(Row, f64)>) -> Self {
        let rows = sorted(rows);
        let follows = |(a, _): &(Row, f64), (b, _): &(Row, f64)| {
            a.dead_path == b.dead_path && a.point + 1 == b.point
        };
        let mut tracks = Self::default();
        for track in rows.chunk_by(follows) {
            let first = &track[0].0;
            let place = tracks.readings.len();
            tracks.tracks.push(Track {
                station: first.station..first.station + PER_STATION - 1,
                dead_path: first.dead_path,
                first_point: first.point,
                rows: place..place + track.len().div_ceil(LANES),
            });
            for rows in track.chunks(LANES) {
                tracks.push(rows);
            }
        }
        tracks
    }

    fn push(&mut self, rows: &[(Row, f64)]) {
        let of_rows = |value: &dyn Fn(&Row, f64) -> f64, filling: f64| {
            let mut lanes = Lanes::splat(filling);
            for (lane, (row, sigma_mm)) in lanes.0.iter_mut().zip(rows) {
                *lane = value(row, *sigma_mm);
            }
            lanes
        };
        // Rows that fill up have a beam, too: a length of zero would have no direction.
        for ((axis, beams), filling) in self.beams.iter_mut().enumerate().zip([1.0, 0.0, 0.0]) {
            beams.push(of_rows(&|row, _| row.beam[axis], filling));
        }
        self.distances_mm
            .push(of_rows(&|row, _| row.distance_mm, 1.0));
        self.weights
            .push(of_rows(&|_, sigma_mm| (sigma_mm * sigma_mm).recip(), 0.0));
        let reading = |lane: usize| rows[lane.min(rows.len() - 1)].0.reading;
        self.readings.push(std::array::from_fn(reading));
    }

    /// Storage for the errors of the rows.
    pub(crate) fn storage(&self) -> Vec<Lanes> {
        vec![Lanes::ZERO; self.readings.len()]
    }

    /// Brings the errors of all readings into the order of the rows.
    #[inline(always)]
    pub(crate) fn arrange(&self, errors_mm: &[f64], arranged: &mut [Lanes]) {
        for (lanes, readings) in arranged.iter_mut().zip(&self.readings) {
            *lanes = Lanes::from_fn(|k| errors_mm[readings[k]]);
        }
    }

    /// Adds the gradient without any corrections, where residuals are the errors.
    #[inline(always)]
    pub(crate) fn add_gradient_of_errors(&self, errors: &[Lanes], gradient: &mut Unknowns) {
        for track in &self.tracks {
            let count = track.rows.len();
            let [ux, uy, uz] = self.beams(track);
            let weights = &self.weights[track.rows.clone()][..count];
            let errors = &errors[track.rows.clone()][..count];
            let [gx, gy, gz] = gradient.points.eights_from_mut(track.first_point, count);
            let mut sums = [Lanes::ZERO; 4];
            for i in 0..count {
                lanes_only();
                let weighted = weights[i] * errors[i];
                let (x, y, z) = (weighted * ux[i], weighted * uy[i], weighted * uz[i]);
                gx[i] = (Lanes(gx[i]) + x).0;
                gy[i] = (Lanes(gy[i]) + y).0;
                gz[i] = (Lanes(gz[i]) + z).0;
                sums[0] -= x;
                sums[1] -= y;
                sums[2] -= z;
                sums[3] -= weighted;
            }
            track.add_to_shared(sums, &mut gradient.shared);
        }
    }

    /// Adds the exact gradient at the corrections `at`.
    #[inline(always)]
    pub(crate) fn add_gradient(&self, errors: &[Lanes], at: &Unknowns, gradient: &mut Unknowns) {
        for track in &self.tracks {
            let count = track.rows.len();
            let [ux, uy, uz] = self.beams(track);
            let distances = &self.distances_mm[track.rows.clone()][..count];
            let weights = &self.weights[track.rows.clone()][..count];
            let errors = &errors[track.rows.clone()][..count];
            let [px, py, pz] = at.points.eights_from(track.first_point, count);
            let [gx, gy, gz] = gradient.points.eights_from_mut(track.first_point, count);
            let [sx, sy, sz, dead_path] = track.shared(&at.shared);
            let mut sums = [Lanes::ZERO; 4];
            for i in 0..count {
                lanes_only();
                let d = distances[i];
                let x = d * ux[i] + (Lanes(px[i]) - sx);
                let y = d * uy[i] + (Lanes(py[i]) - sy);
                let z = d * uz[i] + (Lanes(pz[i]) - sz);
                let distance = (x * x + y * y + z * z).sqrt();
                let weighted = weights[i] * (errors[i] - (distance - d - dead_path));
                let along = weighted / distance;
                let (x, y, z) = (along * x, along * y, along * z);
                gx[i] = (Lanes(gx[i]) + x).0;
                gy[i] = (Lanes(gy[i]) + y).0;
                gz[i] = (Lanes(gz[i]) + z).0;
                sums[0] -= x;
                sums[1] -= y;
                sums[2] -= z;
                sums[3] -= weighted;
            }
            track.add_to_shared(sums, &mut gradient.shared);
        }
    }

    /// Takes `Bᵀ P A y` off `shared`.
    #[inline(always)]
    pub(crate) fn reduce_shared(&self, points: &Coordinates, shared: &mut [f64]) {
        for track in &self.tracks {
            let count = track.rows.len();
            let [ux, uy, uz] = self.beams(track);
            let weights = &self.weights[track.rows.clone()][..count];
            let [px, py, pz] = points.eights_from(track.first_point, count);
            let mut sums = [Lanes::ZERO; 4];
            for i in 0..count {
                lanes_only();
                let (x, y, z) = (ux[i], uy[i], uz[i]);
                let length = x * Lanes(px[i]) + y * Lanes(py[i]) + z * Lanes(pz[i]);
                let weighted = weights[i] * length;
                sums[0] += weighted * x;
                sums[1] += weighted * y;
                sums[2] += weighted * z;
                sums[3] += weighted;
            }
            track.add_to_shared(sums, shared);
        }
    }

    /// Takes `Aᵀ P B s` off `points`.
    #[inline(always)]
    pub(crate) fn reduce_points(&self, shared: &[f64], points: &mut Coordinates) {
        for track in &self.tracks {
            let count = track.rows.len();
            let [ux, uy, uz] = self.beams(track);
            let weights = &self.weights[track.rows.clone()][..count];
            let [gx, gy, gz] = points.eights_from_mut(track.first_point, count);
            let [sx, sy, sz, dead_path] = track.shared(shared);
            for i in 0..count {
                lanes_only();
                let (x, y, z) = (ux[i], uy[i], uz[i]);
                let weighted = weights[i] * (x * sx + y * sy + z * sz + dead_path);
                gx[i] = (Lanes(gx[i]) + weighted * x).0;
                gy[i] = (Lanes(gy[i]) + weighted * y).0;
                gz[i] = (Lanes(gz[i]) + weighted * z).0;
            }
        }
    }

    #[inline(always)]
    fn beams(&self, track: &Track) -> [&[Lanes]; 3] {
        let [x, y, z] = &self.beams;
        let count = track.rows.len();
        [
            &x[track.rows.clone()][..count],
            &y[track.rows.clone()][..count],
            &z[track.rows.clone()][..count],
        ]
    }
}

impl Track {
    /// What belongs to the station, and to its dead path.
    #[inline(always)]
    fn shared(&self, shared: &[f64]) -> [Lanes; 4] {
        let first = self.station.start;
        [
            Lanes::splat(shared[first]),
            Lanes::splat(shared[first + 1]),
            Lanes::splat(shared[first + 2]),
            Lanes::splat(shared[self.dead_path]),
        ]
    }

    #[inline(always)]
    fn add_to_shared(&self, sums: [Lanes; 4], shared: &mut [f64]) {
        // As they are: else the loop before would be arranged for these sums over lanes, and take each of
        // its products apart.
        let sums = black_box(sums);
        let columns = self.station.clone().chain([self.dead_path]);
        for (column, sums) in columns.zip(sums) {
            shared[column] += sums.sum();
        }
    }
}

/// By dead path; under it all first readings of the points, all second ones, ….
fn sorted(rows: Vec<(Row, f64)>) -> Vec<(Row, f64)> {
    let mut read_before = BTreeMap::new();
    let mut keyed: Vec<_> = rows
        .into_iter()
        .map(|row| {
            let (dead_path, point) = (row.0.dead_path, row.0.point);
            let times: &mut usize = read_before.entry((dead_path, point)).or_default();
            *times += 1;
            ((dead_path, *times, point), row)
        })
        .collect();
    keyed.sort_by_key(|(key, _)| *key);
    keyed.into_iter().map(|(_, row)| row).collect()
}
