//! The position of one station, from the nominal points that it sees.
//!
//! For one station with centred and scaled coordinates the square of `l + L = |p - S|` is linear
//! in `S`, `L` and `q = |S|² - L²`:
//!
//! ```text
//! 2 pᵀS + 2 l L - q = |p|² - l²
//! ```
//!
//! If all points lie in one plane, or nearly so, they leave open on which side of the plane the station stands. Both
//! sides are tried; if they fit equally well, both are returned.

use nalgebra::{DMatrix, Matrix3, Matrix4, Point3, Unit, Vector3, Vector4};
use trueaxis_leastsquares::{Error as LeastSquaresError, dense};

use super::POOR_FIT;
use crate::Station;

/// Two mirror images are undecided if their fits differ by less than this factor,
const TIE: f64 = 1.01;

/// or by less than this, mm: nominal positions are not known to a micrometre.
const TIE_MM: f64 = 1e-3;

const MAX_ITERATIONS: usize = 200;

#[derive(Debug, Clone, Copy)]
pub(super) struct Sighting {
    pub(super) point: Point3<f64>,
    pub(super) length_mm: f64,
}

/// Position and spread of the points that one station sees.
pub(super) struct Cloud {
    centroid: Point3<f64>,
    pub(super) radius_mm: f64,
    mean_length_mm: f64,
    /// Direction in which the points spread least; its largest component is positive.
    normal: Unit<Vector3<f64>>,
}

impl Cloud {
    pub(super) fn new(sightings: &[Sighting]) -> Self {
        let count = sightings.len().max(1) as f64;
        let sum: Vector3<f64> = sightings.iter().map(|s| s.point.coords).sum();
        let centroid = Point3::from(sum / count);
        let mut spread = Matrix3::zeros();
        for s in sightings {
            let d = s.point - centroid;
            spread += d * d.transpose();
        }
        let eigen = spread.symmetric_eigen();
        let normal = eigen
            .eigenvectors
            .column(eigen.eigenvalues.imin())
            .into_owned();
        let normal = Unit::new_normalize(normal * normal[normal.iamax()].signum());
        Self {
            centroid,
            radius_mm: (spread.trace() / count).sqrt().max(f64::MIN_POSITIVE),
            mean_length_mm: sightings.iter().map(|s| s.length_mm).sum::<f64>() / count,
            normal,
        }
    }

    /// Height above the plane of the points.
    fn height(&self, p: Point3<f64>) -> f64 {
        (p - self.centroid).dot(&self.normal)
    }

    pub(super) fn on_other_side(&self, p: Point3<f64>, q: Point3<f64>) -> bool {
        self.height(p) * self.height(q) < 0.0
    }

    fn mirrored(&self, p: Point3<f64>) -> Point3<f64> {
        p - self.normal.into_inner() * (2.0 * self.height(p))
    }
}

#[derive(Debug, Clone, Copy)]
pub(super) struct StationFit {
    pub(super) station: Station,
    pub(super) rms_mm: f64,
}

/// All fits as good as the best one. The first is the nearest to `approx` or, without it, on the side to which the
/// normal of the points leads.
pub(super) fn find_station(
    sightings: &[Sighting],
    cloud: &Cloud,
    approx: Option<Point3<f64>>,
) -> Vec<StationFit> {
    let mut starts: Vec<Point3<f64>> = approx.into_iter().collect();
    for position in linear_candidates(sightings, cloud) {
        starts.extend([position, cloud.mirrored(position)]);
    }
    let mut fits = best_fits(sightings, &starts);
    if fits
        .first()
        .is_none_or(|fit| fit.rms_mm > POOR_FIT * cloud.radius_mm)
    {
        starts.extend(surrounding(cloud));
        fits = best_fits(sightings, &starts);
    }
    let rank = |fit: &StationFit| match approx {
        Some(approx) => (fit.station.position_mm - approx).norm(),
        None => -cloud.height(fit.station.position_mm),
    };
    fits.sort_by(|a, b| rank(a).total_cmp(&rank(b)));
    fits
}

/// The refined starts that fit as well as the best one.
fn best_fits(sightings: &[Sighting], starts: &[Point3<f64>]) -> Vec<StationFit> {
    let fits = starts.iter().filter_map(|&start| refine(sightings, start));
    let mut fits: Vec<StationFit> = fits.collect();
    let all = fits.iter().map(|fit| fit.rms_mm);
    let least = all.fold(f64::INFINITY, f64::min);
    fits.retain(|fit| fit.rms_mm <= TIE * least + TIE_MM);
    fits
}

