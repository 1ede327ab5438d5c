//! The misfit without a cause, and the cause as fitted to it.

use trueaxis_files::{told_behind, unit_symbol};

use crate::diagnosis::Fitted;
use crate::numbers::{fixed, signed, with_u};
use crate::page::Figure;
use crate::svg::Drawing;
use crate::svg::plot::Plot;
use crate::svg::ticks::{Ruler, range};

/// A figure for each coordinate in which the cause of a rank shows, the one in which it shows most first, all
/// drawn alike.
pub(crate) fn fitted_figures(rank: usize, is_of_curve: bool, fitted: &Fitted) -> Vec<Figure> {
    let coordinates: Vec<Values<'_>> = std::iter::once(fitted)
        .chain(&fitted.beside)
        .filter_map(|fitted| Values::new(fitted, is_of_curve))
        .collect();
    let bounds = coordinates.iter().flat_map(Values::bounds);
    let [low, high] = range(bounds.chain([0.0]));
    let size = match coordinates.len() > 1 || is_of_curve {
        true => [300.0, 190.0],
        false => [430.0, 220.0],
    };
    let figures = coordinates.iter().zip(1..).map(|(values, k)| {
        let name = match k {
            1 => format!("cause-{rank}"),
            _ => format!("cause-{rank}-{k}"),
        };
        Figure::new(&name, values.drawn(size, Ruler::new(low, high, 5)))
    });
    figures.collect()
}

/// One coordinate: misfit as dots, the fitted cause as a line. The band around the line holds 95 % of the dots where noise
/// alone is left; beside a part of an error curve a smooth course is left, and the band is that of the curve.
struct Values<'a> {
    of: &'a Fitted,
    is_of_curve: bool,
    misfit: &'a [f64],
    effect: &'a [f64],
    u: &'a [f64],
    unit: &'static str,
}

impl<'a> Values<'a> {
    fn new(of: &'a Fitted, is_of_curve: bool) -> Option<Self> {
        let one_of =
            |a: &'a Option<Vec<f64>>, b: &'a Option<Vec<f64>>| a.as_deref().or(b.as_deref());
        Some(Self {
            of,
            is_of_curve,
            misfit: one_of(&of.misfit_um, &of.misfit_arcsec)?,
            effect: one_of(&of.fitted_um, &of.fitted_arcsec)?,
            u: one_of(&of.u_um, &of.u_arcsec).unwrap_or_default(),
            unit: match of.fitted_arcsec {
                Some(_) => "arcsec",
                None => "µm",
            },
        })
    }

    fn expanded(&self, k: usize) -> f64 {
        2.0 * self.u.get(k).copied().unwrap_or(0.0)
    }

    /// An edge of the band.
    fn edge(&self, k: usize, sign: f64) -> f64 {
        let middle = if self.is_of_curve {
            self.misfit
        } else {
            self.effect
        };
        middle.get(k).copied().unwrap_or(f64::NAN) + sign * self.expanded(k)
    }

    fn bounds(&self) -> impl Iterator<Item = f64> {
        let edges = (0..self.effect.len()).flat_map(|k| [self.edge(k, -1.0), self.edge(k, 1.0)]);
        self.misfit.iter().chain(self.effect).copied().chain(edges)
    }

    fn drawn(&self, size: [f64; 2], y: Ruler) -> Drawing {
        let Self {
            of: fitted,
            misfit,
            effect,
            unit,
            ..
        } = self;
        let glued = told_behind(unit, ' ');
        let is_time = fitted.is_over_time();
        let at = |k: usize| fitted.at.get(k).copied().unwrap_or(f64::NAN);
        let [from, to] = range((0..misfit.len()).map(at));
        let place_unit = unit_symbol(&fitted.unit);
        let x_label = match fitted.against.as_str() {
            "order" => "number of the reading".to_owned(),
            against => format!("{against} in {place_unit}"),
        };
        let what = if self.is_of_curve { "error" } else { "misfit" };
        let y_label = format!("{what} in {unit}");
        let most_ticks = if size[0] > 400.0 { 5 } else { 4 };
        let x = Ruler::positions(place_unit == "°", from, to, most_ticks);
        let mut plot = Plot::new(size, &fitted.of, (&x_label, x), (&y_label, y));
        // Time has no sides; over a position each side of approach has its own course.
        let is_on = |k: usize, forward: bool| {
            let side = fitted.direction.get(k).copied().unwrap_or(1);
            (is_time || side > 0) == forward
        };
        for (colour, forward) in [(0, true), (1, false)] {
            let of_side = || (0..misfit.len().min(effect.len())).filter(|&k| is_on(k, forward));
            let bound = |sign: f64| -> Vec<[f64; 2]> {
                of_side().map(|k| [at(k), self.edge(k, sign)]).collect()
            };
            if !self.u.is_empty() {
                plot.band(colour, &bound(-1.0), &bound(1.0));
            }
            plot.marks(&format!("p{colour}"), of_side().map(|k| [at(k), misfit[k]]));
            plot.line(&format!("l{colour}"), of_side().map(|k| [at(k), effect[k]]));
            for k in of_side() {
                let told = match self.u.get(k) {
                    Some(u) => with_u(misfit[k], 2.0 * u, 2),
                    None => signed(misfit[k], 2),
                };
                let text = format!(
                    "{} = {} {place_unit}: {told}, cause {}{glued}",
                    fitted.against,
                    fixed(at(k), 1),
                    signed(effect[k], 2)
                );
                plot.hover([at(k), misfit[k]], &text);
            }
            if of_side().next().is_some() {
                let side = match (fitted.has_sides(), forward) {
                    (false, _) => "",
                    (true, true) => ", forward",
                    (true, false) => ", backward",
                };
                plot.add_key(&format!("p{colour}"), &format!("without the cause{side}"));
                plot.add_key(&format!("l{colour}"), &format!("the cause{side}"));
            }
        }
        plot.finish()
    }
}
