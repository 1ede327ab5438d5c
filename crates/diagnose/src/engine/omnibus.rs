//! Whether anything at all is left in the residuals, and what it varies with.
//!
//! Each test adds smooth functions of a quantity to the model, projects them like the residuals, and applies the F test to what they
//! explain: its null distribution is exact for normal noise. The p-value of several tests is that of the smallest of as many independent ones
//! (Šidák 1967), which is too large, if anything, for tests that share the noise.

use std::collections::BTreeSet;

use rayon::prelude::*;
use trueaxis_effects::Level;
use trueaxis_leastsquares::dot;
use trueaxis_selection::{Fit, Projection, f_test, gram_of};

use crate::engine::basis::Basis;
use crate::{OmnibusTest, Unexplained};

/// Family-wise level of the omnibus tests of lengths or points: with the level of the causes, 0.7 % of clean
/// campaigns of lengths raise an alarm.
pub(crate) const OMNIBUS_LEVEL: f64 = 0.002;

/// Largest share of the degrees of freedom for a test of few data; one that takes more says little.
pub(crate) const MOST_OF_FREEDOM: f64 = 1.0 / 3.0;

/// Columns of a quantity with which residuals may vary.
pub(crate) struct Family {
    pub(crate) varies_with: &'static str,
    /// Whitened like the rows of the tested model.
    pub(crate) columns: Vec<Vec<f64>>,
}

impl Family {
    /// A number of columns that are certainly independent: those that begin in different rows. The time of a test
    /// grows with the third power of its columns, and there are hundreds where each reading is a cycle of its own.
    fn least_rank(&self) -> usize {
        let first = |column: &Vec<f64>| column.iter().position(|&x| x != 0.0);
        let first: BTreeSet<usize> = self.columns.iter().filter_map(first).collect();
        first.len()
    }
}

/// A test with its result.
#[derive(Debug, Clone)]
pub(crate) struct Omnibus {
    pub(crate) test: OmnibusTest,
    /// Drop of the sum of squares.
    pub(crate) drop: f64,
    /// Drop beyond the one expected from noise, in units of the noise's variance.
    pub(crate) excess: f64,
}

impl Omnibus {
    /// The test of one family of whitened columns.
    pub(crate) fn of(family: &Family, projection: &Projection) -> Self {
        let columns = &family.columns;
        let gram = gram_of(projection, columns);
        let (drop, rank) = (gram.statistic(&projection.along(columns)), gram.rank());
        let (squares, freedom) = (projection.squares(), projection.degrees_of_freedom);
        Self {
            test: OmnibusTest {
                varies_with: family.varies_with,
                detail: None,
                columns: rank,
                p_value: f_test(drop, squares, rank, freedom),
            },
            drop,
            excess: (drop / (squares / freedom) - rank as f64).max(0.0),
        }
    }

    /// Whether it is significant for lengths or points.
    pub(crate) fn is_clear(&self) -> bool {
        self.test.p_value < OMNIBUS_LEVEL
    }

    /// The tests for the report.
    pub(crate) fn tests(all: Vec<Self>) -> Vec<OmnibusTest> {
        all.into_iter().map(|omnibus| omnibus.test).collect()
    }

    /// The tests of several families, each taking at most the share `part` of the degrees of freedom, with family-wise
    /// p-values.
    pub(crate) fn of_all(projection: &Projection, families: &[Family], part: f64) -> Vec<Self> {
        let most = part * projection.degrees_of_freedom;
        let taken = projection.rows() as f64 - projection.degrees_of_freedom;
        let may_do = |f: &&Family| f.least_rank() as f64 - taken <= most;
        let tests = families.par_iter().filter(may_do);
        let mut tests: Vec<Self> = tests.map(|f| Self::of(f, projection)).collect();
        tests.retain(|o| o.test.columns > 0 && o.test.columns as f64 <= most);
        let count = tests.len() as f64;
        for Self { test, .. } in &mut tests {
            // 1 - (1 - p)^m without losing small p.
            test.p_value = -(count * (-test.p_value).ln_1p()).exp_m1();
        }
        tests
    }
}

