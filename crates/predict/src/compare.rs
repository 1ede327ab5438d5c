//! The difference of two calibrations of one machine: before and after a repair, this year and last.
//!
//! Component errors are compared at the steps of the second calibration that lie inside those of the first, where the
//! first is interpolated; location errors as they are. The two are taken for independent, so that `u² = u_a² + u_b²`, with
//! what the interpolation may be off by. Each is in its own frame and gauge, by the same rules, which agree if their lines
//! go through the same positions. Where steps differ, both are therefore referred to a line (or axis) through positions
//! that both know ([`crate::common_line`]); what else follows from other steps is marked
//! ([`Difference::follows_from_other_steps`]). Translations and average lines are those of the reference point, so that
//! calibrations with different ones are not compared; those whose errors are zero elsewhere than at home are
//! ([`CalibratedMachine::other_homes`]).

use trueaxis_kinematics::{ARCSEC, AxisKind, Component, LocationComponent, MICROMETRE};

use crate::calibrated_machine::{CalibratedAxis, CalibratedMachine};
use crate::common_line::{Function, Steps, Tilts, is_from_line};

/// Standard uncertainties beyond which a difference is not noise: normal noise exceeds them once in 150,000, so that
/// of a thousand differences, however they go together, one does with a probability below 1 %.
const BEYOND_NOISE: f64 = 4.5;

/// Reference points that are closer together are one, mm: a rotation of 1e-3 rad makes a nanometre of the distance.
const SAME_POINT_MM: f64 = 1e-3;

/// Steps that are closer together are one, mm or rad: files round degrees to 1e-9.
const SAME_HOME: f64 = 1e-9;

/// Linear axes that stand closer together stand alike: 500 µm/m² make 0.02 µm of it at 0.4 m.
const SAME_PLACE_MM: f64 = 0.1;

/// The same of rotary axes: 0.1 mm at a lever of 1 m.
const SAME_PLACE_RAD: f64 = 1e-4;

/// Whether an axis stands so nearly alike at two positions, mm or rad, that no coupling shows over the difference.
pub fn stands_alike(kind: AxisKind, a: f64, b: f64) -> bool {
    let closest = match kind {
        AxisKind::Linear => SAME_PLACE_MM,
        AxisKind::Rotary => SAME_PLACE_RAD,
    };
    (a - b).abs() <= closest
}

/// A component error at a step, or a location error, in both calibrations: mm or rad.
#[derive(Debug, Clone, PartialEq)]
pub struct Difference {
    /// ISO 230-1 name.
    pub name: String,
    /// Index of the axis.
    pub axis: usize,
    /// Position of the axis, mm or rad; none for a location error.
    pub position: Option<f64>,
    /// Whether it is an angle.
    pub is_angular: bool,
    /// In the first calibration; what refers to an average line or axis, from [that](CalibratedMachine::other_steps) through
    /// positions that both know.
    pub first: f64,
    /// In the second.
    pub second: f64,
    /// Whether average lines or axes enter it that are through other positions in the second calibration: then it contains what the
    /// error curves make of that, which `u` does not.
    pub follows_from_other_steps: bool,
    /// Standard uncertainty of second minus first; 0 where both are zero by definition, NaN if one calibration has none.
    pub u: f64,
}

/// Two calibrations give the translations of an axis for different points of its stage.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error(
    "the translations of {axis} are those of the point {first_mm:?} mm in the first calibration, of {second_mm:?} mm \
     in the second, and so are average lines and squareness: calibrate both with one --reference-point"
)]
pub struct OtherReferencePoint {
    /// The axis.
    pub axis: String,
    /// In the first calibration, in the reference frame at home.
    pub first_mm: [f64; 3],
    /// In the second.
    pub second_mm: [f64; 3],
}

impl Difference {
    /// Second minus first, mm or rad.
    pub fn value(&self) -> f64 {
        self.second - self.first
    }

    /// The unit that files give it in, mm or rad, and how their fields name it.
    pub fn unit(&self) -> (f64, &'static str) {
        match self.is_angular {
            true => (ARCSEC, "arcsec"),
            false => (MICROMETRE, "um"),
        }
    }

    /// Whether the machine has changed there, which noise and other steps do not explain.
    pub fn is_change(&self) -> bool {
        self.is_beyond_noise() && !self.follows_from_other_steps
    }

    /// Whether it is more than noise makes of any of a thousand differences.
    pub fn is_beyond_noise(&self) -> bool {
        self.u > 0.0 && self.value().abs() > BEYOND_NOISE * self.u
    }

    /// The difference over its U for k = 2; none where it is certain.
    pub fn e_n(&self) -> Option<f64> {
        (self.u > 0.0).then(|| self.value() / (2.0 * self.u))
    }
}

