//! The nine equations in closed form: least squares for three targets, all coordinates equally
//! well known.
//!
//! With the centroid `c`, the offsets `s_j = r_j - c` (`Σ s_j = 0`) and the mean `Δ_c` of the
//! volumetric errors, the normal equations of `Δ_j = δ + ε × r_j` part into a translation and a
//! rotation:
//!
//! ```text
//! δ = Δ_c - ε × c        J ε = m        m = Σ s_j × Δ_j        J = Σ (|s_j|² I - s_j s_jᵀ)
//! ```
//!
//! `J` is the inertia of three equal masses. They lie in a plane, so with the sides
//! `a = r_Q - r_P`, `b = r_K - r_P`, `b - a` and the normal `N = a × b` its inverse is
//!
//! ```text
//! J⁻¹ = ( a aᵀ + b bᵀ + (b-a)(b-a)ᵀ + 3 N Nᵀ / (|a|² + |b|² + |b-a|²) ) / |N|²
//! ```
//!
//! (In the plane `J` is the adjugate of `S = Σ s_j s_jᵀ`, whose inverse is `S / det S`, with
//! `3 S` the sum over the sides and `3 det S = |N|²`; across it `J` is `tr S`.) `|N|` comes from
//! the sides without a difference of products of large numbers, so thin triangles lose no more
//! digits than by orthogonal factors of the equations.

use nalgebra::{Matrix3, Matrix6x3, Vector3};
use trueaxis_kinematics::MotionError;
use trueaxis_leastsquares::{LANES, Lanes};

use crate::Error;
use crate::coordinates::{Coordinates, Number};
use crate::design::{Extent, GEOMETRY_TOL, require_finite};

const THIRD: f64 = 1.0 / 3.0;

/// The six component errors of a step by least squares over its nine equations: what
/// [`crate::nine`] and [`Operator::apply`](crate::Operator::apply) give, for targets that are at
/// other places (or turned) at every step. Nothing is allocated.
///
/// `r` holds the generalised coordinates of P, Q, K relative to the reference point of δ, `delta`
/// their volumetric errors (measured minus ideal position), mm. What is not finite in `delta` is
/// not finite in the result.
///
/// # Errors
/// [`Error::NotFinite`], [`Error::Collinear`] as [`crate::nine`].
///
/// ```
/// use nalgebra::Vector3;
/// use trueaxis_identify::{nine, nine_closed_form};
///
/// let r = [[0.0, 150.0, 0.0], [200.0, 0.0, 50.0], [0.0, -120.0, 90.0]].map(Vector3::from);
/// let delta = [[1e-3, 0.0, 2e-3], [0.0, 3e-3, 1e-3], [2e-3, 1e-3, 0.0]].map(Vector3::from);
/// let difference = nine_closed_form(&r, &delta)?.to_vector() - nine(&r)?.apply(&delta).to_vector();
/// assert!(difference.norm() < 1e-15);
/// # Ok::<(), trueaxis_identify::Error>(())
/// ```
pub fn nine_closed_form(
    r: &[Vector3<f64>; 3],
    delta: &[Vector3<f64>; 3],
) -> Result<MotionError, Error> {
    let delta = delta.map(|delta| Coordinates(delta.into()));
    let [translation, rotation] = ThreeTargets::new(r)?.motion(&delta).map(|v| v.0.into());
    Ok(MotionError::new(translation, rotation))
}

/// Three targets that span a plane.
pub(crate) struct ThreeTargets<T> {
    centroid_mm: Coordinates<T>,
    /// From P to Q, and from P to K.
    sides_mm: [Coordinates<T>; 2],
    /// `a × b`.
    normal_mm2: Coordinates<T>,
    /// Sum of the squares of all three sides.
    squares_mm2: T,
    /// `1 / |N|²`, mm⁻⁴.
    inverse_square: T,
}

/// `|N|²`, and what it must exceed, mm⁴.
pub(crate) struct Span<T> {
    square: T,
    least: T,
}

impl Span<f64> {
    #[inline(always)]
    pub(crate) fn is_plane(&self) -> bool {
        self.square > self.least && self.square < f64::INFINITY
    }
}

