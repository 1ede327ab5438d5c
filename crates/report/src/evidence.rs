//! Figures of the residuals: what is left of the lengths, or of the coordinates of points.

use serde::Serialize;
use trueaxis_leastsquares::median;

use crate::calibration::Machine;
use crate::numbers::{fixed, normal_quantile, rough};
use crate::page::Figure;
use crate::residuals::{Residuals, Row};
use crate::svg::plot::{Plot, series_class};
use crate::svg::ticks::{Ruler, bounds, range};
use crate::words::shortened;

/// Above this many lengths each figure shows every n-th dot, and all that stand out.
const MOST_DOTS: usize = 20_000;

/// Dots of a figure above 100,000 lengths.
const DOTS_OF_MANY: usize = 10_000;
const MANY: usize = 100_000;

/// A residual of this many standard deviations stands out: it is always drawn, and named.
const FAR: f64 = 3.5;
const MOST_NAMED: usize = 200;

/// Letters of a name under a tick.
const MOST_LETTERS: usize = 6;

const WIDE: [f64; 2] = [900.0, 280.0];
const SMALL: [f64; 2] = [340.0, 230.0];

/// The residuals in figures and numbers.
#[derive(Serialize)]
pub(crate) struct Evidence {
    time: Figure,
    by_series: Figure,
    quantiles: Figure,
    over_position: Vec<Figure>,
    /// What the legend names and what the residuals are of: stations and lengths, or coordinates.
    by: &'static str,
    observed: &'static str,
    legend: Vec<String>,
    /// The class of the mark of each.
    marks: Vec<String>,
    /// n where only every n-th dot is drawn.
    thinned: Option<usize>,
    count: usize,
    reliability: Option<Redundancy>,
}

#[derive(Serialize)]
struct Redundancy {
    least: String,
    median: String,
    /// Those of which less than a tenth of an error would show.
    hardly_checked: usize,
}

const HARDLY: f64 = 0.1;

impl Evidence {
    /// `None` of an empty table.
    pub(crate) fn new(residuals: &Residuals, machine: Option<&Machine>) -> Option<Self> {
        if residuals.rows.is_empty() {
            return None;
        }
        let drawn = match residuals.rows.len() {
            count if count <= MOST_DOTS => count,
            count if count <= MANY => MOST_DOTS,
            _ => DOTS_OF_MANY,
        };
        let every = residuals.rows.len().div_ceil(drawn);
        let axes = 0..residuals.axes.len();
        let is_rotary =
            |axis: usize| machine.is_some_and(|machine| machine.is_rotary(&residuals.axes[axis]));
        let noise = half_of_noise(residuals);
        Some(Self {
            time: in_time(residuals, every, noise),
            by_series: by_series(residuals),
            quantiles: quantiles(residuals),
            over_position: axes
                .filter_map(|axis| over_position(residuals, axis, every, is_rotary(axis), noise))
                .collect(),
            by: by(residuals),
            observed: match residuals.of_points {
                true => "coordinates",
                false => "lengths",
            },
            legend: residuals.series.clone(),
            marks: (0..residuals.series.len())
                .map(|series| series_class('i', series))
                .collect(),
            thinned: (every > 1).then_some(every),
            count: residuals.rows.len(),
            reliability: redundancy(residuals),
        })
    }

    pub(crate) fn figures(&self) -> impl Iterator<Item = &Figure> {
        let single = [&self.time, &self.by_series, &self.quantiles];
        single.into_iter().chain(&self.over_position)
    }
}

/// What tells the series apart.
fn by(residuals: &Residuals) -> &'static str {
    match residuals.of_points {
        true => "coordinate",
        false => "station",
    }
}

/// The name of a length or a coordinate.
fn observed(residuals: &Residuals, series: usize, target: usize) -> String {
    let (series, target) = (&residuals.series[series], &residuals.targets[target]);
    match residuals.of_points {
        true => format!("{series} of {target}"),
        false => format!("{series} to {target}"),
    }
}

fn shown(residuals: &Residuals, every: usize) -> impl Iterator<Item = (usize, &Row)> {
    let rows = residuals.rows.iter().enumerate();
    rows.filter(move |(k, row)| k % every == 0 || row.standardized.abs() > FAR)
}

/// What all but the far ones lie in: a wrong length must not make the others a line.
fn of_used(residuals: &Residuals) -> Ruler {
    let [low, high] = range(residuals.used().map(|row| row.residual_um));
    let half = low.abs().max(high.abs());
    Ruler::new(-half, half, 5)
}

