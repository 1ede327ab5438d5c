//! The calibrated machine in the place of a true one, for a replay.

use trueaxis_calibrate::{AxisResult, Calibration};
use trueaxis_effects::GivenEffect;
use trueaxis_kinematics::MICROMETRE;
use trueaxis_simulate::{
    Noise, ReflectorSpec, TrueComponents, TrueLocation, TrueStation, TrueTarget, Truth,
};

/// What the calibration and the causes found say about the campaign.
pub(crate) fn truth(calibration: &Calibration, effects: &[GivenEffect]) -> anyhow::Result<Truth> {
    if !calibration.adjustment.interruptions.is_empty() {
        anyhow::bail!("the calibration split occupations of stations, which a scenario cannot");
    }
    let Some(noise) = calibration.adjustment.noise else {
        anyhow::bail!("only lengths can be replayed");
    };
    let stations = calibration.stations.iter().map(|station| TrueStation {
        name: station.name.clone(),
        position_mm: station.position_mm,
        dead_path_mm: station.dead_path_mm,
    });
    let targets = calibration.targets.iter().map(|target| TrueTarget {
        name: target.name.clone(),
        home_mm: target.position_mm,
    });
    let locations = calibration.axes.iter().flat_map(|axis| {
        axis.location_errors.iter().map(|location| TrueLocation {
            name: location.component.name(&axis.name),
            component: location.component,
            value: location.value,
        })
    });
    Ok(Truth {
        campaign: calibration.campaign.clone(),
        seed: 0,
        noise: Noise {
            length_sigma_um: noise.length.used.sigma_mm / MICROMETRE,
            length_sigma_ppm: noise.length_ppm,
            repeatability_um: noise.repeatability.used.sigma_mm / MICROMETRE,
        },
        scale_ppm: 0.0,
        reflectors: calibration
            .reflectors
            .iter()
            .map(|reflector| ReflectorSpec {
                name: reflector.name.clone(),
                constant_um: reflector.constant_mm / MICROMETRE,
            })
            .collect(),
        stations: stations.collect(),
        targets: targets.collect(),
        axes: calibration.axes.iter().map(components).collect(),
        location_errors: locations.collect(),
        effects: effects.to_vec(),
    })
}

fn components(axis: &AxisResult) -> TrueComponents {
    let directions: Option<Vec<_>> = axis.nodes.iter().map(|node| node.direction).collect();
    TrueComponents {
        name: axis.name.clone(),
        kind: axis.kind,
        reference_mm: axis.reference_point_mm,
        positions: axis.nodes.iter().map(|node| node.position).collect(),
        directions,
        errors: axis.nodes.iter().map(|node| node.error).collect(),
    }
}
