//! The code of each error: E and three digits, by which `trueaxis explain` tells more.
//!
//! E0 files, E1 documents, E2 tables, E3 the adjustment, E4 what is sought, E5 results that are read, E6 what is asked for.

use trueaxis_calibrate::Error as Calibrate;
use trueaxis_campaign::{Error as Campaign, Part, Place, Problem};
use trueaxis_compensate::Error as Compensate;
use trueaxis_diagnose::Error as Diagnose;
use trueaxis_effects::{Error as Effects, Problem as EffectsProblem};
use trueaxis_files::{DocumentError, DocumentProblem, FileProblem};
use trueaxis_import::{Error as Import, Problem as ImportProblem};
use trueaxis_montecarlo::Error as Montecarlo;
use trueaxis_poses::Error as Poses;
use trueaxis_predict::{OtherMachine, OtherReferencePoint, ReadError};
use trueaxis_report::Error as Report;
use trueaxis_simulate::{Error as Simulate, Problem as SimulateProblem};

use crate::effects_input::EffectsInputError;
use crate::export::{NoOldTables, OntoItself};
use crate::given_file::Unreadable;
use crate::output::OutputError;

/// The code of an error by its first cause that has one.
pub(crate) fn of(error: &anyhow::Error) -> Option<&'static str> {
    error.chain().find_map(|cause| {
        let document = |e: &DocumentError| of_document(&e.problem, &e.place);
        let campaign = |e: &Campaign| of_campaign(&e.problem, &e.place);
        let scenario = |e: &Simulate| of_scenario(&e.problem, &e.place);
        let effects = |e: &Effects| of_effects(&e.problem, &e.place);
        let import = |e: &Import| of_import(&e.problem, &e.place);
        let reading = |e: &Unreadable| of_reading(&e.source);
        let found = cause.downcast_ref().map(document);
        found
            .or_else(|| cause.downcast_ref().map(campaign))
            .or_else(|| cause.downcast_ref().map(scenario))
            .or_else(|| cause.downcast_ref().map(import))
            .or_else(|| cause.downcast_ref().map(of_calibrate))
            .or_else(|| cause.downcast_ref().map(of_diagnose))
            .or_else(|| cause.downcast_ref().map(of_poses))
            .or_else(|| cause.downcast_ref().map(of_calibration))
            .or_else(|| cause.downcast_ref().map(effects))
            .or_else(|| cause.downcast_ref().map(of_compensate))
            .or_else(|| cause.downcast_ref().map(of_montecarlo))
            .or_else(|| cause.downcast_ref().map(of_report))
            .or_else(|| cause.downcast_ref().map(of_output))
            .or_else(|| cause.downcast_ref().map(reading))
            .or_else(|| cause.is::<EffectsInputError>().then_some("E116"))
            .or_else(|| cause.is::<OtherMachine>().then_some("E503"))
            .or_else(|| cause.is::<OtherReferencePoint>().then_some("E509"))
            .or_else(|| cause.is::<NoOldTables>().then_some("E609"))
            .or_else(|| cause.is::<OntoItself>().then_some("E609"))
    })
}

fn of_document(problem: &DocumentProblem, place: &Place) -> &'static str {
    let in_table = matches!(place.part, Some(Part::Column(_)));
    match problem {
        DocumentProblem::Syntax { .. } => "E008",
        DocumentProblem::OtherDocument { .. } => "E010",
        DocumentProblem::Format { .. } => "E011",
        DocumentProblem::Version { .. } => "E012",
        DocumentProblem::UnknownField { .. } => "E101",
        DocumentProblem::MissingField { .. } => "E102",
        DocumentProblem::Value { .. } if in_table => "E220",
        DocumentProblem::Value { .. } => "E103",
        DocumentProblem::UnknownName { .. } if in_table => "E221",
        DocumentProblem::UnknownName { .. } => "E104",
        DocumentProblem::DuplicateName { .. } => "E105",
    }
}

