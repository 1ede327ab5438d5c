//! The program as its users meet it: exit codes, what it prints, which files it leaves.
//!
//! Numbers are tested in the libraries; here the shipped campaigns run through the real program,
//! as they are and damaged in all the ways that happen between a machine and a file.

mod calibrate;
mod campaign_files;
mod check;
mod compare;
mod diagnose;
mod explain;
mod export;
mod golden;
mod gross_errors;
mod harmless;
mod import;
mod import_calibration;
mod json_schema;
mod misleading;
mod montecarlo;
mod predict;
mod program;
mod refused;
mod refused_geometries;
mod refused_inputs;
mod refused_measurements;
mod report;
mod schema;
mod simulate;
mod table1;
mod usage;
mod verify;
mod volume;
