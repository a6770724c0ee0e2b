//! Errors as exceptions, in the sentences that the command line prints.

use std::fmt::Display;

use pyo3::exceptions::PyValueError;
use pyo3::{PyErr, create_exception};

create_exception!(
    haptic_camera,
    Error,
    PyValueError,
    "What is wrong with a file, a capture or a value, in one sentence that says what to do."
);

/// The exception with an error's sentence, in one line that commands no terminal.
pub(crate) fn raised(error: impl Display) -> PyErr {
    Error::new_err(foreign_files::one_line(&error.to_string()))
}
