//! Tests of single lengths and of visits (Baarda's w).
//!
//! Whether an error of the form `c ∇` is in the lengths is tested on the adjusted residuals `v`:
//!
//! ```text
//! w = cᵀC⁻¹v / √(cᵀC⁻¹ Q_v C⁻¹c)      ∇ = cᵀC⁻¹v / cᵀC⁻¹ Q_v C⁻¹c
//! ```
//!
//! `w` is standard normal if nothing is wrong (W. Baarda, A testing procedure for use in geodetic
//! networks, 1968). `c` is one reading, or all readings of a visit.
//!
//! If the own variance `σ²` of a reading is inflated to `f σ²` with a large `f`, the reading has all but left the
//! adjustment: `∇` is its distance from what the others predict, and `1/den - (f - 1) σ²` (`den`: denominator of `∇`)
//! the variance of that distance without an error. So readings are tested alike, whether they take part or not.

use trueaxis_leastsquares::lane_products::{LaneMatrix, add_product, subtract_product};
use trueaxis_leastsquares::{Lanes, lanes_only, zeros};

use crate::batch_influence::{BatchInfluence, BatchRows};
use crate::batches::Batch;
use crate::slots::Slots;
use crate::{Network, Solution};

/// The test of one reading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReadingTest {
    /// Baarda's w, the residual in units of its standard deviation: standard normal if nothing is wrong; zero where
    /// nothing checks the reading.
    pub w: f64,
    /// Estimated error, observed minus right, mm.
    pub error_mm: f64,
    /// Standard deviation of the estimated error, mm; infinite where nothing checks the reading.
    pub sigma_mm: f64,
    /// Share of the squared whitened error that the residuals keep, from 0 to 1.
    pub kept: f64,
    /// Redundancy number: the part of an error in the reading that shows in its residual, from 0 (nothing checks the
    /// reading: the error goes wholly into the result) to 1. It may leave this range for lengths of a visit that
    /// correlate through the machine's repeatability. The sum over all readings is [`Solution::degrees_of_freedom`].
    ///
    /// `r = diag(I - J Q Jᵀ C⁻¹)` with the Jacobian `J` and the covariance `Q` of the unknowns.
    pub redundancy: f64,
}

/// If the residuals keep less than this share of an error, what they keep is rounding.
pub const CHECKED_TOL: f64 = 1e-9;

/// The tests of all readings and visits, in measuring order.
#[derive(Debug, Default)]
pub struct Tests {
    /// The test of every reading.
    pub readings: Vec<ReadingTest>,
    /// Baarda's w of an equal error in all lengths of each visit: the machine stood elsewhere, or the
    /// beam was lost and found again. Zero for visits of a single length.
    pub visits: Vec<f64>,
}

impl Solution {
    /// Tests every reading and every visit; `network` must be the one that was solved.
    pub fn tests(&self, network: &Network) -> Tests {
        self.tests_of_inflated(network, &[])
    }

    /// The same, where the factors on the variances of the network contain `inflation`, one for each reading (all are
    /// one if empty), by which readings were let go: they are tested by the noise that they have without it.
    pub fn tests_of_inflated(&self, network: &Network, inflation: &[f64]) -> Tests {
        test_all(&BatchInfluence::new(network, self), inflation)
    }
}

fn test_all(influence: &BatchInfluence<'_>, inflation: &[f64]) -> Tests {
    let network = influence.model.network;
    let by_group = network.visits_by_group();
    let batches = influence.batches();
    let tested = influence.of_chunks(
        #[inline(always)]
        |chunk, rows| {
            let of_chunk = &batches[chunk.clone()];
            let readings = of_chunk.iter().map(|batch| batch.readings).sum();
            let mut tests = OfGroups {
                readings: Vec::with_capacity(readings),
                visits: Vec::new(),
            };
            let mut slots = Slots::new(network, &by_group);
            let mut work = BatchTests::default();
            for b in chunk {
                influence.fill(b, rows);
                work.fill(influence, &batches[b], rows);
                slots.take(batches[b].groups.clone());
                let taken = (&batches[b], rows.variances.as_slice(), &slots);
                work.append(taken, inflation, &mut tests);
            }
            tests
        },
    );
    let mut tests = Tests {
        readings: vec![ReadingTest::UNCHECKED; network.readings.len()],
        visits: vec![0.0; network.visits.len()],
    };
    for OfGroups { readings, visits } in tested {
        for (reading, test) in readings {
            tests.readings[reading] = test;
        }
        for (visit, w) in visits {
            tests.visits[visit] = w;
        }
    }
    tests
}

impl ReadingTest {
    const UNCHECKED: Self = Self {
        w: 0.0,
        error_mm: 0.0,
        sigma_mm: f64::INFINITY,
        kept: 0.0,
        redundancy: 0.0,
    };
}

/// The tests of some groups: each reading and visit with its number.
struct OfGroups {
    readings: Vec<(usize, ReadingTest)>,
    visits: Vec<(usize, f64)>,
}

/// The tests of a batch, and memory to make them.
#[derive(Default)]
struct BatchTests {
    readings: Vec<LaneTest>,
    visits: Vec<LaneTest>,
    through: Vec<Lanes>,
    /// `I - O Oᵀ - T Σ Tᵀ` of a visit.
    kept: Vec<Lanes>,
    /// The whitened unit error of one reading, and the sum of those of all readings of the visit.
    unit: Vec<Lanes>,
    all: Vec<Lanes>,
    /// A row of `L`.
    row: Vec<Lanes>,
}

