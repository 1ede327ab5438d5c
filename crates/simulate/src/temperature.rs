//! Temperatures that are logged with the lengths, and axes that expand with them.

use std::borrow::Cow;
use std::f64::consts::TAU;
use std::ops::Range;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use trueaxis_campaign::{AxisExpansion, LengthReading, LoggedColumn, LoggedQuantity};
use trueaxis_effects::{Medium, SceneTemperature, TemperatureHistory};
use trueaxis_files::{DocumentProblem, check_names, index_of};

use crate::noise::{Deviates, Part};
use crate::term::interpolate;
use crate::{Error, Scenario, check};

/// The temperature that expansion counts from, °C (ISO 1).
const REFERENCE_C: f64 = 20.0;

/// Logged temperatures are given in steps of 1 mK.
const TEMPERATURES_PER_K: f64 = 1e3;

/// A column of logged temperatures.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object: a logged temperature")]
pub struct TemperatureSpec {
    /// Column of `lengths.csv`, such as `machine_temp_spindle_c`.
    pub column: String,
    /// The true temperature: the sum of the terms, °C.
    pub course: Vec<TemperatureTerm>,
    /// Standard deviation of a logged value, K.
    #[serde(default)]
    pub sigma_k: f64,
}

/// One term of the course of a temperature, °C; times are those of `lengths.csv`, s.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "lowercase", deny_unknown_fields)]
pub enum TemperatureTerm {
    /// Straight lines between the entries; before the first and after the last their values.
    Table {
        /// Times, increasing, s.
        times_s: Vec<f64>,
        /// Value at each time, °C.
        values_c: Vec<f64>,
    },
    /// `change (1 - exp(-(t - start) / T))` after the start, 0 before it.
    Exponential {
        /// What is reached in the end, K.
        change_k: f64,
        /// T, s.
        time_constant_s: f64,
        /// Start, s.
        #[serde(default)]
        start_s: f64,
    },
    /// `amplitude · sin(2π t / period + phase)`.
    Sine {
        /// Amplitude, K.
        amplitude_k: f64,
        /// Period, s.
        period_s: f64,
        /// Phase at t = 0, degrees.
        #[serde(default)]
        phase_deg: f64,
    },
}

impl TemperatureTerm {
    fn check(&self, field: &str) -> Result<(), Error> {
        let inner = |name: &str| format!("{field}.{name}");
        match self {
            Self::Table { times_s, values_c } => {
                check::table(field, "times", ("times_s", times_s), ("values_c", values_c))
            }
            Self::Exponential {
                change_k,
                time_constant_s,
                start_s,
            } => {
                check::finite(field, &[*change_k, *start_s])?;
                check::positive(&inner("time_constant_s"), *time_constant_s)
            }
            Self::Sine {
                amplitude_k,
                period_s,
                phase_deg,
            } => {
                check::finite(field, &[*amplitude_k, *phase_deg])?;
                check::positive(&inner("period_s"), *period_s)
            }
        }
    }

    fn value(&self, time_s: f64) -> f64 {
        match self {
            Self::Table { times_s, values_c } => interpolate(times_s, values_c, time_s),
            Self::Exponential {
                change_k,
                time_constant_s,
                start_s,
            } => change_k * -(-(time_s - start_s).max(0.0) / time_constant_s).exp_m1(),
            Self::Sine {
                amplitude_k,
                period_s,
                phase_deg,
            } => amplitude_k * (TAU * time_s / period_s + phase_deg.to_radians()).sin(),
        }
    }
}

impl TemperatureSpec {
    /// The true temperature, °C.
    fn at(&self, time_s: f64) -> f64 {
        self.course.iter().map(|term| term.value(time_s)).sum()
    }

    /// What is logged at these readings.
    fn logged(&self, readings: &[LengthReading], mut deviates: Deviates) -> LoggedColumn {
        let values = readings.iter().map(|reading| {
            let value_c = self.at(reading.time_s) + deviates.normal() * self.sigma_k;
            Some((value_c * TEMPERATURES_PER_K).round() / TEMPERATURES_PER_K)
        });
        LoggedColumn {
            name: self.column.clone(),
            values: values.collect(),
        }
    }
}

/// Refuses columns that hold no temperature, or occur twice.
pub(crate) fn check_temperatures(scenario: &Scenario) -> Result<(), Error> {
    let columns: Vec<&str> = columns(scenario);
    check_names("temperatures", "column", &columns).map_err(|mut error| {
        // Columns are not names, but must differ just as names do.
        if let Some(path) = error.place.field_path() {
            error.place = trueaxis_files::Place::in_field(path.replace(".name", ".column"));
        }
        error
    })?;
    for (i, spec) in scenario.temperatures.iter().enumerate() {
        let field = format!("temperatures[{i}]");
        if !LoggedQuantity::is_temperature(&spec.column) {
            let found = format!("a column `{}`", spec.column);
            let expected = "machine_temp_c, machine_temp_<name>_c or air_temp_c";
            let problem = DocumentProblem::value(found, expected);
            return Err(problem.in_field(format!("{field}.column")).into());
        }
        check::not_negative(&format!("{field}.sigma_k"), spec.sigma_k)?;
        for (j, term) in spec.course.iter().enumerate() {
            term.check(&format!("{field}.course[{j}]"))?;
        }
    }
    Ok(())
}

