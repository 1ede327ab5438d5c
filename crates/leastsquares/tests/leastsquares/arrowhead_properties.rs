//! The arrowhead system against the same problem written as one dense bordered system.

use nalgebra::DMatrix;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use trueaxis_leastsquares::{BlockBatch, Covariance, Error, Factors, LaneSums, Lanes, Shape};

const SHARED: usize = 3;

/// One block: `rows × (n + SHARED + 1)` numbers in row order.
#[derive(Debug, Clone)]
struct Block {
    unknowns: usize,
    rows: Vec<Vec<f64>>,
}

/// Blocks whose rows do not change when every first block unknown grows by one and every shared
/// unknown falls by one: the free motion that the datum fixes.
fn blocks() -> impl Strategy<Value = Vec<Block>> {
    let block = (1_usize..4).prop_flat_map(|unknowns| {
        let row = prop::collection::vec(-1.0..1.0, unknowns + SHARED + 1);
        prop::collection::vec(row, unknowns + 3..unknowns + 6).prop_map(move |mut rows| {
            for row in &mut rows {
                let shared: f64 = row[unknowns..unknowns + SHARED].iter().sum();
                row[0] = shared;
            }
            Block { unknowns, rows }
        })
    });
    prop::collection::vec(block, 3..6)
}

/// All unknowns (blocks, then shared) and their covariance.
struct Solved {
    unknowns: Vec<f64>,
    covariance: Covariance,
}

/// Each block is the only one of its batch.
fn solve_arrowhead(blocks: &[Block], closure: f64) -> Result<Solved, Error> {
    let fill = |(i, block): (usize, &Block)| {
        let mut batch = BlockBatch::default();
        batch.reset(Shape {
            rows: block.rows.len(),
            unknowns: block.unknowns,
            in_quads: 0,
            shared: SHARED,
            datum: 1,
        });
        for (row, values) in block.rows.iter().enumerate() {
            let (own, shared) = values.split_at(block.unknowns);
            for (k, value) in own.iter().enumerate() {
                batch.row_mut(row).own[k] = Lanes::splat(*value);
            }
            for (k, value) in shared[..SHARED].iter().enumerate() {
                batch.row_mut(row).others[k] = Lanes::splat(*value);
            }
            *batch.row_mut(row).residual = Lanes::splat(shared[SHARED]);
        }
        batch.datum_mut(0)[0] = Lanes::splat(1.0);
        if i == 0 {
            batch.closure_mut()[0] = Lanes::splat(closure);
        }
        batch.use_only(1);
        batch.eliminate(|_| (i, block.rows.len()))?;
        Ok(batch)
    };
    let batches: Vec<BlockBatch> = blocks
        .iter()
        .enumerate()
        .map(fill)
        .collect::<Result<_, Error>>()?;
    let mut sums = LaneSums::new(SHARED, 1);
    for (block, batch) in blocks.iter().zip(&batches) {
        sums.count(block.rows.len(), block.unknowns);
        batch.add_to(&mut sums);
    }
    let solution = sums.reduced().solve(|| vec![vec![-1.0; SHARED]])?;
    let unknowns = blocks.iter().map(|block| block.unknowns);
    let mut factors = Factors::with_room(SHARED + 1, unknowns);
    let mut unknowns = Vec::new();
    for (i, mut batch) in batches.into_iter().enumerate() {
        let mut kept = vec![Lanes::ZERO; BlockBatch::kept_len(blocks[i].unknowns)];
        batch.keep(&mut kept);
        let mut rows = batch.clone();
        rows.take_off(&solution.unknowns[..SHARED]);
        let x = rows.correction(&kept);
        unknowns.extend(x.iter().map(|x| x.0[0]));
        batch.add_factors(i..i + 1, &mut factors);
    }
    unknowns.extend(&solution.unknowns[..SHARED]);
    Ok(Solved {
        unknowns,
        covariance: Covariance::new(factors, solution),
    })
}

