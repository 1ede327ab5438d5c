//! The volumetric error: its first order (paper Eqs. 2 and 4), and what it does not depend on.

use nalgebra::{Isometry3, Point3, Rotation3, Vector3};
use proptest::prelude::*;
use trueaxis_kinematics::{Axis, AxisKind, GeometricErrors, LocationError, Machine, MotionError};

/// Errors of each axis as smooth functions of its position, linear in a factor.
#[derive(Debug, Clone)]
struct Waves {
    factor: f64,
    /// Amplitudes of δ (mm) and ε (rad), tilt (rad) and shift (mm) of each axis.
    axes: Vec<[Vector3<f64>; 4]>,
}

impl GeometricErrors for Waves {
    fn location(&self, axis: usize) -> LocationError {
        let [.., tilt, shift] = self.axes[axis];
        LocationError {
            offset_mm: shift * self.factor,
            tilt_rad: tilt * self.factor,
        }
    }

    fn motion(&self, axis: usize, position: f64) -> MotionError {
        let [delta, epsilon, ..] = self.axes[axis];
        let wave = self.factor * (0.7 + position / 150.0 + axis as f64).sin();
        MotionError::new(delta * wave, epsilon * wave)
    }
}

fn vector(size: f64) -> impl Strategy<Value = Vector3<f64>> {
    prop::array::uniform3(-size..size).prop_map(Vector3::from)
}

fn waves() -> impl Strategy<Value = Waves> {
    let axis = (vector(0.02), vector(1e-4), vector(2e-4), vector(0.02));
    prop::collection::vec(axis, 5).prop_map(|axes| Waves {
        factor: 1.0,
        axes: axes.into_iter().map(|(a, b, c, d)| [a, b, c, d]).collect(),
    })
}

/// X, Y, Z on the tool's side, A and C on the workpiece's.
fn machine() -> Machine {
    let linear = |name, d| Axis::linear(name, d, [0.0, 500.0]).unwrap();
    let rotary = |name, d, at| Axis::rotary(name, d, [-3.2, 3.2], at).unwrap();
    let axes = vec![
        linear("X", Vector3::x()),
        linear("Y", Vector3::y()),
        linear("Z", Vector3::z()),
        rotary("A", Vector3::x(), Point3::new(10.0, 200.0, 50.0)),
        rotary("C", Vector3::z(), Point3::new(250.0, 200.0, -30.0)),
    ];
    Machine::new(axes, vec![0, 1, 2], vec![3, 4]).unwrap()
}

fn positions() -> impl Strategy<Value = Vec<f64>> {
    let linear = prop::collection::vec(0.0..500.0, 3);
    let rotary = prop::collection::vec(-3.0..3.0, 2);
    (linear, rotary).prop_map(|(linear, rotary)| [linear, rotary].concat())
}

/// The sum of what each error does by itself: `Δ = δ + ε × r` for component errors, `q t × d` for the tilt of a linear
/// axis, `(I - R)(s + t × r)` for the location of a rotary one. Written down here, from the bed to the stage.
fn first_order(machine: &Machine, errors: &Waves, q: &[f64], tool: Point3<f64>) -> Vector3<f64> {
    let of_chain = |chain: &[usize], point: Point3<f64>| {
        let mut sum = Vector3::zeros();
        let mut turned = Rotation3::identity();
        let mut moved = Isometry3::identity();
        for &i in chain {
            let axis = &machine.axes()[i];
            let (location, error) = (errors.location(i), errors.motion(i, q[i]));
            let d = axis.direction().into_inner();
            // The reference point before the motion of the axis, and the point from where the reference point is.
            let before = moved * axis.reference_mm();
            let shift = if axis.kind() == AxisKind::Linear {
                d * q[i]
            } else {
                Vector3::zeros()
            };
            let r = turned.inverse() * (point - before) - shift;
            let own = match axis.kind() {
                AxisKind::Linear => location.tilt_rad.cross(&d) * q[i],
                AxisKind::Rotary => {
                    let by = Rotation3::from_axis_angle(&axis.direction(), q[i]);
                    let s = location.offset_mm;
                    let across = s - d * d.dot(&s);
                    let t = location.tilt_rad;
                    across - by * across + d * d.dot(&s) + (t - by * t).cross(&r)
                }
            };
            sum += turned * (own + error.displacement_mm(r));
            moved *= machine.chain_motion(&trueaxis_kinematics::Ideal, &[i], q);
            turned = moved.rotation.to_rotation_matrix();
        }
        (sum, turned)
    };
    let point = Point3::from(tool.coords + Vector3::new(q[0], q[1], q[2]));
    let (of_tool, _) = of_chain(&[0, 1, 2], point);
    let (of_workpiece, turned) = of_chain(&[3, 4], point);
    turned.inverse() * (of_tool - of_workpiece)
}

