//! Whether anything at all is left in the residuals, and what it varies with.
//!
//! Each test adds smooth functions of something to the model, projects them as the residuals were
//! projected, and takes the F test of what they explain: its null distribution is exact for normal
//! noise. Several tests share their level (Bonferroni).

use rayon::prelude::*;
use trueaxis_leastsquares::half_waves;
use trueaxis_poses::LengthCircumstances as Reading;

use crate::OmnibusTest;
use crate::lengths::base::{Adjusted, Base};
use crate::selection::{Projection, dot, f_test, gram_of};

/// Family-wise level of the omnibus tests: with that of the causes, 1.2 % of clean campaigns alarm.
pub(crate) const OMNIBUS_LEVEL: f64 = 0.002;

/// Half waves of time in one occupation of a station: 24, so twelve periods.
const OF_TIME: u32 = 24;
/// Half waves of the position of an axis as one station sees it.
const OF_POSITION: u32 = 12;
/// Half waves of the position of an axis as one target shows it.
const OF_TARGET: u32 = 4;
/// Half waves of the difference between the two sides of approach.
const OF_DIRECTION: u32 = 2;

/// A test with what it found.
#[derive(Debug, Clone)]
pub(crate) struct Omnibus {
    pub(crate) test: OmnibusTest,
    /// Squares explained beyond what noise explains, in units of its variance.
    pub(crate) excess: f64,
}

/// All tests of what an adjusted model leaves.
pub(crate) fn omnibus(base: &Base<'_>, adjusted: &Adjusted) -> Vec<Omnibus> {
    let machine = &base.scene.machine;
    let stations = base.scene.stations.len();
    let (axes, targets) = (machine.axes().len(), base.scene.targets.len());
    let both_sides = base
        .readings
        .iter()
        .any(|r| r.direction != base.readings[0].direction);
    let mut tests = vec![
        columns(base, "time", stations * OF_TIME as usize, |r, set| {
            let first = r.station * OF_TIME as usize;
            fill(set, first, half_waves(r.occupation_progress, OF_TIME));
        }),
        columns(
            base,
            "position",
            stations * axes * OF_POSITION as usize,
            |r, set| {
                let first = (r.station * axes + r.axis) * OF_POSITION as usize;
                fill(set, first, half_waves(travelled(base, r), OF_POSITION));
            },
        ),
        columns(
            base,
            "target",
            targets * axes * OF_TARGET as usize + targets * stations,
            |r, set| {
                let first = (r.target * axes + r.axis) * OF_TARGET as usize;
                fill(set, first, half_waves(travelled(base, r), OF_TARGET));
                set[targets * axes * OF_TARGET as usize + r.target * stations + r.station] = 1.0;
            },
        ),
    ];
    if both_sides {
        let width = OF_DIRECTION as usize + 1;
        tests.push(columns(
            base,
            "direction",
            targets * axes * width,
            |r, set| {
                let first = (r.target * axes + r.axis) * width;
                set[first] = r.sign();
                let waves = half_waves(travelled(base, r), OF_DIRECTION);
                fill(set, first + 1, waves.map(|x| x * r.sign()));
            },
        ));
    }
    let tests = tests.into_par_iter().map(|(varies_with, mut columns)| {
        columns.retain(|column| column.iter().any(|&x| x != 0.0));
        for column in &mut columns {
            adjusted.whitened.whiten(column);
        }
        Omnibus::of(varies_with, &adjusted.projection, &columns)
    });
    family_wise(tests.collect())
}

impl Omnibus {
    /// The test of whitened columns, alone.
    pub(crate) fn of(
        varies_with: &'static str,
        projection: &Projection,
        columns: &[Vec<f64>],
    ) -> Self {
        let gram = gram_of(projection, columns);
        let along = columns.iter().map(|c| dot(c, &projection.residuals));
        let (drop, rank) = (gram.statistic(&along.collect::<Vec<_>>()), gram.rank());
        let (squares, freedom) = (projection.squares(), projection.degrees_of_freedom);
        Self {
            test: OmnibusTest {
                varies_with,
                detail: None,
                columns: rank,
                p_value: f_test(drop, squares, rank, freedom),
            },
            excess: (drop / (squares / freedom) - rank as f64).max(0.0),
        }
    }
}

/// The tests with the p-values of all of them together.
pub(crate) fn family_wise(mut tests: Vec<Omnibus>) -> Vec<Omnibus> {
    let count = tests.len() as f64;
    for omnibus in &mut tests {
        omnibus.test.p_value = (count * omnibus.test.p_value).min(1.0);
    }
    tests
}

/// Where an axis stands in its travel, 0 to 1.
pub(crate) fn travelled(base: &Base<'_>, reading: &Reading) -> f64 {
    let [low, high] = base.scene.machine.axes()[reading.axis].travel();
    let position = base.campaign.steps[reading.step].positions[reading.axis];
    if high > low {
        (position - low) / (high - low)
    } else {
        0.0
    }
}

fn fill(set: &mut [f64], first: usize, values: impl Iterator<Item = f64>) {
    for (x, value) in set[first..].iter_mut().zip(values) {
        *x = value;
    }
}

/// Columns of changes of the lengths; `fill` gets a reading and its row, mm.
fn columns(
    base: &Base<'_>,
    varies_with: &'static str,
    count: usize,
    fill: impl Fn(&Reading, &mut [f64]),
) -> (&'static str, Vec<Vec<f64>>) {
    let mut columns = vec![vec![0.0; base.readings.len()]; count];
    let mut row = vec![0.0; count];
    for (i, reading) in base.readings.iter().enumerate() {
        row.fill(0.0);
        fill(reading, &mut row);
        for (column, &x) in columns.iter_mut().zip(&row) {
            column[i] = x;
        }
    }
    (varies_with, columns)
}
