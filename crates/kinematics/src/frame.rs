//! The reference frame (paper 4.2.1, here for axes of any kind): which axes and targets fix it, and the
//! small motion of the whole that it takes out of what was measured.
//!
//! - **Lines.** With two linear axes of different direction (in the order X, Y, Z of their nearest
//!   directions) the average line of the first has its nominal direction, and that of the second
//!   lies in the nominal plane of the two.
//! - **Anchors.** What lines leave open, targets decide by the best fit of their home positions to
//!   the nominal ones: the origin always, the rotation about the line with one linear axis, the whole
//!   rotation with none. They are the targets of one stage, that of the first target which the runs of
//!   the first linear axis measure, so that nothing but their mounting lies between them; without a
//!   linear run they are all targets.
//!
//! ```text
//! two lines    ρ = t1⊥ + d1 (t2 - t1⊥)·p / d1·p        p = d2 × (d1 × d2)
//! one line     ρ = t1⊥ + d1 d1·(m - J t1⊥) / d1·J d1   m = Σ r × s,  J = Σ |r|² I - r rᵀ
//! none         ρ = J⁺ m
//! ```
//!
//! (`d`: nominal directions, `t`: tilts of the lines, `⊥`: across the first, `r`: nominal positions of
//! the anchors from their centroid, `s`: their shifts.) The translation is the mean of the shifts.

use nalgebra::{Isometry3, Matrix3, Point3, Translation3, UnitQuaternion, Vector3};

use crate::{AxisKind, LocationComponent, Machine};

/// Directions closer than this (sine of the angle, 5.7 degrees) do not span a plane: an error of the
/// second one across the first would turn the plane by more than ten times as much.
const PARALLEL_TOL: f64 = 0.1;

/// Part of a unit normal below which it has none in that direction.
const NORMAL_TOL: f64 = 1e-9;

/// Moment of inertia, relative to the greatest, below which the anchors stand on the line about which
/// it is taken: they hold no rotation about it.
const INERTIA_TOL: f64 = 1e-12;

/// A target where it should be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NominalTarget {
    /// Index of the outermost axis that moves it; none on the bed.
    pub carrier: Option<usize>,
    /// Nominal position at home in the reference frame, mm.
    pub home_mm: Point3<f64>,
}

/// What fixes the reference frame of a measurement.
#[derive(Debug, Clone, PartialEq)]
pub struct FrameRule {
    lines: Vec<Line>,
    anchors: Vec<Anchor>,
    /// The axes that move the anchors; empty without lines.
    anchored: Vec<usize>,
    centroid_mm: Point3<f64>,
    inertia: Matrix3<f64>,
    inverse_inertia: Matrix3<f64>,
}

/// The average line of a linear axis.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Line {
    axis: usize,
    direction: Vector3<f64>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Anchor {
    target: usize,
    home_mm: Point3<f64>,
}

/// A small rigid motion: a point p moves by `translation + rotation × (p - pivot)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SmallMotion {
    /// Rotation vector, rad.
    pub rotation: Vector3<f64>,
    /// Displacement of the pivot, mm.
    pub translation: Vector3<f64>,
    /// Point about which it turns, mm.
    pub pivot: Point3<f64>,
}

impl FrameRule {
    /// The rule for `targets`, of which `measured` says which runs see them: pairs of the index of a
    /// run's axis and the index of a target.
    ///
    /// # Panics
    /// If an index of an axis or a target is out of range.
    pub fn new(
        machine: &Machine,
        targets: &[NominalTarget],
        measured: impl IntoIterator<Item = (usize, usize)>,
    ) -> Self {
        let mut measured: Vec<(usize, usize)> = measured.into_iter().collect();
        measured.sort_unstable();
        measured.dedup();
        let is_linear = |axis: usize| machine.axes()[axis].kind() == AxisKind::Linear;
        let lines = lines(machine, measured.iter().map(|&(axis, _)| axis));
        let first = lines.first().map(|line| line.axis);
        // Sorted pairs: the first of an axis has the first of its targets.
        let carrier = measured
            .iter()
            .find(|&&(axis, _)| Some(axis) == first)
            .map(|&(_, target)| targets[target].carrier);
        let mut anchors: Vec<usize> = measured
            .iter()
            .filter(|&&(axis, _)| first.is_none() || is_linear(axis))
            .map(|&(_, target)| target)
            .filter(|&target| carrier.is_none_or(|carrier| targets[target].carrier == carrier))
            .collect();
        anchors.sort_unstable();
        anchors.dedup();
        let anchors = anchors.into_iter().map(|target| Anchor {
            target,
            home_mm: targets[target].home_mm,
        });
        let anchors: Vec<Anchor> = anchors.collect();
        let homes = anchors.iter().map(|anchor| anchor.home_mm.coords);
        let centroid_mm = Point3::from(homes.sum::<Vector3<f64>>() / count(anchors.len()));
        let inertia = anchors.iter().map(|anchor| {
            let r = anchor.home_mm - centroid_mm;
            Matrix3::identity() * r.norm_squared() - r * r.transpose()
        });
        let inertia = inertia.sum();
        Self {
            lines,
            anchors,
            anchored: carrier.map_or_else(Vec::new, |carrier| machine.chain(carrier).to_vec()),
            centroid_mm,
            inertia,
            inverse_inertia: inverse(inertia),
        }
    }

