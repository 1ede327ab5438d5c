//! The diagnosis: how the misfit splits, and each cause with where it acts.

use serde::Serialize;
use trueaxis_files::{decimals, told_behind, told_places, told_span, told_unit};

use crate::diagnosis::{Cause, Diagnosis, Fitted, Level, MisfitAt, Parameter};
use crate::disturbances::DisturbanceView;
use crate::fitted_figure::fitted_figures;
use crate::numbers::{COVERAGE, fixed, rough, signed, with_u};
use crate::page::Figure;
use crate::svg::Drawing;
use crate::svg::plot::{COLOURS, Plot};
use crate::svg::ticks::{Ruler, range};
use crate::words;

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
    /// Whether causes or disturbances take anything of the misfit away.
    is_explained: bool,
}

#[derive(Serialize)]
struct CauseView {
    /// Place among the causes of the file.
    index: usize,
    effect: String,
    /// Whether it is the form of an error curve, which contradicts nothing.
    is_of_curve: bool,
    name: String,
    value: String,
    rivals: Vec<String>,
    changes: String,
    explained: Option<String>,
    /// One for each coordinate in which it shows.
    figures: Vec<Figure>,
    /// Whether its figures have both sides of approach.
    has_sides: bool,
    /// Whether a length is drawn less what the others of its visit predict of it.
    given_others: bool,
}

const BAR: [f64; 2] = [900.0, 34.0];

/// Results that are listed as changed.
const MOST_CHANGES: usize = 4;

/// Places that fit in a figure, and the letters under its axis.
const MOST_PLACES: usize = 40;
const MOST_LETTERS: usize = 105;

impl DiagnosisSection {
    pub(crate) fn new(diagnosis: &Diagnosis) -> Self {
        let levels = diagnosis.levels.iter().enumerate();
        let disturbances = diagnosis.disturbances.iter().enumerate();
        let causes = diagnosis.causes.iter().enumerate();
        Self {
            levels: levels
                .map(|(k, level)| level_view(k, level, diagnosis))
                .collect(),
            causes: causes.map(|(k, of)| cause(k, of)).collect(),
            disturbances: disturbances
                .map(|(k, of)| DisturbanceView::new(k, of))
                .collect(),
        }
    }

    pub(crate) fn figures(&self) -> impl Iterator<Item = &Figure> {
        let levels = self
            .levels
            .iter()
            .flat_map(|level| level.bar.iter().chain(&level.places));
        let levels = levels.chain(self.causes.iter().flat_map(|cause| &cause.figures));
        levels.chain(self.disturbances.iter().flat_map(|one| &one.figures))
    }
}

fn level_view(k: usize, level: &Level, diagnosis: &Diagnosis) -> LevelView {
    let causes = diagnosis.causes.iter().filter(|cause| cause.is_in(level));
    let names = causes.map(|cause| words::effect(&cause.effect, &cause.subject));
    let names: Vec<String> = names.collect();
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
        is_explained: level.is_explained(),
    }
}

/// Name, share and class of each part of the misfit; they add up to 1.
fn parts(level: &Level, names: &[String]) -> Vec<(String, f64, String)> {
    let shares = &level.shares;
    let named = names.iter().cloned();
    let named = named.chain((0..).map(|k| format!("cause {}", k + 1)));
    let of_causes = shares.causes.iter().zip(named).enumerate();
    let of_causes = of_causes.map(|(k, (share, name))| (name, *share, format!("f{}", k % COLOURS)));
    let smooth: f64 = shares.disturbances.iter().sum();
    let others = [
        ("disturbances", smooth, "fd"),
        ("unexplained", shares.unexplained, "fu"),
        ("noise", shares.noise, "fn"),
    ];
    let others = others
        .into_iter()
        .filter(|(_, share, class)| *class != "fd" || *share > 0.0);
    let others = others.map(|(name, share, class)| (name.to_owned(), share, class.to_owned()));
    of_causes.chain(others).collect()
}

fn bar(name: &str, parts: &[(String, f64, String)]) -> Option<Figure> {
    let whole: f64 = parts.iter().map(|(_, share, _)| share.max(0.0)).sum();
    if !(whole > 0.0 && whole.is_finite()) {
        return None;
    }
    let told = parts
        .iter()
        .map(|(name, share, _)| format!("{name} {} %", fixed(100.0 * share, 0)));
    let told: Vec<String> = told.collect();
    let mut drawing = Drawing::new(BAR[0], BAR[1], told.join(", "));
    let mut x = 0.0;
    for (_, share, class) in parts {
        let width = BAR[0] * share.max(0.0) / whole;
        drawing.element(format_args!(
            r#"rect class="{class}" x="{x:.1}" y="3" width="{:.1}" height="28""#,
            (width - 1.0).max(0.0)
        ));
        x += width;
    }
    for ((.., class), told) in parts.iter().zip(&told) {
        drawing.add_key(class, told);
    }
    Some(Figure::new(name, drawing))
}

