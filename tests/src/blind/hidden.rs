//! The hidden truth: what disturbs a blind campaign, where, when and by how much.

use nalgebra::Vector3;
use trueaxis_kinematics::{ARCSEC, AxisKind, MICROMETRE, Machine};

use super::Course;
use super::course::Instant;
use super::disturbance::Disturbance;

/// One disturbance: an act on a subject with its course in time.
#[derive(Debug, Clone, PartialEq)]
pub struct Hidden {
    /// The catalogue's name, as `machine_shift`; a name of its own if the catalogue has none.
    pub name: &'static str,
    /// What it does.
    pub act: Act,
    /// When.
    pub course: Course,
    /// The station that it concerns; all if none.
    pub station: Option<usize>,
    /// The target that it concerns; all if none.
    pub target: Option<usize>,
    /// The axis that it concerns.
    pub axis: Option<usize>,
}

/// What a disturbance does at its full size.
#[derive(Debug, Clone, PartialEq)]
pub enum Act {
    /// The interferometer's zero moves, µm for each station: lengths grow by it.
    Zero(Vec<f64>),
    /// All lengths grow by this part, ppm.
    Scale(f64),
    /// The tripod moves, µm, reference frame.
    Tripod(Vector3<f64>),
    /// The tripod wanders through these places from one to the next, µm, reference frame.
    Sway {
        /// When it is at the first place, s.
        start_s: f64,
        /// Time from place to place, s.
        every_s: f64,
        /// The places, µm.
        places_um: Vec<Vector3<f64>>,
    },
    /// Air conditioning: scale of the lengths (ppm) and all tripods (µm) swing together.
    Air {
        /// Scale, ppm.
        scale_ppm: f64,
        /// Tripods, µm.
        tripod_um: Vector3<f64>,
    },
    /// A target moves on its stage, µm, stage frame.
    Target(Vector3<f64>),
    /// The triangle of targets grows about its centroid, ppm.
    Growth(f64),
    /// The machine moves, µm, reference frame.
    Machine(Vector3<f64>),
    /// An axis goes too far in proportion to its position, ppm.
    AxisScale(f64),
    /// An axis stands half of this short of where it was sent, µm or arcsec, while it runs.
    LostMotion(f64),
    /// A running axis is read late, ms: it stands that much further on.
    Late(f64),
    /// A target moves on its stage with the power of the axis' position, µm per m² or rad², stage frame.
    Bending {
        /// Coefficient of the power.
        per_square: Vector3<f64>,
        /// 2 for the ideal form.
        exponent: f64,
    },
    /// What an axis carries is led otherwise, by where it stands in its range (x, 0 to 1): displaced by `guide x + bend x²` µm and
    /// turned by `turn x` arc seconds, reference frame.
    Warping {
        /// At the end of the range, µm.
        guide_um: Vector3<f64>,
        /// At the end of the range, µm.
        bend_um: Vector3<f64>,
        /// At the end of the range, about the centroid of the targets, arc seconds.
        turn_arcsec: Vector3<f64>,
    },
    /// Lengths of a station depend on where the axis under test is: a wave over its range.
    CrossTalk {
        /// Amplitude, µm.
        amplitude_um: f64,
        /// Number of waves over the range.
        waves: f64,
        /// At the start of the range, rad.
        phase_rad: f64,
    },
}

/// A reading as far as a disturbance may depend on it.
pub(super) struct Reading<'a> {
    pub(super) machine: &'a Machine,
    pub(super) instant: Instant,
    pub(super) station: usize,
    pub(super) target: usize,
    /// The axis under test.
    pub(super) axis: usize,
    /// Its part of the sweep, 0 to 1.
    pub(super) part: f64,
    /// Where each axis stands in its range, 0 to 1.
    pub(super) parts: &'a [f64],
    pub(super) direction: f64,
    pub(super) speed_per_s: f64,
    pub(super) positions: &'a [f64],
}

const PPM: f64 = 1e-6;
const S_PER_MS: f64 = 1e-3;
const M_PER_MM: f64 = 1e-3;

impl Hidden {
    /// The instant of a jump, s.
    pub fn instant_s(&self) -> Option<f64> {
        match self.course {
            Course::Jump { instant_s, .. } => Some(instant_s),
            _ => None,
        }
    }

    /// The time constant of a warm-up or of a tripod that settles, s.
    pub fn time_constant_s(&self) -> Option<f64> {
        match self.course {
            Course::WarmUp {
                time_constant_s, ..
            }
            | Course::Settling {
                time_constant_s, ..
            } => Some(time_constant_s),
            _ => None,
        }
    }

    /// The period of a swing in time, s.
    pub fn period_s(&self) -> Option<f64> {
        match self.course {
            Course::Wave { period_s, .. } => Some(period_s),
            _ => None,
        }
    }

