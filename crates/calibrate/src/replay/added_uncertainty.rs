//! An independent error of all results, beside the noise of the measurement.

use crate::result::budget::Budget;
use crate::result::calibration::Calibration;

impl Calibration {
    /// Adds an independent error whose standard deviation is `change` (mm and rad) in the results that are
    /// not defined by gauge or frame, in the order of [`Calibration::results`]; fully correlated among
    /// them. It counts as known: degrees of freedom grow with its share.
    ///
    /// # Panics
    /// If there is not one number for each of these results.
    pub(crate) fn add_uncertainty(&mut self, change: &[f64]) {
        let results = self.results();
        let mut changes = change.iter();
        let change: Vec<f64> = results
            .iter()
            .map(|result| match result.u > 0.0 {
                true => *changes.next().expect("one change for each result"),
                false => 0.0,
            })
            .collect();
        assert!(changes.next().is_none(), "one change for each result");
        self.factors.add_common(&change);
        if let Some(covariance) = &mut self.covariance {
            let size = |i: usize| results[i].output.unit().size();
            for j in 0..change.len() {
                for i in 0..change.len() {
                    covariance.matrix[(i, j)] += change[i] / size(i) * (change[j] / size(j));
                }
            }
        }
        let mut variances = change.iter().map(|change| change * change);
        let mut next = || variances.next().unwrap_or(0.0);
        for node in self.axes.iter_mut().flat_map(|axis| &mut axis.nodes) {
            for c in 0..6 {
                add(
                    next(),
                    &mut node.u[c],
                    &mut node.dof[c],
                    Some(&mut node.budget[c]),
                );
            }
        }
        let locations = self
            .axes
            .iter_mut()
            .flat_map(|axis| &mut axis.location_errors);
        for location in locations {
            let budget = Some(&mut location.budget);
            add(next(), &mut location.u, &mut location.dof, budget);
        }
        for station in &mut self.stations {
            for c in 0..3 {
                add(next(), &mut station.u_mm[c], &mut station.dof[c], None);
            }
            let (u, dof) = (&mut station.u_dead_path_mm, &mut station.dof_dead_path);
            add(next(), u, dof, None);
        }
    }
}

/// One result: `u²` grows, and with a part that is known `ν = 2 u⁴ / var(u²)` by the square of its ratio.
fn add(variance: f64, u: &mut f64, dof: &mut f64, budget: Option<&mut Budget>) {
    if variance <= 0.0 {
        return;
    }
    let sum = *u * *u + variance;
    *dof *= (sum / (*u * *u)).powi(2);
    *u = sum.sqrt();
    if let Some(budget) = budget {
        budget.effects += variance;
    }
}
