//! A capture as one row of a table.

use std::path::PathBuf;

use analysis::{Cell, Row};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyFloat, PyInt, PyString};

/// Read and fit a capture, as a row of the table that ``haptic-camera table`` makes.
///
/// Parameters
/// ----------
/// path : str or os.PathLike
///     The capture.
///
/// Returns
/// -------
/// dict of str to str, int, float or None
///     The row under the table's columns. A file that cannot be read or fitted raises nothing: its ``error`` says why.
#[pyfunction]
pub(crate) fn table_row(py: Python<'_>, path: PathBuf) -> PyResult<Bound<'_, PyDict>> {
    let row = py.detach(|| Row::of(&path));
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
/// Returns
/// -------
/// dict of str to type
///     ``str``, ``int`` or ``float`` by name, in the order of the table; any cell may be None.
#[pyfunction]
pub(crate) fn table_columns(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    let columns = PyDict::new(py);
    for (name, empty) in Row::columns() {
        match empty {
            Cell::Text(_) => columns.set_item(name, py.get_type::<PyString>())?,
            Cell::Count(_) => columns.set_item(name, py.get_type::<PyInt>())?,
            Cell::Real(_) => columns.set_item(name, py.get_type::<PyFloat>())?,
        }
    }
    Ok(columns)
}