/// The parts of the test of a whitened error `u`, in eight groups.
struct LaneTest {
    /// `uᵀ v`, `uᵀ K u` and `uᵀ u` with the whitened residuals `v` and the part `K` of their noise that
    /// they keep.
    numerator: Lanes,
    denominator: Lanes,
    squares: Lanes,
    /// `lᵀ K u` with the row `l` of `L` that belongs to a reading: `(L K L⁻¹)_ii`.
    redundancy: Lanes,
}

impl BatchTests {
    /// Makes the tests of a batch with these rows.
    #[inline(always)]
    fn fill(&mut self, influence: &BatchInfluence<'_>, batch: &Batch, rows: &BatchRows) {
        let Self {
            readings,
            visits,
            through,
            kept,
            unit,
            all,
            row,
        } = self;
        readings.clear();
        visits.clear();
        let (own, shared) = (rows.hat.own(), rows.hat.shared());
        let width = influence.width();
        zeros(through, batch.slots() * width);
        add_product(through, shared, influence.shared_sigma());
        let through = LaneMatrix::by_rows(through, [batch.slots(), width]);
        for visit in rows.visits(batch) {
            let count = visit.slots.len();
            zeros(kept, count * count);
            kept.iter_mut()
                .step_by(count + 1)
                .for_each(|diagonal| *diagonal = Lanes::splat(1.0));
            let [own, shared, through] =
                [own, shared, through].map(|all| all.part(visit.slots.clone()));
            subtract_product(kept, own, own.transposed());
            subtract_product(kept, through, shared.transposed());
            let residual = &rows.hat.residual()[visit.slots.clone()];
            zeros(all, count);
            for i in 0..count {
                unit.clear();
                for (r, sum) in all.iter_mut().enumerate() {
                    let x = visit.unit_errors.at(r, i);
                    unit.push(x);
                    *sum += x;
                }
                visit.fill_factor_row(i, row);
                readings.push(LaneTest::new(unit, row, kept, residual));
            }
            visits.push(LaneTest::new(all, all, kept, residual));
        }
    }

    /// Appends the tests of the groups of a batch with these variances, whose readings have these slots.
    fn append(
        &self,
        (batch, variances, slots): (&Batch, &[Lanes], &Slots<'_>),
        inflation: &[f64],
        tests: &mut OfGroups,
    ) {
        for (lane, group) in batch.groups.clone().enumerate() {
            for (number, own) in slots.visits((lane, group)) {
                let of_slot = |&(slot, reading): &(usize, usize)| {
                    let factor = inflation.get(reading).copied().unwrap_or(1.0);
                    let inflated = variances[slot].0[lane] * (1.0 - 1.0 / factor);
                    (reading, self.readings[slot].reading(lane, inflated))
                };
                tests.readings.extend(own.iter().map(of_slot));
                let of_visit = |&(slot, _): &(usize, usize)| {
                    let visit = batch.layout.visit_of(slot);
                    self.visits[visit].w(lane)
                };
                let w = own.first().filter(|_| own.len() > 1).map_or(0.0, of_visit);
                tests.visits.push((number, w));
            }
        }
    }
}

impl LaneTest {
    #[inline(always)]
    fn new(u: &[Lanes], l: &[Lanes], kept: &[Lanes], residual: &[Lanes]) -> Self {
        let mut test = Self {
            redundancy: Lanes::ZERO,
            numerator: Lanes::ZERO,
            denominator: Lanes::ZERO,
            squares: Lanes::ZERO,
        };
        let rows = kept.chunks_exact(u.len()).zip(residual);
        for ((x, l), (row, r)) in u.iter().zip(l).zip(rows) {
            test.numerator = x.mul_add(*r, test.numerator);
            test.squares = x.mul_add(*x, test.squares);
            let mut along = Lanes::ZERO;
            for (k, other) in row.iter().zip(u) {
                lanes_only();
                along = k.mul_add(*other, along);
            }
            test.denominator = x.mul_add(along, test.denominator);
            test.redundancy = l.mul_add(along, test.redundancy);
        }
        test
    }

    /// Whether the residuals keep more of the error than rounding.
    fn is_checked(&self, lane: usize) -> bool {
        self.denominator.0[lane] > CHECKED_TOL * self.squares.0[lane]
    }

    /// The test of a reading whose own variance is inflated by `inflation`, mm².
    fn reading(&self, lane: usize, inflation: f64) -> ReadingTest {
        let redundancy = self.redundancy.0[lane];
        if !self.is_checked(lane) {
            return ReadingTest {
                redundancy,
                ..ReadingTest::UNCHECKED
            };
        }
        let denominator = self.denominator.0[lane];
        let error_mm = self.numerator.0[lane] / denominator;
        let sigma_mm = (1.0 / denominator - inflation)
            .max(f64::MIN_POSITIVE)
            .sqrt();
        ReadingTest {
            w: error_mm / sigma_mm,
            error_mm,
            sigma_mm,
            kept: denominator / self.squares.0[lane],
            redundancy,
        }
    }

    /// Baarda's w of an error where no variance is inflated.
    fn w(&self, lane: usize) -> f64 {
        match self.is_checked(lane) {
            true => self.numerator.0[lane] / self.denominator.0[lane].sqrt(),
            false => 0.0,
        }
    }
}
