//! Writes captures that hide effects, and `answers.json`, into a folder.
//!
//! ```text
//! generate FOLDER --seed 1 --count 60 [--family NAME] [--strength S] [--effects mixed|single|pair|none|…]
//! ```

#![allow(clippy::print_stdout, clippy::print_stderr, reason = "a program of the command line speaks to its user")]

use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;

use anyhow::{Context as _, Result};
use clap::Parser;
use hidden_effects::capture::Capture;
use hidden_effects::family::Family;

/// Writes pairs of captures, each of which hides an effect, and their answers.
#[derive(Parser)]
struct Arguments {
    /// Folder for the captures and answers.json.
    folder: PathBuf,
    /// Decides everything.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// How many pairs of captures.
    #[arg(long, default_value_t = 20)]
    count: usize,
    /// Family of rigs: standard, coloured-noise, resonant-sensor, clipping-sensor, time-jitter, soft-servo,
    /// extreme-knob, other-rate, other-length.
    #[arg(long, default_value = "standard", value_parser = |name: &str| Family::named(name).ok_or("no such family"))]
    family: Family,
    /// Effect over noise.
    #[arg(long, default_value_t = 3.0)]
    strength: f64,
    /// Names with commas, or mixed, single, pair, triple, none, outside-library.
    #[arg(long, default_value = "mixed")]
    effects: String,
}

fn main() -> Result<()> {
    let Arguments { folder, seed, count, family, strength, effects } = Arguments::parse();
    fs::create_dir_all(&folder).with_context(|| format!("cannot make {}", folder.display()))?;
    let mut answers = BTreeMap::new();
    for index in 0..count {
        match Capture::new(seed, index, family, &effects, strength) {
            Ok(capture) => {
                capture.write(&folder)?;
                answers.insert(capture.name, capture.answer);
            }
            Err(error) => eprintln!("left out: {error}"),
        }
    }
    let file = folder.join("answers.json");
    fs::write(&file, serde_json::to_string_pretty(&answers)?)
        .with_context(|| format!("cannot write {}", file.display()))?;
    println!("{} pairs of captures in {}", answers.len(), folder.display());
    Ok(())
}
