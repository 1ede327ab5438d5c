//! A disturbance: a smooth process of unknown form.
//!
//! Something (the machine, the tripods, the air, a station, a target, the lost motion of an axis) moves with time, or
//! with the position of an axis, in a course that nobody knows. Over the argument `x`, 0 to 1, each coordinate is
//!
//! ```text
//! f(x) = Σ_k b_k cos(kπx)      b_k ~ N(0, w² S_k)      S_k ~ (3/ℓ² + k²π²)⁻²      S_0 + ½ Σ S_k = 1
//! ```
//!
//! a process with Matérn's covariance (ν = 3/2) of correlation length `ℓ` and standard deviation `w` in the basis of
//! half waves (Solin and Särkkä 2020), so that a dozen columns for each coordinate are all that is needed. `ℓ` is one
//! of a few, equally likely beforehand, none shorter than three stops: what is shorter is repeatability.
//!
//! | who | what moves | with | basis for each coordinate |
//! | --- | --- | --- | --- |
//! | machine | three translations | time, in each occupation of a station | 13 |
//! | all tripods | three translations each | time, in each occupation | 13 |
//! | air | the scale of the lengths | time, in each occupation | 13 |
//! | station | three translations and the dead path | time in its occupation | 13 |
//! | station | the dead path | position of the axis that runs | 13 |
//! | target | three translations | time | 17 |
//! | target | three translations | position of the axis that runs | 7 |
//! | axis | lost motion | position, by side of approach | 9 |
//!
//! An axis over position is none: the base model's free poses take it. Without targets on the bed the machine in time
//! and all tripods in time are one thing under two names, and always given as two.

use trueaxis_campaign::Direction;
use trueaxis_effects::{Effect, Layer, Subject, effect};
use trueaxis_leastsquares::{half_waves, matern_roots};
use trueaxis_multilateration::Solution;
use trueaxis_poses::LengthCircumstances as Reading;

use crate::engine::correlation_lengths;
use crate::lengths::base::Base;
use crate::lengths::omnibus::travelled;

/// What wanders, and with what.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Wanderer {
    pub(crate) who: Who,
    pub(crate) with: With,
}

/// What wanders.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Who {
    Machine,
    Tripods,
    Air,
    Station(usize),
    Target(usize),
    Axis(usize),
}

/// What it varies with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum With {
    /// Time in the occupation of a station, each occupation for itself.
    Occupation,
    /// Time from the first to the last length.
    Campaign,
    /// Position of the axis that runs, each axis for itself.
    Position,
    /// Position of an axis, opposite from the two sides of approach.
    Sides,
}

/// A disturbance with its size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Disturbance {
    pub(crate) wanderer: Wanderer,
    /// ℓ, as a part of the range of the argument.
    pub(crate) length: f64,
    /// w, in the unit of what moves (µm, ppm, arcsec).
    pub(crate) width: f64,
}

/// Every disturbance that a campaign's lengths may show.
pub(crate) fn wanderers(base: &Base<'_>) -> Vec<Wanderer> {
    let scene = &base.scene;
    let mut all = vec![(Who::Machine, With::Occupation)];
    if scene.targets.iter().any(|target| target.carrier.is_none()) {
        all.push((Who::Tripods, With::Occupation));
    }
    all.push((Who::Air, With::Occupation));
    for station in 0..scene.stations.len() {
        all.push((Who::Station(station), With::Occupation));
        all.push((Who::Station(station), With::Position));
    }
    for target in 0..scene.targets.len() {
        all.push((Who::Target(target), With::Campaign));
        all.push((Who::Target(target), With::Position));
    }
    let back = |r: &&Reading| r.direction == Direction::Backward;
    let mut both: Vec<usize> = base.readings.iter().filter(back).map(|r| r.axis).collect();
    both.sort_unstable();
    both.dedup();
    all.extend(both.into_iter().map(|axis| (Who::Axis(axis), With::Sides)));
    let wanderer = |(who, with)| Wanderer { who, with };
    all.into_iter().map(wanderer).collect()
}

impl Wanderer {
    /// Whose it is.
    pub(crate) fn layer(self) -> Layer {
        match self.who {
            Who::Machine | Who::Axis(_) => Layer::Machine,
            Who::Tripods | Who::Target(_) => Layer::Setup,
            Who::Station(_) if self.with == With::Occupation => Layer::Setup,
            Who::Air | Who::Station(_) => Layer::Instrument,
        }
    }

    /// Station, target and axis; none for what concerns all.
    pub(crate) fn subject(self) -> Subject {
        match self.who {
            Who::Machine | Who::Tripods | Who::Air => Subject::default(),
            Who::Station(station) => Subject::station(station),
            Who::Target(target) => Subject::target(target),
            Who::Axis(axis) => Subject {
                axis: Some(axis),
                ..Subject::default()
            },
        }
    }

    /// The other name of the same columns, if it has one.
    pub(crate) fn twin(self, base: &Base<'_>) -> Option<Self> {
        let has_bed = base.scene.targets.iter().any(|t| t.carrier.is_none());
        (self.who == Who::Machine && !has_bed).then_some(Self {
            who: Who::Tripods,
            ..self
        })
    }

    /// Number of wanderers of the same kind, which share what is believed beforehand.
    pub(crate) fn of_kind(self, base: &Base<'_>) -> usize {
        match self.who {
            Who::Machine | Who::Tripods | Who::Air => 1,
            Who::Station(_) => base.scene.stations.len(),
            Who::Target(_) => base.scene.targets.len(),
            Who::Axis(_) => base.scene.machine.axes().len(),
        }
    }

