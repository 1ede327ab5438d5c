//! Points of an erroneous machine in the frame of an instrument, with one effect: made by formulas of its own.

use std::f64::consts::TAU;

use nalgebra::{Point3, Rotation3, Vector3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use trueaxis_campaign::{
    Campaign, Direction, Instrument, PointReading, Points, Run, Step, Stop, Target,
};
use trueaxis_kinematics::{Axis, Machine};

const ARCSEC: f64 = 4.848_136_811e-6;

/// Targets at home, and on the bed, mm.
const HOME: [Point3<f64>; 4] = [
    Point3::new(60.0, 252.0, 122.0),
    Point3::new(-157.0, 132.0, 124.0),
    Point3::new(148.0, -103.0, 212.0),
    Point3::new(-20.0, 30.0, 60.0),
];
const BED: [Point3<f64>; 3] = [
    Point3::new(-300.0, -200.0, 30.0),
    Point3::new(500.0, -250.0, 40.0),
    Point3::new(100.0, 600.0, 350.0),
];

/// What is measured.
#[derive(Debug, Clone)]
pub(crate) struct Plan {
    /// X, Y and Z, or a rotary C.
    pub(crate) is_rotary: bool,
    pub(crate) repeats: u32,
    pub(crate) both_sides: bool,
    pub(crate) targets: usize,
    /// Targets on the bed that are read before, between and after the sweeps.
    pub(crate) bed: bool,
    /// Noise along each direction of the instrument, relatively.
    pub(crate) unlike: [f64; 3],
    /// Standard deviation of the two angles of an instrument, rad; `noise_mm` is then that of its distances.
    pub(crate) angles: Option<f64>,
    /// Standard deviation of a coordinate and of the machine's repeatability, mm.
    pub(crate) noise_mm: f64,
    pub(crate) return_mm: f64,
}

impl Plan {
    pub(crate) const THREE_AXES: Self = Self {
        is_rotary: false,
        repeats: 2,
        both_sides: true,
        targets: 3,
        bed: false,
        unlike: [1.0; 3],
        angles: None,
        noise_mm: 1e-3,
        return_mm: 1e-3,
    };

    pub(crate) const ROTARY: Self = Self {
        is_rotary: true,
        repeats: 4,
        ..Self::THREE_AXES
    };
}

/// What happens, by the id of the catalogue, with what is drawn for it.
#[derive(Debug, Clone)]
pub(crate) struct Hidden {
    pub(crate) id: &'static str,
    /// A vector of about one, and another.
    pub(crate) vector: Vector3<f64>,
    pub(crate) turn: Vector3<f64>,
    /// From 0 to 1 of the campaign.
    pub(crate) at: f64,
    pub(crate) target: usize,
    pub(crate) axis: usize,
    /// Times its usual size.
    pub(crate) size: f64,
}

impl Hidden {
    pub(crate) fn draw(id: &'static str, size: f64, plan: &Plan, rng: &mut ChaCha8Rng) -> Self {
        let mut unit = || {
            let v = Vector3::from_fn(|_, _| StandardNormal.sample(rng));
            let v: Vector3<f64> = v;
            v.normalize()
        };
        let (mut vector, turn) = (unit(), unit());
        if id == "stage_bending" {
            // Across the plane of three targets the poses take all of it.
            let normal = (HOME[1] - HOME[0]).cross(&(HOME[2] - HOME[0])).normalize();
            vector = (vector - normal * normal.dot(&vector)).normalize();
        }
        Self {
            id,
            vector,
            turn,
            at: rng.random_range(0.2..0.8),
            target: rng.random_range(0..plan.targets),
            axis: if plan.is_rotary {
                0
            } else {
                rng.random_range(0..3)
            },
            size,
        }
    }
}

impl Hidden {
    /// Values of the linear parameters, where an effect has them in the frame of the machine.
    pub(crate) fn truth(&self, plan: &Plan) -> Vec<f64> {
        let along = |um: f64| (self.vector * (um * self.size)).as_slice().to_vec();
        match self.id {
            "machine_shift" | "target_slip" => along(2.0),
            "machine_drift" | "target_creep" => along(4.0),
            "stage_bending" if plan.is_rotary => along(4.0 / TAU.powi(2)),
            "stage_bending" => along(4.0 / 0.4_f64.powi(2)),
            "fixture_expansion" | "axis_expansion" => vec![20.0 * self.size],
            "backlash" => vec![2.0 * self.size],
            _ => Vec::new(),
        }
    }
}

/// Of a cyclic error, three steps.
pub(crate) const PERIOD_MM: f64 = 60.0;

/// One reading before it is one: where the machine and its clock stand.
struct Moment<'a> {
    tau: f64,
    axis: usize,
    q: f64,
    side: f64,
    target: usize,
    stage: &'a Rotation3<f64>,
    centroid: Point3<f64>,
    is_on_bed: bool,
}

