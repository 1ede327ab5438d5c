//! The error curves of each axis with their uncertainty, and what they come to.

use serde::Serialize;
use trueaxis_files::{decimals, told_behind};

use crate::calibration::{Axis, Calibration, Curve, Kind};
use crate::numbers::{expanded, fixed, signed, with_u};
use crate::page::Figure;
use crate::svg::plot::Plot;
use crate::svg::ticks::{Ruler, bounds, range};
use crate::words;

#[derive(Serialize)]
pub(crate) struct AxisSection {
    name: String,
    pub(crate) figures: Vec<Figure>,
    rows: Vec<Summary>,
    /// Names of the sides of approach, where they are kept apart.
    sides: Vec<&'static str>,
    ratios: Vec<RatioRow>,
    /// Whether its curves have more points than are drawn.
    is_thinned: bool,
}

/// A curve in a line.
#[derive(Serialize)]
struct Summary {
    name: String,
    words: String,
    unit: &'static str,
    least: String,
    largest: String,
    range: String,
    expanded: String,
}

/// u by equations relative to the joint adjustment.
#[derive(Serialize)]
struct RatioRow {
    name: String,
    nine: String,
    six: String,
}

pub(crate) const SIZE: [f64; 2] = [340.0, 200.0];

/// Small multiples, in the order of the names: displacements, then angles.
const ORDER: [char; 6] = ['X', 'Y', 'Z', 'A', 'B', 'C'];

pub(crate) fn sections(calibration: &Calibration) -> Vec<AxisSection> {
    let axes = calibration.axes.iter();
    axes.map(|axis| section(axis, calibration)).collect()
}

fn section(axis: &Axis, calibration: &Calibration) -> AxisSection {
    let order = |name: &str| {
        let letter = name.chars().nth(1).unwrap_or_default();
        ORDER.iter().position(|&x| x == letter)
    };
    let mut curves: Vec<(&String, &Curve)> = axis.components.iter().collect();
    curves.sort_by_key(|(name, _)| order(name));
    let ratio = |ratio: Option<f64>| ratio.map_or("–".to_owned(), |r| fixed(r, 2));
    let ratios = curves.iter().filter_map(|(name, _)| {
        let of = axis.u_ratio.get(*name)?;
        Some(RatioRow {
            name: (*name).clone(),
            nine: ratio(of.nine),
            six: ratio(of.six),
        })
    });
    let described = |name: &str| words::component(name, &axis.name, &calibration.machine);
    AxisSection {
        name: axis.name.clone(),
        figures: curves
            .iter()
            .map(|(name, curve)| figure(axis, name, curve, &described(name)))
            .collect(),
        rows: curves
            .iter()
            .map(|(name, curve)| summary(name, curve, described(name)))
            .collect(),
        sides: match axis.direction.is_empty() {
            true => Vec::new(),
            false => vec!["forward", "backward"],
        },
        ratios: ratios.collect(),
        is_thinned: axis.positions.len() > MOST_POINTS,
    }
}

/// Student's factor above which a band would hide the curve, and is not drawn: with less than one degree of freedom.
const MOST_COVERAGE: f64 = 20.0;

fn half_of_band(u: f64, dof: Option<f64>) -> f64 {
    match expanded(u, dof) {
        half if half > MOST_COVERAGE * u => f64::INFINITY,
        half => half,
    }
}

/// From the least to the largest of a curve with its band, and zero.
fn shown(nodes: &[[f64; 3]]) -> [f64; 2] {
    let nodes = nodes.iter();
    let ends = nodes.flat_map(|[_, value, half]| [*value, value - half, value + half]);
    range(ends.chain([0.0]))
}