/// What significant tests find in what a model leaves, whose rms is `rms_um`.
pub(crate) fn unexplained(
    level: Level,
    projection: &Projection,
    after: &[Omnibus],
    rms_um: f64,
) -> Unexplained {
    let clear = || after.iter().filter(|t| t.is_clear());
    let excess = clear().map(|t| t.excess).fold(0.0, f64::max);
    let varies_with: Vec<&'static str> = clear().map(|t| t.test.varies_with).collect();
    let rms_um = rms_um * (excess / projection.degrees_of_freedom).sqrt().min(1.0);
    let note = format!("varies with {}", varies_with.join(" and "));
    Unexplained {
        is_of_tests: true,
        ..Unexplained::new(level, rms_um, varies_with, note)
    }
}

/// Half waves of a quantity in each group of rows: `cos(kπx)`, `k` up to `most`, from 0 (a constant) if
/// `with_constant`. A place is the group of a row and its x, 0 to 1; rows without are zero. Zero columns are dropped.
pub(crate) fn waves_of(
    places: impl IntoIterator<Item = Option<(usize, f64)>>,
    with_constant: bool,
    most: usize,
) -> Vec<Vec<f64>> {
    let places: Vec<_> = places.into_iter().collect();
    let groups = places.iter().flatten().map(|p| p.0 + 1).max().unwrap_or(0);
    let basis = Basis::within(most, with_constant);
    let mut columns = vec![vec![0.0; places.len()]; groups * basis.width()];
    for (row, place) in places.iter().enumerate() {
        let Some((group, x)) = *place else {
            continue;
        };
        let own = &mut columns[group * basis.width()..];
        for (column, wave) in own.iter_mut().zip(basis.at(x)) {
            column[row] = wave;
        }
    }
    columns.retain(|column| column.iter().any(|&x| x != 0.0));
    columns
}

/// The families with significant tests, with the `squares` left in each.
pub(crate) fn still_left<'a>(
    families: &'a [Family],
    tests: &[Omnibus],
    level: f64,
    squares: impl Fn(&Omnibus) -> f64,
) -> Vec<(&'a Family, f64)> {
    let clear = tests.iter().filter(|t| t.test.p_value < level);
    let own = clear.filter_map(|t| {
        let is_own = |f: &&Family| f.varies_with == t.test.varies_with;
        Some((families.iter().find(is_own)?, squares(t)))
    });
    own.collect()
}

/// Squares left in columns, times the part of a cause's effect within these columns, relative to the squares of the
/// effect, from which the cause counts as an imitation. A correct cause leaves noise, far less than it took.
const TOO_MUCH_LEFT: f64 = 0.25;

/// The same limit for one course in time: a disturbance looks like a jump or a drift in most of its squares, so these
/// are named only if they take 95 %. It also applies to free functions of position, which fit many things.
const TOO_MUCH_OF_ANY_FORM: f64 = 1.0 / 19.0;

/// Whether a cause with this fit in the base model only takes part of what is left in the same columns: a wrong name
/// takes part of an unknown disturbance and leaves the rest. `left` are families with the squares left in them.
pub(crate) fn is_imitation(
    base: &Projection,
    fit: &Fit,
    is_of_any_form: bool,
    left: &[(&Family, f64)],
) -> bool {
    let too_much = match is_of_any_form {
        true => TOO_MUCH_OF_ANY_FORM,
        false => TOO_MUCH_LEFT,
    };
    left.iter().any(|(family, left)| {
        part_within(base, &family.columns, fit) * left > too_much * fit.gained()
    })
}

/// Part of the squares of an effect within some columns, both after the projection.
fn part_within(base: &Projection, columns: &[Vec<f64>], fit: &Fit) -> f64 {
    let rest = base.extended(columns).left_of(&fit.effect);
    1.0 - dot(&fit.effect, &rest) / fit.gained().max(f64::MIN_POSITIVE)
}
