//! Component and location errors by their ISO 230-1 names, as files of other systems and old tables have them.

use std::collections::BTreeMap;

use nalgebra::{Point3, Vector3, Vector6};
use trueaxis_files::Alternatives;
use trueaxis_kinematics::{Axis, AxisKind, Component, LocationComponent, Machine, MotionError};

use crate::Error;
use crate::export::line::interpolate;
use crate::export::rising;

/// Positions this close are one, mm or degrees.
const SAME: f64 = 1e-9;

/// No machine has such errors: beyond this a file is in another unit than mm and rad.
const MOST_MM: f64 = 5.0;
const MOST_RAD: f64 = 0.05;

/// What a file says; values in mm and rad, arguments in mm and degrees.
#[derive(Debug, Default)]
pub(crate) struct NamedErrors {
    file: String,
    /// Values that depend on nothing, as `C0Y`, with their lines.
    constants: BTreeMap<String, (usize, f64)>,
    /// Values that depend on an axis, as `EXX`.
    curves: BTreeMap<String, Curve>,
}

/// A value over the positions of an axis, rising.
#[derive(Debug, Default)]
struct Curve {
    line: usize,
    points: Vec<(f64, f64)>,
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct AxisErrors {
    pub(crate) axis: usize,
    /// mm or rad, rising: all positions of its curves. None if the file has location errors of the axis alone.
    pub(crate) positions: Vec<f64>,
    /// mm and rad; components without a curve are zero.
    pub(crate) errors: Vec<MotionError>,
    /// Components that have a curve.
    pub(crate) given: Vec<Component>,
    /// Whether their positions differ, so that they were interpolated.
    pub(crate) is_interpolated: bool,
    pub(crate) locations: Vec<(LocationComponent, f64)>,
    /// Place of a rotary axis, if the file has it.
    pub(crate) centre_mm: Option<Point3<f64>>,
}

impl NamedErrors {
    pub(crate) fn new(file: &str) -> Self {
        Self {
            file: file.to_owned(),
            ..Self::default()
        }
    }

    /// The error for line `number`, from 1.
    pub(crate) fn wrong(&self, number: usize, found: &str, expected: impl Into<String>) -> Error {
        wrong(&self.file, number, found, expected)
    }

    /// The same for the first error that depends on that axis.
    pub(crate) fn wrong_at(&self, axis: &str, found: &str, expected: String) -> Error {
        let curves = self.curves.iter().filter(|(name, _)| name.ends_with(axis));
        let first = curves.map(|(_, curve)| curve.line).min();
        self.wrong(first.unwrap_or(1), found, expected)
    }

    /// A number of a line.
    pub(crate) fn number(&self, number: usize, cell: &str) -> Result<f64, Error> {
        let value = cell.parse().ok().filter(|x: &f64| x.is_finite());
        value.ok_or_else(|| self.wrong(number, cell, "a number with a decimal point, as -0.0012"))
    }

    /// Takes in what depends on nothing.
    pub(crate) fn add_constant(
        &mut self,
        number: usize,
        name: &str,
        value: f64,
    ) -> Result<(), Error> {
        self.check_size(number, name, name.chars().next(), value)?;
        match self.constants.insert(name.to_owned(), (number, value)) {
            None => Ok(()),
            Some((first, _)) => Err(self.twice(number, name, first)),
        }
    }

    /// Begins a curve in line `number`.
    pub(crate) fn add_curve(&mut self, number: usize, name: &str) -> Result<(), Error> {
        let curve = Curve {
            line: number,
            points: Vec::new(),
        };
        match self.curves.insert(name.to_owned(), curve) {
            None => Ok(()),
            Some(first) => Err(self.twice(number, name, first.line)),
        }
    }

    /// Takes in a point of the curve of that name.
    pub(crate) fn add_point(
        &mut self,
        number: usize,
        name: &str,
        (argument, value): (f64, f64),
    ) -> Result<(), Error> {
        let last = self.curves.get(name).and_then(|curve| curve.points.last());
        if let Some(&(last, _)) = last
            && argument - last <= SAME
        {
            let found = format!("{argument}, after {last}");
            return Err(self.wrong(number, &found, "positions that rise"));
        }
        self.check_size(number, name, name.chars().nth(1), value)?;
        let curve = self.curves.entry(name.to_owned()).or_default();
        curve.points.push((argument, value));
        Ok(())
    }

