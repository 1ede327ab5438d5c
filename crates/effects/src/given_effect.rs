//! One effect with its values, by name, as files hold it.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use trueaxis_files::index_of;

use crate::error::Problem;
use crate::shape::{from_file, shape_parameter};
use crate::{Effect, Error, GivenSubject, Parameter, ResolvedEffect, Scene, catalogue};

/// An effect that happened: which, to what, how much and when.
///
/// ```json
/// { "effect": "station_jump", "subject": { "station": "S2" },
///   "parameters": [ { "name": "jump_x", "value": 3.1, "unit": "um" },
///                   { "name": "jump_y", "value": 0, "unit": "um" },
///                   { "name": "jump_z", "value": -1.2, "unit": "um" },
///                   { "name": "time", "value": 5210.0, "unit": "s" } ] }
/// ```
///
/// The parameters are all linear ones of the effect ([`Effect::parameters`]) and, where it has one, its
/// shape: `time` (s, on the clock of the campaign) of what happens at an instant, `time_constant` (s),
/// `period` (mm, or deg of a rotary axis) or `waves` (per turn), in any order.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object: an effect")]
pub struct GivenEffect {
    /// Its name in the catalogue, such as `station_jump`.
    pub effect: String,
    /// What it happens to.
    #[serde(default)]
    pub subject: GivenSubject,
    /// Its values.
    pub parameters: Vec<GivenParameter>,
}

/// The value of a parameter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object: a parameter")]
pub struct GivenParameter {
    /// Its name, such as `jump_x`.
    pub name: String,
    /// Its value.
    pub value: f64,
    /// Standard uncertainty of the value, where it was estimated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub u: Option<f64>,
    /// Its unit, such as `um`.
    pub unit: String,
}

impl GivenEffect {
    /// The effect in a scene: names become indices, values stand in the order of the catalogue.
    ///
    /// # Errors
    /// If effect, subject or a parameter is unknown, if the effect cannot act on the subject, if a
    /// parameter is missing, is there twice, has another unit than its own or an impossible value.
    pub fn resolve(&self, scene: &Scene) -> Result<ResolvedEffect, Error> {
        Ok(self.resolve_with_places(scene)?.0)
    }

    /// The effect in a scene, and where each of its linear parameters stands in the list.
    pub(crate) fn resolve_with_places(
        &self,
        scene: &Scene,
    ) -> Result<(ResolvedEffect, Vec<usize>), Error> {
        let effect = self.catalogued()?;
        let subject = self.subject.resolve(scene)?;
        self.subject.check_fits(effect, &subject, scene)?;

        // The linear parameters, behind them the shape.
        let mut expected = effect.parameters(scene, &subject);
        let linear_count = expected.len();
        let shape = shape_parameter(effect, scene, &subject);
        expected.extend(shape.clone());
        let mut places = self.places(effect, &expected)?;
        self.check_numbers()?;
        let shape = match shape.zip(places.get(linear_count)) {
            Some((parameter, &place)) => {
                let value = self.parameters[place].value;
                let checked = effect.shape.check(value);
                checked.map_err(|problem| problem.at(value_field(place)))?;
                from_file(&parameter, value)
            }
            None => 0.0,
        };
        places.truncate(linear_count);
        let resolved = ResolvedEffect {
            effect,
            subject,
            parameters: places.iter().map(|&i| self.parameters[i].value).collect(),
            shape,
        };
        Ok((resolved, places))
    }

    pub(crate) fn catalogued(&self) -> Result<&'static Effect, Error> {
        let effects = catalogue();
        let names: Vec<&str> = effects.iter().map(|effect| effect.id).collect();
        Ok(effects[index_of("effect", "effect", &self.effect, &names)?])
    }

    /// Where each expected parameter stands in the list, which must hold it once and nothing else.
    fn places(&self, effect: &'static Effect, expected: &[Parameter]) -> Result<Vec<usize>, Error> {
        let names: Vec<&str> = expected.iter().map(|p| p.name.as_str()).collect();
        let mut places = vec![None; expected.len()];
        for (i, given) in self.parameters.iter().enumerate() {
            let field = |name: &str| format!("parameters[{i}].{name}");
            let index = index_of(field("name"), "parameter", &given.name, &names)?;
            let name = given.name.clone();
            if places[index].replace(i).is_some() {
                return Err(Problem::DuplicateParameter { name }.at(field("name")));
            }
            let (expected, found) = (expected[index].unit, given.unit.clone());
            if found != expected {
                let problem = Problem::Unit {
                    name,
                    expected,
                    found,
                };
                return Err(problem.at(field("unit")));
            }
        }
        let missing = |parameter: &Parameter| Problem::MissingParameter {
            effect: effect.id,
            name: parameter.name.clone(),
            unit: parameter.unit,
        };
        let placed = expected.iter().zip(places);
        placed
            .map(|(parameter, place)| place.ok_or_else(|| missing(parameter).at("parameters")))
            .collect()
    }

    /// Refuses values that are not finite and uncertainties that are negative or not finite.
    pub(crate) fn check_numbers(&self) -> Result<(), Error> {
        for (i, &GivenParameter { value, u, .. }) in self.parameters.iter().enumerate() {
            if !value.is_finite() {
                let expected = "a finite number";
                return Err(Problem::Value { value, expected }.at(value_field(i)));
            }
            if let Some(value) = u.filter(|u| !(u.is_finite() && *u >= 0.0)) {
                let expected = "a standard uncertainty, zero or more";
                return Err(Problem::Value { value, expected }.at(format!("parameters[{i}].u")));
            }
        }
        Ok(())
    }
}

fn value_field(index: usize) -> String {
    format!("parameters[{index}].value")
}

/// All effects in a scene, in their order.
///
/// # Errors
/// As [`GivenEffect::resolve`]; the paths of fields begin with `effects[0]` and so on.
pub fn resolve_all(effects: &[GivenEffect], scene: &Scene) -> Result<Vec<ResolvedEffect>, Error> {
    let numbered = effects.iter().enumerate();
    numbered
        .map(|(i, given)| {
            let resolved = given.resolve(scene);
            resolved.map_err(|error| error.within(&format!("effects[{i}]")))
        })
        .collect()
}
