//! The commands of the program, each called as a user calls it.
//!
//! One program, so that its tests share what is compiled and both cores.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "figures are printed; a skipped test says so")]

mod capture_diagnose;
mod chosen_columns;
mod cogging;
mod compose;
mod diagnosis;
mod files;
mod habits;
mod json_output;
mod offline_rig;
mod outputs;
mod pages;
mod pressed;
mod program;
mod recompute;
mod replay;
mod report_pages;
mod sheet;
mod simulate;
mod until_ci;
