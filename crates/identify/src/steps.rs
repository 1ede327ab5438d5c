//! The steps of a run at once: eight side by side, one in each lane.
//!
//! A step alone is too small for wide registers. Steps lie one after the other as they are measured;
//! eight of them are taken apart into coordinates, worked on in lanes, and put together again. Nothing
//! is allocated, and no operation is fused: results are the same bits with any instruction set.
//! [`Arch::dispatch`] takes the widest that the processor has.

use nalgebra::{Matrix6x3, Vector3};
use pulp::{Arch, Simd, WithSimd};
use trueaxis_kinematics::MotionError;
use trueaxis_leastsquares::{LANES, Lanes};

use crate::coordinates::Coordinates;
use crate::three_targets::ThreeTargets;
use crate::{Operator, StepError};

/// Three vectors of one step: of P, Q, K.
type Step = [Vector3<f64>; 3];

impl Operator {
    /// [`Operator::apply`] for many steps of one geometry: those of a linear axis. The same bits.
    ///
    /// `deltas` holds the volumetric errors of the targets of one step after the other, mm; each step
    /// puts its component errors into its place in `errors`.
    ///
    /// # Panics
    /// If `deltas` has not one vector for each target of each step of `errors`.
    pub fn apply_steps(&self, deltas: &[Vector3<f64>], errors: &mut [MotionError]) {
        let targets = self.targets_mm().len();
        assert_eq!(
            deltas.len(),
            targets * errors.len(),
            "one volumetric error for each target of each step"
        );
        match (self.blocks().try_into(), deltas.as_chunks::<3>()) {
            // Three targets are usual.
            (Ok(blocks), (deltas, [])) => Arch::new().dispatch(Apply {
                blocks,
                deltas,
                errors,
            }),
            _ => {
                for (delta, error) in deltas.chunks_exact(targets).zip(errors) {
                    *error = self.apply(delta);
                }
            }
        }
    }
}

/// The nine equations by least squares, as [`crate::nine_closed_form`], for many steps with targets
/// at other places (or turned) in each: those of a rotary axis.
///
/// `r` and `delta` hold the generalised coordinates of P, Q, K and their volumetric errors, mm, step
/// after step; each step puts its component errors into its place in `errors`. What is not finite in
/// `delta` is not finite in the result.
///
/// # Errors
/// The first step that [`crate::nine_closed_form`] refuses; `errors` means nothing then.
///
/// # Panics
/// If `r`, `delta` and `errors` are not equally long.
pub fn nine_steps(r: &[Step], delta: &[Step], errors: &mut [MotionError]) -> Result<(), StepError> {
    assert_eq!(
        (r.len(), delta.len()),
        (errors.len(), errors.len()),
        "targets, volumetric errors and room for each step"
    );
    let found = Arch::new().dispatch(Fit { r, delta, errors });
    found.ok_or_else(|| first_refused(r))
}

/// One operator for all steps.
struct Apply<'a> {
    blocks: &'a [Matrix6x3<f64>; 3],
    deltas: &'a [Step],
    errors: &'a mut [MotionError],
}

// Not a closure: the call of a closure may be compiled by itself, without wide registers.
impl WithSimd for Apply<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let (eights, rest) = self.deltas.as_chunks();
        let (done, last) = self.errors.as_chunks_mut::<LANES>();
        for (deltas, errors) in eights.iter().zip(done) {
            put(applied(self.blocks, deltas), errors);
        }
        if let Some(deltas) = filled_up(rest) {
            put(applied(self.blocks, &deltas), last);
        }
    }
}

/// `Σ P_j Δ_j`, in the order of [`Operator::apply`]. A target's vectors are taken apart where they are
/// needed: those of all three at once would not stay in registers.
#[inline(always)]
fn applied(blocks: &[Matrix6x3<f64>; 3], deltas: &[Step; LANES]) -> [Coordinates<Lanes>; 2] {
    let mut sums = [Lanes::ZERO; 6];
    for (j, block) in blocks.iter().enumerate() {
        let Coordinates([x, y, z]) = of_target(j, deltas);
        for (i, sum) in sums.iter_mut().enumerate() {
            *sum += Lanes::splat(block[(i, 0)]) * x
                + Lanes::splat(block[(i, 1)]) * y
                + Lanes::splat(block[(i, 2)]) * z;
        }
    }
    let [x, y, z, a, b, c] = sums;
    [Coordinates([x, y, z]), Coordinates([a, b, c])]
}

/// The targets of each step.
struct Fit<'a> {
    r: &'a [Step],
    delta: &'a [Step],
    errors: &'a mut [MotionError],
}

impl WithSimd for Fit<'_> {
    /// `None` if a step has targets that do not span a plane.
    type Output = Option<()>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Option<()> {
        let (r_eights, r_rest) = self.r.as_chunks();
        let (eights, rest) = self.delta.as_chunks();
        let (done, last) = self.errors.as_chunks_mut::<LANES>();
        for ((r, delta), errors) in r_eights.iter().zip(eights).zip(done) {
            put(fitted(r, delta)?, errors);
        }
        if let (Some(r), Some(delta)) = (filled_up(r_rest), filled_up(rest)) {
            put(fitted(&r, &delta)?, last);
        }
        Some(())
    }
}

