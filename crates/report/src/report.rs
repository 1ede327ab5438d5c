//! The headline verb: a folder of results to a page.

use std::path::Path;

use minijinja::syntax::SyntaxConfig;
use minijinja::value::Serde;
use minijinja::{AutoEscape, Environment, UndefinedBehavior};

use crate::Error;
use crate::input::Input;
use crate::page::Page;

/// The template of the page.
const TEMPLATE: &str = include_str!("report.html");

/// The script of the page: the view that turns, and the values that hovering shows.
const SCRIPT: &str = include_str!("report.js");

/// A report.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Report {
    /// The page, complete in itself.
    pub html: String,
    /// The same figures as files: name and SVG.
    pub figures: Vec<(String, String)>,
}

impl Report {
    /// File name of the page.
    pub const FILE: &str = "report.html";

    /// Folder of the figures, beside the page.
    pub const FIGURES: &str = "figures";
}

/// Shows the results in `folder`, by a template in place of the program's own if one is given.
///
/// # Errors
/// If the folder has no result, if a file in it is not what its name says, or if the template fails. Files that are
/// not there leave their part of the page out.
pub fn report(folder: &Path, template: Option<&str>) -> Result<Report, Error> {
    let input = Input::read(folder)?;
    let page = Page::new(&input);
    let html = render(template.unwrap_or(TEMPLATE), &page);
    let figures = page.figures().into_iter();
    let figures = figures.map(|figure| (format!("{}.svg", figure.name), figure.alone.clone()));
    Ok(Report {
        html: html.map_err(|source| Error::Template { source })?,
        figures: figures.collect(),
    })
}

fn render(template: &str, page: &Page<'_>) -> Result<String, minijinja::Error> {
    let mut environment = Environment::new();
    environment.set_auto_escape_callback(|_| AutoEscape::Html);
    environment.set_undefined_behavior(UndefinedBehavior::Chainable);
    environment.set_syntax(
        SyntaxConfig::builder()
            .trim_blocks(true)
            .lstrip_blocks(true)
            .build()?,
    );
    environment.add_global("script", SCRIPT);
    environment.add_filter("digits", |value: f64, decimals: usize| {
        crate::numbers::fixed(value, decimals)
    });
    environment.add_filter("rough", crate::numbers::rough);
    environment.add_filter("extent", |value: f64, unit: &str| {
        let (unit, size) = trueaxis_files::told_unit(value, unit);
        format!("{} {unit}", crate::numbers::rough(value / size))
    });
    environment.add_filter("sentence", |text: Option<String>| {
        crate::words::sentence(&text.unwrap_or_default())
    });
    environment.add_filter("probability", crate::numbers::probability);
    environment.add_filter("p_value", crate::numbers::p_value);
    environment.add_template("report.html", template)?;
    environment.get_template("report.html")?.render(Serde(page))
}
