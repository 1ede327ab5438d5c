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
