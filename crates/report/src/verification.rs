//! What other instruments read against what the calibration predicts, with and without compensation.

mod places;
mod polar;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use trueaxis_files::decimals;

use crate::numbers::{COVERAGE, fixed, p_value, signed, with_u};
use crate::page::Figure;
use crate::svg::plot::Plot;
use crate::svg::ticks::{Ruler, bounds, range};

/// What figures and tables need of `verification.json`.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Verification {
    /// The calibration that the readings are compared with.
    pub(crate) calibration: String,
    pub(crate) campaign: String,
    pub(crate) machine: String,
    /// The axes whose positions are degrees.
    rotary_axes: Vec<String>,
    compensated: bool,
    expected_above_one: f64,
    verification: Vec<Entry>,
    notices: Vec<String>,
}

/// One line or ball bar.
#[derive(Debug, Deserialize)]
struct Entry {
    name: String,
    kind: String,
    #[serde(default)]
    points: Vec<Point>,
    e_n: Option<Agreement>,
    #[serde(default)]
    iso_230_2: Vec<Value>,
    iso_230_4: Option<Value>,
}

impl Entry {
    /// Whether the uncertainty of a reading is declared.
    fn is_declared(&self) -> bool {
        self.points.iter().any(|point| point.u_reading_um.is_some())
    }

    /// Whether both sides of approach were read.
    fn has_sides(&self) -> bool {
        self.points.iter().any(|point| point.direction < 0)
    }

    /// Explains the marks of its figures; `with_u` says of readings that their U is shown, or is empty.
    fn add_key(&self, with_u: &str, mut add: impl FnMut(&str, &str)) {
        add("m1", &format!("read forward{with_u}"));
        if self.has_sides() {
            add("p1 x", &format!("read backward{with_u}"));
        }
        add("l0", "predicted, with its 95 % band");
        add("l2", "predicted with compensation");
    }
}

#[derive(Debug, Deserialize)]
struct Point {
    at: BTreeMap<String, f64>,
    /// Only of point checks.
    #[serde(default)]
    point_mm: [f64; 3],
    #[serde(default)]
    coordinate: String,
    /// Not there for point checks.
    #[serde(default)]
    direction: i8,
    reading_um: f64,
    predicted_um: f64,
    compensated_um: f64,
    /// Not there if the calibration has no uncertainties.
    u_prediction_um: Option<f64>,
    u_reading_um: Option<f64>,
    e_n: Option<f64>,
}

impl Point {
    /// What the calibration predicts, with compensation or without.
    fn expected_um(&self, compensated: bool) -> f64 {
        match compensated {
            true => self.compensated_um,
            false => self.predicted_um,
        }
    }

    fn expanded_reading_um(&self) -> f64 {
        COVERAGE * self.u_reading_um.unwrap_or(0.0)
    }

    fn expanded_prediction_um(&self) -> f64 {
        COVERAGE * self.u_prediction_um.unwrap_or(0.0)
    }
}

#[derive(Debug, Deserialize)]
struct Agreement {
    count: usize,
    above_one: usize,
    p_value: Option<f64>,
    misfit: bool,
}

#[derive(Serialize)]
pub(crate) struct VerificationSection {
    compensated: bool,
    entries: Vec<EntryView>,
    notices: Vec<String>,
}

#[derive(Serialize)]
struct EntryView {
    name: String,
    figure: Option<Figure>,
    /// Whether it shows coordinates of single places.
    of_places: bool,
    /// Of a ball bar.
    polar: Option<Figure>,
    /// How well readings and prediction agree, where the uncertainty of a reading is declared.
    agreement: Option<String>,
    is_misfit: bool,
    /// Whether the uncertainty of a reading is declared.
    is_declared: bool,
    has_sides: bool,
    /// Range of the prediction, and with compensation, µm, and whether that is larger.
    predicted_um: String,
    compensated_um: String,
    moves_more: bool,
    /// Rms of the readings, and of what is left of them less the prediction, µm.
    readings_um: String,
    left_um: String,
    iso_230_2: Vec<Value>,
    iso_230_4: Option<Value>,
}

const SIZE: [f64; 2] = [900.0, 270.0];

