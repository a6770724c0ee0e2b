//! `sheet`: the figures of a data sheet, from captures or from other people's testers' files.

mod wall;

use std::path::PathBuf;

use analysis::{curve_files, curves, mean_fit};
use clap::Args;
use comfy_table::Table;
use dynamics::Axis;
use sheet::{Detent, Figure, Sheet};

use crate::command_line::ColumnOptions;
use crate::command_line::outputs::{ResultFiles, kind, write, write_if_asked};
use crate::load;
use crate::terminal::{by_reason, digits, interval, table};

#[derive(Debug, Args)]
#[command(mut_arg("report", |report| report.requires("captures")))]
#[command(mut_arg("json", |json| json.requires("captures")))]
#[command(mut_arg("columns", |columns| columns.requires("captures")))]
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
    #[arg(long, requires = "captures", value_name = "FILE.csv")]
    pub csv: Option<PathBuf>,
    /// Write one page with the paper's five knobs and SmartKnob's default ones, for the wall
    #[arg(long, value_name = "FILE.html")]
    pub wall: Option<PathBuf>,
}

pub fn run(options: &SheetOptions) -> anyhow::Result<()> {
    if let Some(path) = &options.wall {
        write(path, kind::PAGE, &report::wall_page(&wall::page()?))?;
    }
    if options.captures.is_empty() {
        return Ok(());
    }
    let choice = options.columns.choice()?;
    let files = curve_files(&options.captures)?;
    let mut sheet = Sheet::of(&curves(&files, choice.as_ref())?)?;
    let loaded = |path: &PathBuf| load::load_measured(path, &options.columns);
    let captures = options.dynamic.iter().map(loaded).collect::<anyhow::Result<Vec<_>>>()?;
    if let Some(fit) = mean_fit(&captures)? {
        sheet = sheet.with_dynamics(&fit)?;
    }
    let page = || analysis::sheet_page(&sheet, &files);
    options.results.tell(Axis::default(), lines(&sheet, &files), &sheet, page)?;
    write_if_asked(&options.csv, kind::FIGURES, || sheet.figures_csv())
}

fn lines(sheet: &Sheet, files: &[PathBuf]) -> Vec<String> {
    let mut lines = vec![heading(sheet, files), figures(sheet).to_string()];
    let missing = sheet.in_order().filter_map(|figure| Some((figure.kind.name, figure.reason.as_deref()?)));
    lines.extend(by_reason(missing).iter().map(|reason| format!("- {reason}")));
    if !sheet.detents.is_empty() {
        lines.push(format!("\n{}", detents(sheet)));
    }
    lines
}

fn heading(sheet: &Sheet, files: &[PathBuf]) -> String {
    let name = |path: &PathBuf| path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let heading = match files {
        [only] if sheet.runs > 1 => {
            format!("{}, mean of {} presses, 95 % intervals of one more of them", name(only), sheet.runs)
        }
        [only] => format!("{}, 95 % intervals from the noise of a single curve", name(only)),
        several => {
            let folder = several[0].parent().and_then(|folder| folder.file_name());
            let of = folder.map_or_else(String::new, |folder| format!(" of {}", folder.to_string_lossy()));
            format!("mean of {} curves{of}, 95 % prediction intervals for another one", sheet.runs)
        }
    };
    operator::one_line(&heading)
}

/// The figures that have a value, with the digits that their intervals support.
fn figures(sheet: &Sheet) -> Table {
    let row = |figure: &Figure| {
        let (value, [low, high]) = (figure.value?, figure.ci95?);
        let digits = digits(high - low);
        let cells = [figure.kind.name, &format!("{value:.digits$}"), &interval(figure.ci95, digits), figure.kind.unit];
        Some(cells.map(str::to_owned))
    };
    table(["figure", "value", "95 % interval", "unit"], [1, 2], sheet.in_order().filter_map(row))
}

/// What each detent takes in each direction, in degrees, mNm and mJ; its intervals are in the JSON and on the page.
fn detents(sheet: &Sheet) -> Table {
    let degree = 1_f64.to_radians();
    let row = |detent: &Detent| {
        let cell = |name: &str, unit: f64| {
            let figure = detent.figures.get(name);
            figure.map_or_else(String::new, |figure| in_unit(figure.value, figure.ci95, unit))
        };
        [
            in_unit(detent.angle_rad, detent.angle_rad_ci95, degree),
            detent.direction.to_owned(),
            cell("detent_pitch", degree),
            cell("peak_torque", 1.0),
            cell("trough_torque", 1.0),
            cell("torque_ratio", 1.0),
            cell("detent_stiffness", 1.0),
            cell("detent_energy", 1.0),
        ]
    };
    let header = ["at °", "turning", "pitch °", "peak", "trough", "ratio", "stiffness", "energy"];
    table(header, [0, 2, 3, 4, 5, 6, 7], sheet.detents.iter().map(row))
}

/// A value in a unit with the digits that its interval supports.
fn in_unit(value: f64, [low, high]: [f64; 2], unit: f64) -> String {
    let digits = digits((high - low) / unit);
    format!("{:.digits$}", value / unit)
}
