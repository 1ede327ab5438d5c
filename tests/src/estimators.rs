//! How good the estimators are: against the truth, against what they state, against the bound.

use std::collections::BTreeMap;
use std::fmt;
use std::ops::Range;

use trueaxis_calibrate::{Method, Settings, calibrate};
use trueaxis_simulate::{NoiseSpec, Scenario, simulate};

use crate::{Kind, Scatter, in_parallel};

/// The methods by name. What the first states for exact lengths with known noise is the bound for all.
pub const METHODS: [(&str, Method); 2] = [("joint", Method::Joint), ("nine", Method::Nine)];

/// The shipped scenarios by name.
pub const SCENARIOS: [(&str, &str); 3] = [
    (
        "three-axis",
        include_str!("../../campaigns/fxyz/scenario.json"),
    ),
    (
        "rotary stage",
        include_str!("../../campaigns/rotary-stage/scenario.json"),
    ),
    (
        "five-axis",
        include_str!("../../campaigns/five-axis/scenario.json"),
    ),
];

/// Standard deviation of the constants of reflectors in the study, µm: what is taken for known of them where lengths
/// leave them open.
const REFLECTOR_SIGMA_UM: f64 = 5.0;

/// What a method makes of campaigns of one scenario.
#[derive(Debug, Clone)]
pub struct Study {
    /// Name of scenario and method.
    pub name: String,
    /// Errors against the stated uncertainties.
    pub stated: Scatter,
    /// The same errors against the bound.
    pub bound: Scatter,
}

/// Sides of approach that were measured are kept apart: their lost motion is no error of the estimate.
pub fn settings(scenario: &Scenario, method: Method) -> Settings {
    let mut settings = Settings::default();
    settings.poses.method = method;
    settings.poses.by_direction = scenario.runs.iter().any(|run| run.directions.len() > 1);
    settings
}

/// Simulates campaigns and calibrates them; one of each seed.
///
/// # Errors
/// The text of the first error.
pub fn scatter(
    scenario: &Scenario,
    settings: &Settings,
    seeds: Range<u64>,
) -> Result<Scatter, String> {
    let one = |seed| {
        let simulated = simulate(scenario, seed).map_err(|error| error.to_string())?;
        let calibration = calibrate(&simulated.campaign, settings);
        let calibration = calibration.map_err(|error| format!("seed {seed}: {error}"))?;
        let mut scatter = Scatter::default();
        scatter.add(&calibration, &simulated.truth);
        Ok(scatter.campaigns)
    };
    let campaigns: Result<Vec<_>, String> = in_parallel(seeds, one).into_iter().collect();
    Ok(Scatter {
        campaigns: campaigns?.concat(),
    })
}

/// The shipped scenarios, with reflectors drawn anew for each campaign, with the methods.
///
/// # Errors
/// The text of the first error.
pub fn study(methods: &[(&str, Method)], seeds: &Range<u64>) -> Result<Vec<Study>, String> {
    let mut studies = Vec::new();
    for (scenario_name, text) in SCENARIOS {
        let mut scenario = Scenario::from_json(text).map_err(|error| error.to_string())?;
        scenario.systematic.reflector_sigma_um = Some(REFLECTOR_SIGMA_UM);
        let bound = known_noise(&scenario, METHODS[0].1)?;
        for (method_name, method) in methods {
            let stated = scatter(&scenario, &settings(&scenario, *method), seeds.clone())?;
            let mut against_bound = stated.with_u(|deviation| bound[&deviation.name]);
            let all = against_bound.campaigns.iter_mut().flatten();
            all.for_each(|deviation| deviation.dof = f64::INFINITY);
            studies.push(Study {
                name: format!("{scenario_name}, {method_name}"),
                stated,
                bound: against_bound,
            });
        }
    }
    Ok(studies)
}

/// What is stated for exact lengths with the noise that the campaigns declare.
fn known_noise(scenario: &Scenario, method: Method) -> Result<BTreeMap<String, f64>, String> {
    let mut scenario = scenario.clone();
    scenario.noise = NoiseSpec::NONE;
    let exact = scatter(&scenario, &settings(&scenario, method), 0..1)?;
    let all = exact.campaigns.into_iter().flatten();
    Ok(all.map(|deviation| (deviation.name, deviation.u)).collect())
}

impl fmt::Display for Study {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let campaigns = self.stated.campaigns.len();
        writeln!(f, "{}, {campaigns} campaigns", self.name)?;
        let mut line = |name: &dyn fmt::Display, unit: (&str, f64), kinds: &[Kind]| {
            let stated = self.stated.pooled(|d| kinds.contains(&d.kind));
            let bound = self.bound.pooled(|d| kinds.contains(&d.kind)).ratio;
            let (rms, unit) = (stated.rms / unit.1, unit.0);
            let (value, error) = (bound.value, bound.standard_error);
            writeln!(
                f,
                "  {name:<10} rms {rms:6.3} {unit}, {value:.3} ± {error:.3} of the bound; {stated}"
            )
        };
        for kind in self.stated.kinds() {
            line(&kind, kind.unit(), &[kind])?;
        }
        Ok(())
    }
}