impl CalibratedMachine {
    /// How `second`, a calibration of the same machine, differs from this one: component errors axis by axis, then location
    /// errors. Axes are matched by name; those that only one calibration measured are left out.
    ///
    /// # Errors
    /// [`OtherReferencePoint`]: translations of two points of a stage differ by its rotations.
    pub fn compare(&self, second: &Self) -> Result<Vec<Difference>, OtherReferencePoint> {
        let mut all = Vec::new();
        let unknown = match self.has_uncertainties && second.has_uncertainties {
            true => 0.0,
            false => f64::NAN,
        };
        for (name, a, b) in self.pairs(second) {
            let [first_mm, second_mm] = [
                self.machine.axes()[a.axis].reference_mm(),
                second.machine.axes()[b.axis].reference_mm(),
            ];
            if (first_mm - second_mm).norm() > SAME_POINT_MM {
                return Err(OtherReferencePoint {
                    axis: name.to_owned(),
                    first_mm: first_mm.coords.into(),
                    second_mm: second_mm.coords.into(),
                });
            }
        }
        let pairs = self.pairs_with_steps(second);
        for Pair { name, axes, steps } in &pairs {
            let [a, b] = *axes;
            let axis = &second.machine.axes()[b.axis];
            for component in Component::ALL {
                let is_open = is_from_line(axis.kind(), component) && *steps == Steps::Other;
                for position in b.curve.steps() {
                    if a.curve.at(position).beyond > 0.0 {
                        continue;
                    }
                    let function = steps.function(component, position);
                    let of = |machine: &Self, axis: &CalibratedAxis| {
                        let mut sum = Sum::default();
                        sum.add(axis, &function);
                        (sum.value, sum.u(machine))
                    };
                    let ((first, u_a), (second, u_b)) = (of(self, a), of(second, b));
                    all.push(Difference {
                        name: component.name(name),
                        axis: b.axis,
                        position: Some(position),
                        is_angular: component.is_angular(),
                        first,
                        second,
                        follows_from_other_steps: is_open,
                        u: u_a.hypot(u_b) + unknown,
                    });
                }
            }
        }
        let in_first = Tilts::new(&self.machine, &self.axes);
        let in_second = Tilts::new(&second.machine, &second.axes);
        for pair in &pairs {
            let [a, b] = pair.axes;
            for &component in b.reported.iter().filter(|c| a.reported.contains(c)) {
                let first_sum = location(&pairs, pair, component, &in_first, 0);
                let second_sum = location(&pairs, pair, component, &in_second, 1);
                let [u_a, u_b] = [first_sum.u(self), second_sum.u(second)];
                all.push(Difference {
                    name: component.name(pair.name),
                    axis: b.axis,
                    position: None,
                    is_angular: component.is_angular(),
                    first: first_sum.value,
                    second: second_sum.value,
                    follows_from_other_steps: lies_elsewhere(&pairs, pair, component, &in_second),
                    u: u_a.hypot(u_b) + unknown,
                });
            }
        }
        Ok(all)
    }

    /// Axes that were measured at other steps in `second`, with the positions (mm or rad) of the average line or axis to which both
    /// calibrations are referred; none where too few are known in both.
    pub fn other_steps<'a>(
        &'a self,
        second: &'a Self,
    ) -> Vec<(&'a str, AxisKind, Option<Vec<f64>>)> {
        let pairs = self.pairs_with_steps(second).into_iter();
        let other = pairs.filter_map(|pair| {
            let kind = second.machine.axes()[pair.axes[1].axis].kind();
            match pair.steps {
                Steps::Same => None,
                Steps::Line(line) => Some((pair.name, kind, Some(line.positions))),
                Steps::Other => Some((pair.name, kind, None)),
            }
        });
        other.collect()
    }

    /// Axes of which home was not a step in both calibrations, with the steps whose errors each takes for those at home, mm
    /// or rad: home itself, the two around it, or the nearest. Positioning and angles of a linear axis, and what is along and
    /// about a rotary one, are zero there, so that their differences contain what the curve itself makes of another place;
    /// where both have the steps around home in common they do not, and the axis is left out.
    pub fn other_homes<'a>(&'a self, second: &'a Self) -> Vec<(&'a str, AxisKind, [Vec<f64>; 2])> {
        let all = self.pairs(second).map(|(name, a, b)| {
            let kind = second.machine.axes()[b.axis].kind();
            (name, kind, [a, b].map(|axis| axis.curve.steps_of_home()))
        });
        let is_elsewhere = |steps: &Vec<f64>| steps.len() == 1 && steps[0].abs() > SAME_HOME;
        all.filter(|(_, _, [a, b])| {
            let mut pairs = a.iter().zip(b);
            let same = a.len() == b.len() && pairs.all(|(a, b)| (a - b).abs() <= SAME_HOME);
            !same || is_elsewhere(a)
        })
        .collect()
    }

    /// Axes that were measured while another one stood elsewhere in `second`, with the indices of both in that machine and where the
    /// other one stood, mm or rad: what couples them makes other curves. Those that stood at several places are left out.
    pub fn other_parking<'a>(&'a self, second: &'a Self) -> Vec<([usize; 2], [f64; 2])> {
        let stood = |machine: &Self, axis: usize, name: &str| {
            let other = machine.machine.axis_index(name);
            let positions = machine.parked.get(&axis).zip(other);
            positions.map_or(Some(0.0), |(positions, other)| positions[other])
        };
        let mut all = Vec::new();
        for (_, a, b) in self.pairs(second) {
            for (other, geometry) in second.machine.axes().iter().enumerate() {
                let at = |machine: &Self, axis| stood(machine, axis, geometry.name());
                let (Some(first), Some(second)) = (at(self, a.axis), at(second, b.axis)) else {
                    continue;
                };
                if !stands_alike(geometry.kind(), first, second) {
                    all.push(([b.axis, other], [first, second]));
                }
            }
        }
        all
    }

    /// The axes that both measured, by name.
    fn pairs<'a>(
        &'a self,
        second: &'a Self,
    ) -> impl Iterator<Item = (&'a str, &'a CalibratedAxis, &'a CalibratedAxis)> {
        second.axes.iter().filter_map(|b| {
            let name = second.machine.axes()[b.axis].name();
            let a = self.axis(self.machine.axis_index(name)?)?;
            Some((name, a, b))
        })
    }

    /// The same with what their steps have in common.
    fn pairs_with_steps<'a>(&'a self, second: &'a Self) -> Vec<Pair<'a>> {
        let pairs = self.pairs(second).map(|(name, a, b)| {
            let steps = Steps::new(&second.machine.axes()[b.axis], a, b);
            let axes = [a, b];
            Pair { name, axes, steps }
        });
        pairs.collect()
    }
}

