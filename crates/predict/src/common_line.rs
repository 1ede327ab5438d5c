//! The average line or axis through positions `q_i` that two calibrations know, to which both are referred: the same curve
//! has another one through other steps.
//!
//! Straightness is given from the least-squares line through the steps, location errors are those of these lines, and the
//! frame follows from two of them. The gauge of a calibration leaves a curve `f` open up to `Λ(q) x` and fixes it by `Σ C f = 0`
//! over the steps, in directions `b` across the axis:
//!
//! ```text
//! linear   f = δ           Λ x = (t × d) q + g        C f = δ·b, (q - m) δ·b
//! rotary   f = δ or ε      Λ x = (1 - R) a + R g      C f = f·b, f·R b           R = R(d, q)
//! ```
//!
//! (`t` tilt of a line, `a` shift or tilt of an axis, `g` of the targets.) All of it is linear, so that a calibration is
//! referred to other positions by
//!
//! ```text
//! x = (Σ_i C_i Λ_i)⁻¹ Σ_i C_i f(q_i)     f'(q) = f(q) - Λ(q) x     tilt' = tilt + t - (1 - d dᵀ) ρ
//! ```
//!
//! with the rotation `ρ` of the frame with the tilts of the lines that define it ([`FrameRule::motion`]). The covariance goes
//! through the same functions.

use nalgebra::{
    DMatrix, Matrix3, Matrix3x4, Matrix4, Matrix4x3, Point3, Rotation3, Vector3, Vector6,
};
use trueaxis_kinematics::{Axis, AxisKind, Component, FrameRule, Machine, NominalTarget};
use trueaxis_leastsquares::dense::relative_singular_value;

use crate::calibrated_machine::CalibratedAxis;
use crate::compare::stands_alike;

/// Relative singular value below which positions determine no line or axis.
const RANK_TOL: f64 = 1e-6;

/// Below this share of the steps of the coarser calibration those in common say too little: the first is interpolated.
const ENOUGH: f64 = 0.5;

/// A linear function of the component errors of an axis: positions with the coefficients of the six there.
pub(crate) type Function = Vec<(f64, Vector6<f64>)>;

/// The steps of an axis in two calibrations.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Steps {
    /// They are the same.
    Same,
    /// They differ, and both calibrations know the positions of a line or axis.
    Line(CommonLine),
    /// They differ, and those that both know are too few.
    Other,
}

/// The average line or axis of positions that two calibrations know.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct CommonLine {
    pub(crate) positions: Vec<f64>,
    axis: Axis,
    mean: f64,
    /// `(Σ C Λ)⁻¹ C_i`.
    shares: Vec<Matrix4x3<f64>>,
}

impl Steps {
    pub(crate) fn new(axis: &Axis, a: &CalibratedAxis, b: &CalibratedAxis) -> Self {
        let [of_a, of_b] = [a, b].map(|axis| axis.curve.steps());
        let alike = |p: &f64, q: &f64| stands_alike(axis.kind(), *p, *q);
        if of_a.len() == of_b.len() && of_a.iter().zip(&of_b).all(|(p, q)| alike(p, q)) {
            return Self::Same;
        }
        let within = |steps: &[f64], other: &CalibratedAxis| -> Vec<f64> {
            let reached = |q: &f64| other.curve.at(*q).beyond <= 0.0;
            steps.iter().copied().filter(reached).collect()
        };
        let [own, others] = [within(&of_b, a), within(&of_a, b)];
        let is_shared = |q: &f64| of_a.iter().any(|p| alike(p, q));
        let shared: Vec<f64> = own.iter().copied().filter(is_shared).collect();
        let fewest = own.len().min(others.len()) as f64;
        let positions = match shared.len() as f64 >= ENOUGH * fewest {
            true => shared,
            false => own,
        };
        CommonLine::through(axis, positions).map_or(Self::Other, Self::Line)
    }

    /// What is compared of a component error at a position.
    pub(crate) fn function(&self, component: Component, position: f64) -> Function {
        let own = (position, Vector6::ith(component.index(), 1.0));
        match self {
            Self::Line(line) if is_from_line(line.axis.kind(), component) => {
                line.less_line(component, own)
            }
            _ => vec![own],
        }
    }
}

