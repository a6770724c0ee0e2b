//! The operator's program: `haptic-camera`.
//!
//! A command that cannot obtain, read or write what it needs ends with an error: one sentence that says what is wrong and what to
//! do, printed once, here. The documentation of a function names only the errors that need more than that.
//!
//! Exit status: 0 done, 1 failed, 2 wrong usage, 3 done but data was lost; of `judge`, 4 a unit fails and 5 one is undecided.

mod calibrate;
mod capture;
mod check;
mod command_line;
mod compare;
mod compose;
mod diagnose;
mod doctor;
mod export;
mod fit;
mod judge;
mod large_job;
mod list;
mod load;
mod manual;
mod offline_run;
mod outcome;
mod parquet_file;
mod recompute;
mod recover;
mod replay;
mod rig_run;
mod rig_test;
mod rigs;
mod sheet;
mod simulate;
mod studies;
mod supervision;
mod table;
mod terminal;
mod trend;
mod tune;
mod until_ci;
mod verify;
mod view;

use std::process::ExitCode;
use std::sync::atomic::Ordering;

use crate::command_line::Command;
use crate::outcome::Outcome;

fn main() -> ExitCode {
    shared_types::rig::keep_files_private();
    operator::start_log(operator::LevelFilter::ERROR);
    let command = match operator::parse::<Command>() {
        Ok(command) => command,
        Err(status) => return status,
    };
    let files = command.files();
    outcome::OUTPUT_IS_JSON.store(files.gives_json, Ordering::Relaxed);
    let done = |()| Outcome::Done;
    let result = files.check().and_then(|()| match command {
        Command::Capture(options) => capture::run(&options),
        Command::Replay(options) => replay::run(&options),
        Command::Tune(options) => tune::run(&options).map(done),
        Command::Fit(options) => fit::run(&options).map(done),
        Command::Diagnose(options) => diagnose::run(&options).map(done),
        Command::Calibrate(options) => calibrate::run(&options),
        Command::RigTest(options) => rig_test::run(&options),
        Command::Check(options) => check::run(&options).map(done),
        Command::Compare(options) => compare::run(&options).map(done),
        Command::Capability(options) => studies::run_capability(&options).map(done),
        Command::Gauge(options) => studies::run_gauge(&options).map(done),
        Command::Judge(options) => judge::run(&options),
        Command::Sheet(options) => sheet::run(&options).map(done),
        Command::Simulate(options) => simulate::run(&options).map(done),
        Command::Compose(options) => compose::run(&options).map(done),
        Command::Export(options) => export::run(&options).map(done),
        Command::Completions { shell } => manual::completions(shell).map(done),
        Command::Man { folder } => manual::pages(&folder).map(done),
        Command::Table(options) => table::run(&options).map(done),
        Command::Trend(options) => trend::run(&options).map(done),
        Command::List(options) => list::run(&options).map(done),
        Command::View(options) => view::run(&options).map(done),
        Command::Recompute(options) => recompute::run(&options),
        Command::Recover(options) => recover::run(&options),
        Command::Doctor(options) => doctor::run(&options),
        Command::Rig(command) => rigs::run(&command),
    });
    let outcome = result.unwrap_or_else(|error| {
        tracing::debug!("{error:?}");
        if !error.is::<supervision::LoopSaidWhy>() {
            outcome::remark(format!("error: {error:#}"));
        }
        if error.is::<outcome::UsageError>() { Outcome::WrongUsage } else { Outcome::Failed }
    });
    ExitCode::from(outcome.if_output_was_taken() as u8)
}
