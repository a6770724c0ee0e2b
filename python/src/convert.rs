//! Arguments as Python has them: paths, numbers of knobs, captures and models; and results as Python takes them.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use archive::whole_file::{Replace, write_bytes};
use dynamics::knobs;
use loaded_capture::LoadedCapture;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde::Serialize;

use crate::capture::Capture;
use crate::error::raised;
use crate::model::Model;

/// A capture, or the path of one.
#[derive(FromPyObject)]
pub(crate) enum CaptureOrPath {
    Capture(Py<Capture>),
    Path(PathBuf),
}

impl CaptureOrPath {
    pub(crate) fn loaded(self, py: Python<'_>) -> PyResult<Arc<LoadedCapture>> {
        match self {
            Self::Capture(capture) => Ok(Arc::clone(&capture.get().loaded)),
            Self::Path(path) => py.detach(|| LoadedCapture::load(&path)).map(Arc::new).map_err(raised),
        }
    }
}

/// One capture, or several of one knob.
#[derive(FromPyObject)]
pub(crate) enum Captures {
    One(CaptureOrPath),
    Several(Vec<CaptureOrPath>),
}

impl Captures {
    pub(crate) fn loaded(self, py: Python<'_>) -> PyResult<Vec<Arc<LoadedCapture>>> {
        match self {
            Self::One(capture) => Ok(vec![capture.loaded(py)?]),
            Self::Several(captures) => captures.into_iter().map(|capture| capture.loaded(py)).collect(),
        }
    }
}

/// A model, the path of one, or the number of a shipped knob.
#[derive(FromPyObject)]
pub(crate) enum ModelOrName {
    Model(Py<Model>),
    Knob(u32),
    Path(PathBuf),
}

impl ModelOrName {
    /// The model with what its owner calls it.
    pub(crate) fn named(self) -> PyResult<(String, dynamics::Model)> {
        match self {
            Self::Model(model) => Ok((model.get().model.name.clone(), model.get().model.clone())),
            Self::Knob(number) => Ok((format!("knob {number}"), knobs::paper_knob(number).map_err(raised)?)),
            Self::Path(path) => {
                let name = path.display().to_string();
                let model = knobs::named(&name).map_err(raised)?;
                Ok((name, model))
            }
        }
    }

    pub(crate) fn model(self) -> PyResult<dynamics::Model> {
        self.named().map(|(_, model)| model)
    }
}

/// A result as the command line's JSON.
pub(crate) fn json(result: &impl Serialize) -> PyResult<String> {
    analysis::to_json(result).map_err(raised)
}

/// The same as Python's own objects.
pub(crate) fn to_dict(py: Python<'_>, json: String) -> PyResult<Bound<'_, PyDict>> {
    Ok(py.import("json")?.call_method1("loads", (json,))?.cast_into()?)
}

/// A report page within a notebook's page, whose style it neither takes nor changes.
pub(crate) fn framed(page: &str) -> String {
    let escaped = page.replace('&', "&amp;").replace('"', "&quot;");
    format!("<iframe srcdoc=\"{escaped}\" style=\"width: 100%; height: 40em; border: 0\"></iframe>")
}

/// Writes a report page where there is no file yet, or in place of one.
pub(crate) fn save_page(
    py: Python<'_>,
    path: &Path,
    overwrite: bool,
    page: impl FnOnce() -> String + Send,
) -> PyResult<()> {
    let replaced = if overwrite { Replace::Anything } else { Replace::Nothing };
    py.detach(|| write_bytes(path, replaced, page().as_bytes())).map_err(raised)
}
