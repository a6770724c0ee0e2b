//! Data sheets.

use std::path::{Path, PathBuf};

use analysis::{curve_files, curves, mean_fit, sheet_page};
use archive::testers::{Assignments, ColumnChoice, Curve};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyType};
use shared_types::Axis;

use crate::convert::{
    CaptureOrPath, OneOrMore, counted, estimate_in_words, framed, json, not_pickled, save_page, to_dict,
};
use crate::error::{Error, raised};
use crate::interruptible::interruptible;

/// A figure of a data sheet, or the reason why the curve does not determine it.
#[pyclass(frozen, eq, get_all, new = "from_fields", module = "haptic_camera")]
#[derive(Clone, PartialEq)]
pub(crate) struct Figure {
    /// Its name, as in specifications.
    name: String,
    /// Its value; None if the curve does not determine it.
    value: Option<f64>,
    /// Unit of value and interval; "share" for a ratio, empty for a number.
    unit: String,
    /// 95 % interval (low, high): of one curve from its noise, of several that which holds one more of them.
    ci95: Option<(f64, f64)>,
    /// Why there is no value, in a sentence.
    reason: Option<String>,
    /// What it is, in a sentence.
    definition: String,
    /// Whose definition that is.
    source: String,
}

/// The fields of a figure in their order.
type Fields = (String, Option<f64>, String, Option<(f64, f64)>, Option<String>, String, String);

#[pymethods]
impl Figure {
    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let Self { name, value, unit, ci95, reason, .. } = self;
        let text = estimate_in_words(py, *value, unit, *ci95, reason.as_deref())?;
        Ok(format!("<Figure {name}: {text}>"))
    }

    /// Pickled as its fields.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> (Bound<'py, PyType>, Fields) {
        let Self { name, value, unit, ci95, reason, definition, source } = slf.get().clone();
        (slf.get_type(), (name, value, unit, ci95, reason, definition, source))
    }
}

/// The data sheet of a part: its figures, and load over position.
///
/// Of a turned control positions are angles in rad and loads torques in mNm; of a pressed one travels in mm and forces in N.
/// Results do not change; `to_dict` gives what ``haptic-camera sheet --json`` writes.
#[pyclass(frozen, module = "haptic_camera")]
pub(crate) struct Sheet {
    pub(crate) sheet: ::sheet::Sheet,
    pub(crate) files: Vec<PathBuf>,
}

/// Make the data sheet of a part.
///
/// Parameters
/// ----------
/// captures : Capture, str, os.PathLike, or an iterable of them
///     Curves of one part: captures turned slowly there and back, as by the sweep ``slow-turn``, or testers' files. A folder
///     stands for the files in it. Several are averaged.
/// dynamic : Capture, str, os.PathLike, or an iterable of them, optional
///     Captures of the same part at speed, for inertia, viscous friction and breakaway; of several the mean.
/// columns : dict of str to str or int, optional
///     The columns of a table of no known layout, by name or by number from 1: ``{"angle": "Winkel", "torque": 3}``, or
///     ``travel`` and ``force``; besides, ``time`` and ``contact``, a voltage that falls. Channels of an MDF file also by their
///     group's number, ``"2/Winkel"``.
/// units : dict of str to str, optional
///     Their units, as in ``{"angle": "deg", "torque": "Ncm"}``; without them the file's own, else rad and mNm, or mm and N, and s.
///
/// Returns
/// -------
/// Sheet
///
/// Raises
/// ------
/// Error
///     If a file cannot be read, or no figure can be read off a curve; what only some figures lack is their ``reason``.
#[pyfunction]
#[pyo3(signature = (captures, *, dynamic=None, columns=None, units=None))]
pub(crate) fn sheet(
    py: Python<'_>,
    captures: OneOrMore<CaptureOrPath>,
    dynamic: Option<OneOrMore<CaptureOrPath>>,
    columns: Option<Bound<'_, PyDict>>,
    units: Option<Bound<'_, PyDict>>,
) -> PyResult<Sheet> {
    let choice = choice(columns, units)?;
    let Sheet { sheet, files } = Sheet::of(py, captures.0, choice.as_ref())?;
    let at_speed =
        dynamic.map_or_else(Vec::new, |dynamic| dynamic.0).into_iter().map(|one| one.measured(py, choice.as_ref()));
    let at_speed = at_speed.collect::<PyResult<Vec<_>>>()?;
    let fit = interruptible(py, move || mean_fit(at_speed.iter().map(AsRef::as_ref)))?.map_err(raised)?;
    let sheet = match fit {
        Some(fit) => sheet.with_dynamics(&fit).map_err(raised)?,
        None => sheet,
    };
    Ok(Sheet { sheet, files })
}

