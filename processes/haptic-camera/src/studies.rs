//! `capability` and `gauge`: what the figures of many units tell of a process, and of a tester.

use std::collections::BTreeMap;
use std::path::PathBuf;

use analysis::{Study, StudyError, load_specification};
use clap::Args;
use comfy_table::Table;
use dynamics::Axis;
use sheet::{Capability, Design, Gauge, Index, Specification};

use crate::command_line::ColumnOptions;
use crate::command_line::outputs::{kind, write_if_asked, write_json};
use crate::outcome::{show, with_options};
use crate::terminal;

#[derive(Debug, Args)]
pub struct StudyOptions {
    /// Captures or testers' files
    #[arg(required_unless_present = "values", value_name = "CAPTURE")]
    pub captures: Vec<PathBuf>,
    /// A table of values instead of captures, with the columns part, operator and value; needs --figure
    #[arg(long, value_name = "FILE.csv", conflicts_with_all = ["captures", "columns"], requires = "figure")]
    pub values: Option<PathBuf>,
    /// The figure to study, such as collapse_force [default: those that the specification limits]
    #[arg(long, value_name = "NAME")]
    pub figure: Option<String>,
    #[command(flatten)]
    pub columns: ColumnOptions,
    /// Write the study as JSON; `-` for standard output
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
}

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

#[derive(Debug, Args)]
pub struct GaugeOptions {
    #[command(flatten)]
    pub study: StudyOptions,
    /// Limits on the figures, for %GRR of the tolerance
    #[arg(long, value_name = "SPEC.toml")]
    pub spec: Option<PathBuf>,
    /// Every operator measured different parts
    #[arg(long)]
    pub nested: bool,
}

pub fn run_capability(options: &CapabilityOptions) -> anyhow::Result<()> {
    let specification = load_specification(&options.spec)?;
    let study = study(&options.study, Some(&specification))?;
    let results = study.capability(options.subgroup)?;
    show([table(&results)]);
    write_json(Axis::default(), &options.study.json, &results)?;
    write_if_asked(&options.dfq, kind::QDAS, || study.qdas(&specification.name))
}

pub fn run_gauge(options: &GaugeOptions) -> anyhow::Result<()> {
    let specification = options.spec.as_deref().map(load_specification).transpose()?;
    let design = if options.nested { Design::Nested } else { Design::Crossed };
    let results = study(&options.study, specification.as_ref())?.gauge(design).map_err(with_its_options)?;
    show(results.iter().flat_map(|(name, gauge)| words(name, gauge)));
    write_json(Axis::default(), &options.study.json, &results)
}

fn study(options: &StudyOptions, specification: Option<&Specification>) -> anyhow::Result<Study> {
    let figure = options.figure.as_deref();
    let study = match &options.values {
        Some(table) => Study::of_table(table, figure, specification),
        None => Study::of_captures(&options.captures, options.columns.choice()?.as_ref(), figure, specification),
    };
    study.map_err(with_its_options)
}

fn with_its_options(error: StudyError) -> anyhow::Error {
    match error {
        StudyError::NoFigure => with_options(error, "--figure, --spec"),
        StudyError::OtherParts => with_options(error, "--nested"),
        _ => error.into(),
    }
}

fn table(results: &BTreeMap<&'static str, Capability>) -> Table {
    let index = |index: &Index| format!("{:.2} ({:.2} to {:.2})", index.value, index.ci95[0], index.ci95[1]);
    let or_dash = |of: &Option<Index>| of.as_ref().map_or_else(|| "–".to_owned(), index);
    let rows = results.iter().map(|(name, Capability { number, cp, cpk, pp, ppk, .. })| {
        [(*name).to_owned(), number.to_string(), or_dash(cp), index(cpk), or_dash(pp), index(ppk)]
    });
    terminal::table(["figure", "units", "Cp", "Cpk", "Pp", "Ppk"], 1..6, rows)
}

/// %GRR up to which a gauge is good, and up to which it may do (AIAG, Measurement Systems Analysis, 4th edition).
const GOOD_PERCENT: f64 = 10.0;
const MAY_DO_PERCENT: f64 = 30.0;
/// Fewest categories of parts that a gauge should tell apart (AIAG).
const CATEGORIES: u64 = 5;

fn words(name: &str, gauge: &Gauge) -> [String; 2] {
    let Gauge { parts, operators, trials, grr_percent, grr_tolerance_percent, ndc, .. } = gauge;
    let deviation = |variance: f64| format!("{:.3e}", variance.sqrt());
    let band = match grr_percent {
        percent if *percent <= GOOD_PERCENT => "good",
        percent if *percent <= MAY_DO_PERCENT => "may do",
        _ => "not good enough",
    };
    let categories = match ndc {
        Some(ndc) if *ndc < CATEGORIES => format!("ndc {ndc}, fewer than the {CATEGORIES} required"),
        Some(ndc) => format!("ndc {ndc}"),
        None => "ndc is undefined: the gauge has no variance".to_owned(),
    };
    let tolerance =
        grr_tolerance_percent.map_or_else(String::new, |percent| format!(", {percent:.1} % of the tolerance"));
    [
        format!("{name}: %GRR {grr_percent:.1} %{tolerance}: {band}; {categories}"),
        format!(
            "  {operators} operators, {parts} parts, {trials} trials; deviations: repeatability {}, operators {}, \
             interaction {}, parts {}",
            deviation(gauge.repeatability_variance),
            deviation(gauge.operator_variance),
            deviation(gauge.interaction_variance),
            deviation(gauge.part_variance)
        ),
    ]
}