fn of_campaign(problem: &Problem, place: &Place) -> &'static str {
    match problem {
        Problem::Document(problem) => of_document(problem, place),
        Problem::File(problem) => of_file(problem),
        Problem::Unwritable { .. } => "E004",
        Problem::Empty => "E006",
        Problem::NotUtf8 | Problem::NulBytes => "E007",
        Problem::Machine { .. } => "E106",
        Problem::NothingMeasured => "E107",
        Problem::TwoMeasurements => "E108",
        Problem::EmptyList { .. } => "E109",
        Problem::Inconsistent { .. } => "E131",
        Problem::Separator { .. } => "E201",
        Problem::NoHeader { .. } => "E202",
        Problem::MissingColumn { .. } => "E203",
        Problem::UnknownColumn { .. } => "E204",
        Problem::DuplicateColumn => "E205",
        Problem::Columns { .. } => "E206",
        Problem::FieldCount { .. } => "E207",
        Problem::NoRows => "E208",
        Problem::OutsideTravel { .. } => "E209",
        Problem::TargetReadTwice { .. } => "E210",
        Problem::StopRepeated { .. } => "E211",
        Problem::NotInMeasuringOrder { .. } => "E212",
        Problem::StationCopied { .. } => "E213",
        Problem::WrongAxisMoves { .. } => "E214",
        Problem::LengthsTooLarge { .. } => "E215",
        Problem::LengthsTooSmall { .. } => "E216",
        Problem::PointsImpossible { .. } => "E217",
        Problem::ScaleAgainstApprox { .. } => "E218",
        Problem::SwappedStations { .. } => "E219",
        Problem::NearPositions { .. } => "E222",
    }
}

fn of_effects(problem: &EffectsProblem, place: &Place) -> &'static str {
    match problem {
        EffectsProblem::Document(problem) => of_document(problem, place),
        EffectsProblem::Subject { .. } => "E110",
        EffectsProblem::MissingParameter { .. } => "E111",
        EffectsProblem::DuplicateParameter { .. } => "E112",
        EffectsProblem::Unit { .. } => "E113",
        EffectsProblem::Value { .. } => "E103",
        EffectsProblem::CovarianceSize { .. } => "E114",
        EffectsProblem::CovarianceAsymmetric { .. } => "E115",
    }
}

fn of_scenario(problem: &SimulateProblem, place: &Place) -> &'static str {
    match problem {
        SimulateProblem::Document(problem) => of_document(problem, place),
        SimulateProblem::Campaign(problem) => of_campaign(problem, place),
        SimulateProblem::Effect(problem) => of_effects(problem, place),
        SimulateProblem::Read(source) => of_reading(source),
        SimulateProblem::Write(_) => "E004",
        SimulateProblem::Value { .. } | SimulateProblem::Expected { .. } => "E103",
        SimulateProblem::OutsideTravel { .. } => "E209",
        SimulateProblem::NotIncreasing { .. } => "E121",
        SimulateProblem::TargetAtRest { .. } => "E122",
        SimulateProblem::TargetUnused { .. } => "E123",
        SimulateProblem::NoRun { .. } => "E124",
        SimulateProblem::GaugeUndefined { .. } => "E125",
        SimulateProblem::LostMotionUnseen { .. } => "E126",
        SimulateProblem::TakenByFrame { .. } => "E127",
        SimulateProblem::MountingMean { .. } => "E128",
        SimulateProblem::MountingRotation { .. } => "E129",
        SimulateProblem::ExactWithNoise { .. } => "E130",
    }
}

fn of_import(problem: &ImportProblem, place: &Place) -> &'static str {
    match problem {
        ImportProblem::Document(problem) => of_document(problem, place),
        ImportProblem::File(problem) => of_file(problem),
        ImportProblem::NoText => "E007",
        ImportProblem::Toml { .. } => "E009",
        ImportProblem::NoRows { .. } => "E208",
        ImportProblem::NotInMeasuringOrder { .. } => "E212",
        ImportProblem::NoSuchColumn { .. } => "E231",
        ImportProblem::NoNames { .. } => "E232",
        ImportProblem::OneColumn { .. } => "E233",
        ImportProblem::Nothing { .. } => "E234",
        ImportProblem::Short { .. } => "E235",
        ImportProblem::Cell { .. } => "E236",
        ImportProblem::PartOfStop { .. } => "E237",
        ImportProblem::PartOfPath { .. } | ImportProblem::NotPlanned { .. } => "E238",
    }
}

fn of_poses(error: &Poses) -> &'static str {
    match error {
        Poses::NotConverged { .. } => "E301",
        Poses::NotTrustworthy { .. } => "E302",
        Poses::Contradictory { .. } => "E303",
        Poses::RanAway { .. } => "E304",
        Poses::StationUnexplained { .. } => "E305",
        Poses::Numerical { .. } => "E306",
        Poses::NotIdentifiable { .. } => "E401",
        Poses::NothingMeasured => "E404",
        Poses::EffectsWithoutLengths => "E405",
    }
}

