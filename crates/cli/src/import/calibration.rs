//! `trueaxis import calibration`: the result of another system, to be predicted with and verified.

use std::path::{Path, PathBuf};

use clap::Args as ClapArgs;
use serde::Deserialize;
use trueaxis_campaign::{InputFile, MachineSpec};
use trueaxis_compensate::{DeclaredUncertainty, Import, import};
use trueaxis_predict::{CalibratedMachine, FactoredCovariance};

use crate::args::positive;
use crate::exit::Exit;
use crate::export::in_folder;
use crate::given_file::{Unreadable, read_text};
use crate::output::Results;
use crate::talk::{notice_all, say};

#[derive(Debug, ClapArgs)]
pub(crate) struct ImportCalibrationArgs {
    /// Tables that another system wrote for a control: `ISG_CSV` (ISG kernel, Beckhoff TF5280) or
    /// the exchange format of Etalon; the program recognises which.
    #[arg(value_name = "FILE")]
    file: PathBuf,

    /// The machine that the tables are for: any campaign.json with this machine (its measurements are
    /// ignored), or a calibration.json of it.
    #[arg(long, value_name = "CAMPAIGN.json")]
    machine: PathBuf,

    /// Standard uncertainty (k = 1) of each displacement in the file, µm, if it is known. Without it,
    /// nothing derived from the calibration has an uncertainty.
    #[arg(long, value_name = "U", value_parser = positive, allow_negative_numbers = true)]
    u_um: Option<f64>,

    /// The same for each angle, ″ [default: the angle that displaces by --u-um at half the diagonal of the
    /// travels of the linear axes].
    #[arg(long, value_name = "U", value_parser = positive, allow_negative_numbers = true, requires = "u_um")]
    u_arcsec: Option<f64>,

    /// Folder for calibration.json, and covariance.npz [default: one in the current directory, named
    /// after FILE].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,

    /// Also print calibration.json on standard output.
    #[arg(long)]
    pub(crate) json: bool,
}

pub(crate) fn execute(args: &ImportCalibrationArgs) -> anyhow::Result<Exit> {
    let machine = read_machine(&args.machine)?;
    let wanted = "give a table in ISG_CSV or in Etalon's exchange format";
    let text = read_text(&args.file, wanted)?;
    let file = InputFile::of(&args.file).map_err(Unreadable::at(&args.file, wanted))?;
    let built = machine.build().map_err(|mut error| {
        error.place.file = Some(args.machine.clone());
        error
    })?;
    let folder = args.file.parent().unwrap_or(&args.file);
    let imported = import(&Import {
        file,
        text: &text,
        machine: &built,
        machine_name: &machine.name,
        uncertainty: args.u_um.map(|um| DeclaredUncertainty {
            um,
            arcsec: args.u_arcsec,
        }),
    })
    .map_err(|error| in_folder(error, folder))?;
    let text = trueaxis_files::to_json(&imported.calibration)?;
    let stem = args.file.file_stem().unwrap_or_default();
    let mut results = Results::new(args.out.as_deref(), &stem.to_string_lossy())?;
    results.write("calibration.json", text.as_bytes())?;
    say(&format!(
        "{}: format {}, machine {}",
        args.file.display(),
        imported.format.name(),
        machine.name
    ));
    notice_all(&imported.notices);
    if let Some(covariance) = &imported.covariance {
        let as_they_are = vec![1.0; covariance.results()];
        results.write_by(FactoredCovariance::FILE, |out| {
            covariance.write_npz(out, &as_they_are)
        })?;
    }
    let says = "is of another calibration and is not looked at";
    notice_all(results.left_from_before(&[FactoredCovariance::FILE], says));
    results.end(args.json.then_some(&text))?;
    Ok(Exit::Good)
}

/// All that is needed of a campaign or a calibration.
#[derive(Deserialize)]
#[serde(expecting = "an object: a campaign or a calibration")]
struct WithMachine {
    machine: MachineSpec,
}

/// What a document says it is.
#[derive(Deserialize)]
struct SaysFormat {
    format: String,
}

fn read_machine(path: &Path) -> anyhow::Result<MachineSpec> {
    let text = read_text(path, "--machine wants a campaign.json with the machine")?;
    // What is no JSON is refused as a campaign.
    let said = serde_json::from_str::<SaysFormat>(&text);
    let format = match said.is_ok_and(|said| said.format == CalibratedMachine::FORMAT.name) {
        true => CalibratedMachine::FORMAT,
        false => trueaxis_campaign::FORMAT,
    };
    let read: WithMachine = format.read(&text, Some(path))?;
    Ok(read.machine)
}
