//! Which points move together as rigid bodies.

use nalgebra::{DVector, Isometry3, Point3, Vector3};
use trueaxis_kinematics::centroid;

use crate::state::PER_STATION;
use crate::{Error, Network};

/// Targets whose distances from each other do not change.
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    /// Nominal positions at home, mm.
    pub home_mm: Vec<Point3<f64>>,
}

/// The bodies of a network, and where they are in its groups.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Bodies {
    /// The bodies. Each has a shape of its own, common to all groups that see it.
    pub bodies: Vec<Body>,
    /// One for each group of the network.
    pub of_groups: Vec<Placed>,
}

/// A group's points as targets of a body.
#[derive(Debug, Clone, PartialEq)]
pub struct Placed {
    /// The body; none if the points of the group are free.
    pub body: Option<usize>,
    /// For each point of the group the place among the positions of the body; empty without a body.
    pub places: Vec<usize>,
    /// Nominal pose: reference frame from home.
    pub ref_from_home: Isometry3<f64>,
}

/// A rigid body needs three points that are not in line.
const RIGID: usize = 3;

/// Points whose distances from a line are less than this share of their extent are in line: their rotation about it
/// does not show.
const IN_LINE: f64 = 1e-6;

/// Whether points are too few, or too nearly in line, to show how a body is turned.
pub fn are_in_line(points: &[Point3<f64>]) -> bool {
    let centre = centroid(points);
    let longest =
        points
            .iter()
            .map(|p| p - centre)
            .fold(Vector3::zeros(), |most: Vector3<f64>, arm| {
                if arm.norm() > most.norm() { arm } else { most }
            });
    let extent = longest.norm();
    let off = |p: &Point3<f64>| longest.cross(&(p - centre)).norm();
    points.len() < RIGID || points.iter().all(|p| off(p) <= IN_LINE * extent * extent)
}

impl Bodies {
    /// Checks that each body named by a group exists, and that the points of the group show its pose.
    pub(crate) fn check(&self, points_of_groups: &[std::ops::Range<usize>]) -> Result<(), Error> {
        let malformed = |what: String| Err(Error::malformed(what));
        let (found, need) = (self.of_groups.len(), points_of_groups.len());
        if found != need {
            return malformed(format!("bodies are given for {found} of {need} groups"));
        }
        // Most groups see all targets of their body.
        let mut rigid: Option<(usize, &[usize])> = None;
        for (g, (placed, group)) in self.of_groups.iter().zip(points_of_groups).enumerate() {
            let Some(body) = placed.body else { continue };
            let seen = Some((body, &placed.places[..]));
            if rigid == seen && placed.places.len() == group.len() {
                continue;
            }
            let home_mm = self.bodies.get(body).map(|body| &body.home_mm[..]);
            let of_place = |&place: &usize| home_mm.and_then(|home| home.get(place)).copied();
            let places: Option<Vec<_>> = placed.places.iter().map(of_place).collect();
            match places {
                Some(places) if places.len() == group.len() => {
                    if are_in_line(&places) {
                        let points = group.len();
                        return Err(Error::NotRigid { group: g, points });
                    }
                    rigid = seen;
                }
                _ => return malformed(format!("group {g} names targets that no body has")),
            }
        }
        Ok(())
    }
}

impl Body {
    /// Orthonormal displacements of all points that no rigid motion makes, one for each way in which the shape can
    /// differ from nominal, with three numbers for each point.
    pub(crate) fn deformations(&self) -> Vec<DVector<f64>> {
        let count = self.home_mm.len();
        let centre = centroid(&self.home_mm);
        let motion = |k: usize| {
            let unit = Vector3::ith(k % 3, 1.0);
            let of_point = |p: &Point3<f64>| match k {
                0..3 => unit,
                _ => unit.cross(&(p - centre)),
            };
            let all = self.home_mm.iter().map(of_point);
            DVector::from_iterator(3 * count, all.flat_map(|v| [v.x, v.y, v.z]))
        };
        let mut basis: Vec<DVector<f64>> = Vec::new();
        for k in 0..6 {
            let length = motion(k).norm();
            let left = without(motion(k), &basis);
            // Points in line do not move when turned about it.
            if left.norm() > IN_LINE * length {
                basis.push(left.normalize());
            }
        }
        let motions = basis.len();
        while basis.len() < 3 * count {
            // The unit displacement least covered by the basis: at least the share of the free dimensions remains.
            let taken = |i: usize| basis.iter().map(|unit| unit[i] * unit[i]).sum::<f64>();
            let least = (0..3 * count).min_by(|&i, &j| taken(i).total_cmp(&taken(j)));
            let mut unit = DVector::zeros(3 * count);
            unit[least.unwrap_or_default()] = 1.0;
            basis.push(without(unit, &basis).normalize());
        }
        basis.split_off(motions)
    }
}

/// `x` without its parts along an orthonormal basis; done twice to remove the rounding of the first time.
fn without(mut x: DVector<f64>, basis: &[DVector<f64>]) -> DVector<f64> {
    for _ in 0..2 {
        for unit in basis {
            let along = unit.dot(&x);
            x.axpy(-along, unit, 1.0);
        }
    }
    x
}

/// The deformations of all bodies as shared unknowns.
#[derive(Debug, Default)]
pub(crate) struct Deformations {
    /// For each body the deformations, as displacements of its targets.
    pub(crate) of_bodies: Vec<Vec<DVector<f64>>>,
    /// Where the deformations of each body are among the shared unknowns.
    pub(crate) first: Vec<usize>,
    /// Number of all shared unknowns.
    pub(crate) shared: usize,
}

impl Deformations {
    /// The deformations of the bodies of a network: behind stations and dead paths.
    pub(crate) fn new(network: &Network) -> Self {
        let mut new = Self {
            shared: PER_STATION * network.stations.len() + network.interruptions.len(),
            ..Self::default()
        };
        for body in network.bodies.iter().flat_map(|bodies| &bodies.bodies) {
            let own = body.deformations();
            new.first.push(new.shared);
            new.shared += own.len();
            new.of_bodies.push(own);
        }
        new
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_triangle_has_three_deformations_and_none_moves_it() {
        let body = Body {
            home_mm: vec![
                Point3::new(16.0, 452.0, 122.0),
                Point3::new(157.0, 332.0, 324.0),
                Point3::new(248.0, 603.0, 412.0),
            ],
        };
        let deformations = body.deformations();
        assert_eq!(deformations.len(), 3);
        let centre = centroid(&body.home_mm);
        for (i, deformation) in deformations.iter().enumerate() {
            let (mut shift, mut turn) = (Vector3::zeros(), Vector3::zeros());
            for (k, p) in body.home_mm.iter().enumerate() {
                let moved = deformation.fixed_rows::<3>(3 * k).into_owned();
                shift += moved;
                turn += (p - centre).cross(&moved);
            }
            assert!(shift.norm() < 1e-12 && turn.norm() < 1e-10);
            for other in &deformations[..i] {
                assert!(deformation.dot(other).abs() < 1e-12);
            }
        }
    }
}