/// The columns as chosen; None where a file's format says.
pub(crate) fn choice(
    columns: Option<Bound<'_, PyDict>>,
    units: Option<Bound<'_, PyDict>>,
) -> PyResult<Option<ColumnChoice>> {
    let Some(columns) = columns else {
        let words = "units are those of columns; give columns too";
        return units.map_or(Ok(None), |_| Err(Error::new_err(words)));
    };
    let (columns, units) = (assignments(&columns)?, units.as_ref().map(assignments).transpose()?);
    ColumnChoice::new(columns, units.unwrap_or_default()).map(Some).map_err(raised)
}

fn assignments(given: &Bound<'_, PyDict>) -> PyResult<Assignments> {
    let pair =
        |(word, value): (Bound<'_, PyAny>, Bound<'_, PyAny>)| Ok((word.extract()?, value.str()?.extract::<String>()?));
    Assignments::new(given.iter().map(pair).collect::<PyResult<_>>()?).map_err(raised)
}

impl Sheet {
    pub(crate) fn of(py: Python<'_>, sources: Vec<CaptureOrPath>, choice: Option<&ColumnChoice>) -> PyResult<Self> {
        let choice = choice.cloned();
        interruptible(py, move || {
            let (mut all, mut files): (Vec<Curve>, Vec<PathBuf>) = Default::default();
            for source in sources {
                match source {
                    CaptureOrPath::Capture(capture) => {
                        files.push(capture.get().loaded.capture.source.clone());
                        all.push(capture.get().loaded.curve());
                    }
                    CaptureOrPath::Path(path) => {
                        let found = curve_files(&[path]).map_err(raised)?;
                        all.extend(curves(&found, choice.as_ref()).map_err(raised)?);
                        files.extend(found);
                    }
                }
            }
            Ok(Self { sheet: ::sheet::Sheet::of(&all).map_err(raised)?, files })
        })?
    }

    /// The file or folder that the part is called by.
    pub(crate) fn unit(&self) -> &Path {
        let first = self.files.first().map_or(Path::new(""), PathBuf::as_path);
        if self.files.len() > 1 { first.parent().unwrap_or(first) } else { first }
    }
}

#[pymethods]
impl Sheet {
    /// "rotary" for a turned control, "linear" for a pressed one.
    #[getter]
    fn axis(&self) -> &'static str {
        match self.sheet.axis {
            Axis::Rotary => "rotary",
            Axis::Linear => "linear",
        }
    }

    /// Curves that it was made of, or presses where a curve has several.
    #[getter]
    fn runs(&self) -> usize {
        self.sheet.runs
    }

    /// Its figures by name, in the order of the sheet.
    #[getter]
    fn figures<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let figures = PyDict::new(py);
        for figure in self.sheet.in_order() {
            let ::sheet::Figure { value, ci95, kind, reason, .. } = figure.clone();
            let ::sheet::FigureKind { name, unit, definition, source } = *kind;
            let [unit, definition, source] = [unit, definition, source].map(str::to_owned);
            let ci95 = ci95.map(|[low, high]| (low, high));
            let figure = Figure { name: name.to_owned(), value, unit, ci95, reason, definition, source };
            figures.set_item(name, Bound::new(py, figure)?)?;
        }
        Ok(figures)
    }

    /// Everything that ``haptic-camera sheet --json`` writes, under its keys: besides the figures each detent in each
    /// direction (``detents``), each press by itself (``presses``) and load over position, a branch each (``curve``).
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        to_dict(py, self.to_json()?)
    }

    /// The same as text.
    fn to_json(&self) -> PyResult<String> {
        json(&self.sheet)
    }

    /// The report page, one HTML file that fetches nothing.
    fn to_html(&self) -> String {
        sheet_page(&self.sheet, &self.files)
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
        let determined = self.sheet.figures.values().filter(|figure| figure.value.is_some()).count();
        format!("<Sheet of {}, {}: {}>", counted(self.sheet.runs, "curve"), self.axis(), counted(determined, "figure"))
    }

    /// Its curves are not copied about.
    fn __reduce__(&self) -> PyResult<()> {
        Err(not_pickled("a sheet", "its figures or its to_dict()"))
    }
}
