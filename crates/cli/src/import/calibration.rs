//! `trueaxis import calibration`: the result of another system, to be predicted with and verified.

use std::path::{Path, PathBuf};

use clap::Args as ClapArgs;
use serde::Deserialize;
use trueaxis_calibrate::FactoredCovariance;
use trueaxis_campaign::{InputFile, MachineSpec};
use trueaxis_compensate::{DeclaredUncertainty, Import, import};
use trueaxis_files::Format;

use crate::args::positive;
use crate::exit::Exit;
use crate::output;
use crate::talk::{notice, say};

const FILE: &str = "calibration.json";

#[derive(Debug, ClapArgs)]
pub(crate) struct ImportCalibrationArgs {
    /// Tables that another system wrote for a control: `ISG_CSV` (ISG kernel, Beckhoff TF5280) or
    /// the exchange format of Etalon; which one it is, the file tells.
    #[arg(value_name = "FILE")]
    file: PathBuf,

    /// The machine that it is of: any campaign.json with this machine (its measurement is not
    /// looked at), or a calibration.json of it.
    #[arg(long, value_name = "CAMPAIGN.json")]
    machine: PathBuf,

    /// Standard uncertainty (k = 1) of each displacement in the file, µm, if it is known. Without it
    /// nothing that follows from the calibration has an uncertainty.
    #[arg(long, value_name = "U", value_parser = positive)]
    u_um: Option<f64>,

    /// The same of each angle, ″ [default: what makes the U of --u-um on half the diagonal of the
    /// travels of the linear axes].
    #[arg(long, value_name = "U", value_parser = positive, requires = "u_um")]
    u_arcsec: Option<f64>,

    /// Folder for calibration.json, and covariance.npz [default: one in the current directory, named
    /// after FILE].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,

    /// Also print calibration.json on standard output.
    #[arg(long)]
    pub(crate) json: bool,
}

pub(crate) fn run(args: &ImportCalibrationArgs) -> anyhow::Result<Exit> {
    let machine = read_machine(&args.machine)?;
    let unreadable = |source| ImportError::Unreadable {
        path: args.file.clone(),
        mend: "give a table in ISG_CSV or in Etalon's exchange format",
        source,
    };
    let text = std::fs::read_to_string(&args.file).map_err(unreadable)?;
    let file = InputFile::of(&args.file).map_err(unreadable)?;
    let built = machine.build().map_err(|mut error| {
        error.place.file = Some(args.machine.clone());
        error
    })?;
    let imported = import(&Import {
        file,
        text: &text,
        machine: &built,
        machine_name: &machine.name,
        uncertainty: args.u_um.map(|um| DeclaredUncertainty {
            um,
            arcsec: args.u_arcsec,
        }),
    })?;
    let text = trueaxis_files::to_json(&imported.calibration)?;
    let stem = args.file.file_stem().unwrap_or_default();
    let folder = output::folder(args.out.as_deref(), &stem.to_string_lossy())?;
    let path = folder.join(FILE);
    output::write(&path, text.as_bytes())?;
    say(&format!(
        "{}: format {}, machine {}",
        args.file.display(),
        imported.format.name(),
        machine.name
    ));
    imported.notices.iter().for_each(|text| notice(text));
    say(&format!("written: {}", path.display()));
    let path = folder.join(FactoredCovariance::FILE);
    if let Some(covariance) = &imported.covariance {
        output::write_by(&path, |out| covariance.write_npz(out))?;
        say(&format!("written: {}", path.display()));
    } else if path.exists() {
        notice(&format!(
            "{} is of another calibration and is not looked at",
            path.display()
        ));
    }
    if args.json {
        output::print(&text)?;
    }
    Ok(Exit::Good)
}

/// What is wrong with a file that is to be imported.
#[derive(Debug, thiserror::Error)]
pub(crate) enum ImportError {
    /// The operating system refuses, or it is no text.
    #[error("{} cannot be read; {mend}", path.display())]
    Unreadable {
        path: PathBuf,
        mend: &'static str,
        source: std::io::Error,
    },
}

/// All that is needed of a campaign or a calibration.
#[derive(Deserialize)]
#[serde(expecting = "an object: a campaign or a calibration")]
struct WithMachine {
    machine: MachineSpec,
}

const CAMPAIGN: Format = Format {
    name: "trueaxis-campaign",
    version: 1,
    noun: "a campaign",
};

const CALIBRATION: Format = Format {
    name: "trueaxis-calibration",
    version: 1,
    noun: "a calibration",
};

fn read_machine(path: &Path) -> anyhow::Result<MachineSpec> {
    let text = std::fs::read_to_string(path).map_err(|source| ImportError::Unreadable {
        path: path.to_owned(),
        mend: "--machine wants a campaign.json with the machine",
        source,
    })?;
    let format = match text.contains(CALIBRATION.name) {
        true => CALIBRATION,
        false => CAMPAIGN,
    };
    let read: WithMachine = format.read(&text, Some(path))?;
    Ok(read.machine)
}
