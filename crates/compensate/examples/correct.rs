//! Where the axes have to go for the tool to be where it was told to be.

#![expect(clippy::print_stdout, reason = "an example shows its result")]

use nalgebra::Point3;
use trueaxis_compensate::{Moved, correct};
use trueaxis_kinematics::MICROMETRE;
use trueaxis_simulate::Scenario;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let text = include_str!("../../../campaigns/five-axis/scenario.json");
    let truth = Scenario::from_json(text)?.true_machine()?;
    let commanded = [100.0, 200.0, 150.0, -0.3, 1.2];
    let tool = Point3::new(100.0, 50.0, 400.0);
    let corrected = correct(truth.machine(), &truth, &commanded, tool, Moved::All)?;
    assert!(corrected.left.translation_mm.norm() < 1e-6 * MICROMETRE);
    println!(
        "corrected axis positions (mm, rad): {:?}",
        corrected.positions
    );
    Ok(())
}
