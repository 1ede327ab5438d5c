//! What an effect happens to, by name.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use trueaxis_files::index_of;
use trueaxis_kinematics::{Axis, Component};

use crate::error::Problem;
use crate::{Effect, Error, Scene, Subject};

/// Subjects listed in a message; a bending stage alone has one for each axis and target.
const LISTED_AT_MOST: usize = 12;

/// Station, target and axes that an effect concerns, by name; none where it concerns all alike.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Default, Serialize, Deserialize, JsonSchema)]
#[serde(
    default,
    deny_unknown_fields,
    expecting = "an object: what the effect happens to"
)]
pub struct GivenSubject {
    /// The station, such as `S2`.
    pub station: Option<String>,
    /// The target, such as `P`.
    pub target: Option<String>,
    /// The axis, such as `X`.
    pub axis: Option<String>,
    /// The axis on whose position the error of the first one depends.
    pub other_axis: Option<String>,
    /// The component error of the axis by its ISO 230-1 name, such as `EXX`.
    pub component: Option<String>,
    /// The axis that carries the targets concerned, such as `Z`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub carrier: Option<String>,
    /// The column of the temperature that it goes with, such as `machine_temp_spindle_c`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub column: Option<String>,
}

impl GivenSubject {
    /// The names of a subject; what the scene does not have is left out.
    pub fn new(subject: &Subject, scene: &Scene) -> Self {
        let axes = scene.machine.axes();
        let axis = |index: usize| axes.get(index).map(|axis| axis.name().to_owned());
        let station = |index: usize| scene.stations.get(index).cloned();
        let target = |index: usize| Some(scene.targets.get(index)?.name.clone());
        let column = |index: usize| Some(scene.temperatures.get(index)?.column.clone());
        let names_component = |component: Component| {
            let axis = axes.get(subject.axis?)?;
            Some(component.name(axis.name()))
        };
        Self {
            station: subject.station.and_then(station),
            target: subject.target.and_then(target),
            axis: subject.axis.and_then(axis),
            other_axis: subject.other_axis.and_then(axis),
            component: subject.component.and_then(names_component),
            carrier: subject.carrier.and_then(axis),
            column: subject.column.and_then(column),
        }
    }

    /// The subject by index.
    pub(crate) fn resolve(&self, scene: &Scene) -> Result<Subject, Error> {
        let axes: Vec<&str> = scene.machine.axes().iter().map(Axis::name).collect();
        let stations: Vec<&str> = scene.stations.iter().map(String::as_str).collect();
        let targets: Vec<&str> = scene.targets.iter().map(|t| t.name.as_str()).collect();
        let temperatures = scene.temperatures.iter();
        let columns: Vec<&str> = temperatures.map(|t| t.column.as_str()).collect();
        let index = |field: &str, what, name: &Option<String>, known: &[&str]| {
            let name = name.as_deref();
            name.map(|name| index_of(format!("subject.{field}"), what, name, known))
                .transpose()
        };
        Ok(Subject {
            station: index("station", "station", &self.station, &stations)?,
            target: index("target", "target", &self.target, &targets)?,
            axis: index("axis", "axis", &self.axis, &axes)?,
            other_axis: index("other_axis", "axis", &self.other_axis, &axes)?,
            component: self.resolve_component(&axes)?,
            carrier: index("carrier", "axis", &self.carrier, &axes)?,
            column: index("column", "logged temperature", &self.column, &columns)?,
        })
    }

    /// The component by its name for the subject's axis, or for any if it has none.
    fn resolve_component(&self, axes: &[&str]) -> Result<Option<Component>, Error> {
        let Some(name) = &self.component else {
            return Ok(None);
        };
        let own = axes
            .iter()
            .filter(|&&axis| self.axis.as_deref().is_none_or(|own| own == axis));
        let names: Vec<String> = own
            .flat_map(|axis| Component::ALL.map(|component| component.name(axis)))
            .collect();
        let known: Vec<&str> = names.iter().map(String::as_str).collect();
        let index = index_of("subject.component", "component error", name, &known)?;
        Ok(Some(Component::ALL[index % Component::ALL.len()]))
    }

    /// Refuses a subject that the effect cannot act on in this scene; `subject` is this one by index.
    pub(crate) fn check_fits(
        &self,
        effect: &'static Effect,
        subject: &Subject,
        scene: &Scene,
    ) -> Result<(), Error> {
        let possible = effect.subjects(scene);
        if possible.contains(subject) {
            return Ok(());
        }
        let describe = |subject: &Subject| format!("({})", Self::new(subject, scene).describe());
        let mut list: Vec<String> = possible.iter().take(LISTED_AT_MOST).map(describe).collect();
        if possible.len() > LISTED_AT_MOST {
            list.push(format!("... ({} in all)", possible.len()));
        }
        if possible.is_empty() {
            list.push("nothing".to_owned());
        }
        let problem = Problem::Subject {
            effect: effect.id,
            found: self.describe(),
            possible: list.join(", "),
        };
        Err(problem.at("subject"))
    }

    /// As a message shows it: `axis X, target P`, or `all alike`.
    pub fn describe(&self) -> String {
        let parts = [
            ("station", &self.station),
            ("target", &self.target),
            ("axis", &self.axis),
            ("other_axis", &self.other_axis),
            ("component", &self.component),
            ("carrier", &self.carrier),
            ("column", &self.column),
        ];
        let named: Vec<String> = parts
            .iter()
            .filter_map(|(what, name)| Some(format!("{what} {}", (*name).as_ref()?)))
            .collect();
        if named.is_empty() {
            "all alike".to_owned()
        } else {
            named.join(", ")
        }
    }
}