/// The same motions of the axes, described with other reference points, location errors and homes.
struct Described<'a> {
    errors: &'a Waves,
    /// As in the errors.
    machine: &'a Machine,
    /// With other reference points.
    described: &'a Machine,
    locations: &'a Waves,
    /// Positions of all axes at the other home.
    home: &'a [f64],
}

impl Described<'_> {
    /// The motion of an axis, as it acts on coordinates at the other home: `P_{k-1} T(q₀ + q) P_k⁻¹`.
    fn axis_motion(&self, axis: usize, position: f64) -> Isometry3<f64> {
        let chain = self.machine.chain(axis);
        let at_home = |chain| self.machine.chain_motion(self.errors, chain, self.home);
        let mut positions = self.home.to_vec();
        positions[axis] += position;
        let own = self.machine.chain_motion(self.errors, &[axis], &positions);
        // The rotary axes keep their home, so that the workpiece is not turned.
        if self.machine.axes()[axis].kind() == AxisKind::Rotary {
            return own;
        }
        at_home(&chain[..chain.len() - 1]) * own * at_home(chain).inverse()
    }
}

impl GeometricErrors for Described<'_> {
    fn location(&self, axis: usize) -> LocationError {
        self.locations.location(axis)
    }

    fn motion(&self, axis: usize, position: f64) -> MotionError {
        let motion = self.axis_motion(axis, position);
        let axis_geometry = &self.described.axes()[axis];
        let location = self.location(axis);
        let commanded = axis_geometry.commanded_motion(position, &location);
        // δ displaces the reference point from where the commanded motion brings it.
        let point = axis_geometry.reference_at_home_mm(&location);
        let rotation = motion.rotation * commanded.rotation.inverse();
        MotionError::new(motion * point - commanded * point, rotation.scaled_axis())
    }
}

proptest! {
    /// Ten times the errors, a hundred times the difference between first order and exact: slope 2.
    #[test]
    fn first_order_differs_in_the_second(errors in waves(), q in positions(), tool in vector(400.0)) {
        let (machine, tool) = (machine(), Point3::from(tool));
        let difference = |factor: f64| {
            let errors = Waves { factor, ..errors.clone() };
            let exact = machine.tool_error(&errors, &q, tool).translation_mm;
            (exact - first_order(&machine, &errors, &q, tool)).norm()
        };
        let [small, large] = [difference(1.0), difference(10.0)];
        // Of 3e-4 rad and 1.5 m at five axes: µm at factor 1. Third order is 1e-3 of that at factor 10.
        prop_assert!(small < 2e-3, "{small}");
        prop_assert!((large - 100.0 * small).abs() < 0.02 * large + 1e-6, "{small} {large}");
    }

    /// What two poses differ by does not depend on the reference points of the components, on what location errors
    /// take, or on the home.
    #[test]
    fn differences_do_not_depend_on_the_description(
        errors in waves(), locations in waves(), a in positions(), b in positions(),
        tool in vector(400.0), reference in vector(300.0), home in prop::array::uniform3(0.0..400.0)
    ) {
        let (machine, tool) = (machine(), Point3::from(tool));
        let described = machine.with_axes(|_, axis| axis.with_reference(Point3::from(reference)));
        let home = [home[0], home[1], home[2], 0.0, 0.0];
        let other = Described {
            errors: &errors, machine: &machine, described: &described, locations: &locations, home: &home,
        };
        // The rotary axes stand still: the tool's other home turns with the workpiece.
        let b = [&b[..3], &a[3..]].concat();
        let plain = |q: &[f64]| machine.tool_error(&errors, q, tool).translation_mm;
        // The tool point at the other home.
        let at_home = machine.position(&errors, 2, &home, tool);
        let from_home = |q: &[f64]| -> Vec<f64> { q.iter().zip(&home).map(|(q, h)| q - h).collect() };
        let again = |q: &[f64]| described.tool_error(&other, &from_home(q), at_home).translation_mm;
        let off = (plain(&a) - plain(&b)) - (again(&a) - again(&b));
        prop_assert!(off.norm() < 1e-9, "{off}");
    }
}
