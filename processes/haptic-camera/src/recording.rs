//! A diagnosis as a rerun file, which the viewer's program makes: this one does without rerun.

use std::path::Path;
use std::process::{Command, Stdio};

use anyhow::Context as _;
use identification::diagnosis::{Diagnosis, Row};
use serde::Serialize;

use crate::supervision::program_path;

/// What the viewer's program reads.
#[derive(Serialize)]
struct Recording<'a> {
    diagnosis: &'a Diagnosis,
    captures: [CaptureRows<'a>; 2],
}

/// The rows of a capture that were compared.
#[derive(Serialize)]
struct CaptureRows<'a> {
    role: &'static str,
    source: &'a str,
    rows: &'a [Row],
}

/// Writes the diagnosis as a rerun file; without a held-out capture its rows are stretches of the training capture.
pub fn write(path: &Path, found: &Diagnosis, train: &str, heldout: Option<&str>) -> anyhow::Result<()> {
    let [of_train, of_heldout] = &found.rows;
    let recording = Recording {
        diagnosis: found,
        captures: [
            CaptureRows { role: "training", source: train, rows: of_train },
            CaptureRows { role: "heldout", source: heldout.unwrap_or(train), rows: of_heldout },
        ],
    };
    let folder = tempfile::tempdir().context("the recording's rows cannot be stored")?;
    let json = folder.path().join("diagnosis.json");
    std::fs::write(&json, serde_json::to_vec(&recording)?).context("the recording's rows cannot be written")?;
    let program = program_path("rerun-viewer")?;
    anyhow::ensure!(
        program.exists(),
        "the program {} is missing, which writes recordings; build the whole workspace",
        program.display()
    );
    let ended = Command::new(program)
        .arg("diagnosis")
        .arg(&json)
        .arg("--out")
        .arg(path)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .status()
        .context("the viewer's program cannot be started; build the whole workspace")?;
    anyhow::ensure!(ended.success(), "{} is not written; see the viewer's error above", path.display());
    Ok(())
}
