//! Eigenvalues, and a vector along their eigenvectors, without the eigenvectors.
//!
//! Householder reflections of `A` with a border of `s` make `A` tridiagonal and turn `s` to its first axis. The rotations of
//! the QL iteration then need to be applied to one row only: the first components of the eigenvectors (G. H. Golub,
//! J. H. Welsch, *Math. Comp.* 23, 221, 1969). All but the reflections takes `n²` operations.

use nalgebra::DMatrix;
use nalgebra::linalg::SymmetricTridiagonal;

use super::decompositions::STEPS;
use crate::Error;

/// For each eigenvalue of a symmetric matrix, in any order: itself, and how far `s` goes along its eigenvector, with either
/// sign. `element` gives what stands in a row and in a column that is not after it.
///
/// # Errors
/// [`Error::Decomposition`] if an element is not finite, or the iteration does not converge.
pub fn eigenvalues_along(
    s: &[f64],
    element: impl Fn(usize, usize) -> f64,
) -> Result<Vec<(f64, f64)>, Error> {
    let failed = Error::Decomposition {
        what: "eigenvalue decomposition",
    };
    let n = s.len();
    let bordered = DMatrix::from_fn(n + 1, n + 1, |i, j| match (i, j) {
        (0, _) => 0.0,
        (i, 0) => s[i - 1],
        (i, j) if i < j => 0.0,
        (i, j) => element(i - 1, j - 1),
    });
    if bordered.iter().any(|x| !x.is_finite()) {
        return Err(failed);
    }
    let (diagonal, beside) = SymmetricTridiagonal::new(bordered).unpack_tridiagonal();
    let Some((length, beside)) = beside.as_slice().split_first() else {
        return Ok(Vec::new());
    };
    let mut tridiagonal = Tridiagonal {
        diagonal: diagonal.iter().skip(1).copied().collect(),
        beside: beside.iter().copied().chain([0.0]).collect(),
        along: vec![0.0; n],
    };
    tridiagonal.along[0] = *length;
    for first in 0..n {
        let end = (0..STEPS).find_map(|_| match tridiagonal.block(first) {
            last if last == first => Some(()),
            last => {
                tridiagonal.step(first, last);
                None
            }
        });
        end.ok_or(failed.clone())?;
    }
    let Tridiagonal {
        diagonal, along, ..
    } = tridiagonal;
    Ok(diagonal.into_iter().zip(along).collect())
}

/// A symmetric tridiagonal matrix, and a vector that turns with it.
struct Tridiagonal {
    diagonal: Vec<f64>,
    /// Each between a diagonal element and the next; the last one is zero.
    beside: Vec<f64>,
    along: Vec<f64>,
}

impl Tridiagonal {
    /// The last row that hangs together with one.
    fn block(&self, first: usize) -> usize {
        let d = &self.diagonal;
        let is_apart = |i: &usize| {
            let size = d[*i].abs() + d.get(i + 1).map_or(0.0, |next| next.abs());
            self.beside[*i].abs() <= f64::EPSILON * size
        };
        let last = self.diagonal.len() - 1;
        (first..last).find(is_apart).unwrap_or(last)
    }

    /// One QL step with Wilkinson's shift from row `last` to row `first`.
    fn step(&mut self, first: usize, last: usize) {
        let Self {
            diagonal: d,
            beside: e,
            along,
        } = self;
        let half = 0.5 * (d[first + 1] - d[first]) / e[first];
        let shift = d[first] - e[first] / (half + half.hypot(1.0).copysign(half));
        let (mut rest, mut sine, mut cosine, mut moved) = (d[last] - shift, 1.0, 1.0, 0.0);
        for i in (first..last).rev() {
            let (f, b) = (sine * e[i], cosine * e[i]);
            let r = f.hypot(rest);
            e[i + 1] = r;
            if r <= 0.0 {
                // The matrix falls apart here.
                d[i + 1] -= moved;
                e[last] = 0.0;
                return;
            }
            (sine, cosine) = (f / r, rest / r);
            let above = d[i + 1] - moved;
            let r = (d[i] - above) * sine + 2.0 * cosine * b;
            moved = sine * r;
            d[i + 1] = above + moved;
            rest = cosine * r - b;
            (along[i], along[i + 1]) = (
                cosine * along[i] - sine * along[i + 1],
                sine * along[i] + cosine * along[i + 1],
            );
        }
        d[first] -= moved;
        e[first] = rest;
        e[last] = 0.0;
    }
}
