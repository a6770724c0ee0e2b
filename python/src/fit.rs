//! Fits of one capture, and of several of one knob.

use std::path::PathBuf;
use std::sync::Arc;

use analysis::{AverageResult, FitResult};
use identification::{Average, PreparationMethod};
use loaded_capture::LoadedCapture;
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyType};
use report::{AveragePage, FigureNumbers};

use crate::columns::field_view;
use crate::convert::{
    CaptureOrPath, OneOrMore, estimate_in_words, framed, json_on, name_and_unit_on, not_pickled, save_page, to_dict,
};
use crate::error::{Error, raised};
use crate::interruptible::interruptible;
use crate::model::Model;
use crate::sheet::choice;

/// A fitted parameter, or the reason why the data cannot tell it.
#[pyclass(frozen, eq, get_all, new = "from_fields", module = "haptic_camera")]
#[derive(Clone, PartialEq)]
pub(crate) struct Parameter {
    /// Standard name, as in model files.
    name: String,
    /// Fitted value; None if the data cannot tell it.
    value: Option<f64>,
    /// Unit of value and interval.
    unit: String,
    /// 95 % interval (low, high), for residuals that are correlated and of varying size.
    ci95: Option<(f64, f64)>,
    /// Why there is no value, in a sentence.
    reason: Option<String>,
}

/// The fields of a parameter in their order.
type Fields = (String, Option<f64>, String, Option<(f64, f64)>, Option<String>);

#[pymethods]
impl Parameter {
    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let Self { name, value, unit, ci95, reason } = self;
        let text = estimate_in_words(py, *value, unit, *ci95, reason.as_deref())?;
        Ok(format!("<Parameter {name}: {text}>"))
    }

    /// Pickled as its fields.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> (Bound<'py, PyType>, Fields) {
        let Self { name, value, unit, ci95, reason } = slf.get().clone();
        (slf.get_type(), (name, value, unit, ci95, reason))
    }
}

/// A fitted model with its uncertainty; of several captures of one knob, their mean.
///
/// The torque is M·θ̈ + [θ̇<0]·(−C₋ + B₋·θ̇) + [θ̇>0]·(C₊ + B₊·θ̇) + A·sin(θ/P + S) (Swindells and MacLean, World Haptics
/// 2007, equation 1). Results do not change; `to_dict` gives what ``haptic-camera fit --json`` writes.
#[pyclass(frozen, module = "haptic_camera")]
pub(crate) struct Fit {
    captures: Vec<Arc<LoadedCapture>>,
    each: Vec<identification::Fit>,
    /// The mean of several.
    average: Option<Average>,
}

/// Fit a model to a capture, or one model to several captures of the same knob.
///
/// Parameters
/// ----------
/// captures : Capture, str, os.PathLike, or an iterable of them
///     What is fitted, with all that is known of its rig.
/// preparation : {"automatic", "paper", "central-differences"}
///     How the captures are filtered before the fit.
/// columns, units : dict of str, optional
///     Of tables with other columns, as of `read`. A table without a time is fitted as a curve of torque over angle, in which inertia and
///     viscous friction have no part.
///
/// Returns
/// -------
/// Fit
///
/// Raises
/// ------
/// Error
///     If the captures cannot be fitted. A parameter that is not identifiable has a ``reason`` instead.
/// KeyboardInterrupt
///     At Ctrl-C.
#[pyfunction]
#[pyo3(signature = (captures, *, preparation="automatic", columns=None, units=None))]
pub(crate) fn fit(
    py: Python<'_>,
    captures: OneOrMore<CaptureOrPath>,
    preparation: &str,
    columns: Option<Bound<'_, PyDict>>,
    units: Option<Bound<'_, PyDict>>,
) -> PyResult<Fit> {
    let chosen = choice(columns, units)?;
    let methods = [PreparationMethod::Automatic, PreparationMethod::Paper, PreparationMethod::CentralDifferences];
    let method = methods.into_iter().find(|method| method.name() == preparation).ok_or_else(|| {
        let known = methods.map(PreparationMethod::name).join(", ");
        Error::new_err(format!("there is no preparation '{preparation}'; give one of {known}"))
    })?;
    let measured = |capture: CaptureOrPath| capture.measured(py, chosen.as_ref());
    let captures: Vec<_> = captures.0.into_iter().map(measured).collect::<PyResult<_>>()?;
    if captures.is_empty() {
        return Err(Error::new_err("there is no capture to fit; give at least one"));
    }
    analysis::common_axis(captures.iter().map(|one| one.capture.axis)).map_err(raised)?;
    let mut each = Vec::with_capacity(captures.len());
    for capture in &captures {
        let capture = Arc::clone(capture);
        each.push(interruptible(py, move || analysis::fit(&capture, method))?.map_err(raised)?);
    }
    let average = if each.len() > 1 { py.detach(|| identification::average(&each)) } else { None };
    Ok(Fit { captures, each, average })
}

impl Fit {
    fn fit(&self) -> &identification::Fit {
        self.average.as_ref().map_or(&self.each[0], |average| &average.fit)
    }

    /// A text in the words of the axis that was fitted.
    fn said(&self, text: &str) -> String {
        self.fit().axis.words(text).into_owned()
    }

