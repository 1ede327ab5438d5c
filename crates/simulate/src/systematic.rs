//! What is off in all readings alike: reflector constants, the scale of lengths, nests, known dead paths
//! and lengths, thermometers. It is drawn once for a campaign.
//!
//! Each part has its own stream of the random generator, and what is listed draws its deviate all the
//! same: no part changes another, nor the noise.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use trueaxis_campaign::{
    KnownDeadPath, KnownLength, Target, check_instrument, check_reflectors, reflectors,
};
use trueaxis_files::{check_names, index_of};
use trueaxis_kinematics::MICROMETRE;

use crate::noise::{Deviates, Part};
use crate::plan::Plan;
use crate::{Error, Scenario, check};

/// True standard deviations of what is drawn once for the campaign; what is not given is as declared.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(
    deny_unknown_fields,
    expecting = "an object: what is systematic in the instrument"
)]
pub struct SystematicSpec {
    /// Of the constants of reflectors that are not listed, µm; else `instrument.reflector_sigma_um`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reflector_sigma_um: Option<f64>,
    /// Of the scale of all lengths, µm per m; else `instrument.scale_sigma_ppm`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scale_sigma_ppm: Option<f64>,
    /// Of each coordinate of every nest, mm; else `targets[].position_sigma_mm`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub position_sigma_mm: Option<f64>,
}

impl SystematicSpec {
    /// Nothing is drawn.
    pub const NONE: Self = Self {
        reflector_sigma_um: Some(0.0),
        scale_sigma_ppm: Some(0.0),
        position_sigma_mm: Some(0.0),
    };

    /// Whether nothing differs from what is declared.
    pub(crate) fn is_as_declared(&self) -> bool {
        *self == Self::default()
    }
}

/// A reflector whose constant is known to the scenario.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object: a reflector")]
pub struct ReflectorSpec {
    /// Name, as targets name it; that of a target which names none.
    pub name: String,
    /// By how much every length to it is shown too long, µm.
    pub constant_um: f64,
}

/// A bar between two nests of one stage, as its certificate knows it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object: a known length")]
pub struct KnownLengthSpec {
    /// Names of the two targets.
    pub targets: [String; 2],
    /// Standard uncertainty of the length that the campaign declares, µm; it is drawn.
    pub sigma_um: f64,
}

/// The checked systematic parts of a scenario.
pub(crate) struct PlannedSystematic {
    reflector_names: Vec<String>,
    reflector_of_target: Vec<usize>,
    /// Of each reflector, if it is listed, µm.
    listed_um: Vec<Option<f64>>,
    reflector_sigma_um: f64,
    scale_sigma_ppm: f64,
    /// Of each target.
    nest_sigmas_mm: Vec<f64>,
    /// Two targets and the standard uncertainty of their distance, µm.
    known_lengths: Vec<([usize; 2], f64)>,
}

impl PlannedSystematic {
    pub(crate) fn new(scenario: &Scenario, targets: &[Target]) -> Result<Self, Error> {
        // What the campaign would be refused for.
        check_instrument(&scenario.instrument)?;
        check_reflectors(targets)?;
        let (reflector_names, reflector_of_target) = reflectors(targets);
        let own = &scenario.systematic;
        let sigma = |name, own, declared| check::sigma("systematic", name, own, declared);
        let instrument = &scenario.instrument;
        let (reflector_um, scale_ppm) = (instrument.reflector_sigma_um, instrument.scale_sigma_ppm);
        if let Some(sigma_mm) = own.position_sigma_mm {
            check::not_negative("systematic.position_sigma_mm", sigma_mm)?;
        }
        let nests = targets.iter().map(|target| {
            let sigma_mm = own.position_sigma_mm.or(target.position_sigma_mm);
            sigma_mm.unwrap_or(0.0)
        });
        Ok(Self {
            listed_um: listed(scenario, &reflector_names)?,
            reflector_names,
            reflector_of_target,
            reflector_sigma_um: sigma("reflector_sigma_um", own.reflector_sigma_um, reflector_um)?,
            scale_sigma_ppm: sigma("scale_sigma_ppm", own.scale_sigma_ppm, scale_ppm)?,
            nest_sigmas_mm: nests.collect(),
            known_lengths: known_lengths(scenario, targets)?,
        })
    }
}

