//! A ball bar as a polar plot: the change of its length, outwards from a circle that stands for no change.

use std::f64::consts::{FRAC_PI_4, PI, TAU};

use crate::page::Figure;
use crate::svg::Drawing;
use crate::svg::ticks::{Ruler, bounds};
use crate::verification::{Entry, Point};

/// Width and height, radius of the circle of no change, and of the largest change more, pixels.
const SIZE: f64 = 360.0;
const CIRCLE: f64 = 90.0;
const CHANGE: f64 = 62.0;

/// Where the names of the directions stand, and half the height of a letter.
const NAMES: f64 = CIRCLE + CHANGE + 14.0;
const HALF_LETTER: f64 = 4.0;

/// Angle between the points of a curve that is drawn, rad.
const STEP: f64 = TAU / 120.0;

/// Largest difference between the distances of points of a circle from its centre, as a share.
const ROUND: f64 = 0.02;

/// Places of the readings on a circle, rad, and what its quarters are called.
struct Circle {
    angles: Vec<f64>,
    quarters: [String; 4],
}

/// The figure of entry `k`; `None` if its points are on no circle of one rotary or two linear axes.
pub(super) fn figure(k: usize, entry: &Entry, rotary_axes: &[String]) -> Option<Figure> {
    let circle = Circle::new(&entry.points, rotary_axes)?;
    let changes = entry.points.iter().flat_map(|point| {
        let u = point.expanded_prediction_um();
        let predicted = [point.predicted_um - u, point.predicted_um + u];
        predicted
            .into_iter()
            .chain([point.reading_um, point.compensated_um])
    });
    let [low, high] = bounds(changes);
    let most = low.abs().max(high.abs());
    if !(most.is_finite() && most > 0.0) {
        return None;
    }
    let at = |angle: f64, change_um: f64| {
        let radius = CIRCLE + CHANGE * change_um / most;
        let (sin, cos) = angle.sin_cos();
        [0.5 * SIZE + radius * cos, 0.5 * SIZE - radius * sin]
    };
    let mut drawing = Drawing::new(SIZE, SIZE, "change of the bar around the circle, in µm");
    for (change, text) in Ruler::new(-most, most, 4).ticks {
        let is_zero = change.abs() < f64::MIN_POSITIVE;
        let thirds = [0.0, 1.0, 2.0].map(|third| [third * TAU / 3.0, change]);
        let turn = around(&thirds).into_iter();
        let class = if is_zero { "zero" } else { "grid" };
        drawing.path(class, turn.map(|[angle, change]| at(angle, change)));
        let unit = if is_zero { " µm" } else { "" };
        let beside = at(FRAC_PI_4, change);
        drawing.text(beside, "n", "middle", &format!("{text}{unit}"));
    }
    for (quarter, name) in (0_u8..).zip(&circle.quarters) {
        let (sin, cos) = (f64::from(quarter) * 0.25 * TAU).sin_cos();
        let [x, y] = [0.5 * SIZE + NAMES * cos, 0.5 * SIZE - NAMES * sin];
        drawing.path(
            "grid",
            [
                [0.5 * SIZE, 0.5 * SIZE],
                at(f64::from(quarter) * 0.25 * TAU, most),
            ],
        );
        drawing.text([x, y + HALF_LETTER], "l", "middle", name);
    }
    for side in [1, -1] {
        let of_side = entry.points.iter().zip(&circle.angles);
        let of_side = of_side.filter(|(point, _)| point.direction == side);
        let mut of_side: Vec<(&Point, f64)> = of_side.map(|(p, angle)| (p, *angle)).collect();
        if side < 0 {
            // The dashes of both sides then fall on each other.
            of_side.reverse();
        }
        let marks = of_side
            .iter()
            .map(|(point, angle)| at(*angle, point.reading_um));
        let curve = |value: &dyn Fn(&Point) -> f64| -> Vec<[f64; 2]> {
            let values = of_side.iter().map(|(point, angle)| [*angle, value(point)]);
            let curve = around(&values.collect::<Vec<_>>()).into_iter();
            curve.map(|[angle, change]| at(angle, change)).collect()
        };
        let mut band = curve(&|point| point.predicted_um - point.expanded_prediction_um());
        let outer = curve(&|point| point.predicted_um + point.expanded_prediction_um());
        band.extend(outer.into_iter().rev());
        drawing.path("b0", band);
        drawing.path("l0", curve(&|point| point.predicted_um));
        drawing.path("l2", curve(&|point| point.compensated_um));
        drawing.marks(if side < 0 { "p1 x" } else { "p1" }, marks);
    }
    entry.add_key("", |class, words| drawing.add_key(class, words));
    Some(Figure::new(
        &format!("verification-{}-polar", k + 1),
        drawing,
    ))
}

