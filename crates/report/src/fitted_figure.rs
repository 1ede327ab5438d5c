//! The misfit without a cause, and the cause as fitted to it.

use crate::diagnosis::Fitted;
use crate::numbers::{fixed, signed};
use crate::page::Figure;
use crate::svg::plot::{Frame, Plot};
use crate::svg::ticks::{Scale, range};
use crate::words;

/// Misfit as dots, the fitted cause as a line, of the cause of a rank.
pub(crate) fn fitted_figure(rank: usize, is_of_curve: bool, fitted: &Fitted) -> Option<Figure> {
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
    let is_time = fitted.is_over_time();
    let at = |k: usize| fitted.at.get(k).copied().unwrap_or(f64::NAN);
    let [from, to] = range((0..misfit.len()).map(at));
    let [low, high] = range(misfit.iter().chain(effect).copied().chain([0.0]));
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
        plot.dots(&format!("p{colour}"), of_side().map(|k| [at(k), misfit[k]]));
        let course: Vec<[f64; 2]> = of_side().map(|k| [at(k), effect[k]]).collect();
        plot.line(&format!("l{colour}"), &course);
        for k in of_side() {
            let text = format!(
                "{} = {} {place_unit}: {}, cause {}{glued}",
                fitted.against,
                fixed(at(k), 1),
                signed(misfit[k], 2),
                signed(effect[k], 2)
            );
            plot.hover([at(k), misfit[k]], &text);
        }
    }
    Some(Figure::new(&format!("cause-{rank}"), plot.finish()))
}
