//! The misfit without a cause, and the cause as fitted to it.

use crate::diagnosis::Fitted;
use crate::numbers::{fixed, signed};
use crate::page::Figure;
use crate::svg::plot::{Frame, Plot};
use crate::svg::ticks::{Scale, range};
use crate::words;

/// A figure for each coordinate in which the cause of a rank shows, the one in which it shows most first.
pub(crate) fn fitted_figures(rank: usize, is_of_curve: bool, fitted: &Fitted) -> Vec<Figure> {
    let first = figure(format!("cause-{rank}"), is_of_curve, fitted);
    let beside = fitted.beside.iter().zip(2..);
    let beside = beside.map(|(of, k)| figure(format!("cause-{rank}-{k}"), is_of_curve, of));
    std::iter::once(first).chain(beside).flatten().collect()
}

/// Misfit as dots; the fitted cause as a line with the band in which noise alone leaves 95 % of them.
fn figure(name: String, is_of_curve: bool, fitted: &Fitted) -> Option<Figure> {
    let (unit, glued) = match fitted.fitted_arcsec {
        Some(_) => ("arcsec", "″"),
        None => ("µm", " µm"),
    };
    let misfit = fitted
        .misfit_um
        .as_ref()
        .or(fitted.misfit_arcsec.as_ref())?;
    let effect = fitted
        .fitted_um
        .as_ref()
        .or(fitted.fitted_arcsec.as_ref())?;
    let u = fitted.u_um.as_ref().or(fitted.u_arcsec.as_ref());
    let expanded = |k: usize| 2.0 * u.and_then(|u| u.get(k)).copied().unwrap_or(0.0);
    let is_time = fitted.is_over_time();
    let at = |k: usize| fitted.at.get(k).copied().unwrap_or(f64::NAN);
    let [from, to] = range((0..misfit.len()).map(at));
    let bounds = effect
        .iter()
        .zip(0..)
        .flat_map(|(value, k)| [value - expanded(k), value + expanded(k)]);
    let [low, high] = range(misfit.iter().copied().chain(bounds).chain([0.0]));
    let place_unit = words::unit(&fitted.unit);
    let frame = Frame {
        title: &fitted.of,
        x_label: &match fitted.against.as_str() {
            "order" => "number of the reading".to_owned(),
            against => format!("{against} in {place_unit}"),
        },
        y_label: &match is_of_curve {
            true => format!("error in {unit}"),
            false => format!("misfit in {unit}"),
        },
        size: [430.0, 220.0],
    };
    let x = Scale::positions(place_unit == "°", from, to, 5);
    let mut plot = Plot::new(&frame, x, Scale::new(low, high, 5));
    // Time has no sides; over a position each side of approach has its own course.
    let is_on = |k: usize, forward: bool| {
        let side = fitted.direction.get(k).copied().unwrap_or(1);
        is_time && forward || !is_time && (side > 0) == forward
    };
    for (colour, forward) in [(0, true), (1, false)] {
        let of_side = || (0..misfit.len().min(effect.len())).filter(|&k| is_on(k, forward));
        let bound = |sign: f64| -> Vec<[f64; 2]> {
            of_side()
                .map(|k| [at(k), effect[k] + sign * expanded(k)])
                .collect()
        };
        if u.is_some() {
            plot.band(colour, &bound(-1.0), &bound(1.0));
        }
        plot.dots(&format!("p{colour}"), of_side().map(|k| [at(k), misfit[k]]));
        let course: Vec<[f64; 2]> = of_side().map(|k| [at(k), effect[k]]).collect();
        plot.line(&format!("l{colour}"), &course);
        for k in of_side() {
            let text = format!(
                "{} = {} {place_unit}: {} ± {}, cause {}{glued}",
                fitted.against,
                fixed(at(k), 1),
                signed(misfit[k], 2),
                fixed(expanded(k), 2),
                signed(effect[k], 2)
            );
            plot.hover([at(k), misfit[k]], &text);
        }
    }
    Some(Figure::new(&name, plot.finish()))
}
