//! The errors of a stage from the displacements of three targets.

#![expect(clippy::print_stdout, reason = "an example shows its result")]

use nalgebra::Vector3;
use trueaxis_identify::nine;
use trueaxis_kinematics::{ARCSEC, MICROMETRE, MotionError};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // The targets of the paper's three-axis machine, from the origin of the stage frame, mm.
    let r = [
        Vector3::new(16.338, 452.716, 122.416),
        Vector3::new(157.086, 332.593, 324.879),
        Vector3::new(248.925, 603.0552, 412.4483),
    ];
    let truth = MotionError::new(
        Vector3::new(5.0, -2.0, 1.0) * MICROMETRE,
        Vector3::new(0.0, 3.0, -4.0) * ARCSEC,
    );
    let delta = r.map(|r| truth.displacement_mm(r)); // measured minus ideal

    let operator = nine(&r)?;
    let found = operator.apply(&delta);
    assert!((found.to_vector() - truth.to_vector()).norm() < 1e-15);

    // 1 µm of noise on every coordinate makes 2.2 µm of δx and 0.88″ of εx.
    let sigma = operator.noise_gain();
    assert_eq!(format!("{:.2}", sigma[0]), "2.20");
    assert_eq!(format!("{:.2}", sigma[3] * MICROMETRE / ARCSEC), "0.88");
    println!("noise gain of nine equations (mm and rad for 1 mm): {sigma:.2e}");
    Ok(())
}
