//! Noise of the six- and the nine-equation method for 1 µm of independent noise per coordinate.
//!
//! The expected digits are those of a computation with 40 digits, `noise_table.py` beside this file.
//! Two of them are easily rounded wrong by way of four digits: 1.54848 to 1.5485 to 1.549, and
//! 0.60148 to 0.6015 to 0.602.

use nalgebra::{UnitQuaternion, Vector3};
use trueaxis_identify::{Operator, SixRows, nine};
use trueaxis_kinematics::{ARCSEC, MICROMETRE};

use crate::targets::{ROTARY, THREE_AXIS};

/// µm and arcsec, as the table prints them.
fn printed(operator: &Operator) -> String {
    let gain = operator.noise_gain();
    let um = gain.fixed_rows::<3>(0);
    let arcsec = gain.fixed_rows::<3>(3) * (MICROMETRE / ARCSEC);
    format!(
        "{:.3} {:.3} {:.3}; {:.3} {:.3} {:.3}",
        um[0], um[1], um[2], arcsec[0], arcsec[1], arcsec[2]
    )
}

#[test]
fn three_axis_targets_at_the_origin() {
    let all = nine(&THREE_AXIS).unwrap();
    assert_eq!(printed(&all), "2.196 1.177 1.945; 0.878 0.837 0.991");
    let six = SixRows::PAPER.operator(&THREE_AXIS).unwrap();
    assert_eq!(printed(&six), "3.823 1.241 2.692; 0.968 1.444 1.548");
}

#[test]
fn rotary_targets_at_140_degrees() {
    let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 140_f64.to_radians());
    let r = ROTARY.map(|r| turn * r);
    assert_eq!(
        printed(&nine(&r).unwrap()),
        "0.596 0.601 0.629; 1.039 1.347 0.835"
    );
    let six = SixRows::PAPER.operator(&r).unwrap();
    assert_eq!(printed(&six), "2.570 1.055 11.649; 30.125 12.564 3.474");
}

/// At the centroid all three translations have the noise of a mean of three.
#[test]
fn three_axis_targets_at_the_centroid() {
    let centroid = THREE_AXIS.iter().sum::<Vector3<f64>>() / 3.0;
    let gain = nine(&THREE_AXIS.map(|r| r - centroid))
        .unwrap()
        .noise_gain();
    for sigma in gain.fixed_rows::<3>(0).iter() {
        assert!((sigma - 3_f64.sqrt().recip()).abs() < 1e-14);
    }
    assert_eq!(format!("{:.2}", gain[0]), "0.58");
}
