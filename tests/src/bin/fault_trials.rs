//! Faults in running captures, many of them, as a table: what was lost, how soon all was well again.
//!
//! Exit status 1 when a promise was broken.
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "the table is this program's output")]

use std::process::ExitCode;

use clap::Parser;
use tests::Bench;
use tests::trials::{Trial, capture_with_restarts, markdown};

#[derive(Parser)]
struct Arguments {
    /// Trials, the kinds of fault in turn.
    #[arg(long, default_value_t = 200)]
    trials: u64,
    /// Draws the moments.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// The first trial, to repeat one alone with --trials 1.
    #[arg(long, default_value_t = 0)]
    first: u64,
    /// Kills in the one long capture that watches shared memory; 0 leaves it out.
    #[arg(long, default_value_t = 200)]
    restarts: u32,
}

fn main() -> anyhow::Result<ExitCode> {
    let arguments = Arguments::parse();
    let mut trials = Vec::new();
    let mut broken = 0;
    for number in arguments.first..arguments.first + arguments.trials {
        let trial = Trial::draw(arguments.seed, number);
        let outcome = trial.run(&Bench::new()?)?;
        for promise in outcome.broken.iter().chain(&outcome.late) {
            eprintln!("trial {number}, {:?} {:?} at {:.2} s: {promise}", trial.victim, trial.fault, trial.moment_s);
            broken += 1;
        }
        if outcome.lost_unsaid > 0 || outcome.orphans > 0 {
            eprintln!("trial {number}: {} samples lost unsaid, {} orphans", outcome.lost_unsaid, outcome.orphans);
            broken += 1;
        }
        trials.push((trial, outcome));
    }
    println!("{}", markdown(&trials));
    if arguments.restarts > 0 {
        let restarts = capture_with_restarts(&Bench::new()?, arguments.restarts)?;
        let at = |share: f64| {
            let index = (share * (restarts.shared_memory_bytes.len() - 1) as f64) as usize;
            restarts.shared_memory_bytes[index].1 as f64 / 1e6
        };
        println!(
            "One capture with {} restarts: {} samples, {} lost; shared memory {:.1} MB before the first, {:.1} MB half \
             way, {:.1} MB at the last.",
            arguments.restarts,
            restarts.samples,
            restarts.lost_samples,
            at(0.0),
            at(0.5),
            at(1.0)
        );
        broken += u64::from(restarts.lost_samples > 0);
    }
    Ok(if broken == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}