/// Solutions of the linear equations; two where the points leave one combination free, which the definition of `q`
/// then determines by a quadratic equation.
fn linear_candidates(sightings: &[Sighting], cloud: &Cloud) -> Vec<Point3<f64>> {
    let unit_mm = cloud.radius_mm;
    let scaled = |s: &Sighting| {
        let place = (s.point - cloud.centroid) / unit_mm;
        (place, (s.length_mm - cloud.mean_length_mm) / unit_mm)
    };
    let scaled: Vec<_> = sightings.iter().map(scaled).collect();
    let design = DMatrix::from_fn(scaled.len(), 5, |i, k| match (k, scaled[i]) {
        (0..3, (p, _)) => 2.0 * p[k],
        (3, (_, l)) => 2.0 * l,
        _ => -1.0,
    });
    let square = |(p, l): &(Vector3<f64>, f64)| p.norm_squared() - l * l;
    let right: Vec<f64> = scaled.iter().map(square).collect();
    let position = |s: Vector3<f64>| cloud.centroid + s * unit_mm;
    match dense::solve(&design, &right) {
        Ok(fit) => vec![position(Vector3::from_column_slice(&fit.unknowns[..3]))],
        Err(LeastSquaresError::DenseRank { rank: 4, .. }) => {
            // The points lie in a plane: the linear equations give the foot of the station in it, and the height
            // follows from q = |S|² - L².
            planar_candidates(design, &right, cloud.normal)
                .into_iter()
                .map(position)
                .collect()
        }
        Err(_) => Vec::new(),
    }
}

fn planar_candidates(
    design: DMatrix<f64>,
    right: &[f64],
    normal: Unit<Vector3<f64>>,
) -> Vec<Vector3<f64>> {
    // Express S in two directions of the plane; the column normal to it is not needed.
    let u = Unit::new_normalize(normal.cross(&Vector3::ith(normal.iamin(), 1.0)));
    let v = normal.cross(&u);
    let in_plane = DMatrix::from_fn(design.nrows(), 4, |i, k| {
        let p = Vector3::new(design[(i, 0)], design[(i, 1)], design[(i, 2)]);
        match k {
            0 => p.dot(&u),
            1 => p.dot(&v),
            _ => design[(i, k + 1)],
        }
    });
    let fit = dense::solve(&in_plane, right).map(|fit| fit.unknowns);
    let Ok(&[a, b, l, q]) = fit.as_deref() else {
        return Vec::new();
    };
    let height = (q + l * l - a * a - b * b).max(0.0).sqrt();
    let foot = u.into_inner() * a + v * b;
    [height, -height]
        .map(|height| foot + normal.into_inner() * height)
        .to_vec()
}

/// Starts all around the points, in case the linear ones fail.
fn surrounding(cloud: &Cloud) -> Vec<Point3<f64>> {
    let mut starts = Vec::new();
    for distance in [1.5, 3.0, 6.0, 12.0] {
        // The 26 neighbours of the middle of a 3 × 3 × 3 cube.
        for cell in (0..27).filter(|&cell| cell != 13) {
            let digit = |d: i32| f64::from(cell / d % 3 - 1);
            let towards = Vector3::new(digit(1), digit(3), digit(9)).normalize();
            starts.push(cloud.centroid + towards * (distance * cloud.radius_mm));
        }
    }
    starts
}

/// Levenberg–Marquardt on the four unknowns of one station; the points are held.
fn refine(sightings: &[Sighting], start: Point3<f64>) -> Option<StationFit> {
    let mut position = start;
    let mut dead_path = mean_dead_path(sightings, position);
    let mut here = Equations::new(sightings, position, dead_path);
    let mut damping = 1e-3;
    for _ in 0..MAX_ITERATIONS {
        let damping_matrix = Matrix4::from_diagonal(&(here.normal.diagonal() * damping));
        let step = (here.normal + damping_matrix)
            .cholesky()?
            .solve(&here.right);
        let (next, next_dead_path) = (position + step.xyz(), dead_path + step.w);
        let there = Equations::new(sightings, next, next_dead_path);
        if there.squares < here.squares {
            let gain = 1.0 - there.squares / here.squares;
            (position, dead_path, here) = (next, next_dead_path, there);
            damping *= 0.1;
            if gain < 1e-6 {
                break;
            }
        } else if damping > 1e6 || step.norm() < 1e-9 {
            break;
        } else {
            damping *= 10.0;
        }
    }
    let rms_mm = (here.squares / sightings.len().max(1) as f64).sqrt();
    let station = Station {
        position_mm: position,
        dead_path_mm: dead_path,
    };
    rms_mm.is_finite().then_some(StationFit { station, rms_mm })
}

/// `Σ r²`, `JᵀJ` and `Jᵀr` of the lengths to one station, whose rows of `J` are `-(u, 1)` with the unit vectors `u` to the points.
struct Equations {
    squares: f64,
    normal: Matrix4<f64>,
    right: Vector4<f64>,
}

impl Equations {
    fn new(sightings: &[Sighting], position: Point3<f64>, dead_path: f64) -> Self {
        let mut all = Self {
            squares: 0.0,
            normal: Matrix4::zeros(),
            right: Vector4::zeros(),
        };
        for s in sightings {
            let beam = s.point - position;
            let distance = beam.norm();
            let residual = s.length_mm - (distance - dead_path);
            let row = -(beam / distance).push(1.0);
            all.squares += residual * residual;
            all.normal += row * row.transpose();
            all.right += row * residual;
        }
        all
    }
}

fn mean_dead_path(sightings: &[Sighting], position: Point3<f64>) -> f64 {
    let sum: f64 = sightings
        .iter()
        .map(|s| (s.point - position).norm() - s.length_mm)
        .sum();
    sum / sightings.len().max(1) as f64
}

pub(super) fn residual_mm(s: &Sighting, station: Station) -> f64 {
    s.length_mm - ((s.point - station.position_mm).norm() - station.dead_path_mm)
}
