//! Columns as an Apache Parquet file.

use std::sync::Arc;

use parquet::basic::{Compression, Encoding, Repetition, Type as PhysicalType};
use parquet::data_type::{DataType, DoubleType, Int32Type, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::Type;

use super::columns::{Column, Values};

/// The file's bytes: one group of rows, every value there.
///
/// Measured numbers hardly repeat, so dictionaries would only add to them.
///
/// # Errors
/// What the library says.
pub(super) fn bytes(columns: &[Column<'_>], metadata: Vec<(String, String)>) -> Result<Vec<u8>, ParquetError> {
    let fields = columns.iter().map(field).collect::<Result<Vec<_>, _>>()?;
    let schema = Arc::new(Type::group_type_builder("capture").with_fields(fields).build()?);
    let metadata = metadata.into_iter().map(|(key, value)| KeyValue::new(key, value)).collect();
    let properties = WriterProperties::builder()
        .set_compression(Compression::SNAPPY)
        .set_dictionary_enabled(false)
        .set_encoding(Encoding::PLAIN)
        .set_key_value_metadata(Some(metadata))
        .build();
    let mut file = SerializedFileWriter::new(Vec::new(), schema, Arc::new(properties))?;
    let mut group = file.next_row_group()?;
    for column in columns {
        match &column.values {
            Values::Real(values) => write::<DoubleType>(&mut group, values)?,
            Values::Count(values) => write::<Int64Type>(&mut group, values)?,
            Values::Code(values) => write::<Int32Type>(&mut group, values)?,
        }
    }
    group.close()?;
    file.into_inner()
}

fn field(column: &Column<'_>) -> Result<Arc<Type>, ParquetError> {
    let physical = match column.values {
        Values::Real(_) => PhysicalType::DOUBLE,
        Values::Count(_) => PhysicalType::INT64,
        Values::Code(_) => PhysicalType::INT32,
    };
    let field = Type::primitive_type_builder(column.name, physical).with_repetition(Repetition::REQUIRED).build()?;
    Ok(Arc::new(field))
}

fn write<Kind: DataType>(
    group: &mut SerializedRowGroupWriter<'_, Vec<u8>>,
    values: &[Kind::T],
) -> Result<(), ParquetError> {
    let Some(mut column) = group.next_column()? else {
        return Err(ParquetError::General("there are more columns than the schema has".to_owned()));
    };
    column.typed::<Kind>().write_batch(values, None, None)?;
    column.close()
}
