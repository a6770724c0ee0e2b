//! `export`: captures and models in the formats of other programs.

mod simulator;

use std::path::{Path, PathBuf};

use anyhow::{Context as _, anyhow, bail};
use archive::attachment;
use archive::columns::{self, Values};
use archive::whole_file::write_bytes;
use clap::Args;
use dynamics::{Model, knobs};
use loaded_capture::LoadedCapture;
use parquet::basic::{Encoding, Repetition, Type as PhysicalType};
use parquet::data_type::{DoubleType, Int32Type, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use simulator_formats::{TableSpan, TabulationError, TorqueOverAngle};

use crate::command_line::ColumnOptions;
use crate::command_line::outputs::{kind, write};
use crate::load;
use crate::outcome::{UsageError, say, with_options};
use crate::parquet_file::{begin, software, write_column};

#[derive(Debug, Args)]
pub struct ExportOptions {
    /// What to export: a capture, or a model as file or as 1 to 5 for the paper's knobs
    #[arg(value_name = "CAPTURE|MODEL.toml|1…5")]
    pub source: String,
    /// The file to write; its extension selects the format: a capture as .csv or .parquet, a model's torque over the angle
    /// as .csv or .h, a model for simulators as .xml (MuJoCo), .urdf (and a file for Isaac Lab) or .fmu (FMI 3.0),
    /// a model for SmartKnob's firmware as .json
    #[arg(long, value_name = "FILE")]
    pub out: PathBuf,
    #[command(flatten)]
    pub columns: ColumnOptions,
    /// Number of points in a model's table [default: 256]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(4..=65_536))]
    pub points: Option<u32>,
    /// Angle that a model's table covers [default: one period of the detents, a turn without detents]
    #[arg(long, value_enum, value_name = "SPAN")]
    pub over: Option<TableSpan>,
    /// Torque per volt of SmartKnob's motor, mNm/V
    #[arg(long, value_name = "MNM_PER_V", value_parser = positive)]
    pub motor_mnm_per_v: Option<f64>,
    /// Compute the torque that a simulator's format leaves out along this capture's motion [default: the sweep linear-chirp]
    #[arg(long, value_name = "CAPTURE")]
    pub along: Option<PathBuf>,
}

const POINTS: u32 = 256;

impl ExportOptions {
    /// The first option that was given and that an export of this kind has no use for.
    fn unused(&self, is_model: bool, ending: &str) -> Option<&'static str> {
        let is_table = is_model && matches!(ending, "csv" | "h");
        let is_simulated = is_model && matches!(ending, "xml" | "urdf" | "fmu" | "json");
        let options = [
            ("--columns", self.columns.columns.is_some(), !is_model),
            ("--points", self.points.is_some(), is_table),
            ("--over", self.over.is_some(), is_table),
            ("--along", self.along.is_some(), is_simulated),
            ("--motor-mnm-per-v", self.motor_mnm_per_v.is_some(), is_model && ending == "json"),
        ];
        options.into_iter().find(|(_, is_given, is_used)| *is_given && !is_used).map(|(option, ..)| option)
    }
}

pub(crate) fn positive(text: &str) -> Result<f64, String> {
    let number: f64 = text.parse().map_err(|_| "it is not a number".to_owned())?;
    if number.is_finite() && number > 0.0 { Ok(number) } else { Err("it must be greater than zero".to_owned()) }
}

pub fn run(options: &ExportOptions) -> anyhow::Result<()> {
    let source = Path::new(&options.source);
    let ending = options.out.extension().map(|ending| ending.to_string_lossy().to_lowercase()).unwrap_or_default();
    let is_model = load::names_model(&options.source);
    let what = if is_model { "model" } else { "capture" };
    if let Some(option) = options.unused(is_model, &ending) {
        bail!(UsageError(anyhow!("{option} has no effect on a {what} that is exported as .{ending}; leave it out")));
    }
    let model = || knobs::named(&options.source);
    let done = match (is_model, ending.as_str()) {
        (true, "h") => firmware_header(&model()?, options)?,
        (true, "xml") => {
            let model = model()?;
            simulator::write_export(options, &model, &simulator_formats::mjcf(&model)?)?
        }
        (true, "urdf") => simulator::urdf(&model()?, options)?,
        (true, "fmu") => simulator::fmu(&model()?, options)?,
        (true, "json") => simulator::smartknob(options)?,
        (true, "csv") => {
            let table = tabulated(&model()?, options)?;
            write(&options.out, kind::DATA, &table.to_csv())?;
            table.in_words()
        }
        (false, "parquet") => capture_as_parquet(source, options)?,
        (false, "csv") => capture_as_csv(source, options)?,
        _ => {
            let known = if is_model { ".csv, .h, .xml, .urdf, .fmu or .json" } else { ".csv or .parquet" };
            let out = options.out.display();
            bail!(UsageError(anyhow!("{out} has an unknown extension; a {what} is exported as {known}")))
        }
    };
    format!("{}: {done}", options.out.display()).lines().for_each(say);
    Ok(())
}

