//! The volumetric error over the working volume.

mod contributions;
mod draws;
pub(crate) mod places;
pub(crate) mod statistics;

use nalgebra::{Point3, Vector3, Vector6};
use rayon::prelude::*;
use trueaxis_kinematics::{Ideal, MotionError};

use crate::calibrated_machine::CalibratedMachine;
use contributions::{Coefficients, applied};
use draws::Root;
use places::Places;
use statistics::{Figures, RigidFit, figures, percentile_place};

/// How the volume is looked at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VolumeSettings {
    /// Nodes of the grid along each linear axis; two at least.
    pub points: usize,
    /// The tool point in the reference frame at home, mm.
    pub tool_home_mm: Point3<f64>,
    /// Draws of the calibration's errors for the intervals.
    pub draws: usize,
    /// Seed of these.
    pub seed: u64,
}

/// Places that take part in intervals and shares: an interval needs no more.
const MOST_DRAWN: usize = 1000;

/// Limits of the intervals.
const INTERVAL: [f64; 2] = [0.025, 0.975];

/// The volumetric error of a machine.
#[derive(Debug, Clone, PartialEq)]
pub struct Volume {
    /// Where it was looked at.
    pub places: Places,
    /// Error at home, which is subtracted, mm and rad.
    pub home: MotionError,
    /// The figures.
    pub figures: Figures<Figure>,
    /// The place with the largest `|e - e(home)|`: positions of all axes, mm or rad.
    pub worst: Vec<f64>,
    /// The error there less that at home (rotation as it is), mm and rad.
    pub worst_error: MotionError,
    /// Share of each component and location error in the mean square of `e - e(home)`.
    pub shares: Vec<(String, f64)>,
}

/// A figure, mm or rad.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Figure {
    /// Of the errors as calibrated.
    pub value: f64,
    /// What the uncertainty of the calibration does to it; `None` if there are too many results to draw.
    pub drawn: Option<Drawn>,
}

/// How a figure scatters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drawn {
    /// By how much the noise of the calibration raises the figure in the mean: sizes of noisy values are biased, the
    /// largest of many most.
    pub bias: f64,
    /// Interval of 95 % for the true figure.
    pub interval: [f64; 2],
}

impl CalibratedMachine {
    /// The volumetric error over the volume that the axes were measured in.
    ///
    /// Figures are over all places; shares and intervals over at most a thousand of them. With `s` the figure of the
    /// errors as calibrated and `s*` that of the same errors with a draw of the calibration's covariance on top, the
    /// interval is the basic bootstrap's, `[2s - s*₀.₉₇₅, 2s - s*₀.₀₂₅]`, not below 0 (A. C. Davison, D. V. Hinkley,
    /// *Bootstrap Methods and their Application*, 5.2): it takes the bias out that `s* - s` shows.
    ///
    /// A share is the mean of `c_i · e` over that of `e · e`, with the first-order contribution `c_i` of a component
    /// to the sum `e`. Shares add up to one; one that is negative takes away from what others make.
    pub fn volume(&self, settings: &VolumeSettings) -> Volume {
        let tool_mm = settings.tool_home_mm;
        let places = self.places(settings.points, tool_mm);
        let at_home = vec![0.0; self.machine.axes().len()];
        let home = self.machine.tool_error(self, &at_home, tool_mm);
        let zero = zeroing(&home);

        let numbers = (0..places.count()).into_par_iter();
        let seen = numbers.map(|i| self.seen(&places.at(i), tool_mm));
        let (nominal, errors): (Vec<_>, Vec<_>) = seen.unzip();
        let whole = figures(&nominal, &RigidFit::new(&nominal), &errors, &zero);
        let size = |i: &usize| (errors[*i] - zero).fixed_rows::<3>(0).norm();
        let worst = (0..errors.len()).max_by(|a, b| size(a).total_cmp(&size(b)));
        let worst = worst.unwrap_or(0);

        let chosen: Vec<usize> = places.some(MOST_DRAWN).collect();
        let of_home = self.coefficients(&at_home, tool_mm);
        let coefficients = chosen.par_iter();
        let coefficients = coefficients.map(|&i| self.coefficients(&places.at(i), tool_mm));
        let subset = Subset {
            points: chosen.iter().map(|&i| nominal[i]).collect(),
            errors: chosen.iter().map(|&i| errors[i]).collect(),
            coefficients: coefficients.collect(),
            of_home,
            home: zero,
        };
        let drawn = subset.drawn(self, settings);
        let values = whole.to_array();
        let figure = |k: usize| Figure::new(values[k], drawn.as_ref().map(|drawn| drawn[k]));
        let figures = Figures::from_array(std::array::from_fn(figure));
        Volume {
            worst: places.at(worst),
            worst_error: MotionError::from_vector(&(errors[worst] - zero)),
            shares: subset.shares(self),
            home,
            figures,
            places,
        }
    }

