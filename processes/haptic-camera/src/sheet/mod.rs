//! `sheet`: the figures of a data sheet, from captures or from other people's testers' files.

mod table;
mod wall;

use std::fmt::Write as _;
use std::path::PathBuf;

use analysis::{curve_files, curves, mean_fit};
use clap::Args;
use dynamics::Axis;
use sheet::Sheet;

use crate::command_line::ColumnOptions;
use crate::load;
use crate::outcome::Outcome;
use crate::outputs::{FIGURES_HEADER, ResultFiles, kind, write, write_if_asked};

#[derive(Debug, Args)]
#[command(mut_arg("report", |report| report.requires("captures")))]
pub struct SheetOptions {
    /// Captures or testers' files of one part, or a folder of them; several are averaged
    #[arg(required_unless_present = "wall", value_name = "CAPTURE")]
    pub captures: Vec<PathBuf>,
    /// A capture of the same part at speed, for inertia, viscous friction and breakaway; give it again for further ones
    #[arg(long, requires = "captures", value_name = "CAPTURE")]
    pub dynamic: Vec<PathBuf>,
    #[command(flatten)]
    pub columns: ColumnOptions,
    #[command(flatten)]
    pub results: ResultFiles,
    /// Write the figures as a table
    #[arg(long, value_name = "FILE.csv")]
    pub csv: Option<PathBuf>,
    /// Write one page with the paper's five knobs and SmartKnob's default ones, for the wall
    #[arg(long, value_name = "FILE.html")]
    pub wall: Option<PathBuf>,
}

pub fn run(options: &SheetOptions) -> anyhow::Result<Outcome> {
    if let Some(path) = &options.wall {
        write(path, kind::PAGE, &report::wall_page(&wall::page()?))?;
    }
    if options.captures.is_empty() {
        return Ok(Outcome::Done);
    }
    let choice = options.columns.choice()?;
    let files = curve_files(&options.captures)?;
    let mut sheet = Sheet::of(&curves(&files, choice.as_ref())?)?;
    let loaded = |path: &PathBuf| load::load_measured(path, &options.columns);
    let captures = options.dynamic.iter().map(loaded).collect::<anyhow::Result<Vec<_>>>()?;
    if let Some(fit) = mean_fit(&captures)? {
        sheet = sheet.with_dynamics(&fit)?;
    }
    options
        .results
        .tell(Axis::default(), table::lines(&sheet, &files), &sheet, || analysis::sheet_page(&sheet, &files))?;
    write_if_asked(&options.csv, kind::FIGURES, || figures_csv(&sheet))?;
    Ok(Outcome::Done)
}

/// One row a figure; after those of the whole control, those of each detent with its angle and direction.
fn figures_csv(sheet: &Sheet) -> String {
    let mut text = FIGURES_HEADER.to_owned();
    let number = |value: Option<f64>| value.map_or_else(String::new, |value| value.to_string());
    // Writing to a string does not fail.
    for figure in sheet.in_order() {
        let kind = figure.kind;
        let [low, high] = [0, 1].map(|end| number(figure.ci95.map(|ends| ends[end])));
        let definition = kind.definition.replace('"', "\"\"");
        let _ = writeln!(text, "{},,,{},{},{low},{high},\"{definition}\"", kind.name, number(figure.value), kind.unit);
    }
    for detent in &sheet.detents {
        for (name, figure) in &detent.figures {
            let [low, high] = figure.ci95;
            let (angle, direction) = (detent.angle_rad, detent.direction);
            let _ = writeln!(text, "{name},{angle},{direction},{},{},{low},{high},", figure.value, figure.unit);
        }
    }
    text
}
