//! Readings that contradict all others, such as one written down wrongly, or two consecutive ones.
//!
//! Against the model that leaves nothing but scatter (each position and side has a mean, each pass an offset,
//! [`scatter`]) every arrival, and every two consecutive ones, are tested with the residuals of the others
//! ([`Outliers`]), those that stand out most first.
//! Two consecutive ones are tested together because each hides the other. Gross errors of one size hide each other wherever
//! they are, so the search goes on after one that is not clear, and what came before the last clear one counts, too
//! (Rosner 1983, generalised extreme studentised deviates). Each is then judged beside all others. Three consecutive
//! ones, more than a few, or those after which readings stay there are structure and stay; so do those that other
//! arrivals explain nearly as well. Of two readings at a position nothing shows which is wrong, and both go. More
//! than a few go if each is alone and plainly wrong ([`far_off`]); otherwise a notice says that many are doubtful.

use std::ops::Range;

use trueaxis_campaign::Verification;
use trueaxis_selection::Projection;

use crate::engine::{ACCIDENT_LEVEL, ACCIDENTS, LEAST_OTHERS, most, without};
use crate::numbers::{distinct, mean};
use crate::verification::base::{cells, passes, sizes};
use crate::verification::comparison::Comparison;
use crate::verification::doubted::{far_off, mistakes};
use crate::verification::gross_error::{Contradicts, GrossError};
use crate::verification::noise_floor::scatter;
use crate::verification::other_side::against_other_side;
use crate::verification::tested::{Outlier, Outliers};

/// p-value of the arrival that stands out most, above which no others are sought behind it: of `k` gross errors of one size
/// the first has `F > ν/k`, which is 16 where they are 3 % of readings that were repeated once.
const HIDDEN: f64 = 1e-3;

/// Most consecutive gross errors: more are structure.
pub(crate) const MOST_IN_A_ROW: usize = 2;

/// More than a few are gross errors all the same if each is alone, as far off as this in standard uncertainties, and they
/// are at most one in ten.
const PLAINLY: f64 = 20.0;
const ONE_IN: usize = 10;

/// Share of the largest drop of the sum of squares from which on another one is alike.
const ALIKE: f64 = 0.81;

/// Arrivals before and after a gross error that show where the readings were and where they stay.
const NEIGHBOURS: usize = 4;

/// Share of a gross error by which the readings may stay off.
const STAYS: f64 = 0.5;

/// Share of a gross error by which the nearest readings may differ from those beyond them, where it is the first or
/// last of a table. A warm-up changes most at its start, noise between two means of four is 0.7 of that of a reading,
/// and a gross error is eight of them.
pub(crate) const IS_ON_ITS_WAY: f64 = 0.33;

