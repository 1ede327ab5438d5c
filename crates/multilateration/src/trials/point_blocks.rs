//! `D = R⁻¹R⁻ᵀ`: what a gradient at the points of a group does to them while all stations are held.
//!
//! Where no visit couples the points of a group, every point has a block of its own.

use std::ops::Range;

use faer::Mat;
use trueaxis_leastsquares::{LANES, Lanes, lanes_only};

use super::coordinates::Coordinates;

/// `D` of all points.
#[derive(Debug, Clone, Default)]
pub(crate) struct PointBlocks {
    /// xx xy xz yy yz zz of each point, eight points side by side; zero where a coupled group takes
    /// its place.
    own: [Vec<Lanes>; 6],
    coupled: Vec<CoupledPoints>,
}

#[derive(Debug, Clone)]
struct CoupledPoints {
    points: Range<usize>,
    /// Symmetric, row by row, all x before all y before all z.
    matrix: Vec<f64>,
}

/// Places of the stored elements of a point's block.
const ELEMENTS: [(usize, usize); 6] = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)];

impl PointBlocks {
    /// Adds the next group, whose points follow those before; `block` has rows and columns x y z of each point.
    pub(crate) fn push(&mut self, points: Range<usize>, block: &Mat<f64>, is_coupled: bool) {
        let count = points.len();
        for (k, point) in points.clone().enumerate() {
            for (all, (i, j)) in self.own.iter_mut().zip(ELEMENTS) {
                if point % LANES == 0 {
                    all.push(Lanes::ZERO);
                }
                if !is_coupled {
                    all[point / LANES].0[point % LANES] = block[(3 * k + i, 3 * k + j)];
                }
            }
        }
        if is_coupled {
            // From x y z of each point to all x, all y, all z.
            let place = |k: usize| 3 * (k % count) + k / count;
            let elements = (0..3 * count).flat_map(|i| (0..3 * count).map(move |j| (i, j)));
            let matrix = elements.map(|(i, j)| block[(place(i), place(j))]).collect();
            self.coupled.push(CoupledPoints { points, matrix });
        }
    }

    /// `D g`.
    #[inline(always)]
    pub(crate) fn times(&self, gradient: &Coordinates, product: &mut Coordinates) {
        let [xx, xy, xz, yy, yz, zz] = &self.own;
        let count = xx.len();
        let [xy, xz, yy] = [&xy[..count], &xz[..count], &yy[..count]];
        let [yz, zz] = [&yz[..count], &zz[..count]];
        let [gx, gy, gz] = gradient.eights();
        let (gx, gy, gz) = (&gx[..count], &gy[..count], &gz[..count]);
        let [x, y, z] = product.eights_mut();
        let (x, y, z) = (&mut x[..count], &mut y[..count], &mut z[..count]);
        for i in 0..count {
            lanes_only();
            let (a, b, c) = (Lanes(gx[i]), Lanes(gy[i]), Lanes(gz[i]));
            x[i] = (xx[i] * a + xy[i] * b + xz[i] * c).0;
            y[i] = (xy[i] * a + yy[i] * b + yz[i] * c).0;
            z[i] = (xz[i] * a + yz[i] * b + zz[i] * c).0;
        }
        for group in &self.coupled {
            group.times(gradient, product);
        }
    }
}

impl CoupledPoints {
    #[inline(always)]
    fn times(&self, gradient: &Coordinates, product: &mut Coordinates) {
        let [x, y, z] = gradient.all();
        let points = || self.points.clone();
        let gradient = [&x[points()], &y[points()], &z[points()]];
        let [x, y, z] = product.all_mut();
        let product = [&mut x[points()], &mut y[points()], &mut z[points()]];
        // Three targets are usual, and loops of a known length are three times as fast.
        match self.points.len() {
            3 => self.times_three(gradient, product),
            count => self.times_any(count, gradient, product),
        }
    }

    #[inline(always)]
    fn times_three(&self, g: [&[f64]; 3], product: [&mut [f64]; 3]) {
        let g: [f64; 9] = std::array::from_fn(|k| g[k / 3][k % 3]);
        let columns = self.matrix.as_chunks::<9>().0;
        let mut sums = [0.0; 9];
        for (column, g) in columns.iter().zip(g) {
            for (sum, element) in sums.iter_mut().zip(column) {
                *sum += element * g;
            }
        }
        for (values, sums) in product.into_iter().zip(sums.as_chunks::<3>().0) {
            values.copy_from_slice(sums);
        }
    }

    #[inline(always)]
    fn times_any(&self, count: usize, gradient: [&[f64]; 3], product: [&mut [f64]; 3]) {
        let mut rows = self.matrix.chunks_exact(3 * count);
        for values in product {
            for (value, row) in values.iter_mut().zip(&mut rows) {
                let parts = row.chunks_exact(count).zip(gradient);
                *value = parts
                    .flat_map(|(elements, g)| elements.iter().zip(g))
                    .map(|(element, g)| element * g)
                    .sum();
            }
        }
    }
}