    /// Adds what the disturbance does to a reading.
    pub(super) fn act_on(&self, reading: &Reading<'_>, sum: &mut Disturbance) {
        let elsewhere = self.station.is_some_and(|own| own != reading.station)
            || self.target.is_some_and(|own| own != reading.target);
        if elsewhere {
            return;
        }
        let part = self.course.at(&reading.instant);
        match &self.act {
            Act::Zero(by_station) => {
                sum.zero_mm += by_station[reading.station] * MICROMETRE * part;
            }
            Act::Scale(ppm) => sum.scale += ppm * PPM * part,
            Act::Tripod(v) => sum.station_mm += v * (MICROMETRE * part),
            Act::Sway {
                start_s,
                every_s,
                places_um,
            } => {
                let t = (reading.instant.time_s - start_s) / every_s;
                sum.station_mm += interpolate(places_um, t) * MICROMETRE;
            }
            Act::Air {
                scale_ppm,
                tripod_um,
            } => {
                sum.scale += scale_ppm * PPM * part;
                sum.station_mm += tripod_um * (MICROMETRE * part);
            }
            Act::Target(v) => sum.target_mm += v * (MICROMETRE * part),
            Act::Growth(ppm) => sum.growth += ppm * PPM * part,
            Act::Machine(v) => sum.machine_mm += v * (MICROMETRE * part),
            Act::AxisScale(_) | Act::LostMotion(_) | Act::Late(_) => {
                sum.axes.extend(self.beyond(reading, part));
            }
            Act::Bending {
                per_square,
                exponent,
            } => {
                let axis = self.axis.unwrap_or(reading.axis);
                let q = match reading.machine.axes()[axis].kind() {
                    AxisKind::Linear => reading.positions[axis] * M_PER_MM,
                    AxisKind::Rotary => reading.positions[axis],
                };
                sum.target_mm += per_square * (MICROMETRE * part * q.abs().powf(*exponent));
            }
            Act::Warping {
                guide_um,
                bend_um,
                turn_arcsec,
            } => {
                let x = reading.parts[self.axis.unwrap_or(reading.axis)];
                sum.machine_mm += (guide_um + bend_um * x) * (MICROMETRE * part * x);
                sum.turn += turn_arcsec * (ARCSEC * part * x);
            }
            Act::CrossTalk {
                amplitude_um,
                waves,
                phase_rad,
            } => {
                let angle = std::f64::consts::TAU * waves * reading.part + phase_rad;
                sum.zero_mm += amplitude_um * MICROMETRE * part * angle.sin();
            }
        }
    }

    /// By how much the axis stands beyond its commanded position, mm or rad.
    fn beyond(&self, reading: &Reading<'_>, part: f64) -> Option<(usize, f64)> {
        let axis = self.axis?;
        let runs = axis == reading.axis;
        let unit = match reading.machine.axes()[axis].kind() {
            AxisKind::Linear => MICROMETRE,
            AxisKind::Rotary => ARCSEC,
        };
        let beyond = match self.act {
            Act::AxisScale(ppm) => ppm * PPM * reading.positions[axis],
            Act::LostMotion(b) if runs => -0.5 * b * unit * reading.direction,
            Act::Late(ms) if runs => reading.speed_per_s * ms * S_PER_MS,
            _ => return None,
        };
        Some((axis, beyond * part))
    }
}

/// On the straight lines between places, `t` counting them from 0; the ends go on for ever.
fn interpolate(places: &[Vector3<f64>], t: f64) -> Vector3<f64> {
    let Some(last) = places.len().checked_sub(1) else {
        return Vector3::zeros();
    };
    let before = (0..=last).rev().find(|&i| i as f64 <= t).unwrap_or(0);
    let after = (before + 1).min(last);
    let weight = (t - before as f64).clamp(0.0, 1.0);
    places[before].lerp(&places[after], weight)
}

/// The same disturbance, `factor` times as large.
#[must_use]
pub fn scaled(hidden: &Hidden, factor: f64) -> Hidden {
    let mut hidden = hidden.clone();
    match &mut hidden.act {
        Act::Zero(by_station) => by_station.iter_mut().for_each(|value| *value *= factor),
        Act::Sway { places_um, .. } => places_um.iter_mut().for_each(|place| *place *= factor),
        Act::Air {
            scale_ppm,
            tripod_um,
        } => {
            *scale_ppm *= factor;
            *tripod_um *= factor;
        }
        Act::Tripod(v) | Act::Target(v) | Act::Machine(v) => *v *= factor,
        Act::Bending { per_square, .. } => *per_square *= factor,
        Act::CrossTalk { amplitude_um, .. } => *amplitude_um *= factor,
        Act::Warping {
            guide_um,
            bend_um,
            turn_arcsec,
        } => [guide_um, bend_um, turn_arcsec]
            .into_iter()
            .for_each(|v| *v *= factor),
        Act::Scale(value)
        | Act::Growth(value)
        | Act::AxisScale(value)
        | Act::LostMotion(value)
        | Act::Late(value) => *value *= factor,
    }
    hidden
}