    fn twice(&self, number: usize, name: &str, first: usize) -> Error {
        let expected = format!("each error once; line {first} has it already");
        self.wrong(number, name, expected)
    }

    /// The errors of the axes of a machine.
    ///
    /// # Errors
    /// A name that is not of this machine, a size that no machine has, a curve with less than two points.
    pub(crate) fn of_machine(&self, machine: &Machine) -> Result<Vec<AxisErrors>, Error> {
        if self.constants.is_empty() && self.curves.is_empty() {
            let expected = "component or location errors, as EXX or C0Y";
            return Err(self.wrong(1, "nothing", expected));
        }
        self.check_names(machine)?;
        self.check_lengths()?;
        let axes = (0..machine.axes().len()).map(|axis| self.of_axis(machine, axis));
        let mut axes = axes.collect::<Result<Vec<_>, Error>>()?;
        axes.retain(|axis| !axis.positions.is_empty() || !axis.locations.is_empty());
        Ok(axes)
    }

    fn check_names(&self, machine: &Machine) -> Result<(), Error> {
        let of_all = |names: fn(&Axis) -> Vec<String>| -> Vec<String> {
            machine.axes().iter().flat_map(names).collect()
        };
        let curves = of_all(component_names);
        let constants = of_all(constant_names);
        let of_curves = self.curves.iter().map(|(name, curve)| (name, curve.line));
        // Redundant ones, as X0X, are there as zeros.
        let there = |(_, (_, value)): &(&String, &(usize, f64))| value.abs() > 0.0;
        let of_constants = self.constants.iter().filter(there);
        let of_constants = of_constants.map(|(name, (line, _))| (name, *line));
        let unknown_curves = of_curves.filter(|(name, _)| !curves.contains(name));
        let unknown = of_constants.filter(|(name, _)| !constants.contains(name));
        let of_kind = unknown_curves
            .map(|found| (found, &curves))
            .chain(unknown.map(|found| (found, &constants)));
        // The first in the file.
        match of_kind.min_by_key(|((_, line), _)| *line) {
            None => Ok(()),
            Some(((name, line), known)) => {
                let alternatives = Alternatives::new(name, known);
                let expected = format!("an error of an axis of this machine; {alternatives}");
                Err(self.wrong(line, name, expected))
            }
        }
    }

    fn check_lengths(&self) -> Result<(), Error> {
        let short = self.curves.iter().find(|(_, curve)| curve.points.len() < 2);
        match short {
            None => Ok(()),
            Some((name, curve)) => {
                let expected = "two points or more: the file may be cut off";
                Err(self.wrong(curve.line, name, expected))
            }
        }
    }

    /// `letter` is that of the direction, as the middle one of `EXX`.
    fn check_size(
        &self,
        number: usize,
        name: &str,
        letter: Option<char>,
        value: f64,
    ) -> Result<(), Error> {
        let (most, unit) = match letter {
            Some('A' | 'B' | 'C') => (MOST_RAD, "rad"),
            Some('X' | 'Y' | 'Z') => (MOST_MM, "mm"),
            _ => return Ok(()),
        };
        if value.abs() <= most {
            return Ok(());
        }
        let expected = format!("at most {most} {unit}: the file is in mm and rad");
        Err(self.wrong(number, &format!("{name} = {value}"), expected))
    }

