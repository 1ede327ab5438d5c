//! A machine: two branches of axes that start at the bed.

use nalgebra::{Isometry3, Point3};

use crate::{Axis, Error, GeometricErrors, Ideal, MotionError};

/// One of the two kinematic branches.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Branch {
    /// Bed to tool.
    Tool,
    /// Bed to workpiece.
    Workpiece,
}

/// Any number of axes in two branches, in any order.
///
/// Positions of all axes are given as one slice in the order of [`Machine::axes`]: mm for linear
/// and rad for rotary axes.
#[derive(Debug, Clone, PartialEq)]
pub struct Machine {
    axes: Vec<Axis>,
    tool: Vec<usize>,
    workpiece: Vec<usize>,
    /// For each axis, the axes from the bed up to and including it.
    chains: Vec<Vec<usize>>,
}

impl Machine {
    /// A machine of `axes`; `tool` and `workpiece` list indices into it from the bed outwards.
    ///
    /// # Errors
    /// If two axes share a name, a branch names an axis that is not there, or an axis does not
    /// stand in exactly one branch.
    pub fn new(axes: Vec<Axis>, tool: Vec<usize>, workpiece: Vec<usize>) -> Result<Self, Error> {
        for (i, axis) in axes.iter().enumerate() {
            if axes[..i].iter().any(|other| other.name() == axis.name()) {
                return Err(Error::DuplicateAxis {
                    name: axis.name().to_owned(),
                });
            }
        }
        let mut uses = vec![0_usize; axes.len()];
        for &index in tool.iter().chain(&workpiece) {
            let count = axes.len();
            *uses
                .get_mut(index)
                .ok_or(Error::UnknownAxis { index, count })? += 1;
        }
        for (axis, uses) in axes.iter().zip(uses) {
            let name = axis.name().to_owned();
            match uses {
                0 => return Err(Error::AxisUnused { name }),
                1 => {}
                _ => return Err(Error::AxisUsedTwice { name }),
            }
        }
        let mut chains = vec![Vec::new(); axes.len()];
        for branch in [&tool, &workpiece] {
            for (depth, &axis) in branch.iter().enumerate() {
                chains[axis] = branch[..=depth].to_vec();
            }
        }
        Ok(Self {
            axes,
            tool,
            workpiece,
            chains,
        })
    }

    /// The same machine with other geometry of its axes; `change` gets the index and the axis and
    /// must keep the name.
    #[must_use]
    pub fn with_axes(&self, change: impl Fn(usize, Axis) -> Axis) -> Self {
        let axes = self
            .axes
            .iter()
            .cloned()
            .enumerate()
            .map(|(i, axis)| change(i, axis));
        Self {
            axes: axes.collect(),
            ..self.clone()
        }
    }

    /// All axes; every index in this crate refers to this slice.
    pub fn axes(&self) -> &[Axis] {
        &self.axes
    }

    /// Index of the axis of that name.
    pub fn axis_index(&self, name: &str) -> Option<usize> {
        self.axes.iter().position(|axis| axis.name() == name)
    }

    /// Indices of the axes of a branch, from the bed outwards.
    pub fn branch(&self, branch: Branch) -> &[usize] {
        match branch {
            Branch::Tool => &self.tool,
            Branch::Workpiece => &self.workpiece,
        }
    }

    /// The axes from the bed up to and including axis `carrier`, from the bed outwards; none for what
    /// stands on the bed, which no axis carries.
    ///
    /// # Panics
    /// If `carrier` is not an index of [`Machine::axes`].
    pub fn chain(&self, carrier: impl Into<Option<usize>>) -> &[usize] {
        carrier.into().map_or(&[], |axis| &self.chains[axis])
    }

    /// The rigid motion of the stage of axis `carrier`, or of the bed, as it acts on coordinates at home.
    pub fn motion(
        &self,
        errors: &impl GeometricErrors,
        carrier: impl Into<Option<usize>>,
        positions: &[f64],
    ) -> Isometry3<f64> {
        self.chain_motion(errors, self.chain(carrier), positions)
    }

    /// Where a point on the stage of axis `carrier`, or on the bed, is, in the reference frame, mm.
    ///
    /// `home_mm` is its position in the reference frame when all axes are at home.
    pub fn position(
        &self,
        errors: &impl GeometricErrors,
        carrier: impl Into<Option<usize>>,
        positions: &[f64],
        home_mm: Point3<f64>,
    ) -> Point3<f64> {
        self.motion(errors, carrier, positions) * home_mm
    }

    /// The error of the tool against the workpiece: displacement of the tool point (the volumetric error, mm) and
    /// rotation of the tool (rad), actual against ideal.
    ///
    /// Both are along the axes of the workpiece, which are those of the reference frame at home and turn with the
    /// workpiece. With `T` and `W` the motions of tool and workpiece and `h` the tool point,
    ///
    /// ```text
    /// G = W⁻¹ T     δ = G h - G₀ h     exp(ε) = R(G) R(G₀)⁻¹     ₀: ideal
    /// ```
    ///
    /// `tool_home_mm` is the tool point in the reference frame at home.
    pub fn tool_error(
        &self,
        errors: &impl GeometricErrors,
        positions: &[f64],
        tool_home_mm: Point3<f64>,
    ) -> MotionError {
        self.tool_error_at(errors, positions, positions, tool_home_mm)
    }