    fn loaded(&self) -> Vec<&LoadedCapture> {
        self.captures.iter().map(Arc::as_ref).collect()
    }
}

#[pymethods]
impl Fit {
    /// The parameters by name.
    #[getter]
    fn parameters<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let parameters = PyDict::new(py);
        for parameter in &self.fit().parameters.0 {
            let identification::Parameter { name, value, unit, ci95, reason, .. } = parameter.clone();
            let (name, unit) = name_and_unit_on(self.fit().axis, name, unit);
            let reason = reason.map(|reason| self.said(&reason));
            let ci95 = ci95.map(|[low, high]| (low, high));
            parameters.set_item(name.clone(), Bound::new(py, Parameter { name, value, unit, ci95, reason })?)?;
        }
        Ok(parameters)
    }

    /// Covariance of the parameters named in `covariance_order`, shape (k, k), in the products of their units.
    #[getter]
    fn covariance<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        PyArray2::from_vec2(py, &self.fit().covariance.rows).map_err(raised)
    }

    /// Names of the parameters in the order of the covariance's rows and columns.
    #[getter]
    fn covariance_order(&self) -> Vec<String> {
        self.fit().covariance.order.iter().map(|name| self.said(name)).collect()
    }

    /// RMS of measured minus model torque, mNm; of what is pressed or slid N.
    #[getter]
    fn residual_rms_mnm(&self) -> f64 {
        self.fit().residual_rms_mnm
    }

    /// 100 · ‖measured − model‖ / ‖measured‖.
    #[getter]
    fn relative_error_percent(&self) -> f64 {
        self.fit().relative_error_percent
    }

    /// Mean half width of the 95 % interval of the model's torque, mNm; of what is pressed or slid N.
    #[getter]
    fn mean_ci95_mnm(&self) -> f64 {
        self.fit().mean_ci95_mnm
    }

    /// Samples that were fitted.
    #[getter]
    fn samples(&self) -> usize {
        self.fit().samples
    }

    /// What a reader of the numbers should know.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.fit().notes.iter().map(|note| self.said(note)).collect()
    }

    /// Each capture's own fit.
    #[getter]
    fn fits(&self) -> Vec<Self> {
        let each = self.captures.iter().zip(&self.each);
        each.map(|(capture, fit)| Self { captures: vec![Arc::clone(capture)], each: vec![fit.clone()], average: None })
            .collect()
    }

    /// Measured and model torque row by row, filtered to the fit's band: arrays of shape (rows,) by name, without a copy.
    #[getter]
    fn points<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyDict>> {
        type Field = fn(&identification::Point) -> &f64;
        let fields: [(&str, Field); 8] = [
            ("t_s", |point| &point.t_s),
            ("angle_rad", |point| &point.angle_rad),
            ("velocity_rad_s", |point| &point.velocity_rad_s),
            ("acceleration_rad_s2", |point| &point.acceleration_rad_s2),
            ("torque_mnm", |point| &point.torque_mnm),
            ("torque_model_mnm", |point| &point.torque_model_mnm),
            ("torque_model_ci95_mnm", |point| &point.torque_model_ci95_mnm),
            ("residual_mnm", |point| &point.residual_mnm),
        ];
        let columns = PyDict::new(slf.py());
        for (name, field) in fields {
            // SAFETY: the class is frozen and keeps its points.
            #[allow(unsafe_code, reason = "the array looks at the fit's memory")]
            let column: Bound<'py, PyArray1<f64>> =
                unsafe { field_view(slf.as_any(), &slf.get().fit().points, field) }?;
            columns.set_item(slf.get().said(name), column)?;
        }
        Ok(columns)
    }

    /// The fitted model.
    fn model(&self) -> Model {
        let titles = analysis::titles(&self.loaded());
        let model = self.average.as_ref().map_or_else(|| self.fit().model(&titles), |average| average.model(&titles));
        Model::from(model)
    }

    /// Everything that ``haptic-camera fit --json`` writes, under its keys.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        to_dict(py, self.to_json()?)
    }

    /// The same as text.
    fn to_json(&self) -> PyResult<String> {
        match &self.average {
            Some(average) => json_on(self.fit().axis, &AverageResult::of(average, &self.loaded(), &self.each)),
            None => json_on(self.fit().axis, &FitResult::of(&self.captures[0], &self.each[0], FigureNumbers::new())),
        }
    }

    /// The report page, one HTML file that fetches nothing.
    fn to_html(&self) -> String {
        match &self.average {
            Some(average) => self.said(&report::average_page(&AveragePage {
                average,
                fits: &self.each,
                captures: self.captures.iter().map(|capture| analysis::facts(capture)).collect(),
                truth: analysis::common_truth(&self.loaded()),
            })),
            None => analysis::fit_page(&self.captures[0], &self.each[0]).0,
        }
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
        let fit = self.fit();
        let text =
            format!("residual {:.3} mNm, {:.2} % of the torque", fit.residual_rms_mnm, fit.relative_error_percent);
        format!("<Fit of {}: {}>", analysis::titles(&self.loaded()), self.said(&text))
    }

    /// Its captures are not copied about.
    fn __reduce__(&self) -> PyResult<()> {
        Err(not_pickled("a fit", "its parameters, its model() or its to_dict()"))
    }
}
