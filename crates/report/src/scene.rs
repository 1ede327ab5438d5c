//! The machine, its targets and the stations in space: as a still picture, and as data for the view that turns.

use nalgebra::Vector3;
use serde::Serialize;

use crate::calibration::{Calibration, Kind, NominalAxis};
use crate::page::Figure;
use crate::svg::Drawing;
use crate::svg::ticks::bounds;

/// Lines and points in the reference frame, mm.
#[derive(Serialize)]
pub(crate) struct Scene {
    lines: Vec<Line>,
    points: Vec<Point>,
    centre: [f64; 3],
    /// Radius of a ball about the centre that holds all, mm.
    radius: f64,
}

#[derive(Serialize)]
struct Line {
    /// `box`, `track`, `arrow` or `beam`: a class of the style sheet.
    class: &'static str,
    points: Vec<Place>,
}

#[derive(Serialize)]
struct Point {
    /// `station`, `target` or `axis`.
    class: &'static str,
    name: String,
    at: Place,
}

type Place = [f64; 3];

/// Directions to the right and upwards in the still picture: from above and the front right.
const RIGHT: Vector3<f64> = Vector3::new(0.829, 0.559, 0.0);
const UP: Vector3<f64> = Vector3::new(-0.213, 0.316, 0.924);

const SIZE: [f64; 2] = [460.0, 380.0];
const MARGIN: f64 = 26.0;

/// Points of a circle.
const ROUND: usize = 48;

/// Beyond, targets and stations have no names and no beams: they would cover each other.
const MOST_NAMED: usize = 40;

impl Scene {
    /// `None` where there is nothing to show.
    pub(crate) fn new(calibration: &Calibration) -> Option<Self> {
        let finite = |p: &[f64; 3]| p.iter().all(|x| x.abs() < 1e9);
        let of = |class, places: &[crate::calibration::Place]| -> Vec<Point> {
            let places = places.iter().filter(|place| finite(&place.position_mm));
            let point = |place: &crate::calibration::Place| Point {
                class,
                name: place.name.clone(),
                at: place.position_mm,
            };
            places.map(point).collect()
        };
        let targets = of("target", &calibration.targets);
        let stations = of("station", &calibration.stations);
        if targets.is_empty() {
            return None;
        }
        let count = targets.len() as f64;
        let shares = targets.iter().map(|t| Vector3::from(t.at) / count);
        let middle: Place = shares.sum::<Vector3<f64>>().into();
        let mut scene = Self {
            lines: Vec::new(),
            points: Vec::new(),
            centre: middle,
            radius: 1.0,
        };
        let axes = calibration.machine.axes.iter();
        let axes = axes.filter(|axis| finite(&axis.direction));
        let (linear, rotary): (Vec<_>, Vec<_>) = axes.partition(|axis| axis.kind == Kind::Linear);
        scene.volume(&linear);
        let far = targets.iter().map(|target| distance(target.at, middle));
        let size = far.fold(60.0, f64::max);
        for axis in rotary {
            scene.turning(axis, size);
        }
        if stations.len() <= MOST_NAMED {
            let beams = stations.iter().map(|station| Line {
                class: "beam",
                points: vec![station.at, middle],
            });
            scene.lines.extend(beams);
        }
        scene.points.extend(targets);
        scene.points.extend(stations);
        scene.frame();
        Some(scene)
    }

    /// Where the linear axes take the origin: a box, with an arrow along each axis.
    fn volume(&mut self, axes: &[&NominalAxis]) {
        let strokes: Vec<[f64; 2]> = axes
            .iter()
            .map(|axis| axis.travel.unwrap_or([0.0, 100.0]))
            .collect();
        let at = |amounts: &[f64]| {
            let moved = axes.iter().zip(amounts);
            let moves = moved.map(|(axis, amount)| Vector3::from(axis.direction) * *amount);
            Place::from(moves.sum::<Vector3<f64>>())
        };
        let lowest: Vec<f64> = strokes.iter().map(|stroke| stroke[0]).collect();
        // The first three axes make a box; more would hide it.
        let edges = axes.len().min(3);
        for k in 0..edges {
            for corner in 0..1_usize << edges {
                if corner >> k & 1 == 1 {
                    continue;
                }
                let mut from = lowest.clone();
                for (axis, stroke) in strokes.iter().enumerate().take(edges) {
                    from[axis] = stroke[corner >> axis & 1];
                }
                let mut to = from.clone();
                to[k] = strokes[k][1];
                self.lines.push(Line {
                    class: if corner == 0 { "arrow" } else { "box" },
                    points: vec![at(&from), at(&to)],
                });
            }
            let mut tip = lowest.clone();
            tip[k] = strokes[k][1] + 0.08 * (strokes[k][1] - strokes[k][0]);
            self.points.push(Point {
                class: "axis",
                name: axes[k].name.clone(),
                at: at(&tip),
            });
        }
    }

