//! `capability`: whether a process keeps its units within their limits.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use analysis::load_specification;
use anyhow::Context as _;
use clap::Args;
use comfy_table::Table;
use dynamics::Axis;
use sheet::{Capability, Index, QdasRow};

use super::values::{StudyOptions, Unit, columns, studied, units};
use crate::outcome::{Outcome, show};
use crate::outputs::{kind, write_if_asked, write_json};
use crate::terminal;

#[derive(Debug, Args)]
pub struct CapabilityOptions {
    #[command(flatten)]
    pub study: StudyOptions,
    /// Limits on the figures
    #[arg(long, value_name = "SPEC.toml")]
    pub spec: PathBuf,
    /// Consecutive units in a subgroup; 1 for single units
    #[arg(long, default_value_t = 1, value_name = "N")]
    pub subgroup: usize,
    /// Write the figures as a Q-DAS file
    #[arg(long, value_name = "FILE.dfq")]
    pub dfq: Option<PathBuf>,
}

pub fn run(options: &CapabilityOptions) -> anyhow::Result<Outcome> {
    let specification = load_specification(&options.spec)?;
    let studied = studied(&options.study, Some(&specification))?;
    let units = units(&options.study, &studied)?;
    let mut results = BTreeMap::new();
    for ((kind, limits), values) in columns(&units, &studied)? {
        results.insert(kind.name, Capability::of(&values, options.subgroup, limits).context(kind.name)?);
    }
    show([table(&results)]);
    write_json(Axis::default(), &options.study.json, &results)?;
    write_if_asked(&options.dfq, kind::QDAS, || {
        let row = |unit: &Unit| QdasRow { measured_at: measured_at(unit.file.as_deref()), values: unit.values.clone() };
        let rows: Vec<QdasRow> = units.iter().map(row).collect();
        sheet::qdas(&specification.name, &studied, &rows)
    })?;
    Ok(Outcome::Done)
}

/// When a file was written, else now.
fn measured_at(file: Option<&Path>) -> String {
    let written = file.and_then(|file| file.metadata().ok()?.modified().ok());
    let at = written.and_then(|at| jiff::Timestamp::try_from(at).ok()).unwrap_or_else(jiff::Timestamp::now);
    at.to_zoned(jiff::tz::TimeZone::system()).strftime("%d.%m.%Y/%H:%M:%S").to_string()
}

fn table(results: &BTreeMap<&'static str, Capability>) -> Table {
    let index = |index: &Index| format!("{:.2} ({:.2} to {:.2})", index.value, index.ci95[0], index.ci95[1]);
    let or_dash = |of: &Option<Index>| of.as_ref().map_or_else(|| "–".to_owned(), index);
    let rows = results.iter().map(|(name, Capability { number, cp, cpk, pp, ppk, .. })| {
        [(*name).to_owned(), number.to_string(), or_dash(cp), index(cpk), or_dash(pp), index(ppk)]
    });
    terminal::table(["figure", "units", "Cp", "Cpk", "Pp", "Ppk"], 1..6, rows)
}