    /// Effects of the catalogue that move it as it moves, with the number of the parameter.
    pub(crate) fn coordinates(self) -> Vec<(&'static Effect, usize)> {
        let moved: &[(&str, usize)] = match (self.who, self.with) {
            (Who::Machine, _) => &[("machine_shift", 3)],
            (Who::Tripods, _) => &[("station_jump", 3)],
            (Who::Air, _) => &[("station_scale", 1)],
            (Who::Station(_), With::Position) => &[("dead_path_jump", 1)],
            (Who::Station(_), _) => &[("station_jump", 3), ("dead_path_jump", 1)],
            (Who::Target(_), _) => &[("target_slip", 3)],
            (Who::Axis(_), _) => &[("backlash", 1)],
        };
        let known = moved
            .iter()
            .filter_map(|(id, count)| Some((effect(id)?, *count)));
        known
            .flat_map(|(effect, count)| (0..count).map(move |k| (effect, k)))
            .collect()
    }

    /// Half waves of each coordinate, beside the constant.
    fn waves(self) -> u32 {
        match (self.who, self.with) {
            (Who::Target(_), With::Position) => 6,
            (_, With::Occupation | With::Position) => 12,
            (_, With::Campaign) => 16,
            (_, With::Sides) => 8,
        }
    }

    /// Which of several courses a reading belongs to (occupation, axis), and its argument, 0 to 1.
    fn place(self, base: &Base<'_>, reading: &Reading) -> (usize, f64) {
        match self.with {
            With::Occupation => (reading.station, reading.occupation_progress),
            With::Campaign => {
                let (first, last) = (base.span_s[0], base.span_s[1]);
                (
                    0,
                    (reading.time_s - first) / (last - first).max(f64::MIN_POSITIVE),
                )
            }
            With::Position => (reading.axis, travelled(base, reading)),
            With::Sides => (0, travelled(base, reading)),
        }
    }

    fn concerns(self, reading: &Reading) -> bool {
        match self.who {
            Who::Machine | Who::Tripods | Who::Air => true,
            Who::Station(station) => reading.station == station,
            Who::Target(target) => reading.target == target,
            Who::Axis(axis) => reading.axis == axis,
        }
    }

    /// The courses that it has: occupations or axes.
    pub(crate) fn courses(self, base: &Base<'_>) -> Vec<usize> {
        let own = base.readings.iter().filter(|r| self.concerns(r));
        let mut courses: Vec<usize> = own.map(|r| self.place(base, r).0).collect();
        courses.sort_unstable();
        courses.dedup();
        courses
    }

    /// Correlation lengths that are tried.
    pub(crate) fn lengths(self, base: &Base<'_>) -> Vec<f64> {
        let stops = base.network.visits.len();
        let stops = match self.with {
            With::Campaign => stops,
            _ => stops / base.scene.stations.len().max(1),
        };
        correlation_lengths(stops)
    }

    /// `S_k^½` for each column.
    pub(crate) fn roots_of_spectrum(self, base: &Base<'_>, length: f64) -> Vec<f64> {
        let times = self.courses(base).len() * self.coordinates().len();
        let of_one = matern_roots(length, self.waves());
        of_one
            .iter()
            .copied()
            .cycle()
            .take(times * of_one.len())
            .collect()
    }

    /// `1, cos(πx), ...`.
    pub(crate) fn basis(self, x: f64) -> impl Iterator<Item = f64> {
        std::iter::once(1.0).chain(half_waves(x, self.waves()))
    }

    /// What a unit of each coefficient does to the lengths, mm: course after course, coordinate after coordinate.
    pub(crate) fn columns_mm(self, base: &Base<'_>, solution: &Solution) -> Vec<Vec<f64>> {
        let courses = self.courses(base);
        let coordinates = self.coordinates();
        let subject = self.subject();
        let width = self.waves() as usize + 1;
        let count = courses.len() * coordinates.len() * width;
        let mut columns = vec![vec![0.0; base.readings.len()]; count];
        let mut waves = Vec::with_capacity(width);
        for (i, reading) in base.readings.iter().enumerate() {
            if !self.concerns(reading) {
                continue;
            }
            let (course, x) = self.place(base, reading);
            let Ok(course) = courses.binary_search(&course) else {
                continue;
            };
            let observation = base.observation(reading, solution);
            waves.clear();
            waves.extend(self.basis(x));
            for (c, (effect, k)) in coordinates.iter().enumerate() {
                let moved = effect.form(&subject, *k, f64::NEG_INFINITY, &observation.at);
                let along = moved.along(&observation.beam);
                let first = (course * coordinates.len() + c) * width;
                for (column, wave) in columns[first..].iter_mut().zip(&waves) {
                    column[i] = wave * along;
                }
            }
        }
        columns
    }
}

impl Disturbance {
    /// The same for a unit of the standard deviation that each coefficient has beforehand, mm.
    pub(crate) fn columns_mm(&self, base: &Base<'_>, solution: &Solution) -> Vec<Vec<f64>> {
        let mut columns = self.wanderer.columns_mm(base, solution);
        let roots = self.wanderer.roots_of_spectrum(base, self.length);
        for (column, root) in columns.iter_mut().zip(roots) {
            column.iter_mut().for_each(|x| *x *= self.width * root);
        }
        columns
    }
}
