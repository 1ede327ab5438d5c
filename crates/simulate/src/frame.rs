//! Which errors the reference frame takes, so that a scenario cannot contain them.
//!
//! x of the frame lies along the average line of the first linear axis that runs (in the order
//! X, Y, Z of nearest directions); the second one fixes the plane; origin and, without two linear
//! runs, orientation come from the targets. True errors that would move this frame against the
//! simulated machine's own are refused: the truth is expressed in the machine's frame.

use trueaxis_kinematics::{Axis, AxisKind, LocationComponent, Machine};

/// The axes that give the reference frame its directions.
pub(crate) struct ReferenceFrame {
    first: Option<Line>,
    second: Option<Line>,
    /// For each rotary axis of the machine its nearest direction, 0 to 2 for x to z.
    turning: Vec<Option<usize>>,
}

/// The average line of a linear axis.
struct Line {
    axis: usize,
    name: String,
    /// The tilts of the axis that the frame leaves free: 0 to 2 for about x to about z.
    free_tilt: Option<usize>,
}

/// Sine of the angle below which two axes count as parallel: far above any squareness error, far
/// below any oblique design.
const PARALLEL_SINE: f64 = 1e-2;

impl ReferenceFrame {
    /// The frame of a campaign that runs the axes for which `runs` holds.
    pub(crate) fn new(machine: &Machine, runs: impl Fn(usize) -> bool) -> Self {
        let axes = machine.axes();
        let is_linear = |axis: &Axis| axis.kind() == AxisKind::Linear;
        let mut linear: Vec<(usize, &Axis)> = axes.iter().enumerate().collect();
        linear.retain(|&(i, axis)| is_linear(axis) && runs(i));
        linear.sort_by_key(|&(i, axis)| (axis.principal(), i));
        let line = |(index, axis): (usize, &Axis), free_tilt| Line {
            axis: index,
            name: axis.name().to_owned(),
            free_tilt,
        };
        let first = linear.first().copied();
        let second = first.and_then(|(_, first)| {
            linear.iter().find_map(|&(i, axis)| {
                let normal = first.direction().cross(&axis.direction());
                let spans = normal.norm() > PARALLEL_SINE;
                spans.then(|| line((i, axis), Some(normal.iamax())))
            })
        });
        let turning = axes
            .iter()
            .map(|axis| (!is_linear(axis)).then(|| axis.principal()));
        Self {
            first: first.map(|first| line(first, None)),
            second,
            turning: turning.collect(),
        }
    }

    /// Index of the first linear axis that runs.
    pub(crate) fn first(&self) -> Option<usize> {
        self.first.as_ref().map(|line| line.axis)
    }

    /// Whether the runs alone fix all directions of the frame.
    pub(crate) fn is_oriented_by_runs(&self) -> bool {
        self.second.is_some()
    }

    /// Why that location error of that axis is zero by definition, if it is.
    pub(crate) fn takes(&self, axis: usize, component: LocationComponent) -> Option<String> {
        let Some(first) = &self.first else {
            let principal = self.turning.get(axis).copied().flatten()?;
            return (component == LocationComponent::Offset(principal)).then(|| {
                "without a linear run the reference frame has its origin at the targets' home \
                 positions, so a shift along an axis of rotation shifts the frame"
                    .to_owned()
            });
        };
        let lines = [Some(first), self.second.as_ref()];
        let line = lines.into_iter().flatten().find(|line| line.axis == axis)?;
        let is_free = |i| component == LocationComponent::Tilt(i);
        if line.free_tilt.is_some_and(is_free) {
            return None;
        }
        Some(if axis == first.axis {
            format!(
                "the reference frame takes its first direction from the average line of {}",
                first.name
            )
        } else {
            format!(
                "the average lines of {} and {} lie in a plane of the reference frame, so {} can \
                 only tilt about the normal of that plane",
                first.name, line.name, line.name
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Point3, Vector3};

    fn names_taken(axes: Vec<Axis>) -> String {
        let branch = (0..axes.len()).collect();
        let machine = Machine::new(axes, branch, Vec::new()).unwrap();
        let frame = ReferenceFrame::new(&machine, |_| true);
        let mut names = Vec::new();
        for (i, axis) in machine.axes().iter().enumerate() {
            let taken = axis.location_components().into_iter();
            let taken = taken.filter(|&component| frame.takes(i, component).is_some());
            names.extend(taken.map(|component| component.name(axis.name())));
        }
        names.join(" ")
    }

    fn linear(name: &str, direction: Vector3<f64>) -> Axis {
        Axis::linear(name, direction, [0.0, 1.0]).unwrap()
    }

    fn rotary(name: &str, direction: Vector3<f64>) -> Axis {
        Axis::rotary(name, direction, [0.0, 1.0], Point3::origin()).unwrap()
    }

    #[test]
    fn x_and_y_define_the_frame_of_a_machine_that_has_them() {
        let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
        let axes = vec![
            linear("Z", z),
            linear("Y", y),
            linear("X", -x),
            rotary("C", z),
        ];
        assert_eq!(names_taken(axes), "A0Y B0X C0X");
    }

    #[test]
    fn a_lathe_takes_its_plane_from_x_and_z() {
        let axes = vec![linear("Z", Vector3::z()), linear("X", Vector3::x())];
        assert_eq!(names_taken(axes), "A0Z B0X C0X");
    }

    #[test]
    fn a_parallel_axis_does_not_span_a_plane() {
        let (x, y) = (Vector3::x(), Vector3::y());
        let axes = vec![linear("X", x), linear("U", x), linear("Y", y)];
        assert_eq!(names_taken(axes), "B0X C0X A0Y");
    }

    #[test]
    fn a_lone_rotary_axis_has_no_axial_location() {
        let axes = vec![rotary("C", Vector3::z())];
        assert_eq!(names_taken(axes), "Z0C");
    }
}
