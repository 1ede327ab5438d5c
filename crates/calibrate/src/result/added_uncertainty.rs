//! An independent error of all results beside the noise of the measurement.

use std::collections::HashMap;

use trueaxis_kinematics::{LocationError, Machine};

use crate::result::budget::Budget;
use crate::result::calibration::{AxisResult, Calibration};

impl Calibration {
    /// Adds an error of the calibrated `machine`, fully correlated among all results. `change` is its standard
    /// deviation (mm, rad) in each result that gauge or frame do not define, in the order of
    /// [`Calibration::results`], `part` its part of the budget. It counts as known: degrees of freedom grow.
    ///
    /// # Panics
    /// If there is not one number for each of these results.
    pub(crate) fn add_uncertainty(
        &mut self,
        machine: &Machine,
        change: &[f64],
        part: impl Fn(&mut Budget) -> &mut f64,
    ) {
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
        self.add_to_relative_locations(machine, &change, &part);
        for (change, (u, dof, budget)) in change.iter().zip(self.uncertainties_mut()) {
            add(change * change, u, dof, budget.map(&part));
        }
    }

    /// u and degrees of freedom of all results in their order, with the budget where there is one.
    fn uncertainties_mut(&mut self) -> Vec<(&mut f64, &mut f64, Option<&mut Budget>)> {
        let (mut all, mut locations) = (Vec::new(), Vec::new());
        for axis in &mut self.axes {
            for node in &mut axis.nodes {
                let of_node = node.u.iter_mut().zip(&mut node.dof).zip(&mut node.budget);
                all.extend(of_node.map(|((u, dof), budget)| (u, dof, Some(budget))));
            }
            let of_axis = axis.location_errors.iter_mut();
            locations.extend(of_axis.map(|l| (&mut l.u, &mut l.dof, Some(&mut l.budget))));
        }
        all.append(&mut locations);
        for station in &mut self.stations {
            let position = station.u_mm.iter_mut().zip(&mut station.dof);
            all.extend(position.map(|(u, dof)| (u, dof, None)));
            let (u, dof) = (&mut station.u_dead_path_mm, &mut station.dof_dead_path);
            all.push((u, dof, None));
        }
        all
    }

    /// Adds the error to the relative locations; `change` is in the order of [`Calibration::results`].
    fn add_to_relative_locations(
        &mut self,
        machine: &Machine,
        change: &[f64],
        part: impl Fn(&mut Budget) -> &mut f64,
    ) {
        let components: usize = self.axes.iter().map(|axis| 6 * axis.nodes.len()).sum();
        let mut changes = change[components..].iter();
        let of_axis = |axis: &AxisResult| {
            let mut location = LocationError::default();
            for (error, change) in axis.location_errors.iter().zip(&mut changes) {
                *error.component.of_mut(&mut location) = *change;
            }
            machine.axes()[axis.axis].complete_tilt(&mut location);
            (axis.name.clone(), location)
        };
        let locations: HashMap<String, LocationError> = self.axes.iter().map(of_axis).collect();
        for relative in &mut self.relative_locations {
            let [axis, to] = [&relative.axis, &relative.to].map(|name| &locations[name]);
            let [offset, angle] = relative.of(axis, to);
            for (change, found) in [(offset, &mut relative.offset), (angle, &mut relative.angle)] {
                let budget = Some(part(&mut found.budget));
                add(change * change, &mut found.u, &mut found.dof, budget);
            }
        }
    }
}

/// Adds a known variance to one result: `ν = 2 u⁴ / var(u²)` grows by the square of the ratio of `u²`.
fn add(variance: f64, u: &mut f64, dof: &mut f64, part: Option<&mut f64>) {
    if variance <= 0.0 {
        return;
    }
    let sum = *u * *u + variance;
    *dof *= (sum / (*u * *u)).powi(2);
    *u = sum.sqrt();
    if let Some(part) = part {
        *part += variance;
    }
}