    /// A rotary axis with a circle about it.
    fn turning(&mut self, axis: &NominalAxis, size: f64) {
        let origin = Vector3::from(axis.position_mm.unwrap_or_default());
        let direction = Vector3::from(axis.direction);
        let along = |amount: f64| Place::from(origin + direction * (amount * size));
        self.lines.push(Line {
            class: "arrow",
            points: vec![along(-0.6), along(1.2)],
        });
        self.points.push(Point {
            class: "axis",
            name: axis.name.clone(),
            at: along(1.35),
        });
        let unit = |v: Vector3<f64>| v.try_normalize(0.0).unwrap_or_default();
        let across = unit(direction.cross(&Vector3::ith(direction.iamin(), 1.0)));
        let third = unit(direction).cross(&across);
        let turn = (0..=ROUND).map(|k| {
            let (sin, cos) = (std::f64::consts::TAU * k as f64 / ROUND as f64).sin_cos();
            Place::from(origin + across * (size * cos) + third * (size * sin))
        });
        self.lines.push(Line {
            class: "track",
            points: turn.collect(),
        });
    }

    /// The ball that holds everything.
    fn frame(&mut self) {
        let of_lines = self.lines.iter().flat_map(|line| &line.points);
        let all = of_lines.chain(self.points.iter().map(|point| &point.at));
        let all: Vec<Place> = all.copied().collect();
        let centre = [0, 1, 2].map(|k| extent(all.iter().map(|p| p[k]))[0]);
        self.centre = centre;
        self.radius = all.iter().map(|p| distance(*p, centre)).fold(1.0, f64::max);
    }

    /// The still picture.
    pub(crate) fn still(&self) -> Figure {
        let flat = |p: Place| {
            let p = Vector3::from(p) - Vector3::from(self.centre);
            [p.dot(&RIGHT), -p.dot(&UP)]
        };
        let all = self.lines.iter().flat_map(|line| &line.points).copied();
        let all: Vec<[f64; 2]> = all
            .chain(self.points.iter().map(|point| point.at))
            .map(flat)
            .collect();
        let [x, y] = [0, 1].map(|k| extent(all.iter().map(|p| p[k])));
        let fit = |k: usize, extent: f64| (SIZE[k] - 2.0 * MARGIN) / extent;
        let per_mm = fit(0, x[1]).min(fit(1, y[1]));
        let place = |p: Place| {
            let [a, b] = flat(p);
            [
                0.5 * SIZE[0] + per_mm * (a - x[0]),
                0.5 * SIZE[1] + per_mm * (b - y[0]),
            ]
        };
        let names = self.points.iter().map(|point| point.name.as_str());
        let names: Vec<&str> = names.collect();
        let title = format!("machine, targets and stations: {}", names.join(", "));
        let mut drawing = Drawing::new(SIZE[0], SIZE[1], title);
        for line in &self.lines {
            drawing.path(line.class, line.points.iter().map(|p| place(*p)));
        }
        let mut taken: Vec<[f64; 4]> = Vec::new();
        let named = self.points.len() <= MOST_NAMED;
        for point in &self.points {
            let at = place(point.at);
            match point.class {
                "axis" => {}
                "station" => drawing.marks("out", [at]),
                _ => drawing.marks("m0", [at]),
            }
            if named && let Some(text) = free(at, &point.name, &mut taken) {
                drawing.text(text, "k", "start", &point.name);
            }
        }
        Figure::new("machine", drawing)
    }
}

/// Where a name has room near a point; `None` if nowhere.
fn free(at: [f64; 2], name: &str, taken: &mut Vec<[f64; 4]>) -> Option<[f64; 2]> {
    let (width, height) = (8.0 * name.chars().count() as f64, 15.0);
    let places = [
        [6.0, -4.0],
        [-6.0 - width, -4.0],
        [6.0, 15.0],
        [-6.0 - width, 15.0],
        [-0.5 * width, -10.0],
        [-0.5 * width, 22.0],
    ];
    let in_frame = |[x, y, _, _]: &[f64; 4]| {
        *x >= 0.0 && x + width <= SIZE[0] && *y >= 0.0 && y + height <= SIZE[1]
    };
    places.into_iter().find_map(|[dx, dy]| {
        let base = [at[0] + dx, at[1] + dy];
        let area = [base[0], base[1] - 12.0, width, height];
        let covers = |other: &[f64; 4]| {
            area[0] < other[0] + other[2]
                && other[0] < area[0] + area[2]
                && area[1] < other[1] + other[3]
                && other[1] < area[1] + area[3]
        };
        if !in_frame(&area) || taken.iter().any(covers) {
            return None;
        }
        taken.push(area);
        Some(base)
    })
}

/// The middle of some values, and how far they extend, at least 1.
fn extent(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let [low, high] = bounds(values);
    [0.5 * (low + high), (high - low).max(1.0)]
}

fn distance(a: Place, b: Place) -> f64 {
    (Vector3::from(a) - Vector3::from(b)).norm()
}