/// Half of the range in which 95 % of the residuals lie where noise alone is left; of the median length, µm.
fn half_of_noise(residuals: &Residuals) -> Option<f64> {
    let u = residuals.used();
    let u = u.map(|row| (row.residual_um / row.standardized).abs());
    median(&mut u.filter(|u| u.is_finite()).collect::<Vec<_>>()).map(|u| 1.96 * u)
}

/// Dashed lines at the ends of that range.
fn draw_noise(plot: &mut Plot, half: Option<f64>, from: f64, to: f64) {
    for edge in half.into_iter().flat_map(|half| [-half, half]) {
        plot.line("rule", [[from, edge], [to, edge]]);
    }
}

fn in_time(residuals: &Residuals, every: usize, noise: Option<f64>) -> Figure {
    let [from, to] = range(residuals.rows.iter().map(|row| row.time_s));
    let y = of_used(residuals);
    let half = y.high;
    let from = from.max(0.0).min(to);
    let x = ("time in s", Ruler::new(from, to, 8));
    let mut plot = Plot::new(WIDE, "", x, ("residual in µm", y));
    let at = |row: &Row| [row.time_s, row.residual_um.clamp(-half, half)];
    for series in 0..residuals.series.len() {
        let of_series = shown(residuals, every).filter(|(_, row)| row.used && row.series == series);
        let points = of_series.map(|(_, row)| at(row));
        plot.marks(&series_class('p', series), points);
    }
    let removed = residuals.rows.iter().filter(|row| !row.used);
    plot.marks("out", removed.map(at));
    draw_noise(&mut plot, noise, from, to);
    let far = residuals
        .rows
        .iter()
        .filter(|row| !row.used || row.standardized.abs() > FAR);
    for row in far.take(MOST_NAMED) {
        let text = format!(
            "line {}: {}, {} µm, {} standard deviations{}",
            row.line,
            observed(residuals, row.series, row.target),
            rough(row.residual_um),
            rough(row.standardized),
            if row.used { "" } else { ", removed" }
        );
        plot.hover(at(row), &text);
    }
    for (series, name) in residuals.series.iter().enumerate() {
        plot.add_key(&series_class('p', series), name);
    }
    plot.add_key("out", "removed");
    if noise.is_some() {
        plot.add_key("rule", "95 % of noise alone");
    }
    Figure::new("residuals-time", plot.finish())
}

/// Rms of the standardized residuals of each target from each station, or of each coordinate, with the range that
/// noise alone leaves it.
fn by_series(residuals: &Residuals) -> Figure {
    let (series, targets) = (residuals.series.len(), residuals.targets.len());
    let mut sums = vec![(0.0, 0_usize); series * targets];
    for row in residuals.used().filter(|row| row.standardized.is_finite()) {
        let (squares, count) = &mut sums[row.series * targets + row.target];
        *squares += row.standardized * row.standardized;
        *count += 1;
    }
    let rms: Vec<(usize, usize, f64, f64)> = sums
        .iter()
        .enumerate()
        .filter(|(_, (_, count))| *count > 0)
        .map(|(k, (squares, count))| {
            let count = *count as f64;
            // The rms of n standard normal numbers is normal about 1 with 1 / √(2 n).
            (
                k / targets,
                k % targets,
                (squares / count).sqrt(),
                1.96 / (2.0 * count).sqrt(),
            )
        })
        .collect();
    let ends = rms
        .iter()
        .flat_map(|(_, _, rms, half)| [*rms, 1.0 - half, 1.0 + half]);
    let [low, high] = range(ends);
    let mut x = Ruler::new(-0.5, series as f64 - 0.5, 5);
    let most = 8;
    let every = series.div_ceil(most).max(1);
    let named = residuals.series.iter().enumerate().step_by(every);
    x.ticks = named
        .map(|(k, name)| (k as f64, shortened(name, MOST_LETTERS)))
        .collect();
    let title = format!("rms by {} and target", by(residuals));
    let y = ("rms (1 if noise alone)", Ruler::new(low.max(0.0), high, 5));
    let mut plot = Plot::new(SMALL, &title, (by(residuals), x), y);
    for (series, target, rms, half) in rms {
        let spread = 0.7 * ((target as f64 + 0.5) / targets as f64 - 0.5);
        let x = series as f64 + spread;
        plot.line("range", [[x, 1.0 - half], [x, 1.0 + half]]);
        plot.marks("m0", [[x, rms]]);
        let text = format!(
            "{}: {} (noise alone: {} to {})",
            observed(residuals, series, target),
            fixed(rms, 2),
            fixed(1.0 - half, 2),
            fixed(1.0 + half, 2)
        );
        plot.hover([x, rms], &text);
    }
    Figure::new(&format!("residuals-{}s", by(residuals)), plot.finish())
}

