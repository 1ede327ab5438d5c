//! `comparison.json`: what has changed between two calibrations of a machine.

use serde_json::{Value, json};
use trueaxis_files::{round, without_nulls};
use trueaxis_kinematics::{Axis, AxisKind};

use crate::calibrated_machine::CalibratedMachine;
use crate::compare::Difference;
use crate::position_in_file;

/// Decimals of µm and ″.
const DECIMALS: i32 = 4;

/// The differences of two calibrations ([`CalibratedMachine::compare`]), one slice for each curve and location error.
pub fn comparison_json(
    first: &CalibratedMachine,
    second: &CalibratedMachine,
    curves: &[&[Difference]],
) -> Value {
    let axes = second.machine().axes();
    let entry = |curve: &&[Difference]| {
        let (unit, suffix) = curve[0].unit();
        let column = |of: &dyn Fn(&Difference) -> f64| -> Value {
            let values = curve.iter().map(|d| json!(round(of(d) / unit, DECIMALS)));
            values.collect()
        };
        let in_file = |d: &Difference, q| position_in_file(axes[d.axis].kind(), q);
        let positions = curve.iter().filter_map(|d| Some(in_file(d, d.position?)));
        let positions: Vec<f64> = positions.collect();
        let value = without_nulls(json!({
            format!("first_{suffix}"): column(&|d| d.first),
            format!("difference_{suffix}"): column(&Difference::value),
            format!("u_{suffix}"): column(&|d| d.u),
            "positions": (!positions.is_empty()).then_some(positions),
            "beyond_noise": curve.iter().filter(|d| d.is_beyond_noise()).count(),
            "follows_from_other_steps": curve[0].follows_from_other_steps.then_some(true),
        }));
        (curve[0].name.clone(), value)
    };
    let lines = first.other_steps(second).into_iter();
    let common: serde_json::Map<String, Value> = lines
        .filter_map(|(axis, kind, positions)| {
            let in_file = |q: &f64| position_in_file(kind, *q);
            let positions: Vec<f64> = positions?.iter().map(in_file).collect();
            Some((axis.to_owned(), json!(positions)))
        })
        .collect();
    let rotary = axes.iter().filter(|axis| axis.kind() == AxisKind::Rotary);
    let rotary: Vec<&str> = rotary.map(Axis::name).collect();
    without_nulls(json!({
        "format": "trueaxis-comparison",
        "version": 1,
        "machine": second.name,
        "first": first.campaign,
        "second": second.campaign,
        "rotary_axes": (!rotary.is_empty()).then_some(rotary),
        "common_positions": (!common.is_empty()).then_some(common),
        "differences": curves.iter().map(entry).collect::<Value>(),
    }))
}
