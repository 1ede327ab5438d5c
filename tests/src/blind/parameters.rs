//! The truth in the words of the catalogue, to compare with what was found.

use nalgebra::Vector3;
use trueaxis_kinematics::AxisKind;

use super::layout::Layout;
use super::{Act, Hidden, Kind};

/// One number of the truth, in the words of the catalogue.
#[derive(Debug, Clone, PartialEq)]
pub struct TrueParameter {
    /// Name, as `shift_x`.
    pub name: String,
    /// Value.
    pub value: f64,
    /// Unit, as `um`.
    pub unit: &'static str,
}

impl Hidden {
    /// The linear parameters in the catalogue's names, signs and units; none for what it does not
    /// hold.
    pub fn parameters(&self, kind: &Kind) -> Vec<TrueParameter> {
        let layout = Layout::new(kind);
        let rotary = self
            .axis
            .is_some_and(|axis| layout.machine.axes()[axis].kind() == AxisKind::Rotary);
        match (&self.act, self.name) {
            (Act::Zero(by_station), "dead_path_drift") => self.rates(by_station),
            (Act::Zero(by_station), _) => {
                let value = self.station.map_or(0.0, |own| by_station[own]);
                scalar("jump", value, "um")
            }
            (Act::Scale(ppm), "station_scale") => scalar("scale", *ppm, "ppm"),
            (Act::Scale(ppm), _) => scalar("scale_drift", *ppm, "ppm"),
            (Act::Tripod(v), "station_jump") => vector("jump", v, "um"),
            (Act::Tripod(v), "station_settling") => vector("settling", v, "um"),
            (Act::Tripod(v), _) => vector("creep", v, "um"),
            (Act::Target(v), "target_slip") => vector("slip", v, "um"),
            (Act::Target(v), _) => vector("creep", v, "um"),
            (Act::Growth(ppm) | Act::AxisScale(ppm), _) => scalar("expansion", *ppm, "ppm"),
            (Act::Machine(v), "machine_drift") => vector("drift", v, "um"),
            (Act::Machine(v), "warm_up") => vector("growth", v, "um"),
            (Act::Machine(v), "machine_shift") => vector("shift", v, "um"),
            (Act::LostMotion(b), "backlash") => {
                scalar("lost_motion", *b, if rotary { "arcsec" } else { "um" })
            }
            (Act::Late(ms), _) => scalar("offset", *ms, "ms"),
            (Act::Bending { per_square, .. }, _) => vector(
                "bending",
                per_square,
                if rotary { "um/rad2" } else { "um/m2" },
            ),
            _ => Vec::new(),
        }
    }

    /// Rates of the stations concerned.
    fn rates(&self, by_station: &[f64]) -> Vec<TrueParameter> {
        let stations = by_station.iter().enumerate();
        let own = stations.filter(|&(i, _)| self.station.is_none_or(|own| own == i));
        own.flat_map(|(i, &rate)| scalar(&format!("rate_{}", super::station_name(i)), rate, "um"))
            .collect()
    }
}

fn scalar(name: &str, value: f64, unit: &'static str) -> Vec<TrueParameter> {
    let name = name.to_owned();
    vec![TrueParameter { name, value, unit }]
}

fn vector(name: &str, v: &Vector3<f64>, unit: &'static str) -> Vec<TrueParameter> {
    let along = ["x", "y", "z"].iter().zip(v.iter());
    along
        .flat_map(|(axis, &value)| scalar(&format!("{name}_{axis}"), value, unit))
        .collect()
}