/// Bordered normal matrix of all unknowns (blocks, shared, multiplier) and its right-hand side.
fn dense(blocks: &[Block], closure: f64) -> (DMatrix<f64>, DMatrix<f64>) {
    let own: usize = blocks.iter().map(|b| b.unknowns).sum();
    let size = own + SHARED + 1;
    let (mut matrix, mut right) = (
        DMatrix::<f64>::zeros(size, size),
        DMatrix::<f64>::zeros(size, 1),
    );
    let mut first = 0;
    for block in blocks {
        let column = |k: usize| {
            if k < block.unknowns {
                first + k
            } else {
                own + k - block.unknowns
            }
        };
        let width = block.unknowns + SHARED;
        for row in &block.rows {
            for i in 0..width {
                right[(column(i), 0)] += row[i] * row[width];
                for j in 0..width {
                    matrix[(column(i), column(j))] += row[i] * row[j];
                }
            }
        }
        matrix[(first, size - 1)] = 1.0;
        matrix[(size - 1, first)] = 1.0;
        first += block.unknowns;
    }
    right[(size - 1, 0)] = closure;
    (matrix, right)
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 64,
        rng_seed: RngSeed::Fixed(1),
        ..ProptestConfig::default()
    })]

    #[test]
    fn arrowhead_equals_the_dense_bordered_system(blocks in blocks(), closure in -1.0..1.0) {
        let (matrix, right) = dense(&blocks, closure);
        let lu = matrix.clone().full_piv_lu();
        // Random geometries that are close to singular say nothing about the algorithm.
        let inverse = lu.try_inverse();
        prop_assume!(inverse.is_some());
        let inverse = inverse.unwrap();
        let expected = lu.solve(&right).unwrap();
        let size = inverse.amax();
        prop_assume!(size < 1e4);
        let tol = 1e-9 * size.max(1.0);

        let solved = solve_arrowhead(&blocks, closure).unwrap();
        let own = matrix.nrows() - SHARED - 1;
        let mut first = 0;
        for (i, block) in blocks.iter().enumerate() {
            for k in 0..block.unknowns {
                let found = solved.unknowns[first + k];
                prop_assert!((found - expected[(first + k, 0)]).abs() < tol);
            }
            let covariance = solved.covariance.block(i);
            let coupling = solved.covariance.factors.coupling_transposed(i);
            let with_shared = -coupling.tr_mul(solved.covariance.reduced_inverse());
            for k in 0..block.unknowns {
                for j in 0..block.unknowns {
                    prop_assert!((covariance[(k, j)] - inverse[(first + k, first + j)]).abs() < tol);
                }
                for j in 0..SHARED {
                    prop_assert!((with_shared[(k, j)] - inverse[(first + k, own + j)]).abs() < tol);
                }
                let mut before = 0;
                for (other, block) in blocks[..i].iter().enumerate() {
                    let of_other = solved.covariance.factors.coupling_transposed(other);
                    let between = -&with_shared * of_other;
                    for j in 0..block.unknowns {
                        let expected = inverse[(first + k, before + j)];
                        prop_assert!((between[(k, j)] - expected).abs() < tol);
                    }
                    before += block.unknowns;
                }
            }
            first += block.unknowns;
        }
        for k in 0..SHARED {
            prop_assert!((solved.unknowns[own + k] - expected[(own + k, 0)]).abs() < tol);
            for j in 0..SHARED {
                let found = solved.covariance.shared()[(k, j)];
                prop_assert!((found - inverse[(own + k, own + j)]).abs() < tol);
            }
        }
    }
}

#[test]
fn a_defect_beyond_the_datum_is_named() {
    // Shared unknown 2 never appears; the datum takes care of the other free motion.
    let rows = |a: f64| {
        vec![
            vec![1.0 + a, 1.0, a, 0.0, 0.3],
            vec![2.0, 1.0 - a, 1.0 + a, 0.0, 0.1],
        ]
    };
    let blocks: Vec<Block> = [0.1, 0.5, -0.7, 0.9]
        .into_iter()
        .map(|a| Block {
            unknowns: 1,
            rows: rows(a),
        })
        .collect();
    let Err(Error::SharedRank { defect, free, .. }) = solve_arrowhead(&blocks, 0.0) else {
        panic!("an unknown without any row must be refused");
    };
    assert_eq!(defect, 1);
    assert_eq!(free[0].0, 2);
    // Not all of it: the datum's own motion moves this unknown, too.
    assert!(free[0].1 > 0.6, "{free:?}");
}
