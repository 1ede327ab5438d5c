//! Numbers and names of a diagnosis in the words of the terminal.

use trueaxis_diagnose::{Cause, EstimatedParameter, LostMotionAt};
use trueaxis_effects::{ResolvedEffect, Scene};
use trueaxis_files::{
    decimals, probability, told_behind, told_effect, told_places, told_span, told_unit,
};

use crate::summary::COVERAGE;

/// `machine shift`, `dead path jump of station S2`.
pub(crate) fn effect(effect: &ResolvedEffect, scene: &Scene) -> String {
    let given = effect.to_given(scene);
    let subject = serde_json::to_value(given.subject).unwrap_or_default();
    told_effect(&given.effect, |field| subject[field].as_str())
}

/// Values with expanded uncertainties, vectors together: `shift x +3.10 ± 0.40, y … µm; at 5210 ± 8 s`.
pub(crate) fn parameters(parameters: &[EstimatedParameter]) -> String {
    let parameters: Vec<EstimatedParameter> = parameters.iter().map(as_told).collect();
    let mut parts: Vec<String> = Vec::new();
    let mut rest = parameters.as_slice();
    while let Some(first) = rest.first() {
        let (group, others) = rest.split_at(vector_at(rest));
        rest = others;
        if group.len() == 3 {
            let stem = first.name.trim_end_matches("_x").replace('_', " ");
            let along = group.iter().zip(["x", "y", "z"]);
            let values: Vec<String> = along
                .map(|(p, axis)| format!("{axis} {}", number(p)))
                .collect();
            parts.push(format!("{stem} {}{}", values.join(", "), unit(first.unit)));
            continue;
        }
        let name = match first.name.as_str() {
            "time" => "at".to_owned(),
            name => name.replace('_', " "),
        };
        parts.push(match first.name.as_str() {
            "period" if !first.u.is_finite() => {
                format!("{name} at most {:.1}{}", first.value, unit(first.unit))
            }
            "time" | "time_constant" | "period" => {
                format!("{name} {}{}", plain(first), unit(first.unit))
            }
            "waves" if first.u > 0.0 => {
                format!(
                    "{:.0} ± {:.0} waves per turn",
                    first.value,
                    COVERAGE * first.u
                )
            }
            "waves" => format!("{:.0} waves per turn", first.value),
            _ => format!(
                "{name} {}{}{}",
                number(first),
                unit(first.unit),
                told_span(&first.name)
            ),
        });
    }
    parts.join("; ")
}

/// In the unit in which it is told.
fn as_told(parameter: &EstimatedParameter) -> EstimatedParameter {
    let (unit, size) = told_unit(parameter.value, parameter.unit);
    EstimatedParameter {
        value: parameter.value / size,
        u: parameter.u / size,
        unit,
        ..parameter.clone()
    }
}

/// The ends of a free form: `from -12.0 ± 5.2 µm at -4 mm to +104.7 ± 5.2 µm at 0 mm`; none without one.
pub(crate) fn curve(cause: &Cause) -> Option<String> {
    let (unit, of_position) = match cause.has_angular_curve()? {
        true => ("″", "°"),
        false => (" µm", " mm"),
    };
    let places = told_places(cause.curve.iter().map(|point| point.at));
    let point = |point: &LostMotionAt| {
        let expanded = COVERAGE * point.u;
        let decimals = decimals(expanded);
        format!(
            "{:+.decimals$} ± {expanded:.decimals$}{unit} at {:.places$}{of_position}",
            point.value, point.at
        )
    };
    let by_value = |a: &&LostMotionAt, b: &&LostMotionAt| a.value.total_cmp(&b.value);
    let most = cause.curve.iter().max_by(by_value)?;
    let least = cause.curve.iter().min_by(by_value)?;
    Some(format!("from {} to {}", point(least), point(most)))
}

/// 3 if the parameters begin with the three parts of a vector, else 1.
fn vector_at(parameters: &[EstimatedParameter]) -> usize {
    let [x, y, z, ..] = parameters else {
        return 1;
    };
    let stem = x.name.strip_suffix("_x");
    let is_part = |p: &EstimatedParameter, end| stem.is_some() && p.name.strip_suffix(end) == stem;
    if is_part(y, "_y") && is_part(z, "_z") {
        3
    } else {
        1
    }
}

