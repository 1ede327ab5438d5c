//! The points of the paper, and stations around them.

use nalgebra::{Point3, Vector3};
use trueaxis_multilateration::{Network, Noise, Reading, Visit};

/// Four stations.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Arrangement {
    pub(crate) name: &'static str,
    pub(crate) stations_mm: [Point3<f64>; 4],
}

/// Distance of the stations of the tetrahedron from the centre of the points.
const TETRAHEDRON_MM: f64 = 800.0;

/// The stations that minimise the largest standard deviation of a coordinate, each between 0.3 m
/// and 3 m from every point (the second and third stand at these limits), rounded to 1 mm. They are
/// data: the best of eight random starts of an evolution strategy (CMA-ES with its default weights and
/// rates, 12 coordinates, 16 offspring, until it moved stations by less than 0.1 mm; N. Hansen, The CMA
/// evolution strategy: a tutorial, arXiv 1604.00772). A test looks for better ones near them.
const OPTIMISED_MM: [[f64; 3]; 4] = [
    [-335.0, 1231.0, -148.0],
    [3.0, 123.0, 875.0],
    [1289.0, -1072.0, -1447.0],
    [1664.0, 1132.0, 972.0],
];

/// Targets at home and strokes of section 5.1 of the paper.
const TARGETS_MM: [[f64; 3]; 3] = [
    [16.338, 452.716, 122.416],
    [157.086, 332.593, 324.879],
    [248.925, 603.0552, 412.4483],
];
const STEPS: [u32; 3] = [22, 20, 20];
const STEP_MM: f64 = 20.0;

/// Points of a step.
pub(crate) const TARGETS: usize = TARGETS_MM.len();

/// Any; it is found together with everything else.
const DEAD_PATH_MM: f64 = 50.0;

/// The places of the three targets at all steps of the three axes, step after step: 195 points.
pub(crate) fn points_mm() -> Vec<Point3<f64>> {
    let steps = STEPS.into_iter().enumerate();
    let moves = steps.flat_map(|(axis, last)| {
        (0..=last).map(move |step| Vector3::ith(axis, f64::from(step) * STEP_MM))
    });
    moves
        .flat_map(|shift| TARGETS_MM.map(|target| Point3::from(target) + shift))
        .collect()
}

/// A regular tetrahedron around the centre of the points, its edges along diagonals of a cube.
pub(crate) fn tetrahedron(points_mm: &[Point3<f64>]) -> Arrangement {
    let corners = [
        [1.0, 1.0, 1.0],
        [1.0, -1.0, -1.0],
        [-1.0, 1.0, -1.0],
        [-1.0, -1.0, 1.0],
    ];
    let sum: Vector3<f64> = points_mm.iter().map(|p| p.coords).sum();
    let centre = Point3::from(sum / points_mm.len() as f64);
    Arrangement {
        name: "regular tetrahedron, 800 mm from the centre of the points",
        stations_mm: corners
            .map(|corner| centre + TETRAHEDRON_MM * Vector3::from(corner).normalize()),
    }
}

/// The best that was found.
pub(crate) fn optimised() -> Arrangement {
    Arrangement {
        name: "optimised, 0.3 m to 3 m from every point",
        stations_mm: OPTIMISED_MM.map(Point3::from),
    }
}

/// Exact lengths from all stations to all points. The paper's machine returns to each place anew for
/// each station, so that the repeatability errors of the three targets of a step are independent: each
/// length is a visit of its own.
pub(crate) fn network(
    points_mm: &[Point3<f64>],
    stations_mm: &[Point3<f64>; 4],
    noise: Noise,
) -> Network {
    let pairs = stations_mm
        .iter()
        .enumerate()
        .flat_map(|(station, s)| points_mm.iter().enumerate().map(move |p| (station, s, p)));
    let (readings, visits) = pairs
        .enumerate()
        .map(|(place, (station, s, (i, p)))| {
            let length_mm = (p - s).norm() - DEAD_PATH_MM;
            let (group, point) = (i / TARGETS, i % TARGETS);
            let readings = place..place + 1;
            (
                Reading { point, length_mm },
                Visit {
                    station,
                    group,
                    readings,
                },
            )
        })
        .unzip();
    let steps = points_mm.len() / TARGETS;
    Network {
        stations: vec![None; stations_mm.len()],
        nominal_mm: points_mm.to_vec(),
        groups: (0..steps)
            .map(|step| TARGETS * step..TARGETS * (step + 1))
            .collect(),
        visits,
        readings,
        noise,
        ..Network::default()
    }
}
