//! Mistakes of unit that could explain data which cannot be true.

use std::collections::BTreeSet;
use std::f64::consts::PI;
use std::fmt;

use trueaxis_kinematics::{Axis, AxisKind};

use crate::Campaign;

/// A column in another unit than the format's.
#[derive(Debug, Clone, PartialEq)]
pub struct UnitMistake {
    /// The column or columns, such as `X` or `length_mm of station S2`.
    pub columns: String,
    /// The unit that the values seem to have.
    pub looks_like: &'static str,
    /// The symbol of that unit, as in the map of an import; empty if no import makes the values.
    pub symbol: &'static str,
    /// The unit of the format.
    pub expected: &'static str,
    /// What to multiply the values by.
    pub factor: f64,
}

impl UnitMistake {
    /// How to correct data with which something is wrong.
    pub(crate) fn advice(mistake: Option<&Self>) -> String {
        mistake.map_or_else(
            || {
                "no usual mistake of unit explains it: check the names in the rows, and \
                 position_mm and carried_by of the targets"
                    .to_owned()
            },
            Self::to_string,
        )
    }
}

impl fmt::Display for UnitMistake {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            columns,
            looks_like,
            symbol,
            expected,
            factor,
        } = self;
        write!(
            f,
            "the values of {columns} look like {looks_like}, expected {expected}: multiply them by {factor}"
        )?;
        match symbol.is_empty() {
            true => Ok(()),
            false => write!(
                f,
                ", or say `unit = \"{symbol}\"` in the map of `trueaxis import`"
            ),
        }
    }
}

/// A way to read the columns.
pub(crate) struct Hypothesis {
    /// For each axis, what its positions are multiplied by.
    pub(crate) axis_factors: Vec<f64>,
    /// What the positions of targets are multiplied by.
    pub(crate) target_factor: f64,
    /// What lengths or coordinates are multiplied by ...
    measured_factor: f64,
    /// ... for one station only, or for all.
    station: Option<usize>,
    pub(crate) mistake: Option<Box<UnitMistake>>,
}

impl Hypothesis {
    /// The file is right.
    pub(crate) fn as_given(campaign: &Campaign) -> Self {
        Self {
            axis_factors: vec![1.0; campaign.machine.axes().len()],
            target_factor: 1.0,
            measured_factor: 1.0,
            station: None,
            mistake: None,
        }
    }

    /// What to multiply the lengths of `station` by.
    pub(crate) fn measured_factor(&self, station: usize) -> f64 {
        if self.is_about(station) {
            self.measured_factor
        } else {
            1.0
        }
    }

    /// Whether it says anything on the lengths of `station`.
    pub(crate) fn is_about(&self, station: usize) -> bool {
        self.station.is_none_or(|only| only == station)
    }
}

/// A unit in which values may have been given: its name, its symbol, and what to multiply them by.
type Unit = (&'static str, &'static str, f64);

/// Largest factor first: of two factors that both explain lengths which change too little, the
/// larger one makes them change like the targets.
const LENGTH_UNITS: [Unit; 3] = [
    ("metres", "m", 1000.0),
    ("inches", "in", 25.4),
    ("micrometres", "um", 1e-3),
];

const ANGLE_UNITS: [Unit; 1] = [("radians", "rad", 180.0 / PI)];

/// The mistake that `columns` are in a unit instead of the `expected` one.
fn mistake(columns: String, unit: Unit, expected: &'static str) -> Option<Box<UnitMistake>> {
    let (looks_like, symbol, factor) = unit;
    Some(Box::new(UnitMistake {
        columns,
        looks_like,
        symbol,
        expected,
        factor,
    }))
}

/// No tracker reaches farther than this, mm: an axis that moves more is given in another unit.
const LONGEST_AXIS_MM: f64 = 1e5;

/// Share of the travel by which converted positions may exceed it, because they were rounded in the other unit.
const CONVERTED_TRAVEL_SLACK: f64 = 0.01;

/// What could be wrong with lengths that fail in some runs or from some stations.
pub(crate) fn for_lengths(
    campaign: &Campaign,
    runs: &[usize],
    stations: &[usize],
) -> Vec<Hypothesis> {
    let all = measured(campaign, None, "length_mm".to_owned());
    let mut hypotheses = of_columns(campaign, runs);
    hypotheses.extend(all);
    for &index in stations {
        let columns = format!("length_mm of station {}", campaign.stations[index].name);
        hypotheses.extend(measured(campaign, Some(index), columns));
    }
    hypotheses
}

