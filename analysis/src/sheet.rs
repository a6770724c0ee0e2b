//! Data sheets and verdicts, and what `judge --json` tells of them.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use archive::testers::{ColumnChoice, Curve};
use foreign_files::one_line;
use report::{JudgedUnit, SheetPage, VerdictsPage};
use serde::Serialize;
use sheet::{Sheet, Specification, Verdict};

use crate::{AnalysisError, MADE_BY};

/// Endings of the files that a folder is read for.
const ENDINGS: [&str; 5] = ["csv", "json", "mcap", "mf4", "txt"];

/// The given files, and in place of a folder the captures in it, by name.
///
/// # Errors
/// For a folder that cannot be read, or that holds none.
pub fn curve_files(given: &[PathBuf]) -> Result<Vec<PathBuf>, AnalysisError> {
    let mut files = Vec::new();
    for path in given {
        if path.is_dir() { files.extend(files_in(path)?) } else { files.push(path.clone()) }
    }
    Ok(files)
}

/// The captures of a folder, by name: neither results of this program, nor a table beside an archive of the same name.
fn files_in(folder: &Path) -> Result<Vec<PathBuf>, AnalysisError> {
    let unreadable = |error| AnalysisError::Unreadable { path: folder.to_owned(), error };
    let entries = std::fs::read_dir(folder).map_err(unreadable)?;
    let paths: Result<Vec<PathBuf>, std::io::Error> = entries.map(|entry| Ok(entry?.path())).collect();
    let mut paths = paths.map_err(unreadable)?;
    paths.retain(|path| ENDINGS.iter().any(|ending| ends_in(path, ending)) && !is_result(path));
    leave_exports_out(&mut paths, |path| path);
    paths.sort();
    if paths.is_empty() {
        return Err(AnalysisError::NoCaptures { folder: folder.to_owned(), endings: ENDINGS.join(", .") });
    }
    Ok(paths)
}

/// Leaves out the tables that lie beside an archive of the same name: they were exported from it.
pub fn leave_exports_out<File>(files: &mut Vec<File>, path: impl Fn(&File) -> &Path) {
    let archives = files.iter().map(&path).filter(|path| ends_in(path, "mcap"));
    let archives: HashSet<PathBuf> = archives.map(|path| path.with_extension("")).collect();
    files.retain(|file| !ends_in(path(file), "csv") || !archives.contains(&path(file).with_extension("")));
}

/// Whether a path has this ending, in capital or small letters.
#[must_use]
pub fn ends_in(path: &Path, ending: &str) -> bool {
    path.extension().is_some_and(|found| found.eq_ignore_ascii_case(ending))
}

/// Whether a file is a result of this program as JSON, and no tester's.
fn is_result(path: &Path) -> bool {
    let mark = format!("\"made_by\": \"{MADE_BY}\"");
    ends_in(path, "json") && foreign_files::read_text(path).is_ok_and(|text| text.contains(&mark))
}

/// The curve of each file.
///
/// # Errors
/// One sentence on what is wrong with a file.
pub fn curves(files: &[PathBuf], choice: Option<&ColumnChoice>) -> Result<Vec<Curve>, AnalysisError> {
    files.iter().map(|file| Ok(loaded_capture::load_curve(file, choice)?)).collect()
}

/// The page of a sheet that was made of these files.
#[must_use]
pub fn sheet_page(sheet: &Sheet, files: &[PathBuf]) -> String {
    let folder = files.first().filter(|_| files.len() > 1).and_then(|file| file.parent());
    report::sheet_page(&SheetPage {
        sheet,
        title: folder.or(files.first().map(PathBuf::as_path)).map(last_name).unwrap_or_default(),
        sources: files.iter().map(|file| last_name(file)).collect(),
        software_version: env!("CARGO_PKG_VERSION").to_owned(),
    })
}

/// Reads a specification.
///
/// # Errors
/// One sentence that names the file.
pub fn load_specification(path: &Path) -> Result<Specification, AnalysisError> {
    let text =
        foreign_files::read_text(path).map_err(|error| AnalysisError::Unreadable { path: path.to_owned(), error })?;
    Specification::from_toml(&text).map_err(|error| AnalysisError::Specification { path: path.to_owned(), error })
}

/// The verdicts on units, as `judge --json` tells them.
#[derive(Clone, Debug, Serialize)]
pub struct Judgements {
    /// The worst of all units.
    pub verdict: Verdict,
    /// Largest risk of a wrong verdict.
    pub risk: f64,
    /// The units in the order in which they were given.
    pub units: Vec<JudgedUnit>,
    /// What the specification is of.
    #[serde(skip)]
    name: String,
}

impl Judgements {
    /// The verdicts on units that were judged by a specification.
    #[must_use]
    pub fn of(specification: &Specification, units: Vec<JudgedUnit>) -> Self {
        let verdict = units.iter().map(|unit| unit.judgement.verdict).max().unwrap_or(Verdict::Pass);
        Self { verdict, risk: specification.risk, units, name: one_line(&specification.name) }
    }

    /// The report page.
    #[must_use]
    pub fn page(&self) -> String {
        report::verdicts_page(&VerdictsPage {
            name: &self.name,
            risk: self.risk,
            units: &self.units,
            software_version: env!("CARGO_PKG_VERSION"),
        })
    }
}

/// A unit, by the name of its file or folder, with its verdict.
#[must_use]
pub fn judged(unit: &Path, specification: &Specification, sheet: &Sheet) -> JudgedUnit {
    JudgedUnit { unit: last_name(unit), judgement: specification.judge(sheet) }
}

/// The last part of a path; of one that has none, all of it.
fn last_name(path: &Path) -> String {
    one_line(&path.file_name().map_or_else(|| path.to_string_lossy(), |name| name.to_string_lossy()))
}
