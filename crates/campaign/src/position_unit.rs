//! Positions of axes: mm or degrees in the files, mm or rad in the model.

use trueaxis_kinematics::AxisKind;

/// From the model's unit to the file's, such that [`AxisKind::position_from_file`] returns `position` again.
///
/// Multiplying by 180/π alone would print 22.5° as 22.499999999999996. Of the decimal numbers that read as `position`, the
/// shortest is the one that was in the file. A few angles (one in ten of those that no file ever held) are not the image of any
/// double in degrees: these come back one unit in the last place away, and stay there.
pub(crate) fn in_file(kind: AxisKind, position: f64) -> f64 {
    match kind {
        AxisKind::Linear => position + 0.0,
        AxisKind::Rotary => shortest_degrees(position + 0.0),
    }
}

/// Digits after the first that make a decimal number distinguish all doubles.
const DIGITS_OF_A_DOUBLE: usize = 16;

fn shortest_degrees(position_rad: f64) -> f64 {
    let near = position_rad.to_degrees();
    (0..=DIGITS_OF_A_DOUBLE)
        .filter_map(|digits| format!("{near:.digits$e}").parse().ok())
        .chain([near.next_up(), near.next_down()])
        .find(|degrees: &f64| degrees.to_radians().to_bits() == position_rad.to_bits())
        .unwrap_or(near)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn through(degrees: f64) -> f64 {
        in_file(
            AxisKind::Rotary,
            AxisKind::Rotary.position_from_file(degrees),
        )
    }

    /// Every multiple of 0.0001° of a turn prints as it was read.
    #[test]
    fn degrees_of_a_file_print_as_the_same_text() {
        for i in (-3_600_000..=3_600_000).step_by(7) {
            let text = format!("{}", f64::from(i) / 1e4);
            assert_eq!(format!("{}", through(text.parse().unwrap())), text);
        }
        for text in ["22.487129", "0.0023", "337.508716", "359.99999999999994"] {
            assert_eq!(format!("{}", through(text.parse().unwrap())), text);
        }
    }

    #[test]
    fn any_angle_is_stable_after_one_pass() {
        for i in 0..20_000 {
            let angle = f64::from(i) * 3.141_592e-4 + 1e-9;
            let once = AxisKind::Rotary.position_from_file(in_file(AxisKind::Rotary, angle));
            let twice = AxisKind::Rotary.position_from_file(in_file(AxisKind::Rotary, once));
            assert!((once - angle).abs() <= angle * f64::EPSILON);
            assert_eq!(once.to_bits(), twice.to_bits());
        }
    }

    #[test]
    fn minus_zero_is_zero() {
        for kind in [AxisKind::Linear, AxisKind::Rotary] {
            assert_eq!(kind.position_from_file(-0.0).to_bits(), 0.0_f64.to_bits());
            assert_eq!(in_file(kind, -0.0).to_bits(), 0.0_f64.to_bits());
        }
    }
}
