//! Sums of the reduced system over the points of [`crate::single_points`], one for each lane.

use pulp::Simd;
use trueaxis_leastsquares::Reduced;

use crate::free_points::{DATUM, PER_STATION};
use crate::single_point_batch::{Batch, REGISTERS, Registers, cross, take3, weighted_datum};

/// Columns of the datum multipliers and the right side.
const BORDER: usize = DATUM + 1;

/// The sums, and memory for what they are made of.
pub(crate) struct Sums<S: Simd> {
    stations: usize,
    /// `(s_j, s_k)` for each pair `j ≤ k`.
    pairs: Vec<[[S::f64s; PER_STATION]; PER_STATION]>,
    /// `([λ, 1], s_j)`.
    borders: Vec<[[S::f64s; PER_STATION]; BORDER]>,
    /// `([λ, 1], [λ, 1])`, upper triangle.
    corner: [[S::f64s; BORDER]; BORDER],
    closure: [S::f64s; DATUM],
    /// `[W | c]` of the batch, by columns.
    bordering: [[Registers<S>; 3]; BORDER],
}

impl<S: Simd> Sums<S> {
    pub(crate) fn new(simd: S, stations: usize) -> Self {
        let zero = simd.splat_f64s(0.0);
        Self {
            stations,
            pairs: vec![[[zero; PER_STATION]; PER_STATION]; stations * (stations + 1) / 2],
            borders: vec![[[zero; PER_STATION]; BORDER]; stations],
            corner: [[zero; BORDER]; BORDER],
            closure: [zero; DATUM],
            bordering: [[[zero; REGISTERS]; 3]; BORDER],
        }
    }

    /// Adds the points of a batch.
    #[inline(always)]
    pub(crate) fn add(&mut self, simd: S, batch: &Batch<S>, registers: usize) {
        self.add_pairs(simd, batch, registers);
        self.fill_bordering(simd, batch, registers);
        self.add_borders(simd, batch, registers);
        self.add_corner(simd, registers);
        for at in 0..registers {
            let deviation = take3::<S>(&batch.deviation_mm, at);
            let moment = cross(simd, &take3::<S>(&batch.lever, at), &deviation);
            let motion = deviation.into_iter().chain(moment);
            for (sum, x) in self.closure.iter_mut().zip(motion) {
                *sum = simd.sub_f64s(*sum, x);
            }
        }
    }

    /// `g_j P_jk g_kᵀ`.
    #[inline(always)]
    fn add_pairs(&mut self, simd: S, batch: &Batch<S>, registers: usize) {
        let mut pair = 0;
        for j in 0..self.stations {
            let (vj, gj) = (
                row::<S, 3>(&batch.orthonormal, j),
                row::<S, 4>(&batch.shared, j),
            );
            for k in j..self.stations {
                let (vk, gk) = (
                    row::<S, 3>(&batch.orthonormal, k),
                    row::<S, 4>(&batch.shared, k),
                );
                let diagonal = simd.splat_f64s(if j == k { 1.0 } else { 0.0 });
                let mut projection = [diagonal; REGISTERS];
                for at in 0..registers {
                    for axis in 0..3 {
                        let v = simd.neg_f64s(vj[axis][at]);
                        projection[at] = simd.mul_add_f64s(v, vk[axis][at], projection[at]);
                    }
                }
                // Two rows at a time: their sums stay in registers.
                for (two, rows) in self.pairs[pair].chunks_exact_mut(2).enumerate() {
                    let (a, b) = (&gj[2 * two], &gj[2 * two + 1]);
                    let (mut sum_a, mut sum_b) = (rows[0], rows[1]);
                    for at in 0..registers {
                        let pa = simd.mul_f64s(projection[at], a[at]);
                        let pb = simd.mul_f64s(projection[at], b[at]);
                        for c in 0..PER_STATION {
                            sum_a[c] = simd.mul_add_f64s(pa, gk[c][at], sum_a[c]);
                            sum_b[c] = simd.mul_add_f64s(pb, gk[c][at], sum_b[c]);
                        }
                    }
                    (rows[0], rows[1]) = (sum_a, sum_b);
                }
                pair += 1;
            }
        }
    }

