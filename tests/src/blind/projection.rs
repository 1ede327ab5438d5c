//! What of a disturbance is left when the base model has taken all it can.
//!
//! The base model: rigid stages whose six pose parameters are free at every step (common to all
//! stations, repeats and directions), targets, those on the bed too, stations, dead paths and constants of reflectors,
//! with the covariance `σ² I + ρ² U Uᵀ` of the lengths of a stop (U: unit vectors, ρ: repeatability error, none on the bed). With W its inverse
//! root, the strength of a change `Δl` of the lengths is
//!
//! ```text
//! λ = |P W Δl|,    P = I - Q Qᵀ,    Q an orthonormal base of the columns of W J
//! ```
//!
//! and λ² is what it adds to the sum of squares on average. Everything here is numerical: J and U are
//! central differences of exact distances, and Q is made by QR factorisations, first of the poses of
//! each step alone.

use std::ops::Range;

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use trueaxis_kinematics::MICROMETRE;

use super::derivatives::Derivatives;
use super::experiment::Experiment;

/// The projection that leaves what the base model cannot take.
#[derive(Debug)]
pub(super) struct Projection {
    stops: Vec<StopWeight>,
    steps: Vec<StepPoses>,
    shared: DMatrix<f64>,
}

/// Root of the covariance of the lengths of a stop.
#[derive(Debug)]
struct StopWeight {
    rows: Range<usize>,
    root: Cholesky<f64, Dyn>,
}

/// What the poses of a step can take.
#[derive(Debug)]
struct StepPoses {
    rows: Vec<usize>,
    base: DMatrix<f64>,
}

impl Projection {
    pub(super) fn new(experiment: &Experiment) -> Self {
        let derivatives = Derivatives::new(experiment);
        let mut poses = derivatives.poses();
        let mut shared = derivatives.shared();
        let stops = StopWeight::all(experiment, &poses);
        for stop in &stops {
            stop.whiten(&mut poses);
            stop.whiten(&mut shared);
        }
        let steps = &experiment.schedule.steps;
        let of_runs = (0..steps.len()).filter(|&step| steps[step].run.is_some());
        let steps: Vec<StepPoses> = of_runs
            .map(|step| StepPoses::new(derivatives.rows_of(step), &poses))
            .collect();
        for step in &steps {
            step.eliminate(&mut shared);
        }
        Self {
            stops,
            steps,
            shared: shared.qr().q(),
        }
    }

    /// `P W Δl` of changes of the lengths in mm, without unit.
    pub(super) fn residuals(&self, change_mm: &[f64]) -> DVector<f64> {
        let mut change = DMatrix::from_column_slice(change_mm.len(), 1, change_mm);
        self.stops.iter().for_each(|stop| stop.whiten(&mut change));
        self.steps
            .iter()
            .for_each(|step| step.eliminate(&mut change));
        let taken = &self.shared * self.shared.tr_mul(&change);
        (change - taken).column(0).into_owned()
    }

    /// Number of lengths minus number of parameters.
    #[cfg(test)]
    pub(super) fn degrees_of_freedom(&self) -> usize {
        let poses: usize = self.steps.iter().map(|step| step.base.ncols()).sum();
        self.shared.nrows() - poses - self.shared.ncols()
    }
}

impl StopWeight {
    /// Of all stops; the first three columns of the poses are U.
    fn all(experiment: &Experiment, poses: &DMatrix<f64>) -> Vec<Self> {
        let noise = experiment.kind.noise;
        let length_mm = noise.length_um * MICROMETRE;
        let return_mm = noise.return_um * MICROMETRE;
        let mut first = 0;
        let stops = experiment.schedule.visits.iter().map(|visit| {
            let rows = first..first + visit.readings.len();
            first = rows.end;
            let u = poses.view((rows.start, 0), (rows.len(), 3));
            let return_mm = match experiment.schedule.is_of_bed(visit) {
                true => 0.0,
                false => return_mm,
            };
            let own = DMatrix::identity(rows.len(), rows.len()) * length_mm.powi(2);
            let root = Cholesky::new(own + u * u.transpose() * return_mm.powi(2));
            Self {
                rows,
                root: root.expect("every length has noise of its own"),
            }
        });
        stops.collect()
    }

    /// Multiplies the stop's rows by the inverse root of their covariance.
    fn whiten(&self, columns: &mut DMatrix<f64>) {
        let mut rows = columns.rows_mut(self.rows.start, self.rows.len());
        // The root of a positive definite matrix has no zero on its diagonal.
        self.root.l_dirty().solve_lower_triangular_mut(&mut rows);
    }
}

impl StepPoses {
    fn new(rows: Vec<usize>, poses: &DMatrix<f64>) -> Self {
        let base = poses.select_rows(&rows).qr().q();
        Self { rows, base }
    }

    /// Takes out of the step's rows what its pose can take.
    fn eliminate(&self, columns: &mut DMatrix<f64>) {
        let own = columns.select_rows(&self.rows);
        let left = &own - &self.base * self.base.tr_mul(&own);
        for (i, &row) in self.rows.iter().enumerate() {
            columns.set_row(row, &left.row(i));
        }
    }
}
