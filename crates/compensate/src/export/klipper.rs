//! `klipper`: `SET_SKEW`, three lengths of a rhombus that was printed as a square.
//!
//! It takes the diagonals AC and BD and the side AD and finds the angle at A by the law of cosines; what it then does is
//! what Marlin does. The rhombus of sides a whose axes are short of 90° by `atan f` has
//!
//! ```text
//! AC = a √(2 + 2 cos A)     BD = a √(2 - 2 cos A)     cos A = sin(atan f)
//! ```
//!
//! A saved profile does nothing until it is loaded; comments begin with `;`.
//!
//! Sources: `klippy/extras/skew_correction.py`, `klippy/gcode.py`, and "Skew correction" in Klipper's documentation.

use crate::Error;
use crate::export::sides::Sides;
use crate::export::skew::Skew;
use crate::export::{Description, ExportedFile, OldFiles, Request, Tables};

pub(super) const FORMAT: Description = Description {
    name: "klipper",
    text: "Klipper: SET_SKEW",
    old_files: OldFiles::None,
    sides: Sides::Nothing,
    is_experimental: false,
    tables,
};

/// Side of the rhombus, mm.
const SIDE_MM: f64 = 100.0;

fn tables(request: &Request<'_>) -> Result<Tables, Error> {
    let skew = Skew::new(request)?;
    let factors = skew.factors();
    let lengths = factors.map(|factor| {
        let cosine = factor.atan().sin();
        let [ac, bd] = [1.0, -1.0].map(|sign| SIDE_MM * (2.0 + 2.0 * sign * cosine).sqrt());
        format!("{ac:.9},{bd:.9},{SIDE_MM}")
    });
    let [xy, xz, yz] = lengths;
    let text = format!(
        "; {}\nSET_SKEW XY={xy} XZ={xz} YZ={yz}\nSKEW_PROFILE SAVE=trueaxis\n",
        request.origin()
    );
    Ok(Tables {
        files: vec![ExportedFile::new("skew.gcode", text)],
        notes: vec![
            "squareness alone, as AC, BD, AD of a square of 100 mm: commands for the console; needs [skew_correction]".to_owned(),
            "SAVE_CONFIG keeps the profile, but after each start of the firmware nothing is corrected until, after homing, \
             SKEW_PROFILE LOAD=trueaxis"
                .to_owned(),
            request.origin(),
        ],
        rule: Box::new(move |commanded| Ok(skew.added(factors, commanded))),
    })
}