impl CommonLine {
    fn through(axis: &Axis, positions: Vec<f64>) -> Option<Self> {
        let mean = positions.iter().sum::<f64>() / positions.len().max(1) as f64;
        let mut line = Self {
            positions,
            axis: axis.clone(),
            mean,
            shares: Vec::new(),
        };
        let conditions = line.positions.iter().map(|&q| line.conditions(q));
        let conditions: Vec<Matrix4x3<f64>> = conditions.collect();
        let effects = line.positions.iter().map(|&q| line.effects(q));
        let products = conditions
            .iter()
            .zip(effects)
            .map(|(c, effects)| c * effects);
        let sum: Matrix4<f64> = products.sum();
        // Rows and columns of unit size: mm and mm² alike.
        let rows = sum.row_iter().map(|row| row.norm());
        let rows = Matrix4::from_diagonal(&nalgebra::Vector4::from_iterator(rows)).try_inverse()?;
        let even = rows * sum;
        let columns = even.column_iter().map(|column| column.norm());
        let columns =
            Matrix4::from_diagonal(&nalgebra::Vector4::from_iterator(columns)).try_inverse()?;
        let even = even * columns;
        if relative_singular_value(&DMatrix::from_column_slice(4, 4, even.as_slice())) < RANK_TOL {
            return None;
        }
        let inverse = columns * even.try_inverse()? * rows;
        line.shares = conditions.into_iter().map(|c| inverse * c).collect();
        Some(line)
    }

    /// Two directions across the axis.
    fn across(&self) -> [Vector3<f64>; 2] {
        let along = self.axis.direction().into_inner();
        let first = Vector3::ith((self.axis.principal() + 1) % 3, 1.0);
        let first = (first - along * first.dot(&along)).normalize();
        [first, along.cross(&first)]
    }

    fn turn(&self, position: f64) -> Rotation3<f64> {
        Rotation3::from_axis_angle(&self.axis.direction(), position)
    }

    /// `Λ(q)` in the coordinates of `t` or `a`, then of `g`.
    fn effects(&self, position: f64) -> Matrix3x4<f64> {
        let [a, b] = self.across();
        let turn = self.turn(position);
        let along = self.axis.direction().into_inner();
        let columns = match self.axis.kind() {
            AxisKind::Linear => [a.cross(&along) * position, b.cross(&along) * position, a, b],
            AxisKind::Rotary => [a - turn * a, b - turn * b, turn * a, turn * b],
        };
        Matrix3x4::from_columns(&columns)
    }

    /// `C` at a position.
    fn conditions(&self, position: f64) -> Matrix4x3<f64> {
        let [a, b] = self.across();
        let turn = self.turn(position);
        let lever = position - self.mean;
        let [c, d] = match self.axis.kind() {
            AxisKind::Linear => [a * lever, b * lever],
            AxisKind::Rotary => [turn * a, turn * b],
        };
        Matrix3x4::from_columns(&[a, b, c, d]).transpose()
    }

    /// `f'(q)`, from `f(q)`.
    fn less_line(&self, component: Component, own: (f64, Vector6<f64>)) -> Function {
        let effect = self.effects(own.0);
        let effect = effect.row(component.index() % 3);
        let shares = self.positions.iter().zip(&self.shares);
        let on_line = |(&q, share): (&f64, &Matrix4x3<f64>)| {
            let coefficients = -(effect * share).transpose();
            (q, six(component.is_angular(), &coefficients))
        };
        let mut function: Function = shares.map(on_line).collect();
        // What the interpolation may be off by is one at one position.
        let at = own.0.to_bits();
        match function.iter_mut().find(|(q, _)| q.to_bits() == at) {
            Some((_, coefficients)) => *coefficients += own.1,
            None => function.push(own),
        }
        function
    }

    /// What the tilt `t` or `a` adds to a result, by its coefficients.
    pub(crate) fn of_tilt(&self, coefficients: &Vector3<f64>) -> Function {
        let [a, b] = self.across();
        let [of_a, of_b] = [a, b].map(|direction| coefficients.dot(&direction));
        let is_angular = self.axis.kind() == AxisKind::Rotary;
        let shares = self.positions.iter().zip(&self.shares);
        let of_position = |(&q, share): (&f64, &Matrix4x3<f64>)| {
            let coefficients = (share.row(0) * of_a + share.row(1) * of_b).transpose();
            (q, six(is_angular, &coefficients))
        };
        shares.map(of_position).collect()
    }
}

/// Whether the average line or axis enters a component error of an axis.
pub(crate) fn is_from_line(kind: AxisKind, component: Component) -> bool {
    kind == AxisKind::Rotary || !component.is_angular()
}