/// Half of what the last digit of a figure shows, µm.
const LAST_DIGIT_UM: f64 = 0.005;

impl Verification {
    /// What contradicts the prediction, and by how much.
    pub(crate) fn misfits(&self) -> Vec<String> {
        let entries = self.verification.iter();
        let misfits = entries.filter_map(|entry| {
            let e_n = entry.e_n.as_ref().filter(|e_n| e_n.misfit)?;
            let (name, above, all) = (&entry.name, e_n.above_one, e_n.count);
            Some(format!("{name} ({above} of {all} readings outside U)"))
        });
        misfits.collect()
    }

    /// Whether the readings contradict the prediction; `None` where no uncertainty of a reading is declared.
    pub(crate) fn is_misfit(&self) -> Option<bool> {
        let judged = self
            .verification
            .iter()
            .filter_map(|entry| entry.e_n.as_ref());
        judged.map(|e_n| e_n.misfit).reduce(|a, b| a || b)
    }
}

impl VerificationSection {
    pub(crate) fn new(verification: &Verification) -> Self {
        let entries = verification.verification.iter().enumerate();
        let view = |(k, entry): (usize, &Entry)| {
            let predicted = |point: &Point| point.expected_um(verification.compensated);
            let rms = |value: &dyn Fn(&Point) -> f64| {
                let squares: f64 = entry.points.iter().map(|point| value(point).powi(2)).sum();
                (squares / entry.points.len().max(1) as f64).sqrt()
            };
            let range_of = |value: &dyn Fn(&Point) -> f64| {
                let [low, high] = bounds(entry.points.iter().map(value));
                (high - low).max(0.0)
            };
            let without = range_of(&|point| point.predicted_um);
            let with = range_of(&|point| point.compensated_um);
            EntryView {
                is_declared: entry.is_declared(),
                has_sides: entry.has_sides(),
                predicted_um: fixed(without, 2),
                compensated_um: fixed(with, 2),
                moves_more: with > without + LAST_DIGIT_UM,
                name: entry.name.clone(),
                figure: match entry.kind.as_str() {
                    "points" => places::figure(k, entry, verification.compensated),
                    _ => figure(k, entry, &verification.rotary_axes),
                },
                of_places: entry.kind == "points",
                polar: match entry.kind.as_str() {
                    "ballbar" => polar::figure(k, entry, &verification.rotary_axes),
                    _ => None,
                },
                agreement: entry.e_n.as_ref().map(|e_n| {
                    format!(
                        "{} of {} normalised errors Eₙ are above 1, {} expected{}",
                        e_n.above_one,
                        e_n.count,
                        fixed(verification.expected_above_one * e_n.count as f64, 1),
                        e_n.p_value
                            .map_or_else(String::new, |p| format!(", {}", p_value(p)))
                    )
                }),
                is_misfit: entry.e_n.as_ref().is_some_and(|e_n| e_n.misfit),
                readings_um: fixed(rms(&|point| point.reading_um), 2),
                left_um: fixed(rms(&|point| point.reading_um - predicted(point)), 2),
                iso_230_2: entry.iso_230_2.clone(),
                iso_230_4: entry.iso_230_4.clone(),
            }
        };
        Self {
            compensated: verification.compensated,
            entries: entries.map(view).collect(),
            notices: verification.notices.clone(),
        }
    }

    pub(crate) fn figures(&self) -> impl Iterator<Item = &Figure> {
        let entries = self.entries.iter();
        entries.flat_map(|entry| entry.figure.iter().chain(&entry.polar))
    }
}

