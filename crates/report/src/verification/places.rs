//! Coordinates of single places: what was read less what is predicted, place after place.

use trueaxis_files::decimals;

use crate::numbers::{fixed, signed, with_u};
use crate::page::Figure;
use crate::svg::plot::Plot;
use crate::svg::ticks::{Ruler, range};
use crate::verification::{Entry, Point, SIZE};

/// Coordinates, with the class of their marks.
const COORDINATES: [(&str, &str); 3] = [("x", "m0"), ("y", "m1"), ("z", "m2")];

/// Distance of the marks of a place, where those of the next are at 1.
const APART: f64 = 0.25;

pub(super) fn figure(k: usize, entry: &Entry, compensated: bool) -> Option<Figure> {
    let of_calibration = |point: &Point| point.expected_um(compensated);
    let u = |point: &Point| {
        let u_prediction = point.expanded_prediction_um();
        point.expanded_reading_um().hypot(u_prediction)
    };
    let is_same = |a: &Point, b: &Point| (a.point_mm, &a.at) == (b.point_mm, &b.at);
    let places = entry.points.chunk_by(is_same);
    let places = (1..).map(f64::from).zip(places);
    let numbered: Vec<(f64, &Point)> = places
        .flat_map(|(number, place)| place.iter().map(move |point| (number, point)))
        .collect();
    let [from, to] = range(numbered.iter().map(|(number, _)| *number));
    let [low, high] = range(entry.points.iter().flat_map(|point| {
        let left = point.reading_um - of_calibration(point);
        [left - u(point), left + u(point), 0.0]
    }));
    let y = ("read − predicted in µm", Ruler::new(low, high, 5));
    let mut plot = Plot::new(
        SIZE,
        "",
        ("number of the place", Ruler::new(from, to, 8)),
        y,
    );
    for (beside, (coordinate, class)) in [-APART, 0.0, APART].into_iter().zip(COORDINATES) {
        let own = numbered
            .iter()
            .filter(|(_, point)| point.coordinate == coordinate);
        for &(number, point) in own {
            let (at, left) = (number + beside, point.reading_um - of_calibration(point));
            plot.line("tick", [[at, left - u(point)], [at, left + u(point)]]);
            plot.marks(class, [[at, left]]);
            let digits = decimals(u(point));
            let place = point.point_mm.map(|mm| signed(mm, 1)).join(", ");
            let e_n = point.e_n.map(|e_n| format!(", Eₙ {}", fixed(e_n, 2)));
            let text = format!(
                "{coordinate} at ({place}) mm: read {} µm, predicted {} µm{}",
                signed(point.reading_um, digits),
                with_u(
                    of_calibration(point),
                    point.expanded_prediction_um(),
                    digits
                ),
                e_n.unwrap_or_default(),
            );
            plot.hover([at, left], &text);
        }
        plot.add_key(class, coordinate);
    }
    (!numbered.is_empty()).then(|| Figure::new(&format!("verification-{}", k + 1), plot.finish()))
}
