//! A capture's columns as an Apache Parquet file.

use std::sync::Arc;

use archive::columns::{self, Values};
use loaded_capture::LoadedCapture;
use parquet::basic::{Compression, Encoding, Repetition, Type as PhysicalType};
use parquet::data_type::{DoubleType, Int32Type, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;

use super::TAKEN_ALONG;
use crate::table::write_column;

/// The file's bytes and the number of its columns: one group of rows, every value there.
///
/// Measured numbers hardly repeat, so dictionaries would only add to them.
pub(super) fn bytes(loaded: &LoadedCapture) -> Result<(Vec<u8>, usize), ParquetError> {
    let columns: Vec<(&str, Values<'_>)> = columns::of(&loaded.capture).collect();
    let fields = columns.iter().map(|(name, values)| field(name, values)).collect::<Result<Vec<_>, _>>()?;
    let schema = Arc::new(Type::group_type_builder("capture").with_fields(fields).build()?);
    let properties = WriterProperties::builder()
        .set_compression(Compression::SNAPPY)
        .set_dictionary_enabled(false)
        .set_encoding(Encoding::PLAIN)
        .set_key_value_metadata(Some(metadata(loaded, &columns)))
        .build();
    let mut file = SerializedFileWriter::new(Vec::new(), schema, Arc::new(properties))?;
    let mut group = file.next_row_group()?;
    for (_, values) in &columns {
        match values {
            Values::Reals(values) => write_column::<DoubleType, _>(&mut group, values, None)?,
            Values::Counts(values) => {
                let counts: Vec<i64> = values.iter().map(|&count| i64::try_from(count).unwrap_or(i64::MAX)).collect();
                write_column::<Int64Type, _>(&mut group, &counts, None)?;
            }
            Values::Codes(values) => {
                let codes: Vec<i32> = values.iter().map(|&code| i32::try_from(code).unwrap_or(i32::MAX)).collect();
                write_column::<Int32Type, _>(&mut group, &codes, None)?;
            }
        }
    }
    group.close()?;
    Ok((file.into_inner()?, columns.len()))
}

fn field(name: &str, values: &Values<'_>) -> Result<Arc<Type>, ParquetError> {
    let physical = match values {
        Values::Reals(_) => PhysicalType::DOUBLE,
        Values::Counts(_) => PhysicalType::INT64,
        Values::Codes(_) => PhysicalType::INT32,
    };
    let field = Type::primitive_type_builder(name, physical).with_repetition(Repetition::REQUIRED).build()?;
    Ok(Arc::new(field))
}

/// What the file says of itself: the unit of every column, the rate, and what the archive had attached.
fn metadata(loaded: &LoadedCapture, columns: &[(&str, Values<'_>)]) -> Vec<KeyValue> {
    let capture = &loaded.capture;
    let own = [
        ("software", format!("haptic-camera {}", env!("CARGO_PKG_VERSION"))),
        ("source", capture.source.display().to_string()),
        ("rate_hz", capture.rate_hz.to_string()),
        ("missing_samples", capture.gaps.iter().map(|gap| gap.count).sum::<u64>().to_string()),
    ];
    let own = own.into_iter().map(|(key, text)| KeyValue::new(key.to_owned(), text));
    let units = columns.iter().filter_map(|(name, _)| {
        let unit = archive::unit_of(name)?;
        Some(KeyValue::new(format!("unit.{name}"), unit.to_owned()))
    });
    let attached = TAKEN_ALONG.iter().filter_map(|name| {
        let text = capture.attached_text(name).filter(|text| !text.is_empty())?;
        Some(KeyValue::new((*name).to_owned(), text.to_owned()))
    });
    own.chain(units).chain(attached).collect()
}
