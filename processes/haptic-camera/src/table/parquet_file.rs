//! The rows as an Apache Parquet file, a group of rows at a time.

use std::fs::File;
use std::io::BufWriter;

use analysis::{Cell, Row};
use parquet::basic::{Repetition, Type as PhysicalType};
use parquet::data_type::{ByteArray, ByteArrayType, DataType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use sheet::Specification;

use crate::parquet_file::{begin, software, write_column};

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
        let fields = columns.iter().map(|(name, empty)| (name.as_str(), physical(empty)));
        let unit =
            |(name, _): &(String, Cell)| Some((format!("unit.{name}"), Row::unit_of(name, specification)?.to_owned()));
        let metadata = columns.iter().filter_map(unit).chain([software()]);
        let file = begin(place, "captures", fields, Repetition::OPTIONAL, metadata, WriterProperties::builder())?;
        Ok(Self { specification, file })
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

fn physical(empty: &Cell) -> PhysicalType {
    match empty {
        Cell::Text(_) => PhysicalType::BYTE_ARRAY,
        Cell::Count(_) => PhysicalType::INT64,
        Cell::Real(_) => PhysicalType::DOUBLE,
    }
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
