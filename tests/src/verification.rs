//! Verification readings of the shipped machines, by their exact models: of the three-axis machine as it is, and with the
//! compensation of the calibration of `campaigns/fxyz` switched on; of the rotary stage and the five-axis machine as they are.
//!
//! Lines of X, Y and Z through the paper's point T (175.6, 497.5, 312.1) mm, 21 positions, five passes a side, and a ball bar
//! of 100 mm in the plane of X and Y, both ways. A reading has noise of the instrument and the machine's repeatability; each
//! line has a zero, the bar a set-up of its own. On the rotary stage balls at the paper's points A and B, and the centre of the
//! bar above the middle of the stage (its Figs. 15 and 16): every 20°, three times each way.

mod five_axis;

use std::f64::consts::TAU;

use nalgebra::{Point3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use trueaxis_campaign::{
    Campaign, Direction, Instrument, Verification, VerificationKind, VerificationReading,
};
use trueaxis_compensate::{Error, Moved, correct};
use trueaxis_kinematics::MICROMETRE;
use trueaxis_predict::CalibratedMachine;
use trueaxis_simulate::TrueMachine;

pub use five_axis::five_axis_readings;

/// The paper's point T.
pub const T_MM: [f64; 3] = [175.6, 497.5, 312.1];

/// Standard deviations, µm: what the instruments declare, and the machine's repeatability.
const INSTRUMENT_UM: f64 = 0.3;
const REPEATABILITY_UM: f64 = 0.3;

/// Declared: both.
const U_UM: f64 = 0.43;

/// Outermost axis of the tool.
const TOOL: usize = 2;

/// The campaign with readings alone: those of `campaign` without its lengths, under another name.
///
/// # Errors
/// If the calibration that compensates has no inverse.
pub fn verification_campaign(
    campaign: &Campaign,
    truth: &TrueMachine,
    compensated_by: Option<&CalibratedMachine>,
    name: &str,
) -> Result<Campaign, Error> {
    let seed = 2026 + u64::from(compensated_by.is_some());
    let mut readings = Readings::new(truth, compensated_by, seed);
    let mut verification = Vec::new();
    for (axis, letter) in ["X", "Y", "Z"].into_iter().enumerate() {
        let target_mm = Point3::from(T_MM);
        let kind = VerificationKind::Positioning { axis, target_mm };
        verification.push(readings.of(&format!("LI along {letter}"), kind, &line(axis))?);
    }
    let ball_mm = Point3::from(T_MM);
    let kind = VerificationKind::Ballbar {
        ball_mm,
        ball_carrier: TOOL,
        center_mm: ball_mm + Vector3::from(CENTRE_MM),
        length_is_calibrated: false,
    };
    verification.push(readings.of("DBB in XY", kind, &circle())?);
    Ok(readings_alone(campaign, verification, name))
}

/// The paper's points A and B.
const ON_THE_STAGE_MM: [(&str, [f64; 3]); 2] = [
    ("DBB at A", [121.779, 87.578, 59.216]),
    ("DBB at B", [49.919, 2.842, 59.216]),
];

/// The campaign of the rotary stage with ball bars alone.
///
/// # Errors
/// None: nothing is compensated.
pub fn bars_on_the_stage(
    campaign: &Campaign,
    truth: &TrueMachine,
    name: &str,
) -> Result<Campaign, Error> {
    let mut readings = Readings::new(truth, None, 2028);
    let bar = |(name, ball): (&str, [f64; 3])| {
        let kind = VerificationKind::Ballbar {
            ball_mm: Point3::from(ball),
            ball_carrier: 0,
            center_mm: Point3::new(0.0, 0.0, ball[2]),
            length_is_calibrated: false,
        };
        readings.with(name, kind, &turn(), |readings, set_up_mm, commanded| {
            let centre = Point3::from(set_up_mm + Vector3::z() * ball[2]);
            let machine = readings.truth.machine();
            let actual = machine.position(readings.truth, 0, commanded, Point3::from(ball));
            // However the stage turns, the ball is as far from its axis.
            Ok(((actual - centre).norm() - ball[0].hypot(ball[1])) / MICROMETRE)
        })
    };
    let bars = ON_THE_STAGE_MM.into_iter().map(bar);
    let bars = bars.collect::<Result<_, Error>>()?;
    Ok(readings_alone(campaign, bars, name))
}

/// A campaign without what else it measured.
fn readings_alone(campaign: &Campaign, verification: Vec<Verification>, name: &str) -> Campaign {
    Campaign {
        name: name.to_owned(),
        verification,
        instrument: Instrument::default(),
        targets: Vec::new(),
        stations: Vec::new(),
        runs: Vec::new(),
        steps: Vec::new(),
        lengths: None,
        notices: Vec::new(),
        ..campaign.clone()
    }
}

/// A turn in steps of 20°, three times each way.
fn turn() -> Vec<Stand> {
    let mut stands = Vec::new();
    for cycle in 1..=3 {
        for direction in SIDES {
            for k in 0..=18 {
                let k = if direction == Direction::Forward {
                    k
                } else {
                    18 - k
                };
                stands.push((cycle, direction, vec![(20.0 * f64::from(k)).to_radians()]));
            }
        }
    }
    stands
}

/// Cycle, side and positions.
type Stand = (u32, Direction, Vec<f64>);

const CENTRE_MM: [f64; 3] = [200.0, 200.0, 100.0];
const RADIUS_MM: f64 = 100.0;

const SIDES: [Direction; 2] = [Direction::Forward, Direction::Backward];

/// 21 positions of one axis, the others at home; five runs from each side.
fn line(axis: usize) -> Vec<Stand> {
    let mut stands = Vec::new();
    for cycle in 1..=5 {
        for direction in SIDES {
            for k in 0..=20 {
                let k = if direction == Direction::Forward {
                    k
                } else {
                    20 - k
                };
                let mut positions = vec![0.0; 3];
                positions[axis] = 20.0 * f64::from(k);
                stands.push((cycle, direction, positions));
            }
        }
    }
    stands
}

/// 72 positions of the circle, once each way.
fn circle() -> Vec<Stand> {
    let mut stands = Vec::new();
    for direction in SIDES {
        for k in 0..72 {
            let k = if direction == Direction::Forward {
                k
            } else {
                72 - k
            };
            let angle = TAU * f64::from(k % 72) / 72.0;
            let [x, y, z] = CENTRE_MM;
            // As a program of the machine has them.
            let rounded = |x: f64| (x * 1e4).round() / 1e4;
            let x = rounded(x + RADIUS_MM * angle.cos());
            let y = rounded(y + RADIUS_MM * angle.sin());
            stands.push((1, direction, vec![x, y, z]));
        }
    }
    stands
}

struct Readings<'a> {
    truth: &'a TrueMachine,
    compensated_by: Option<&'a CalibratedMachine>,
    rng: ChaCha8Rng,
}

