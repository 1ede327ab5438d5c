//! Nominal geometry: axes, targets and sweeps.

use nalgebra::{Point3, Vector3};
use trueaxis_kinematics::{Axis, Error, Machine};

use super::{Geometry, Kind};

/// The nominal machine, its targets and the sweeps of its axes.
pub(super) struct Layout {
    pub(super) name: &'static str,
    pub(super) machine: Machine,
    pub(super) targets: Vec<LayoutTarget>,
    pub(super) sweeps: Vec<Sweep>,
    /// Middle of the measured points, mm.
    pub(super) centre_mm: Point3<f64>,
}

/// Targets on the bed, one of them on a column: name, and place from the middle of the measured points, mm. All at
/// one height, they would see little of a shift across flat beams.
const ON_BED: [(&str, [f64; 3]); 3] = [
    ("B1", [-470.0, -390.0, -420.0]),
    ("B2", [520.0, -250.0, 450.0]),
    ("B3", [20.0, 560.0, -440.0]),
];

/// A target: name, nominal position at home, outermost axis that moves it (none on the bed).
pub(super) struct LayoutTarget {
    pub(super) name: &'static str,
    pub(super) home_mm: Point3<f64>,
    pub(super) carrier: Option<usize>,
}

/// A sweep of one axis; the others stay at home.
pub(super) struct Sweep {
    pub(super) axis: usize,
    /// Commanded positions, evenly spaced and increasing, mm or rad.
    pub(super) positions: Vec<f64>,
    /// The targets that the axis moves.
    pub(super) targets: Vec<usize>,
}

impl Layout {
    pub(super) fn new(kind: &Kind) -> Self {
        let layout = match kind.geometry {
            Geometry::ThreeAxis => three_axis(),
            Geometry::RotaryStage => rotary_stage(),
            Geometry::FiveAxis => five_axis(),
        };
        let mut layout = layout.expect("the nominal machines are consistent");
        if kind.bed_readings > 0 {
            let on_bed = ON_BED.map(|(name, from_centre_mm)| LayoutTarget {
                name,
                home_mm: layout.centre_mm + Vector3::from(from_centre_mm),
                carrier: None,
            });
            layout.targets.extend(on_bed);
        }
        layout
    }

    /// The targets on the bed.
    pub(super) fn on_bed(&self) -> Vec<usize> {
        let targets = 0..self.targets.len();
        targets
            .filter(|&t| self.targets[t].carrier.is_none())
            .collect()
    }

    fn from(
        name: &'static str,
        machine: Machine,
        targets: &[(&'static str, [f64; 3], usize)],
        positions: Vec<Vec<f64>>,
        centre_mm: [f64; 3],
    ) -> Self {
        let targets: Vec<LayoutTarget> = targets
            .iter()
            .map(|&(name, home_mm, carrier)| LayoutTarget {
                name,
                home_mm: Point3::from(home_mm),
                carrier: Some(carrier),
            })
            .collect();
        let moved_by = |axis: usize| {
            let moved = |i: &usize| machine.chain(targets[*i].carrier).contains(&axis);
            (0..targets.len()).filter(moved).collect()
        };
        let sweeps = positions
            .into_iter()
            .enumerate()
            .map(|(axis, positions)| Sweep {
                axis,
                positions,
                targets: moved_by(axis),
            });
        Self {
            name,
            sweeps: sweeps.collect(),
            machine,
            targets,
            centre_mm: Point3::from(centre_mm),
        }
    }

    /// Lowest and highest position of an axis in the sweeps, mm or rad.
    pub(super) fn range(&self, axis: usize) -> [f64; 2] {
        let positions = &self.sweeps[axis].positions;
        [positions[0], positions[positions.len() - 1]]
    }
}

/// Section 5.1 of the paper.
fn three_axis() -> Result<Layout, Error> {
    let axes = vec![
        Axis::linear("X", Vector3::x(), [0.0, 440.0])?,
        Axis::linear("Y", Vector3::y(), [0.0, 400.0])?,
        Axis::linear("Z", Vector3::z(), [0.0, 400.0])?,
    ];
    Ok(Layout::from(
        "three-axis machine",
        Machine::new(axes, vec![0, 1, 2], vec![])?,
        &[
            ("P", [16.338, 452.716, 122.416], 2),
            ("Q", [157.086, 332.593, 324.879], 2),
            ("K", [248.925, 603.0552, 412.4483], 2),
        ],
        vec![
            spaced(0.0, 20.0, 23),
            spaced(0.0, 20.0, 21),
            spaced(0.0, 20.0, 21),
        ],
        [350.0, 650.0, 450.0],
    ))
}

/// Section 5.2 of the paper.
fn rotary_stage() -> Result<Layout, Error> {
    let travel = [0.0, 360_f64.to_radians()];
    let c = Axis::rotary("C", Vector3::z(), travel, Point3::origin())?;
    Ok(Layout::from(
        "rotary stage",
        Machine::new(vec![c], vec![], vec![0])?,
        &[
            ("P", [-105.8046, 135.3414, 0.0], 0),
            ("Q", [128.8513, 87.8158, 39.9797], 0),
            ("K", [24.9026, -110.8575, 15.2662], 0),
        ],
        vec![degrees(0.0, 20.0, 19)],
        [0.0, 0.0, 20.0],
    ))
}

/// The shipped five-axis campaign with fewer positions.
fn five_axis() -> Result<Layout, Error> {
    let a_travel = [-90_f64, 90.0].map(f64::to_radians);
    let c_travel = [0_f64, 360.0].map(f64::to_radians);
    let axes = vec![
        Axis::linear("X", Vector3::x(), [0.0, 400.0])?,
        Axis::linear("Y", Vector3::y(), [0.0, 400.0])?,
        Axis::linear("Z", Vector3::z(), [0.0, 400.0])?,
        Axis::rotary("A", Vector3::x(), a_travel, Point3::new(0.0, 200.0, 40.0))?,
        Axis::rotary("C", Vector3::z(), c_travel, Point3::new(200.0, 200.0, 0.0))?,
    ];
    Ok(Layout::from(
        "five-axis machine",
        Machine::new(axes, vec![0, 1, 2], vec![3, 4])?,
        &[
            ("P", [22.0, 61.5, 402.0], 2),
            ("Q", [178.4, 18.2, 463.7], 2),
            ("K", [96.3, 163.9, 548.1], 2),
            ("U", [92.6, 131.8, 78.3], 4),
            ("V", [311.7, 158.4, 112.9], 4),
            ("W", [187.2, 318.5, 164.6], 4),
        ],
        vec![
            spaced(0.0, 80.0, 6),
            spaced(0.0, 80.0, 6),
            spaced(0.0, 80.0, 6),
            degrees(-60.0, 30.0, 6),
            degrees(0.0, 40.0, 10),
        ],
        [220.0, 220.0, 350.0],
    ))
}

/// `start, start + step, ...`, `count` of them.
fn spaced(start: f64, step: f64, count: u32) -> Vec<f64> {
    (0..count).map(|i| start + step * f64::from(i)).collect()
}

/// The same in degrees, as rad.
fn degrees(start: f64, step: f64, count: u32) -> Vec<f64> {
    let all = spaced(start, step, count);
    all.into_iter().map(f64::to_radians).collect()
}