/// Value with sign and U, to the decimals that U shows.
fn number(parameter: &EstimatedParameter) -> String {
    let expanded = COVERAGE * parameter.u;
    if expanded.is_finite() {
        let decimals = decimals(expanded);
        return format!("{:+.decimals$} ± {expanded:.decimals$}", parameter.value);
    }
    match format!("{:+.1}", parameter.value).as_str() {
        "+0.0" | "-0.0" => "–".to_owned(),
        value => format!("{value} (seen in part only)"),
    }
}

fn plain(parameter: &EstimatedParameter) -> String {
    let expanded = COVERAGE * parameter.u;
    let decimals = decimals(expanded);
    match expanded > 0.0 && expanded.is_finite() {
        true => format!("{:.decimals$} ± {expanded:.decimals$}", parameter.value),
        false => format!("{:.1}", parameter.value),
    }
}

/// A unit as it stands behind a value.
pub(crate) fn unit(unit: &str) -> String {
    told_behind(unit, ' ')
}

/// A duration, or a length over which something is smooth, with its unit.
pub(crate) fn extent(value: f64, unit: &str) -> String {
    let (unit, size) = told_unit(value, unit);
    format!("{} {unit}", amount(value / size, 0))
}

/// A share of one in percent; neither nothing nor all by rounding.
pub(crate) fn percent(share: f64) -> String {
    match 100.0 * share {
        p if p < 1.0 => "less than 1 %".to_owned(),
        p if p > 99.0 && p < 100.0 => format!("{:.1} %", p.min(99.9)),
        p => format!("{p:.0} %"),
    }
}

/// An amount with this many decimals, or with three significant digits where these would round it to next to nothing.
pub(crate) fn amount(value: f64, decimals: i32) -> String {
    let last = 10_f64.powi(-decimals);
    match value.abs() < 10.0 * last {
        true => trueaxis_files::significant(value).to_string(),
        false => format!("{value:.*}", decimals.unsigned_abs() as usize),
    }
}

/// The certainty of a cause: a phrase and the p-value.
pub(crate) fn certainty(p_value: f64) -> String {
    let words = match p_value {
        p if p < 1e-6 => "beyond doubt",
        p if p < 1e-3 => "very sure",
        _ => "sure",
    };
    format!(
        "that something is wrong: {words}; the chance that noise alone looks as much like any known cause is {}",
        match p_value {
            p if p < 1e-3 => probability(p),
            p => format!("{:.1} %", 100.0 * p),
        }
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parameter(name: &str, value: f64, u: f64, unit: &'static str) -> EstimatedParameter {
        EstimatedParameter {
            name: name.to_owned(),
            value,
            u,
            unit,
        }
    }

    #[test]
    fn small_amounts_keep_three_digits() {
        let said = [amount(12.3456, 2), amount(0.001_234_5, 2), amount(431.2, 0)];
        assert_eq!(said, ["12.35", "0.00123", "431"]);
        assert_eq!(amount(0.427_9, 0), "0.428");
    }

    #[test]
    fn vectors_are_told_together_and_an_instant_behind_them() {
        let all = [
            parameter("shift_x", 3.1, 0.2, "um"),
            parameter("shift_y", 0.0, 0.2, "um"),
            parameter("shift_z", -1.44, 0.3, "um"),
            parameter("time", 5210.0, 4.0, "s"),
        ];
        let text = "shift x +3.10 ± 0.40, y +0.00 ± 0.40, z -1.44 ± 0.60 µm; at 5210.0 ± 8.0 s";
        assert_eq!(parameters(&all), text);
        // Shorter than what the steps show.
        let shortest = [parameter("period", 40.0, f64::INFINITY, "mm")];
        assert_eq!(parameters(&shortest), "period at most 40.0 mm");
        let expansion = [parameter("expansion", 2.0, 0.01, "ppm")];
        assert_eq!(parameters(&expansion), "expansion +2.000 ± 0.020 ppm");
    }

    #[test]
    fn long_times_are_not_told_in_seconds() {
        let all = [
            parameter("time", 864_000.0, 43_200.0, "s"),
            parameter("time_constant", 94_672_800.0, f64::INFINITY, "s"),
        ];
        assert_eq!(
            parameters(&all),
            "at 10.0 ± 1.0 days; time constant 3.0 years"
        );
    }
}
