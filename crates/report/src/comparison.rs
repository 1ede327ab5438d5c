//! How a calibration differs from an earlier one of the same machine.

use serde::{Deserialize, Deserializer, Serialize};
use serde_json::Map;
use trueaxis_files::{decimals, told_behind};

use crate::components::{SIZE, thinned};
use crate::numbers::{COVERAGE, signed, with_u};
use crate::page::Figure;
use crate::svg::plot::Plot;
use crate::svg::ticks::{Ruler, range};

/// What figures and tables need of `comparison.json`.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Comparison {
    pub(crate) machine: String,
    /// Campaigns of the two calibrations.
    first: String,
    pub(crate) second: String,
    /// The axes whose positions are degrees.
    rotary_axes: Vec<String>,
    /// Curves and location errors by name, in their order.
    #[serde(deserialize_with = "in_order")]
    differences: Vec<(String, Difference)>,
}

/// The members of an object in their order, without those that are none.
fn in_order<'de, D: Deserializer<'de>>(object: D) -> Result<Vec<(String, Difference)>, D::Error> {
    let all = Map::deserialize(object)?.into_iter();
    let read = all.filter_map(|(name, value)| Some((name, Difference::deserialize(value).ok()?)));
    Ok(read.collect())
}

/// A curve, or a location error: second less first.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Difference {
    difference_um: Option<Vec<Option<f64>>>,
    difference_arcsec: Option<Vec<Option<f64>>>,
    u_um: Vec<Option<f64>>,
    u_arcsec: Vec<Option<f64>>,
    /// Empty for a location error.
    positions: Vec<f64>,
    /// Number of values beyond the noise.
    beyond_noise: usize,
    follows_from_other_steps: bool,
}

#[derive(Serialize)]
pub(crate) struct ComparisonSection {
    first: String,
    rows: Vec<Row>,
    pub(crate) figures: Vec<Figure>,
}

/// The largest difference of a curve, or a location error.
#[derive(Serialize)]
struct Row {
    name: String,
    largest: String,
    said: String,
}

impl Comparison {
    /// The errors that have changed by more than the noise; `None` if that is not known.
    pub(crate) fn changed(&self) -> Option<Vec<&str>> {
        let mut all = self.differences.iter();
        let is_known = all.all(|(_, own)| own.values().all(|(_, u)| u.is_some()));
        let is_changed = |own: &Difference| own.beyond_noise > 0 && !own.follows_from_other_steps;
        let changed = self.differences.iter().filter(|(_, own)| is_changed(own));
        is_known.then(|| changed.map(|(name, _)| name.as_str()).collect())
    }

    /// What it amounts to.
    pub(crate) fn said(&self) -> String {
        let (first, all) = (&self.first, self.differences.len());
        match self.changed().as_deref() {
            None => format!(
                "Whether anything has changed since “{first}” is not known: a calibration has no uncertainties."
            ),
            Some([]) => format!(
                "None of the {all} errors has changed by more than the noise since “{first}”."
            ),
            Some(names) => format!(
                "{} of the {all} errors changed by more than the noise since “{first}”: {}.",
                names.len(),
                names.join(", ")
            ),
        }
    }
}

impl Difference {
    fn unit(&self) -> &'static str {
        if self.difference_arcsec.is_some() {
            "arcsec"
        } else {
            "µm"
        }
    }

    /// Each value that is known, with its U.
    fn values(&self) -> impl Iterator<Item = (f64, Option<f64>)> {
        let (values, u) = match &self.difference_arcsec {
            Some(values) => (Some(values), &self.u_arcsec),
            None => (self.difference_um.as_ref(), &self.u_um),
        };
        let u = u.iter().copied().chain(std::iter::repeat(None));
        let values = values.into_iter().flatten().zip(u);
        values.filter_map(|(value, u)| Some(((*value)?, u.map(|u| COVERAGE * u))))
    }

    fn told((value, expanded): (f64, Option<f64>), unit: &str) -> String {
        let told = match expanded {
            Some(expanded) => with_u(value, expanded, decimals(expanded).min(2)),
            None => signed(value, 2),
        };
        format!("{told}{}", told_behind(unit, ' '))
    }

    fn row(&self, name: &str) -> Option<Row> {
        let largest = self
            .values()
            .max_by(|a, b| a.0.abs().total_cmp(&b.0.abs()))?;
        let count = self.values().count();
        let at = match count {
            1 => String::new(),
            _ => format!(" at {} of {count} positions", self.beyond_noise),
        };
        Some(Row {
            name: name.to_owned(),
            largest: Self::told(largest, self.unit()),
            said: match (self.beyond_noise, self.follows_from_other_steps) {
                (0, _) => String::new(),
                (_, false) => format!("changed{at}"),
                (_, true) => format!("measured at other positions; differs{at}"),
            },
        })
    }

    /// The difference over the positions of the axis, with its band; `None` for a location error.
    fn figure(&self, name: &str, rotary_axes: &[String]) -> Option<Figure> {
        // A letter for the error and one for its direction come before the axis.
        let (start, _) = name
            .char_indices()
            .nth(2)
            .filter(|_| self.positions.len() > 1)?;
        let axis = &name[start..];
        let is_rotary = rotary_axes.iter().any(|rotary| rotary == axis);
        let position_unit = if is_rotary { "°" } else { " mm" };
        let nodes = self.positions.iter().zip(self.values());
        let nodes = nodes.map(|(x, (value, u))| [*x, value, u.unwrap_or(f64::NAN)]);
        let nodes = thinned(nodes.collect());
        let [from, to] = range(nodes.iter().map(|[x, ..]| *x));
        let ends = nodes
            .iter()
            .flat_map(|[_, value, u]| [value - u, value + u]);
        let [low, high] = range(ends.chain([0.0]));
        let x_label = format!("{axis} in {}", position_unit.trim());
        let y_label = format!("change in {}", self.unit());
        let x = (x_label.as_str(), Ruler::positions(is_rotary, from, to, 5));
        let mut plot = Plot::new(SIZE, name, x, (&y_label, Ruler::new(low, high, 5)));
        plot.curve(0, &nodes);
        for [x, value, u] in &nodes {
            let told = Self::told((*value, Some(*u).filter(|u| u.is_finite())), self.unit());
            plot.hover(
                [*x, *value],
                &format!("{axis} = {x}{position_unit}: {name} changed by {told}"),
            );
        }
        Some(Figure::new(&format!("change-{name}"), plot.finish()))
    }
}

impl ComparisonSection {
    pub(crate) fn new(comparison: &Comparison) -> Self {
        let all = &comparison.differences;
        let figure = |(name, own): &(String, Difference)| own.figure(name, &comparison.rotary_axes);
        Self {
            first: comparison.first.clone(),
            rows: all.iter().filter_map(|(name, own)| own.row(name)).collect(),
            figures: all.iter().filter_map(figure).collect(),
        }
    }
}
