//! The table that `calibrate` ends with.

mod adjustment;
mod paper_signs;
mod reversal;

use nalgebra::{Point3, Vector3};
use trueaxis_calibrate::{
    AxisResult, Calibration, LengthReliability, LengthsReliability, Method, NumberedResult,
    RelativeLocation,
};
use trueaxis_campaign::{Campaign, Lengths};
use trueaxis_files::{counted, p_value, point_mm, round, told_behind};
use trueaxis_kinematics::{ARCSEC, AxisKind, Component, MICROMETRE};
use trueaxis_predict::{Output, coverage_factor};

pub(crate) use adjustment::adjustment;

use crate::summary::paper_signs::with_paper_signs;
use crate::summary::reversal::reversal_values;

/// Coverage factor of the uncertainties that people read, if many degrees of freedom stand behind them.
pub(crate) const COVERAGE: f64 = 2.0;

/// Half width of the 95 % interval that people read: Student's factor where that is more than [`COVERAGE`].
pub(crate) fn expanded(u: f64, dof: f64) -> f64 {
    u * coverage_factor(dof).max(COVERAGE)
}

/// Misfits and sides listed before the rest is only counted.
const MOST_LISTED: usize = 5;

/// A direction this close to one of the frame's is named after it (an angle of 0.3 arcmin).
const PRINCIPAL_TOL: f64 = 1e-8;

/// All lines, without notices.
pub(crate) fn lines(
    campaign: &Campaign,
    calibration: &Calibration,
    paper_signs: bool,
) -> Vec<String> {
    let mut lines = adjustment(calibration);
    lines.extend(location_errors(calibration));
    if paper_signs {
        lines.extend(with_paper_signs(campaign, calibration));
    }
    lines.extend(component_errors(calibration));
    lines.extend(reversal_values(calibration));
    if matches!(calibration.method, Method::Six(_)) {
        lines.extend(noise_gains(calibration));
    }
    lines.extend(method_losses(calibration));
    lines.extend(misfits(calibration));
    lines
}

/// The name of a campaign, or that it has none.
pub(crate) fn named(campaign: &str) -> &str {
    match campaign.trim() {
        "" => "campaign without a name",
        name => name,
    }
}

/// What the reliability of the lengths comes to.
pub(crate) fn reliability(
    campaign: &Campaign,
    lengths: &Lengths,
    found: &LengthsReliability,
    results: &[NumberedResult],
) -> Vec<String> {
    let detectable = found.lengths.iter().map(|of| of.minimal_detectable_mm);
    let mut detectable: Vec<f64> = detectable.filter(|mm| mm.is_finite()).collect();
    detectable.sort_by(f64::total_cmp);
    let unchecked = found.lengths.len() - detectable.len();
    let mut lines = vec![String::new()];
    if let (Some(median), Some(largest)) = (detectable.get(detectable.len() / 2), detectable.last())
    {
        lines.push(format!(
            "an error of a length is noticed (80 %) from {:.2} µm on in the median, {:.2} µm at most",
            median / MICROMETRE,
            largest / MICROMETRE
        ));
    }
    let by_effect =
        |a: &&LengthReliability, b: &&LengthReliability| a.worst.1.total_cmp(&b.worst.1);
    if let Some(worst) = found.lengths.iter().max_by(by_effect) {
        let reading = &lengths.readings[worst.reading];
        lines.push(format!(
            "unnoticed, it moves a result by {:.1} u at most: {} by line {} (target {})",
            worst.worst.1,
            in_words(&results[worst.worst.0].output),
            reading.line,
            campaign.targets[reading.target].name
        ));
    }
    if unchecked > 0 {
        lines.push(format!("nothing checks {unchecked} of the lengths"));
    }
    lines
}

