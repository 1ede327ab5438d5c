//! Waves along an error curve: `s sin φ + c cos φ`, parameters in pairs of s and c.

use nalgebra::{Vector3, Vector6};
use trueaxis_kinematics::{ARCSEC, Axis, Component, MICROMETRE, MotionError};

use crate::form::OnCurve;
use crate::{Parameter, Scene, Subject};

/// The components along the three reference directions.
pub(crate) const SHIFTS: [Component; 3] = [Component::X, Component::Y, Component::Z];

/// The components about the three reference directions.
pub(crate) const ANGLES: [Component; 3] = [Component::A, Component::B, Component::C];

/// `sin φ` for the first parameter of a pair, `cos φ` for the second.
fn wave(of: &OnCurve<'_>, phase_rad: f64) -> f64 {
    match of.parameter % 2 {
        0 => phase_rad.sin(),
        _ => phase_rad.cos(),
    }
}

/// A wave of one component, 1 µm or 1 arcsec high.
pub(crate) fn wave_of(component: Component, of: &OnCurve<'_>, phase_rad: f64) -> MotionError {
    let (_, unit) = unit(component);
    let value = unit * wave(of, phase_rad);
    MotionError::from_vector(&Vector6::ith(component.index(), value))
}

/// Waves per turn of the angle about a rotary axis itself, 1 arcsec high.
pub(crate) fn waves_about_axis(waves: f64, of: &OnCurve<'_>) -> MotionError {
    let angle_rad = ARCSEC * wave(of, waves * of.at.position);
    let direction = of.at.axis.direction().into_inner();
    MotionError::new(Vector3::zeros(), direction * angle_rad)
}

/// Waves per turn, as many as the shape says, of the two of `components` across a rotary axis.
pub(crate) fn waves_across_axis(components: [Component; 3], of: &OnCurve<'_>) -> MotionError {
    let component = components[across(of.at.axis)[of.parameter / 2]];
    wave_of(component, of, of.shape * of.at.position)
}

/// The parameters of [`waves_across_axis`], such as `sine_x cosine_x sine_y cosine_y`.
pub(crate) fn parameters_across(
    scene: &Scene,
    subject: &Subject,
    components: [Component; 3],
) -> Vec<Parameter> {
    let axis = subject.axis.and_then(|axis| scene.machine.axes().get(axis));
    let across = axis.map_or([0, 1], across).map(|i| components[i]);
    let of_component = across.map(|component| {
        let letter = component.letter().to_ascii_lowercase();
        let (unit, _) = unit(component);
        ["sine", "cosine"].map(|name| Parameter::new(format!("{name}_{letter}"), unit))
    });
    of_component.into_iter().flatten().collect()
}

/// The unit in which files give the waves of a component: its name, and its size in mm or rad.
pub(crate) fn unit(component: Component) -> (&'static str, f64) {
    match component.is_angular() {
        true => ("arcsec", ARCSEC),
        false => ("um", MICROMETRE),
    }
}

/// The two reference directions (0, 1, 2 for x, y, z) across an axis, in this order.
pub(crate) fn across(axis: &Axis) -> [usize; 2] {
    match axis.principal() {
        0 => [1, 2],
        1 => [0, 2],
        _ => [0, 1],
    }
}
