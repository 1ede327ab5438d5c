//! The paper's closed solution of ①②④⑥⑧⑨ against general solvers of the same six equations.

use nalgebra::{Vector3, Vector6};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use trueaxis_identify::{Error, SixRows, nine};
use trueaxis_kinematics::MotionError;

use crate::targets::{
    THREE_AXIS, condition_number, random_targets, random_vector, reach, relative_difference,
    six_equations,
};

/// Solves Px Py Qx Qz Ky Kz (paper Eqs. 10 and 17) for the six component errors in closed form
/// (Eqs. 11, 18 and 22), with N as its only denominator: a second opinion on the operator that
/// `--method six` uses. N where it vanishes against the cube of the longest distance between targets
/// (which can happen with all coordinates different).
///
/// Eq. 18 is the right one of the three printed forms: in Eq. 22 the first term of δz lacks its
/// factor `(x̂K - x̂P)/(ẑP - ẑK)`, and in Eq. 11 δx and δy are garbled. All three divide by
/// `ẑP - ẑK` and `ẑQ - ẑP`, which only follows from the order of elimination. The differences
/// Qx - Px, Ky - Py, Kz - Qz leave three equations in ε that Cramer's rule solves with the
/// determinant N alone, so that targets of equal z are no problem as long as N is not zero.
fn closed_form(r: &[Vector3<f64>; 3], delta: &[Vector3<f64>; 3]) -> Result<MotionError, f64> {
    let [p, q, k] = r;
    let [delta_p, delta_q, delta_k] = delta;
    let (qp, kp, kq) = (q - p, k - p, k - q);

    // u = Qx - Px =            εy qp.z - εz qp.y
    // v = Ky - Py = -εx kp.z           + εz kp.x
    // w = Kz - Qz =  εx kq.y - εy kq.x
    let u = delta_q.x - delta_p.x;
    let v = delta_k.y - delta_p.y;
    let w = delta_k.z - delta_q.z;

    let n_mm3 = kq.x * qp.y * kp.z - kp.x * kq.y * qp.z;
    let longest_mm = [qp, kp, kq]
        .map(|side| side.norm())
        .into_iter()
        .fold(0.0, f64::max);
    if n_mm3.abs() <= 1e-6 * longest_mm.powi(3) {
        return Err(n_mm3);
    }
    let rotation = Vector3::new(
        kp.x * kq.x * u + qp.y * kq.x * v + kp.x * qp.z * w,
        kp.x * kq.y * u + qp.y * kq.y * v + qp.y * kp.z * w,
        kq.x * kp.z * u + kq.y * qp.z * v + qp.z * kp.z * w,
    ) / -n_mm3;

    // Rows Px, Py, Qz.
    let translation = Vector3::new(
        delta_p.x - rotation.y * p.z + rotation.z * p.y,
        delta_p.y - rotation.z * p.x + rotation.x * p.z,
        delta_q.z - rotation.x * q.y + rotation.y * q.x,
    );
    Ok(MotionError::new(translation, rotation))
}

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
        let Ok(found) = closed_form(&r, &delta) else {
            refused += 1;
            continue;
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
    let n_mm3 = closed_form(&r, &r).expect_err("N is nearly zero");
    assert!((n_mm3 + 0.01).abs() < 1e-9, "{n_mm3}");
    let Err(Error::SingularRows {
        determinant_mm3, ..
    }) = SixRows::PAPER.operator(&r)
    else {
        panic!("not refused");
    };
    assert!((determinant_mm3 - n_mm3).abs() < 1e-9, "{determinant_mm3}");
}

const DELTA: [Vector3<f64>; 3] = [
    Vector3::new(1.7e-3, -4.1e-3, 0.6e-3),
    Vector3::new(-2.9e-3, 3.3e-3, 5.2e-3),
    Vector3::new(4.4e-3, -0.8e-3, -3.7e-3),
];

