//! `marlin`: `M852 I J K`, the skew factors of the planes XY, XZ, YZ.
//!
//! The firmware moves to `x - y I - z (J - I K)` and `y - z K`. A factor is the tangent of the angle that a plane's axes
//! are short of 90°: positive if Y leans towards +X (I), Z towards +X (J), Z towards +Y (K). Positioning and straightness
//! stay, and the part turns with the line of X. Kept with `M500`. Nothing is corrected where X or Y is less than 1 mm from the
//! lower end of its travel, or corrected would leave it.
//!
//! Sources: `planner.h` (`skew`), `M852.cpp`, and M852 in Marlin's documentation.

use trueaxis_files::round;

use crate::Error;
use crate::export::sides::Sides;
use crate::export::skew::Skew;
use crate::export::{Description, ExportedFile, OldFiles, Request, Tables};

pub(super) const FORMAT: Description = Description {
    name: "marlin",
    text: "Marlin: skew factors, M852",
    old_files: OldFiles::None,
    sides: Sides::Nothing,
    is_experimental: false,
    tables,
};

fn tables(request: &Request<'_>) -> Result<Tables, Error> {
    let skew = Skew::new(request)?;
    let factors = skew.factors().map(|factor| round(factor, 9));
    let [i, j, k] = factors.map(|factor| format!("{factor:.9}"));
    let text = format!("; {}\nM852 I{i} J{j} K{k}\n", request.origin());
    Ok(Tables {
        files: vec![ExportedFile::new("skew.gcode", text)],
        notes: vec![
            "squareness alone; a factor is positive if the second axis leans towards the first; M500 keeps it".to_owned(),
            "needs SKEW_CORRECTION_GCODE, and SKEW_CORRECTION_FOR_Z, without which J and K are passed over in silence; with G20 (inches) \
             the factors would be multiplied by 25.4"
                .to_owned(),
            "the firmware prints six decimals (0.2″); it calculates with 32 bits".to_owned(),
            request.origin(),
        ],
        rule: Box::new(move |commanded| Ok(skew.added(factors, commanded))),
    })
}
