//! Points that contradict all others, such as that of a wrong target or one written down wrongly.
//!
//! The three columns of one point are tested against what the other points leave ([`Tested`]).
//!
//! A stop whose points are all off by the same (the machine had not arrived, or was leant on) is tested as one, with
//! three columns for all its points. More than a few, or several consecutive ones of one target, are structure and
//! stay. Where two of one step explain the contradiction equally, nothing shows which is wrong, and both leave.

use nalgebra::{Matrix3, Vector3};
use trueaxis_campaign::Points;
use trueaxis_leastsquares::dot;
use trueaxis_selection::Gram;

use crate::Rejected;
use crate::engine::{ACCIDENT_LEVEL, ACCIDENTS, LEAST_OTHERS, Tested, most};
use crate::numbers::distinct;
use crate::points::base::Base;
use crate::points::model::{Model, left_of};
use crate::points::readings::Reading;

/// Points that stand out by less than this share of the largest wait: that one may be what they contradict.
const AT_ONCE: f64 = 0.5;

/// Ratio of two points of one step from which either may be the wrong one.
const ALIKE: f64 = 0.9;

/// From this number on, consecutive wrong points of one target, or stops, are no accidents. Stops are fewer than a jump
/// has on its far side: a machine may be read too early several times in succession.
const IN_A_ROW: usize = 3;
const STOPS_IN_A_ROW: usize = 4;

/// A point, or all those of a stop, that contradict the others.
#[derive(Debug, Clone)]
pub(crate) struct Gross {
    pub(crate) points: Vec<Wrong>,
    stop: usize,
    pub(crate) step: usize,
    statistic: f64,
    error_um: f64,
    u_um: f64,
    is_alone: bool,
}

/// A point that is left out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Wrong {
    /// Its number among the points of the campaign.
    pub(crate) number: usize,
    line: usize,
    target: usize,
}

impl Gross {
    /// Its entries in the result file.
    pub(crate) fn rejected(&self) -> impl Iterator<Item = Rejected> {
        let reason = match (self.points.len() > 1, self.is_alone) {
            (false, true) => "contradicts all other points",
            (false, false) => {
                "one of the points of this step contradicts the others, and nothing tells which: measure the step again"
            }
            (true, true) => {
                "all points of this stop are off by the same against the other stops of this step"
            }
            (true, false) => {
                "the stops of this step contradict each other, and nothing tells which is wrong: measure the step again"
            }
        };
        self.points.iter().map(move |point| Rejected {
            file: "points.csv".to_owned(),
            row: point.line,
            error_um: self.error_um,
            u_um: self.u_um,
            reason: reason.to_owned(),
        })
    }

    /// Whether one is the stop of the other.
    fn holds(&self, other: &Self) -> bool {
        self.stop == other.stop && (self.points.len() > 1 || other.points.len() > 1)
    }
}

impl Wrong {
    fn of(reading: &Reading) -> Self {
        Self {
            number: reading.number,
            line: reading.line,
            target: reading.target,
        }
    }
}

/// The points that stand out in what a model leaves, at once; the rest must be adjusted again.
pub(crate) fn stand_out(base: &Base<'_>, model: &Model) -> Vec<Gross> {
    let projection = &model.projection;
    let left = (projection.squares(), projection.degrees_of_freedom);
    let tests = base.readings.all.len() + base.readings.stops.len();
    let limit = (ACCIDENT_LEVEL / tests as f64).ln();
    let mut found: Vec<Gross> = Vec::new();
    for (stop_number, stop) in base.readings.stops.iter().enumerate() {
        let points = &base.readings.all[stop.clone()];
        let each = stop.clone().map(|i| i..i + 1);
        // A stop of one point is already tested as that point.
        let whole = (points.len() > 1).then(|| stop.clone());
        for wrong in each.chain(whole) {
            let column = |k: usize| {
                let mut column = vec![0.0; 3 * stop.len()];
                for i in wrong.clone() {
                    let first = 3 * (i - stop.start);
                    let error: [f64; 3] = base.in_rows(i, Vector3::ith(k, 1.0)).into();
                    column[first..first + 3].copy_from_slice(&error);
                }
                model.whitening[stop_number].apply(&mut column);
                column
            };
            let columns: Vec<Vec<f64>> = (0..3).map(column).collect();
            let first = 3 * stop.start;
            let residuals = &projection.residuals[first..first + 3 * stop.len()];
            let s: Vec<f64> = columns.iter().map(|c| dot(c, residuals)).collect();
            let before: Vec<f64> = columns.iter().map(|c| dot(c, c)).collect();
            let gram = Gram::new(&left_of(projection, first, &columns), &before);
            let tested = Tested::new(left, (&gram, &s), 0.0);
            let others = left.1 - gram.rank() as f64;
            if others < LEAST_OTHERS || tested.ln_p > limit {
                continue;
            }
            let error = Vector3::from_column_slice(&tested.errors);
            let covariance = Matrix3::from_column_slice(&tested.covariance);
            let unit = error.normalize();
            found.push(Gross {
                stop: stop_number,
                step: points[0].step,
                statistic: tested.drop,
                error_um: 1e3 * error.norm(),
                u_um: 1e3 * unit.dot(&(covariance * unit)).max(0.0).sqrt(),
                is_alone: true,
                points: wrong.map(|i| Wrong::of(&base.readings.all[i])).collect(),
            });
        }
    }
    first_of_steps(found)
}

/// The largest of each step, unless it is much smaller than the largest of all, with those nearly as large.
fn first_of_steps(mut found: Vec<Gross>) -> Vec<Gross> {
    found.sort_by(|a, b| b.statistic.total_cmp(&a.statistic));
    let largest = found.first().map_or(0.0, |first| first.statistic);
    let mut out: Vec<Gross> = Vec::new();
    for gross in found {
        if gross.statistic < AT_ONCE * largest {
            break;
        }
        // A whole stop and a point of it are one alternative.
        if out.iter().any(|other| other.holds(&gross)) {
            continue;
        }
        let first = out.iter_mut().find(|other| other.step == gross.step);
        match first {
            Some(first) if gross.statistic < ALIKE * first.statistic => {}
            Some(first) => {
                first.is_alone = false;
                let is_alone = false;
                out.push(Gross { is_alone, ..gross });
            }
            None => out.push(gross),
        }
    }
    out
}

/// Whether these are so few and so scattered that they are accidents.
pub(crate) fn are_accidents(gross: &[Gross], base: &Base<'_>, points: &Points) -> bool {
    let steps = distinct(gross.iter().map(|own| own.step)).len();
    if steps > most(ACCIDENTS, points.readings.len()) {
        return false;
    }
    // In measuring order, target by target.
    let mut in_a_row = vec![[0, 1]; base.scene.targets.len()];
    let mut readings = points.readings.iter().enumerate();
    let are_few = readings.all(|(number, reading)| {
        let row = &mut in_a_row[reading.target];
        let is_own = |w: &Wrong| w.number == number && w.target == reading.target;
        let own = gross.iter().find(|g| g.points.iter().any(is_own));
        *row = match own {
            Some(gross) if gross.points.len() > 1 => [row[0], row[1] + 1],
            Some(_) => [row[0] + 1, row[1] + 1],
            None => [0; 2],
        };
        row[0] < IN_A_ROW && row[1] < STOPS_IN_A_ROW
    });
    // At the last end of the table, as at the first (where the count begins with one), a frame may have jumped: one stop less.
    are_few && in_a_row.iter().all(|row| row[1] + 1 < STOPS_IN_A_ROW)
}