/// The temperatures that effects may go with: those of the machine, and that of air which the instrument does not
/// compensate.
fn of_effects(scenario: &Scenario) -> impl Iterator<Item = (&TemperatureSpec, Medium)> {
    let compensated = scenario.instrument.air_compensated;
    let specs = scenario.temperatures.iter();
    specs.filter_map(move |spec| match LoggedQuantity::of_column(&spec.column)? {
        LoggedQuantity::MachineTemperature => Some((spec, Medium::Machine)),
        LoggedQuantity::AirTemperature if !compensated => Some((spec, Medium::Air)),
        _ => None,
    })
}

/// The temperatures that effects may go with.
pub(crate) fn scene_temperatures(scenario: &Scenario) -> Vec<SceneTemperature> {
    let temperatures = of_effects(scenario).map(|(spec, medium)| SceneTemperature {
        column: spec.column.clone(),
        medium,
    });
    temperatures.collect()
}

/// Nodes of the true course of a temperature over the campaign.
const NODES: u32 = 4096;

/// The true courses of these temperatures from the first to the last reading.
pub(crate) fn true_histories(scenario: &Scenario, span_s: &Range<f64>) -> Vec<TemperatureHistory> {
    let spacing_s = (span_s.end - span_s.start) / f64::from(NODES);
    let of = |spec: &TemperatureSpec| {
        let nodes = (0..=NODES).map(|k| spec.at(span_s.start + spacing_s * f64::from(k)));
        TemperatureHistory::new(span_s.start, spacing_s, nodes.collect())
    };
    let specs = of_effects(scenario).filter(|_| spacing_s > 0.0);
    specs.map(|(spec, _)| of(spec)).collect()
}

fn columns(scenario: &Scenario) -> Vec<&str> {
    let columns = scenario.temperatures.iter().map(|t| t.column.as_str());
    columns.collect()
}

/// The columns of temperatures for these readings.
pub(crate) fn logged(
    scenario: &Scenario,
    readings: &[LengthReading],
    seed: u64,
) -> Vec<LoggedColumn> {
    let specs = scenario.temperatures.iter().enumerate();
    specs
        .map(|(i, spec)| spec.logged(readings, Deviates::of_part(seed, Part::Thermometer(i))))
        .collect()
}

/// The axes that expand, as the machine of the scenario declares them.
pub(crate) struct Expansions<'a>(Vec<Expanding<'a>>);

struct Expanding<'a> {
    axis: usize,
    per_k: f64,
    course: &'a TemperatureSpec,
    /// The axis' temperature less that of its column, K.
    off_k: f64,
}

/// Refuses an expansion whose temperature the scenario does not have.
pub(crate) fn check_expansions(
    scenario: &Scenario,
    expansions: &[AxisExpansion],
) -> Result<(), Error> {
    for expansion in expansions {
        let field = format!("machine.axes[{}].temperature_column", expansion.axis);
        let column = &expansion.temperature_column;
        index_of(field, "column of temperatures", column, &columns(scenario))?;
    }
    Ok(())
}

impl<'a> Expansions<'a> {
    /// The temperature of each axis has an error of the declared uncertainty, drawn once.
    pub(crate) fn draw(scenario: &'a Scenario, declared: &[AxisExpansion], seed: u64) -> Self {
        let mut deviates = Deviates::of_part(seed, Part::AxisTemperatures);
        let axes = declared.iter().filter_map(|expansion| {
            let off_k = deviates.normal() * expansion.temperature_sigma_k.unwrap_or(0.0);
            let is_its = |spec: &&TemperatureSpec| spec.column == expansion.temperature_column;
            Some(Expanding {
                axis: expansion.axis,
                per_k: expansion.ppm_per_k * 1e-6,
                course: scenario.temperatures.iter().find(is_its)?,
                off_k,
            })
        });
        Self(axes.collect())
    }

    /// Where axes stand that are commanded to `positions`: at `q (1 + α (T - 20 °C))`.
    pub(crate) fn reached<'p>(&self, positions: &'p [f64], time_s: f64) -> Cow<'p, [f64]> {
        let mut positions = Cow::Borrowed(positions);
        for expanding in &self.0 {
            let above_k = expanding.course.at(time_s) + expanding.off_k - REFERENCE_C;
            positions.to_mut()[expanding.axis] *= 1.0 + expanding.per_k * above_k;
        }
        positions
    }
}
