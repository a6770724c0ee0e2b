//! A capture: its columns as arrays, and what is known of it.

use std::path::PathBuf;
use std::sync::Arc;

use archive::columns::Values;
use archive::whole_file::{Replace, write_whole};
use dynamics::Axis;
use loaded_capture::LoadedCapture;
use numpy::PyArray1;
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use pyo3::types::{PyCapsule, PyDict};

use crate::arrow::{self, ArrayCapsules};
use crate::columns::view;
use crate::convert::{Column, json, not_pickled, to_dict};
use crate::error::{Error, raised};
use crate::interruptible::interruptible;
use crate::model::Model;
use crate::sheet::choice;

/// A capture in memory: one read-only NumPy array a column, all of one length, in the order of time.
///
/// Arrays look at the capture's own memory, nothing is copied; they keep it alive. pandas, polars and pyarrow take a capture
/// through Arrow's C interface, as in ``polars.DataFrame(capture)`` and ``pyarrow.table(capture)``.
#[pyclass(frozen, module = "haptic_camera")]
pub(crate) struct Capture {
    pub(crate) loaded: Arc<LoadedCapture>,
}

/// Read a capture.
///
/// Parameters
/// ----------
/// path : str or os.PathLike
///     An archive (MCAP) of this instrument, or a CSV file with the header
///     ``t_s,angle_rad[,velocity_rad_s][,acceleration_rad_s2],torque_mnm[,contact]``. A table's calibration is taken from
///     ``NAME.calibration.toml`` beside it, if there is one. An ASAM MDF 4 measurement, whose channels of angle and torque, or
///     of travel and force, are known by their names or units. Or a table of another layout, with ``columns``.
/// columns : dict of str to str or int, optional
///     The columns or channels, by name or by number from 1: ``{"angle": "Winkel", "torque": 3, "time": "Zeit"}``, or ``travel``
///     and ``force``; a channel also by its group's number, ``"2/Winkel"``. A measurement has its time from the group.
/// units : dict of str to str, optional
///     Their units, as in ``{"angle": "deg", "torque": "Ncm"}``; without them the file's own, else rad and mNm, or mm and N, and s.
///
/// Returns
/// -------
/// Capture
///
/// Raises
/// ------
/// Error
///     If the file cannot be read or is no capture; the sentence says what to do.
#[pyfunction]
#[pyo3(signature = (path, *, columns=None, units=None))]
pub(crate) fn read(
    py: Python<'_>,
    path: PathBuf,
    columns: Option<Bound<'_, PyDict>>,
    units: Option<Bound<'_, PyDict>>,
) -> PyResult<Capture> {
    let choice = choice(columns, units)?;
    let loaded = interruptible(py, move || LoadedCapture::load_chosen(&path, choice.as_ref()))?.map_err(raised)?;
    Ok(Capture::of(loaded))
}

/// A getter of a column that every capture has, and of one that may be absent.
macro_rules! column {
    ($slf:ident, $name:ident) => {{
        // SAFETY: the class is frozen and keeps its capture.
        #[allow(unsafe_code, reason = "the array looks at the capture's memory")]
        unsafe {
            view($slf.as_any(), &$slf.get().loaded.capture.$name)
        }
    }};
    ($slf:ident, $name:ident, optional) => {{
        let values = $slf.get().loaded.capture.$name.as_deref();
        // SAFETY: the class is frozen and keeps its capture.
        #[allow(unsafe_code, reason = "the array looks at the capture's memory")]
        values.map(|values| unsafe { view($slf.as_any(), values) }).transpose()
    }};
}

type Reals<'py> = Bound<'py, PyArray1<f64>>;
type Counts<'py> = Bound<'py, PyArray1<u64>>;
type Codes<'py> = Bound<'py, PyArray1<u32>>;

