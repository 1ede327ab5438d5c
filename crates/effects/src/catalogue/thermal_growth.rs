//! Something grows with a logged temperature ϑ, at once or with a first-order lag: what a carrier holds moves,
//! `D_p = g (ϑ - ϑ0)`, or the scale of a linear axis grows, the axis goes `α q (ϑ - ϑ0)` further.
//!
//! g is `growth_x`, `growth_y`, `growth_z` in µm/K, in the reference frame; α is `expansion` in ppm/K. ϑ is that of
//! the column, ϑ0 its value at the first reading; with a lag T (`time_constant` in s, 0 without) ϑ follows the
//! column by `T ϑ' = column - ϑ`.

use std::collections::BTreeSet;

use nalgebra::Vector3;
use trueaxis_kinematics::{AxisKind, MICROMETRE};

use crate::form::AtReading;
use crate::{Effect, Explanation, Form, Layer, Level, Medium, PPM, Parameter, Shape};
use crate::{Scene, Subject};

pub(super) const EFFECT: Effect = Effect {
    id: "thermal_growth",
    layer: Layer::Machine,
    levels: &[Level::Lengths],
    subjects,
    parameters: |_, subject| match subject.axis {
        Some(_) => vec![Parameter::new("expansion", "ppm/K").plausible(EXPANSION_PPM_PER_K)],
        None => {
            let growth = Parameter::vector("growth", "um/K").into_iter();
            growth.map(|g| g.plausible(GROWTH_UM_PER_K)).collect()
        }
    },
    shape: Shape::Lag,
    form: Form::Displacement(grown),
    explanation: Explanation {
        cause: "a part of the machine grows with the temperature that was logged: spindle, column, screw or scale",
        consequence: "the results hold at the temperatures of the measurement only, and differ from run to run",
        action: "let the control compensate with this coefficient and this sensor, or keep the temperature; calibrate --with-effects takes it out to the temperature at the start",
        separate_by: "let the temperature not simply follow time: warm up, cool down and warm up again between the runs, and log it",
    },
};

/// From glass ceramics and carbon fibre, which may shrink, to aluminium.
const EXPANSION_PPM_PER_K: [f64; 2] = [-1.0, 25.0];

/// Two metres of steel, or one of aluminium, either way.
const GROWTH_UM_PER_K: [f64; 2] = [-25.0, 25.0];

/// Each column with each carrier of targets and with each linear axis.
fn subjects(scene: &Scene) -> Vec<Subject> {
    let carriers: BTreeSet<usize> = scene.targets.iter().filter_map(|t| t.carrier).collect();
    let of_column = |column: usize| {
        let carriers = carriers.clone().into_iter().map(Subject::carrier);
        let axes = scene.moving_axes(AxisKind::Linear).map(Subject::axis);
        let all = carriers.chain(axes);
        all.map(|subject| subject.with_column(column))
            .collect::<Vec<_>>()
    };
    scene
        .columns_of(Medium::Machine)
        .flat_map(of_column)
        .collect()
}

/// Displacement for one unit of a parameter, mm.
fn grown(of: &AtReading<'_>) -> Vector3<f64> {
    let warmer_k = of.warmer_k();
    match of.subject.axis {
        Some(axis) => of.at.unit_motion(axis) * (PPM * warmer_k * of.position()),
        None => Vector3::ith(of.parameter, MICROMETRE * warmer_k),
    }
}