/// The misfit by station, target, axis and so on, without and with the causes.
fn places(name: &str, level: &Level) -> Option<Figure> {
    let coarse = level
        .places
        .iter()
        .filter(|place| place.by != "position" && place.by != "time");
    let kinds = [
        ("station", "station"),
        ("target", "target"),
        ("axis", "axis"),
        ("direction", "side of approach (+1, \u{2212}1)"),
        ("repeat", "repeat (#)"),
        ("cycle", "cycle (#)"),
    ];
    let is_there = |by: &str| level.places.iter().any(|place| place.by == by);
    let kinds = kinds.iter().filter(|(by, _)| is_there(by));
    let kinds: Vec<&str> = kinds.map(|(_, words)| *words).collect();
    let named = coarse
        .take(MOST_PLACES)
        .map(|place| match place.by.as_str() {
            "repeat" | "cycle" => (place, format!("#{}", place.name)),
            _ => (place, place.name.replace('-', "\u{2212}")),
        });
    misfits(name, &kinds.join(", "), level, &named.collect::<Vec<_>>())
}

/// Misfits at places, with their names under the axis.
fn misfits(
    name: &str,
    kinds: &str,
    level: &Level,
    places: &[(&MisfitAt, String)],
) -> Option<Figure> {
    if places.is_empty() {
        return None;
    }
    let values = places
        .iter()
        .flat_map(|(place, _)| [place.before_um, place.after_um]);
    let [low, high] = range(values.chain(level.noise_floor_um).chain([0.0]));
    let end = places.len() as f64 - 0.4;
    let mut x = Ruler::new(-0.6, end, 5);
    let letters = MOST_LETTERS / places.len();
    let ticks = places
        .iter()
        .enumerate()
        .map(|(k, (_, name))| (k as f64, tick(name, letters)));
    x.ticks = ticks.collect();
    let y = ("misfit (rms) in µm", Ruler::new(low.max(0.0), high, 5));
    let mut plot = Plot::new([900.0, 260.0], "", (kinds, x), y);
    if let Some(noise) = level.noise_floor_um {
        plot.line("rule", [[-0.6, noise], [end, noise]]);
    }
    for (k, (place, _)) in places.iter().enumerate() {
        let k = k as f64;
        let (before, after) = (rough(place.before_um), rough(place.after_um));
        let mut place_it = |point: [f64; 2], what: &str, class: &str| {
            plot.marks(class, [point]);
            plot.hover(point, &format!("{} {}: {what}", place.by, place.name));
        };
        if level.is_explained() {
            let what = format!("{before} µm without, {after} µm with the causes");
            place_it([k - 0.12, place.before_um], &what, "pk x");
            place_it([k + 0.12, place.after_um], &what, "mk");
        } else {
            place_it([k, place.before_um], &format!("{before} µm"), "mk");
        }
    }
    match level.is_explained() {
        true => {
            plot.add_key("pk x", "without");
            plot.add_key("mk", "with causes and disturbances in the model");
        }
        false => plot.add_key("mk", "misfit"),
    }
    plot.add_key("rule", "noise alone");
    Some(Figure::new(name, plot.finish()))
}

/// A name, shortened to a number of letters.
fn tick(name: &str, most: usize) -> String {
    match most {
        0 | 1 if name.chars().count() > 1 => String::new(),
        most => words::shortened(name, most.clamp(1, 12)),
    }
}

fn cause(index: usize, cause: &Cause) -> CauseView {
    let rivals = cause.cannot_tell_apart_from.iter();
    let rivals = rivals.map(|rival| rival.name(cause));
    CauseView {
        index,
        effect: cause.effect.clone(),
        is_of_curve: cause.is_of_curve(),
        name: words::effect(&cause.effect, &cause.subject),
        value: [parameters(cause), along_it(cause)].concat(),
        rivals: rivals.collect(),
        changes: changes(cause).1,
        explained: cause.explained_rms_um.map(rough),
        figures: cause
            .fitted
            .as_ref()
            .map(|of| fitted_figures(index + 1, cause.is_of_curve(), of))
            .unwrap_or_default(),
        has_sides: cause.fitted.as_ref().is_some_and(Fitted::has_sides),
        given_others: cause.fitted.as_ref().is_some_and(Fitted::given_others),
    }
}

