//! Whether anything is left at all: F tests of smooth functions, each through the model's projection.
//!
//! | varies with | columns |
//! | --- | --- |
//! | `time` | twelve half waves of time, for each direction and about each (the frame, or the machine) |
//! | `target` | four half waves of time for each target and direction |
//! | `position` | four half waves of the position of each axis for each target and direction |
//! | `direction` | the side of approach, alone and times two half waves of the position, the same way |

use nalgebra::Vector3;
use rayon::prelude::*;
use trueaxis_leastsquares::half_waves;

use crate::engine::{Found, Level};
use crate::lengths::{OMNIBUS_LEVEL, Omnibus, family_wise};
use crate::points::base::Base;
use crate::points::model::Model;
use crate::points::readings::Reading;
use crate::selection::{Fit, Projection};

const OF_TIME: u32 = 12;
const OF_TARGET: u32 = 4;
const OF_POSITION: u32 = 4;
const OF_DIRECTION: u32 = 2;

/// A test that takes more of the degrees of freedom than this part says little.
const MOST_OF_FREEDOM: f64 = 1.0 / 3.0;

/// Columns that the residuals may vary with.
pub(crate) struct Family {
    varies_with: &'static str,
    columns_mm: Vec<Vec<f64>>,
}

/// All families.
pub(crate) fn families(base: &Base<'_>) -> Vec<Family> {
    let (axes, targets) = (base.scene.machine.axes().len(), base.scene.targets.len());
    let travelled = travelled(base);
    let centre: Vector3<f64> = {
        let sum: Vector3<f64> = base.readings.all.iter().map(|r| r.measured_mm.coords).sum();
        sum / base.readings.all.len().max(1) as f64
    };
    let arms = base.readings.all.iter();
    let arms = arms.map(|r| (r.measured_mm.coords - centre).norm());
    let arm_mm = arms.fold(1.0, f64::max);
    let of_time = OF_TIME as usize;
    let time = columns(base, 6 * of_time, |_, r, column| {
        let (k, motion) = (column / 6, column % 6);
        let wave = wave(r.progress, k);
        match motion.checked_sub(3) {
            None => Vector3::ith(motion, wave),
            Some(about) => {
                let arm = (r.measured_mm.coords - centre) / arm_mm;
                Vector3::ith(about, wave).cross(&arm)
            }
        }
    });
    let target = columns(base, 3 * targets * OF_TARGET as usize, |_, r, column| {
        let (k, own) = (column / 3 / targets, column / 3 % targets);
        let wave = if own == r.target {
            wave(r.progress, k)
        } else {
            0.0
        };
        Vector3::ith(column % 3, wave)
    });
    // Of one axis, one target and one direction.
    let concerns = |r: &Reading, number: usize| {
        r.axis == Some(number / targets % axes) && r.target == number % targets
    };
    let each = axes * targets;
    let position = columns(base, 3 * each * OF_POSITION as usize, |i, r, column| {
        let (k, own) = (column / 3 / each, column / 3 % each);
        let wave = if concerns(r, own) {
            wave(travelled[i], k)
        } else {
            0.0
        };
        Vector3::ith(column % 3, wave)
    });
    let sides = 1 + OF_DIRECTION as usize;
    let direction = columns(base, 3 * each * sides, |i, r, column| {
        let (k, own) = (column / 3 / each, column / 3 % each);
        let form = k.checked_sub(1).map_or(1.0, |k| wave(travelled[i], k));
        let value = if concerns(r, own) { r.side * form } else { 0.0 };
        Vector3::ith(column % 3, value)
    });
    let family = |varies_with, columns_mm| Family {
        varies_with,
        columns_mm,
    };
    vec![
        family("time", time),
        family("target", target),
        family("position", position),
        family("direction", direction),
    ]
}

/// The `k`-th half wave, from 0.
fn wave(x: f64, k: usize) -> f64 {
    half_waves(x, OF_TIME).nth(k).unwrap_or(0.0)
}