/// What could be wrong with lengths that are too small.
pub(crate) fn for_small_lengths(campaign: &Campaign) -> Vec<Hypothesis> {
    let all = measured(campaign, None, "length_mm".to_owned());
    all.filter(|hypothesis| hypothesis.measured_factor > 1.0)
        .collect()
}

/// What could be wrong with points that fail in some runs.
pub(crate) fn for_points(campaign: &Campaign, runs: &[usize]) -> Vec<Hypothesis> {
    let mut hypotheses = of_columns(campaign, runs);
    hypotheses.extend(measured(campaign, None, "x_mm, y_mm, z_mm".to_owned()));
    hypotheses.extend(LENGTH_UNITS.map(|(looks_like, _, factor)| Hypothesis {
        target_factor: factor,
        mistake: mistake(
            "position_mm of the targets in campaign.json".to_owned(),
            (looks_like, "", factor),
            "mm",
        ),
        ..Hypothesis::as_given(campaign)
    }));
    hypotheses
}

fn measured(
    campaign: &Campaign,
    station: Option<usize>,
    columns: String,
) -> impl Iterator<Item = Hypothesis> {
    LENGTH_UNITS.into_iter().map(move |unit| {
        let (.., measured_factor) = unit;
        Hypothesis {
            measured_factor,
            station,
            mistake: mistake(columns.clone(), unit, "mm"),
            ..Hypothesis::as_given(campaign)
        }
    })
}

/// The column of each axis under test in `runs` alone, then all columns of a kind together.
fn of_columns(campaign: &Campaign, runs: &[usize]) -> Vec<Hypothesis> {
    let axes = campaign.machine.axes();
    let known = runs.iter().filter_map(|&run| campaign.runs.get(run));
    let tested: BTreeSet<usize> = known.map(|run| run.axis).collect();
    let of_kind = |kind| -> Vec<usize> {
        let axes = axes.iter().enumerate();
        let axes = axes.filter(|(_, axis)| axis.kind() == kind);
        axes.map(|(i, _)| i).collect()
    };
    let singles = tested.into_iter().map(|axis| vec![axis]);
    let groups = [of_kind(AxisKind::Linear), of_kind(AxisKind::Rotary)];
    let groups = groups.into_iter().filter(|group| group.len() > 1);
    singles
        .chain(groups)
        .flat_map(|columns| of_these_columns(campaign, &columns))
        .collect()
}

fn of_these_columns(campaign: &Campaign, columns: &[usize]) -> Vec<Hypothesis> {
    let axes = campaign.machine.axes();
    let chosen = || columns.iter().map(|&i| (i, &axes[i]));
    let kind = axes[columns[0]].kind();
    let units: &[Unit] = match kind {
        AxisKind::Linear => &LENGTH_UNITS,
        AxisKind::Rotary => &ANGLE_UNITS,
    };
    let names: Vec<&str> = chosen().map(|(_, axis)| axis.name()).collect();
    let possible = units.iter().filter(|(.., factor)| {
        chosen().all(|(index, axis)| stays_possible(campaign, index, axis, *factor))
    });
    possible
        .map(|&unit| {
            let (.., factor) = unit;
            let mut hypothesis = Hypothesis::as_given(campaign);
            for &index in columns {
                hypothesis.axis_factors[index] = factor;
            }
            hypothesis.mistake = mistake(names.join(", "), unit, kind.position_unit());
            hypothesis
        })
        .collect()
}

/// Whether positions times `factor` are those of a machine: within the travel if they grow, and
/// beyond all machines as given if they shrink.
fn stays_possible(campaign: &Campaign, index: usize, axis: &Axis, factor: f64) -> bool {
    let positions = campaign.steps.iter().map(|step| step.positions[index]);
    let (lowest, highest) = positions.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), q| {
        (l.min(q), h.max(q))
    });
    if factor < 1.0 {
        return highest - lowest > LONGEST_AXIS_MM;
    }
    let [low, high] = axis.travel();
    let slack = CONVERTED_TRAVEL_SLACK * (high - low);
    lowest * factor >= low - slack && highest * factor <= high + slack
}
