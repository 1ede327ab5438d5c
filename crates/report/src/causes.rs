//! The diagnosis: how the misfit splits, and each cause with where it acts.

use serde::Serialize;
use serde_json::Value;

use crate::diagnosis::{Cause, CurvePoint, Diagnosis, Disturbance, Level, MisfitAt, Shares};
use crate::numbers::{decimals, fixed, rough, signed};
use crate::page::Figure;
use crate::svg::Drawing;
use crate::svg::plot::{Frame, Plot};
use crate::svg::ticks::{Scale, range};
use crate::words;

/// The section of the diagnosis.
#[derive(Serialize)]
pub(crate) struct DiagnosisSection {
    levels: Vec<LevelView>,
    /// In the order of `diagnosis.causes`.
    causes: Vec<CauseView>,
    disturbances: Vec<DisturbanceView>,
}

#[derive(Serialize)]
struct LevelView {
    data: String,
    bar: Option<Figure>,
    /// Parts of the bar with their share in per cent and their class.
    legend: Vec<(String, String, String)>,
    places: Option<Figure>,
}

#[derive(Serialize)]
struct CauseView {
    name: String,
    value: String,
    rivals: Vec<String>,
    changes: String,
    explained: Option<String>,
    figure: Option<Figure>,
}

#[derive(Serialize)]
struct DisturbanceView {
    name: String,
    figure: Option<Figure>,
}

const BAR: [f64; 2] = [900.0, 34.0];

/// Results that are listed as changed.
const MOST_CHANGES: usize = 4;

/// Places that fit in a figure.
const MOST_PLACES: usize = 40;

impl DiagnosisSection {
    pub(crate) fn new(diagnosis: &Diagnosis) -> Self {
        let levels = diagnosis.levels.iter().enumerate();
        let disturbances = diagnosis.disturbances.iter().enumerate();
        let causes = diagnosis.causes.iter().enumerate();
        Self {
            levels: levels
                .map(|(k, level)| level_view(k, level, diagnosis))
                .collect(),
            causes: causes.map(|(k, of)| cause(k + 1, of, diagnosis)).collect(),
            disturbances: disturbances.map(|(k, of)| disturbance(k, of)).collect(),
        }
    }

    pub(crate) fn figures(&self) -> impl Iterator<Item = &Figure> {
        let levels = self
            .levels
            .iter()
            .flat_map(|level| level.bar.iter().chain(&level.places));
        let levels = levels.chain(self.causes.iter().flat_map(|cause| &cause.figure));
        levels.chain(self.disturbances.iter().flat_map(|of| &of.figure))
    }
}

fn level_view(k: usize, level: &Level, diagnosis: &Diagnosis) -> LevelView {
    let names: Vec<String> = of_level(diagnosis, level)
        .map(|cause| words::effect(&cause.effect, &cause.subject))
        .collect();
    let parts = parts(level, &names);
    let legend = parts.iter().map(|(name, share, class)| {
        let share = format!("{} %", fixed(100.0 * share, 0));
        (name.clone(), share, class.clone())
    });
    LevelView {
        data: match level.data.is_empty() {
            true => level.level.clone(),
            false => level.data.clone(),
        },
        legend: legend.collect(),
        bar: bar(&format!("shares-{}", k + 1), &parts),
        places: places(&format!("places-{}", k + 1), level),
    }
}

fn of_level<'a>(diagnosis: &'a Diagnosis, level: &'a Level) -> impl Iterator<Item = &'a Cause> {
    diagnosis
        .causes
        .iter()
        .filter(|cause| cause.level == level.level)
}

