//! What the best compensation leaves.

use trueaxis_compensate::remains;
use trueaxis_kinematics::{ARCSEC, MICROMETRE};

use crate::{FIVE_AXES, TABLE, THREE_AXES, calibrated, scenario, tool};

#[test]
fn positions_go_and_rotations_stay_as_far_as_no_axis_turns() {
    let of = |text| {
        let machine = calibrated(&scenario(text), false);
        remains(&machine, &machine.places(8, tool())).unwrap()
    };
    let (three, five, table) = (of(THREE_AXES), of(FIVE_AXES), of(TABLE));
    assert_eq!(three.places, 512);
    for left in [three.linear, three.all, five.linear, five.all] {
        assert!(left.max_mm < 1e-6 * MICROMETRE, "{left:?}");
        assert!(left.rms_mm <= left.max_mm && left.rotation_rms_rad <= left.rotation_max_rad);
    }
    // Three linear axes turn nothing, two rotary ones most.
    assert_eq!(three.linear, three.all);
    assert!(three.all.rotation_max_rad > 5.0 * ARCSEC);
    assert!(
        five.all.rotation_rms_rad < 0.8 * five.linear.rotation_rms_rad,
        "{five:?}"
    );
    // A table alone displaces what is on it.
    assert!(table.linear.max_mm > MICROMETRE);
    assert!(table.all.rotation_max_rad < table.linear.rotation_max_rad);
    // What is not known is that of the predictions: µm here.
    for remains in [three, five] {
        let u_um = remains.u_rms_mm / MICROMETRE;
        assert!((0.3..10.0).contains(&u_um), "{u_um}");
        assert!(remains.u_rms_mm < remains.u_max_mm);
    }
}

/// Where no axis corrects anything, that is what was there before: zero at home. The displacement at home counted.
#[test]
fn what_is_there_at_home_does_not_remain() {
    let machine = calibrated(&scenario(TABLE), false);
    let places = machine.places(8, tool());
    let left = remains(&machine, &places).unwrap();
    assert_eq!(left.places, places.count());
    let error = |positions: &[f64]| machine.predict(positions, tool()).error.translation_mm;
    let home = error(&vec![0.0; machine.machine().axes().len()]);
    let sizes = (0..places.count()).map(|k| (error(&places.at(k)) - home).norm());
    let largest = sizes.fold(0.0, f64::max);
    assert!(home.norm() > 0.1 * MICROMETRE, "{home}");
    assert!(
        (left.linear.max_mm - largest).abs() < 1e-9,
        "{left:?} {largest}"
    );
}