/// Coefficients of translations, or of angles, among those of all six.
fn six(is_angular: bool, coefficients: &Vector3<f64>) -> Vector6<f64> {
    let mut all = Vector6::zeros();
    let first = if is_angular { 3 } else { 0 };
    all.fixed_rows_mut::<3>(first).copy_from(coefficients);
    all
}

/// How the tilts of axes change with those of lines and axes, in the frame of a calibration.
pub(crate) struct Tilts<'a> {
    machine: &'a Machine,
    rule: FrameRule,
}

impl<'a> Tilts<'a> {
    /// Of the axes that were measured.
    pub(crate) fn new(machine: &'a Machine, axes: &[CalibratedAxis]) -> Self {
        // Two lines alone fix all rotations, whatever the targets.
        let anywhere = NominalTarget {
            carrier: None,
            home_mm: Point3::origin(),
        };
        let rule = FrameRule::new(machine, &[anywhere], axes.iter().map(|axis| (axis.axis, 0)));
        Self { machine, rule }
    }

    /// The lines that fix the frame; none where targets have a part in its rotation.
    pub(crate) fn lines(&self) -> Option<[usize; 2]> {
        let lines: Vec<usize> = self.rule.lines().collect();
        lines.try_into().ok()
    }

    /// Change of the tilt of axis `of` in the frame with that of axis `line`.
    pub(crate) fn response(&self, of: usize, line: usize) -> Matrix3<f64> {
        let direction = |axis: usize| self.machine.axes()[axis].direction().into_inner();
        let lines: Vec<usize> = self.rule.lines().collect();
        let turn = |j: usize| {
            let tilts = lines.iter().map(|&axis| match axis == line {
                true => Vector3::ith(j, 1.0),
                false => Vector3::zeros(),
            });
            let tilts: Vec<Vector3<f64>> = tilts.collect();
            self.rule.motion(&tilts, &[Vector3::zeros()]).rotation
        };
        let frame = Matrix3::from_columns(&[turn(0), turn(1), turn(2)]);
        let along = direction(of);
        let across = Matrix3::identity() - along * along.transpose();
        let own = if of == line { across } else { Matrix3::zeros() };
        own - across * frame
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What a gauge leaves open of a curve is all in the line, with its tilt (of a rotary axis: the tilt of the axis): nothing of
    /// it is left between its positions or beyond them.
    #[test]
    fn a_line_takes_all_that_the_gauge_leaves_open() {
        let oblique = Vector3::new(0.6, 0.0, 0.8);
        let linear = Axis::linear("W", oblique, [0.0, 400.0]).unwrap();
        let centre = Point3::new(50.0, 60.0, 70.0);
        let rotary = Axis::rotary("D", oblique, [0.0, 6.0], centre).unwrap();
        let across = |v: Vector3<f64>| v - oblique * oblique.dot(&v);
        let tilt = across(Vector3::new(3e-5, -2e-5, 1e-5));
        let shift = across(Vector3::new(-4e-3, 1e-3, 2e-3));
        for (axis, places, far, component) in [
            (linear, vec![0.0, 90.0, 110.0, 400.0], 230.0, Component::Y),
            (rotary, vec![-0.3, 0.1, 0.9, 1.4], 2.6, Component::B),
        ] {
            let first = if component.is_angular() { 3 } else { 0 };
            let curve = |q: f64| match axis.kind() {
                AxisKind::Linear => tilt.cross(&oblique) * q + shift,
                AxisKind::Rotary => {
                    let turn = Rotation3::new(oblique * q);
                    tilt - turn * tilt + turn * shift
                }
            };
            let value = |function: &Function| -> f64 {
                let of_position = |(q, c): &(f64, Vector6<f64>)| {
                    let [x, y, z] = [0, 1, 2].map(|i| c[first + i]);
                    curve(*q).dot(&Vector3::new(x, y, z))
                };
                function.iter().map(of_position).sum()
            };
            let line = CommonLine::through(&axis, places.clone()).unwrap();
            for q in [places[1], far] {
                let own = (q, Vector6::ith(component.index(), 1.0));
                let left = value(&line.less_line(component, own));
                assert!(left.abs() < 1e-14, "{left}");
            }
            for i in 0..3 {
                let found = value(&line.of_tilt(&Vector3::ith(i, 1.0)));
                assert!((found - tilt[i]).abs() < 1e-14, "{found} {tilt}");
            }
            assert_eq!(CommonLine::through(&axis, places[..1].to_vec()), None);
        }
    }
}