/// Name, share and class of each part of the misfit; they add up to 1. Without `shares` they follow from the mean
/// squares: what the causes take away together, noise as its floor, the rest.
fn parts(level: &Level, names: &[String]) -> Vec<(String, f64, String)> {
    let causes = || names.iter().cloned();
    match &level.shares {
        Some(Shares {
            causes: of_causes,
            disturbances,
            unexplained,
            noise,
        }) => {
            let named = causes().chain((0..).map(|k| format!("cause {}", k + 1)));
            let of_causes = of_causes.iter().zip(named).enumerate();
            let of_causes =
                of_causes.map(|(k, (share, name))| (name, *share, format!("f{}", k % 6)));
            let smooth: f64 = disturbances.iter().sum();
            of_causes
                .chain((smooth > 0.0).then(|| ("disturbances".to_owned(), smooth, "fd".to_owned())))
                .chain([
                    ("unexplained".to_owned(), *unexplained, "fu".to_owned()),
                    ("noise".to_owned(), *noise, "fn".to_owned()),
                ])
                .collect()
        }
        None => {
            let (Some(before), Some(after), Some(noise)) = (
                level.before.rms_um,
                level.after.rms_um,
                level.noise_floor_um,
            ) else {
                return Vec::new();
            };
            let whole = before * before;
            if !(whole > 0.0 && whole.is_finite()) {
                return Vec::new();
            }
            let noise = (noise * noise / whole).clamp(0.0, 1.0);
            let explained = match names.is_empty() {
                true => 0.0,
                false => (1.0 - after * after / whole).clamp(0.0, 1.0 - noise),
            };
            let named = (!names.is_empty()).then(|| (names.join(", "), explained, "f0".to_owned()));
            let rest = (
                "unexplained".to_owned(),
                1.0 - noise - explained,
                "fu".to_owned(),
            );
            named
                .into_iter()
                .chain([rest, ("noise".to_owned(), noise, "fn".to_owned())])
                .collect()
        }
    }
}

fn bar(name: &str, parts: &[(String, f64, String)]) -> Option<Figure> {
    let whole: f64 = parts.iter().map(|(_, share, _)| share.max(0.0)).sum();
    if !(whole > 0.0 && whole.is_finite()) {
        return None;
    }
    let title = parts
        .iter()
        .map(|(name, share, _)| format!("{name} {} %", fixed(100.0 * share, 0)));
    let title: Vec<String> = title.collect();
    let mut drawing = Drawing::new(BAR[0], BAR[1], title.join(", "));
    let mut x = 0.0;
    for (_, share, class) in parts {
        let width = BAR[0] * share.max(0.0) / whole;
        drawing.element(format_args!(
            r#"rect class="{class}" x="{x:.1}" y="3" width="{:.1}" height="28""#,
            (width - 1.0).max(0.0)
        ));
        x += width;
    }
    Some(Figure::new(name, drawing))
}

/// The misfit by station, target, axis and so on, without and with the causes.
fn places(name: &str, level: &Level) -> Option<Figure> {
    let coarse = level
        .places
        .iter()
        .filter(|place| place.by != "position" && place.by != "time");
    let frame = Frame {
        title: "",
        x_label: "station, target, axis, side of approach (+1, \u{2212}1), repeat (#)",
        y_label: "misfit (rms) in µm",
        size: [900.0, 260.0],
    };
    let named = coarse
        .take(MOST_PLACES)
        .map(|place| match place.by.as_str() {
            "repeat" => (place, format!("#{}", place.name)),
            _ => (place, place.name.replace('-', "\u{2212}")),
        });
    misfits(name, &frame, 105, level, &named.collect::<Vec<_>>())
}