/// Eq. 18 term by term, with its removable denominators.
fn as_printed(r: &[Vector3<f64>; 3], delta: &[Vector3<f64>; 3]) -> MotionError {
    let [p, q, k] = r;
    let [dp, dq, dk] = delta;
    let m = (dq.x - dp.x) * (k.x - q.x) * (p.z - k.z)
        + ((dp.y - dk.y) * (k.y - q.y) + (dk.z - dq.z) * (p.z - k.z)) * (q.z - p.z);
    let n = (k.x - q.x) * (p.y - q.y) * (p.z - k.z) - (k.x - p.x) * (k.y - q.y) * (q.z - p.z);
    let translation = Vector3::new(
        dp.x + m / n * (p.y - p.z * (q.y - p.y) / (q.z - p.z)) - p.z * (dq.x - dp.x) / (q.z - p.z),
        dp.y - m / n * (p.x - p.z * (p.x - k.x) / (p.z - k.z)) - p.z * (dp.y - dk.y) / (p.z - k.z),
        dq.z + m / n * (q.y * (k.x - p.x) / (p.z - k.z) - q.x * (p.y - q.y) / (q.z - p.z))
            - q.y * (dk.y - dp.y) / (p.z - k.z)
            + q.x * (dq.x - dp.x) / (q.z - p.z),
    );
    let rotation = Vector3::new(
        (dk.y - dp.y) / (p.z - k.z) + (p.x - k.x) / (p.z - k.z) * (m / n),
        (dq.x - dp.x) / (q.z - p.z) + (q.y - p.y) / (q.z - p.z) * (m / n),
        m / n,
    );
    MotionError::new(translation, rotation)
}

#[test]
fn equals_the_printed_equation_18() {
    let found = closed_form(&THREE_AXIS, &DELTA).unwrap();
    let printed = as_printed(&THREE_AXIS, &DELTA);
    let translation = found.translation_mm - printed.translation_mm;
    let rotation = found.rotation_rad - printed.rotation_rad;
    assert!(translation.norm() < 1e-13 * printed.translation_mm.norm());
    assert!(rotation.norm() < 1e-13 * printed.rotation_rad.norm());
}

/// The printed form is 0/0 there.
#[test]
fn equal_heights_are_no_singularity() {
    let [p, q, k] = THREE_AXIS;
    let (mut level_q, mut level_k) = (q, k);
    level_q.z = p.z;
    level_k.z = p.z;
    for r in [[p, level_q, k], [p, q, level_k]] {
        assert!(!as_printed(&r, &DELTA).translation_mm.norm().is_finite());
        let found = closed_form(&r, &DELTA).unwrap();
        let expected = SixRows::PAPER.operator(&r).unwrap().apply(&DELTA);
        let difference = found.to_vector() - expected.to_vector();
        assert!(difference.norm() < 1e-12 * expected.to_vector().norm());
    }
}

/// Three targets of one height see no rotation about z by these six rows: N is zero.
#[test]
fn three_equal_heights_are_refused() {
    let level = THREE_AXIS.map(|r| Vector3::new(r.x, r.y, 7.0));
    assert_eq!(closed_form(&level, &DELTA), Err(0.0));
    assert!(matches!(
        SixRows::PAPER.operator(&level),
        Err(Error::SingularRows { .. })
    ));
    assert!(nine(&level).is_ok());
}

#[test]
fn zero_n_with_all_coordinates_different_is_refused() {
    let p = Vector3::new(7.0, 11.0, 13.0);
    let r = [
        p,
        p + Vector3::new(40.0, 20.0, 10.0),
        p + Vector3::new(60.0, 40.0, 30.0),
    ];
    assert_eq!(closed_form(&r, &DELTA), Err(0.0));
    assert!(matches!(
        SixRows::PAPER.operator(&r),
        Err(Error::SingularRows { rows: SixRows::PAPER, condition, .. }) if condition > 1e12
    ));
    assert!(nine(&r).is_ok());
}
