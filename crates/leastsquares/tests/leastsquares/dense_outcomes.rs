//! One problem for each way in which a dense adjustment can end, and what it must not depend on.

use nalgebra::DMatrix;
use proptest::prelude::*;
use trueaxis_leastsquares::Error;
use trueaxis_leastsquares::dense::{Adjusted, Model, Termination, adjust};

/// A model in as many words.
struct Residuals<R, J> {
    residuals: R,
    jacobian: J,
}

impl<R: Fn(&[f64]) -> Vec<f64>, J: Fn(&[f64]) -> Vec<Vec<f64>>> Model for Residuals<R, J> {
    fn residuals(&self, unknowns: &[f64]) -> Vec<f64> {
        (self.residuals)(unknowns)
    }

    fn jacobian(&self, unknowns: &[f64]) -> DMatrix<f64> {
        let rows = (self.jacobian)(unknowns);
        DMatrix::from_fn(rows.len(), unknowns.len(), |i, j| rows[i][j])
    }
}

fn solve(
    start: &[f64],
    residuals: impl Fn(&[f64]) -> Vec<f64>,
    jacobian: impl Fn(&[f64]) -> Vec<Vec<f64>>,
) -> Result<Adjusted, Error> {
    let model = Residuals {
        residuals,
        jacobian,
    };
    adjust(&model, start, 2000)
}

/// Rosenbrock's valley: as many residuals as unknowns, all zero at (1, 1).
#[test]
fn an_exact_fit_converges_to_rounding() {
    let adjusted = solve(
        &[-1.2, 1.0],
        |x| vec![10.0 * (x[1] - x[0] * x[0]), 1.0 - x[0]],
        |x| vec![vec![-20.0 * x[0], 10.0], vec![-1.0, 0.0]],
    )
    .unwrap();
    assert!(adjusted.termination.is_converged());
    for x in &adjusted.unknowns {
        assert!((x - 1.0).abs() < 1e-15);
    }
}

/// Brown and Dennis: large residuals at the minimum, where the sum of squares is 85822.2016 (Moré,
/// Garbow, Hillstrom, ACM Transactions on Mathematical Software 7, 1981, no. 16).
#[test]
fn large_residuals_converge_to_the_minimum() {
    let parts = |x: &[f64], i: u32| {
        let t = f64::from(i) / 5.0;
        (
            x[0] + t * x[1] - t.exp(),
            x[2] + x[3] * t.sin() - t.cos(),
            t,
        )
    };
    let adjusted = solve(
        &[25.0, 5.0, -5.0, -1.0],
        |x| {
            let residual = |i| {
                let (a, b, _) = parts(x, i);
                a * a + b * b
            };
            (1..=20).map(residual).collect()
        },
        |x| {
            let row = |i| {
                let (a, b, t) = parts(x, i);
                vec![2.0 * a, 2.0 * a * t, 2.0 * b, 2.0 * b * t.sin()]
            };
            (1..=20).map(row).collect()
        },
    )
    .unwrap();
    assert!(
        adjusted.termination.is_converged(),
        "{:?}",
        adjusted.termination
    );
    assert!((adjusted.squares - 85822.2016).abs() < 1e-4);
}

/// `x² + y² + (y² - 5)²` falls away from `(0, 0)` along y: relative curvature 1 - 5 · 2.
#[test]
fn a_saddle_is_not_called_converged() {
    let adjusted = solve(
        &[0.7, 0.0],
        |x| vec![x[0], x[1], x[1] * x[1] - 5.0],
        |x| vec![vec![1.0, 0.0], vec![0.0, 1.0], vec![0.0, 2.0 * x[1]]],
    )
    .unwrap();
    let Termination::NoMinimum { curvature } = adjusted.termination else {
        panic!("{:?}", adjusted.termination);
    };
    assert!((curvature + 9.0).abs() < 1e-3, "{curvature}");
}

/// Only the product of the first two unknowns is determined.
#[test]
fn a_free_combination_is_named() {
    let rows = [1.0, 2.0, 3.0];
    let adjusted = solve(
        &[1.0, 1.0, 1.0],
        |x| {
            rows.iter()
                .map(|t| x[0] * x[1] * t + x[2] - t * t)
                .collect()
        },
        |x| rows.iter().map(|t| vec![x[1] * t, x[0] * t, 1.0]).collect(),
    )
    .unwrap();
    let Termination::RankDefect {
        rank,
        unknowns,
        free,
        ..
    } = &adjusted.termination
    else {
        panic!("{:?}", adjusted.termination);
    };
    assert_eq!((*rank, *unknowns), (2, 3));
    assert!((free[0] - 0.5).abs() < 1e-9 && (free[1] - 0.5).abs() < 1e-9 && free[2] < 1e-9);
    assert!(adjusted.covariance.is_none());
    // What is determined is right: 4 t - 10/3.
    assert!((adjusted.unknowns[0] * adjusted.unknowns[1] - 4.0).abs() < 1e-7);
}

/// A decay to data below zero is best at an infinite rate, where the sum of squares is flat.
#[test]
fn a_runaway_is_not_called_converged() {
    let times = [1.0, 2.0, 3.0];
    for level in [0.0, -0.1] {
        let adjusted = solve(
            &[1.0],
            |x| times.iter().map(|t| (-x[0] * t).exp() - level).collect(),
            |x| times.iter().map(|t| vec![-t * (-x[0] * t).exp()]).collect(),
        )
        .unwrap();
        assert!(
            !adjusted.termination.is_converged(),
            "{:?}",
            adjusted.termination
        );
        assert!(adjusted.unknowns[0] > 30.0);
    }
}