/// Quantiles of the standardized residuals against those of the normal distribution.
fn quantiles(residuals: &Residuals) -> Figure {
    let w = residuals.used().map(|row| row.standardized);
    let mut w: Vec<f64> = w.filter(|w| w.is_finite()).collect();
    w.sort_unstable_by(f64::total_cmp);
    let count = w.len();
    let probability = |k: usize| (k as f64 + 0.5) / count as f64;
    // All of the tails, where the question is; every n-th of the middle.
    const MOST: usize = 1200;
    const TAIL: usize = 100;
    let every = count.div_ceil(MOST).max(1);
    let kept: Vec<usize> = (0..count)
        .filter(|k| k % every == 0 || *k < TAIL || *k + TAIL >= count)
        .collect();
    let expected: Vec<f64> = kept
        .iter()
        .map(|&k| normal_quantile(probability(k)))
        .collect();
    let [low, high] = range(kept.iter().map(|&k| w[k]).chain(expected.iter().copied()));
    let half = low.abs().max(high.abs()).min(8.0);
    let title = "quantiles of standardized residuals";
    let labels = ["normal distribution", "residuals, standardized"];
    let [x, y] = labels.map(|label| (label, Ruler::new(-half, half, 6)));
    let mut plot = Plot::new(SMALL, title, x, y);
    // As many residuals are independent as there are degrees of freedom: the sum of the redundancy numbers.
    let redundancy = residuals.rows.iter().filter_map(|row| row.redundancy);
    let independent = redundancy.sum::<f64>().clamp(1.0, count.max(1) as f64);
    // Pointwise 95 % range of an order statistic (asymptotic).
    let spread = |k: usize, z: f64| {
        let p = probability(k);
        let density = (-0.5 * z * z).exp() / std::f64::consts::TAU.sqrt();
        1.96 * (p * (1.0 - p) / independent).sqrt() / density
    };
    let edge = |sign: f64| -> Vec<[f64; 2]> {
        let points = kept.iter().zip(&expected);
        points
            .map(|(&k, &z)| [z, (z + sign * spread(k, z)).clamp(-half, half)])
            .collect()
    };
    plot.band(2, &edge(-1.0), &edge(1.0));
    plot.line("rule", [[-half, -half], [half, half]]);
    let points = kept
        .iter()
        .zip(&expected)
        .map(|(&k, &z)| [z, w[k].clamp(-half, half)]);
    plot.marks("p0", points);
    Figure::new("residuals-quantiles", plot.finish())
}

/// Over the position of an axis, of the runs in which it alone moves.
fn over_position(
    residuals: &Residuals,
    axis: usize,
    every: usize,
    is_rotary: bool,
    noise: Option<f64>,
) -> Option<Figure> {
    let mut ends = vec![[f64::INFINITY, f64::NEG_INFINITY]; residuals.runs.len()];
    for (k, row) in residuals.rows.iter().enumerate() {
        let position = residuals.positions(k)[axis];
        let [low, high] = ends[row.run];
        ends[row.run] = [low.min(position), high.max(position)];
    }
    let moves = |run: usize| {
        let [low, high] = ends[run];
        !residuals.runs[run].is_empty() && high > low
    };
    let points: Vec<(usize, [f64; 2])> = shown(residuals, every)
        .filter(|(_, row)| row.used && moves(row.run))
        .map(|(k, row)| (row.series, [residuals.positions(k)[axis], row.residual_um]))
        .collect();
    if points.is_empty() {
        return None;
    }
    let [from, to] = range(points.iter().map(|(_, point)| point[0]));
    let name = &residuals.axes[axis];
    let title = format!("over the position of {name}");
    let label = format!("{name} in {}", if is_rotary { "°" } else { "mm" });
    let x = (&*label, Ruler::positions(is_rotary, from, to, 5));
    let mut plot = Plot::new(SMALL, &title, x, ("residual in µm", of_used(residuals)));
    for series in 0..residuals.series.len() {
        let of_series = points.iter().filter(|(of, _)| *of == series);
        let points = of_series.map(|(_, point)| *point);
        plot.marks(&series_class('p', series), points);
    }
    draw_noise(&mut plot, noise, from, to);
    Some(Figure::new(&format!("residuals-{name}"), plot.finish()))
}

fn redundancy(residuals: &Residuals) -> Option<Redundancy> {
    let numbers = residuals.rows.iter().filter_map(|row| row.redundancy);
    let mut numbers: Vec<f64> = numbers.collect();
    Some(Redundancy {
        median: fixed(median(&mut numbers)?, 2),
        // Of lengths with common noise it may be below zero: nothing of an error shows.
        least: fixed(bounds(numbers.iter().copied())[0].max(0.0), 2),
        hardly_checked: numbers.iter().filter(|r| **r < HARDLY).count(),
    })
}