#[pymethods]
impl Capture {
    /// A capture of columns of your own; they are copied once.
    ///
    /// Parameters
    /// ----------
    /// t_s : array_like of float, shape (n,)
    ///     Time, s, rising.
    /// angle_rad : array_like of float, shape (n,)
    ///     Angle, rad.
    /// torque_mnm : array_like of float, shape (n,)
    ///     Torque that the knob takes, mNm; positive torque turns it towards positive angle.
    /// velocity_rad_s, acceleration_rad_s2 : array_like of float, shape (n,), optional
    ///     Velocity, rad/s, and acceleration, rad/s², where they were measured.
    /// axis : {"rotary", "linear"}
    ///     Of "linear", what was pressed or slid, columns hold mm in place of rad and N in place of mNm.
    /// name : str, optional
    ///     What tables, pages and error messages call it.
    ///
    /// Returns
    /// -------
    /// Capture
    ///
    /// Raises
    /// ------
    /// Error
    ///     If columns differ in length, a value is not finite, time does not rise, or there are fewer than three rows.
    #[staticmethod]
    #[pyo3(signature = (t_s, angle_rad, torque_mnm, *, velocity_rad_s=None, acceleration_rad_s2=None, axis="rotary", name="columns"))]
    fn from_columns(
        t_s: Column,
        angle_rad: Column,
        torque_mnm: Column,
        velocity_rad_s: Option<Column>,
        acceleration_rad_s2: Option<Column>,
        axis: &str,
        name: &str,
    ) -> PyResult<Self> {
        let axes = [Axis::Rotary, Axis::Linear];
        let axis = axes
            .into_iter()
            .find(|known| known.to_string() == axis)
            .ok_or_else(|| Error::new_err(format!("there is no axis '{axis}'; give \"rotary\" or \"linear\"")))?;
        let capture = archive::Capture::from_measured(archive::Capture {
            source: PathBuf::from(name),
            axis,
            t_s: t_s.0,
            angle_rad: angle_rad.0,
            velocity_rad_s: velocity_rad_s.map(|column| column.0),
            acceleration_rad_s2: acceleration_rad_s2.map(|column| column.0),
            torque_mnm: torque_mnm.0,
            ..archive::Capture::default()
        })
        .map_err(raised)?;
        Ok(Self::of(LoadedCapture { capture, ..LoadedCapture::default() }))
    }

