//! `verification.json`.

use serde_json::{Value, json};
use trueaxis_campaign::VerificationKind;
use trueaxis_files::{round, without_nulls};
use trueaxis_kinematics::{ARCSEC, Axis, AxisKind, Machine};
use trueaxis_predict::{CalibratedMachine, position_in_file};

use crate::verify::iso_230_2::{Positioning, Side};
use crate::verify::iso_230_4::Circular;
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
    let lines = lines.iter().map(|l| parallel(nominal, l));
    without_nulls(json!({
        "format": "trueaxis-verification",
        "version": 1,
        "machine": machine.name,
        "rotary_axes": nominal.axes().iter().filter(|axis| axis.kind() == AxisKind::Rotary).map(Axis::name).collect::<Value>(),
        "calibration": machine.campaign,
        "campaign": campaign,
        "effects_taken_out": machine.names_taken_out(),
        "compensated": is_compensated,
        "expected_above_one": EXPECTED_ABOVE_ONE,
        "verification": verified.iter().map(|v| entry(nominal, v)).collect::<Value>(),
        "parallel_lines": if_any(lines),
    }))
}

/// Entries as a list; none if there are none.
fn if_any(entries: impl Iterator<Item = Value>) -> Option<Vec<Value>> {
    Some(entries.collect::<Vec<_>>()).filter(|all| !all.is_empty())
}

/// µm or `E_n`.
fn rounded(value: Option<f64>) -> Option<f64> {
    value.map(|value| round(value, DECIMALS))
}

fn parallel(machine: &Machine, found: &ParallelLines) -> Value {
    let name = machine.axes()[found.axis].name();
    let arcsec = |values: &[f64]| -> Value {
        let values = values.iter().map(|x| json!(round(x / ARCSEC, DECIMALS)));
        values.collect()
    };
    let components = found.angles.iter().map(|curve| {
        let value = without_nulls(json!({
            "measured_arcsec": arcsec(&curve.measured),
            "predicted_arcsec": arcsec(&curve.predicted),
            "u_predicted_arcsec": arcsec(&curve.u_predicted),
            "largest_difference_arcsec": round(curve.largest_difference() / ARCSEC, DECIMALS),
            "u_measured_arcsec": curve.u_measured.as_deref().map(arcsec),
        }));
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
    let lines = verified.positioning.iter();
    without_nulls(json!({
        "name": verified.name,
        "kind": match verified.kind {
            Some(VerificationKind::Positioning { .. }) => "positioning",
            Some(VerificationKind::Ballbar { .. }) => "ballbar",
            None => "points",
        },
        "points": verified.points.iter().map(|p| point(machine, p)).collect::<Value>(),
        "e_n": verified.p_value.map(|p| json!({
            "count": all,
            "above_one": above,
            "p_value": round(p, DECIMALS),
            "misfit": verified.is_misfit(),
        })),
        "iso_230_2": if_any(lines.map(|(at, line)| positioning(machine, at, line))),
        "iso_230_4": verified.circular.as_ref().map(circular),
    }))
}

fn circular(found: &Circular) -> Value {
    let [forward, backward] = [found.f_forward_um, found.f_backward_um];
    without_nulls(json!({
        "G_forward_um": rounded(found.g_forward_um),
        "G_backward_um": rounded(found.g_backward_um),
        "Gb_um": rounded(found.g_both_um),
        "H_um": rounded(found.h_um),
        "Fmin_forward_um": rounded(forward.map(|f| f[0])),
        "Fmax_forward_um": rounded(forward.map(|f| f[1])),
        "Fmin_backward_um": rounded(backward.map(|f| f[0])),
        "Fmax_backward_um": rounded(backward.map(|f| f[1])),
        "D_um": rounded(found.d_um),
    }))
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
    let side = |side: &Side| {
        without_nulls(json!({
            "A_um": rounded(side.a_um),
            "E_um": round(side.e_um, DECIMALS),
            "R_um": rounded(side.r_um),
        }))
    };
    let [forward, backward, both] = found.sides.each_ref().map(|of| of.as_ref().map(side));
    without_nulls(json!({
        "from": at(machine, line),
        "runs": found.passes,
        "fewer_runs_than_the_standard": found.is_short,
        "forward": forward,
        "backward": backward,
        "bidirectional": both,
        "B_um": rounded(found.b_um),
        "mean_B_um": rounded(found.mean_b_um),
        "M_um": rounded(found.m_um),
    }))
}
