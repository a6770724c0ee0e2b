//! A capture as one row of a table.

use std::path::PathBuf;

use analysis::{Cell, Row, load_specification};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyFloat, PyInt, PyString};
use sheet::Specification;

use crate::error::raised;

/// Read and fit a capture, as a row of the table that ``haptic-camera table`` makes.
///
/// Parameters
/// ----------
/// path : str or os.PathLike
///     The capture.
/// spec : str or os.PathLike, optional
///     A specification, as for `judge`: the row then has the figures of the sheet and the verdict too.
///
/// Returns
/// -------
/// dict of str to str, int, float or None
///     The row under the table's columns. A file that cannot be read or fitted raises nothing: its ``error`` says why.
///
/// Raises
/// ------
/// Error
///     If the specification cannot be read.
#[pyfunction]
#[pyo3(signature = (path, *, spec=None))]
pub(crate) fn table_row(py: Python<'_>, path: PathBuf, spec: Option<PathBuf>) -> PyResult<Bound<'_, PyDict>> {
    let row = py.detach(|| PyResult::Ok(Row::of(&path, specification(spec)?.as_ref())))?;
    let cells = PyDict::new(py);
    for (name, cell) in row.cells() {
        match cell {
            Cell::Text(text) => cells.set_item(name, text)?,
            Cell::Count(count) => cells.set_item(name, count)?,
            Cell::Real(real) => cells.set_item(name, real)?,
        }
    }
    Ok(cells)
}

/// The columns of a table's row, with their types.
///
/// Parameters
/// ----------
/// spec : str or os.PathLike, optional
///     The specification that the rows are made with.
///
/// Returns
/// -------
/// dict of str to type
///     ``str``, ``int`` or ``float`` by name, in the order of the table; any cell may be None.
#[pyfunction]
#[pyo3(signature = (*, spec=None))]
pub(crate) fn table_columns(py: Python<'_>, spec: Option<PathBuf>) -> PyResult<Bound<'_, PyDict>> {
    let columns = PyDict::new(py);
    for (name, empty) in Row::columns(specification(spec)?.as_ref()) {
        match empty {
            Cell::Text(_) => columns.set_item(name, py.get_type::<PyString>())?,
            Cell::Count(_) => columns.set_item(name, py.get_type::<PyInt>())?,
            Cell::Real(_) => columns.set_item(name, py.get_type::<PyFloat>())?,
        }
    }
    Ok(columns)
}

fn specification(path: Option<PathBuf>) -> PyResult<Option<Specification>> {
    path.map(|path| load_specification(&path)).transpose().map_err(raised)
}
