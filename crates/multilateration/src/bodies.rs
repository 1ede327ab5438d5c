//! Which points move together as rigid bodies.

use nalgebra::{DMatrix, DVector, Isometry3, Point3, Vector3};
use trueaxis_campaign::Campaign;
use trueaxis_kinematics::Ideal;

use crate::{Error, Group};

/// The targets of one stage.
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    /// Nominal positions at home, mm.
    pub home_mm: Vec<Point3<f64>>,
}

/// The bodies of a network, and which points of which group belong to them.
#[derive(Debug, Clone, PartialEq)]
pub struct Bodies {
    /// The bodies.
    pub bodies: Vec<Body>,
    /// For each group of the network its body.
    pub body_of_group: Vec<usize>,
    /// For each group, for each of its points the place among the positions of the body.
    pub places: Vec<Vec<usize>>,
    /// Nominal pose of the body at each group: reference frame from home.
    pub ref_from_home: Vec<Isometry3<f64>>,
}

/// A rigid body is three points that are not in line.
const RIGID: usize = 3;

impl Bodies {
    /// The bodies of a campaign's network: targets on one stage are one body, whichever axis moves
    /// it. Targets of a run that sit on several stages are a body of their own, since these stand
    /// still against each other only during this run.
    ///
    /// # Errors
    /// [`Error::NotRigid`] if a step has fewer than three targets.
    pub fn of_campaign(campaign: &Campaign, groups: &[Group]) -> Result<Self, Error> {
        let mut keys: Vec<(Option<usize>, Vec<usize>)> = Vec::new();
        let mut bodies = Self {
            bodies: Vec::new(),
            body_of_group: Vec::new(),
            places: Vec::new(),
            ref_from_home: Vec::new(),
        };
        for (number, group) in groups.iter().enumerate() {
            if group.targets.len() < RIGID {
                return Err(Error::NotRigid {
                    group: number,
                    points: group.targets.len(),
                });
            }
            let step = &campaign.steps[group.step];
            let carrier = campaign.targets[group.targets[0]].carrier;
            let on_one_stage = group
                .targets
                .iter()
                .all(|&t| campaign.targets[t].carrier == carrier);
            let run = (!on_one_stage).then_some(step.run);
            let together = |other: usize| match run {
                None => campaign.targets[other].carrier == carrier,
                Some(_) => group.targets.contains(&other),
            };
            let targets: Vec<usize> = (0..campaign.targets.len())
                .filter(|&t| together(t))
                .collect();
            let key = (run, targets);
            let body = keys.iter().position(|known| *known == key);
            let body = body.unwrap_or_else(|| {
                let home_mm = key.1.iter().map(|&t| campaign.targets[t].home_mm);
                bodies.bodies.push(Body {
                    home_mm: home_mm.collect(),
                });
                keys.push(key.clone());
                keys.len() - 1
            });
            let place = |target: &usize| key.1.binary_search(target).unwrap_or_default();
            bodies.body_of_group.push(body);
            bodies
                .places
                .push(group.targets.iter().map(place).collect());
            // The rigid motion of the outermost stage; on a lower one a body is placed by the
            // adjustment.
            let outermost = key.1.iter().map(|&t| campaign.targets[t].carrier);
            let outermost = outermost
                .max_by_key(|&axis| campaign.machine.chain(axis).len())
                .unwrap_or(carrier);
            bodies
                .ref_from_home
                .push(campaign.machine.motion(&Ideal, outermost, &step.positions));
        }
        Ok(bodies)
    }
}

impl Body {
    /// Orthonormal displacements of all points that no rigid motion makes: one for each way in which
    /// the shape can differ from nominal, three numbers for each point.
    pub(crate) fn deformations(&self) -> Vec<DVector<f64>> {
        let count = self.home_mm.len();
        let sum: Vector3<f64> = self.home_mm.iter().map(|p| p.coords).sum();
        let centroid = Point3::from(sum / count as f64);
        let motion = |k: usize| {
            let unit = Vector3::ith(k % 3, 1.0);
            let of_point = |p: &Point3<f64>| match k {
                0..3 => unit,
                _ => unit.cross(&(p - centroid)),
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
            // The unit displacement of which most is left; at least the share of the free dimensions.
            let candidates = (0..3 * count).map(|i| {
                let mut unit = DVector::zeros(3 * count);
                unit[i] = 1.0;
                without(unit, &basis)
            });
            let largest = candidates.max_by(|a, b| a.norm().total_cmp(&b.norm()));
            basis.push(
                largest
                    .unwrap_or_else(|| DVector::zeros(3 * count))
                    .normalize(),
            );
        }
        basis.split_off(motions)
    }
}

/// What of a rotation must be left beside the others, relative to its size.
const IN_LINE: f64 = 1e-6;

/// `x` without its parts along an orthonormal basis; twice, so that rounding does not stay.
fn without(mut x: DVector<f64>, basis: &[DVector<f64>]) -> DVector<f64> {
    for _ in 0..2 {
        for unit in basis {
            let along = unit.dot(&x);
            x.axpy(-along, unit, 1.0);
        }
    }
    x
}

/// Displacements of points at lever arms from their centroid by the six motions of the body:
/// translations, then rotations about the reference axes. Rows are `x y z` of each point.
pub(crate) fn rigid_motions(arms_mm: &[Vector3<f64>]) -> DMatrix<f64> {
    DMatrix::from_fn(3 * arms_mm.len(), 6, |row, k| {
        let unit = Vector3::ith(k % 3, 1.0);
        let moved = match k {
            0..3 => unit,
            _ => unit.cross(&arms_mm[row / 3]),
        };
        moved[row % 3]
    })
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
        let sum: Vector3<f64> = body.home_mm.iter().map(|p| p.coords).sum();
        let arms: Vec<_> = body.home_mm.iter().map(|p| p.coords - sum / 3.0).collect();
        let motions = rigid_motions(&arms);
        for (i, deformation) in deformations.iter().enumerate() {
            assert!((motions.transpose() * deformation).norm() < 1e-10);
            for other in &deformations[..i] {
                assert!(deformation.dot(other).abs() < 1e-12);
            }
        }
    }
}