fn location_errors(calibration: &Calibration) -> Vec<String> {
    let mut lines = vec![
        String::new(),
        format!("{:<24}{:>12}{:>12}", "location errors", "value", "U"),
    ];
    let row = |name: &str, value: f64, expanded: f64, is_angular: bool| {
        let (unit, size) = unit(is_angular);
        let (value, expanded) = (value / size, expanded / size);
        format!("  {name:<22}{value:>9.2} {unit}{expanded:>9.2} {unit}")
    };
    for axis in &calibration.axes {
        for location in &axis.location_errors {
            let is_angular = location.component.is_angular();
            let name = location.component.name(&axis.name);
            if location.u < f64::MIN_POSITIVE && location.value.abs() < f64::MIN_POSITIVE {
                let (unit, _) = unit(is_angular);
                lines.push(format!(
                    "  {name:<22}        0 {unit}   by definition of the frame"
                ));
                continue;
            }
            let expanded = expanded(location.u, location.dof);
            let note = match location.relative_to_targets {
                true => "  relative to the nests of the targets",
                false => "",
            };
            lines.push(row(&name, location.value, expanded, is_angular) + note);
        }
    }
    for relative in &calibration.relative_locations {
        let RelativeLocation { axis, to, .. } = relative;
        let along = direction_in_words(&relative.direction);
        let quantities = [
            ("offset along", &relative.offset, false),
            ("angle about", &relative.angle, true),
        ];
        for (what, found, is_angular) in quantities {
            let name = format!("{axis} to {to}, {what} {along}");
            let expanded = expanded(found.u, found.dof);
            lines.push(row(&name, found.value, expanded, is_angular));
        }
    }
    for line in &mut lines {
        line.truncate(line.trim_end().len());
    }
    if lines.len() == 2 {
        lines.push("  none: the reference frame takes those of a single linear axis".to_owned());
    }
    lines
}

/// The unit of angles and displacements, and its size.
pub(crate) fn unit(is_angular: bool) -> (&'static str, f64) {
    match is_angular {
        true => ("″ ", ARCSEC),
        false => ("µm", MICROMETRE),
    }
}

/// `y`, or the coordinates of a direction that is none of the frame's.
fn direction_in_words(direction: &Vector3<f64>) -> String {
    let largest = direction.iamax();
    match direction[largest] > 1.0 - PRINCIPAL_TOL {
        true => ["x", "y", "z"][largest].to_owned(),
        false => {
            let [x, y, z] = [direction.x, direction.y, direction.z];
            format!("({x:.3} {y:.3} {z:.3})")
        }
    }
}

fn component_errors(calibration: &Calibration) -> Vec<String> {
    let mut header = format!("{:<24}", "component errors");
    for component in Component::ALL {
        header.push_str(&format!("{:>8}", format!("E{}·", component.letter())));
    }
    let mut lines = vec![
        String::new(),
        header,
        "  largest amount, µm and ″".to_owned(),
        reference_points(calibration),
    ];
    for axis in &calibration.axes {
        let mut values = format!("  {:<22}", range(axis));
        let mut uncertainties = format!("  {:<22}", "  largest U");
        for component in Component::ALL {
            let c = component.index();
            let (_, size) = unit(component.is_angular());
            let values_of = axis.nodes.iter().map(|n| n.error.to_vector()[c].abs());
            let value = values_of.fold(0.0, f64::max);
            let expanded = axis.nodes.iter().map(|n| expanded(n.u[c], n.dof[c]));
            let expanded = expanded.fold(0.0, f64::max);
            // The gauge takes all of it, as of the straightness of two positions.
            let is_taken = expanded < f64::MIN_POSITIVE && value < f64::MIN_POSITIVE;
            for (line, x) in [(&mut values, value), (&mut uncertainties, expanded)] {
                line.push_str(&match is_taken {
                    true => format!(" {:>7}", "–"),
                    false => format!(" {:>7.2}", x / size),
                });
            }
        }
        lines.extend([values, uncertainties]);
    }
    lines
}

/// Which point the translations, and the lines that they make, belong to.
fn reference_points(calibration: &Calibration) -> String {
    let point = |p: &Point3<f64>| point_mm((*p).into());
    let mut points: Vec<(&Point3<f64>, Vec<&str>)> = Vec::new();
    for axis in &calibration.axes {
        let reference = &axis.reference_point_mm;
        match points.iter_mut().find(|(point, _)| *point == reference) {
            Some((_, axes)) => axes.push(&axis.name),
            None => points.push((reference, vec![&axis.name])),
        }
    }
    let several = points.len() > 1;
    let of_axes = points.iter().map(|(at, axes)| match several {
        true => format!("{} for {}", point(at), axes.join(" ")),
        false => point(at),
    });
    let of_axes: Vec<String> = of_axes.collect();
    format!(
        "  translations and squareness are those of the point at home at {}",
        of_axes.join(", ")
    )
}

