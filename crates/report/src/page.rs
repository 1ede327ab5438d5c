//! What the template gets.

use serde::Serialize;
use serde_json::{Map, Value};

use crate::causes::DiagnosisSection;
use crate::comparison::ComparisonSection;
use crate::components::{self, AxisSection};
use crate::evidence::Evidence;
use crate::input::Input;
use crate::locations::{Location, locations};
use crate::scene::Scene;
use crate::svg::Drawing;
use crate::verdict::Verdict;
use crate::verification::VerificationSection;

/// A figure: for the page, and for a file of its own.
#[derive(Serialize)]
pub(crate) struct Figure {
    /// File name without its ending.
    pub(crate) name: String,
    pub(crate) svg: String,
    #[serde(skip)]
    pub(crate) alone: String,
}

impl Figure {
    /// `name` may hold names from files: what no file name should have is left out.
    pub(crate) fn new(name: &str, drawing: Drawing) -> Self {
        let plain = |c: char| {
            if c.is_alphanumeric() || c == '-' {
                c
            } else {
                '_'
            }
        };
        Self {
            name: name.chars().map(plain).take(80).collect(),
            svg: drawing.inline(),
            alone: drawing.alone(),
        }
    }
}

/// All of it. `calibration`, `diagnosis` and `volume` are the files as they stand, or null.
#[derive(Serialize)]
pub(crate) struct Page<'a> {
    campaign: &'a str,
    machine: &'a str,
    verdict: Verdict,
    left_out: &'a [String],
    locations: Vec<Location>,
    largest: Vec<crate::largest::Largest>,
    scene: Option<Scene>,
    machine_figure: Option<Figure>,
    axes: Vec<AxisSection>,
    evidence: Option<Evidence>,
    causes: Option<DiagnosisSection>,
    verified: Option<VerificationSection>,
    compared: Option<ComparisonSection>,
    calibration: Option<&'a Value>,
    diagnosis: Option<&'a Value>,
    volume: Option<&'a Value>,
    montecarlo: Option<&'a Value>,
    /// Parts of the budgets that there are, by their field, with what they are called.
    budget_parts: Vec<[&'static str; 2]>,
    figure_style: &'static str,
}

/// Parts of the uncertainty budgets that any result has.
fn budget_parts(calibration: &Value) -> Vec<[&'static str; 2]> {
    let axes = calibration["axes"].as_array().into_iter().flatten();
    let results = axes.map(|axis| &axis["components"]);
    let results = results.chain([&calibration["location_errors"]]);
    let results = results.filter_map(Value::as_object).flat_map(Map::values);
    let budgets: Vec<&Value> = results.map(|result| &result["budget"]).collect();
    let all = [
        ["laser", "laser"],
        ["machine_return", "repeatability"],
        ["station_geometry", "stations"],
        ["systematic", "systematic"],
        ["effects", "effects"],
    ];
    let is_there = |[part, _]: &[&str; 2]| budgets.iter().any(|budget| budget[*part].is_number());
    all.into_iter().filter(is_there).collect()
}

impl<'a> Page<'a> {
    pub(crate) fn new(input: &'a Input) -> Self {
        let calibration = input.calibration.as_ref().map(|document| &document.parts);
        let diagnosis = input.diagnosis.as_ref().map(|document| &document.parts);
        let verification = input.verification.as_ref().map(|document| &document.parts);
        let comparison = input.comparison.as_ref().map(|document| &document.parts);
        let machine = calibration.map(|calibration| &calibration.machine);
        let residuals = input.residuals.as_ref();
        let raw = input.calibration.as_ref().map(|document| &document.raw);
        let scene = calibration.and_then(Scene::new);
        Self {
            campaign: match (calibration, diagnosis, verification) {
                (Some(calibration), _, _) => &calibration.campaign,
                (_, Some(diagnosis), _) => &diagnosis.campaign,
                (_, _, Some(verification)) => &verification.campaign,
                (None, None, None) => comparison.map_or("", |of| &of.second),
            },
            machine: match (machine, verification) {
                (Some(machine), _) => &machine.name,
                (None, Some(verification)) => &verification.machine,
                (None, None) => comparison.map_or("", |of| &of.machine),
            },
            verdict: Verdict::new(calibration, diagnosis, verification, comparison),
            left_out: &input.left_out,
            locations: calibration.map_or_else(Vec::new, locations),
            largest: calibration.map_or_else(Vec::new, crate::largest::largest),
            machine_figure: scene.as_ref().map(Scene::still),
            scene,
            axes: calibration.map_or_else(Vec::new, components::sections),
            evidence: residuals.and_then(|residuals| Evidence::new(residuals, machine)),
            causes: diagnosis.map(DiagnosisSection::new),
            verified: verification.map(VerificationSection::new),
            compared: comparison.map(ComparisonSection::new),
            calibration: raw,
            diagnosis: input.diagnosis.as_ref().map(|document| &document.raw),
            volume: input.volume.as_ref(),
            montecarlo: input.montecarlo.as_ref(),
            budget_parts: raw.map_or_else(Vec::new, budget_parts),
            figure_style: include_str!("figure.css"),
        }
    }

    pub(crate) fn figures(&self) -> Vec<&Figure> {
        let of_axes = self.axes.iter().flat_map(|axis| &axis.figures);
        let of_evidence = self.evidence.iter().flat_map(Evidence::figures);
        let of_causes = self.causes.iter().flat_map(DiagnosisSection::figures);
        let of_verified = self.verified.iter().flat_map(VerificationSection::figures);
        let of_compared = self.compared.iter().flat_map(|compared| &compared.figures);
        let machine = self.machine_figure.iter();
        machine
            .chain(of_axes)
            .chain(of_evidence)
            .chain(of_causes)
            .chain(of_verified)
            .chain(of_compared)
            .collect()
    }
}
