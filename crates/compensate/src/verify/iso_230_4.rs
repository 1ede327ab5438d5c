//! Circular tests by ISO 230-4, 3, as far as the set-up of the bar leaves them determined.
//!
//! Each path has a least-squares centre; what the readings `r` are beside its offset `c` (`a`: direction of the bar),
//!
//! ```text
//! f_i = r_i - a_i · c        D = mean of f about the common centre of both paths
//! G = F_max - F_min          H = max |r_i↑ - r_i↓|
//! ```
//!
//! - `G`: circular deviation, the distance of two concentric circles around a path; `G(b)`: the same around both paths,
//!   clockwise and counter-clockwise, about their common centre. The standard allows the least-squares circle for the smallest
//!   pair of circles, beside which `G` is a little too large.
//! - `F_max`, `F_min`: radial deviation, from the nominal circle about that centre; `D`: mean bidirectional radial deviation, of
//!   the radius of the least-squares circle of both paths from the nominal one. Both need a bar of calibrated length.
//! - `H`: circular hysteresis, the largest difference of the two paths.

use nalgebra::DVector;
use trueaxis_campaign::{Direction, VerificationKind};
use trueaxis_kinematics::Machine;

use crate::freedom::pseudo_inverse;
use crate::verify::{Point, ROUNDING, are_same, set_up};

/// The quantities, µm. Those of a path that was not run are not there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Circular {
    /// G of the readings with direction +1.
    pub g_forward_um: Option<f64>,
    /// G of those with direction -1.
    pub g_backward_um: Option<f64>,
    /// G(b), both.
    pub g_both_um: Option<f64>,
    /// H.
    pub h_um: Option<f64>,
    /// Least and largest F with direction +1, if the length of the bar is calibrated.
    pub f_forward_um: Option<[f64; 2]>,
    /// The same with direction -1.
    pub f_backward_um: Option<[f64; 2]>,
    /// D, if the length of the bar is calibrated.
    pub d_um: Option<f64>,
}

/// A path about its least-squares centre, µm.
struct Path {
    least: f64,
    largest: f64,
    /// Radius of the least-squares circle beyond nominal.
    radius: f64,
}

impl Circular {
    /// Of readings as they are; none of a positioning line.
    pub(crate) fn new(
        machine: &Machine,
        kind: &VerificationKind,
        points: &[Point],
    ) -> Option<Self> {
        let VerificationKind::Ballbar {
            length_is_calibrated,
            ..
        } = *kind
        else {
            return None;
        };
        let [forward, backward] = [Direction::Forward, Direction::Backward].map(|direction| {
            let own = points
                .iter()
                .filter(|point| point.direction == Some(direction));
            own.collect::<Vec<_>>()
        });
        let pairs = forward.iter().filter_map(|f| {
            let mut opposite = backward.iter();
            let same = opposite.find(|b| are_same(&f.positions, &b.positions));
            same.map(|b| (f.reading_um - b.reading_um).abs())
        });
        let h_um = pairs.reduce(f64::max);
        let path = |points: &[&Point]| Path::new(machine, kind, points);
        let is_both = !forward.is_empty() && !backward.is_empty();
        let both = [forward.as_slice(), backward.as_slice()].concat();
        let both = is_both.then(|| path(&both)).flatten();
        let [forward, backward] = [&forward, &backward].map(|points| path(points));
        let g = |path: &Option<Path>| path.as_ref().map(|path| path.largest - path.least);
        let f = |path: &Option<Path>| {
            let path = path.as_ref().filter(|_| length_is_calibrated);
            path.map(|path| [path.least, path.largest])
        };
        Some(Self {
            g_forward_um: g(&forward),
            g_backward_um: g(&backward),
            g_both_um: g(&both),
            h_um,
            f_forward_um: f(&forward),
            f_backward_um: f(&backward),
            d_um: both
                .filter(|_| length_is_calibrated)
                .map(|path| path.radius),
        })
    }
}

impl Path {
    fn new(machine: &Machine, kind: &VerificationKind, points: &[&Point]) -> Option<Self> {
        if points.is_empty() {
            return None;
        }
        let set_up = set_up(machine, kind, points);
        let readings = points.iter().map(|point| point.reading_um);
        let readings = DVector::from_iterator(points.len(), readings);
        // The last column is the length. What a bar that is inclined to the plane of its path does not tell from it is no centre.
        let centre = set_up.columns(0, set_up.ncols() - 1).into_owned();
        let mut beside_length = centre.clone();
        for mut column in beside_length.column_iter_mut() {
            let mean = column.mean();
            column.add_scalar_mut(-mean);
        }
        let of_readings = readings.add_scalar(-readings.mean());
        let tolerance = ROUNDING * set_up.norm();
        let left = readings - centre * (pseudo_inverse(&beside_length, tolerance) * of_readings);
        let radius = left.mean();
        Some(Self {
            least: left.iter().copied().reduce(f64::min)?,
            largest: left.iter().copied().reduce(f64::max)?,
            radius,
        })
    }
}
