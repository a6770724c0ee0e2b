//! A diagnosis as a rerun file, which the viewer's program makes: this one does without rerun.

use std::path::Path;
use std::process::{Command, Stdio};

use anyhow::Context as _;
use identification::diagnosis::{Diagnosis, Row};
use serde_json::json;

use crate::supervision::program_path;

/// Writes the diagnosis as a rerun file; without a held-out capture its rows are stretches of the training capture.
pub fn write(path: &Path, found: &Diagnosis, train: &str, heldout: Option<&str>) -> anyhow::Result<()> {
    let [of_train, of_heldout] = &found.rows;
    let capture = |role: &str, source: &str, rows: &[Row]| json!({ "role": role, "source": source, "rows": rows });
    let captures = [capture("training", train, of_train), capture("heldout", heldout.unwrap_or(train), of_heldout)];
    let recording = json!({ "diagnosis": found, "captures": captures });
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
