//! `calibration.json`, version 1.
//!
//! Positions are mm or degrees, linear errors µm, angular errors arcsec; `u` is a standard
//! uncertainty. Numbers are rounded far below anything measurable, so that the file reads well.

use serde::Serialize;
use serde::ser::{SerializeMap, Serializer};
use trueaxis_campaign::Direction;
use trueaxis_effects::GivenEffect;
use trueaxis_kinematics::{ARCSEC, AxisKind, Component, MICROMETRE};
use trueaxis_poses::{Method, SideDifference};

use crate::adjustment_file::AdjustmentFile;
use crate::budget::Budget;
use crate::calibration::{AxisResult, Calibration, MethodLoss, NodeResult, StationResult};

impl Calibration {
    /// The text of `calibration.json`, version 1.
    ///
    /// Optional fields beyond the fixed ones: `p_value` and `uncertainty_factor` of the
    /// adjustment, `direction` of each position where the sides of approach are kept apart,
    /// `noise_gain` of each axis where equations were solved, `u_ratio` where they
    /// were not (what they would lose), `dof` (degrees of freedom of u, the least of a curve; absent if
    /// infinite) and `budget` (shares of u², mean of a curve) of each error, `misfits`, `triangle`,
    /// `effects_taken_out` where there are any, `notices`.
    pub fn to_json(&self) -> String {
        // Serialising plain structs of numbers and strings has no way to fail.
        trueaxis_files::to_json(&File::new(self)).expect("numbers and strings serialise")
    }
}

#[derive(Serialize)]
struct File<'a> {
    format: &'static str,
    version: u32,
    campaign: &'a str,
    method: String,
    adjustment: AdjustmentFile<'a>,
    stations: Vec<StationFile<'a>>,
    targets: Vec<TargetFile<'a>>,
    axes: Vec<AxisFile<'a>>,
    location_errors: Ordered<QuantityFile>,
    misfits: Vec<MisfitFile<'a>>,
    triangle: Vec<TriangleFile<'a>>,
    #[serde(skip_serializing_if = "<[_]>::is_empty")]
    effects_taken_out: &'a [GivenEffect],
    notices: &'a [String],
}

#[derive(Serialize)]
struct StationFile<'a> {
    name: &'a str,
    position_mm: [f64; 3],
    u_mm: [f64; 3],
    dead_path_mm: f64,
    u_dead_path_mm: f64,
}

#[derive(Serialize)]
struct TargetFile<'a> {
    name: &'a str,
    position_mm: [f64; 3],
}

#[derive(Serialize)]
struct AxisFile<'a> {
    name: &'a str,
    kind: &'static str,
    unit: &'static str,
    positions: Vec<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    direction: Option<Vec<i8>>,
    reference_point_mm: [f64; 3],
    components: Ordered<CurveFile>,
    #[serde(skip_serializing_if = "Option::is_none")]
    noise_gain: Option<Ordered<GainFile>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    u_ratio: Option<Ordered<RatioFile>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    forward_minus_backward: Option<SidesFile>,
}

/// How the sides of approach differ in the mean, where they share a curve.
#[derive(Serialize)]
struct SidesFile {
    p_value: f64,
    components: Ordered<DifferenceFile>,
}

#[derive(Serialize)]
#[serde(untagged)]
enum DifferenceFile {
    Linear { value_um: f64, u_um: f64 },
    Angular { value_arcsec: f64, u_arcsec: f64 },
}

#[derive(Serialize)]
#[serde(untagged)]
enum CurveFile {
    Linear {
        value_um: Vec<f64>,
        u_um: Vec<f64>,
        #[serde(flatten)]
        behind: BehindFile,
    },
    Angular {
        value_arcsec: Vec<f64>,
        u_arcsec: Vec<f64>,
        #[serde(flatten)]
        behind: BehindFile,
    },
}

#[derive(Serialize)]
#[serde(untagged)]
enum QuantityFile {
    Linear {
        value_mm: f64,
        u_mm: f64,
        #[serde(flatten)]
        behind: BehindFile,
    },
    Angular {
        value_arcsec: f64,
        u_arcsec: f64,
        #[serde(flatten)]
        behind: BehindFile,
    },
}

/// What is behind uncertainties.
#[derive(Serialize)]
struct BehindFile {
    #[serde(skip_serializing_if = "Option::is_none")]
    dof: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    budget: Option<SharesFile>,
}

/// Shares of u².
#[derive(Serialize)]
struct SharesFile {
    laser: f64,
    machine_return: f64,
    station_geometry: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    effects: Option<f64>,
}

