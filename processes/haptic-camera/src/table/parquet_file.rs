//! The rows as an Apache Parquet file, a group of rows at a time.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::sync::Arc;

use analysis::{Cell, Row};
use parquet::basic::{Compression, ConvertedType, Repetition, Type as PhysicalType};
use parquet::data_type::{ByteArray, ByteArrayType, DataType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::Type;
use sheet::Specification;

pub(super) struct Table<'spec> {
    specification: Option<&'spec Specification>,
    file: SerializedFileWriter<BufWriter<File>>,
}

impl<'spec> Table<'spec> {
    /// Begins a table at a place; the units of its columns go into its key-value metadata.
    pub(super) fn begin(
        place: BufWriter<File>,
        specification: Option<&'spec Specification>,
    ) -> Result<Self, ParquetError> {
        let columns = Row::columns(specification);
        let fields = columns.iter().map(|(name, empty)| field(name, empty)).collect::<Result<Vec<_>, _>>()?;
        let schema = Arc::new(Type::group_type_builder("captures").with_fields(fields).build()?);
        let units = columns.iter().filter_map(|(name, _)| {
            Some(KeyValue::new(format!("unit.{name}"), Row::unit_of(name, specification)?.to_owned()))
        });
        let software = KeyValue::new("software".to_owned(), format!("haptic-camera {}", env!("CARGO_PKG_VERSION")));
        let properties = WriterProperties::builder()
            .set_compression(Compression::SNAPPY)
            .set_key_value_metadata(Some(units.chain([software]).collect()))
            .build();
        Ok(Self { specification, file: SerializedFileWriter::new(place, schema, Arc::new(properties))? })
    }

    /// Adds rows, each with a cell for every column.
    pub(super) fn add(&mut self, rows: &[Vec<Cell>]) -> Result<(), ParquetError> {
        let mut group = self.file.next_row_group()?;
        for (place, (_, empty)) in Row::columns(self.specification).iter().enumerate() {
            let cells = rows.iter().map(|row| &row[place]);
            match empty {
                Cell::Text(_) => write::<ByteArrayType>(&mut group, cells.map(text))?,
                Cell::Count(_) => write::<Int64Type>(&mut group, cells.map(count))?,
                Cell::Real(_) => write::<DoubleType>(&mut group, cells.map(real))?,
            }
        }
        group.close()?;
        Ok(())
    }

    pub(super) fn end(self) -> Result<(), ParquetError> {
        self.file.close().map(drop)
    }
}

fn field(name: &str, empty: &Cell) -> Result<Arc<Type>, ParquetError> {
    let (physical, converted) = match empty {
        Cell::Text(_) => (PhysicalType::BYTE_ARRAY, ConvertedType::UTF8),
        Cell::Count(_) => (PhysicalType::INT64, ConvertedType::NONE),
        Cell::Real(_) => (PhysicalType::DOUBLE, ConvertedType::NONE),
    };
    let field = Type::primitive_type_builder(name, physical).with_converted_type(converted);
    Ok(Arc::new(field.with_repetition(Repetition::OPTIONAL).build()?))
}

fn text(cell: &Cell) -> Option<ByteArray> {
    if let Cell::Text(Some(text)) = cell { Some(ByteArray::from(text.as_str())) } else { None }
}

fn count(cell: &Cell) -> Option<i64> {
    if let Cell::Count(Some(count)) = cell { i64::try_from(*count).ok() } else { None }
}

fn real(cell: &Cell) -> Option<f64> {
    if let Cell::Real(real) = cell { *real } else { None }
}

/// Writes a column: the values that are there, and for each row whether it has one.
fn write<Kind: DataType>(
    group: &mut SerializedRowGroupWriter<'_, BufWriter<File>>,
    cells: impl Iterator<Item = Option<Kind::T>>,
) -> Result<(), ParquetError> {
    let (mut there, mut values) = (Vec::new(), Vec::new());
    for cell in cells {
        there.push(i16::from(cell.is_some()));
        values.extend(cell);
    }
    write_column::<Kind, _>(group, &values, Some(&there))
}

/// Writes a column of values, and for each row whether it has one where not all have.
pub(crate) fn write_column<Kind: DataType, To: Write + Send>(
    group: &mut SerializedRowGroupWriter<'_, To>,
    values: &[Kind::T],
    there: Option<&[i16]>,
) -> Result<(), ParquetError> {
    let Some(mut column) = group.next_column()? else {
        return Err(ParquetError::General("there are more columns than the schema has".to_owned()));
    };
    column.typed::<Kind>().write_batch(values, there, None)?;
    column.close()
}
