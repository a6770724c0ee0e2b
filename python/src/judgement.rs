//! Verdicts on units by a specification.

use std::path::{Path, PathBuf};

use analysis::{Judgements, judged, load_specification};
use archive::testers::ColumnChoice;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyType};
use report::JudgedUnit;

use crate::convert::{CaptureOrPath, OneOrMore, counted, framed, json, not, not_pickled, save_page, to_dict};
use crate::error::{Error, raised};
use crate::sheet::{Sheet, choice};

/// The verdict on one unit.
#[pyclass(frozen, eq, get_all, new = "from_fields", module = "haptic_camera")]
#[derive(Clone, PartialEq)]
pub(crate) struct Verdict {
    /// Name of the unit's file or folder.
    unit: String,
    /// "pass", "fail", or "undecided" where the data do not tell.
    verdict: String,
    /// Why the unit does not pass, a sentence each.
    reasons: Vec<String>,
}

#[pymethods]
impl Verdict {
    fn __repr__(&self) -> String {
        format!("<Verdict on {}: {}>", self.unit, self.verdict)
    }

    /// Pickled as its fields.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> (Bound<'py, PyType>, (String, String, Vec<String>)) {
        let Self { unit, verdict, reasons } = slf.get().clone();
        (slf.get_type(), (unit, verdict, reasons))
    }
}

/// The verdicts on units.
///
/// Results do not change; `to_dict` gives what ``haptic-camera judge --json`` writes.
#[pyclass(frozen, module = "haptic_camera")]
pub(crate) struct Judgement {
    judgements: Judgements,
}

/// A unit: its sheet, its only capture, or its file or folder.
pub(crate) enum Unit {
    Sheet(Py<Sheet>),
    Curve(CaptureOrPath),
}

impl FromPyObject<'_, '_> for Unit {
    type Error = PyErr;

    fn extract(given: Borrowed<'_, '_, PyAny>) -> PyResult<Self> {
        match (given.extract(), given.extract()) {
            (Ok(sheet), _) => Ok(Self::Sheet(sheet)),
            (_, Ok(curve)) => Ok(Self::Curve(curve)),
            _ => Err(not("a Sheet, a Capture or the path of one", given)),
        }
    }
}

/// Judge units by a specification: pass, fail, or undecided.
///
/// Parameters
/// ----------
/// captures : Sheet, Capture, str, os.PathLike, or an iterable of them
///     A unit each; a folder is one unit that was captured several times.
/// spec : str or os.PathLike
///     The specification, a TOML file of limits on figures, and envelopes for the curve, with the risk of a wrong verdict.
///     Limits are in the unit that they name, or in the figure's own: rad, mNm, mJ of a turned control; mm, N, mJ of a
///     pressed one.
/// columns, units : dict, optional
///     As for `sheet`.
///
/// Returns
/// -------
/// Judgement
///
/// Raises
/// ------
/// Error
///     If the specification or a file cannot be read, or a curve makes no sheet.
///
/// Notes
/// -----
/// Guard bands after ISO 14253-1 and JCGM 106 at the stated risk.
#[pyfunction]
#[pyo3(signature = (captures, spec, *, columns=None, units=None))]
pub(crate) fn judge(
    py: Python<'_>,
    captures: OneOrMore<Unit>,
    spec: PathBuf,
    columns: Option<Bound<'_, PyDict>>,
    units: Option<Bound<'_, PyDict>>,
) -> PyResult<Judgement> {
    let choice = choice(columns, units)?;
    let specification = py.detach(|| load_specification(&spec)).map_err(raised)?;
    if captures.0.is_empty() {
        return Err(Error::new_err("there is no unit to judge; give at least one"));
    }
    let mut units = Vec::with_capacity(captures.0.len());
    for unit in captures.0 {
        let unit = unit.with_sheet(py, choice.as_ref(), |name, sheet| judged(name, &specification, sheet))?;
        units.push(unit);
        py.check_signals()?;
    }
    Ok(Judgement { judgements: Judgements::of(&specification, units) })
}

impl Unit {
    /// What is made of the unit's name and sheet.
    fn with_sheet(
        self,
        py: Python<'_>,
        choice: Option<&ColumnChoice>,
        judged: impl Fn(&Path, &::sheet::Sheet) -> JudgedUnit,
    ) -> PyResult<JudgedUnit> {
        let source = match self {
            Self::Sheet(sheet) => return Ok(judged(sheet.get().unit(), &sheet.get().sheet)),
            Self::Curve(source) => source,
        };
        let folder = match &source {
            CaptureOrPath::Capture(_) => None,
            CaptureOrPath::Path(path) => Some(path.clone()),
        };
        let sheet = Sheet::of(py, vec![source], choice)?;
        Ok(judged(folder.as_deref().unwrap_or(sheet.unit()), &sheet.sheet))
    }
}

#[pymethods]
impl Judgement {
    /// The worst verdict of all units: "pass", "undecided" or "fail".
    #[getter]
    fn verdict(&self) -> &'static str {
        self.judgements.verdict.word()
    }

    /// Largest risk of a wrong verdict, as the specification states it.
    #[getter]
    fn risk(&self) -> f64 {
        self.judgements.risk
    }

    /// The verdict on each unit, in the order in which they were given.
    #[getter]
    fn units(&self) -> Vec<Verdict> {
        let verdict = |JudgedUnit { unit, judgement }: &JudgedUnit| Verdict {
            unit: unit.clone(),
            verdict: judgement.verdict.word().to_owned(),
            reasons: judgement.reasons.clone(),
        };
        self.judgements.units.iter().map(verdict).collect()
    }

    /// Everything that ``haptic-camera judge --json`` writes, under its keys.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        to_dict(py, self.to_json()?)
    }

    /// The same as text.
    fn to_json(&self) -> PyResult<String> {
        json(&self.judgements)
    }

    /// The report page, one HTML file that fetches nothing.
    fn to_html(&self) -> String {
        self.judgements.page()
    }

    /// Write the report page.
    #[pyo3(signature = (path, *, overwrite=false))]
    fn save_report(&self, py: Python<'_>, path: PathBuf, overwrite: bool) -> PyResult<()> {
        save_page(py, &path, overwrite, || self.to_html())
    }

    /// The report page in a notebook.
    fn _repr_html_(&self, py: Python<'_>) -> String {
        framed(&py.detach(|| self.to_html()))
    }

    fn __repr__(&self) -> String {
        format!("<Judgement of {}: {}>", counted(self.judgements.units.len(), "unit"), self.verdict())
    }

    /// What it was made of is not copied about.
    fn __reduce__(&self) -> PyResult<()> {
        Err(not_pickled("a judgement", "its units or its to_dict()"))
    }
}