    #[inline(always)]
    fn fill_bordering(&mut self, simd: S, batch: &Batch<S>, registers: usize) {
        for at in 0..registers {
            for (axis, row) in weighted_datum(simd, batch, at).into_iter().enumerate() {
                for (column, w) in self.bordering.iter_mut().zip(row) {
                    column[axis][at] = w;
                }
            }
            for axis in 0..3 {
                let mut sum = simd.splat_f64s(0.0);
                for (j, r) in batch.residuals.iter().enumerate() {
                    sum = simd.mul_add_f64s(batch.orthonormal[3 * j + axis][at], r[at], sum);
                }
                self.bordering[DATUM][axis][at] = sum;
            }
        }
    }

    /// `g_j (v_jᵀ [W, c] - [0, r_j])`.
    #[inline(always)]
    fn add_borders(&mut self, simd: S, batch: &Batch<S>, registers: usize) {
        for j in 0..self.stations {
            let (v, g) = (
                row::<S, 3>(&batch.orthonormal, j),
                row::<S, 4>(&batch.shared, j),
            );
            for (c, column) in self.bordering.iter().enumerate() {
                let [mut sum0, mut sum1, mut sum2, mut sum3] = self.borders[j][c];
                for at in 0..registers {
                    let mut x = simd.mul_f64s(v[0][at], column[0][at]);
                    x = simd.mul_add_f64s(v[1][at], column[1][at], x);
                    x = simd.mul_add_f64s(v[2][at], column[2][at], x);
                    if c == DATUM {
                        x = simd.sub_f64s(x, batch.residuals[j][at]);
                    }
                    sum0 = simd.mul_add_f64s(g[0][at], x, sum0);
                    sum1 = simd.mul_add_f64s(g[1][at], x, sum1);
                    sum2 = simd.mul_add_f64s(g[2][at], x, sum2);
                    sum3 = simd.mul_add_f64s(g[3][at], x, sum3);
                }
                self.borders[j][c] = [sum0, sum1, sum2, sum3];
            }
        }
    }

    /// `-[W, c]ᵀ [W, c]`.
    #[inline(always)]
    fn add_corner(&mut self, simd: S, registers: usize) {
        for i in 0..BORDER {
            let mut sums = self.corner[i];
            for at in 0..registers {
                for axis in 0..3 {
                    let x = simd.neg_f64s(self.bordering[i][axis][at]);
                    for (sum, column) in sums.iter_mut().zip(&self.bordering).skip(i) {
                        *sum = simd.mul_add_f64s(x, column[axis][at], *sum);
                    }
                }
            }
            self.corner[i] = sums;
        }
    }

    /// Adds the sums of all lanes to a reduced system.
    #[inline(always)]
    pub(crate) fn add_to(&self, simd: S, reduced: &mut Reduced) {
        let shared = reduced.shared();
        let mut pair = 0;
        for j in 0..self.stations {
            for k in j..self.stations {
                for (a, sums) in self.pairs[pair].iter().enumerate() {
                    let row = reduced.row_mut(PER_STATION * j + a);
                    for (m, &x) in row[PER_STATION * k..].iter_mut().zip(sums) {
                        *m += simd.reduce_sum_f64s(x);
                    }
                }
                pair += 1;
            }
            for (c, sums) in self.borders[j].iter().enumerate() {
                for (a, &x) in sums.iter().enumerate() {
                    reduced.row_mut(PER_STATION * j + a)[shared + c] += simd.reduce_sum_f64s(x);
                }
            }
        }
        for (i, sums) in self.corner.iter().enumerate() {
            let row = &mut reduced.row_mut(shared + i)[shared..];
            for (m, &x) in row.iter_mut().zip(sums).skip(i) {
                *m += simd.reduce_sum_f64s(x);
            }
        }
        let mut closure = [0.0; DATUM];
        for (h, &x) in closure.iter_mut().zip(&self.closure) {
            *h = simd.reduce_sum_f64s(x);
        }
        reduced.close(&closure);
    }
}

/// The `N` vectors of station `j`.
#[inline(always)]
fn row<S: Simd, const N: usize>(all: &[Registers<S>], j: usize) -> &[Registers<S>; N] {
    &all.as_chunks::<N>().0[j]
}