/// µm or arcsec for 1 µm of independent noise on every coordinate, by the method used and by the
/// nine equations.
#[derive(Serialize)]
struct GainFile {
    used: f64,
    nine: f64,
}

/// Standard uncertainties by points and nine or six equations, relative to those of the joint adjustment.
#[derive(Serialize)]
struct RatioFile {
    nine: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    six: Option<f64>,
}

#[derive(Serialize)]
struct MisfitFile<'a> {
    step: &'a str,
    rms_um: f64,
    chi_squared: f64,
    degrees_of_freedom: usize,
    p_value: f64,
}

#[derive(Serialize)]
struct TriangleFile<'a> {
    targets: &'a [String; 2],
    nominal_mm: f64,
    measured_mm: f64,
    difference_um: f64,
}

/// A JSON object in the order in which it was made.
struct Ordered<T>(Vec<(String, T)>);

impl<T: Serialize> Serialize for Ordered<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        for (name, value) in &self.0 {
            map.serialize_entry(name, value)?;
        }
        map.end()
    }
}

impl<'a> File<'a> {
    fn new(calibration: &'a Calibration) -> Self {
        Self {
            format: "trueaxis-calibration",
            version: 1,
            campaign: &calibration.campaign,
            method: match calibration.method {
                Method::Joint => "joint".to_owned(),
                Method::Nine => "nine-equation".to_owned(),
                Method::Six(rows) => format!("six-equation {rows}"),
            },
            adjustment: AdjustmentFile::new(&calibration.adjustment),
            stations: calibration.stations.iter().map(station).collect(),
            targets: calibration
                .targets
                .iter()
                .map(|t| TargetFile {
                    name: &t.name,
                    position_mm: t.position_mm.coords.map(mm).into(),
                })
                .collect(),
            axes: calibration.axes.iter().map(axis).collect(),
            location_errors: Ordered(calibration.axes.iter().flat_map(location_errors).collect()),
            misfits: calibration
                .misfits
                .iter()
                .map(|misfit| MisfitFile {
                    step: &misfit.step,
                    rms_um: round(misfit.rms_um, 3),
                    chi_squared: round(misfit.chi_squared, 3),
                    degrees_of_freedom: misfit.degrees_of_freedom,
                    p_value: significant(misfit.p_value),
                })
                .collect(),
            triangle: calibration
                .triangle
                .iter()
                .map(|side| TriangleFile {
                    targets: &side.targets,
                    nominal_mm: mm(side.nominal_mm),
                    measured_mm: mm(side.measured_mm),
                    difference_um: round((side.measured_mm - side.nominal_mm) / MICROMETRE, 3),
                })
                .collect(),
            effects_taken_out: &calibration.effects,
            notices: &calibration.notices,
        }
    }
}

fn station(station: &StationResult) -> StationFile<'_> {
    StationFile {
        name: &station.name,
        position_mm: station.position_mm.coords.map(mm).into(),
        u_mm: station.u_mm.map(mm),
        dead_path_mm: mm(station.dead_path_mm),
        u_dead_path_mm: mm(station.u_dead_path_mm),
    }
}

/// A commanded position in the unit of the file.
pub(crate) fn position_in_file(kind: AxisKind, position: f64) -> f64 {
    match kind {
        AxisKind::Linear => position,
        AxisKind::Rotary => round(position.to_degrees(), 9),
    }
}

/// A side of approach as the file has it.
pub(crate) fn direction_in_file(direction: Direction) -> i8 {
    match direction {
        Direction::Forward => 1,
        Direction::Backward => -1,
    }
}

fn axis(axis: &AxisResult) -> AxisFile<'_> {
    let rotary = axis.kind == AxisKind::Rotary;
    let position = |node: &NodeResult| position_in_file(axis.kind, node.position);
    let directions: Vec<i8> = axis
        .nodes
        .iter()
        .filter_map(|node| node.direction)
        .map(direction_in_file)
        .collect();
    AxisFile {
        name: &axis.name,
        kind: if rotary { "rotary" } else { "linear" },
        unit: if rotary { "deg" } else { "mm" },
        positions: axis.nodes.iter().map(position).collect(),
        direction: (!directions.is_empty()).then_some(directions),
        reference_point_mm: axis.reference_point_mm.coords.map(mm).into(),
        components: Ordered(
            Component::ALL
                .map(|c| (c.name(&axis.name), curve(axis, c)))
                .into(),
        ),
        noise_gain: axis.noise_gain.map(|gains| {
            let gain = |c: Component| (c.name(&axis.name), gain(&gains, c));
            Ordered(Component::ALL.map(gain).into())
        }),
        u_ratio: axis.u_ratio.map(|loss| {
            let ratio = |c: Component| (c.name(&axis.name), ratio(&loss, c));
            Ordered(Component::ALL.map(ratio).into())
        }),
        forward_minus_backward: axis.sides.map(|sides| {
            let difference = |c: Component| (c.name(&axis.name), difference(&sides, c));
            SidesFile {
                p_value: significant(sides.p_value),
                components: Ordered(Component::ALL.map(difference).into()),
            }
        }),
    }
}