/// The least and the largest of a free form over the position, µm or arcsec; nothing without one.
fn along_it(cause: &Cause) -> String {
    let points = cause.curve.iter().flatten();
    let [unit, of_position] = match points.clone().any(|point| point.of.is_angular()) {
        true => ["″", "°"],
        false => ["\u{a0}µm", "\u{a0}mm"],
    };
    let first = |of: [&[f64]; 3]| -> Option<[f64; 3]> {
        let [at, value, u] = of.map(|values| values.first().copied());
        Some([at?, value?, u?])
    };
    let all = points.filter_map(|point| first([&point.at, point.of.values(), point.of.u()]));
    let mut all: Vec<[f64; 3]> = all.collect();
    let places = told_places(all.iter().map(|point| point[0]));
    all.sort_by(|a, b| a[1].total_cmp(&b[1]));
    let told = |[at, value, u]: &[f64; 3]| {
        let u = COVERAGE * u;
        let told = with_u(*value, u, decimals(u).min(3));
        format!("{told}{unit} at {}{of_position}", fixed(*at, places))
    };
    match (all.first(), all.last()) {
        (Some(least), Some(most)) => format!("; from {} to {}", told(least), told(most)),
        _ => String::new(),
    }
}

fn parameters(cause: &Cause) -> String {
    // Amplitude and phase say the same as the two linear parameters, and better.
    let is_wave = cause.parameters.iter().any(|p| p.name == "amplitude");
    let is_shown =
        |p: &&Parameter| !is_wave || !(p.name.starts_with("sine") || p.name.starts_with("cosine"));
    let parts = cause.parameters.iter().filter(is_shown).map(|parameter| {
        // The mean of a lost motion where it was measured, not in the middle of the travel.
        let parameter = match &cause.mean_lost_motion {
            Some(mean) if parameter.name == "lost_motion_mean" => mean,
            _ => parameter,
        };
        if parameter.name == "waves" {
            let u = parameter.u.filter(|u| *u > 0.0);
            let u = u.map_or(String::new(), |u| format!(" ± {:.0}", COVERAGE * u));
            return format!("{:.0}{u} waves per turn", parameter.value);
        }
        let name = parameter.name.replace('_', " ");
        let (unit, size) = told_unit(parameter.value, &parameter.unit);
        let (value, u) = (parameter.value / size, parameter.u.map(|u| u / size));
        let unit = told_behind(unit, '\u{a0}');
        // Instants and durations have no side.
        let with_sign = match parameter.name.as_str() {
            "time" | "time_constant" | "period" => fixed,
            _ => signed,
        };
        match u.filter(|u| *u > 0.0) {
            Some(u) => {
                let digits = decimals(COVERAGE * u);
                format!(
                    "{name} {} ± {}{unit}{}",
                    with_sign(value, digits),
                    fixed(COVERAGE * u, digits),
                    told_span(&parameter.name)
                )
            }
            // The shortest that the steps show.
            None if u.is_none() && parameter.name == "period" => {
                format!("{name} at most {}{unit}", fixed(value, 1))
            }
            None if u.is_none() && value == 0.0 => format!("{name} –"),
            None if u.is_none() => format!("{name} {}{unit} (seen in part only)", rough(value)),
            None => format!("{name} {}{unit}", rough(value)),
        }
    });
    parts
        .map(|part| part.trim().to_owned())
        .collect::<Vec<_>>()
        .join("; ")
}

/// Angles at an arm of half a metre, to compare them with displacements: µm per arcsec.
const ARM_UM_PER_ARCSEC: f64 = 2.4;

/// The results that change most when all causes are taken out, and the largest change, angles at the arm, µm.
pub(crate) fn changes(cause: &Cause) -> (Option<f64>, String) {
    let mut all: Vec<(f64, String)> = Vec::new();
    for (name, change) in &cause.component_change {
        let units = [
            ("max_um", "\u{a0}µm", 1.0, 1.0),
            ("max_mm", "\u{a0}µm", 1e3, 1.0),
            ("max_arcsec", "″", 1.0, ARM_UM_PER_ARCSEC),
        ];
        all.extend(units.iter().filter_map(|(field, unit, factor, weight)| {
            let value = factor * change.get(field)?.as_f64()?;
            Some((weight * value, format!("{name} {}{unit}", rough(value))))
        }));
    }
    all.sort_by(|a, b| b.0.total_cmp(&a.0));
    let most_um = all.first().map(|(um, _)| *um);
    let largest = all.into_iter().take(MOST_CHANGES).map(|(_, text)| text);
    (most_um, largest.collect::<Vec<_>>().join(", "))
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn a_period_without_u_is_the_shortest() {
        let told = |name: &str| {
            let parameter = json!({ "name": name, "value": 40.0, "unit": "mm" });
            let cause = json!({ "effect": "cyclic_error", "parameters": [parameter] });
            parameters(&serde_json::from_value(cause).unwrap())
        };
        assert_eq!(told("period"), "period at most 40.0\u{a0}mm");
        assert_eq!(
            told("amplitude"),
            "amplitude 40.0\u{a0}mm (seen in part only)"
        );
    }
}