/// An axis that both measured.
struct Pair<'a> {
    name: &'a str,
    /// Its errors in the first calibration and in the second.
    axes: [&'a CalibratedAxis; 2],
    steps: Steps,
}

/// A linear function of the results of a calibration.
#[derive(Default)]
struct Sum {
    value: f64,
    /// Places of results and coefficients.
    places: Vec<(usize, f64)>,
    /// What interpolation may be off by, at all positions to the same side: between steps a smooth curve is.
    between_steps: f64,
}

impl Sum {
    fn add(&mut self, axis: &CalibratedAxis, function: &Function) {
        for (position, coefficients) in function {
            let sample = axis.curve.at(*position);
            self.value += coefficients.dot(&axis.error(&sample).to_vector());
            self.between_steps += coefficients.abs().dot(&axis.remainder.u(&sample));
            for &(node, weight) in &sample.weights {
                let used = coefficients.iter().enumerate().filter(|(_, c)| **c != 0.0);
                let places = used.map(|(i, c)| (axis.first + 6 * node + i, c * weight));
                self.places.extend(places);
            }
        }
    }

    fn u(&self, machine: &CalibratedMachine) -> f64 {
        machine.factors.u(&self.places).hypot(self.between_steps)
    }
}

/// A location error with the lines through the positions that both calibrations know, in the first (0) or the second (1).
fn location(
    pairs: &[Pair<'_>],
    of: &Pair<'_>,
    component: LocationComponent,
    tilts: &Tilts<'_>,
    which: usize,
) -> Sum {
    let axis = of.axes[which];
    let place = axis.reported.iter().position(|other| *other == component);
    let mut sum = Sum {
        value: component.of(&axis.location),
        places: vec![(axis.first_location + place.unwrap_or_default(), 1.0)],
        between_steps: 0.0,
    };
    let (LocationComponent::Tilt(i), Some(_)) = (component, tilts.lines()) else {
        return sum;
    };
    for pair in pairs {
        if let Steps::Line(line) = &pair.steps {
            let own = pair.axes[which];
            let response = tilts.response(axis.axis, own.axis);
            sum.add(own, &line.of_tilt(&response.row(i).transpose()));
        }
    }
    sum
}

/// Whether lines or axes enter a location error that are not through the same positions.
fn lies_elsewhere(
    pairs: &[Pair<'_>],
    of: &Pair<'_>,
    component: LocationComponent,
    tilts: &Tilts<'_>,
) -> bool {
    let (LocationComponent::Tilt(_), Some(lines)) = (component, tilts.lines()) else {
        // The curves at home displace the targets, which have a part in the frame.
        return pairs.iter().any(|pair| pair.steps != Steps::Same);
    };
    let index = |pair: &Pair<'_>| pair.axes[1].axis;
    let enters = |pair: &&Pair<'_>| index(pair) == index(of) || lines.contains(&index(pair));
    pairs.iter().filter(enters).any(|p| p.steps == Steps::Other)
}