impl Span<Lanes> {
    #[inline(always)]
    fn of_lane(&self, k: usize) -> Span<f64> {
        Span {
            square: self.square.0[k],
            least: self.least.0[k],
        }
    }

    /// Whether it is in all lanes.
    #[inline(always)]
    pub(crate) fn is_plane(&self) -> bool {
        // Without a branch for each lane.
        (0..LANES).fold(true, |all, k| all & self.of_lane(k).is_plane())
    }
}

impl ThreeTargets<f64> {
    /// # Errors
    /// [`Error::NotFinite`], [`Error::Collinear`].
    pub(crate) fn new(r: &[Vector3<f64>; 3]) -> Result<Self, Error> {
        let (targets, span) = Self::unchecked(&r.map(|r| Coordinates(r.into())));
        if span.is_plane() {
            return Ok(targets);
        }
        require_finite("position", r)?;
        Err(Extent::of(r).collinear())
    }

    /// From P to Q, and from P to K.
    pub(crate) fn sides_mm(&self) -> [Vector3<f64>; 2] {
        self.sides_mm.map(|side| side.0.into())
    }

    /// Unit normal of the plane.
    pub(crate) fn normal(&self) -> Vector3<f64> {
        Vector3::from(self.normal_mm2.0) * self.inverse_square.sqrt()
    }

    /// The columns of the operator that belong to each target:
    /// `ε = J⁻¹ Σ s_j × Δ_j` and `δ = Δ_c + c × ε`.
    pub(crate) fn blocks(&self) -> [Matrix6x3<f64>; 3] {
        let [a, b] = self.sides_mm();
        let offsets = [-(a + b), a * 2.0 - b, b * 2.0 - a].map(|sum| sum / 3.0);
        offsets.map(|offset| {
            let turned_by = |delta: Vector3<f64>| {
                let moment = Coordinates(offset.cross(&delta).into());
                Vector3::from(self.inverse_inertia_times(&moment).0)
            };
            let rotation =
                Matrix3::from_columns(&[Vector3::x(), Vector3::y(), Vector3::z()].map(turned_by));
            let centroid_mm = Vector3::from(self.centroid_mm.0);
            let translation = Matrix3::identity() / 3.0 + centroid_mm.cross_matrix() * rotation;
            let mut block = Matrix6x3::zeros();
            block.fixed_rows_mut::<3>(0).copy_from(&translation);
            block.fixed_rows_mut::<3>(3).copy_from(&rotation);
            block
        })
    }
}

impl<T: Number> ThreeTargets<T> {
    /// Means nothing if the targets do not span a plane.
    #[inline(always)]
    pub(crate) fn unchecked(r: &[Coordinates<T>; 3]) -> (Self, Span<T>) {
        let [p, q, k] = *r;
        let (a, b) = (q - p, k - p);
        let c = b - a;
        let squares = [a.dot(&a), b.dot(&b), c.dot(&c)];
        let normal_mm2 = a.cross(&b);
        let square = normal_mm2.dot(&normal_mm2);
        // The distance of the third target from the longest side is |N| over its length.
        let longest_mm2 = squares[0].larger(squares[1]).larger(squares[2]);
        let least = T::of(GEOMETRY_TOL) * longest_mm2;
        let targets = Self {
            centroid_mm: p + (a + b) * T::of(THIRD),
            sides_mm: [a, b],
            normal_mm2,
            squares_mm2: squares[0] + squares[1] + squares[2],
            inverse_square: T::of(1.0) / square,
        };
        let least = least * least;
        (targets, Span { square, least })
    }

    /// The translation δ and the rotation ε that fit the volumetric errors best.
    #[inline(always)]
    pub(crate) fn motion(&self, delta: &[Coordinates<T>; 3]) -> [Coordinates<T>; 2] {
        let [delta_p, delta_q, delta_k] = *delta;
        let [a, b] = self.sides_mm;
        let (u, v) = (delta_q - delta_p, delta_k - delta_p);
        // Σ s_j × Δ_j with s_Q = (2a - b)/3, s_K = (2b - a)/3 and s_P the rest.
        let moment = (a.cross(&(u + u - v)) + b.cross(&(v + v - u))) * T::of(THIRD);
        let rotation = self.inverse_inertia_times(&moment);
        let mean = delta_p + (u + v) * T::of(THIRD);
        [mean - rotation.cross(&self.centroid_mm), rotation]
    }

