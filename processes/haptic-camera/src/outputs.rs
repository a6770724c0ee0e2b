//! The files that commands write: what each may replace, and none of them a file that the same call reads.

use std::os::unix::fs::MetadataExt as _;
use std::path::{Path, PathBuf};

use anyhow::{anyhow, bail};
use archive::whole_file::{self, Replace, write_bytes};
use dynamics::Axis;
use loaded_capture::CALIBRATION_MARK;
use serde::Serialize;

use crate::outcome::{UsageError, print_json};

/// What an output is, and so what it may replace: an earlier one of its kind, known by words that every one has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A result as JSON.
    Json,
    /// A report page.
    Page,
    /// The figures of a data sheet as a table.
    Figures,
    /// Figures of many units as a Q-DAS file.
    Qdas,
    /// A model that was fitted.
    FittedModel,
    /// A model with what a diagnosis found.
    DiagnosedModel,
    /// A model that was composed.
    ComposedModel,
    /// What is known of a rig.
    Calibration,
    /// A model for firmware.
    Header,
    /// A model for a simulator.
    Simulator,
    /// A capture that was simulated.
    Simulation,
    /// A manual page.
    ManualPage,
    /// A diagnosis as a rerun file.
    Recording,
    /// An archive or a table, in which nothing tells ours from others': the name must be free.
    Data,
}

impl Kind {
    /// What such a file may replace.
    pub fn replaces(self) -> Replace {
        match self {
            Self::Json => Replace::Marked("\"made_by\": \"haptic-camera\""),
            Self::Page => Replace::Marked("<meta name=\"generator\" content=\"haptic-camera\">"),
            Self::Figures => Replace::Marked(FIGURES_HEADER),
            Self::Qdas => Replace::Marked(sheet::QDAS_REMARK),
            Self::FittedModel => Replace::Marked(" samples: residual "),
            Self::DiagnosedModel => Replace::Marked("\ndescription = \"diagnosed from "),
            Self::ComposedModel => Replace::Marked("\norigin = "),
            Self::Calibration => Replace::Marked(CALIBRATION_MARK),
            Self::Header => Replace::Marked(" as numbers, made by haptic-camera "),
            Self::Simulator => Replace::Marked(". SI units: N m, rad, s.\n"),
            Self::Simulation => Replace::Marked("\"apparatus\": \"simulation\""),
            Self::ManualPage => Replace::Marked(".TH haptic-camera"),
            // The application's name, which rerun writes first.
            Self::Recording => Replace::Marked("haptic-camera-diagnosis"),
            Self::Data => Replace::Nothing,
        }
    }
}

/// The first line of a table of figures.
pub const FIGURES_HEADER: &str = "figure,angle_rad,direction,value,unit,ci95_low,ci95_high,definition\n";

/// The files that a call names.
#[derive(Debug, Default)]
pub struct Files {
    inputs: Vec<PathBuf>,
    outputs: Vec<(PathBuf, Replace)>,
    gives_json: bool,
}

impl Files {
    /// With files that are read.
    #[must_use]
    pub fn reading<File: AsRef<Path>>(mut self, paths: impl IntoIterator<Item = File>) -> Self {
        self.inputs.extend(paths.into_iter().map(|path| path.as_ref().to_owned()));
        self
    }

    /// With a file that is written, if it was asked for; standard output is none.
    #[must_use]
    pub fn writing(mut self, path: Option<&PathBuf>, kind: Kind) -> Self {
        self.gives_json |= kind == Kind::Json && to_output(path.map(PathBuf::as_path));
        self.replacing(path, kind.replaces())
    }

    /// Whether standard output is for the result as JSON.
    #[must_use]
    pub fn give_json(&self) -> bool {
        self.gives_json
    }

    /// The same with what it may replace.
    #[must_use]
    pub fn replacing(mut self, path: Option<&PathBuf>, replace: Replace) -> Self {
        self.outputs.extend(path.filter(|path| !to_output(Some(path))).map(|path| (path.clone(), replace)));
        self
    }

    /// Refuses outputs that would cost something, before any work is done.
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

/// Whether two paths lead to one regular file, that there is or that would be.
pub fn is_same(one: &Path, other: &Path) -> bool {
    match (one.metadata(), other.metadata()) {
        (Ok(one), Ok(other)) => one.is_file() && (one.dev(), one.ino()) == (other.dev(), other.ino()),
        (Err(_), Err(_)) => one.file_name() == other.file_name() && is_same_folder(one, other),
        _ => false,
    }
}

fn is_same_folder(one: &Path, other: &Path) -> bool {
    let [one, other] = [one, other].map(|path| whole_file::folder_of(path).canonicalize());
    matches!((one, other), (Ok(one), Ok(other)) if one == other)
}

/// Whether standard output is for the JSON alone.
fn to_output(json: Option<&Path>) -> bool {
    json == Some(Path::new("-"))
}

/// Writes a result as JSON, if it was asked for: to a file, or to standard output for `-`.
///
/// # Errors
/// When the file cannot be written.
pub fn write_json(path: Option<&Path>, result: &impl Serialize) -> anyhow::Result<()> {
    write_json_on(Axis::Rotary, path, result)
}

/// The same of what has an axis, in its names and units.
///
/// # Errors
/// When the file cannot be written.
pub fn write_json_on(axis: Axis, path: Option<&Path>, result: &impl Serialize) -> anyhow::Result<()> {
    let Some(path) = path else { return Ok(()) };
    let text = analysis::to_json_on(axis, result)?;
    if to_output(Some(path)) {
        print_json(&text);
        return Ok(());
    }
    write(path, Kind::Json, &(text + "\n"))
}

/// Writes a text file; whole or not at all.
///
/// # Errors
/// When something lies there that is not to be replaced, or the folder cannot be written to.
pub fn write(path: &Path, kind: Kind, text: &str) -> anyhow::Result<()> {
    replace(path, kind.replaces(), text)
}

/// Writes a text file if it was asked for.
///
/// # Errors
/// As [`write()`].
pub fn write_if_asked(path: Option<&PathBuf>, kind: Kind, text: impl FnOnce() -> String) -> anyhow::Result<()> {
    path.map_or(Ok(()), |path| write(path, kind, &text()))
}

/// Writes a text file in the place of what it may replace.
///
/// # Errors
/// As [`write()`].
pub fn replace(path: &Path, replace: Replace, text: &str) -> anyhow::Result<()> {
    Ok(write_bytes(path, replace, text.as_bytes())?)
}
