//! The closed form against a general solver of the same six equations.

use nalgebra::{Vector3, Vector6};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use trueaxis_identify::{Error, SixRows, closed_form};
use trueaxis_kinematics::MotionError;

use crate::targets::{
    condition_number, random_targets, random_vector, reach, relative_difference, six_equations,
};

/// Either solver may be wrong by `EPSILON * condition`.
const ROUNDING_FACTOR: f64 = 2.0;

const GEOMETRIES: usize = 10_000;

/// One geometry in four has two targets of equal z, where the printed form is 0/0. There N is a
/// product of three differences, each of which can happen to be small: a few are refused.
#[test]
fn equals_a_general_solver() {
    let mut rng = ChaCha8Rng::seed_from_u64(18);
    let mut refused = 0;
    for i in 0..GEOMETRIES {
        let mut r = random_targets(&mut rng);
        match i % 8 {
            0 => r[1].z = r[0].z,
            1 => r[2].z = r[0].z,
            _ => {}
        }
        let delta = [(); 3].map(|()| random_vector(&mut rng, 1e-2));
        let found = match closed_form(&r, &delta) {
            Ok(found) => found,
            Err(Error::NearZeroN { n_mm3, scale_mm3 }) => {
                assert!(n_mm3.abs() <= 1e-6 * scale_mm3);
                refused += 1;
                continue;
            }
            Err(other) => panic!("{other}"),
        };
        let reach = reach(&r);
        let measured = Vector6::from_iterator(SixRows::PAPER.rows().map(|i| delta[i / 3][i % 3]));
        let equations = six_equations(SixRows::PAPER, &r, reach);
        let mut solution = equations.lu().solve(&measured).unwrap();
        solution.fixed_rows_mut::<3>(3).unscale_mut(reach);
        let general = MotionError::from_vector(&solution);

        let difference = relative_difference(&found, &general, reach);
        let condition = condition_number(SixRows::PAPER, &r);
        let bound = ROUNDING_FACTOR * f64::EPSILON * condition;
        assert!(difference < bound, "{difference:e} {bound:e} {r:?}");
    }
    assert!(
        refused <= GEOMETRIES / 1000,
        "{refused} of {GEOMETRIES} refused"
    );
}

/// det of ①②④⑥⑧⑨ is N, sign included.
#[test]
fn determinant_is_n() {
    let mut rng = ChaCha8Rng::seed_from_u64(19);
    for _ in 0..1000 {
        let [p, q, k] = [(); 3].map(|()| random_vector(&mut rng, 1.0));
        let n = (k.x - q.x) * (p.y - q.y) * (p.z - k.z) - (k.x - p.x) * (k.y - q.y) * (q.z - p.z);
        let determinant = six_equations(SixRows::PAPER, &[p, q, k], 1.0).determinant();
        // Entries and N are of order 1.
        assert!((determinant - n).abs() < 1e-13);
    }
}

/// The refusal reports N and the determinant, which are the same number.
#[test]
fn refusals_report_n() {
    let p = Vector3::new(7.0, 11.0, 13.0);
    // N = 20 · 20 · 30 - 60 · 20 · 10 is zero; moving K.y by h changes it by -60 · 10 h.
    let r = [
        p,
        p + Vector3::new(40.0, 20.0, 10.0),
        p + Vector3::new(60.0, 40.0 + 1e-4 / 6.0, 30.0),
    ];
    let Err(Error::NearZeroN { n_mm3, .. }) = closed_form(&r, &r) else {
        panic!("not refused");
    };
    assert!((n_mm3 + 0.01).abs() < 1e-9, "{n_mm3}");
    let Err(Error::SingularRows {
        determinant_mm3, ..
    }) = SixRows::PAPER.operator(&r)
    else {
        panic!("not refused");
    };
    assert!((determinant_mm3 - n_mm3).abs() < 1e-9, "{determinant_mm3}");
}
