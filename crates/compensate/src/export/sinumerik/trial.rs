//! Two small tables that show what a control makes of a product, before anything is at stake.

use trueaxis_files::round;

use crate::export::sinumerik::sag::Product;
use crate::export::sinumerik::table::Table;
use crate::export::{ExportedFile, Request};

const FILE: &str = "LEVER_TRIAL.INI";

/// Of the table of the angle, the same everywhere, mm.
const FACTOR: f64 = 0.1;

/// Of the table of the lever, at its far end, mm.
const AT_FAR_END: f64 = 0.4;

/// The tables of a product with small values: a constant for the angle, and a small share of the lever.
pub(super) fn file(request: &Request<'_>, product: &Product) -> ExportedFile {
    let Product { factor, lever } = product;
    let count = factor.values.len() - 1;
    let constant = Table {
        step: factor.step * count as f64,
        values: vec![FACTOR; 2],
        ..factor.clone()
    };
    let ends = [lever.min, lever.min + lever.step];
    let far = match ends[0].abs() > ends[1].abs() {
        true => ends[0],
        false => ends[1],
    };
    let share = AT_FAR_END / far.abs();
    let small = Table {
        values: lever.values.iter().map(|x| share * x).collect(),
        ..lever.clone()
    };
    let (by, of) = (request.name(lever.input), request.name(factor.output));
    let alone = round(FACTOR * share * far, 4);
    let with_lever = round(share * far + FACTOR * share * far, 4);
    let mut text = format!(
        "%_N_NC_CEC_INI\n\
         ; EXPERIMENTAL: a trial of $AN_CEC_MULT_BY_TABLE, not a compensation; it replaces the tables 0 and 1. No tool in the spindle,\n\
         ; all axes free to move. Read {of} with a dial gauge or a laser, everything else at home, first with the tables off, then on:\n\
         ; {by} = 0: {of} changes by 0, or by -{FACTOR} mm (the table of the angle acts by itself, too). Both will do.\n\
         ; {by} = {far}: {of} changes by {} mm more than at {by} = 0: as in the manual's example, use the levers.\n\
         ;   By {} mm more: the table of the lever acts by itself; by nothing more: there is no product; do not use the levers.\n\
         ;   By {alone} mm more: the other sign than is taken for all tables here; find out first with the tables of the lines.\n\
         CHANDATA(1)\n",
        -alone, -with_lever
    );
    constant.write(&mut text, 0, Some(1));
    small.write(&mut text, 1, None);
    text.push_str("M17\n");
    ExportedFile::new(FILE, text)
}