/// `X  0 … 440 mm`.
fn range(axis: &AxisResult) -> String {
    let place = |position: f64| match axis.kind {
        AxisKind::Linear => format!("{position}"),
        AxisKind::Rotary => format!("{:.4}", position.to_degrees())
            .trim_end_matches('0')
            .trim_end_matches('.')
            .to_owned(),
    };
    let unit = told_behind(axis.kind.position_unit(), ' ');
    match (axis.nodes.first(), axis.nodes.last()) {
        (Some(first), Some(last)) => {
            format!(
                "{}  {} … {}{unit}",
                axis.name,
                place(first.position),
                place(last.position)
            )
        }
        _ => axis.name.clone(),
    }
}

fn noise_gains(calibration: &Calibration) -> Vec<String> {
    let mut lines = vec![
        String::new(),
        "noise of the components: this method against nine equations (ratio of standard deviations)"
            .to_owned(),
    ];
    for axis in &calibration.axes {
        lines.extend(axis.noise_gain.map(|[used, nine]| {
            let ratios = std::array::from_fn(|c| used[c] / nine[c]);
            table_row(&axis.name, &ratios)
        }));
    }
    lines
}

/// What nine and six equations would lose against the joint adjustment.
fn method_losses(calibration: &Calibration) -> Vec<String> {
    let mut lines = Vec::new();
    for axis in &calibration.axes {
        let Some(loss) = &axis.u_ratio else { continue };
        lines.push(table_row(
            &format!("{} by nine equations", axis.name),
            &loss.nine,
        ));
        let six = loss.six.iter();
        lines.extend(six.map(|six| table_row(&format!("{} by six equations", axis.name), six)));
    }
    if !lines.is_empty() {
        let title = "u by other methods from the same lengths, relative to the joint adjustment";
        lines.splice(0..0, [String::new(), title.to_owned()]);
    }
    lines
}

fn table_row(name: &str, values: &[f64; 6]) -> String {
    let mut line = format!("  {name:<22}");
    for value in values {
        line.push_str(&format!("{value:>8.2}"));
    }
    line
}

fn misfits(calibration: &Calibration) -> Vec<String> {
    let mut lines = Vec::new();
    if !calibration.triangle.is_empty() {
        lines.push(String::new());
        lines.push("the measured triangle is not the nominal one:".to_owned());
        for side in &calibration.triangle {
            lines.push(format!(
                "  {} to {}  measured {:.4} mm, nominal {:.4} mm, difference {:+.1} µm",
                side.targets[0],
                side.targets[1],
                side.measured_mm,
                side.nominal_mm,
                (side.measured_mm - side.nominal_mm) / MICROMETRE
            ));
        }
        lines.push(
            "  the measured one is used; check `targets` if nominal should be right".to_owned(),
        );
    }
    if !calibration.misfits.is_empty() {
        lines.push(String::new());
        lines.push("points that do not move as a rigid triangle:".to_owned());
        lines.extend(first_ones(&calibration.misfits, "", |misfit| {
            format!(
                "  {}: rms {:.2} µm, chi-squared {:.1} with {} of freedom ({})",
                misfit.step,
                misfit.rms_um,
                misfit.chi_squared,
                counted(misfit.degrees_of_freedom, "degree"),
                p_value(misfit.p_value)
            )
        }));
    }
    lines
}

/// A line for each of the first ones; the rest is counted, and `elsewhere` says where it is.
pub(crate) fn first_ones<T>(
    all: &[T],
    elsewhere: &str,
    line: impl Fn(&T) -> String,
) -> Vec<String> {
    let mut lines: Vec<String> = all.iter().take(MOST_LISTED).map(line).collect();
    if all.len() > MOST_LISTED {
        let more = all.len() - MOST_LISTED;
        lines.push(format!("  and {more} more{elsewhere}"));
    }
    lines
}

/// A result as a sentence.
pub(crate) fn in_words(output: &Output) -> String {
    let name = output.name();
    match output {
        Output::ComponentError { kind, position, .. } => match kind {
            AxisKind::Linear => format!("{name} at {position} mm"),
            AxisKind::Rotary => format!("{name} at {}°", round(position.to_degrees(), 9)),
        },
        Output::LocationError { .. } => name,
        Output::StationPosition { station, .. } | Output::DeadPath { station } => {
            format!("{name} of {station}")
        }
    }
}