    /// The same of a machine that is sent to `positions` and meant to be at `commanded`.
    pub fn tool_error_at(
        &self,
        errors: &impl GeometricErrors,
        commanded: &[f64],
        positions: &[f64],
        tool_home_mm: Point3<f64>,
    ) -> MotionError {
        let actual = self.tool_in_workpiece(errors, positions);
        let ideal = self.tool_in_workpiece(&Ideal, commanded);
        MotionError::new(
            actual * tool_home_mm - ideal * tool_home_mm,
            (actual.rotation * ideal.rotation.inverse()).scaled_axis(),
        )
    }

    /// Where the tool is against the workpiece: `W⁻¹ T`, as it acts on coordinates at home.
    pub fn tool_in_workpiece(
        &self,
        errors: &impl GeometricErrors,
        positions: &[f64],
    ) -> Isometry3<f64> {
        let workpiece = self.chain_motion(errors, &self.workpiece, positions);
        workpiece.inverse() * self.chain_motion(errors, &self.tool, positions)
    }

    /// The combined motion of some axes of one branch, given from the bed outwards.
    pub fn chain_motion(
        &self,
        errors: &impl GeometricErrors,
        chain: &[usize],
        positions: &[f64],
    ) -> Isometry3<f64> {
        chain.iter().fold(Isometry3::identity(), |motion, &axis| {
            let position = positions[axis];
            let location = errors.location(axis);
            let error = errors.motion(axis, position);
            motion * self.axes[axis].motion(position, &location, &error)
        })
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;
    use crate::LocationError;

    fn five_axis() -> Machine {
        let axes = vec![
            Axis::linear("X", Vector3::x(), [0.0, 500.0]).unwrap(),
            Axis::linear("Y", Vector3::y(), [0.0, 500.0]).unwrap(),
            Axis::linear("Z", Vector3::z(), [0.0, 500.0]).unwrap(),
            Axis::rotary(
                "A",
                Vector3::x(),
                [-2.0, 2.0],
                Point3::new(0.0, 200.0, 50.0),
            )
            .unwrap(),
            Axis::rotary(
                "C",
                Vector3::z(),
                [0.0, 6.3],
                Point3::new(250.0, 200.0, 0.0),
            )
            .unwrap(),
        ];
        Machine::new(axes, vec![0, 1, 2], vec![3, 4]).unwrap()
    }

    #[test]
    fn inner_axis_is_carried_by_the_outer_one() {
        let machine = five_axis();
        let angle = 0.3_f64;
        let home = Point3::new(250.0, 250.0, 50.0);
        let p = machine.position(&Ideal, 4, &[0.0, 0.0, 0.0, angle, 0.0], home);
        let expected = Point3::new(250.0, 200.0 + 50.0 * angle.cos(), 50.0 + 50.0 * angle.sin());
        assert!((p - expected).norm() < 1e-12);
        assert_eq!(machine.chain(4), [3, 4]);
    }

    #[test]
    fn the_error_of_the_tool_is_in_workpiece_coordinates() {
        struct LongX;
        impl GeometricErrors for LongX {
            fn location(&self, _: usize) -> LocationError {
                LocationError::default()
            }
            fn motion(&self, axis: usize, position: f64) -> MotionError {
                let size = if axis == 0 { 1e-5 } else { 0.0 };
                let (translation, rotation) = (Vector3::x() * size, Vector3::y() * (1e-3 * size));
                MotionError::new(translation * position, rotation * position)
            }
        }
        let machine = five_axis();
        let quarter = std::f64::consts::FRAC_PI_2;
        let error = machine.tool_error(&LongX, &[400.0, 0.0, 0.0, 0.0, quarter], Point3::origin());
        let displaced = error.translation_mm - Vector3::new(0.0, -4e-3, 0.0);
        assert!(displaced.norm() < 1e-12);
        // +Y is +x of a workpiece that has turned by 90° about +Z.
        assert!((error.rotation_rad - Vector3::new(4e-6, 0.0, 0.0)).norm() < 1e-15);
    }

    #[test]
    fn every_axis_stands_in_one_branch() {
        let x = || Axis::linear("X", Vector3::x(), [0.0, 1.0]).unwrap();
        let y = || Axis::linear("Y", Vector3::y(), [0.0, 1.0]).unwrap();
        let unused = Machine::new(vec![x(), y()], vec![0], vec![]);
        assert_eq!(unused, Err(Error::AxisUnused { name: "Y".into() }));
        let twice = Machine::new(vec![x(), y()], vec![0, 1], vec![1]);
        assert_eq!(twice, Err(Error::AxisUsedTwice { name: "Y".into() }));
        let unknown = Machine::new(vec![x()], vec![0, 3], vec![]);
        assert_eq!(unknown, Err(Error::UnknownAxis { index: 3, count: 1 }));
        assert!(matches!(
            Machine::new(vec![x(), x()], vec![0, 1], vec![]),
            Err(Error::DuplicateAxis { .. })
        ));
    }
}