fn figure(axis: &Axis, name: &str, curve: &Curve, described: &str) -> Figure {
    let position_unit = match axis.kind {
        Kind::Linear => " mm",
        Kind::Rotary => "°",
    };
    let nodes = axis.positions.iter().zip(curve.values()).zip(curve.u());
    let nodes: Vec<[f64; 3]> = nodes
        .map(|((&x, &value), &u)| [x, value, half_of_band(u, curve.dof)])
        .collect();
    let [low, high] = shown(&nodes);
    let [from, to] = range(axis.positions.iter().copied());
    let x = Ruler::positions(axis.kind == Kind::Rotary, from, to, 5);
    let x_label = format!("{} in {}", axis.name, position_unit.trim());
    let unit = if curve.is_angular() { "arcsec" } else { "µm" };
    let y_label = format!("{name} in {unit}");
    let unit = told_behind(unit, ' ');
    let y = (&*y_label, Ruler::new(low, high, 5));
    let mut plot = Plot::new(SIZE, &format!("{name}  {described}"), (&x_label, x), y);
    let of_side = |side: Option<i8>| -> Vec<[f64; 3]> {
        let nodes = nodes.iter().enumerate();
        let on = nodes.filter(|(k, _)| side.is_none() || axis.direction.get(*k).copied() == side);
        let mut on: Vec<[f64; 3]> = on.map(|(_, node)| *node).collect();
        on.sort_by(|a, b| a[0].total_cmp(&b[0]));
        thinned(on)
    };
    let sides = match axis.direction.is_empty() {
        true => vec![(None, "")],
        false => vec![(Some(1), ", forward"), (Some(-1), ", backward")],
    };
    for (colour, (side, told)) in sides.into_iter().enumerate() {
        let on = of_side(side);
        plot.curve(colour, &on);
        for [x, value, expanded] in on {
            let text = format!(
                "{} = {x}{position_unit}{told}: {name} = {}{unit}",
                axis.name,
                with_u(value, expanded, decimals(expanded)),
            );
            plot.hover([x, value], &text);
        }
    }
    if !axis.direction.is_empty() {
        plot.add_key("l0", "forward");
        plot.add_key("l1", "backward");
    }
    Figure::new(&format!("component-{name}"), plot.finish())
}

/// A figure cannot show more points of a curve than these one by one.
const MOST_POINTS: usize = 400;

/// Points in the order of their positions, of each part of a long curve the least and the largest.
pub(crate) fn thinned(points: Vec<[f64; 3]>) -> Vec<[f64; 3]> {
    if points.len() <= MOST_POINTS {
        return points;
    }
    let parts = points.chunks(points.len().div_ceil(MOST_POINTS / 2));
    let ends = parts.flat_map(|part| {
        let by_value = |a: &usize, b: &usize| part[*a][1].total_cmp(&part[*b][1]);
        let least = (0..part.len()).min_by(by_value);
        let largest = (0..part.len()).max_by(by_value);
        let mut ends: Vec<usize> = least.into_iter().chain(largest).collect();
        ends.sort_unstable();
        ends.dedup();
        ends.into_iter().map(|k| part[k])
    });
    ends.collect()
}

fn summary(name: &str, curve: &Curve, words: String) -> Summary {
    let values = || curve.values().iter().copied().filter(|x| x.is_finite());
    let [least, largest] = bounds(values());
    let u = curve.u().iter().copied().fold(0.0, f64::max);
    let expanded = expanded(u, curve.dof);
    let digits = decimals(expanded).min(2);
    let is_defined = expanded < f64::MIN_POSITIVE && values().all(|x| x.abs() < f64::MIN_POSITIVE);
    let shown = |text: String| match is_defined || least > largest {
        true => "–".to_owned(),
        false => text,
    };
    Summary {
        name: name.to_owned(),
        words,
        unit: if curve.is_angular() { "″" } else { "µm" },
        least: shown(signed(least, digits)),
        largest: shown(signed(largest, digits)),
        range: shown(fixed(largest - least, digits)),
        expanded: shown(fixed(expanded, digits)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_curves_keep_their_extremes() {
        let curve: Vec<[f64; 3]> = (0..33_333_u32)
            .map(|k| [f64::from(k), (f64::from(k) / 500.0).sin(), 0.1])
            .collect();
        let drawn = thinned(curve.clone());
        assert!(drawn.len() <= MOST_POINTS, "{}", drawn.len());
        assert!(drawn.is_sorted_by(|a, b| a[0] < b[0]));
        let extremes = |points: &[[f64; 3]]| range(points.iter().map(|point| point[1]));
        let (all, kept) = (extremes(&curve), extremes(&drawn));
        assert!((all[0] - kept[0]).abs() + (all[1] - kept[1]).abs() < 1e-15);
        assert_eq!(thinned(curve[..400].to_vec()), curve[..400]);
    }

    #[test]
    fn a_curve_without_degrees_of_freedom_is_inside_its_frame() {
        let half = half_of_band(0.3, Some(0.0));
        assert!(half.is_infinite());
        let nodes = [[0.0, -3.0, half], [10.0, 14.0, half]];
        let [low, high] = shown(&nodes);
        assert!(low < -3.0 && high > 14.0 && high < 20.0, "{low} {high}");
        let [x, y] = [[0.0, 10.0], [low, high]].map(|[from, to]| Ruler::new(from, to, 5));
        let mut plot = Plot::new(SIZE, "", ("x", x), ("y", y));
        plot.curve(0, &nodes);
        let drawn = plot.finish().inline();
        assert!(
            drawn.contains("\"l0\"") && drawn.contains("\"m0\""),
            "{drawn}"
        );
        assert!(half_of_band(0.3, Some(1.0)) < 4.0);
    }
}