/// Readings as dots with their U, the prediction with its band, and what is left with compensation.
fn figure(k: usize, entry: &Entry, rotary_axes: &[String]) -> Option<Figure> {
    let axis = moving_axis(entry)?;
    let is_rotary = rotary_axes.contains(&axis);
    let unit = if is_rotary { "°" } else { " mm" };
    let on_axis = |point: &Point| point.at.get(&axis).copied().unwrap_or(f64::NAN);
    // On a circle of two linear axes a position of one of them is no place: the points follow each other.
    let is_place = tells_the_place(entry, &on_axis);
    let numbered: Vec<(f64, &Point)> = match is_place {
        true => entry
            .points
            .iter()
            .map(|point| (on_axis(point), point))
            .collect(),
        false => (1..).map(f64::from).zip(&entry.points).collect(),
    };
    let (u_reading, u_prediction) = (Point::expanded_reading_um, Point::expanded_prediction_um);
    let [from, to] = range(numbered.iter().map(|(x, _)| *x));
    let [low, high] = range(entry.points.iter().flat_map(|point| {
        let around = |value: f64, u: f64| [value - u, value + u];
        let read = around(point.reading_um, u_reading(point));
        let predicted = around(point.predicted_um, u_prediction(point));
        read.into_iter()
            .chain(predicted)
            .chain([point.compensated_um])
    }));
    let x_label = match is_place {
        true => format!("{axis} in {}", unit.trim()),
        false => "number of the reading".to_owned(),
    };
    let y_label = match entry.kind.as_str() {
        "ballbar" => "change of the bar in µm",
        _ => "deviation in µm",
    };
    let x = Ruler::positions(is_rotary && is_place, from, to, 8);
    let y = (y_label, Ruler::new(low, high, 5));
    let mut plot = Plot::new(SIZE, "", (&x_label, x), y);
    for side in [1, -1] {
        let on_side = numbered.iter().filter(|(_, point)| point.direction == side);
        let mut of_side: Vec<&(f64, &Point)> = on_side.collect();
        of_side.sort_by(|a, b| a.0.total_cmp(&b.0));
        let curve = |value: &dyn Fn(&Point) -> f64| -> Vec<[f64; 2]> {
            of_side
                .iter()
                .map(|(x, point)| [*x, value(point)])
                .collect()
        };
        let edge = |sign: f64| curve(&|point| point.predicted_um + sign * u_prediction(point));
        plot.band(0, &edge(-1.0), &edge(1.0));
        plot.line("l0", curve(&|point| point.predicted_um));
        plot.line("l2", curve(&|point| point.compensated_um));
    }
    for &(x, point) in &numbered {
        let u = u_reading(point);
        let ends = [[x, point.reading_um - u], [x, point.reading_um + u]];
        plot.line("whisker", ends);
        let class = if point.direction < 0 { "p1 x" } else { "m1" };
        plot.marks(class, [[x, point.reading_um]]);
        let digits = decimals(u.max(u_prediction(point)));
        let text = format!(
            "{axis} = {}{unit}, {}: read {} µm, predicted {} µm, {} µm with compensation{}",
            on_axis(point),
            if point.direction > 0 {
                "forward"
            } else {
                "backward"
            },
            signed(point.reading_um, digits),
            match point.u_prediction_um {
                Some(u) => with_u(point.predicted_um, COVERAGE * u, digits),
                None => signed(point.predicted_um, digits),
            },
            signed(point.compensated_um, digits),
            point
                .e_n
                .map(|e_n| format!(", Eₙ {}", fixed(e_n, 2)))
                .unwrap_or_default()
        );
        plot.hover([x, point.reading_um], &text);
    }
    let with_u = if entry.is_declared() { ", with U" } else { "" };
    entry.add_key(with_u, |class, words| plot.add_key(class, words));
    Some(Figure::new(
        &format!("verification-{}", k + 1),
        plot.finish(),
    ))
}

/// Whether an axis is at each position once from each side of approach, so that the position tells the points apart.
fn tells_the_place(entry: &Entry, on_axis: &dyn Fn(&Point) -> f64) -> bool {
    [1, -1].into_iter().all(|side| {
        let of_side = entry.points.iter().filter(|point| point.direction == side);
        let mut positions: Vec<f64> = of_side.map(on_axis).collect();
        positions.sort_by(f64::total_cmp);
        positions.windows(2).all(|pair| pair[0] < pair[1])
    })
}

/// The axis that moves farthest, mm or degrees.
fn moving_axis(entry: &Entry) -> Option<String> {
    let first = entry.points.first()?;
    let moved = |axis: &&String| {
        let positions = entry.points.iter().filter_map(|point| point.at.get(*axis));
        let [low, high] = range(positions.copied());
        high - low
    };
    let axes = first.at.keys().filter(|axis| moved(axis) > 0.0);
    axes.max_by(|a, b| moved(a).total_cmp(&moved(b))).cloned()
}
