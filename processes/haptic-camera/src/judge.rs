//! `judge`: whether units are as their specification says.

use analysis::{Judgements, curve_files, curves, judged, load_specification};
use report::JudgedUnit;
use sheet::{Sheet, Verdict};

use crate::command_line::JudgeOptions;
use crate::outcome::{Outcome, say};
use crate::outputs::{Kind, to_output, write, write_json};

/// Reads the specification, judges each unit, and writes what was asked for.
///
/// # Errors
/// One sentence on what is wrong with a file.
pub fn run(options: &JudgeOptions) -> anyhow::Result<Outcome> {
    let specification = load_specification(&options.spec)?;
    let choice = options.columns.choice()?;
    let mut units = Vec::new();
    for unit in &options.captures {
        let files = curve_files(std::slice::from_ref(unit))?;
        let sheet = Sheet::of(&curves(&files, choice.as_ref())?)?;
        let judged = judged(unit, &specification, &sheet);
        if !to_output(options.json.as_deref()) {
            say(line(&judged));
        }
        units.push(judged);
    }
    let judgements = Judgements::of(&specification, units);
    if let Some(path) = &options.report {
        write(path, Kind::Page, &judgements.page())?;
    }
    write_json(options.json.as_deref(), &judgements)?;
    Ok(outcome(judgements.verdict))
}

/// What a verdict makes of a command.
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
