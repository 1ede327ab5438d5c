//! Smooth processes of unknown form, each with its course.

use serde::Serialize;

use trueaxis_files::decimals;

use crate::diagnosis::{CurvePoint, Disturbance};
use crate::numbers::{fixed, with_u};
use crate::page::Figure;
use crate::svg::plot::Plot;
use crate::svg::ticks::{Ruler, range};

#[derive(Serialize)]
pub(crate) struct DisturbanceView {
    name: String,
    /// One for each coordinate.
    pub(crate) figures: Vec<Figure>,
}

impl DisturbanceView {
    pub(crate) fn new(k: usize, of: &Disturbance) -> Self {
        let curve = of.curve.as_deref().unwrap_or_default();
        Self {
            name: of.name(),
            figures: smooth(k, curve, of),
        }
    }
}

/// What its course is over, with the unit.
fn argument(of: &Disturbance) -> &'static str {
    match of.correlation_length.unit.as_str() {
        "readings" => "number of the reading",
        _ if of.varies_with.first().is_some_and(|with| with == "time") => "time in s",
        "deg" => "position in °",
        _ => "position in mm",
    }
}

/// What wanders of a station, a target or the machine; lost motion and the scale of the air have one coordinate.
const COORDINATES: [&str; 4] = ["x", "y", "z", "dead path"];

/// The frame in which points are measured, and the stage of an axis.
const OF_FRAME: [&str; 6] = ["x", "y", "z", "about x", "about y", "about z"];

/// An axis that grows.
const OF_SCALE: [&str; 2] = ["middle of the line", "length of the line"];

fn coordinates(of: &Disturbance) -> &'static [&'static str] {
    match of.varies_with.as_slice() {
        [with] if with == "time" && of.axis().is_some() => &OF_SCALE,
        [with] if with == "direction" => &OF_FRAME,
        [time, position] if time == "time" && position == "position" => &OF_FRAME,
        _ if of.is_of_frame() => &OF_FRAME,
        _ => &COORDINATES,
    }
}

/// The course of a disturbance, a figure with its 95 % band for each coordinate, all drawn alike; of the geometry of an axis at each
/// of the positions where it is given.
fn smooth(k: usize, curve: &[CurvePoint], of: &Disturbance) -> Vec<Figure> {
    let (x_label, axis) = (argument(of), of.axis().unwrap_or_default());
    if curve.iter().any(|point| point.at.is_empty()) {
        return Vec::new();
    }
    let count = curve.first().map_or(0, |point| point.of.values().len());
    let part = |point: &CurvePoint, c: usize, sign: f64| {
        let value = point.of.values().get(c).copied().unwrap_or(f64::NAN);
        let u = point.of.u().get(c).copied().unwrap_or(0.0);
        [point.at[0], value + 2.0 * sign * u]
    };
    let all = |c: usize, sign: f64| curve.iter().map(move |point| part(point, c, sign));
    let bounds = (0..count).flat_map(|c| all(c, -1.0).chain(all(c, 1.0)));
    let [low, high] = range(bounds.map(|[_, value]| value));
    let [from, to] = range(curve.iter().map(|point| point.at[0]));
    let mut figures: Vec<Figure> = Vec::new();
    for own in curve.chunk_by(|a, b| a.at.get(1) == b.at.get(1)) {
        let edge = |c: usize, sign: f64| -> Vec<[f64; 2]> {
            own.iter().map(|point| part(point, c, sign)).collect()
        };
        let position = own[0].at.get(1);
        for (c, name) in coordinates(of).iter().take(count).enumerate() {
            let title = match position {
                Some(position) => format!("{name} at {axis} = {}", fixed(*position, 0)),
                None if count == 1 => String::new(),
                None => (*name).to_owned(),
            };
            let x = (x_label, Ruler::new(from, to, 4));
            let y = ("disturbance in µm", Ruler::new(low, high, 5));
            let mut plot = Plot::new([340.0, 200.0], &title, x, y);
            plot.band(0, &edge(c, -1.0), &edge(c, 1.0));
            plot.line("l0", edge(c, 0.0));
            for point in own {
                let [at, value] = part(point, c, 0.0);
                let expanded = part(point, c, 1.0)[1] - value;
                let told = with_u(value, expanded, decimals(expanded));
                let text = format!("{x_label}: {}; {told} µm", fixed(at, 1));
                plot.hover([at, value], &text);
            }
            let number = figures.len() + 1;
            figures.push(Figure::new(
                &format!("disturbance-{}-{number}", k + 1),
                plot.finish(),
            ));
        }
    }
    figures
}