/// The readings of a table that are gross errors, in its order.
pub(crate) fn gross_errors(
    verification: &Verification,
    comparison: &Comparison<'_>,
) -> Vec<GrossError> {
    let Some(model) = scatter(comparison) else {
        return against_other_side(verification, comparison);
    };
    let count = comparison.arrivals.len();
    let most = most(ACCIDENTS, count);
    let screen = Screen {
        model,
        comparison,
        resolution_um: comparison.resolution_um().unwrap_or_default(),
    };
    let far = far_off(comparison, &comparison.difference_um);
    let are_many = mistakes(comparison, &far) > most as f64;
    let found = match are_many {
        true => screen.isolated(&far),
        false => screen.found(MOST_IN_A_ROW * most),
    };
    let Some(found) = found else {
        return Vec::new();
    };
    let rows: Vec<&[Outlier]> = found.chunk_by(|a, b| a.arrival + 1 == b.arrival).collect();
    if rows.len() > most && !are_many {
        return Vec::new();
    }
    let without = arrivals(&found);
    let off = off_um(comparison, &without);
    // Whole stops at the start of a table may be a warming machine, at its end one that moved.
    let is_start_or_end = |row: &[Outlier]| {
        let are_stops = row
            .iter()
            .any(|outlier| comparison.arrivals[outlier.arrival].readings > 1);
        let is_at_end = |outlier: &Outlier| outlier.arrival == 0 || outlier.arrival + 1 == count;
        are_stops && (row.len() > 1 || row.iter().any(is_at_end))
    };
    let alone = |outlier: &Outlier| match comparison.arrivals[outlier.arrival].readings {
        1 => Contradicts::All,
        _ => Contradicts::OtherStops,
    };
    let outliers = |row: &[Outlier]| -> Vec<(Outlier, Contradicts)> {
        if row.len() > MOST_IN_A_ROW || is_jump(row, &off, &without) || is_start_or_end(row) {
            return Vec::new();
        }
        match screen.rivals(row, &off, &without).as_deref() {
            Some([]) => row
                .iter()
                .map(|outlier| (*outlier, alone(outlier)))
                .collect(),
            Some([other])
                if screen.are_all_of_a_cell(row, other) && !is_start_or_end(&other.outliers) =>
            {
                let both = [row, &other.outliers].concat();
                let said = |outlier| (outlier, Contradicts::TheOther);
                both.into_iter().map(said).collect()
            }
            _ => Vec::new(),
        }
    };
    let mut outliers: Vec<(Outlier, Contradicts)> = rows.into_iter().flat_map(outliers).collect();
    outliers.sort_by_key(|(outlier, _)| outlier.arrival);
    outliers.dedup_by_key(|(outlier, _)| outlier.arrival);
    let said = outliers.into_iter().flat_map(|(outlier, contradicts)| {
        let error = (outlier.error_um, outlier.u_um);
        readings_of(comparison, outlier.arrival)
            .map(move |reading| GrossError::new(verification, reading, error, contradicts))
    });
    said.collect()
}

/// The readings of an arrival.
pub(crate) fn readings_of(comparison: &Comparison<'_>, arrival: usize) -> Range<usize> {
    let before = comparison.arrivals[..arrival].iter();
    let first: usize = before.map(|arrival| arrival.readings).sum();
    first..first + comparison.arrivals[arrival].readings
}

/// What the arrivals are tested with.
struct Screen<'a> {
    model: Projection,
    comparison: &'a Comparison<'a>,
    resolution_um: f64,
}

