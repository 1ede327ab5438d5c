//! The random part of a length.

use nalgebra::Vector3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use serde::Serialize;
use trueaxis_kinematics::MICROMETRE;

use crate::check;
use crate::{Error, Problem, Scenario};

/// True standard deviations of the simulated noise.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Noise {
    /// Constant part `a` of a length's standard deviation `√(a² + (b l)²)`, µm.
    pub length_sigma_um: f64,
    /// Proportional part `b`, µm per m of the distance from station to target.
    pub length_sigma_ppm: f64,
    /// Standard deviation per coordinate of the position that the machine returns to at a stop,
    /// µm; common to the targets measured there.
    pub repeatability_um: f64,
}

impl Noise {
    /// The noise of a scenario: its own, else what the instrument declares, else none.
    pub(crate) fn of(scenario: &Scenario) -> Result<Self, Error> {
        let (noise, declared) = (&scenario.noise, &scenario.instrument);
        let sigma = |name, own, declared| check::sigma("noise", name, own, declared);
        let (a, a_declared) = (noise.length_sigma_um, declared.length_sigma_um);
        let (b, b_declared) = (noise.length_sigma_ppm, declared.length_sigma_ppm);
        let (m, m_declared) = (noise.repeatability_um, declared.repeatability_um);
        let true_noise = Self {
            length_sigma_um: sigma("length_sigma_um", a, a_declared)?,
            length_sigma_ppm: sigma("length_sigma_ppm", b, b_declared)?,
            repeatability_um: sigma("repeatability_um", m, m_declared)?,
        };
        if noise.exact && !true_noise.is_zero() {
            return Err(Problem::ExactWithNoise { noise: true_noise }.at("noise.exact"));
        }
        Ok(true_noise)
    }

    /// Whether there is none.
    pub fn is_zero(&self) -> bool {
        let largest = self.length_sigma_um.max(self.length_sigma_ppm);
        largest.max(self.repeatability_um) <= 0.0
    }

    /// Standard deviation of a length over `distance_mm`, mm.
    pub fn length_sigma_mm(&self, distance_mm: f64) -> f64 {
        let proportional_um = self.length_sigma_ppm * distance_mm * 1e-3;
        self.length_sigma_um.hypot(proportional_um) * MICROMETRE
    }

    /// Standard deviation per coordinate of the machine's position, mm.
    pub fn repeatability_mm(&self) -> f64 {
        self.repeatability_um * MICROMETRE
    }
}

/// Normal deviates. Each stop, and each part that is drawn once for a campaign, has its own stream, so
/// that they do not depend on the order in which stops are simulated, nor on the size of the noise.
pub(crate) struct Deviates(ChaCha8Rng);

/// What is drawn once for a campaign.
#[derive(Clone, Copy)]
pub(crate) enum Part {
    Reflectors,
    Scale,
    Nests,
    DeadPaths,
    KnownLengths,
    AxisTemperatures,
    /// By its number.
    Thermometer(usize),
}

impl Deviates {
    /// The deviates of stop number `stop` under `seed`.
    pub(crate) fn of_stop(seed: u64, stop: u64) -> Self {
        let mut generator = ChaCha8Rng::seed_from_u64(seed);
        generator.set_stream(stop);
        Self(generator)
    }

    /// The deviates of a part under `seed`: streams from the other end, where no stop comes.
    pub(crate) fn of_part(seed: u64, part: Part) -> Self {
        let number = match part {
            Part::Reflectors => 0,
            Part::Scale => 1,
            Part::Nests => 2,
            Part::DeadPaths => 3,
            Part::KnownLengths => 4,
            Part::AxisTemperatures => 5,
            Part::Thermometer(number) => 6 + number as u64,
        };
        Self::of_stop(seed, u64::MAX - number)
    }

    /// The next standard normal deviate.
    pub(crate) fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.0)
    }

    /// The next three.
    pub(crate) fn normal_vector(&mut self) -> Vector3<f64> {
        Vector3::from_fn(|_, _| self.normal())
    }
}
