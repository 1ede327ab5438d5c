//! Declared thermal expansion of axes, from and to `machine.axes`.

use trueaxis_files::{Alternatives, DocumentError, DocumentProblem};

use crate::logged::LOGGED_COLUMNS;
use crate::setup::check_sigma;
use crate::{AxisExpansion, AxisKindSpec, AxisSpec, Error, Lengths, LoggedQuantity, MachineSpec};

/// A smaller coefficient than this, ppm/K, is one in 1/K: even glass ceramics for scales are known no better.
const LEAST_PPM_PER_K: f64 = 1e-3;

/// No material of machines expands more, ppm/K; polymers do.
const LARGEST_PPM_PER_K: f64 = 100.0;

impl MachineSpec {
    /// The thermal expansion of the axes that declare it.
    ///
    /// # Errors
    /// With the path of the field in a document that has this machine as `machine`.
    pub fn expansions(&self) -> Result<Vec<AxisExpansion>, Error> {
        let axes = self.axes.iter().enumerate();
        let declared: Result<Vec<_>, DocumentError> =
            axes.map(|(axis, spec)| expansion(axis, spec)).collect();
        Ok(declared?.into_iter().flatten().collect())
    }

    /// The same machine with these expansions declared.
    pub(crate) fn with_expansions(mut self, expansions: &[AxisExpansion]) -> Self {
        for expansion in expansions {
            let Some(axis) = self.axes.get_mut(expansion.axis) else {
                continue;
            };
            let column = &expansion.temperature_column;
            axis.expansion_ppm_per_k = Some(expansion.ppm_per_k);
            axis.temperature_column =
                (column != AxisExpansion::DEFAULT_COLUMN).then(|| column.clone());
            axis.temperature_sigma_k = expansion.temperature_sigma_k;
        }
        self
    }
}

fn expansion(axis: usize, spec: &AxisSpec) -> Result<Option<AxisExpansion>, DocumentError> {
    let path = format!("machine.axes[{axis}]");
    let refused = |field: &str, found: String, expected: &str| {
        let problem = DocumentProblem::value(found, expected);
        Err(problem.in_field(format!("{path}.{field}")))
    };
    let Some(ppm_per_k) = spec.expansion_ppm_per_k else {
        if spec.temperature_column.is_some() || spec.temperature_sigma_k.is_some() {
            return Err(DocumentProblem::missing("expansion_ppm_per_k").in_field(path));
        }
        return Ok(None);
    };
    if spec.kind == AxisKindSpec::Rotary {
        let found = format!("axis {} is rotary and has an expansion", spec.name);
        let expected = "an expansion of linear axes only; remove it";
        return refused("expansion_ppm_per_k", found, expected);
    }
    let size = ppm_per_k.abs();
    if size > LARGEST_PPM_PER_K || (size > 0.0 && size < LEAST_PPM_PER_K) {
        let found = format!("an expansion of {ppm_per_k} ppm/K");
        let expected = "a coefficient in um per m and K, such as 11.5 for steel";
        return refused("expansion_ppm_per_k", found, expected);
    }
    let field = format!("{path}.temperature_sigma_k");
    let sigma_k = spec.temperature_sigma_k;
    check_sigma(field, "standard uncertainty", sigma_k, " K", false)?;
    let column = spec.temperature_column.as_deref();
    let column = column.unwrap_or(AxisExpansion::DEFAULT_COLUMN);
    if !LoggedQuantity::is_temperature(column) {
        let known = LOGGED_COLUMNS.iter().filter(|name| name.contains("_temp_"));
        let problem = DocumentProblem::unknown_name("temperature column", column, known);
        return Err(problem.in_field(format!("{path}.temperature_column")));
    }
    Ok(Some(AxisExpansion {
        axis,
        ppm_per_k,
        temperature_column: column.to_owned(),
        temperature_sigma_k: spec.temperature_sigma_k,
        lengths_hold_at_c: None,
    }))
}

/// Refuses an expansion whose temperature the file `name` does not hold.
pub(crate) fn check_columns(
    name: &str,
    expansions: &[AxisExpansion],
    lengths: &Lengths,
) -> Result<(), DocumentError> {
    for expansion in expansions {
        let column = &expansion.temperature_column;
        if lengths.logged_column(column).is_none() {
            let logged = lengths.logged.iter().map(|column| column.name.as_str());
            let temperatures = logged.filter(|column| LoggedQuantity::is_temperature(column));
            let found = format!("{name} has no column `{column}`");
            let expected = format!(
                "a column with the temperature of the axis; {}",
                Alternatives::new(column, temperatures)
            );
            let field = format!("machine.axes[{}].temperature_column", expansion.axis);
            return Err(DocumentProblem::value(found, expected).in_field(field));
        }
    }
    Ok(())
}
