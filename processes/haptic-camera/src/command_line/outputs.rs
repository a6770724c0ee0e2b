//! The files that commands write: what each may replace, and that none is a file that the same command reads.

use std::os::unix::fs::MetadataExt as _;
use std::path::{Path, PathBuf};

use anyhow::{anyhow, bail};
use archive::whole_file::{self, Replace, write_bytes};
use clap::Args;
use dynamics::Axis;
use report::FigureNumbers;
use serde::Serialize;

use crate::outcome::{UsageError, print, show};

/// Kinds of output, each as what it may replace: an earlier output of its kind, known by a text that all of that kind contain.
pub mod kind {
    use archive::whole_file::Replace::{self, Marked, Nothing};

    pub const JSON: Replace = Marked("\"made_by\": \"haptic-camera\"");
    pub const PAGE: Replace = Marked("<meta name=\"generator\" content=\"haptic-camera\">");
    pub const FIGURES: Replace = Marked(sheet::FIGURES_HEADER);
    pub const QDAS: Replace = Marked(sheet::QDAS_REMARK);
    pub const FITTED_MODEL: Replace = Marked(" samples: residual ");
    pub const DIAGNOSED_MODEL: Replace = Marked("\ndescription = \"diagnosed from ");
    pub const COMPOSED_MODEL: Replace = Marked("\norigin = ");
    /// What is known of a rig.
    pub const CALIBRATION: Replace = Marked(loaded_capture::CALIBRATION_MARK);
    /// A model for firmware.
    pub const HEADER: Replace = Marked(" as numbers, made by haptic-camera ");
    pub const SIMULATOR: Replace = Marked(". SI units: N m, rad, s.\n");
    pub const SIMULATION: Replace = Marked("\"apparatus\": \"simulation\"");
    pub const MANUAL_PAGE: Replace = Marked(".TH haptic-camera");
    /// A diagnosis as a rerun file: the application's name, which rerun writes first.
    pub const RECORDING: Replace = Marked("haptic-camera-diagnosis");
    /// An archive or a table: nothing in it distinguishes our files from those of others, so the name must be free.
    pub const DATA: Replace = Nothing;
}

#[derive(Debug, Default)]
pub struct Files {
    inputs: Vec<PathBuf>,
    outputs: Vec<(PathBuf, Replace)>,
    pub gives_json: bool,
}

impl Files {
    pub fn reading<File: AsRef<Path>>(mut self, paths: impl IntoIterator<Item = File>) -> Self {
        self.inputs.extend(paths.into_iter().map(|path| path.as_ref().to_owned()));
        self
    }

    /// Adds a file that is written, if it was asked for, with what it may replace; a JSON file `-` is standard output and no file.
    pub fn writing<'path>(mut self, path: impl Into<Option<&'path PathBuf>>, replace: Replace) -> Self {
        let Some(path) = path.into() else { return self };
        if path == "-" && replace == kind::JSON {
            self.gives_json = true;
        } else {
            self.outputs.push((path.clone(), replace));
        }
        self
    }

    /// Adds the JSON file and the page of a result, each if it was asked for.
    pub fn telling(self, results: &ResultFiles) -> Self {
        self.writing(&results.json, kind::JSON).writing(&results.report, kind::PAGE)
    }

    /// Refuses outputs that would destroy something, before any work is done.
    ///
    /// # Errors
    /// [`UsageError`] for an output that is an input, under whatever name, or another output; otherwise what
    /// [`whole_file::check`] says.
    pub fn check(&self) -> anyhow::Result<()> {
        for (index, (path, replace)) in self.outputs.iter().enumerate() {
            let shown = path.display();
            if self.inputs.iter().any(|input| is_same(path, input)) {
                bail!(UsageError(anyhow!("{shown} is also an input; name another file to write to")));
            }
            if self.outputs[..index].iter().any(|(other, _)| is_same(path, other)) {
                bail!(UsageError(anyhow!("{shown} would be written twice; name a different file for each output")));
            }
            whole_file::check(path, *replace)?;
        }
        Ok(())
    }
}

/// Whether two paths lead to one regular file, which may exist or be still to be written.
pub fn is_same(one: &Path, other: &Path) -> bool {
    match (one.metadata(), other.metadata()) {
        (Ok(one), Ok(other)) => one.is_file() && (one.dev(), one.ino()) == (other.dev(), other.ino()),
        (Err(_), Err(_)) if one.file_name() == other.file_name() => {
            let folders = [one, other].map(|path| whole_file::folder_of(path).canonicalize());
            matches!(folders, [Ok(one), Ok(other)] if one == other)
        }
        _ => false,
    }
}

/// Where a result goes beside the terminal.
#[derive(Clone, Debug, Default, Args)]
pub struct ResultFiles {
    /// Write the result as JSON; `-` for standard output
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Write the report page
    #[arg(long, value_name = "FILE.html")]
    pub report: Option<PathBuf>,
}

impl ResultFiles {
    /// Prints a result, unless standard output is for its JSON, and writes what was asked for; all in the words of its axis.
    pub fn tell<Line: ToString>(
        &self,
        axis: Axis,
        lines: impl IntoIterator<Item = Line>,
        result: &impl Serialize,
        page: impl FnOnce() -> String,
    ) -> anyhow::Result<()> {
        show_on(axis, lines);
        self.write(axis, || (page(), FigureNumbers::new()), |_| result)
    }

    /// Writes what was asked for; with a page, the result also holds the numbers in the captions of its figures.
    pub fn write<Content: Serialize>(
        &self,
        axis: Axis,
        page: impl FnOnce() -> (String, FigureNumbers),
        result: impl FnOnce(FigureNumbers) -> Content,
    ) -> anyhow::Result<()> {
        let (page, figures) = self.report.as_ref().map(|_| page()).unwrap_or_default();
        write_json(axis, &self.json, &result(figures))?;
        write_if_asked(&self.report, kind::PAGE, || axis.words(&page).into_owned())
    }
}

/// Prints a result line by line in the words of an axis, unless standard output is reserved for it as JSON.
pub fn show_on<Line: ToString>(axis: Axis, lines: impl IntoIterator<Item = Line>) {
    show(lines.into_iter().map(|line| axis.words(&line.to_string()).into_owned()));
}

/// Writes a result as JSON in the names and units of its axis, if it was asked for: to a file, or to standard output for `-`.
pub fn write_json(axis: Axis, path: &Option<PathBuf>, result: &impl Serialize) -> anyhow::Result<()> {
    let Some(path) = path else { return Ok(()) };
    let text = analysis::to_json_on(axis, result)?;
    if path == "-" {
        print(&operator::visible(&text));
        return Ok(());
    }
    write(path, kind::JSON, &(text + "\n"))
}

/// Writes a text file, whole or not at all, and replaces only what `replace` permits.
pub fn write(path: &Path, replace: Replace, text: &str) -> anyhow::Result<()> {
    Ok(write_bytes(path, replace, text.as_bytes())?)
}

pub fn write_if_asked(path: &Option<PathBuf>, replace: Replace, text: impl FnOnce() -> String) -> anyhow::Result<()> {
    path.as_ref().map_or(Ok(()), |path| write(path, replace, &text()))
}
