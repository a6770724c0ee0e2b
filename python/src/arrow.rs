//! A capture through Arrow's C interface (<https://arrow.apache.org/docs/format/CDataInterface/PyCapsuleInterface.html>): pandas,
//! polars, DuckDB and pyarrow take it as it lies in memory.

use std::collections::HashMap;
use std::ptr::NonNull;
use std::sync::Arc;

use archive::columns::{self, Values};
use arrow_array::ffi::{FFI_ArrowArray, FFI_ArrowSchema, to_ffi};
use arrow_array::ffi_stream::FFI_ArrowArrayStream;
use arrow_array::{
    Array as _, ArrayRef, Float64Array, RecordBatch, RecordBatchIterator, StructArray, UInt32Array, UInt64Array,
};
use arrow_buffer::{Buffer, ScalarBuffer};
use arrow_schema::{ArrowError, Field, Schema};
use loaded_capture::LoadedCapture;
use pyo3::prelude::*;
use pyo3::types::PyCapsule;

use crate::error::raised;

/// The columns of a capture, as they lie in memory, with the unit of each.
fn batch(loaded: &Arc<LoadedCapture>) -> Result<RecordBatch, ArrowError> {
    let mut fields = Vec::new();
    let mut arrays: Vec<ArrayRef> = Vec::new();
    for (name, values) in columns::of(&loaded.capture) {
        let array: ArrayRef = match &values {
            Values::Reals(values) => Arc::new(Float64Array::new(shared(loaded, values), None)),
            Values::Counts(values) => Arc::new(UInt64Array::new(shared(loaded, values), None)),
            Values::Codes(values) => Arc::new(UInt32Array::new(shared(loaded, values), None)),
        };
        let unit = HashMap::from([("unit".to_owned(), archive::unit_of(name).unwrap_or_default().to_owned())]);
        fields.push(Field::new(name, array.data_type().clone(), false).with_metadata(unit));
        arrays.push(array);
    }
    let rate = HashMap::from([("rate_hz".to_owned(), loaded.capture.rate_hz.to_string())]);
    RecordBatch::try_new(Arc::new(Schema::new(fields).with_metadata(rate)), arrays)
}

/// A column's memory, which the capture keeps.
#[allow(unsafe_code, reason = "Arrow takes memory that it did not allocate")]
fn shared<T: arrow_buffer::ArrowNativeType>(loaded: &Arc<LoadedCapture>, values: &[T]) -> ScalarBuffer<T> {
    let (place, bytes) = (NonNull::from(values).cast(), size_of_val(values));
    let owner: Arc<LoadedCapture> = Arc::clone(loaded);
    // SAFETY: the columns of `owner` are neither moved nor written to while anybody holds it.
    ScalarBuffer::from(unsafe { Buffer::from_custom_allocation(place, bytes, owner) })
}

pub(crate) fn schema<'py>(py: Python<'py>, loaded: &Arc<LoadedCapture>) -> PyResult<Bound<'py, PyCapsule>> {
    let schema = FFI_ArrowSchema::try_from(batch(loaded).map_err(raised)?.schema().as_ref()).map_err(raised)?;
    PyCapsule::new_with_value(py, schema, c"arrow_schema")
}

pub(crate) type ArrayCapsules<'py> = (Bound<'py, PyCapsule>, Bound<'py, PyCapsule>);

pub(crate) fn array<'py>(py: Python<'py>, loaded: &Arc<LoadedCapture>) -> PyResult<ArrayCapsules<'py>> {
    let batch = batch(loaded).map_err(raised)?;
    let schema = FFI_ArrowSchema::try_from(batch.schema().as_ref()).map_err(raised)?;
    let (array, _): (FFI_ArrowArray, _) = to_ffi(&StructArray::from(batch).to_data()).map_err(raised)?;
    Ok((PyCapsule::new_with_value(py, schema, c"arrow_schema")?, PyCapsule::new_with_value(py, array, c"arrow_array")?))
}

pub(crate) fn stream<'py>(py: Python<'py>, loaded: &Arc<LoadedCapture>) -> PyResult<Bound<'py, PyCapsule>> {
    let batch = batch(loaded).map_err(raised)?;
    let schema = batch.schema();
    let stream = FFI_ArrowArrayStream::new(Box::new(RecordBatchIterator::new([Ok(batch)], schema)));
    PyCapsule::new_with_value(py, stream, c"arrow_array_stream")
}