impl<'a> Readings<'a> {
    fn new(
        truth: &'a TrueMachine,
        compensated_by: Option<&'a CalibratedMachine>,
        seed: u64,
    ) -> Self {
        Self {
            truth,
            compensated_by,
            rng: ChaCha8Rng::seed_from_u64(seed),
        }
    }

    fn of(
        &mut self,
        name: &str,
        kind: VerificationKind,
        stands: &[Stand],
    ) -> Result<Verification, Error> {
        self.with(
            name,
            kind.clone(),
            stands,
            |readings, set_up_mm, commanded| readings.exact_um(&kind, commanded, set_up_mm),
        )
    }

    /// With what the instrument reads but for its zero and noise, for its set-up and commanded positions.
    fn with(
        &mut self,
        name: &str,
        kind: VerificationKind,
        stands: &[Stand],
        exact_um: impl Fn(&Self, Vector3<f64>, &[f64]) -> Result<f64, Error>,
    ) -> Result<Verification, Error> {
        let zero_um: f64 = 5.0 * self.deviate();
        let set_up_mm = Vector3::from_fn(|_, _| 0.005 * self.deviate());
        let mut readings = Vec::new();
        for (row, (cycle, direction, commanded)) in stands.iter().enumerate() {
            let exact_um = exact_um(self, set_up_mm, commanded)?;
            let noise_um = INSTRUMENT_UM * self.deviate() + REPEATABILITY_UM * self.deviate();
            let value_um = exact_um + zero_um + noise_um;
            readings.push(VerificationReading {
                time_s: None,
                cycle: *cycle,
                direction: *direction,
                positions: commanded.clone(),
                value_um: (value_um * 1e3).round() / 1e3,
                line: row + 2,
            });
        }
        Ok(Verification {
            name: name.to_owned(),
            kind,
            u_um: Some(U_UM),
            u_ppm: None,
            readings,
        })
    }

    fn deviate(&mut self) -> f64 {
        self.rng.sample(StandardNormal)
    }

    /// Of the true machine where the control sends it, put together here.
    fn exact_um(
        &self,
        kind: &VerificationKind,
        commanded: &[f64],
        set_up_mm: Vector3<f64>,
    ) -> Result<f64, Error> {
        let (VerificationKind::Positioning {
            target_mm: home, ..
        }
        | VerificationKind::Ballbar { ball_mm: home, .. }) = *kind;
        let sent = match self.compensated_by {
            None => commanded.to_vec(),
            Some(calibrated) => {
                let machine = calibrated.machine();
                correct(machine, calibrated, commanded, home, Moved::Linear)?.positions
            }
        };
        let wanted = home + Vector3::from_column_slice(&commanded[..3]);
        let actual = self.truth.machine().position(self.truth, TOOL, &sent, home);
        let mm = match *kind {
            VerificationKind::Positioning { axis, .. } => actual[axis] - wanted[axis],
            VerificationKind::Ballbar { center_mm, .. } => {
                let centre = center_mm + set_up_mm;
                (actual - centre).norm() - (wanted - center_mm).norm()
            }
        };
        Ok(mm / MICROMETRE)
    }
}