    /// The nominal point on the workpiece, mm, and the error.
    fn seen(&self, positions: &[f64], tool_mm: Point3<f64>) -> (Point3<f64>, Vector6<f64>) {
        let nominal = self.machine.tool_in_workpiece(&Ideal, positions) * tool_mm;
        let error = self.machine.tool_error(self, positions, tool_mm);
        (nominal, error.to_vector())
    }
}

/// What is subtracted: the displacement at home.
pub(crate) fn zeroing(home: &MotionError) -> Vector6<f64> {
    MotionError::new(home.translation_mm, Vector3::zeros()).to_vector()
}

impl Figure {
    /// With the interval about the value of all places; it was drawn about that of some.
    fn new(value: f64, mut drawn: Option<Drawn>) -> Self {
        if let Some(drawn) = &mut drawn {
            drawn.interval = drawn.interval.map(|off| (value + off).max(0.0));
        }
        Self { value, drawn }
    }
}

/// Some of the places, with how their errors depend on the results.
struct Subset {
    points: Vec<Point3<f64>>,
    errors: Vec<Vector6<f64>>,
    coefficients: Vec<Coefficients>,
    of_home: Coefficients,
    home: Vector6<f64>,
}

impl Subset {
    /// For each figure its bias, and the interval relative to the value.
    fn drawn(&self, machine: &CalibratedMachine, settings: &VolumeSettings) -> Option<Vec<Drawn>> {
        let root = Root::new(machine).filter(|_| machine.has_uncertainties)?;
        let fit = RigidFit::new(&self.points);
        let value = figures(&self.points, &fit, &self.errors, &self.home).to_array();
        let draws = (0..settings.draws).into_par_iter().map(|number| {
            let changes = root.draw(settings.seed, number as u64);
            let errors = self.errors.iter().zip(&self.coefficients);
            let errors: Vec<Vector6<f64>> = errors
                .map(|(error, coefficients)| error + applied(coefficients, &changes))
                .collect();
            let home = MotionError::from_vector(&applied(&self.of_home, &changes));
            let home = self.home + zeroing(&home);
            figures(&self.points, &fit, &errors, &home).to_array()
        });
        let draws: Vec<[f64; 12]> = draws.collect();
        let of_figure = |k: usize| {
            let mut off: Vec<f64> = draws.iter().map(|draw| draw[k] - value[k]).collect();
            off.sort_by(f64::total_cmp);
            let [low, high] = INTERVAL.map(|share| off[percentile_place(share, off.len())]);
            Drawn {
                bias: off.iter().sum::<f64>() / off.len() as f64,
                interval: [-high, -low],
            }
        };
        (!draws.is_empty()).then(|| (0..value.len()).map(of_figure).collect())
    }

    /// Share of each component in the mean square.
    fn shares(&self, machine: &CalibratedMachine) -> Vec<(String, f64)> {
        let (values, (names, part_of)) = (machine.values(), machine.parts());
        let by_part = |coefficients: &Coefficients| {
            let mut sums = vec![Vector3::<f64>::zeros(); names.len()];
            for (place, c) in coefficients {
                sums[part_of[*place]] += c.fixed_rows::<3>(0) * values[*place];
            }
            sums
        };
        let at_home = by_part(&self.of_home);
        let mut products = vec![0.0; names.len()];
        for coefficients in &self.coefficients {
            let mut sums = by_part(coefficients);
            sums.iter_mut()
                .zip(&at_home)
                .for_each(|(sum, home)| *sum -= home);
            let whole: Vector3<f64> = sums.iter().sum();
            let terms = products.iter_mut().zip(&sums);
            terms.for_each(|(product, part)| *product += part.dot(&whole));
        }
        let square: f64 = products.iter().sum();
        let share = |product: &f64| if square > 0.0 { product / square } else { 0.0 };
        names.into_iter().zip(products.iter().map(share)).collect()
    }
}