impl Screen<'_> {
    /// The arrivals that stand out, each beside all others, in their order; `None` if they are more than `most`.
    fn found(&self, most: usize) -> Option<Vec<Outlier>> {
        let mut left = self.model.clone();
        let mut taken: Vec<Outlier> = Vec::new();
        let mut clear = 0;
        while taken.len() <= most {
            let Some(next) = self.largest(&left) else {
                break;
            };
            left = beside(&left, &arrivals(&next.outliers));
            taken.extend(&next.outliers);
            if self.is_clear(&next) {
                clear = taken.len();
            }
        }
        if clear > most {
            return None;
        }
        taken.truncate(clear);
        let arrivals = self.culprits(&taken);
        let judged = (0..arrivals.len()).filter_map(|k| {
            let left = beside(&self.model, &without(&arrivals, k));
            let tested = Outliers::new(&left, &[arrivals[k]], self.resolution_um)?;
            self.is_clear(&tested).then_some(tested.outliers)
        });
        Some(judged.flatten().collect())
    }

    /// Those that are far off, if each is plainly wrong and no two are consecutive.
    fn isolated(&self, far: &[(usize, f64)]) -> Option<Vec<Outlier>> {
        let arrivals: Vec<usize> = far.iter().map(|(arrival, _)| *arrival).collect();
        let are_few = ONE_IN * arrivals.len() <= self.comparison.arrivals.len();
        let are_alone = arrivals.windows(2).all(|two| two[0] + 1 < two[1]);
        let left = self.model.degrees_of_freedom - arrivals.len() as f64;
        if !are_few || !are_alone || left < LEAST_OTHERS {
            return None;
        }
        let outliers = Outliers::new(&self.model, &arrivals, self.resolution_um)?.outliers;
        let is_plain = |outlier: &Outlier| outlier.error_um.abs() > PLAINLY * outlier.u_um;
        outliers.iter().all(is_plain).then_some(outliers)
    }

    /// The arrivals in their order. Beside the offset of their pass, two wrong ones of three or four look like the
    /// others being wrong the other way: then those two, if the means of their positions say so.
    fn culprits(&self, outliers: &[Outlier]) -> Vec<usize> {
        let mut arrivals = arrivals(outliers);
        let off = off_um(self.comparison, &arrivals);
        let passes = passes(self.comparison);
        for outlier in outliers {
            let in_pass = (0..passes.len()).filter(|&k| passes[k] == passes[outlier.arrival]);
            let (own, others): (Vec<usize>, Vec<usize>) =
                in_pass.partition(|k| outliers.iter().any(|outlier| outlier.arrival == *k));
            let is_off =
                |k: &usize| off[*k].is_some_and(|off| off.abs() > outlier.error_um.abs() * STAYS);
            if (1..=MOST_IN_A_ROW).contains(&others.len())
                && others.iter().all(is_off)
                && !own.iter().any(is_off)
            {
                arrivals.retain(|k| !own.contains(k));
                arrivals.extend(others);
            }
        }
        distinct(arrivals)
    }

    /// Whether noise has none like them.
    fn is_clear(&self, tested: &Outliers) -> bool {
        tested.ln_p < (ACCIDENT_LEVEL / self.comparison.arrivals.len() as f64).ln()
    }

    /// All runs of this many consecutive arrivals, those that stand out most first.
    fn tested(&self, left: &Projection, length: usize) -> Vec<Outliers> {
        let all = (0..=self.comparison.arrivals.len() - length).filter_map(|first| {
            let arrivals: Vec<usize> = (first..first + length).collect();
            Outliers::new(left, &arrivals, self.resolution_um)
        });
        let mut all: Vec<Outliers> = all.collect();
        all.sort_by(|a, b| b.drop.total_cmp(&a.drop));
        all
    }

    /// The arrival, or the two consecutive ones, that stand out most, if others may be behind it.
    fn largest(&self, left: &Projection) -> Option<Outliers> {
        if left.degrees_of_freedom - 2.0 < LEAST_OTHERS {
            return None;
        }
        let first = |length| self.tested(left, length).into_iter().next();
        let alone = first(1)?;
        if self.is_clear(&alone) {
            return Some(alone);
        }
        match first(2).filter(|two| self.is_clear(two)) {
            Some(two) => Some(two),
            None => (alone.ln_p < HIDDEN.ln()).then_some(alone),
        }
    }

    /// Other arrivals that explain nearly as much beside all others that stand out (`found`): only how far they are
    /// `off` the means of their positions can then show which are wrong. `None` if they cannot be tested.
    fn rivals(
        &self,
        row: &[Outlier],
        off: &[Option<f64>],
        found: &[usize],
    ) -> Option<Vec<Outliers>> {
        let is_of_row = |arrival: usize| row.iter().any(|own| own.arrival == arrival);
        let is_own = |outlier: &Outlier| is_of_row(outlier.arrival);
        let others = found.iter().copied().filter(|&arrival| !is_of_row(arrival));
        let others: Vec<usize> = others.collect();
        let mut all = self.tested(&beside(&self.model, &others), row.len());
        let own = all.iter().position(|own| own.outliers.iter().all(is_own))?;
        let own = all.remove(own);
        let size_um = size_um(&own.outliers);
        let off = |outlier: &Outlier| off[outlier.arrival].map(|off| off.abs() > STAYS * size_um);
        let is_off = own.outliers.iter().all(|own| off(own) == Some(true));
        let is_in_order =
            |rival: &Outliers| rival.outliers.iter().any(|own| off(own) == Some(false));
        all.retain(|rival| {
            let is_other = !rival.outliers.iter().any(is_own);
            is_other && rival.drop >= ALIKE * own.drop && !(is_off && is_in_order(rival))
        });
        Some(all)
    }

    /// Whether positions were read only by these from their side, twice each: then nothing shows which is wrong.
    fn are_all_of_a_cell(&self, row: &[Outlier], other: &Outliers) -> bool {
        let cells = cells(self.comparison);
        let sizes = sizes(&cells);
        let is_of_two = |(one, other): (&Outlier, &Outlier)| {
            let cell = cells[one.arrival];
            cell == cells[other.arrival] && sizes[cell] == 2
        };
        // A pass there and one there again, or one there and one back from the same side, in the other order.
        let [first, second] = [row, &other.outliers];
        let mut pairs = first.iter().zip(second);
        let mut reversed = first.iter().zip(second.iter().rev());
        first.len() == second.len() && (pairs.all(is_of_two) || reversed.all(is_of_two))
    }
}

