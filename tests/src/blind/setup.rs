//! The true set-up: errors of the machine, targets and stations as they are, drawn from the seed.

use std::f64::consts::TAU;

use nalgebra::{Point3, Rotation3, Vector3};
use trueaxis_kinematics::{ARCSEC, AxisKind, GeometricErrors, LocationError, MICROMETRE};
use trueaxis_kinematics::{LocationComponent, MotionError};

use super::layout::Layout;
use super::random::{Purpose, Random};

/// Where stations stand around the middle of the points: three low and one high, about a
/// tetrahedron, which measures points best; further ones lie between.
const AROUND: [[f64; 3]; 6] = [
    [-1.0, -0.76, -0.22],
    [1.1, -0.66, -0.12],
    [0.85, 0.99, -0.32],
    [-0.6, 0.84, 1.03],
    [0.2, -0.9, 0.9],
    [0.9, 0.3, 0.6],
];
/// How far a station's direction may be from there, per coordinate of the unit vector.
const ASTRAY: f64 = 0.15;
/// Distance of a station from the middle of the points, mm.
const FAR_MM: [f64; 2] = [900.0, 1600.0];
/// Standard deviation per coordinate of a target's mounting, mm.
const MOUNTING_MM: f64 = 0.02;

/// What is true of the machine, the targets and the stations.
#[derive(Debug, Clone)]
pub(super) struct Setup {
    pub(super) errors: SmoothErrors,
    /// Targets at home, mm.
    pub(super) homes_mm: Vec<Point3<f64>>,
    pub(super) stations_mm: Vec<Point3<f64>>,
    pub(super) dead_paths_mm: Vec<f64>,
}

impl Setup {
    pub(super) fn new(layout: &Layout, stations: usize, seed: u64) -> Self {
        let mut random = Random::new(seed, Purpose::Setup);
        let errors = SmoothErrors::draw(layout, &mut random);
        let mounted =
            |t: &Point3<f64>, random: &mut Random| t + random.normal_vector() * MOUNTING_MM;
        let homes = layout
            .targets
            .iter()
            .map(|t| mounted(&t.home_mm, &mut random));
        let homes_mm = homes.collect();
        let turn = Rotation3::new(Vector3::z() * random.between(0.0, TAU));
        let around = AROUND.iter().cycle().take(stations);
        let stations = around.map(|&direction| {
            let astray = Vector3::from_fn(|_, _| random.between(-ASTRAY, ASTRAY));
            let direction = Vector3::from(direction).normalize() + astray;
            let far_mm = random.between(FAR_MM[0], FAR_MM[1]);
            layout.centre_mm + turn * direction.normalize() * far_mm
        });
        let stations_mm: Vec<Point3<f64>> = stations.collect();
        let dead_paths = stations_mm.iter().map(|_| random.between(800.0, 1500.0));
        Self {
            errors,
            homes_mm,
            dead_paths_mm: dead_paths.collect(),
            stations_mm,
        }
    }
}

/// Smooth geometric errors of all axes.
#[derive(Debug, Clone)]
pub(super) struct SmoothErrors {
    pub(super) axes: Vec<AxisCurves>,
}

/// The errors of an axis: curves over the part `x` of its range, 0 to 1 (beyond it they go on).
#[derive(Debug, Clone)]
pub(super) struct AxisCurves {
    pub(super) location: LocationError,
    range: [f64; 2],
    /// In mm and rad, in the order of the components.
    curves: [Curve; 6],
}

/// `x (a + x (b + x c)) + Σ d sin(2π n x + φ)`: for a linear axis a polynomial and one wave, for a
/// rotary one waves alone.
#[derive(Debug, Clone)]
struct Curve {
    polynomial: [f64; 3],
    waves: Vec<Wave>,
}

#[derive(Debug, Clone, Copy)]
struct Wave {
    amplitude: f64,
    number: f64,
    phase: f64,
}

impl SmoothErrors {
    fn draw(layout: &Layout, random: &mut Random) -> Self {
        let axes = layout.machine.axes().iter().enumerate();
        let axes = axes.map(|(i, axis)| {
            let mut location = LocationError::default();
            for component in axis.location_components() {
                match component {
                    LocationComponent::Offset(k) => location.offset_mm[k] = 0.015 * random.normal(),
                    LocationComponent::Tilt(k) => {
                        location.tilt_rad[k] = random.between(-30.0, 30.0) * ARCSEC;
                    }
                }
            }
            let rotary = axis.kind() == AxisKind::Rotary;
            AxisCurves {
                location,
                range: layout.range(i),
                curves: std::array::from_fn(|component| {
                    let unit = if component < 3 {
                        MICROMETRE
                    } else {
                        0.6 * ARCSEC
                    };
                    Curve::draw(rotary, unit, random)
                }),
            }
        });
        Self {
            axes: axes.collect(),
        }
    }
}

impl Curve {
    /// A few units large.
    fn draw(rotary: bool, unit: f64, random: &mut Random) -> Self {
        let numbers = if rotary {
            vec![(2.0, 1.0), (1.5, 2.0), (0.7, 4.0)]
        } else {
            vec![(0.7, random.between(2.0, 4.0))]
        };
        let waves = numbers.into_iter().map(|(amplitude, number)| Wave {
            amplitude: amplitude * unit * random.between(0.5, 1.5),
            number,
            phase: random.between(0.0, TAU),
        });
        let waves = waves.collect();
        let size = if rotary { 0.0 } else { unit };
        Self {
            waves,
            polynomial: [5.0, 3.0, 1.5].map(|c| c * size * random.between(-1.0, 1.0)),
        }
    }

    fn at(&self, x: f64) -> f64 {
        let [a, b, c] = self.polynomial;
        let waves = self
            .waves
            .iter()
            .map(|wave| wave.amplitude * (TAU * wave.number * x + wave.phase).sin());
        x * (a + x * (b + x * c)) + waves.sum::<f64>()
    }
}

impl GeometricErrors for SmoothErrors {
    fn location(&self, axis: usize) -> LocationError {
        self.axes[axis].location
    }

    fn motion(&self, axis: usize, position: f64) -> MotionError {
        let AxisCurves { range, curves, .. } = &self.axes[axis];
        let x = (position - range[0]) / (range[1] - range[0]);
        let part = |component: usize| curves[component].at(x);
        MotionError::new(
            Vector3::from_fn(|i, _| part(i)),
            Vector3::from_fn(|i, _| part(3 + i)),
        )
    }
}