    /// The axes whose average lines fix directions: none, one or two.
    pub fn lines(&self) -> impl Iterator<Item = usize> {
        self.lines.iter().map(|line| line.axis)
    }

    /// Indices of the targets that fix the rest, increasing.
    pub fn anchors(&self) -> impl Iterator<Item = usize> {
        self.anchors.iter().map(|anchor| anchor.target)
    }

    /// Whether a rotary axis has a position along itself. It is the mean position of its targets; if
    /// these are the anchors of the frame, that is nominal by definition.
    pub fn places_along_itself(&self, axis: usize) -> bool {
        !self.lines.is_empty() && !self.anchored.contains(&axis)
    }

    /// Whether that location error is zero by definition of the frame.
    ///
    /// Of the second line only the tilt about the normal of the plane is left: more than one component if
    /// the plane is oblique.
    ///
    /// # Panics
    /// If `axis` is not an index of the machine.
    pub fn defines(&self, machine: &Machine, axis: usize, component: LocationComponent) -> bool {
        let geometry = &machine.axes()[axis];
        match (geometry.kind(), component) {
            (AxisKind::Rotary, LocationComponent::Offset(i)) => {
                i == geometry.principal() && !self.places_along_itself(axis)
            }
            (AxisKind::Linear, LocationComponent::Tilt(i)) => match self.lines.as_slice() {
                [first, ..] if first.axis == axis => true,
                [first, second] if second.axis == axis => {
                    let normal = first.direction.cross(&second.direction).normalize();
                    normal[i].abs() <= NORMAL_TOL
                }
                _ => false,
            },
            _ => false,
        }
    }

    /// The motion that the frame takes out, linear in what it is made from: the tilts of the
    /// [lines](FrameRule::lines) (rotation vectors in the reference frame, rad) and the shifts of the
    /// [anchors](FrameRule::anchors) from their nominal home positions, mm.
    pub fn motion(&self, tilts: &[Vector3<f64>], shifts: &[Vector3<f64>]) -> SmallMotion {
        let translation = shifts.iter().sum::<Vector3<f64>>() / count(shifts.len());
        let moments = self.anchors.iter().zip(shifts);
        let moment: Vector3<f64> = moments
            .map(|(anchor, shift)| (anchor.home_mm - self.centroid_mm).cross(shift))
            .sum();
        let across = |v: Vector3<f64>, d: Vector3<f64>| v - d * d.dot(&v);
        let rotation = match (self.lines.as_slice(), tilts) {
            ([line, second], [tilt, t2]) => {
                let (d1, d2) = (line.direction, second.direction);
                let first = across(*tilt, d1);
                let in_plane = d2.cross(&d1.cross(&d2));
                first + d1 * ((t2 - first).dot(&in_plane) / d1.dot(&in_plane))
            }
            ([line], [tilt]) => {
                let d = line.direction;
                let first = across(*tilt, d);
                let about_line = d.dot(&(self.inertia * d));
                let left = d.dot(&(moment - self.inertia * first));
                if about_line > INERTIA_TOL * self.inertia.amax() {
                    first + d * (left / about_line)
                } else {
                    first
                }
            }
            _ => self.inverse_inertia * moment,
        };
        SmallMotion {
            rotation,
            translation,
            pivot: self.centroid_mm,
        }
    }
}

impl SmallMotion {
    /// How it displaces a point, mm.
    pub fn at(&self, point_mm: Point3<f64>) -> Vector3<f64> {
        self.translation + self.rotation.cross(&(point_mm - self.pivot))
    }

    /// The exact motion that takes it out.
    pub fn removal(&self) -> Isometry3<f64> {
        Translation3::from(self.pivot.coords)
            * UnitQuaternion::from_scaled_axis(-self.rotation)
            * Translation3::from(-self.pivot.coords - self.translation)
    }
}

/// The first linear axis that runs, and the first one after it that spans a plane with it.
fn lines(machine: &Machine, runs: impl Iterator<Item = usize>) -> Vec<Line> {
    let axes = machine.axes();
    let mut linear: Vec<usize> = runs
        .filter(|&axis| axes[axis].kind() == AxisKind::Linear)
        .collect();
    linear.sort_by_key(|&axis| (axes[axis].principal(), axis));
    let mut linear = linear.into_iter().map(|axis| Line {
        axis,
        direction: axes[axis].direction().into_inner(),
    });
    let Some(first) = linear.next() else {
        return Vec::new();
    };
    let spans = |line: &Line| first.direction.cross(&line.direction).norm() > PARALLEL_TOL;
    [Some(first), linear.find(spans)]
        .into_iter()
        .flatten()
        .collect()
}

/// The inverse without the axes of inertia that have none.
fn inverse(inertia: Matrix3<f64>) -> Matrix3<f64> {
    let principal = inertia.symmetric_eigen();
    let greatest = principal.eigenvalues.amax();
    let axes = principal.eigenvectors.column_iter();
    axes.zip(&principal.eigenvalues)
        .filter(|&(_, &inertia)| inertia > INERTIA_TOL * greatest)
        .map(|(axis, inertia)| axis * axis.transpose() / *inertia)
        .sum()
}

/// At least one, as a divisor.
fn count(number: usize) -> f64 {
    number.max(1) as f64
}

#[cfg(test)]
mod tests;