    /// `J⁻¹ m`.
    #[inline(always)]
    fn inverse_inertia_times(&self, m: &Coordinates<T>) -> Coordinates<T> {
        let [a, b] = self.sides_mm;
        let (along_a, along_b) = (a.dot(m), b.dot(m));
        // (b - a) ((b - a)·m) is taken apart into multiples of a and b.
        let difference = along_b - along_a;
        let in_plane = a * (along_a - difference) + b * (along_b + difference);
        let share = T::of(3.0) * self.normal_mm2.dot(m) / self.squares_mm2;
        (in_plane + self.normal_mm2 * share) * self.inverse_square
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nine;
    use crate::nine::whitened;
    use nalgebra::DMatrix;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// The same by orthogonal factors of the nine equations.
    fn by_qr(r: &[Vector3<f64>; 3], delta: &[Vector3<f64>; 3]) -> MotionError {
        whitened(r, DMatrix::identity(9, 9)).unwrap().apply(delta)
    }

    fn assert_close(found: &MotionError, expected: &MotionError, relative: f64) {
        let parts = [
            (found.translation_mm, expected.translation_mm),
            (found.rotation_rad, expected.rotation_rad),
        ];
        for (found, expected) in parts {
            let difference = (found - expected).norm() / expected.norm();
            assert!(difference < relative, "{found} {expected}: {difference:e}");
        }
    }

    fn random(rng: &mut ChaCha8Rng, size: f64) -> Vector3<f64> {
        Vector3::from_fn(|_, _| rng.random_range(-size..size))
    }

    #[test]
    fn equals_orthogonal_factors() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        for _ in 0..2_000 {
            let r = [(); 3].map(|()| random(&mut rng, 400.0));
            let delta = [(); 3].map(|()| random(&mut rng, 0.01));
            // Random triangles are up to some hundred times as long as wide.
            let expected = by_qr(&r, &delta);
            assert_close(&nine_closed_form(&r, &delta).unwrap(), &expected, 1e-12);
            assert_close(&nine(&r).unwrap().apply(&delta), &expected, 1e-12);
        }
    }

    /// The third target is off the line of the others by a small part of their distance: digits are
    /// lost by its inverse, not by its square.
    #[test]
    fn thin_triangles_keep_what_can_be_known() {
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        for part in [1e-2, 1e-4, 1e-5] {
            for _ in 0..100 {
                let (start, along) = (random(&mut rng, 400.0), random(&mut rng, 400.0));
                let across = along.cross(&random(&mut rng, 1.0)).normalize() * along.norm();
                let middle = start + along * rng.random::<f64>() + across * part;
                let r = [start, middle, start + along];
                let delta = [(); 3].map(|()| random(&mut rng, 0.01));
                let allowed = 1e-13 / part;
                let found = nine_closed_form(&r, &delta).unwrap();
                assert_close(&found, &by_qr(&r, &delta), allowed);
            }
        }
    }

    #[test]
    fn refuses_what_the_operator_refuses() {
        let line = [0.0, 1.0, 3.0].map(|t| Vector3::new(5.0, -2.0, 1.0) * t);
        let delta = [Vector3::zeros(); 3];
        assert_eq!(
            nine_closed_form(&line, &delta).unwrap_err(),
            nine(&line).unwrap_err()
        );
        for wrong in [f64::NAN, f64::INFINITY] {
            let mut r = [Vector3::x(), Vector3::y(), Vector3::z()];
            r[1].z = wrong;
            let quantity = "position";
            let refused = Err(Error::NotFinite {
                quantity,
                target: 1,
            });
            assert_eq!(nine_closed_form(&r, &delta), refused);
        }
    }
}