/// `None` if a step has targets that do not span a plane.
#[inline(always)]
fn fitted(r: &[Step; LANES], deltas: &[Step; LANES]) -> Option<[Coordinates<Lanes>; 2]> {
    let (targets, span) = ThreeTargets::unchecked(&taken(r));
    span.is_plane().then(|| targets.motion(&taken(deltas)))
}

/// The vectors of the steps as lanes.
#[inline(always)]
fn taken(steps: &[Step; LANES]) -> [Coordinates<Lanes>; 3] {
    [
        of_target(0, steps),
        of_target(1, steps),
        of_target(2, steps),
    ]
}

#[inline(always)]
fn of_target(j: usize, steps: &[Step; LANES]) -> Coordinates<Lanes> {
    let lanes = |axis: usize| Lanes::from_fn(|k| steps[k][j][axis]);
    Coordinates([lanes(0), lanes(1), lanes(2)])
}

/// Fewer steps than lanes, and the last of them for the lanes that are left; `None` without any.
#[inline(always)]
fn filled_up(rest: &[Step]) -> Option<[Step; LANES]> {
    let last = rest.len().checked_sub(1)?;
    Some(std::array::from_fn(|k| rest[k.min(last)]))
}

/// The lanes as component errors of the first steps.
#[inline(always)]
fn put([translation, rotation]: [Coordinates<Lanes>; 2], errors: &mut [MotionError]) {
    for (k, error) in errors.iter_mut().enumerate().take(LANES) {
        let ([x, y, z], [a, b, c]) = (translation.0, rotation.0);
        *error = MotionError {
            translation_mm: Vector3::new(x.0[k], y.0[k], z.0[k]),
            rotation_rad: Vector3::new(a.0[k], b.0[k], c.0[k]),
        };
    }
}

fn first_refused(r: &[Step]) -> StepError {
    let refused = r.iter().enumerate().find_map(|(step, r)| {
        let error = ThreeTargets::new(r).err()?;
        Some(StepError { step, error })
    });
    refused.expect("one step refuses as the lanes do")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{nine, nine_closed_form};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    fn random(count: usize, size: f64, seed: u64) -> Vec<Step> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut vector = || Vector3::from_fn(|_, _| rng.random_range(-size..size));
        (0..count).map(|_| [vector(), vector(), vector()]).collect()
    }

    /// Whole eights, parts of them, and nothing.
    const COUNTS: [usize; 7] = [0, 1, 7, 8, 9, 16, 29];

    #[test]
    fn steps_of_one_operator_are_what_it_gives_each() {
        let mut four = random(2, 400.0, 1).concat();
        four.truncate(4);
        for r in [&four[..3], &four] {
            let operator = nine(r).unwrap();
            for count in COUNTS {
                let deltas = random(count * r.len(), 0.01, 2).concat();
                let deltas = &deltas[..count * r.len()];
                let mut errors = vec![MotionError::default(); count];
                operator.apply_steps(deltas, &mut errors);
                let expected = deltas.chunks(r.len()).map(|delta| operator.apply(delta));
                assert_eq!(errors, expected.collect::<Vec<_>>());
            }
        }
    }

    #[test]
    fn steps_of_many_designs_are_the_closed_form() {
        for count in COUNTS {
            let (r, delta) = (random(count, 400.0, 3), random(count, 0.01, 4));
            let mut errors = vec![MotionError::default(); count];
            nine_steps(&r, &delta, &mut errors).unwrap();
            let expected = r
                .iter()
                .zip(&delta)
                .map(|(r, delta)| nine_closed_form(r, delta));
            assert_eq!(errors, expected.map(Result::unwrap).collect::<Vec<_>>());
        }
    }

    #[test]
    fn any_instruction_set_gives_the_same_bits() {
        let (r, delta) = (random(29, 400.0, 5), random(29, 0.01, 6));
        let operator = nine(&r[0]).unwrap();
        let [mut wide, mut plain] = [(); 2].map(|()| vec![MotionError::default(); 29]);
        operator.apply_steps(delta.as_flattened(), &mut wide);
        Arch::Scalar.dispatch(Apply {
            blocks: operator.blocks().try_into().unwrap(),
            deltas: &delta,
            errors: &mut plain,
        });
        assert_eq!(wide, plain);
        nine_steps(&r, &delta, &mut wide).unwrap();
        let (r, delta, errors) = (&r[..], &delta[..], &mut plain[..]);
        assert!(Arch::Scalar.dispatch(Fit { r, delta, errors }).is_some());
        assert_eq!(wide, plain);
    }

    #[test]
    fn the_first_step_without_a_plane_is_named() {
        let delta = random(29, 0.01, 7);
        let mut errors = vec![MotionError::default(); 29];
        let line = [1.0, 2.0, 5.0].map(|t| Vector3::new(3.0, -2.0, 7.0) * t);
        for step in [0, 12, 28] {
            let mut r = random(29, 400.0, 8);
            r[step] = line;
            let error = nine(&line).unwrap_err();
            let refused = Err(StepError { step, error });
            assert_eq!(nine_steps(&r, &delta, &mut errors), refused);
            r[step][1].y = f64::NAN;
            let error = nine(&r[step]).unwrap_err();
            let refused = Err(StepError { step, error });
            assert_eq!(nine_steps(&r, &delta, &mut errors), refused);
        }
    }
}