fn listed(scenario: &Scenario, names: &[String]) -> Result<Vec<Option<f64>>, Error> {
    let known: Vec<&str> = names.iter().map(String::as_str).collect();
    let listed = scenario.reflectors.iter().map(|r| r.name.as_str());
    let listed: Vec<&str> = listed.collect();
    check_names("reflectors", "reflector", &listed)?;
    let mut constants_um = vec![None; names.len()];
    for (i, spec) in scenario.reflectors.iter().enumerate() {
        let field = format!("reflectors[{i}]");
        check::finite(&format!("{field}.constant_um"), &[spec.constant_um])?;
        let index = index_of(format!("{field}.name"), "reflector", &spec.name, &known)?;
        constants_um[index] = Some(spec.constant_um);
    }
    Ok(constants_um)
}

fn known_lengths(scenario: &Scenario, targets: &[Target]) -> Result<Vec<([usize; 2], f64)>, Error> {
    let names: Vec<&str> = targets.iter().map(|target| target.name.as_str()).collect();
    let specs = scenario.known_lengths.iter().enumerate();
    specs
        .map(|(i, spec)| {
            let field = format!("known_lengths[{i}]");
            check::positive(&format!("{field}.sigma_um"), spec.sigma_um)?;
            let [a, b] = spec.targets.each_ref();
            let a = index_of(format!("{field}.targets[0]"), "target", a, &names)?;
            let b = index_of(format!("{field}.targets[1]"), "target", b, &names)?;
            if a == b || targets[a].carrier != targets[b].carrier {
                let field = format!("{field}.targets");
                return Err(check::expected(field, "two targets of one stage"));
            }
            Ok(([a, b], spec.sigma_um))
        })
        .collect()
}

/// The systematic parts as they are in one campaign.
pub(crate) struct Systematic {
    pub(crate) reflectors: Vec<ReflectorSpec>,
    /// Of each target, mm.
    constants_mm: Vec<f64>,
    /// By how much all lengths are shown too long, µm per m.
    pub(crate) scale_ppm: f64,
}

impl Systematic {
    pub(crate) fn draw(planned: &PlannedSystematic, seed: u64) -> Self {
        let mut deviates = Deviates::of_part(seed, Part::Reflectors);
        let constants = planned.listed_um.iter().map(|listed_um| {
            let drawn_um = deviates.normal() * planned.reflector_sigma_um;
            listed_um.unwrap_or(drawn_um)
        });
        let names = planned.reflector_names.iter().cloned();
        let reflectors = names.zip(constants);
        let reflectors = reflectors.map(|(name, constant_um)| ReflectorSpec { name, constant_um });
        let reflectors: Vec<ReflectorSpec> = reflectors.collect();
        let of_target = planned.reflector_of_target.iter();
        let constants_mm = of_target.map(|&r| reflectors[r].constant_um * MICROMETRE);
        let scale = Deviates::of_part(seed, Part::Scale).normal();
        Self {
            constants_mm: constants_mm.collect(),
            reflectors,
            scale_ppm: scale * planned.scale_sigma_ppm,
        }
    }

    /// By how much a length is shown too long, mm.
    pub(crate) fn length_mm(&self, target: usize, distance_mm: f64) -> f64 {
        self.constants_mm[target] + self.scale_ppm * 1e-6 * distance_mm
    }
}

impl Plan {
    /// Moves the targets to where their nests were set.
    pub(crate) fn set_nests(&mut self, seed: u64) {
        let mut deviates = Deviates::of_part(seed, Part::Nests);
        let sigmas_mm = &self.systematic.nest_sigmas_mm;
        for (home_mm, &sigma_mm) in self.homes_mm.iter_mut().zip(sigmas_mm) {
            *home_mm += deviates.normal_vector() * sigma_mm;
        }
    }

    /// The known lengths that the campaign declares, each with a random error of its uncertainty.
    pub(crate) fn known_lengths(&self, seed: u64) -> Vec<KnownLength> {
        let mut deviates = Deviates::of_part(seed, Part::KnownLengths);
        let known = self.systematic.known_lengths.iter();
        let known = known.map(|&(targets, sigma_um)| {
            let [a, b] = targets.map(|target| self.homes_mm[target]);
            let off_mm = deviates.normal() * sigma_um * MICROMETRE;
            KnownLength {
                targets,
                length_mm: nalgebra::distance(&a, &b) + off_mm,
                sigma_um,
            }
        });
        known.collect()
    }
}

/// The dead paths that the campaign declares, each with a random error of its uncertainty.
pub(crate) fn known_dead_paths(scenario: &Scenario, seed: u64) -> Vec<Option<KnownDeadPath>> {
    let mut deviates = Deviates::of_part(seed, Part::DeadPaths);
    let known = scenario.stations.iter().map(|station| {
        let deviate = deviates.normal();
        let sigma_mm = station.dead_path_sigma_mm?;
        let length_mm = station.dead_path_mm + deviate * sigma_mm;
        Some(KnownDeadPath {
            length_mm,
            sigma_mm,
        })
    });
    known.collect()
}
