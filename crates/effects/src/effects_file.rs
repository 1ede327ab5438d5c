//! `trueaxis-effects`: what a diagnosis found, for `simulate` to replay and `calibrate` to take out.
//!
//! ```json
//! { "format": "trueaxis-effects", "version": 1, "campaign": "FXYZ machine",
//!   "effects": [ { "effect": "dead_path_jump", "subject": { "station": "S2" },
//!                  "parameters": [ { "name": "jump", "value": 4.2, "u": 0.1, "unit": "um" },
//!                                  { "name": "time", "value": 5210.0, "unit": "s" } ] } ],
//!   "covariance": [[0.01]] }
//! ```

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use trueaxis_files::{DocumentProblem, Format};

use crate::error::Problem;
use crate::{Error, GivenEffect, ResolvedEffect, Scene};

/// Effects of one campaign.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct EffectsFile {
    /// Name of the campaign.
    pub campaign: String,
    /// The effects.
    pub effects: Vec<GivenEffect>,
    /// Covariance of all linear parameters of all effects, in the order in which they stand in
    /// `effects` and in the products of their units; shapes (such as `time`) have no part in it.
    pub covariance: Option<Vec<Vec<f64>>>,
}

/// Effects in a scene.
#[derive(Debug, Clone)]
pub struct ResolvedEffects {
    /// The effects.
    pub effects: Vec<ResolvedEffect>,
    /// Covariance of all [`ResolvedEffect::parameters`], effect after effect.
    pub covariance: Option<Vec<Vec<f64>>>,
}

/// Difference of mirrored elements in units of `√(C_ii C_jj)`: what the rounding of an estimator may
/// leave, far below anything that a covariance means.
const SYMMETRY_TOL: f64 = 1e-9;

impl EffectsFile {
    /// The format.
    pub const FORMAT: Format = Format {
        name: "trueaxis-effects",
        version: 1,
        noun: "an effects file",
    };

    /// Effects that are independent of each other, each with the covariance of its linear parameters.
    pub fn of_independent(
        campaign: String,
        effects: impl IntoIterator<Item = (GivenEffect, Vec<Vec<f64>>)>,
    ) -> Self {
        let (effects, blocks): (Vec<GivenEffect>, Vec<Vec<Vec<f64>>>) = effects.into_iter().unzip();
        let size = blocks.iter().map(Vec::len).sum();
        let mut covariance = vec![vec![0.0; size]; size];
        let mut first = 0;
        for block in blocks {
            for (row, values) in block.iter().enumerate() {
                let width = values.len().min(block.len());
                covariance[first + row][first..first + width].copy_from_slice(&values[..width]);
            }
            first += block.len();
        }
        Self {
            campaign,
            effects,
            covariance: Some(covariance),
        }
    }

    /// The JSON Schema of the file.
    pub fn schema() -> String {
        Self::FORMAT.schema::<Document>()
    }

    /// Reads the text of a file and checks its header, the effects' names, the numbers and the
    /// covariance; subjects and parameters are checked by [`EffectsFile::resolve`].
    ///
    /// # Errors
    /// With the field that is wrong.
    pub fn from_json(text: &str) -> Result<Self, Error> {
        let document: Document = Self::FORMAT.read(text, None)?;
        let file = Self {
            campaign: document.campaign,
            effects: document.effects,
            covariance: document.covariance,
        };
        file.check()?;
        Ok(file)
    }

    /// The text of the file; numbers come back as they are.
    ///
    /// # Errors
    /// As [`EffectsFile::from_json`]: what is written can be read.
    pub fn to_json(&self) -> Result<String, Error> {
        self.check()?;
        let document = Document {
            format: Self::FORMAT.name.to_owned(),
            version: Self::FORMAT.version,
            campaign: self.campaign.clone(),
            effects: self.effects.clone(),
            covariance: self.covariance.clone(),
        };
        trueaxis_files::to_json(&document).map_err(|error| {
            let problem = DocumentProblem::Syntax {
                problem: error.to_string(),
            };
            problem.in_field("effects").into()
        })
    }

    /// The effects in a scene; the covariance in the order of the resolved parameters.
    ///
    /// # Errors
    /// As [`GivenEffect::resolve`] and [`EffectsFile::from_json`]; paths begin with `effects[0]` and so
    /// on.
    pub fn resolve(&self, scene: &Scene) -> Result<ResolvedEffects, Error> {
        self.check()?;
        let mut effects = Vec::with_capacity(self.effects.len());
        // For each resolved parameter, its row in the covariance of the file.
        let mut rows = Vec::new();
        for (i, given) in self.effects.iter().enumerate() {
            let (resolved, places) = given
                .resolve_with_places(scene)
                .map_err(|error| error.within(&format!("effects[{i}]")))?;
            let first = rows.len();
            let rank = |place| places.iter().filter(|&&other| other < place).count();
            rows.extend(places.iter().map(|&place| first + rank(place)));
            effects.push(resolved);
        }
        let covariance = self.covariance.as_ref().map(|given| {
            let row = |&i: &usize| rows.iter().map(|&j| given[i][j]).collect();
            rows.iter().map(row).collect()
        });
        Ok(ResolvedEffects {
            effects,
            covariance,
        })
    }

    fn check(&self) -> Result<(), Error> {
        let mut linear_count = 0;
        for (i, given) in self.effects.iter().enumerate() {
            let effect = given
                .check_numbers()
                .and_then(|()| given.catalogued())
                .map_err(|error| error.within(&format!("effects[{i}]")))?;
            let shape = effect.shape.name();
            let linear = given.parameters.iter();
            linear_count += linear.filter(|p| Some(p.name.as_str()) != shape).count();
        }
        match &self.covariance {
            Some(covariance) => check_covariance(covariance, linear_count),
            None => Ok(()),
        }
    }
}

/// Square, finite, with variances on the diagonal, symmetric.
fn check_covariance(covariance: &[Vec<f64>], expected: usize) -> Result<(), Error> {
    let sized = |field: String, found: usize| match found == expected {
        true => Ok(()),
        false => Err(Problem::CovarianceSize { expected, found }.at(field)),
    };
    sized("covariance".to_owned(), covariance.len())?;
    for (i, row) in covariance.iter().enumerate() {
        sized(format!("covariance[{i}]"), row.len())?;
        for (j, &value) in row.iter().enumerate() {
            let expected = match i == j {
                true if value < 0.0 => "a variance, zero or more",
                _ if !value.is_finite() => "a finite number",
                _ => continue,
            };
            return Err(Problem::Value { value, expected }.at(format!("covariance[{i}][{j}]")));
        }
    }
    for (i, row) in covariance.iter().enumerate() {
        for (column, &value) in row.iter().enumerate().take(i) {
            let mirrored = covariance[column][i];
            let size = (row[i] * covariance[column][column]).sqrt();
            if (value - mirrored).abs() > SYMMETRY_TOL * size {
                let problem = Problem::CovarianceAsymmetric {
                    column,
                    value,
                    mirrored,
                };
                return Err(problem.at(format!("covariance[{i}][{column}]")));
            }
        }
    }
    Ok(())
}

/// Effects of a campaign, with their uncertainties.
#[derive(Serialize, Deserialize, JsonSchema)]
#[serde(
    deny_unknown_fields,
    expecting = "an object: the effects of a campaign"
)]
struct Document {
    format: String,
    version: u32,
    campaign: String,
    effects: Vec<GivenEffect>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    covariance: Option<Vec<Vec<f64>>>,
}
