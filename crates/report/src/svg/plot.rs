//! A plot: two axes with units, and marks in their coordinates.

use crate::svg::Drawing;
use crate::svg::ticks::Ruler;
use crate::words::shortened;

/// Space for what stands beside the plotting area.
const LEFT: f64 = 52.0;
const RIGHT: f64 = 14.0;
const TOP: f64 = 8.0;
const TITLE: f64 = 22.0;
const BOTTOM: f64 = 40.0;

/// Radius of the place around a value that shows it.
const HIT: f64 = 7.0;

/// A plot under way.
pub(crate) struct Plot {
    drawing: Drawing,
    x: Ruler,
    y: Ruler,
    width: f64,
    bottom: f64,
    top: f64,
}

/// Width of a letter of a title, on average with some reserve.
const TITLE_LETTER: f64 = 7.6;

impl Plot {
    /// Of a size, with a title that may be empty, and each axis with its label.
    pub(crate) fn new(
        size: [f64; 2],
        title: &str,
        (x_label, x): (&str, Ruler),
        (y_label, y): (&str, Ruler),
    ) -> Self {
        let [width, height] = size;
        let top = TOP + if title.is_empty() { 0.0 } else { TITLE };
        let described = match title {
            "" => format!("{y_label} over {x_label}"),
            title => format!("{title}: {y_label} over {x_label}"),
        };
        let mut plot = Self {
            drawing: Drawing::new(width, height, described),
            x,
            y,
            width,
            bottom: height - BOTTOM,
            top,
        };
        plot.axes(title, x_label, y_label);
        plot
    }

    fn axes(&mut self, title: &str, x_label: &str, y_label: &str) {
        let (left, right) = (LEFT, self.width - RIGHT);
        let (top, bottom) = (self.top, self.bottom);
        if !title.is_empty() {
            // No plot is so narrow that not a letter has room.
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "letters in a width"
            )]
            let most = (self.width / TITLE_LETTER) as usize;
            let title = shortened(title, most);
            self.drawing.text([4.0, 16.0], "t", "start", &title);
        }
        for (value, text) in self.y.ticks.clone() {
            let y = self.at([self.x.low, value])[1];
            let class = if value.abs() < f64::MIN_POSITIVE {
                "zero"
            } else {
                "grid"
            };
            self.drawing.path(class, [[left, y], [right, y]]);
            self.drawing.text([left - 6.0, y + 4.0], "n", "end", &text);
        }
        for (value, text) in self.x.ticks.clone() {
            let x = self.at([value, self.y.low])[0];
            self.drawing.path("tick", [[x, bottom], [x, bottom + 4.0]]);
            self.drawing.text([x, bottom + 16.0], "n", "middle", &text);
        }
        self.drawing
            .path("axis", [[left, top], [left, bottom], [right, bottom]]);
        let below = [0.5 * (left + right), bottom + BOTTOM - 6.0];
        self.drawing.text(below, "l", "middle", x_label);
        let beside = [13.0, 0.5 * (top + bottom)];
        self.drawing.text_upwards(beside, y_label);
    }

    /// Where a value is, in the drawing.
    fn at(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [
            LEFT + self.x.place(x) * (self.width - LEFT - RIGHT),
            self.bottom - self.y.place(y) * (self.bottom - self.top),
        ]
    }

    fn inside(&self, points: impl IntoIterator<Item = [f64; 2]>) -> Vec<[f64; 2]> {
        let points = points.into_iter();
        let finite = points.filter(|[x, y]| x.is_finite() && y.is_finite());
        finite.map(|point| self.at(point)).collect()
    }

    /// What lies between two curves, in the order of their points.
    pub(crate) fn band(&mut self, colour: usize, low: &[[f64; 2]], high: &[[f64; 2]]) {
        let around = low.iter().chain(high.iter().rev()).copied();
        let points = self.inside(around);
        self.drawing.path(&format!("b{colour}"), points);
    }

    /// A curve with its points and its band; of each point its place, value and half of the band.
    pub(crate) fn curve(&mut self, colour: usize, points: &[[f64; 3]]) {
        let at = |shift: f64| -> Vec<[f64; 2]> {
            points
                .iter()
                .map(|[x, value, half]| [*x, value + shift * half])
                .collect()
        };
        // A band may be infinite, and nothing times that is no number.
        let middle = || points.iter().map(|[x, value, _]| [*x, *value]);
        self.band(colour, &at(-1.0), &at(1.0));
        self.line(&format!("l{colour}"), middle());
        self.marks(&format!("m{colour}"), middle());
    }

    pub(crate) fn line(&mut self, class: &str, points: impl IntoIterator<Item = [f64; 2]>) {
        let points = self.inside(points);
        self.drawing.path(class, points);
    }

    /// Dots, or crosses of a class that ends in ` x`.
    pub(crate) fn marks(&mut self, class: &str, points: impl IntoIterator<Item = [f64; 2]>) {
        let points = self.inside(points);
        self.drawing.marks(class, points);
    }

    /// Shows `text` at a value.
    pub(crate) fn hover(&mut self, point: [f64; 2], text: &str) {
        if point.iter().all(|x| x.is_finite()) {
            let at = self.at(point);
            self.drawing.hover(at, HIT, text);
        }
    }

    /// Says in a file of its own what marks of a class mean.
    pub(crate) fn add_key(&mut self, class: &str, words: &str) {
        self.drawing.add_key(class, words);
    }

    pub(crate) fn finish(self) -> Drawing {
        self.drawing
    }
}

/// Number of colours that can be told apart.
pub(crate) const COLOURS: usize = 6;

/// The class of the marks of a series, of which `p` is the letter, or in a legend `i`: crosses beyond the sixth.
pub(crate) fn series_class(letter: char, number: usize) -> String {
    let (colour, is_cross) = (number % COLOURS, number / COLOURS % 2 == 1);
    format!("{letter}{colour}{}", if is_cross { " x" } else { "" })
}
