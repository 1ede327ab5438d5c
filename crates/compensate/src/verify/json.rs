//! `verification.json`.

use serde_json::{Value, json};
use trueaxis_campaign::VerificationKind;
use trueaxis_files::round;
use trueaxis_kinematics::{ARCSEC, Machine};
use trueaxis_predict::{CalibratedMachine, position_in_file};

use crate::verify::iso_230_2::{Positioning, Side};
use crate::verify::parallel_lines::ParallelLines;
use crate::verify::{EXPECTED_ABOVE_ONE, Point, Verified};

/// Decimals of µm and `E_n`.
const DECIMALS: i32 = 4;

/// The document of all verifications of the campaign of this name, and of the angles that parallel lines tell.
pub fn verification_json(
    machine: &CalibratedMachine,
    campaign: &str,
    is_compensated: bool,
    verified: &[Verified],
    lines: &[ParallelLines],
) -> Value {
    let nominal = machine.machine();
    let mut document = json!({
        "format": "trueaxis-verification",
        "version": 1,
        "machine": machine.name,
        "calibration": machine.campaign,
        "campaign": campaign,
        "effects_taken_out": machine.effects_taken_out,
        "compensated": is_compensated,
        "expected_above_one": EXPECTED_ABOVE_ONE,
        "verification": verified.iter().map(|v| entry(nominal, v)).collect::<Value>(),
    });
    if !lines.is_empty() {
        let lines = lines.iter();
        document["parallel_lines"] = lines.map(|l| parallel(nominal, l)).collect();
    }
    document
}

fn parallel(machine: &Machine, found: &ParallelLines) -> Value {
    let name = machine.axes()[found.axis].name();
    let arcsec = |values: &[f64]| -> Value {
        let values = values.iter().map(|x| json!(round(x / ARCSEC, DECIMALS)));
        values.collect()
    };
    let components = found.angles.iter().map(|curve| {
        let mut value = json!({
            "measured_arcsec": arcsec(&curve.measured),
            "predicted_arcsec": arcsec(&curve.predicted),
            "u_predicted_arcsec": arcsec(&curve.u_predicted),
            "largest_difference_arcsec": round(curve.largest_difference() / ARCSEC, DECIMALS),
        });
        if let Some(u) = &curve.u_measured {
            value["u_measured_arcsec"] = arcsec(u);
        }
        (curve.component.name(name), value)
    });
    let positions = found.positions.iter().map(|q| json!(round(*q, 9)));
    json!({
        "axis": name,
        "lines": found.lines,
        "positions": positions.collect::<Value>(),
        "components": components.collect::<Value>(),
    })
}

fn entry(machine: &Machine, verified: &Verified) -> Value {
    let (above, all) = verified.above_one();
    let mut entry = json!({
        "name": verified.name,
        "kind": match verified.kind {
            Some(VerificationKind::Positioning { .. }) => "positioning",
            Some(VerificationKind::Ballbar { .. }) => "ballbar",
            None => "points",
        },
        "points": verified.points.iter().map(|p| point(machine, p)).collect::<Value>(),
    });
    if let Some(p) = verified.p_value {
        entry["e_n"] = json!({
            "count": all,
            "above_one": above,
            "p_value": round(p, DECIMALS),
            "misfit": verified.is_misfit(),
        });
    }
    if !verified.positioning.is_empty() {
        let lines = verified.positioning.iter();
        entry["iso_230_2"] = lines
            .map(|(at, line)| positioning(machine, at, line))
            .collect();
    }
    if let Some(circular) = verified.circular {
        entry["iso_230_4"] = without_nulls([
            ("G_forward_um", circular.g_forward_um),
            ("G_backward_um", circular.g_backward_um),
            ("Gb_um", circular.g_both_um),
            ("H_um", circular.h_um),
            ("Fmin_forward_um", circular.f_forward_um.map(|f| f[0])),
            ("Fmax_forward_um", circular.f_forward_um.map(|f| f[1])),
            ("Fmin_backward_um", circular.f_backward_um.map(|f| f[0])),
            ("Fmax_backward_um", circular.f_backward_um.map(|f| f[1])),
            ("D_um", circular.d_um),
        ]);
    }
    entry
}

fn at(machine: &Machine, positions: &[f64]) -> Value {
    let axes = machine.axes().iter().zip(positions);
    let cells = axes.map(|(axis, &q)| (axis.name(), position_in_file(axis.kind(), q)));
    cells.collect()
}

fn point(machine: &Machine, point: &Point) -> Value {
    let um = |value: f64| json!(round(value, DECIMALS));
    let mut value = json!({
        "at": at(machine, &point.positions),
        "readings": point.readings,
        "reading_um": um(point.reading_um),
        "predicted_um": um(point.predicted_um),
        "first_order_um": um(point.first_order_um),
        "compensated_um": um(point.compensated_um),
        "u_prediction_um": um(point.u_prediction_um),
    });
    if let Some(direction) = point.direction {
        value["direction"] = json!(direction.sign());
    }
    if let Some(checked) = point.checked {
        value["point_mm"] = json!(checked.tool_home_mm.coords.as_slice());
        value["coordinate"] = json!(["x", "y", "z"][checked.coordinate]);
    }
    if let Some((u, e_n)) = point.u_reading_um.zip(point.e_n) {
        value["u_reading_um"] = um(u);
        value["e_n"] = um(e_n);
    }
    value
}

fn positioning(machine: &Machine, line: &[f64], found: &Positioning) -> Value {
    let mut value = json!({
        "from": at(machine, line),
        "runs": found.runs,
        "fewer_runs_than_the_standard": found.is_short,
    });
    for (name, side) in ["forward", "backward", "bidirectional"]
        .iter()
        .zip(&found.sides)
    {
        if let Some(Side { a_um, e_um, r_um }) = *side {
            value[*name] = without_nulls([("A_um", a_um), ("E_um", Some(e_um)), ("R_um", r_um)]);
        }
    }
    let rest = without_nulls([
        ("B_um", found.b_um),
        ("mean_B_um", found.mean_b_um),
        ("M_um", found.m_um),
    ]);
    if let (Value::Object(value), Value::Object(rest)) = (&mut value, rest) {
        value.extend(rest);
    }
    value
}

fn without_nulls<const N: usize>(fields: [(&str, Option<f64>); N]) -> Value {
    let there = fields
        .into_iter()
        .filter_map(|(name, value)| Some((name, value?)));
    there
        .map(|(name, value)| (name.to_owned(), json!(round(value, DECIMALS))))
        .collect()
}