/// The misfit where a cause acts: along its axis, else at its stations or targets, else in time.
fn where_it_acts(rank: usize, cause: &Cause, diagnosis: &Diagnosis) -> Option<Figure> {
    let level = diagnosis
        .levels
        .iter()
        .find(|level| level.level == cause.level)?;
    let subject = |field: &str| cause.subject.get(field).and_then(Value::as_str);
    let (x_label, by, axis) = match (subject("axis"), subject("station"), subject("target")) {
        (Some(axis), _, _) => (
            format!("quarter of the travel of {axis}"),
            "position",
            Some(axis),
        ),
        (_, Some(_), _) => ("station".to_owned(), "station", None),
        (_, _, Some(_)) => ("target".to_owned(), "target", None),
        _ => ("quarter of the readings in time".to_owned(), "time", None),
    };
    let of_subject = |place: &&MisfitAt| {
        let prefix = axis.map(|axis| format!("{axis}, "));
        place.by == by && prefix.is_none_or(|prefix| place.name.starts_with(&prefix))
    };
    let places = level
        .places
        .iter()
        .filter(of_subject)
        .take(MOST_PLACES)
        .enumerate();
    let named = places.map(|(k, place)| match by {
        "station" | "target" => (place, place.name.clone()),
        _ => (place, (k + 1).to_string()),
    });
    let frame = Frame {
        title: "",
        x_label: &x_label,
        y_label: "misfit (rms) in µm",
        size: [340.0, 190.0],
    };
    misfits(
        &format!("cause-{rank}"),
        &frame,
        40,
        level,
        &named.collect::<Vec<_>>(),
    )
}

/// Misfits at places, with their names under the axis, which has room for so many letters.
fn misfits(
    name: &str,
    frame: &Frame<'_>,
    letters: usize,
    level: &Level,
    places: &[(&MisfitAt, String)],
) -> Option<Figure> {
    if places.is_empty() {
        return None;
    }
    let values = places
        .iter()
        .flat_map(|(place, _)| [place.before_um, place.after_um]);
    let [low, high] = range(values.chain(level.noise_floor_um));
    let end = places.len() as f64 - 0.4;
    let mut x = Scale::new(-0.6, end, 5);
    let letters = letters / places.len();
    let ticks = places
        .iter()
        .enumerate()
        .map(|(k, (_, name))| (k as f64, tick(name, letters)));
    x.ticks = ticks.collect();
    let mut plot = Plot::new(frame, x, Scale::new(low.max(0.0), high, 5));
    if let Some(noise) = level.noise_floor_um {
        plot.line("rule", &[[-0.6, noise], [end, noise]]);
    }
    for (k, (place, _)) in places.iter().enumerate() {
        let k = k as f64;
        let text = format!(
            "{} {}: {} µm without, {} µm with the causes",
            place.by,
            place.name,
            rough(place.before_um),
            rough(place.after_um)
        );
        for (class, point) in [
            ("m1", [k - 0.12, place.before_um]),
            ("m0", [k + 0.12, place.after_um]),
        ] {
            plot.dots(class, std::iter::once(point));
            plot.hover(point, &text);
        }
    }
    Some(Figure::new(name, plot.finish()))
}

/// A name of so many letters at most.
fn tick(name: &str, most: usize) -> String {
    let most = most.clamp(1, 12);
    match name.chars().count() > most {
        true if most == 1 => String::new(),
        true => name.chars().take(most - 1).chain(['…']).collect(),
        false => name.to_owned(),
    }
}

fn cause(rank: usize, cause: &Cause, diagnosis: &Diagnosis) -> CauseView {
    let rivals = cause.cannot_tell_apart_from.iter().map(|rival| {
        let name = words::effect(&rival.effect, &rival.subject);
        match rival.delta_bic {
            Some(bic) => format!("{name} (BIC {})", signed(bic, 0)),
            None => name,
        }
    });
    CauseView {
        name: words::effect(&cause.effect, &cause.subject),
        value: parameters(cause),
        rivals: rivals.collect(),
        changes: changes(cause),
        explained: cause.explained_rms_um.map(rough),
        figure: where_it_acts(rank, cause, diagnosis),
    }
}