/// What it does to where a target is, mm.
fn moved(hidden: &Hidden, at: &Moment<'_>, p: &Point3<f64>, travel: f64) -> Vector3<f64> {
    let um = 1e-3 * hidden.size;
    let after = if at.tau > hidden.at { 1.0 } else { 0.0 };
    let own = if at.target == hidden.target { 1.0 } else { 0.0 };
    let along = |axis: usize| Vector3::ith(axis, 1.0);
    if at.is_on_bed {
        return Vector3::zeros();
    }
    match hidden.id {
        "machine_shift" => hidden.vector * 2.0 * um * after,
        "machine_drift" => hidden.vector * 4.0 * um * at.tau,
        "warm_up" => hidden.vector * 6.0 * um * (1.0 - (-at.tau / (0.1 + 0.3 * hidden.at)).exp()),
        "target_slip" => at.stage * hidden.vector * 2.0 * um * after * own,
        // Of no catalogue: a holder that sways, a stage that is wavy.
        "swaying_target" => {
            at.stage * hidden.vector * (4.0 * um * (TAU * 2.7 * at.tau).sin() * own)
        }
        "wavy_stage" if hidden.axis == at.axis => {
            at.stage * hidden.vector * (4.0 * um * (TAU * 1.6 * at.q / travel).sin() * own)
        }
        "cyclic_error" if hidden.axis == at.axis => {
            along(at.axis) * (3.0 * um * (TAU * at.q / PERIOD_MM).sin())
        }
        "target_creep" => at.stage * hidden.vector * 4.0 * um * at.tau * own,
        "fixture_expansion" => (p - at.centroid) * 20e-6 * hidden.size * at.tau,
        "stage_bending" if hidden.axis == at.axis => {
            at.stage * hidden.vector * 4.0 * um * (at.q / travel).powi(2) * own
        }
        "axis_expansion" if hidden.axis == at.axis => {
            along(at.axis) * (20e-6 * hidden.size * at.q * at.tau)
        }
        // Of no catalogue: an axis that warms up is led otherwise, a drive works loose.
        "warming_axis" if hidden.axis == at.axis => {
            // After a turn a rotary stage is where it was; it leans twice a turn, too, by three fifths of what it does once a turn.
            let part = match travel < 10.0 {
                true => (0.5 * at.q).sin().powi(2) + 0.3 * (2.0 * at.q).sin(),
                false => at.q / travel,
            };
            let x = warm(hidden, at.tau) * part;
            let turned = hidden.turn.cross(&(p - at.centroid)) * (4.0 * ARCSEC * hidden.size);
            (hidden.vector * 6.0 * um + turned) * x
        }
        "loosening_drive" if hidden.axis == at.axis => {
            let part = 3.0 * warm(hidden, at.tau);
            behind(at, travel, p, part * hidden.size)
        }
        "backlash" if hidden.axis == at.axis => behind(at, travel, p, hidden.size),
        _ => Vector3::zeros(),
    }
}

/// Half of a lost motion of twice `size`, µm or arc seconds.
fn behind(at: &Moment<'_>, travel: f64, p: &Point3<f64>, size: f64) -> Vector3<f64> {
    if travel < 10.0 {
        Vector3::z().cross(&p.coords) * (-ARCSEC * size * at.side)
    } else {
        Vector3::ith(at.axis, -1e-3 * size * at.side)
    }
}

/// A warm-up that goes on through a good part of the campaign.
fn warm(hidden: &Hidden, tau: f64) -> f64 {
    1.0 - (-tau / (0.15 + 0.5 * hidden.at)).exp()
}

