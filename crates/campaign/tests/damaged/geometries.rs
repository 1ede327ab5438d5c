//! Correct campaigns of all sorts of machines and stations are accepted: no false alarm. The same
//! campaigns in another unit are not.
//!
//! The machine that is measured differs from the nominal one as badly as real ones do: directions
//! by degrees, targets and pivots by mm, readings by tenths of mm, a dead path that jumps.

use std::f64::consts::{PI, TAU};

use nalgebra::{Point3, Rotation3, Unit, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use trueaxis_campaign::{
    Campaign, Direction, Instrument, LengthReading, Lengths, Run, Station, Step, Stop, Target,
    write,
};
use trueaxis_kinematics::{Axis, AxisKind, Ideal, Machine};

const DIRECTION_ERROR_RAD: f64 = 3.0 * PI / 180.0;
const MOUNTING_ERROR_MM: f64 = 4.0;
const NOISE_MM: f64 = 0.3;
const DEAD_PATH_JUMP_MM: f64 = 3.0;
const CAMPAIGNS: u64 = 60;

#[derive(Debug, Clone, Copy)]
enum Kind {
    /// X, Y and Z carry the targets.
    ThreeLinear,
    /// One linear axis, seen from anywhere or from straight across.
    OneLinear,
    /// One rotary axis, seen from anywhere or along the axis (two stations of four or more).
    OneRotary,
    /// X, Y, Z in one branch, A and C with the targets of their runs in the other.
    FiveAxes,
}

struct Random(ChaCha8Rng);

impl Random {
    fn within(&mut self, limit: f64) -> f64 {
        self.0.random_range(-limit..limit)
    }

    fn vector(&mut self, limit: f64) -> Vector3<f64> {
        Vector3::from_fn(|_, _| self.within(limit))
    }

    fn direction(&mut self) -> Unit<Vector3<f64>> {
        loop {
            let vector = self.vector(1.0);
            if (0.1..1.0).contains(&vector.norm()) {
                return Unit::new_normalize(vector);
            }
        }
    }

    fn rotation(&mut self, limit_rad: f64) -> Rotation3<f64> {
        Rotation3::from_axis_angle(&self.direction(), self.0.random_range(0.0..limit_rad))
    }

    /// A machine and what is wrong with it.
    fn machines(&mut self, kind: Kind) -> (Machine, Machine) {
        let frame = self.rotation(PI);
        let linear = |name: &str, v: Vector3<f64>| (name.to_owned(), AxisKind::Linear, frame * v);
        let rotary = |name: &str, v: Vector3<f64>| (name.to_owned(), AxisKind::Rotary, frame * v);
        let x = linear("X", Vector3::x());
        let y = linear("Y", Vector3::y());
        let z = linear("Z", Vector3::z());
        let a = rotary("A", Vector3::x());
        let c = rotary("C", Vector3::z());
        let (axes, workpiece_from) = match kind {
            Kind::ThreeLinear => (vec![x, y, z], 3),
            Kind::OneLinear => (vec![x], 1),
            Kind::OneRotary => (vec![c], 0),
            Kind::FiveAxes => (vec![x, y, z, a, c], 3),
        };
        let stroke = self.0.random_range(150.0..900.0);
        let mut build = |is_real: bool| {
            let axes: Vec<Axis> = axes
                .iter()
                .map(|(name, kind, direction)| {
                    let (tilt, shift_mm) = if is_real {
                        (
                            self.rotation(DIRECTION_ERROR_RAD),
                            self.vector(MOUNTING_ERROR_MM),
                        )
                    } else {
                        (Rotation3::identity(), Vector3::zeros())
                    };
                    let direction = tilt * direction;
                    match kind {
                        AxisKind::Linear => Axis::linear(name, direction, [0.0, stroke]),
                        AxisKind::Rotary => {
                            Axis::rotary(name, direction, [-PI, TAU], Point3::from(shift_mm))
                        }
                    }
                    .unwrap()
                })
                .collect();
            let count = axes.len();
            Machine::new(
                axes,
                (0..workpiece_from).collect(),
                (workpiece_from..count).collect(),
            )
            .unwrap()
        };
        (build(false), build(true))
    }

    fn stations(&mut self, kind: Kind, machine: &Machine) -> Vec<Point3<f64>> {
        let axis = machine.axes()[0].direction();
        let count = self.0.random_range(4..7);
        let is_special = self.0.random_range(0..3) == 0;
        (0..count)
            .map(|i| {
                let distance_mm = 10_f64.powf(self.0.random_range(3.0..4.2));
                let anywhere = self.direction().into_inner();
                let position = match kind {
                    Kind::OneLinear if is_special => {
                        let across = Unit::new_normalize(axis.cross(&anywhere));
                        axis.scale(machine.axes()[0].travel()[1] / 2.0)
                            + across.scale(distance_mm.min(3000.0))
                    }
                    Kind::OneRotary if is_special && i < 2 => axis.scale(distance_mm),
                    _ => anywhere * distance_mm,
                };
                Point3::from(position)
            })
            .collect()
    }

    /// A campaign that is correct within the errors named above.
    fn campaign(&mut self, kind: Kind) -> Campaign {
        let (machine, real_machine) = self.machines(kind);
        let stations = self.stations(kind, &machine);
        let axes = machine.axes();
        let carriers = match kind {
            Kind::FiveAxes => vec![2, 4],
            _ => vec![axes.len() - 1],
        };
        let targets: Vec<Target> = (0..carriers.len() * 3)
            .map(|i| Target {
                name: format!("T{i}"),
                home_mm: Point3::from(self.direction().scale(self.0.random_range(100.0..400.0))),
                carrier: Some(carriers[i / 3]),
                ..Target::default()
            })
            .collect();
        let mounted_mm: Vec<_> = targets
            .iter()
            .map(|t| t.home_mm + self.vector(MOUNTING_ERROR_MM))
            .collect();
        let dead_paths_mm: Vec<f64> = stations.iter().map(|_| self.within(2000.0)).collect();
        let approx_error_mm = self.0.random_range(1.0..400.0);
        let has_approx = self.0.random_range(0..2) == 0;

        let points_per_run = self.0.random_range(5..14);
        let mut steps = Vec::new();
        for run in 0..axes.len() {
            let [low, high] = axes[run].travel();
            for i in 0..points_per_run {
                let mut positions = vec![0.0; axes.len()];
                positions[run] = low + (high - low) * f64::from(i) / f64::from(points_per_run - 1);
                let run = Some(run);
                steps.push(Step { run, positions });
            }
        }
        let mut lengths = Lengths::default();
        let jump_at = self.0.random_range(0..stations.len() * steps.len());
        for (station, position) in stations.iter().enumerate() {
            for (index, step) in steps.iter().enumerate() {
                let first = lengths.readings.len();
                for (target, (entry, home)) in targets.iter().zip(&mounted_mm).enumerate() {
                    let axis = step.run.unwrap();
                    let is_carried = machine.chain(entry.carrier).contains(&axis);
                    if !is_carried {
                        continue;
                    }
                    let point =
                        real_machine.position(&Ideal, entry.carrier, &step.positions, *home);
                    let mut length_mm = (point - position).norm() - dead_paths_mm[station];
                    length_mm += self.within(NOISE_MM);
                    if station * steps.len() + index >= jump_at {
                        length_mm += DEAD_PATH_JUMP_MM;
                    }
                    lengths.readings.push(LengthReading {
                        time_s: lengths.readings.len() as f64,
                        target,
                        length_mm,
                        line: lengths.readings.len() + 2,
                    });
                }
                lengths.stops.push(Stop {
                    station,
                    repeat: 1,
                    step: index,
                    direction: Direction::Forward,
                    readings: first..lengths.readings.len(),
                });
            }
        }
        Campaign {
            name: format!("{kind:?}"),
            date: None,
            operator: None,
            machine_name: "random".to_owned(),
            expansions: Vec::new(),
            instrument: Instrument::default(),
            stations: stations
                .iter()
                .enumerate()
                .map(|(i, position)| Station {
                    name: format!("S{i}"),
                    approx_mm: has_approx.then(|| position + self.vector(approx_error_mm)),
                    dead_path: None,
                })
                .collect(),
            known_lengths: Vec::new(),
            runs: axes
                .iter()
                .enumerate()
                .map(|(axis, entry)| Run {
                    name: entry.name().to_lowercase(),
                    axis,
                })
                .collect(),
            targets,
            steps,
            lengths: Some(lengths),
            points: None,
            verification: Vec::new(),
            point_checks: Vec::new(),
            notices: Vec::new(),
            machine,
        }
    }
}

fn campaigns(kind: Kind) -> impl Iterator<Item = Campaign> {
    (0..CAMPAIGNS).map(move |seed| {
        let mut rng = ChaCha8Rng::seed_from_u64(20_240_607);
        rng.set_stream(seed);
        Random(rng).campaign(kind)
    })
}

/// What reading says to the campaign; writing reads it.
fn objection(campaign: &Campaign) -> Option<String> {
    let folder = tempfile::tempdir().unwrap();
    write(campaign, folder.path()).err().map(|e| e.to_string())
}

fn scale_lengths(mut campaign: Campaign, factor: f64) -> Campaign {
    let lengths = campaign.lengths.as_mut().unwrap();
    lengths
        .readings
        .iter_mut()
        .for_each(|r| r.length_mm *= factor);
    campaign
}

fn scale_positions(mut campaign: Campaign, kind: AxisKind, factor: f64) -> Campaign {
    for step in &mut campaign.steps {
        for (axis, position) in campaign.machine.axes().iter().zip(&mut step.positions) {
            if axis.kind() == kind {
                *position *= factor;
            }
        }
    }
    campaign
}

#[test]
fn correct_campaigns_raise_no_alarm() {
    for kind in [
        Kind::ThreeLinear,
        Kind::OneLinear,
        Kind::OneRotary,
        Kind::FiveAxes,
    ] {
        for (i, campaign) in campaigns(kind).enumerate() {
            assert_eq!(objection(&campaign), None, "{kind:?} {i}");
        }
    }
}

#[test]
fn lengths_in_another_unit_are_refused() {
    for kind in [Kind::ThreeLinear, Kind::FiveAxes] {
        for (i, campaign) in campaigns(kind).enumerate() {
            for (factor, words) in [
                (1e-3, "metres"),
                (1.0 / 25.4, "inches"),
                (1e3, "micrometres"),
            ] {
                let expected = format!("length_mm look like {words}, expected mm");
                let message = objection(&scale_lengths(campaign.clone(), factor));
                let message = message.unwrap_or_default();
                assert!(
                    message.contains(&expected),
                    "{kind:?} {i} in {words}: {message}"
                );
            }
        }
    }
    // With a single axis inches may be a poor geometry; metres may not.
    for kind in [Kind::OneLinear, Kind::OneRotary] {
        for (i, campaign) in campaigns(kind).enumerate() {
            for (factor, words) in [(1e-3, "metres"), (1e3, "micrometres")] {
                let expected = format!("length_mm look like {words}, expected mm");
                let message = objection(&scale_lengths(campaign.clone(), factor));
                let message = message.unwrap_or_default();
                assert!(
                    message.contains(&expected),
                    "{kind:?} {i} in {words}: {message}"
                );
            }
        }
    }
}

#[test]
fn positions_in_another_unit_are_refused() {
    for (kind, axes, factor, words) in [
        (Kind::ThreeLinear, AxisKind::Linear, 1e-3, "metres"),
        (Kind::ThreeLinear, AxisKind::Linear, 1.0 / 25.4, "inches"),
        (Kind::OneRotary, AxisKind::Rotary, PI / 180.0, "radians"),
        (Kind::FiveAxes, AxisKind::Rotary, PI / 180.0, "radians"),
    ] {
        for (i, campaign) in campaigns(kind).enumerate() {
            let message = objection(&scale_positions(campaign, axes, factor));
            let message = message.unwrap_or_default();
            let expected = format!("look like {words}, expected");
            assert!(
                message.contains(&expected),
                "{kind:?} {i} in {words}: {message}"
            );
        }
    }
}