fn arrivals(outliers: &[Outlier]) -> Vec<usize> {
    outliers.iter().map(|outlier| outlier.arrival).collect()
}

/// Mean absolute error of outliers.
fn size_um(outliers: &[Outlier]) -> f64 {
    let errors = outliers.iter().map(|outlier| outlier.error_um.abs());
    mean(&errors.collect::<Vec<f64>>())
}

/// A model in which these arrivals have values of their own.
fn beside(model: &Projection, arrivals: &[usize]) -> Projection {
    let own = arrivals.iter().map(|&arrival| {
        let mut column = vec![0.0; model.rows()];
        column[arrival] = 1.0;
        column
    });
    model.extended(&own.collect::<Vec<Vec<f64>>>())
}

/// Whether the readings after an outlier, or two consecutive ones, stay there, or were there before. At an end of the
/// table, where none are on one side, whether the nearest on the other approach it: then it is the end of a warm-up
/// or of a drift. `off` is how far each is off the mean of its position; what was `found` to stand out is ignored.
fn is_jump(row: &[Outlier], off: &[Option<f64>], found: &[usize]) -> bool {
    let ([first, ..], [.., last]) = (row, row) else {
        return false;
    };
    let mean_of = |rows: &mut dyn Iterator<Item = usize>, nearer: usize| {
        let kept = rows.filter(|k| !found.contains(k)).skip(nearer);
        let off: Vec<f64> = kept.take(NEIGHBOURS).filter_map(|k| off[k]).collect();
        (!off.is_empty()).then(|| mean(&off))
    };
    let before = |nearer| mean_of(&mut (0..first.arrival).rev(), nearer);
    let after = |nearer| mean_of(&mut (last.arrival + 1..off.len()), nearer);
    let is_more = |a: f64, b: f64, part: f64| (b - a).abs() > part * size_um(row);
    match (before(0), after(0)) {
        (Some(before), Some(after)) => is_more(before, after, STAYS),
        (Some(near), None) => {
            before(NEIGHBOURS).is_some_and(|far| is_more(far, near, IS_ON_ITS_WAY))
        }
        (None, Some(near)) => {
            after(NEIGHBOURS).is_some_and(|far| is_more(near, far, IS_ON_ITS_WAY))
        }
        (None, None) => false,
    }
}

/// How far each arrival is off the mean of the others at its position and side, µm; `None` where there is no other.
/// Arrivals `without` are in no mean.
fn off_um(comparison: &Comparison<'_>, without: &[usize]) -> Vec<Option<f64>> {
    let cells = cells(comparison);
    let off = |row: usize| {
        let others = (0..cells.len()).filter(|other| {
            cells[*other] == cells[row] && *other != row && !without.contains(other)
        });
        let others: Vec<f64> = others.map(|k| comparison.difference_um[k]).collect();
        (!others.is_empty()).then(|| comparison.difference_um[row] - mean(&others))
    };
    (0..cells.len()).map(off).collect()
}
