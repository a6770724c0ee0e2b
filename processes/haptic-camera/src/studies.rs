//! `capability` and `gauge`: what the figures of many units tell of a process, and of a tester.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use analysis::{curve_files, curves, load_specification};
use anyhow::{Context as _, bail};
use clap::Args;
use comfy_table::Table;
use dynamics::Axis;
use foreign_files::{Column, OtherColumns, read_columns};
use sheet::{Capability, Design, FigureKind, Gauge, Index, Limits, QdasRow, Sheet, Specification, kinds};

use crate::command_line::ColumnOptions;
use crate::outcome::show;
use crate::outputs::{kind, write_if_asked, write_json};
use crate::terminal;

#[derive(Debug, Args)]
pub struct StudyOptions {
    /// Captures or testers' files
    #[arg(required_unless_present = "values", value_name = "CAPTURE")]
    pub captures: Vec<PathBuf>,
    /// A table of values instead of captures, with the columns part, operator (numbers) and value; needs --figure
    #[arg(long, value_name = "FILE.csv", conflicts_with = "captures", requires = "figure")]
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

/// Whether a process keeps its units within their limits.
pub fn run_capability(options: &CapabilityOptions) -> anyhow::Result<()> {
    let specification = load_specification(&options.spec)?;
    let Study { figures, units } = &Study::of(&options.study, Some(&specification))?;
    let results = each(figures, units, |kind, limits, values| {
        Capability::of(values, options.subgroup, limits).context(kind.name)
    })?;
    show([table(&results)]);
    write_json(Axis::default(), &options.study.json, &results)?;
    write_if_asked(&options.dfq, kind::QDAS, || {
        let row = |unit: &Unit| QdasRow { measured_at: measured_at(unit.file.as_deref()), values: unit.values.clone() };
        let rows: Vec<QdasRow> = units.iter().map(row).collect();
        sheet::qdas(&specification.name, figures, &rows)
    })
}

/// Whether a tester is good enough to tell the units apart.
pub fn run_gauge(options: &GaugeOptions) -> anyhow::Result<()> {
    let specification = options.spec.as_deref().map(load_specification).transpose()?;
    let Study { figures, units } = &Study::of(&options.study, specification.as_ref())?;
    let design = if options.nested { Design::Nested } else { Design::Crossed };
    let results = each(figures, units, |kind, limits, values| {
        let values = by_operator(units, values, design)?;
        let tolerance = limits.min.zip(limits.max).map(|(min, max)| max - min);
        Gauge::of(&values, design, tolerance).context(kind.name)
    })?;
    show(results.iter().map(|(name, gauge)| words(name, gauge)));
    write_json(Axis::default(), &options.study.json, &results)
}

/// A figure with its limits.
type Studied = (&'static FigureKind, Limits);

/// The figures that are studied, and the units.
struct Study {
    figures: Vec<Studied>,
    units: Vec<Unit>,
}

/// One unit as one operator measured it once.
struct Unit {
    /// The part's folder, or its number.
    part: String,
    /// The operator's.
    operator: String,
    /// The file; `None` for a row of a table.
    file: Option<PathBuf>,
    values: Vec<Option<f64>>,
}

impl Study {
    fn of(options: &StudyOptions, specification: Option<&Specification>) -> anyhow::Result<Self> {
        let figures = studied(options, specification)?;
        Ok(Self { units: units(options, &figures)?, figures })
    }
}

/// The figure that is named, or those that the specification limits.
fn studied(options: &StudyOptions, specification: Option<&Specification>) -> anyhow::Result<Vec<Studied>> {
    let limited = specification.map(Specification::limits).unwrap_or_default();
    let Some(name) = &options.figure else {
        if limited.is_empty() {
            bail!("no figure to study; name one, as in --figure collapse_force, or give limits with --spec");
        }
        return Ok(limited.to_vec());
    };
    if let Some(known) = limited.iter().find(|(kind, _)| kind.name == *name) {
        return Ok(vec![*known]);
    }
    let kind = kinds().find(|kind| kind.name == *name).with_context(|| {
        let known: Vec<&str> = kinds().map(|kind| kind.name).collect();
        format!("`{name}` is not a figure; known are {}", known.join(", "))
    })?;
    Ok(vec![(kind, Limits::default())])
}

fn units(options: &StudyOptions, studied: &[Studied]) -> anyhow::Result<Vec<Unit>> {
    if let Some(table) = &options.values {
        return of_table(table);
    }
    let choice = options.columns.choice()?;
    let unit = |file: PathBuf| {
        let sheet = Sheet::of(&curves(std::slice::from_ref(&file), choice.as_ref())?)?;
        let values = studied.iter().map(|(kind, _)| sheet.figure(kind).and_then(|figure| figure.value)).collect();
        // A capture lies in its operator's folder, and that in its part's.
        let [operator, part] = [1, 2].map(|above| {
            let name = file.ancestors().nth(above).and_then(Path::file_name);
            name.map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
        });
        Ok(Unit { part, operator, file: Some(file), values })
    };
    curve_files(&options.captures)?.into_iter().map(unit).collect()
}

fn of_table(table: &Path) -> anyhow::Result<Vec<Unit>> {
    let file = foreign_files::open(table).with_context(|| format!("{} cannot be read", table.display()))?;
    let wanted = [Column::required("value"), Column::optional("part"), Column::optional("operator")];
    let [values, parts, operators] =
        read_columns(file, wanted, OtherColumns::Ignored).with_context(|| table.display().to_string())?;
    let values = values.unwrap_or_default();
    let label = |column: &Option<Vec<f64>>, row: usize| {
        column.as_ref().and_then(|column| column.get(row)).map(f64::to_string).unwrap_or_default()
    };
    let unit = |(row, value): (usize, &f64)| Unit {
        part: label(&parts, row),
        operator: label(&operators, row),
        file: None,
        values: vec![Some(*value)],
    };
    Ok(values.iter().enumerate().map(unit).collect())
}

/// What the values of each figure tell; an error names a unit whose curve does not tell one.
fn each<T>(
    figures: &[Studied],
    units: &[Unit],
    of: impl Fn(&FigureKind, Limits, &[f64]) -> anyhow::Result<T>,
) -> anyhow::Result<BTreeMap<&'static str, T>> {
    let value = |unit: &Unit, index: usize| {
        unit.values[index].with_context(|| {
            let file = unit.file.as_ref().map(|file| file.display().to_string()).unwrap_or_default();
            format!("{file} has no {}; `haptic-camera sheet` gives the reason", figures[index].0.name)
        })
    };
    let column = |index| units.iter().map(|unit| value(unit, index)).collect::<anyhow::Result<Vec<f64>>>();
    let columns = (0..figures.len()).map(column).collect::<anyhow::Result<Vec<_>>>()?;
    figures.iter().zip(&columns).map(|((kind, limits), values)| Ok((kind.name, of(kind, *limits, values)?))).collect()
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

/// %GRR up to which a gauge is good, and up to which it may do (AIAG, Measurement Systems Analysis, 4th edition).
const GOOD_PERCENT: f64 = 10.0;
const MAY_DO_PERCENT: f64 = 30.0;
/// Fewest categories of parts that a gauge should tell apart (AIAG).
const CATEGORIES: u64 = 5;

fn by_operator(units: &[Unit], values: &[f64], design: Design) -> anyhow::Result<Vec<Vec<Vec<f64>>>> {
    if units.iter().any(|unit| unit.part.is_empty() || unit.operator.is_empty()) {
        bail!(
            "a gauge study needs the part and operator of each value: captures in folders PART/OPERATOR/, or a table \
             with both columns"
        );
    }
    let mut sorted: BTreeMap<&str, BTreeMap<&str, Vec<f64>>> = BTreeMap::new();
    for (unit, value) in units.iter().zip(values) {
        sorted.entry(&unit.operator).or_default().entry(&unit.part).or_default().push(*value);
    }
    let mut parts = sorted.values().map(|parts| parts.keys().collect::<Vec<_>>());
    let first = parts.next();
    if design == Design::Crossed && parts.any(|parts| Some(parts) != first) {
        bail!("the operators did not measure the same parts; give --nested if each measured different parts");
    }
    Ok(sorted.into_values().map(|parts| parts.into_values().collect()).collect())
}

fn words(name: &str, gauge: &Gauge) -> String {
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
    format!(
        "{name}: %GRR {grr_percent:.1} %{tolerance}: {band}; {categories}\n  \
         {operators} operators, {parts} parts, {trials} trials; deviations: repeatability {}, operators {}, interaction {}, parts {}",
        deviation(gauge.repeatability_variance),
        deviation(gauge.operator_variance),
        deviation(gauge.interaction_variance),
        deviation(gauge.part_variance)
    )
}