/// Where the axis of each point stands in the range that it was measured in, 0 to 1.
fn travelled(base: &Base<'_>) -> Vec<f64> {
    let position = |r: &Reading| {
        let axis = r.axis?;
        Some((axis, base.campaign.steps[r.step].positions[axis]))
    };
    let mut ranges = vec![[f64::INFINITY, f64::NEG_INFINITY]; base.scene.machine.axes().len()];
    for (axis, q) in base.readings.all.iter().filter_map(position) {
        ranges[axis] = [ranges[axis][0].min(q), ranges[axis][1].max(q)];
    }
    let part = |r: &Reading| {
        let (axis, q) = position(r)?;
        let [low, high] = ranges[axis];
        (high > low).then(|| (q - low) / (high - low))
    };
    base.readings
        .all
        .iter()
        .map(|r| part(r).unwrap_or(0.0))
        .collect()
}

/// Columns of coordinates that are not nothing.
fn columns(
    base: &Base<'_>,
    count: usize,
    value: impl Fn(usize, &Reading, usize) -> Vector3<f64> + Sync,
) -> Vec<Vec<f64>> {
    let column = |number: usize| -> Vec<f64> {
        let readings = base.readings.all.iter().enumerate();
        readings
            .flat_map(|(i, r)| <[f64; 3]>::from(base.in_rows(value(i, r, number))))
            .collect()
    };
    let all: Vec<Vec<f64>> = (0..count).into_par_iter().map(column).collect();
    let is_something = |column: &Vec<f64>| column.iter().any(|&x| x != 0.0);
    all.into_iter().filter(is_something).collect()
}

/// The tests of what a model leaves; p-values family-wise over all of them.
pub(crate) fn omnibus(base: &Base<'_>, families: &[Family], model: &Model) -> Vec<Omnibus> {
    let most = MOST_OF_FREEDOM * model.projection.degrees_of_freedom;
    let tested = families.par_iter().map(|family| {
        let columns = model.whitened(base, &family.columns_mm);
        Omnibus::of(family.varies_with, &model.projection, &columns)
    });
    let mut tested: Vec<Omnibus> = tested.collect();
    tested.retain(|o| o.test.columns > 0 && o.test.columns as f64 <= most);
    family_wise(tested)
}

/// What is left in columns, times the part of a cause's trace that lies in them, in squares of that trace, from which
/// the cause is taken for an imitation; and the same of one course in time, since what wanders looks like a jump or a
/// drift in most of its squares.
const TOO_MUCH_LEFT: f64 = 0.25;
const TOO_MUCH_OF_TIME: f64 = 1.0 / 19.0;

/// Whether a cause merely takes a part of what is left in the same columns.
pub(crate) fn is_imitation(
    base: &Base<'_>,
    families: &[Family],
    model: &Model,
    left: &[Omnibus],
    cause: &Found,
) -> bool {
    let columns = base.columns(model)(&cause.suspect.hypothesis, cause.suspect.shape);
    let trace = Fit::new(&model.bare, &columns).explained;
    let squares: f64 = trace.iter().map(|x| x * x).sum();
    let too_much = match cause.suspect.hypothesis.is_of_time() {
        true => TOO_MUCH_OF_TIME,
        false => TOO_MUCH_LEFT,
    };
    let clear = left.iter().filter(|t| t.test.p_value < OMNIBUS_LEVEL);
    clear.into_iter().any(|omnibus| {
        let own = families
            .iter()
            .filter(|f| f.varies_with == omnibus.test.varies_with);
        own.into_iter().any(|family| {
            let columns = model.whitened(base, &family.columns_mm);
            part_within(&model.bare, &columns, &trace) * omnibus.excess > too_much * squares
        })
    })
}

/// Part of the squares of a trace that lies in columns, both after the projection.
fn part_within(model: &Projection, columns: &[Vec<f64>], trace: &[f64]) -> f64 {
    let squares: f64 = trace.iter().map(|x| x * x).sum();
    let mut rest = trace.to_vec();
    model.extended(columns).project(&mut rest);
    let left: f64 = rest.iter().map(|x| x * x).sum();
    1.0 - left / squares.max(f64::MIN_POSITIVE)
}
