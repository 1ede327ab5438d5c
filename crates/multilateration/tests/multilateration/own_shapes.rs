//! A group whose body has a shape of its own, against what freeing its targets does by definition.

use nalgebra::{DMatrix, DVector, Point3, Vector3};
use trueaxis_kinematics::centroid;
use trueaxis_multilateration::{Network, Solution, Whitened, solve};

use crate::hat_matrix::{FEW, NOISE, Places, solved};
use crate::world::{TARGETS, network, tied, truth};

/// What the adjustment leaves of displacements of the targets of some groups.
struct Freed {
    /// Of each group a column for each coordinate of its targets.
    columns: Vec<Vec<DVector<f64>>>,
    residuals: DVector<f64>,
}

impl Freed {
    fn new(network: &Network, solution: &Solution) -> Self {
        const STEP_MM: f64 = 0.1;
        let rows = Whitened::new(network, solution);
        let start = Places::of(solution);
        let column = |point: usize, axis: usize| {
            let [plus, minus] = [STEP_MM, -STEP_MM].map(|step| {
                let mut places = start.clone();
                places.points[point] += Vector3::ith(axis, step);
                places.lengths_mm(network)
            });
            let moved = plus.iter().zip(&minus);
            let mut moved: Vec<f64> = moved.map(|(a, b)| (a - b) / (2.0 * STEP_MM)).collect();
            rows.whiten(&mut moved);
            rows.project(&mut moved);
            DVector::from_vec(moved)
        };
        let of_group = |points: &std::ops::Range<usize>| {
            let coordinates = points
                .clone()
                .flat_map(|p| (0..3).map(move |axis| (p, axis)));
            coordinates.map(|(p, axis)| column(p, axis)).collect()
        };
        Self {
            columns: network.groups.iter().map(of_group).collect(),
            residuals: DVector::from_column_slice(&rows.residuals),
        }
    }

    /// By how much the sum of squares drops if all targets of these groups are free of each other, and in how many
    /// ways: rigid motions of each group are absorbed anyway.
    fn drop(&self, groups: &[usize]) -> (f64, usize) {
        let columns: Vec<DVector<f64>> = groups
            .iter()
            .flat_map(|g| self.columns[*g].clone())
            .collect();
        let columns = DMatrix::from_columns(&columns);
        let normal = columns.tr_mul(&columns).symmetric_eigen();
        let along = normal.eigenvectors.tr_mul(&columns.tr_mul(&self.residuals));
        let least = 1e-7 * normal.eigenvalues.max();
        let told = along
            .iter()
            .zip(&normal.eigenvalues)
            .filter(|(_, value)| **value > least);
        told.fold((0.0, 0), |(sum, count), (x, value)| {
            (sum + x * x / value, count + 1)
        })
    }
}

fn assert_near(found: f64, expected: f64) {
    assert!((found / expected - 1.0).abs() < 1e-3, "{found} {expected}");
}

#[test]
fn squares_drop_as_by_definition() {
    let (network, solution) = solved(FEW, NOISE, true);
    let freed = Freed::new(&network, &solution);
    let tied = (0..FEW).filter(|&g| network.body_of(g).is_some());
    let tied: Vec<usize> = tied.collect();
    let mut shapes = solution.own_shapes(&network);
    for g in 0..FEW {
        let found = shapes.test(g);
        assert_eq!(found.is_some(), tied.contains(&g), "{g}");
        let Some(found) = found else { continue };
        let (drop, degrees_of_freedom) = freed.drop(&[g]);
        assert_eq!(found.degrees_of_freedom, degrees_of_freedom);
        assert_near(found.drop, drop);
    }
    let [first, second] = [tied[2], tied[7]];
    let (alone, _) = freed.drop(&[first]);
    assert_near(shapes.free(first).unwrap(), alone);
    assert!(shapes.free(first).is_none());
    for &g in tied.iter().filter(|g| **g != first) {
        let (both, _) = freed.drop(&[first, g]);
        assert_near(shapes.test(g).unwrap().drop, both - alone);
    }
    // One that is free is what the other one leaves of it.
    assert_near(shapes.test(first).unwrap().drop, alone);
    assert!(shapes.free(second).is_some());
    let (both, _) = freed.drop(&[first, second]);
    let (other, _) = freed.drop(&[second]);
    assert_near(shapes.test(first).unwrap().drop, both - other);
}

/// Exact lengths of a triangle one target of which is 20 µm elsewhere at one step: its shape there differs by what no
/// rigid motion explains of that, and by nothing anywhere else once it is free.
#[test]
fn the_shape_of_a_moved_target_is_found() {
    const GROUP: usize = 5;
    let mut moved = truth(50.0);
    let nominal = moved.points.clone();
    let by = Vector3::new(0.012, -0.008, 0.014);
    moved.points[3 * GROUP + 1] += by;
    let network = tied(&network(&moved, nominal, 2, NOISE));
    let solution = solve(&network).unwrap();
    let mut shapes = solution.own_shapes(&network);
    assert!(shapes.free(GROUP).is_some());
    let arms = TARGETS.map(Point3::from);
    let centre = centroid(&arms);
    let motions = DMatrix::from_fn(9, 6, |i, k| {
        let unit = Vector3::ith(k % 3, 1.0);
        let turned = unit.cross(&(arms[i / 3] - centre));
        if k < 3 { unit[i % 3] } else { turned[i % 3] }
    });
    let mut left = DVector::zeros(9);
    left.fixed_rows_mut::<3>(3).copy_from(&by);
    let normal = motions.tr_mul(&motions).try_inverse().unwrap();
    left -= &motions * normal * motions.tr_mul(&left);
    let found = shapes.test(GROUP).unwrap();
    assert_eq!(found.degrees_of_freedom, 3);
    assert!(found.drop > 100.0, "{found:?}");
    assert!(
        (found.rms_mm - left.norm() / 3.0).abs() < 2e-4,
        "{found:?} {}",
        left.norm() / 3.0
    );
    for g in (0..network.groups.len()).filter(|g| *g != GROUP) {
        let other = shapes.test(g).unwrap();
        assert!(other.drop < 1e-2 && other.rms_mm < 1e-6, "{g}: {other:?}");
    }
}
