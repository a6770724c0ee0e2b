//! Arguments as Python has them: paths, numbers of knobs, captures and models; and results as Python takes them.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use archive::testers::ColumnChoice;
use archive::whole_file::{Replace, write_bytes};
use dynamics::{Axis, Source, knobs};
use loaded_capture::LoadedCapture;
use numpy::{PyReadonlyArray1, dtype, get_array_module};
use pyo3::conversion::FromPyObjectOwned;
use pyo3::exceptions::{PyOverflowError, PyTypeError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict};
use serde::Serialize;

use crate::capture::Capture;
use crate::error::{Error, raised};
use crate::interruptible::interruptible;
use crate::model::Model;

/// A capture, or the path of one.
pub(crate) enum CaptureOrPath {
    Capture(Py<Capture>),
    Path(PathBuf),
}

impl FromPyObject<'_, '_> for CaptureOrPath {
    type Error = PyErr;

    fn extract(given: Borrowed<'_, '_, PyAny>) -> PyResult<Self> {
        match (given.extract(), given.extract()) {
            (Ok(capture), _) => Ok(Self::Capture(capture)),
            (_, Ok(path)) => Ok(Self::Path(path)),
            _ => Err(not("a Capture or the path of one", given)),
        }
    }
}

impl CaptureOrPath {
    pub(crate) fn loaded(self, py: Python<'_>) -> PyResult<Arc<LoadedCapture>> {
        match self {
            Self::Capture(capture) => Ok(Arc::clone(&capture.get().loaded)),
            Self::Path(path) => interruptible(py, move || LoadedCapture::load(&path))?.map(Arc::new).map_err(raised),
        }
    }

    /// The capture, or a tester's curve as one.
    pub(crate) fn measured(self, py: Python<'_>, chosen: Option<&ColumnChoice>) -> PyResult<Arc<LoadedCapture>> {
        let chosen = chosen.cloned();
        match self {
            Self::Path(path) => interruptible(py, move || LoadedCapture::load_measured(&path, chosen.as_ref()))?
                .map(Arc::new)
                .map_err(raised),
            capture => capture.loaded(py),
        }
    }
}

/// One of a kind, or several.
pub(crate) struct OneOrMore<Item>(pub(crate) Vec<Item>);

impl<'py, Item: FromPyObjectOwned<'py, Error = PyErr>> FromPyObject<'_, 'py> for OneOrMore<Item> {
    type Error = PyErr;

    fn extract(given: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        match (given.extract(), given.try_iter()) {
            (Ok(one), _) => Ok(Self(vec![one])),
            (_, Ok(several)) => several.map(|item| item?.extract()).collect::<PyResult<_>>().map(Self),
            (Err(error), Err(_)) => Err(error),
        }
    }
}

/// A model, or what an operator names one by: its path, or the number of a shipped knob.
pub(crate) enum ModelOrName {
    Model(Py<Model>),
    Name(String),
}

impl FromPyObject<'_, '_> for ModelOrName {
    type Error = PyErr;

    fn extract(given: Borrowed<'_, '_, PyAny>) -> PyResult<Self> {
        if let Ok(model) = given.extract() {
            return Ok(Self::Model(model));
        }
        if let Ok(path) = given.extract::<PathBuf>() {
            return Ok(Self::Name(path.display().to_string()));
        }
        match given.extract::<u32>() {
            Ok(number) if !given.is_instance_of::<PyBool>() => Ok(Self::Name(number.to_string())),
            Err(error) if error.is_instance_of::<PyOverflowError>(given.py()) => Err(Error::new_err(format!(
                "there is no shipped knob {}; choose 1 to 5 or give a model file",
                given.str()?
            ))),
            _ => Err(not("a Model, the path of one or the number of a shipped knob", given)),
        }
    }
}

impl ModelOrName {
    /// The model with what its owner calls it.
    pub(crate) fn named(self) -> PyResult<(String, dynamics::Model)> {
        match self {
            Self::Model(model) => Ok((model.get().model.name.clone(), model.get().model.clone())),
            Self::Name(name) => {
                let model = knobs::named(&name).map_err(raised)?;
                Ok((name, model))
            }
        }
    }

    pub(crate) fn model(self) -> PyResult<dynamics::Model> {
        self.named().map(|(_, model)| model)
    }

    /// The model as one to take parts from, which may be a drawn table too.
    pub(crate) fn source(self) -> PyResult<Source> {
        match self {
            Self::Model(model) => Ok(Source::new(model.get().model.name.clone(), model.get().model.clone())),
            Self::Name(name) => Source::named(&name).map_err(raised),
        }
    }
}

/// A column of numbers, copied from whatever NumPy makes an array of.
pub(crate) struct Column(pub(crate) Vec<f64>);

impl FromPyObject<'_, '_> for Column {
    type Error = PyErr;

    fn extract(given: Borrowed<'_, '_, PyAny>) -> PyResult<Self> {
        let array = get_array_module(given.py())?.call_method1("asarray", (given, dtype::<f64>(given.py())))?;
        match array.extract::<PyReadonlyArray1<'_, f64>>() {
            Ok(column) => Ok(Self(column.as_array().to_vec())),
            Err(_) => Err(Error::new_err(format!(
                "a column has one dimension, but this array has the shape {}",
                array.getattr("shape")?
            ))),
        }
    }
}

/// What is wrong with an argument of another type.
pub(crate) fn not(wanted: &str, given: Borrowed<'_, '_, PyAny>) -> PyErr {
    match given.get_type().name() {
        Ok(kind) => PyTypeError::new_err(format!("expected {wanted}, not {kind}")),
        Err(error) => error,
    }
}

/// Why a result is not pickled, and what to hand on instead.
pub(crate) fn not_pickled(what: &str, instead: &str) -> PyErr {
    Error::new_err(format!("{what} is not pickled; hand on {instead}"))
}

/// A value with its unit and interval in six digits, or the reason why there is none.
pub(crate) fn estimate_in_words(
    py: Python<'_>,
    value: Option<f64>,
    unit: &str,
    ci95: Option<(f64, f64)>,
    reason: Option<&str>,
) -> PyResult<String> {
    let six = |value: f64| value.into_pyobject(py)?.call_method1("__format__", (".6g",))?.extract::<String>();
    Ok(match (value, ci95) {
        (Some(value), Some((low, high))) => format!("{} {unit}, 95 % {} to {}", six(value)?, six(low)?, six(high)?),
        (Some(value), None) => format!("{} {unit}", six(value)?),
        (None, _) => reason.unwrap_or("not identifiable").to_owned(),
    })
}

/// How many there are of what is named.
pub(crate) fn counted(number: usize, what: &str) -> String {
    format!("{number} {what}{}", if number == 1 { "" } else { "s" })
}

/// A parameter's name and unit in the words of an axis.
pub(crate) fn name_and_unit_on(axis: Axis, name: &str, unit: &str) -> (String, String) {
    let both = format!("{name} {unit}");
    let (name, unit) =
        axis.words(&both).split_once(' ').map(|(name, unit)| (name.to_owned(), unit.to_owned())).unwrap_or_default();
    (name, unit)
}

/// A result as the command line's JSON.
pub(crate) fn json(result: &impl Serialize) -> PyResult<String> {
    json_on(Axis::Rotary, result)
}

/// The same of what has an axis, in its names and units.
pub(crate) fn json_on(axis: Axis, result: &impl Serialize) -> PyResult<String> {
    analysis::to_json_on(axis, result).map_err(raised)
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
