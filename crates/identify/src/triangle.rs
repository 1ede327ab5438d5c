//! Whether measured targets have the distances that the nominal ones have.

use nalgebra::Point3;

use crate::Error;

/// The distance between two targets, nominal and measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SideMismatch {
    /// Index of one target.
    pub first: usize,
    /// Index of the other, greater than `first`.
    pub second: usize,
    /// Distance of the nominal positions, mm.
    pub nominal_mm: f64,
    /// Distance of the measured positions, mm.
    pub measured_mm: f64,
}

/// Compares the distances between all pairs of targets, in the order PQ, PK, QK.
///
/// Positions at home, mm; nominal and measured may be in different frames, for distances do not
/// depend on the frame. A wrong or interchanged coordinate shows here before it spoils six
/// component errors.
///
/// # Errors
/// [`Error::TargetCount`] if there are not as many measured targets as nominal ones.
pub fn triangle_mismatch(
    nominal: &[Point3<f64>],
    measured: &[Point3<f64>],
) -> Result<Vec<SideMismatch>, Error> {
    if nominal.len() != measured.len() {
        return Err(Error::TargetCount {
            nominal: nominal.len(),
            measured: measured.len(),
        });
    }
    let count = nominal.len();
    let pairs = (0..count).flat_map(|first| (first + 1..count).map(move |second| (first, second)));
    let side = |(first, second): (usize, usize)| SideMismatch {
        first,
        second,
        nominal_mm: (nominal[second] - nominal[first]).norm(),
        measured_mm: (measured[second] - measured[first]).norm(),
    };
    Ok(pairs.map(side).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The paper's section 5.2 prints the home positions of P, Q, K in two frames that contradict
    /// each other: PQ +157, PK +67, QK -119 µm, stage minus tracker.
    #[test]
    fn contradictory_coordinates_of_the_paper_are_noticed() {
        let in_tracker = [
            Point3::new(1005.6648, -140.3849, -222.6797),
            Point3::new(1240.2676, -187.6319, -183.0147),
            Point3::new(1136.3720, -386.5078, -207.4099),
        ];
        let in_stage = [
            Point3::new(-105.8046, 135.3414, 0.0),
            Point3::new(128.8513, 87.8158, 39.9797),
            Point3::new(24.9026, -110.8575, 15.2662),
        ];
        let sides = triangle_mismatch(&in_tracker, &in_stage).unwrap();
        let pairs: Vec<_> = sides.iter().map(|s| (s.first, s.second)).collect();
        assert_eq!(pairs, [(0, 1), (0, 2), (1, 2)]);
        let differences_mm = sides.iter().map(|s| s.measured_mm - s.nominal_mm);
        let differences_um: Vec<f64> = differences_mm.map(|d| (1e3 * d).round()).collect();
        assert_eq!(differences_um, [157.0, 67.0, -119.0]);
        assert!((sides[0].nominal_mm - 242.578).abs() < 5e-4);
        assert!((sides[0].measured_mm - 242.735).abs() < 5e-4);
    }

    #[test]
    fn counts_must_agree() {
        let p = Point3::origin();
        let refused = triangle_mismatch(&[p, p, p], &[p, p]);
        assert_eq!(
            refused,
            Err(Error::TargetCount {
                nominal: 3,
                measured: 2
            })
        );
    }
}
