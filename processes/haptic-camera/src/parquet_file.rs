//! Apache Parquet files of named columns.

use std::io::Write;
use std::sync::Arc;

use parquet::basic::{Compression, ConvertedType, Repetition, Type as PhysicalType};
use parquet::data_type::DataType;
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterPropertiesBuilder;
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::Type;

/// The metadata entry that names this program and its version in every file.
pub fn software() -> (String, String) {
    ("software".to_owned(), format!("haptic-camera {}", env!("CARGO_PKG_VERSION")))
}

/// Begins a file of these columns; `repetition` says whether values may be missing.
pub fn begin<'a, To: Write + Send>(
    to: To,
    name: &str,
    columns: impl IntoIterator<Item = (&'a str, PhysicalType)>,
    repetition: Repetition,
    metadata: impl IntoIterator<Item = (String, String)>,
    properties: WriterPropertiesBuilder,
) -> Result<SerializedFileWriter<To>, ParquetError> {
    let field = |(name, physical)| {
        let converted = if physical == PhysicalType::BYTE_ARRAY { ConvertedType::UTF8 } else { ConvertedType::NONE };
        let field = Type::primitive_type_builder(name, physical).with_converted_type(converted);
        field.with_repetition(repetition).build().map(Arc::new)
    };
    let fields = columns.into_iter().map(field).collect::<Result<Vec<_>, _>>()?;
    let schema = Arc::new(Type::group_type_builder(name).with_fields(fields).build()?);
    let metadata = metadata.into_iter().map(|(key, text)| KeyValue::new(key, text)).collect();
    let properties = properties.set_compression(Compression::SNAPPY).set_key_value_metadata(Some(metadata)).build();
    SerializedFileWriter::new(to, schema, Arc::new(properties))
}

/// Writes a column, a cell for each row: nothing where the row has no value, which only an optional column permits.
pub fn write_column<Kind: DataType, To: Write + Send>(
    group: &mut SerializedRowGroupWriter<'_, To>,
    cells: impl Iterator<Item = Option<Kind::T>>,
) -> Result<(), ParquetError> {
    let (mut there, mut values) = (Vec::new(), Vec::new());
    for cell in cells {
        there.push(i16::from(cell.is_some()));
        values.extend(cell);
    }
    let Some(mut column) = group.next_column()? else {
        return Err(ParquetError::General("there are more columns than the schema has".to_owned()));
    };
    column.typed::<Kind>().write_batch(&values, Some(&there), None)?;
    column.close()
}
