//! `judge`: whether units are as their specification says.

use std::path::Path;

use anyhow::Context as _;
use report::{JudgedUnit, VerdictsPage};
use serde::Serialize;
use sheet::{Judgement, Sheet, Specification, Verdict};

use crate::command_line::JudgeOptions;
use crate::outcome::{Outcome, say};
use crate::outputs::{Kind, to_output, write, write_json};
use crate::sheet::{curves, files_of};

/// The verdict on one unit.
#[derive(Debug, Serialize)]
struct Judged {
    unit: String,
    #[serde(flatten)]
    judgement: Judgement,
}

/// What `judge --json` writes.
#[derive(Debug, Serialize)]
struct Judgements {
    /// The worst of all units.
    verdict: Verdict,
    risk: f64,
    units: Vec<Judged>,
}

/// Reads the specification, judges each unit, and writes what was asked for.
///
/// # Errors
/// One sentence on what is wrong with a file.
pub fn run(options: &JudgeOptions) -> anyhow::Result<Outcome> {
    let specification = load(&options.spec)?;
    let choice = options.table.choice()?;
    let mut units = Vec::new();
    for unit in &options.captures {
        let files = files_of(std::slice::from_ref(unit))?;
        let sheet = Sheet::of(&curves(&files, choice.as_ref())?)?;
        let judged = Judged { unit: name(unit), judgement: specification.judge(&sheet) };
        if !to_output(options.json.as_deref()) {
            say(line(&judged));
        }
        units.push(judged);
    }
    let verdict = units.iter().map(|unit| unit.judgement.verdict).max().unwrap_or(Verdict::Pass);
    if let Some(path) = &options.report {
        let judged =
            units.iter().map(|judged| JudgedUnit { unit: judged.unit.clone(), judgement: judged.judgement.clone() });
        let page = VerdictsPage {
            name: operator::one_line(&specification.name),
            risk: specification.risk,
            units: judged.collect(),
            software_version: env!("CARGO_PKG_VERSION").to_owned(),
        };
        write(path, Kind::Page, &report::verdicts_page(&page))?;
    }
    write_json(options.json.as_deref(), &Judgements { verdict, risk: specification.risk, units })?;
    Ok(outcome(verdict))
}

/// What a verdict makes of a command.
pub fn outcome(verdict: Verdict) -> Outcome {
    match verdict {
        Verdict::Pass => Outcome::Done,
        Verdict::Undecided => Outcome::Undecided,
        Verdict::Fail => Outcome::OutOfSpecification,
    }
}

/// Reads a specification.
///
/// # Errors
/// One sentence that names the file.
pub fn load(path: &Path) -> anyhow::Result<Specification> {
    let text = foreign_files::read_text(path).with_context(|| format!("{} cannot be read", path.display()))?;
    Specification::from_toml(&text).with_context(|| format!("{} is no specification", path.display()))
}

fn name(unit: &Path) -> String {
    operator::one_line(&unit.file_name().map_or_else(|| unit.to_string_lossy(), |name| name.to_string_lossy()))
}

fn line(Judged { unit, judgement }: &Judged) -> String {
    let reasons = judgement.reasons.join("; ");
    let colon = if reasons.is_empty() { "" } else { ": " };
    format!("{:9}  {unit}{colon}{reasons}", judgement.verdict.word())
}
