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
mod tests {
    use super::*;
    use crate::Axis;

    const TARGETS: [[f64; 3]; 3] = [[0.0, 0.0, 0.0], [200.0, 30.0, 0.0], [40.0, 150.0, 90.0]];

    fn linear(name: &str, direction: Vector3<f64>) -> Axis {
        Axis::linear(name, direction, [0.0, 1.0]).unwrap()
    }

    fn rotary(name: &str, direction: Vector3<f64>) -> Axis {
        Axis::rotary(name, direction, [0.0, 1.0], Point3::origin()).unwrap()
    }

    /// All axes in one branch, measured with three targets on the last.
    fn rule(axes: Vec<Axis>) -> (Machine, FrameRule) {
        let last = axes.len() - 1;
        let machine = Machine::new(axes, (0..=last).collect(), Vec::new()).unwrap();
        let targets = TARGETS.map(|home| NominalTarget {
            carrier: Some(last),
            home_mm: Point3::from(home),
        });
        let measured = (0..=last).flat_map(|axis| (0..3).map(move |target| (axis, target)));
        let rule = FrameRule::new(&machine, &targets, measured);
        (machine, rule)
    }

    fn defined(axes: Vec<Axis>) -> String {
        let (machine, rule) = rule(axes);
        let mut names = Vec::new();
        for (i, axis) in machine.axes().iter().enumerate() {
            let all = axis.location_components().into_iter();
            let defined = all.filter(|&component| rule.defines(&machine, i, component));
            names.extend(defined.map(|component| component.name(axis.name())));
        }
        names.join(" ")
    }

    #[test]
    fn x_and_y_define_the_frame_of_a_machine_that_has_them() {
        let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
        let axes = vec![
            rotary("C", z),
            linear("Z", z),
            linear("Y", y),
            linear("X", -x),
        ];
        assert_eq!(defined(axes), "Z0C A0Y B0X C0X");
    }

    #[test]
    fn a_lathe_takes_its_plane_from_x_and_z() {
        let axes = vec![linear("Z", Vector3::z()), linear("X", Vector3::x())];
        assert_eq!(defined(axes), "A0Z B0X C0X");
    }

    #[test]
    fn almost_parallel_axes_span_no_plane() {
        let (x, y) = (Vector3::x(), Vector3::y());
        let at = |degrees: f64| {
            let (sin, cos) = degrees.to_radians().sin_cos();
            x * cos + y * sin
        };
        let axes = |degrees| vec![linear("X", x), linear("U", at(degrees)), linear("Y", y)];
        assert_eq!(defined(axes(0.0)), "B0X C0X A0Y");
        assert_eq!(defined(axes(3.0)), "B0X C0X A0Y");
        assert_eq!(defined(axes(6.0)), "B0X C0X B0U");
    }

    #[test]
    fn a_lone_rotary_axis_and_a_head_have_no_axial_location() {
        assert_eq!(defined(vec![rotary("C", Vector3::z())]), "Z0C");
        let head = vec![linear("X", Vector3::x()), rotary("B", Vector3::y())];
        assert_eq!(defined(head), "B0X C0X Y0B");
    }

    #[test]
    fn a_rotary_table_beside_the_linear_axes_has_one() {
        let axes = vec![linear("X", Vector3::x()), rotary("C", Vector3::z())];
        let machine = Machine::new(axes, vec![0], vec![1]).unwrap();
        let target = |carrier| NominalTarget {
            carrier: Some(carrier),
            home_mm: Point3::origin(),
        };
        let rule = FrameRule::new(&machine, &[target(1), target(0)], [(1, 0), (0, 1)]);
        assert!(rule.places_along_itself(1));
        assert!(rule.anchors().eq([1]));
    }

    #[test]
    fn anchors_are_the_targets_of_one_stage() {
        let axes = vec![linear("Y", Vector3::y()), linear("X", Vector3::x())];
        let machine = Machine::new(axes, vec![1, 0], Vec::new()).unwrap();
        let targets = [0, 1, 0, 1].map(|carrier| NominalTarget {
            carrier: Some(carrier),
            home_mm: Point3::origin(),
        });
        // X is the first axis, and target 1 the first that it measures.
        let measured = [(0, 0), (0, 2), (1, 1), (1, 2), (1, 3)];
        let rule = FrameRule::new(&machine, &targets, measured);
        assert!(rule.lines().eq([1, 0]));
        assert!(rule.anchors().eq([1, 3]));
    }

    /// What moves everything as one body is taken out whole, whatever the axes are.
    #[test]
    fn a_motion_of_the_whole_is_taken_out() {
        let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
        let turn = Vector3::new(1e-5, -3e-5, 2e-5);
        let shift = Vector3::new(0.1, -0.2, 0.3);
        for axes in [
            vec![linear("X", x), linear("Y", y)],
            vec![linear("X", x), linear("U", (x + y + z).normalize())],
            vec![linear("Z", z), rotary("C", z)],
            vec![rotary("C", z)],
        ] {
            let (_, rule) = rule(axes);
            let tilts: Vec<_> = rule.lines().map(|_| turn).collect();
            let homes = TARGETS.map(Point3::from);
            let shifts = homes.map(|p| shift + turn.cross(&p.coords));
            let motion = rule.motion(&tilts, &shifts);
            assert!((motion.rotation - turn).norm() < 1e-17);
            for (p, shift) in homes.into_iter().zip(shifts) {
                assert!((motion.at(p) - shift).norm() < 1e-15);
                assert!((motion.removal() * (p + shift) - p).norm() < 1e-6);
            }
        }
    }

    #[test]
    fn anchors_on_one_line_hold_no_rotation_about_it() {
        let machine = Machine::new(vec![rotary("C", Vector3::z())], vec![0], Vec::new()).unwrap();
        let targets = [0.0, 50.0, 120.0].map(|x| NominalTarget {
            carrier: Some(0),
            home_mm: Point3::new(x, 7.0, 0.0),
        });
        let rule = FrameRule::new(&machine, &targets, (0..3).map(|target| (0, target)));
        let turn = Vector3::new(5e-5, 2e-5, -1e-5);
        let shifts = targets.map(|t| turn.cross(&(t.home_mm - Point3::new(0.0, 7.0, 0.0))));
        let found = rule.motion(&[], &shifts).rotation;
        assert!((found - Vector3::new(0.0, turn.y, turn.z)).norm() < 1e-15);
    }
}