#[test]
fn steps_turn_back_at_the_end_of_the_domain() {
    // The first step from 4 would go below zero, where the root does not exist.
    let root = |x: &[f64]| vec![x[0].sqrt() - 0.1];
    let slope = |x: &[f64]| vec![vec![0.5 / x[0].sqrt()]];
    let adjusted = solve(&[4.0], root, slope).unwrap();
    assert!(
        adjusted.termination.is_converged(),
        "{:?}",
        adjusted.termination
    );
    assert!((adjusted.unknowns[0] - 0.01).abs() < 1e-15);

    let Err(Error::NotFinite { .. }) = solve(&[-1.0], root, slope) else {
        panic!("a start outside the domain must be refused");
    };
}

/// A Jacobian of the wrong sign points uphill.
#[test]
fn a_wrong_jacobian_is_not_called_converged() {
    let adjusted = solve(&[3.0], |x| vec![x[0] - 1.0], |_| vec![vec![-1.0]]).unwrap();
    assert!(matches!(
        adjusted.termination,
        Termination::Stalled { offset, tolerance } if offset > tolerance
    ));
}

/// Differences of large numbers have more rounding than the unknowns explain. Unsaid, no step
/// lowers the sum of squares, at an offset that nothing accounts for.
#[test]
fn rounding_of_the_model_is_reckoned_with_when_stated() {
    struct Line {
        rounding: f64,
    }
    const TIMES: [f64; 4] = [1.0, 2.0, 3.0, 4.0];
    const DATA: [f64; 4] = [0.3, 0.7, 0.8, 1.3];
    const LARGE: f64 = 1e9;
    impl Model for Line {
        fn residuals(&self, unknowns: &[f64]) -> Vec<f64> {
            let rows = TIMES.iter().zip(&DATA);
            rows.map(|(t, y)| (LARGE + unknowns[0] * t) - (LARGE + y))
                .collect()
        }

        fn jacobian(&self, _: &[f64]) -> DMatrix<f64> {
            DMatrix::from_fn(TIMES.len(), 1, |i, _| TIMES[i])
        }

        fn rounding(&self) -> f64 {
            self.rounding
        }
    }
    let end = |rounding| {
        let adjusted = adjust(&Line { rounding }, &[2.0_f64.sqrt()], 2000);
        adjusted.unwrap().termination
    };
    assert!(
        matches!(end(0.0), Termination::Stalled { .. }),
        "{:?}",
        end(0.0)
    );
    let stated = 2.0 * LARGE * f64::EPSILON;
    assert!(end(stated).is_converged(), "{:?}", end(stated));
}

#[test]
fn too_few_residuals_leave_unknowns_free() {
    let sum = solve(&[1.0, 2.0], |x| vec![x[0] + x[1]], |_| vec![vec![1.0, 1.0]]).unwrap();
    assert!(matches!(
        sum.termination,
        Termination::RankDefect {
            rank: 1,
            unknowns: 2,
            ..
        }
    ));
    let none = solve(&[1.0], |_| vec![], |_| vec![]).unwrap();
    assert!(matches!(
        none.termination,
        Termination::RankDefect {
            rank: 0,
            unknowns: 1,
            ..
        }
    ));
}

#[test]
fn used_up_iterations_are_told() {
    let model = Residuals {
        residuals: |x: &[f64]| vec![x[0].exp() - 2.0],
        jacobian: |x: &[f64]| vec![vec![x[0].exp()]],
    };
    let adjusted = adjust(&model, &[5.0], 2).unwrap();
    assert!(matches!(
        adjusted.termination,
        Termination::MaxIterations { offset, tolerance } if offset > tolerance
    ));
    assert_eq!(adjusted.iterations, 2);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 32, ..ProptestConfig::default() })]

    /// Units of the unknowns and of the residuals that are powers of two change no bit of the
    /// result: nothing depends on scale.
    #[test]
    fn scales_change_nothing(powers in prop::array::uniform3(-30_i32..30), rate in 0.2..3.0_f64) {
        let [amount_unit, rate_unit, residual_unit] = powers.map(|power| 2.0_f64.powi(power));
        let data: Vec<(f64, f64)> = (0..8)
            .map(|i| f64::from(i) / 4.0)
            .map(|t| (t, 3.0 * (-t).exp() + 0.2 * (7.0 * t).sin()))
            .collect();
        let in_units = |amount_unit: f64, rate_unit: f64, residual_unit: f64| {
            solve(
                &[5.0 * amount_unit, rate * rate_unit],
                |x| {
                    let residual = |(t, y): &(f64, f64)| {
                        x[0] / amount_unit * (-x[1] / rate_unit * t).exp() - y
                    };
                    data.iter().map(|row| residual(row) * residual_unit).collect()
                },
                |x| {
                    let row = |(t, _): &(f64, f64)| {
                        let decay = (-x[1] / rate_unit * t).exp() * residual_unit;
                        vec![
                            decay / amount_unit,
                            -t * (x[0] / amount_unit) * decay / rate_unit,
                        ]
                    };
                    data.iter().map(row).collect()
                },
            )
            .unwrap()
        };
        let plain = in_units(1.0, 1.0, 1.0);
        let scaled = in_units(amount_unit, rate_unit, residual_unit);
        prop_assert!(plain.termination.is_converged());
        prop_assert_eq!(plain.iterations, scaled.iterations);
        let back = [scaled.unknowns[0] / amount_unit, scaled.unknowns[1] / rate_unit];
        prop_assert_eq!(&plain.unknowns[..], &back[..]);
    }
}
