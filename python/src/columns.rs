//! Columns as NumPy arrays that look at Rust's memory.

use numpy::ndarray::{ArrayView1, ShapeBuilder as _};
use numpy::{Element, PyArray1};
use pyo3::prelude::*;

/// A read-only array over `values`, which `owner` keeps.
///
/// # Safety
/// `owner` must be a frozen object whose memory holds `values` for as long as it lives.
#[allow(unsafe_code, reason = "the array looks at memory that only its owner keeps")]
pub(crate) unsafe fn view<'py, T: Element>(
    owner: &Bound<'py, PyAny>,
    values: &[T],
) -> PyResult<Bound<'py, PyArray1<T>>> {
    // SAFETY: the caller's promise; nothing frozen is ever moved or written to.
    read_only(unsafe { PyArray1::borrow_from_array(&ArrayView1::from(values), owner.clone()) })
}

/// The same over one field of every element.
///
/// # Safety
/// As for [`view`].
#[allow(unsafe_code, reason = "the array looks at memory that only its owner keeps")]
pub(crate) unsafe fn field_view<'py, Row>(
    owner: &Bound<'py, PyAny>,
    rows: &[Row],
    field: fn(&Row) -> &f64,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let Some(first) = rows.first() else {
        // SAFETY: the caller's promise.
        return unsafe { view(owner, &[]) };
    };
    const { assert!(size_of::<Row>().is_multiple_of(size_of::<f64>())) };
    let shape = rows.len().strides(size_of::<Row>() / size_of::<f64>());
    // SAFETY: the field of row n lies n rows after that of the first, all within `rows`.
    let values = unsafe { ArrayView1::from_shape_ptr(shape, std::ptr::from_ref(field(first))) };
    // SAFETY: the caller's promise.
    read_only(unsafe { PyArray1::borrow_from_array(&values, owner.clone()) })
}

fn read_only<T: Element>(array: Bound<'_, PyArray1<T>>) -> PyResult<Bound<'_, PyArray1<T>>> {
    array.call_method1("setflags", (false,))?;
    Ok(array)
}