fn curve(axis: &AxisResult, component: Component) -> CurveFile {
    let c = component.index();
    let values = axis.nodes.iter().map(|node| node.error.to_vector()[c]);
    let uncertainties = axis.nodes.iter().map(|node| node.u[c]);
    let behind = behind(axis.nodes.iter().map(|node| (node.dof[c], node.budget[c])));
    if component.is_angular() {
        CurveFile::Angular {
            value_arcsec: values.map(arcsec).collect(),
            u_arcsec: uncertainties.map(arcsec).collect(),
            behind,
        }
    } else {
        CurveFile::Linear {
            value_um: values.map(um).collect(),
            u_um: uncertainties.map(um).collect(),
            behind,
        }
    }
}

/// The least degrees of freedom, and the mean shares of what is not zero by definition.
fn behind(uncertainties: impl Iterator<Item = (f64, Budget)>) -> BehindFile {
    let mut least = f64::INFINITY;
    let (mut sums, mut count) = ([0.0; 4], 0.0);
    for (dof, budget) in uncertainties {
        least = least.min(dof);
        if let Some(shares) = budget.shares() {
            for (sum, share) in sums.iter_mut().zip(shares) {
                *sum += share;
            }
            count += 1.0;
        }
    }
    let [laser, machine_return, station_geometry, effects] = sums.map(|sum| round(sum / count, 4));
    BehindFile {
        dof: least.is_finite().then(|| round(least, 1)),
        budget: (count > 0.0).then_some(SharesFile {
            laser,
            machine_return,
            station_geometry,
            effects: (effects > 0.0).then_some(effects),
        }),
    }
}

fn gain([used, nine]: &[[f64; 6]; 2], component: Component) -> GainFile {
    // mm per mm is µm per µm; rad per mm becomes arcsec per µm.
    let unit = if component.is_angular() {
        MICROMETRE / ARCSEC
    } else {
        1.0
    };
    let gain = |gain: &[f64; 6]| round(gain[component.index()] * unit, 4);
    GainFile {
        used: gain(used),
        nine: gain(nine),
    }
}

fn ratio(loss: &MethodLoss, component: Component) -> RatioFile {
    let c = component.index();
    RatioFile {
        nine: round(loss.nine[c], 4),
        six: loss.six.map(|six| round(six[c], 4)),
    }
}

fn difference(sides: &SideDifference, component: Component) -> DifferenceFile {
    let (value, u) = (sides.value[component.index()], sides.u[component.index()]);
    match component.is_angular() {
        true => DifferenceFile::Angular {
            value_arcsec: arcsec(value),
            u_arcsec: arcsec(u),
        },
        false => DifferenceFile::Linear {
            value_um: um(value),
            u_um: um(u),
        },
    }
}

fn location_errors(axis: &AxisResult) -> Vec<(String, QuantityFile)> {
    axis.location_errors
        .iter()
        .map(|location| {
            let behind = behind(std::iter::once((location.dof, location.budget)));
            let quantity = if location.component.is_angular() {
                let (value_arcsec, u_arcsec) = (arcsec(location.value), arcsec(location.u));
                QuantityFile::Angular {
                    value_arcsec,
                    u_arcsec,
                    behind,
                }
            } else {
                QuantityFile::Linear {
                    value_mm: mm(location.value),
                    u_mm: mm(location.u),
                    behind,
                }
            };
            (location.component.name(&axis.name), quantity)
        })
        .collect()
}

/// To a nanometre's millionth.
fn mm(value: f64) -> f64 {
    round(value, 9)
}

pub(crate) fn um(value_mm: f64) -> f64 {
    round(value_mm / MICROMETRE, 6)
}

fn arcsec(value_rad: f64) -> f64 {
    round(value_rad / ARCSEC, 6)
}

/// Rounded to decimals; no negative zero.
pub(crate) fn round(value: f64, decimals: i32) -> f64 {
    let scale = 10_f64.powi(decimals);
    (value * scale).round() / scale + 0.0
}

/// Three significant digits, for probabilities.
pub(crate) fn significant(value: f64) -> f64 {
    format!("{value:.2e}").parse().unwrap_or(value)
}