/// By what the instrument has moved and turned by then, mm and rad, in its own frame.
fn strayed(hidden: &Hidden, tau: f64) -> (Vector3<f64>, Vector3<f64>) {
    let part = match hidden.id {
        "station_jump" if tau > hidden.at => 1.0,
        "station_drift" => 2.0 * tau,
        // Of no catalogue: a hall that breathes.
        "breathing" => (TAU * (3.3 * tau + hidden.at)).sin() + 0.5 * (TAU * 7.1 * tau).cos(),
        "station_settling" => 3.0 * (-tau / (0.1 + 0.3 * hidden.at)).exp(),
        _ => 0.0,
    };
    let part = part * hidden.size;
    (hidden.vector * 2e-3 * part, hidden.turn * ARCSEC * part)
}

/// A smooth curve over 0 to 1 that is zero at the start.
struct Curve([f64; 6]);

impl Curve {
    fn draw(rng: &mut ChaCha8Rng) -> Self {
        Self(std::array::from_fn(|_| StandardNormal.sample(rng)))
    }

    fn at(&self, x: f64) -> f64 {
        let [a, b, c, d, e, f] = self.0;
        let wave = |k: f64, sine: f64, cosine: f64| {
            sine * (k * TAU * x).sin() + cosine * ((k * TAU * x).cos() - 1.0)
        };
        a * x + wave(0.5, b, c) + 0.5 * wave(1.0, d, e) + 0.3 * wave(2.0, f, 0.0)
    }
}

