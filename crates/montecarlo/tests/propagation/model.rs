//! Models and input distributions of the examples.

use rand::RngExt;
use rand_distr::{ChiSquared, Distribution, StandardNormal};
use trueaxis_montecarlo::{ChaCha8Rng, Model};

/// A model that needs no workspace.
struct Trial<F, const N: usize>(F);

/// A model of one trial as a function from inputs drawn to outputs.
pub(crate) fn model_of<F, const N: usize>(trial: F) -> impl Model
where
    F: Fn(&mut ChaCha8Rng) -> [f64; N] + Sync,
{
    Trial(trial)
}

impl<F: Fn(&mut ChaCha8Rng) -> [f64; N] + Sync, const N: usize> Model for Trial<F, N> {
    type Workspace = ();

    fn outputs(&self) -> usize {
        N
    }

    fn workspace(&self) {}

    fn trial(&self, rng: &mut ChaCha8Rng, _: &mut (), outputs: &mut [f64]) {
        outputs.copy_from_slice(&self.0(rng));
    }
}

/// Gaussian N(mean, u²) (JCGM 101, 6.4.7).
pub(crate) fn gaussian(rng: &mut ChaCha8Rng, mean: f64, u: f64) -> f64 {
    let deviate: f64 = StandardNormal.sample(rng);
    mean + u * deviate
}

/// Rectangular R(a, b) (6.4.2).
pub(crate) fn rectangular(rng: &mut ChaCha8Rng, a: f64, b: f64) -> f64 {
    a + (b - a) * rng.random::<f64>()
}

/// Curvilinear trapezoid CTrap(a, b, d): limits known to ±d (6.4.3).
pub(crate) fn curvilinear_trapezoid(rng: &mut ChaCha8Rng, a: f64, b: f64, d: f64) -> f64 {
    let low = rectangular(rng, a - d, a + d);
    let high = (a + b) - low;
    rectangular(rng, low, high)
}

/// Arc sine (U-shaped) U(a, b) (6.4.6).
pub(crate) fn arc_sine(rng: &mut ChaCha8Rng, a: f64, b: f64) -> f64 {
    let angle = std::f64::consts::TAU * rng.random::<f64>();
    0.5 * (a + b) + 0.5 * (b - a) * angle.sin()
}

/// Scaled and shifted t-distribution; `chi_squared` has its degrees of freedom (6.4.9).
pub(crate) fn student(rng: &mut ChaCha8Rng, t: &Student) -> f64 {
    let w = t.chi_squared.sample(rng);
    gaussian(rng, t.location, t.scale * (t.degrees / w).sqrt())
}

/// Parameters of a t-distribution.
pub(crate) struct Student {
    degrees: f64,
    location: f64,
    scale: f64,
    chi_squared: ChiSquared<f64>,
}

impl Student {
    pub(crate) fn new(degrees: f64, location: f64, scale: f64) -> Self {
        Self {
            degrees,
            location,
            scale,
            chi_squared: ChiSquared::new(degrees).unwrap(),
        }
    }
}

/// Multivariate Gaussian N(mean, V) of three quantities by V = R Rᵀ (6.4.8).
pub(crate) struct Gaussian3 {
    mean: [f64; 3],
    r: [[f64; 3]; 3],
}

impl Gaussian3 {
    pub(crate) fn new(mean: [f64; 3], covariance: [[f64; 3]; 3]) -> Self {
        let mut r = [[0.0; 3]; 3];
        for i in 0..3 {
            for k in 0..=i {
                let known: f64 = (0..k).map(|m| r[i][m] * r[k][m]).sum();
                let rest: f64 = covariance[i][k] - known;
                r[i][k] = if i == k { rest.sqrt() } else { rest / r[k][k] };
            }
        }
        Self { mean, r }
    }

    pub(crate) fn draw(&self, rng: &mut ChaCha8Rng) -> [f64; 3] {
        let z = [(); 3].map(|()| gaussian(rng, 0.0, 1.0));
        let deviation = |i: usize| (0..=i).map(|k| self.r[i][k] * z[k]).sum::<f64>();
        [0, 1, 2].map(|i| self.mean[i] + deviation(i))
    }
}
