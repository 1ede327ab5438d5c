//! Random numbers of a campaign: one seed, a stream for each purpose.

use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal, StudentT};

/// What random numbers are for. Streams of one seed are independent, so that the same machine can be
/// measured with and without a disturbance under the same noise.
#[derive(Debug, Clone, Copy)]
pub(super) enum Purpose {
    /// True geometry of machine, targets and stations.
    Setup,
    /// Return errors and noise of the lengths.
    Noise,
    /// How the shape of a disturbance differs from the ideal one.
    Shape,
    /// Subject, direction, size and instants of a disturbance; each name has its number.
    Hidden(u64),
}

impl Purpose {
    fn stream(self) -> u64 {
        match self {
            Self::Setup => 0,
            Self::Noise => 1,
            Self::Shape => 2,
            Self::Hidden(number) => 3 + number,
        }
    }
}

/// A stream of random numbers.
pub(super) struct Random(ChaCha8Rng);

impl Random {
    pub(super) fn new(seed: u64, purpose: Purpose) -> Self {
        let mut generator = ChaCha8Rng::seed_from_u64(seed);
        generator.set_stream(purpose.stream());
        Self(generator)
    }

    /// Uniform in an interval.
    pub(super) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.0.random::<f64>()
    }

    /// One of `count` indices; `count` must not be 0.
    pub(super) fn index(&mut self, count: usize) -> usize {
        self.0.random_range(0..count)
    }

    /// Whether an event of this probability happens.
    pub(super) fn happens(&mut self, probability: f64) -> bool {
        self.0.random::<f64>() < probability
    }

    /// +1 or -1.
    pub(super) fn sign(&mut self) -> f64 {
        if self.happens(0.5) { 1.0 } else { -1.0 }
    }

    /// Standard normal.
    pub(super) fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.0)
    }

    /// Student's with four degrees of freedom, scaled to a standard deviation of one.
    pub(super) fn student(&mut self) -> f64 {
        let drawn: f64 = StudentT::new(4.0)
            .expect("four degrees of freedom")
            .sample(&mut self.0);
        drawn / f64::sqrt(2.0)
    }

    /// Three of them.
    pub(super) fn normal_vector(&mut self) -> Vector3<f64> {
        Vector3::from_fn(|_, _| self.normal())
    }

    /// A vector of this length, uniform over the sphere of directions.
    pub(super) fn vector(&mut self, length: f64) -> Vector3<f64> {
        let v = self.normal_vector();
        v * (length / v.norm())
    }
}
