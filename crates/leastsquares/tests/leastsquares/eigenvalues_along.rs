//! Eigenvalues and a vector along their eigenvectors, against products and solutions with the matrix itself.

use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use trueaxis_leastsquares::dense::eigenvalues_along;

/// `BᵀDB` of random `B`: eigenvalues over ten decades, the last `missing` of them zero.
fn graded(random: &mut ChaCha8Rng, n: usize, missing: usize) -> DMatrix<f64> {
    let b = DMatrix::from_fn(n, n, |_, _| random.random_range(-1.0..1.0));
    let size = |i: usize| match i + missing < n {
        true => 10_f64.powf(-10.0 * i as f64 / n as f64),
        false => 0.0,
    };
    let d = DMatrix::from_fn(n, n, |i, j| if i == j { size(i) } else { 0.0 });
    b.transpose() * d * b
}

fn assert_same(matrix: &DMatrix<f64>, s: &DVector<f64>) {
    let all = eigenvalues_along(s.as_slice(), |i, j| matrix[(i, j)]).expect("finite");
    let size = matrix.amax().max(1.0);
    let sum = |f: &dyn Fn(f64) -> f64| all.iter().map(|(g, a)| a * a * f(*g)).sum::<f64>();
    let close = |a: f64, b: f64, of: f64| assert!((a - b).abs() < 1e-12 * of, "{a} {b}");
    let squares = s.norm_squared();
    assert_eq!(all.len(), s.len());
    close(
        all.iter().map(|(g, _)| g).sum(),
        matrix.trace(),
        size * s.len() as f64,
    );
    close(sum(&|_| 1.0), squares, squares);
    close(
        sum(&|g| g),
        (s.transpose() * matrix * s)[0],
        size * squares * s.len() as f64,
    );
    for width in [1e-3, 1.0, 1e3] {
        let with = DMatrix::identity(s.len(), s.len()) + matrix * width;
        let ln_det: f64 = all.iter().map(|(g, _)| (width * g).ln_1p()).sum();
        let cholesky = with.cholesky().expect("definite");
        let expected: f64 = cholesky.l().diagonal().iter().map(|l| 2.0 * l.ln()).sum();
        close(ln_det, expected, 1e2 * (1.0 + expected.abs()));
        let solved = s.dot(&cholesky.solve(s));
        close(sum(&|g| (1.0 + width * g).recip()), solved, 1e2 * squares);
    }
}

#[test]
fn eigenvalues_and_a_vector_along_their_eigenvectors_give_what_the_matrix_gives() {
    let mut random = ChaCha8Rng::seed_from_u64(61);
    for n in 1..40 {
        for missing in [0, 1, n / 2] {
            let matrix = graded(&mut random, n, missing);
            let s = DVector::from_fn(n, |_, _| random.random_range(-1.0..1.0));
            assert_same(&matrix, &s);
        }
        // Equal eigenvalues, blocks that nothing connects, and a vector in one of them.
        let diagonal = DMatrix::from_fn(n, n, |i, j| if i == j { (i % 3) as f64 } else { 0.0 });
        let one = DVector::from_fn(n, |i, _| f64::from(u8::from(i == n / 2)));
        assert_same(&diagonal, &one);
    }
}

#[test]
fn nothing_along_nothing() {
    assert_eq!(eigenvalues_along(&[], |_, _| 1.0), Ok(Vec::new()));
    let zero = eigenvalues_along(&[0.0, 0.0], |i, j| if i == j { 2.0 } else { 1.0 });
    let mut zero = zero.expect("finite");
    zero.sort_by(|a, b| a.0.total_cmp(&b.0));
    assert!(
        (zero[0].0 - 1.0).abs() < 1e-14 && (zero[1].0 - 3.0).abs() < 1e-14,
        "{zero:?}"
    );
    assert!(zero.iter().all(|(_, along)| along.abs() <= 0.0));
    assert!(eigenvalues_along(&[1.0], |_, _| f64::NAN).is_err());
}
