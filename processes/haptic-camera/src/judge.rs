//! `judge`: whether units are as their specification says.

use std::path::PathBuf;

use analysis::{Judgements, curve_files, curves, judged, load_specification};
use clap::Args;
use dynamics::Axis;
use report::JudgedUnit;
use sheet::{Sheet, Verdict};

use crate::command_line::ColumnOptions;
use crate::command_line::outputs::ResultFiles;
use crate::outcome::{Outcome, show};

#[derive(Debug, Args)]
pub struct JudgeOptions {
    /// Units: for each a capture, a tester's file, or a folder of repeated captures
    #[arg(required = true, value_name = "CAPTURE")]
    pub captures: Vec<PathBuf>,
    /// Limits on the figures and an envelope for the curve
    #[arg(long, value_name = "SPEC.toml")]
    pub spec: PathBuf,
    #[command(flatten)]
    pub columns: ColumnOptions,
    #[command(flatten)]
    pub results: ResultFiles,
}

pub fn run(options: &JudgeOptions) -> anyhow::Result<Outcome> {
    let specification = load_specification(&options.spec)?;
    let choice = options.columns.choice()?;
    let mut units = Vec::new();
    for unit in &options.captures {
        let files = curve_files(std::slice::from_ref(unit))?;
        let sheet = Sheet::of(&curves(&files, choice.as_ref())?)?;
        let judged = judged(unit, &specification, &sheet);
        show([line(&judged)]);
        units.push(judged);
    }
    let judgements = Judgements::of(&specification, units);
    // Every unit was told as soon as it was judged.
    options.results.tell(Axis::default(), None::<&str>, &judgements, || judgements.page())?;
    Ok(outcome(judgements.verdict))
}

pub fn outcome(verdict: Verdict) -> Outcome {
    match verdict {
        Verdict::Pass => Outcome::Done,
        Verdict::Undecided => Outcome::Undecided,
        Verdict::Fail => Outcome::OutOfSpecification,
    }
}

fn line(JudgedUnit { unit, judgement }: &JudgedUnit) -> String {
    let reasons = judgement.reasons.join("; ");
    let colon = if reasons.is_empty() { "" } else { ": " };
    format!("{:9}  {unit}{colon}{reasons}", judgement.verdict.word())
}
