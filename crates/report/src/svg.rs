//! Drawings as SVG text.
//!
//! Marks have classes; colours come from a style sheet, so that the page shows them dark or light. A file of its
//! own carries the light ones and the key that stands beside the figure on the page ([`Drawing::alone`]). All text is escaped.

pub(crate) mod plot;
pub(crate) mod ticks;

use std::fmt::{Display, Write};

/// The colours of a drawing that stands alone; those of the page are in its template.
const STYLE: &str = include_str!("figure.css");

/// A drawing that grows mark by mark.
pub(crate) struct Drawing {
    width: f64,
    height: f64,
    title: String,
    body: String,
    /// What marks mean: their class and the words.
    key: Vec<(String, String)>,
}

/// A line of the key, what its marks take, and a letter, pixels.
const KEY_LINE: f64 = 18.0;
const KEY_MARK: f64 = 24.0;
const KEY_LETTER: f64 = 6.8;

impl Drawing {
    /// A screen reader reads out `title`.
    pub(crate) fn new(width: f64, height: f64, title: impl Into<String>) -> Self {
        Self {
            width,
            height,
            title: title.into(),
            body: String::new(),
            key: Vec::new(),
        }
    }

    /// Says in a file of its own what marks of a class mean.
    pub(crate) fn add_key(&mut self, class: &str, words: &str) {
        self.key.push((class.to_owned(), words.to_owned()));
    }

    /// An element; attributes are numbers and names of our own, never text from a file.
    pub(crate) fn element(&mut self, element: std::fmt::Arguments<'_>) {
        // Writing to a String cannot fail.
        let _ = writeln!(self.body, "<{element}/>");
    }

    /// `anchor` is `start`, `middle` or `end`.
    pub(crate) fn text(&mut self, [x, y]: [f64; 2], class: &str, anchor: &str, text: &str) {
        let (x, y) = (coordinate(x), coordinate(y));
        let text = escaped(text);
        let _ = writeln!(
            self.body,
            r#"<text x="{x}" y="{y}" class="{class}" text-anchor="{anchor}">{text}</text>"#
        );
    }

    /// Text that reads upwards.
    pub(crate) fn text_upwards(&mut self, [x, y]: [f64; 2], text: &str) {
        let (x, y) = (coordinate(x), coordinate(y));
        let text = escaped(text);
        let _ = writeln!(
            self.body,
            r#"<text transform="translate({x} {y}) rotate(-90)" text-anchor="middle">{text}</text>"#
        );
    }

    /// A place that shows `text` when pointed at.
    pub(crate) fn hover(&mut self, [x, y]: [f64; 2], radius: f64, text: &str) {
        let (x, y) = (coordinate(x), coordinate(y));
        let text = escaped(text);
        let _ = writeln!(
            self.body,
            r#"<circle class="hit" cx="{x}" cy="{y}" r="{radius}"><title>{text}</title></circle>"#
        );
    }

    pub(crate) fn path(&mut self, class: &str, points: impl IntoIterator<Item = [f64; 2]>) {
        let mut d = String::new();
        for [x, y] in points {
            let letter = if d.is_empty() { 'M' } else { 'L' };
            let _ = write!(d, "{letter}{} {}", coordinate(x), coordinate(y));
        }
        self.path_of(class, &d);
    }

    fn path_of(&mut self, class: &str, d: &str) {
        if !d.is_empty() {
            self.element(format_args!(r#"path class="{class}" d="{d}""#));
        }
    }

    /// Dots, or crosses of a class that ends in ` x`, as one element: thousands of them stay small.
    pub(crate) fn marks(&mut self, class: &str, points: impl IntoIterator<Item = [f64; 2]>) {
        let (beside, mark) = match class.ends_with(" x") {
            true => (-2.0, "l4 4m0-4l-4 4"),
            false => (0.0, "h0"),
        };
        let mut d = String::new();
        for [x, y] in points {
            let (x, y) = (coordinate(x + beside), coordinate(y + beside));
            let _ = write!(d, "M{x} {y}{mark}");
        }
        self.path_of(class, &d);
    }

    /// For a page, which has the style.
    pub(crate) fn inline(&self) -> String {
        self.with("", "")
    }

    /// For a file.
    pub(crate) fn alone(&self) -> String {
        let style = format!("<style>{STYLE}</style>\n");
        let with_key = self.with_key();
        let mut text = with_key.with(r#" xmlns="http://www.w3.org/2000/svg""#, &style);
        text.push('\n');
        text
    }

    /// With the key below it, in as many lines as it needs.
    fn with_key(&self) -> Self {
        let mut all = Self {
            body: self.body.clone(),
            title: self.title.clone(),
            key: Vec::new(),
            ..*self
        };
        let mut at = [KEY_MARK / 2.0, self.height + KEY_LINE / 2.0];
        for (class, words) in &self.key {
            let width = KEY_MARK + KEY_LETTER * (words.chars().count() + 2) as f64;
            if at[0] > KEY_MARK && at[0] + width > self.width {
                at = [KEY_MARK / 2.0, at[1] + KEY_LINE];
            }
            let [x, y] = at;
            match class.chars().next() {
                Some('f') => {
                    let (x, y) = (coordinate(x), coordinate(y - 5.0));
                    all.element(format_args!(
                        r#"rect class="{class}" x="{x}" y="{y}" width="16" height="10""#
                    ));
                }
                Some('l' | 'r') => all.path(class, [[x, y], [x + 18.0, y]]),
                _ => all.marks(class, [[x + 8.0, y]]),
            }
            all.text([x + KEY_MARK, y + 4.0], "k", "start", words);
            at[0] += width;
        }
        if !self.key.is_empty() {
            all.height = at[1] + KEY_LINE / 2.0;
        }
        all
    }

    fn with(&self, space: &str, style: &str) -> String {
        let (width, height) = (coordinate(self.width), coordinate(self.height));
        let title = escaped(&self.title);
        format!(
            "<svg{space} class=\"figure\" viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"{title}\">\n{style}{}</svg>",
            self.body
        )
    }
}

/// A coordinate to a tenth of a pixel, without idle digits.
pub(crate) fn coordinate(value: f64) -> impl Display {
    // Beyond, a drawing has lost its meaning and its file its size.
    (10.0 * value.clamp(-1e5, 1e5)).round() / 10.0 + 0.0
}

/// Text that is neither markup nor a control character, which no XML may hold.
pub(crate) fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\'' => escaped.push_str("&#39;"),
            c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => escaped.push(' '),
            c => escaped.push(c),
        }
    }
    escaped
}
