//! The figures of many units, from captures or from a table.

use std::path::{Path, PathBuf};

use analysis::{curve_files, curves};
use anyhow::{Context as _, bail};
use clap::Args;
use foreign_files::{Column, OtherColumns, read_columns};
use sheet::{FigureKind, Limits, Sheet, Specification, kinds};

use crate::command_line::ColumnOptions;

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

/// A figure that is studied, with its limits.
pub type Studied = (&'static FigureKind, Limits);

/// One unit as one operator measured it once.
pub struct Unit {
    /// The part's folder, or its number.
    pub part: String,
    /// The operator's.
    pub operator: String,
    /// The file; `None` for a row of a table.
    pub file: Option<PathBuf>,
    pub values: Vec<Option<f64>>,
}

/// The figures that are studied.
///
/// # Errors
/// For a figure that there is not, and where none is named.
pub fn studied(options: &StudyOptions, specification: Option<&Specification>) -> anyhow::Result<Vec<Studied>> {
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

pub fn units(options: &StudyOptions, studied: &[Studied]) -> anyhow::Result<Vec<Unit>> {
    if let Some(table) = &options.values {
        return of_table(table);
    }
    let choice = options.columns.choice()?;
    let unit = |file: PathBuf| {
        let sheet = Sheet::of(&curves(std::slice::from_ref(&file), choice.as_ref())?)?;
        let values = studied.iter().map(|(kind, _)| sheet.figure(kind).and_then(|figure| figure.value)).collect();
        // A capture lies in its operator's folder, and that in its part's.
        let [operator, part] = [1, 2].map(|above| folder(&file, above));
        Ok(Unit { part, operator, file: Some(file), values })
    };
    curve_files(&options.captures)?.into_iter().map(unit).collect()
}

/// Name of the folder so many above the file.
fn folder(file: &Path, above: usize) -> String {
    let name = file.ancestors().nth(above).and_then(Path::file_name);
    name.map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
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

/// The values of each studied figure.
///
/// # Errors
/// For a unit whose curve does not tell one.
pub fn columns(units: &[Unit], studied: &[Studied]) -> anyhow::Result<Vec<(Studied, Vec<f64>)>> {
    let value = |unit: &Unit, index: usize| {
        unit.values[index].with_context(|| {
            let file = unit.file.as_ref().map(|file| file.display().to_string()).unwrap_or_default();
            format!("{file} has no {}; `haptic-camera sheet` gives the reason", studied[index].0.name)
        })
    };
    let column = |index| units.iter().map(|unit| value(unit, index)).collect::<anyhow::Result<Vec<f64>>>();
    studied.iter().enumerate().map(|(index, studied)| Ok((*studied, column(index)?))).collect()
}