/// Angles with changes, in their order, and what lies between on a curve; back to the first if that is not farther than
/// any other is from the next.
fn around(values: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let way = |from: &[f64; 2], to: &[f64; 2]| (to[0] - from[0] + PI).rem_euclid(TAU) - PI;
    let steps = values.windows(2).map(|two| way(&two[0], &two[1]).abs());
    let farthest = (1.0 + 1e-6) * steps.fold(0.0, f64::max);
    let back = values.last().zip(values.first());
    let back = back.filter(|(last, first)| way(last, first).abs() <= farthest);
    let pairs = values.windows(2).map(|two| (&two[0], &two[1])).chain(back);
    let mut curve: Vec<[f64; 2]> = values.first().copied().into_iter().collect();
    for (from, to) in pairs {
        let turn = way(from, to);
        let parts = (turn.abs() / STEP).ceil().max(1.0);
        let share = (1..=120)
            .map(|i| f64::from(i) / parts)
            .take_while(|share| *share <= 1.0);
        curve.extend(
            share.map(|share| [from[0] + turn * share, from[1] + (to[1] - from[1]) * share]),
        );
    }
    curve
}

impl Circle {
    fn new(points: &[Point], rotary_axes: &[String]) -> Option<Self> {
        let axes = points.first()?.at.keys();
        let moves = |axis: &&String| {
            points
                .iter()
                .any(|p| p.at.get(*axis) != points[0].at.get(*axis))
        };
        let moving: Vec<&String> = axes.filter(moves).collect();
        let positions = |axis: &String| -> Option<Vec<f64>> {
            points
                .iter()
                .map(|point| point.at.get(axis).copied())
                .collect()
        };
        let (rotary, linear): (Vec<_>, Vec<_>) = moving
            .into_iter()
            .partition(|axis| rotary_axes.contains(axis));
        match (rotary.as_slice(), linear.as_slice()) {
            // Linear axes that follow a table do not tell the place.
            ([axis], _) => Some(Self {
                angles: positions(axis)?.into_iter().map(f64::to_radians).collect(),
                quarters: ["0°", "90°", "180°", "270°"].map(str::to_owned),
            }),
            ([], [across, up]) => Some(Self {
                angles: around_centre(&positions(across)?, &positions(up)?)?,
                quarters: [("+", across), ("+", up), ("−", across), ("−", up)]
                    .map(|(sign, axis)| format!("{sign}{axis}")),
            }),
            _ => None,
        }
    }
}

/// Angles of points around the centre of their circle; `None` if they are on none.
fn around_centre(x: &[f64], y: &[f64]) -> Option<Vec<f64>> {
    // The centre is as far from all: 2 c (p - p̄) = |p|² - mean |p|², about the mean place (Kåsa 1976).
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let (mean_x, mean_y) = (mean(x), mean(y));
    let places: Vec<[f64; 2]> = x
        .iter()
        .zip(y)
        .map(|(x, y)| [x - mean_x, y - mean_y])
        .collect();
    let sum = |of: &dyn Fn(&[f64; 2]) -> f64| places.iter().map(of).sum::<f64>();
    let (xx, xy, yy) = (
        sum(&|p| p[0] * p[0]),
        sum(&|p| p[0] * p[1]),
        sum(&|p| p[1] * p[1]),
    );
    let (xs, ys) = (
        sum(&|p| p[0] * p[0].hypot(p[1]).powi(2)),
        sum(&|p| p[1] * p[0].hypot(p[1]).powi(2)),
    );
    let determinant = xx * yy - xy * xy;
    let centre = [
        0.5 * (yy * xs - xy * ys) / determinant,
        0.5 * (xx * ys - xy * xs) / determinant,
    ];
    let from_centre = places.iter().map(|p| [p[0] - centre[0], p[1] - centre[1]]);
    let from_centre: Vec<[f64; 2]> = from_centre.collect();
    let [least, most] = bounds(from_centre.iter().map(|[x, y]| x.hypot(*y)));
    let is_round = most.is_finite() && least > 0.0 && most - least <= ROUND * most;
    is_round.then(|| from_centre.iter().map(|[x, y]| y.atan2(*x)).collect())
}