fn parameters(cause: &Cause) -> String {
    let parts = cause.parameters.iter().map(|parameter| {
        let name = parameter.name.replace('_', " ");
        let unit = match words::unit(&parameter.unit) {
            glued @ ("″" | "°" | "") => glued.to_owned(),
            apart => format!(" {apart}"),
        };
        // Instants and durations have no side.
        let with_sign = match parameter.name.as_str() {
            "time" | "time_constant" | "period" | "waves" => fixed,
            _ => signed,
        };
        match parameter.u.filter(|u| *u > 0.0) {
            Some(u) => {
                let digits = decimals(2.0 * u).min(3);
                format!(
                    "{name} {} ± {}{unit}",
                    with_sign(parameter.value, digits),
                    fixed(2.0 * u, digits)
                )
            }
            None if parameter.u.is_none() => format!(
                "{name} {}{unit} (seen in part only)",
                rough(parameter.value)
            ),
            None => format!("{name} {}{unit}", rough(parameter.value)),
        }
    });
    parts
        .map(|part| part.trim().to_owned())
        .collect::<Vec<_>>()
        .join("; ")
}

/// The results that change most when all causes are taken out.
fn changes(cause: &Cause) -> String {
    let mut all: Vec<(&String, f64, &'static str)> = Vec::new();
    for (name, change) in &cause.component_change {
        let number = |field: &str| change.get(field).and_then(Value::as_f64);
        let found = number("max_um")
            .map(|um| (um, " µm"))
            .or_else(|| number("max_mm").map(|mm| (1e3 * mm, " µm")))
            .or_else(|| number("max_arcsec").map(|arcsec| (arcsec, "″")));
        all.extend(found.map(|(value, unit)| (name, value, unit)));
    }
    all.sort_by(|a, b| b.1.total_cmp(&a.1));
    let largest = all.iter().take(MOST_CHANGES);
    let largest = largest.map(|(name, value, unit)| format!("{name} {}{unit}", rough(*value)));
    largest.collect::<Vec<_>>().join(", ")
}

fn disturbance(k: usize, of: &Disturbance) -> DisturbanceView {
    let with = of.varies_with.join(" and ");
    let name = words::effect("disturbance", &of.subject);
    let name = match with.is_empty() {
        true => name,
        false => format!("{name}, with {with}"),
    };
    let figure = of
        .curve
        .as_deref()
        .and_then(|curve| smooth(k, curve, &with));
    DisturbanceView { name, figure }
}

/// x, y, z, and the dead path of a station.
const COORDINATES: usize = 4;

/// The curve of a disturbance of one argument, each coordinate with its 95 % band.
fn smooth(k: usize, curve: &[CurvePoint], with: &str) -> Option<Figure> {
    let coordinates = curve.first()?.value_um.len().min(COORDINATES);
    if coordinates == 0 || curve.iter().any(|point| point.at.len() != 1) {
        return None;
    }
    let part = |point: &CurvePoint, c: usize, sign: f64| {
        let value = point.value_um.get(c).copied().unwrap_or(f64::NAN);
        let u = point.u_um.get(c).copied().unwrap_or(0.0);
        [point.at[0], value + 2.0 * sign * u]
    };
    let all = || {
        (0..coordinates).flat_map(|c| {
            curve
                .iter()
                .flat_map(move |p| [part(p, c, -1.0)[1], part(p, c, 1.0)[1]])
        })
    };
    let [from, to] = range(curve.iter().map(|point| point.at[0]));
    let [low, high] = range(all());
    let unit = match with {
        "time" => "time in s".to_owned(),
        other => format!("{other} in mm or °"),
    };
    let frame = Frame {
        title: "",
        x_label: &unit,
        y_label: "disturbance in µm",
        size: [900.0, 250.0],
    };
    let mut plot = Plot::new(&frame, Scale::new(from, to, 8), Scale::new(low, high, 5));
    for c in 0..coordinates {
        let at = |sign: f64| -> Vec<[f64; 2]> {
            curve.iter().map(|point| part(point, c, sign)).collect()
        };
        let colour = if c == 3 { 3 } else { c.min(1) };
        plot.band(colour, &at(-1.0), &at(1.0));
        plot.line(&format!("l{c}"), &at(0.0));
    }
    Some(Figure::new(
        &format!("disturbance-{}", k + 1),
        plot.finish(),
    ))
}