    /// Time since the start of the run, s.
    #[getter]
    fn t_s<'py>(slf: &Bound<'py, Self>) -> PyResult<Reals<'py>> {
        column!(slf, t_s)
    }

    /// Encoder angle, rad.
    #[getter]
    fn angle_rad<'py>(slf: &Bound<'py, Self>) -> PyResult<Reals<'py>> {
        column!(slf, angle_rad)
    }

    /// Angular velocity, rad/s, if the capture has it.
    #[getter]
    fn velocity_rad_s<'py>(slf: &Bound<'py, Self>) -> PyResult<Option<Reals<'py>>> {
        column!(slf, velocity_rad_s, optional)
    }

    /// Angular acceleration, rad/s², if the capture has it.
    #[getter]
    fn acceleration_rad_s2<'py>(slf: &Bound<'py, Self>) -> PyResult<Option<Reals<'py>>> {
        column!(slf, acceleration_rad_s2, optional)
    }

    /// Torque that the knob takes from the rig, mNm.
    #[getter]
    fn torque_mnm<'py>(slf: &Bound<'py, Self>) -> PyResult<Reals<'py>> {
        column!(slf, torque_mnm)
    }

    /// Whether the control's contact was closed, 1 or 0, if somebody watched one.
    #[getter]
    fn contact<'py>(slf: &Bound<'py, Self>) -> PyResult<Option<Reals<'py>>> {
        column!(slf, contact, optional)
    }

    /// Angle that the excitation asked for, rad; NaN where it asked for none. None from a table.
    #[getter]
    fn commanded_angle_rad<'py>(slf: &Bound<'py, Self>) -> PyResult<Option<Reals<'py>>> {
        column!(slf, commanded_angle_rad, optional)
    }

    /// Torque commanded from the motor, mNm; NaN where it is unknown. None from a table, and of a replay, in which the motor does not drive
    /// the knob: its command there is ``capture["commanded_torque_mnm"]``.
    #[getter]
    fn commanded_torque_mnm<'py>(slf: &Bound<'py, Self>) -> PyResult<Option<Reals<'py>>> {
        let values = slf.get().loaded.commanded_torque_mnm();
        // SAFETY: the class is frozen and keeps its capture.
        #[allow(unsafe_code, reason = "the array looks at the capture's memory")]
        values.map(|values| unsafe { view(slf.as_any(), values) }).transpose()
    }

    /// Number of each sample in its run.
    #[getter]
    fn seq<'py>(slf: &Bound<'py, Self>) -> PyResult<Counts<'py>> {
        column!(slf, seq)
    }

    /// Scheduled tick of each sample; jumps where ticks were missed or samples lost.
    #[getter]
    fn tick<'py>(slf: &Bound<'py, Self>) -> PyResult<Counts<'py>> {
        column!(slf, tick)
    }

    /// State of the control loop at each sample; None from a table.
    #[getter]
    fn state<'py>(slf: &Bound<'py, Self>) -> PyResult<Option<Codes<'py>>> {
        column!(slf, state, optional)
    }

    /// Ticks that the loop missed directly before each sample; None from a table.
    #[getter]
    fn missed_ticks<'py>(slf: &Bound<'py, Self>) -> PyResult<Option<Codes<'py>>> {
        column!(slf, missed_ticks, optional)
    }

    /// Flags of each sample, bit by bit; None from a table.
    #[getter]
    fn flags<'py>(slf: &Bound<'py, Self>) -> PyResult<Option<Codes<'py>>> {
        column!(slf, flags, optional)
    }

    /// Names of the columns that the capture has.
    #[getter]
    fn columns(&self) -> Vec<&'static str> {
        archive::columns::of(&self.loaded.capture).map(|(name, _)| name).collect()
    }

    /// A column by its name in `columns`.
    ///
    /// Of what is pressed or slid the names are those of its axis, as ``travel_mm``, and attributes have the same columns under the
    /// names of what is turned.
    fn __getitem__<'py>(slf: &Bound<'py, Self>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        let capture = &slf.get().loaded.capture;
        let found = archive::columns::of(capture).find(|(known, _)| *known == name);
        let (_, values) = found.ok_or_else(|| {
            let known = slf.get().columns().join(", ");
            PyKeyError::new_err(format!("there is no column '{name}'; the capture has {known}"))
        })?;
        // SAFETY: the class is frozen and keeps its capture, which the values are borrowed from.
        #[allow(unsafe_code, reason = "the array looks at the capture's memory")]
        unsafe {
            Ok(match &values {
                Values::Reals(values) => view(slf.as_any(), values)?.into_any(),
                Values::Counts(values) => view(slf.as_any(), values)?.into_any(),
                Values::Codes(values) => view(slf.as_any(), values)?.into_any(),
            })
        }
    }

    fn __contains__(&self, name: &str) -> bool {
        self.columns().contains(&name)
    }

    /// "rotary" of a knob that was turned, "linear" of what was pressed or slid: columns hold mm in place of rad then, and N in
    /// place of mNm.
    #[getter]
    fn axis(&self) -> String {
        self.loaded.capture.axis.to_string()
    }

    /// Sample rate, Hz.
    #[getter]
    fn rate_hz(&self) -> f64 {
        self.loaded.capture.rate_hz
    }

    /// The file that it was read from, or the name that it was given.
    #[getter]
    fn source(&self) -> String {
        self.loaded.capture.source.display().to_string()
    }

    /// The model of the knob that a simulated rig turned; None for a real one or a table.
    #[getter]
    fn truth(&self) -> Option<Model> {
        self.loaded.truth.clone().map(Model::from)
    }

    /// What is known of the capture besides its samples: knob, rig, time, rate, missed ticks, gaps.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        to_dict(py, json(&analysis::facts(&self.loaded))?)
    }

    /// Write the capture where there is no file yet: an archive if the name ends in ``.mcap``, a table if it ends in ``.csv``.
    ///
    /// What is known of the rig is in an archive, and is written into a file beside a table, from where it is read again.
    ///
    /// Raises
    /// ------
    /// Error
    ///     If the name ends otherwise, there is a file already, or the folder cannot be written to.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase()).unwrap_or_default();
        py.detach(|| match ending.as_str() {
            "csv" => self.loaded.write_csv(&path).map(drop).map_err(raised),
            "mcap" => write_whole(&path, Replace::Nothing, |place| self.loaded.write_mcap_to(place)).map_err(raised),
            _ => Err(Error::new_err(format!(
                "{} has none of the endings that a capture can be saved as; name the file .mcap or .csv",
                path.display()
            ))),
        })
    }

    fn __len__(&self) -> usize {
        self.loaded.capture.len()
    }

    fn __repr__(&self) -> String {
        let capture = &self.loaded.capture;
        format!("<Capture {}: {} samples at {} Hz>", self.loaded.title(), capture.len(), capture.rate_hz)
    }

    /// Arrow's C interface: the types of the columns, with their units.
    fn __arrow_c_schema__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyCapsule>> {
        arrow::schema(py, &self.loaded)
    }

    /// Arrow's C interface: the columns as one struct array.
    #[pyo3(signature = (requested_schema=None))]
    fn __arrow_c_array__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<Bound<'py, PyAny>>,
    ) -> PyResult<ArrayCapsules<'py>> {
        // The interface permits a producer to keep its types.
        drop(requested_schema);
        arrow::array(py, &self.loaded)
    }

    /// Arrow's C interface: the columns as a stream of one batch.
    #[pyo3(signature = (requested_schema=None))]
    fn __arrow_c_stream__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyCapsule>> {
        drop(requested_schema);
        arrow::stream(py, &self.loaded)
    }

    /// Captures are read from their files where they are needed.
    fn __reduce__(&self) -> PyResult<()> {
        Err(not_pickled("a capture", "its path, and read it there"))
    }
}

impl Capture {
    pub(crate) fn of(loaded: LoadedCapture) -> Self {
        Self { loaded: Arc::new(loaded) }
    }
}