/// Writes the columns that `fit` reads and, beside the table, the calibration, so that a fit of the table gives the same result.
fn capture_as_csv(source: &Path, options: &ExportOptions) -> anyhow::Result<String> {
    let loaded = load::load_chosen(source, &options.columns)?;
    let calibration = loaded.write_csv(&options.out)?;
    let units = loaded.capture.axis.words("angles in rad, torque in mNm, time in s");
    let beside = calibration.map_or_else(String::new, |place| {
        format!("\n{}: the rig's calibration, which `fit` reads along with the table", place.display())
    });
    Ok(format!("{} samples; {units}{beside}", loaded.capture.len()))
}

fn capture_as_parquet(source: &Path, options: &ExportOptions) -> anyhow::Result<String> {
    let loaded = load::load_chosen(source, &options.columns)?;
    let (bytes, columns) =
        as_parquet(&loaded).with_context(|| format!("{} cannot be written as Parquet", source.display()))?;
    write_bytes(&options.out, kind::DATA, &bytes)?;
    Ok(format!("{} samples, {columns} columns with their units", loaded.capture.len()))
}

/// Attachments of an archive that are copied into the metadata.
const TAKEN_ALONG: [&str; 4] = [attachment::RUN, attachment::CALIBRATION, attachment::EXCITATION, attachment::MODEL];

/// The bytes of the Parquet file and the number of its columns: one row group, without missing values.
///
/// Measured numbers hardly repeat, so dictionaries would only add to them.
fn as_parquet(loaded: &LoadedCapture) -> Result<(Vec<u8>, usize), ParquetError> {
    let columns: Vec<(&str, Values<'_>)> = columns::of(&loaded.capture).collect();
    let fields = columns.iter().map(|(name, values)| {
        let physical = match values {
            Values::Reals(_) => PhysicalType::DOUBLE,
            Values::Counts(_) => PhysicalType::INT64,
            Values::Codes(_) => PhysicalType::INT32,
        };
        (*name, physical)
    });
    let properties = WriterProperties::builder().set_dictionary_enabled(false).set_encoding(Encoding::PLAIN);
    let metadata = metadata(loaded, &columns);
    let mut file = begin(Vec::new(), "capture", fields, Repetition::REQUIRED, metadata, properties)?;
    let mut group = file.next_row_group()?;
    for (_, values) in &columns {
        match values {
            Values::Reals(values) => write_column::<DoubleType, _>(&mut group, values.iter().copied().map(Some))?,
            Values::Counts(values) => {
                write_column::<Int64Type, _>(&mut group, values.iter().map(|count| Some(count.cast_signed())))?;
            }
            Values::Codes(values) => {
                write_column::<Int32Type, _>(&mut group, values.iter().map(|code| Some(code.cast_signed())))?;
            }
        }
    }
    group.close()?;
    Ok((file.into_inner()?, columns.len()))
}

/// What the file says of itself: the unit of every column, the rate, and what the archive had attached.
fn metadata(loaded: &LoadedCapture, columns: &[(&str, Values<'_>)]) -> Vec<(String, String)> {
    let capture = &loaded.capture;
    let own = [
        ("source", capture.source.display().to_string()),
        ("rate_hz", capture.rate_hz.to_string()),
        ("missing_samples", capture.lost_samples().to_string()),
    ];
    let units =
        columns.iter().filter_map(|(name, _)| Some((format!("unit.{name}"), archive::unit_of(name)?.to_owned())));
    let attached = TAKEN_ALONG.iter().filter_map(|name| {
        let text = capture.attached_text(name).filter(|text| !text.is_empty())?;
        Some(((*name).to_owned(), text.to_owned()))
    });
    let own = own.map(|(key, text)| (key.to_owned(), text));
    [software()].into_iter().chain(own).chain(units).chain(attached).collect()
}

fn tabulated(model: &Model, options: &ExportOptions) -> anyhow::Result<TorqueOverAngle> {
    TorqueOverAngle::of(model, options.points.unwrap_or(POINTS), options.over).map_err(|error| match error {
        TabulationError::NoPeriod(_) => with_options(error, "--over turn"),
        TabulationError::NoTorque(_) => error.into(),
    })
}

/// The header of a knob without any torque that depends on the angle holds its inertia and friction alone.
fn firmware_header(model: &Model, options: &ExportOptions) -> anyhow::Result<String> {
    let has_table = model.effects.iter().any(|effect| effect.kind().steepest_mnm_rad.is_some());
    let table = has_table.then(|| tabulated(model, options)).transpose()?;
    let guard = options.out.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    write(&options.out, kind::HEADER, &simulator_formats::c_header(model, table.as_ref(), &options.source, &guard))?;
    Ok(table.map_or_else(|| "no torque that depends on the angle".to_owned(), |table| table.in_words()))
}