/// The points of a plan with effects, under a seed.
pub(crate) fn made(plan: &Plan, hidden: &[Hidden], seed: u64) -> Campaign {
    let mut rng = super::generator(seed, 1);
    let axes: &[&str] = if plan.is_rotary {
        &["C"]
    } else {
        &["X", "Y", "Z"]
    };
    let travel = if plan.is_rotary { TAU } else { 400.0 };
    let count = if plan.is_rotary { 24 } else { 21 };
    // Error curves: six for each axis, mm and rad; and where the targets and the instrument really are.
    let curves: Vec<[Curve; 6]> = (0..axes.len())
        .map(|_| std::array::from_fn(|_| Curve::draw(&mut rng)))
        .collect();
    let mut normal = super::generator(seed, 2);
    let mut deviate = move || -> f64 { StandardNormal.sample(&mut normal) };
    let mut vector = |size: f64| Vector3::new(deviate(), deviate(), deviate()) * size;
    let mounted: Vec<Point3<f64>> = HOME.iter().map(|h| h + vector(0.05)).collect();
    let frame = Rotation3::new(vector(0.7));
    let stands = Vector3::new(900.0, -1500.0, 700.0);

    // One sweep after the other; bed targets before, between and after.
    let sides: &[f64] = if plan.both_sides {
        &[1.0, -1.0]
    } else {
        &[1.0]
    };
    let mut visits: Vec<(u32, Option<usize>, f64, f64)> = Vec::new();
    for repeat in 1..=plan.repeats {
        for axis in 0..axes.len() {
            for &side in sides {
                if plan.bed {
                    visits.push((repeat, None, 1.0, 0.0));
                }
                for k in 0..count {
                    let k = if side > 0.0 { k } else { count - 1 - k };
                    let q = match plan.is_rotary {
                        true => TAU * k as f64 / count as f64,
                        false => travel * k as f64 / (count - 1) as f64,
                    };
                    visits.push((repeat, Some(axis), side, q));
                }
            }
        }
    }
    if plan.bed {
        visits.push((plan.repeats, None, 1.0, 0.0));
    }
    let mut clock_s = 0.0;
    let last_s = visits.len() as f64 * 20.0;
    let mut points = Points::default();
    let mut steps: Vec<Step> = Vec::new();
    for (repeat, axis, side, q) in visits {
        clock_s += 8.0;
        let mut positions = vec![0.0; axes.len()];
        let mut stage = Rotation3::identity();
        let mut go = Vector3::zeros();
        if let Some(axis) = axis {
            positions[axis] = q;
            let e: [f64; 6] = std::array::from_fn(|k| curves[axis][k].at(q / travel));
            let tilt = Rotation3::new(Vector3::new(e[3], e[4], e[5]) * 3.0 * ARCSEC);
            go = Vector3::new(e[0], e[1], e[2]) * 4e-3;
            if plan.is_rotary {
                stage = tilt * Rotation3::new(Vector3::z() * q);
            } else {
                stage = tilt;
                go += Vector3::ith(axis, q);
            }
        }
        let step = Step {
            run: axis,
            positions,
        };
        let number = steps.iter().position(|s| *s == step).unwrap_or_else(|| {
            steps.push(step);
            steps.len() - 1
        });
        let back = vector(plan.return_mm);
        let first = points.readings.len();
        let read: Vec<usize> = match axis {
            Some(_) => (0..plan.targets).collect(),
            None => (plan.targets..plan.targets + 3).collect(),
        };
        let place = |t: usize| match axis {
            Some(_) => stage * mounted[t] + go,
            None => BED[t - plan.targets],
        };
        let sum: Vector3<f64> = read.iter().map(|&t| place(t).coords).sum();
        let centroid = Point3::from(sum / read.len() as f64);
        for &target in &read {
            clock_s += 4.0;
            let tau = clock_s / last_s;
            let mut p = place(target);
            if axis.is_some() {
                p += back;
            }
            for hidden in hidden {
                let at = Moment {
                    tau,
                    axis: axis.unwrap_or(9),
                    q,
                    side,
                    target,
                    stage: &stage,
                    centroid,
                    is_on_bed: axis.is_none(),
                };
                p += moved(hidden, &at, &place(target), travel);
            }
            let mut seen = frame * p + stands;
            for hidden in hidden {
                let (gone, turned) = strayed(hidden, tau);
                seen = Rotation3::new(turned).inverse() * (seen - gone);
            }
            let mut noise = vector(plan.noise_mm).component_mul(&Vector3::from(plan.unlike));
            if let Some(angles) = plan.angles {
                let (beam, distance_mm) = (seen.coords.normalize(), seen.coords.norm());
                let along = beam * beam.dot(&noise);
                noise = along + (noise - along) / plan.noise_mm * angles * distance_mm;
            }
            points.readings.push(PointReading {
                time_s: clock_s,
                target,
                position_mm: seen + noise,
                sigma_um: None,
                line: points.readings.len() + 2,
            });
        }
        points.stops.push(Stop {
            station: 0,
            repeat,
            step: number,
            direction: if side > 0.0 {
                Direction::Forward
            } else {
                Direction::Backward
            },
            readings: first..points.readings.len(),
        });
    }
    campaign(plan, axes, points, steps)
}

fn campaign(plan: &Plan, axes: &[&str], points: Points, steps: Vec<Step>) -> Campaign {
    let machine = match plan.is_rotary {
        true => {
            let c = Axis::rotary("C", Vector3::z(), [0.0, TAU], Point3::origin()).unwrap();
            Machine::new(vec![c], vec![], vec![0]).unwrap()
        }
        false => super::three_axes(),
    };
    let target = |name: String, home_mm, carrier| Target {
        name,
        home_mm,
        carrier,
        reflector: None,
        position_sigma_mm: None,
    };
    let carried = (0..plan.targets).map(|k| {
        target(
            ["P", "Q", "K", "R"][k].to_owned(),
            HOME[k],
            Some(axes.len() - 1),
        )
    });
    let mut targets: Vec<Target> = carried.collect();
    if plan.bed {
        targets.extend((0..3).map(|k| target(format!("B{}", k + 1), BED[k], None)));
    }
    Campaign {
        name: "points".into(),
        date: None,
        operator: None,
        machine_name: "made".into(),
        machine,
        expansions: Vec::new(),
        instrument: Instrument::default(),
        targets,
        stations: Vec::new(),
        known_lengths: Vec::new(),
        runs: axes
            .iter()
            .enumerate()
            .map(|(axis, name)| Run {
                name: name.to_lowercase(),
                axis,
            })
            .collect(),
        steps,
        lengths: None,
        points: Some(points),
        verification: Vec::new(),
        point_checks: Vec::new(),
        notices: Vec::new(),
    }
}
