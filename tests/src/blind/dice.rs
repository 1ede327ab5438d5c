//! What a disturbance is drawn from: subjects, sizes, directions, instants.

use std::f64::consts::TAU;

use nalgebra::Vector3;
use trueaxis_kinematics::AxisKind;

use super::draw::{on_all, on_station, on_target};
use super::layout::Layout;
use super::random::Random;
use super::{Act, Course, Hidden};

/// Where in an occupation an instant may lie.
const INSIDE_A_TURN: [f64; 2] = [0.1, 0.9];
/// Time between the places of a tripod that sways, s.
const SWAY_EVERY_S: f64 = 30.0;

/// What is drawn from.
pub(super) struct Dice<'a> {
    pub(super) random: Random,
    pub(super) occupations_s: &'a [[f64; 2]],
    pub(super) layout: &'a Layout,
}

impl Dice<'_> {
    pub(super) fn station(&mut self) -> usize {
        self.random.index(self.occupations_s.len())
    }

    /// A target that an axis carries; those of the bed are the last.
    pub(super) fn target(&mut self) -> usize {
        let on_bed = self.layout.on_bed().len();
        self.random.index(self.layout.targets.len() - on_bed)
    }

    pub(super) fn any_axis(&mut self) -> usize {
        self.random.index(self.layout.sweeps.len())
    }

    pub(super) fn linear_axis(&mut self) -> Option<usize> {
        let axes = self.layout.machine.axes().iter().enumerate();
        let linear = axes.filter(|(_, axis)| axis.kind() == AxisKind::Linear);
        let linear: Vec<usize> = linear.map(|(i, _)| i).collect();
        (!linear.is_empty()).then(|| linear[self.random.index(linear.len())])
    }

    /// 2 to 5 with a sign.
    pub(super) fn size(&mut self) -> f64 {
        self.random.sign() * self.random.between(2.0, 5.0)
    }

    /// 2 to 5 µm in any direction.
    pub(super) fn vector(&mut self) -> Vector3<f64> {
        let length = self.random.between(2.0, 5.0);
        self.random.vector(length)
    }

    /// Zeros of one station or of all.
    pub(super) fn zeros(&mut self, station: Option<usize>) -> Act {
        let all = (0..self.occupations_s.len()).map(|i| {
            let size = self.size();
            if station.is_none_or(|own| own == i) {
                size
            } else {
                0.0
            }
        });
        Act::Zero(all.collect())
    }

    /// A jump inside the occupation of a station.
    pub(super) fn jump_at(&mut self, station: usize) -> Course {
        let [from_s, to_s] = self.occupations_s[station];
        let inside = self.random.between(INSIDE_A_TURN[0], INSIDE_A_TURN[1]);
        Course::Jump {
            instant_s: from_s + inside * (to_s - from_s),
            spread_s: 0.0,
        }
    }

    /// A target that moves with an axis which carries it; at the end of its range a few µm.
    pub(super) fn bending(&mut self) -> Hidden {
        let target = self.target();
        let carrier = self.layout.targets[target].carrier;
        let chain = self.layout.machine.chain(carrier);
        let axis = chain[self.random.index(chain.len())];
        let end = self.layout.range(axis).map(f64::abs);
        let end = match self.layout.machine.axes()[axis].kind() {
            AxisKind::Linear => end[0].max(end[1]) * 1e-3,
            AxisKind::Rotary => end[0].max(end[1]),
        };
        let act = Act::Bending {
            per_square: self.vector() / (end * end),
            exponent: 2.0,
        };
        Hidden {
            axis: Some(axis),
            ..on_target(target, act, Course::Constant)
        }
    }

    /// A warm-up that goes on through a good part of the campaign.
    pub(super) fn warming(&mut self, [_, end_s]: [f64; 2]) -> Course {
        Course::WarmUp {
            time_constant_s: end_s * self.random.between(0.15, 0.6),
            exponent: 1.0,
        }
    }

    /// Swings of the air (length scale), of the floor (all tripods), or of both.
    pub(super) fn air(&mut self) -> Hidden {
        let what = self.random.index(3);
        let scale_ppm = self.size();
        let tripod_um = self.vector();
        let act = Act::Air {
            scale_ppm: if what == 1 { 0.0 } else { scale_ppm },
            tripod_um: if what == 0 {
                Vector3::zeros()
            } else {
                tripod_um
            },
        };
        let course = Course::Wave {
            period_s: self.random.between(600.0, 1800.0),
            phase_rad: self.random.between(0.0, TAU),
        };
        on_all(act, course)
    }

    /// One tripod takes a random step every half minute of its occupation.
    pub(super) fn sway(&mut self) -> Hidden {
        let station = self.station();
        let [start_s, end_s] = self.occupations_s[station];
        let mut place = Vector3::zeros();
        let mut places_um = vec![place];
        let mut time_s = start_s;
        while time_s < end_s {
            time_s += SWAY_EVERY_S;
            place += self.random.normal_vector() * 0.5;
            places_um.push(place);
        }
        let act = Act::Sway {
            start_s,
            every_s: SWAY_EVERY_S,
            places_um,
        };
        on_station(Some(station), act, Course::Constant)
    }
}
