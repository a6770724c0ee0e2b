//! Has the instrument diagnose many captures that hide effects, and tabulates how often it is right.
//!
//! ```text
//! study target/release/haptic-camera --folder FOLDER [--families standard,soft-servo,…] [--strengths 1,3] [--count 20]
//! ```
//!
//! Captures and diagnoses stay in FOLDER, and captures that are there already are used again.

#![allow(clippy::print_stdout, clippy::print_stderr, reason = "a program of the command line speaks to its user")]

mod diagnosis;
mod tables;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;
use std::time::Duration;

use anyhow::{Context as _, Result};
use clap::Parser;
use hidden_effects::capture::{Answer, Capture};
use hidden_effects::family::Family;
use serde_json::{Value, json};

use crate::diagnosis::{Case, Judged, diagnose};

/// Has the instrument diagnose captures that hide effects, and tabulates the outcome.
#[derive(Parser)]
struct Arguments {
    /// The haptic-camera program.
    program: PathBuf,
    /// Where captures and diagnoses are kept.
    #[arg(long)]
    folder: PathBuf,
    /// Decides every capture.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Families of rigs, with commas; `all` for all.
    #[arg(long, default_value = "standard")]
    families: String,
    /// Ratios of effect to noise, with commas.
    #[arg(long, value_delimiter = ',', default_value = "1,3")]
    strengths: Vec<f64>,
    /// Captures of each family and strength.
    #[arg(long, default_value_t = 20)]
    count: usize,
    /// What they hide: mixed, single, pair, triple, none, outside-library, or names with commas.
    #[arg(long, default_value = "mixed")]
    effects: String,
    /// Diagnoses that run at the same time.
    #[arg(long, default_value_t = 2)]
    at_once: usize,
    /// A diagnosis that takes longer than this many seconds counts as wrong.
    #[arg(long, default_value_t = 60.0)]
    timeout_s: f64,
    /// Use the captures that FOLDER holds directly, beside an answers.json, and make none.
    #[arg(long)]
    given: bool,
}

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    if arguments.given {
        let cases = cases(&arguments.folder)?;
        let judged = judge(&arguments, cases);
        keep(&arguments.folder, &judged)?;
        tables::print("given", &judged);
        return Ok(());
    }
    let mut by_family = Vec::new();
    for (place, family) in Family::ALL.into_iter().enumerate() {
        if arguments.families != "all" && !arguments.families.split(',').any(|name| name == family.name()) {
            continue;
        }
        let mut judged = Vec::new();
        for strength in &arguments.strengths {
            let folder = arguments.folder.join(format!("{}-{strength}", family.name()));
            generate(&arguments, &folder, family, place * arguments.count, *strength)?;
            let these = judge(&arguments, cases(&folder)?);
            keep(&folder, &these)?;
            judged.extend(these);
        }
        tables::print(family.name(), &judged);
        by_family.push((family.name(), judged));
    }
    if by_family.len() > 1 {
        tables::print_families(&by_family);
    }
    Ok(())
}

/// Calls `work` with the numbers below `count` on so many threads.
fn spread(count: usize, threads: usize, work: impl Fn(usize) + Sync) {
    let next = AtomicUsize::new(0);
    thread::scope(|scope| {
        for _ in 0..threads.max(1) {
            scope.spawn(|| {
                while let index @ 0.. = next.fetch_add(1, Ordering::Relaxed)
                    && index < count
                {
                    work(index);
                }
            });
        }
    });
}

/// Makes the captures of one family and strength, unless the very same are there.
///
/// Each family continues the list of effects at its capture `first`, where the family before ended, so that all effects occur equally often.
fn generate(arguments: &Arguments, folder: &Path, family: Family, first: usize, strength: f64) -> Result<()> {
    let Arguments { seed, count, effects, .. } = arguments;
    let made_by = format!("seed {seed}, captures {first} to {}, effects {effects}\n", first + count);
    let note = folder.join("made-by.txt");
    if fs::read_to_string(&note).is_ok_and(|there| there == made_by) {
        return Ok(());
    }
    fs::create_dir_all(folder).with_context(|| format!("cannot make {}", folder.display()))?;
    let answers = Mutex::new(BTreeMap::new());
    spread(*count, arguments.at_once, |index| {
        let made = Capture::new(*seed, first + index, family, effects, strength)
            .and_then(|capture| capture.write(folder).map(|()| (capture.name, capture.answer)));
        match made {
            Ok((name, answer)) => _ = answers.lock().map(|mut answers| answers.insert(name, answer)),
            Err(error) => eprintln!("left out: {error}"),
        }
    });
    fs::write(folder.join("answers.json"), serde_json::to_string_pretty(&answers)?)?;
    fs::write(&note, made_by).with_context(|| format!("cannot write {}", note.display()))
}

/// The captures that a folder's answers name.
fn cases(folder: &Path) -> Result<Vec<Case>> {
    let file = folder.join("answers.json");
    let text = fs::read_to_string(&file).with_context(|| format!("cannot read {}", file.display()))?;
    let answers: BTreeMap<String, Answer> =
        serde_json::from_str(&text).with_context(|| format!("{} is no list of answers", file.display()))?;
    let case = |(name, answer)| Case { folder: folder.join(&name), name, answer };
    Ok(answers.into_iter().map(case).collect())
}

/// Keeps the outcomes beside the captures, for comparisons on the very same.
fn keep(folder: &Path, judged: &[Judged]) -> Result<()> {
    let outcome = |j: &Judged| {
        let seconds = j.outcome.seconds;
        (
            j.case.name.clone(),
            json!({"first_right": j.first_right(), "exact": j.exact(), "seconds": seconds, "said": j.words()}),
        )
    };
    let outcomes: BTreeMap<String, Value> = judged.iter().map(outcome).collect();
    let file = folder.join("results.json");
    fs::write(&file, serde_json::to_string_pretty(&outcomes)?)
        .with_context(|| format!("cannot write {}", file.display()))
}

/// Diagnoses the captures, a few at a time.
fn judge(arguments: &Arguments, cases: Vec<Case>) -> Vec<Judged> {
    let timeout = Duration::from_secs_f64(arguments.timeout_s);
    let judged = Mutex::new(Vec::new());
    spread(cases.len(), arguments.at_once, |index| {
        let outcome = diagnose(&arguments.program, &cases[index], timeout);
        _ = judged.lock().map(|mut judged| judged.push((index, outcome)));
    });
    let mut judged = judged.into_inner().unwrap_or_default();
    judged.sort_by_key(|(index, _)| *index);
    cases.into_iter().zip(judged).map(|(case, (_, outcome))| Judged { case, outcome }).collect()
}