fn of_calibrate(error: &Calibrate) -> &'static str {
    match error {
        Calibrate::Poses(error) => of_poses(error),
        Calibrate::Mistaken { error, .. } => of_calibrate(error),
        Calibrate::NotConverged { .. } => "E307",
        Calibrate::NotThatMotion { .. } | Calibrate::DisplacedOnce(_) => "E402",
        Calibrate::SeveralAxesMove { .. } => "E403",
        Calibrate::TooLarge { .. } => "E610",
    }
}

fn of_diagnose(error: &Diagnose) -> &'static str {
    match error {
        Diagnose::Calibrate(error) => of_calibrate(error),
        Diagnose::Adjustment(_) => "E301",
        Diagnose::NothingMeasured | Diagnose::NothingRead => "E404",
        Diagnose::OtherMachine(_) => "E503",
    }
}

fn of_calibration(error: &ReadError) -> &'static str {
    match error {
        ReadError::File { problem, .. } => of_file(problem),
        ReadError::Document(error) => of_document(&error.problem, &error.place),
        ReadError::Machine(error) => of_campaign(&error.problem, &error.place),
        ReadError::Covariance { .. } => "E502",
    }
}

fn of_file(problem: &FileProblem) -> &'static str {
    match problem {
        FileProblem::NotFound { .. } => "E001",
        FileProblem::Folder { .. } => "E002",
        FileProblem::Unreadable { .. } => "E003",
    }
}

/// The code of a file that cannot be read.
fn of_reading(error: &std::io::Error) -> &'static str {
    match error.kind() {
        std::io::ErrorKind::NotFound => "E001",
        std::io::ErrorKind::IsADirectory => "E002",
        _ => "E003",
    }
}

fn of_report(error: &Report) -> &'static str {
    match error {
        Report::Unreadable { source, .. } => of_reading(source),
        Report::NothingToReport { .. } => "E504",
        Report::NotAResult { .. } => "E505",
        Report::OtherFormat { .. } => "E506",
        Report::NotResiduals { .. } => "E507",
        Report::Template { .. } => "E508",
    }
}

fn of_compensate(error: &Compensate) -> &'static str {
    match error {
        Compensate::NothingRead => "E404",
        Compensate::OtherMachine(_) => "E503",
        Compensate::NotContracting { .. } => "E601",
        Compensate::NoSuchAxis { .. } => "E602",
        Compensate::Unsuitable { .. } | Compensate::NoLever => "E603",
        Compensate::Table { .. } => "E604",
        Compensate::Step { .. } => "E605",
        Compensate::UnequalSteps { .. } => "E606",
        Compensate::TooManyPoints { .. } => "E607",
        Compensate::Slope { .. } => "E608",
        Compensate::NoOldTable { .. } => "E609",
        Compensate::NoSign { .. } => "E615",
    }
}

fn of_output(error: &OutputError) -> &'static str {
    match error {
        OutputError::Exists { .. } | OutputError::OtherMachine { .. } => "E005",
        OutputError::File { .. } | OutputError::StandardOutput(_) => "E004",
    }
}

fn of_montecarlo(error: &Montecarlo) -> &'static str {
    match error {
        Montecarlo::TooFewTrials { .. } | Montecarlo::TooFewForBlocks { .. } => "E611",
        Montecarlo::Memory { .. } | Montecarlo::Allocation { .. } => "E612",
        Montecarlo::Threads { .. } => "E613",
        Montecarlo::Coverage { .. }
        | Montecarlo::NoOutputs
        | Montecarlo::SignificantDigits { .. } => "E614",
        Montecarlo::NotFinite { .. }
        | Montecarlo::Overflow { .. }
        | Montecarlo::FirstOrderNotFinite { .. } => "E308",
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use crate::explain;

    const SOURCE: &str = include_str!("codes.rs");

    /// Codes that stand in the code of the program.
    fn codes(source: &str) -> BTreeSet<&str> {
        let texts = source.split('"').filter(|text| {
            let digits = text.strip_prefix('E').unwrap_or_default();
            digits.len() == 3 && digits.bytes().all(|b| b.is_ascii_digit())
        });
        texts.collect()
    }

    #[test]
    fn every_code_is_explained_and_no_other() {
        let given = codes(SOURCE);
        let explained: Vec<&str> = explain::entries().map(|entry| entry.code).collect();
        assert!(explained.is_sorted(), "{explained:?}");
        let unique: BTreeSet<&str> = explained.iter().copied().collect();
        assert_eq!(unique.len(), explained.len(), "a code is explained twice");
        assert_eq!(given, unique);
    }
}