    fn of_axis(&self, machine: &Machine, axis: usize) -> Result<AxisErrors, Error> {
        let geometry = &machine.axes()[axis];
        let name = geometry.name();
        let curves = Component::ALL.map(|component| self.curves.get(&component.name(name)));
        let given = Component::ALL.into_iter();
        let given: Vec<_> = given.filter(|c| curves[c.index()].is_some()).collect();
        let arguments = |curve: &Curve| -> Vec<f64> { curve.points.iter().map(|p| p.0).collect() };
        let all = rising(curves.iter().flatten().flat_map(|c| arguments(c)), SAME);
        let is_interpolated = curves.iter().flatten().any(|c| c.points.len() != all.len());
        let of = |curve: Option<&Curve>, position: f64| {
            let Some(curve) = curve else { return 0.0 };
            interpolate(&arguments(curve), |k| curve.points[k].1, position)
        };
        let errors = all.iter().map(|&position| {
            MotionError::from_vector(&Vector6::from_fn(|c, _| of(curves[c], position)))
        });
        let constant = |component: LocationComponent| {
            let found = self.constants.get(&component.name(name));
            found.map(|(_, value)| *value)
        };
        // A calibration has the rotation across the axis, which gives it the same direction.
        let tilt = Vector3::from_fn(|i, _| constant(LocationComponent::Tilt(i)).unwrap_or(0.0));
        let direction = geometry.direction();
        let across = tilt - direction.into_inner() * direction.dot(&tilt);
        let own = geometry.location_components().into_iter();
        let locations = own.filter_map(|component| match component {
            LocationComponent::Offset(_) => Some((component, constant(component)?)),
            LocationComponent::Tilt(i) => {
                let is_given = constant(component).is_some() || across[i].abs() > 0.0;
                is_given.then_some((component, across[i]))
            }
        });
        Ok(AxisErrors {
            axis,
            errors: errors.collect(),
            given,
            is_interpolated,
            locations: locations.collect(),
            centre_mm: self.centre(geometry)?,
            positions: match geometry.kind() {
                AxisKind::Linear => all,
                AxisKind::Rotary => all.into_iter().map(f64::to_radians).collect(),
            },
        })
    }

    /// `PXC PYC PZC`, which must be on the nominal axis.
    fn centre(&self, axis: &Axis) -> Result<Option<Point3<f64>>, Error> {
        if axis.kind() == AxisKind::Linear {
            return Ok(None);
        }
        let names = centre_names(axis);
        let found = names.iter().filter_map(|name| self.constants.get(name));
        let found: Vec<(usize, f64)> = found.copied().collect();
        let (line, [x, y, z]) = match *found {
            [] => return Ok(None),
            [(line, x), (_, y), (_, z)] => (line, [x, y, z]),
            [(line, value), ..] => {
                return Err(self.wrong(line, &value.to_string(), names.join(", ")));
            }
        };
        let centre = Point3::new(x, y, z);
        let beside = axis
            .direction()
            .cross(&(centre - axis.reference_mm()))
            .norm();
        if beside > MOST_MM {
            let found = format!("{} = {x}, {y}, {z}", names.join(", "));
            let expected = format!(
                "a point on axis {} of the machine, and it is {beside:.3} mm beside it: another machine, or a frame \
                 with another origin",
                axis.name()
            );
            return Err(self.wrong(line, &found, expected));
        }
        Ok(Some(centre))
    }
}

fn component_names(axis: &Axis) -> Vec<String> {
    Component::ALL.map(|c| c.name(axis.name())).to_vec()
}

fn constant_names(axis: &Axis) -> Vec<String> {
    let own = axis.location_components().into_iter();
    // The third tilt of an oblique axis is one, too.
    let principal = axis.principal();
    let is_oblique = (0..3).any(|i| i != principal && axis.direction()[i].abs() > 0.0);
    let third = is_oblique.then_some(LocationComponent::Tilt(principal));
    let locations = own.chain(third);
    let locations = locations.map(|component| component.name(axis.name()));
    locations.chain(centre_names(axis)).collect()
}

fn centre_names(axis: &Axis) -> [String; 3] {
    ["X", "Y", "Z"].map(|letter| format!("P{letter}{}", axis.name()))
}

/// The error for a line of a file, from 1.
pub(crate) fn wrong(file: &str, number: usize, found: &str, expected: impl Into<String>) -> Error {
    Error::Table {
        file: file.to_owned(),
        line: number,
        found: found.chars().take(MOST_SHOWN).collect(),
        expected: expected.into(),
    }
}

/// Characters of a line that an error shows.
const MOST_SHOWN: usize = 80;
