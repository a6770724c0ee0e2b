//! `fit`: from a capture to a model.

use std::io::Write as _;
use std::os::unix::fs::PermissionsExt as _;
use std::path::Path;

use anyhow::Context as _;
use identification::{Fit, FitOptions};

use crate::command_line;
use crate::load::LoadedCapture;
use crate::outcome::{Outcome, say};
use crate::parameter_table::{parameter_table, reasons};

/// Fits a capture and writes what was asked for.
///
/// # Errors
/// One sentence on what is wrong with the capture or a file.
pub fn run(options: &command_line::FitOptions) -> anyhow::Result<Outcome> {
    let loaded = LoadedCapture::load(&options.capture)?;
    let fit = fit_capture(&loaded)?;
    let json_to_output = options.json.as_deref() == Some(Path::new("-"));
    if !json_to_output {
        show(&loaded, &fit);
    }
    if let Some(path) = &options.json {
        let text = serde_json::to_string_pretty(&fit)? + "\n";
        if json_to_output { say(text.trim_end()) } else { write(path, &text)? }
    }
    if let Some(path) = &options.out {
        write(path, &fit.model(&loaded.title()).to_toml())?;
    }
    if let Some(path) = &options.report {
        write(path, &loaded.report_page(&fit))?;
    }
    Ok(Outcome::Done)
}

/// Fits a capture with all that is known of its rig.
///
/// # Errors
/// One sentence on why nothing can be told from it.
pub fn fit_capture(loaded: &LoadedCapture) -> anyhow::Result<Fit> {
    let options = FitOptions { calibration: loaded.calibration.clone(), ..FitOptions::default() };
    identification::fit(&loaded.samples(), &options)
        .with_context(|| format!("{} cannot be fitted", loaded.capture.source.display()))
}

/// Prints the fit for people.
pub fn show(loaded: &LoadedCapture, fit: &Fit) {
    say(parameter_table(fit, loaded.truth.as_ref()));
    say(format!(
        "residual {:.3} mNm RMS, {:.2} % of the torque; mean 95 % interval of the model ±{:.3} mNm",
        fit.residual_rms_mnm, fit.relative_error_percent, fit.mean_ci95_mnm
    ));
    for line in reasons(fit).iter().chain(&fit.notes) {
        say(format!("- {line}"));
    }
}

/// Writes a text file; whole or not at all.
///
/// # Errors
/// When the folder cannot be written to.
pub fn write(path: &Path, text: &str) -> anyhow::Result<()> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let written = tempfile::NamedTempFile::new_in(folder).and_then(|mut file| {
        file.write_all(text.as_bytes())?;
        file.as_file().set_permissions(std::fs::Permissions::from_mode(0o644))?;
        file.persist(path)?;
        Ok(())
    });
    written.with_context(|| format!("{} cannot be written; choose another place", path.display()))
}
