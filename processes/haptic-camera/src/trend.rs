//! `trend`: how parameters change over a table's captures.

use std::borrow::Cow;
use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};

use analysis::{CI95_ENDS, Row};
use anyhow::{Context as _, ensure};
use clap::Args;
use dynamics::Axis;
use parquet::file::reader::{FileReader as _, SerializedFileReader};
use parquet::record::Field;
use report::{Trend, TrendGroup, TrendParameter, TrendPoint};

use crate::command_line::outputs::ResultFiles;

#[derive(Debug, Args)]
pub struct TrendOptions {
    /// A file made by `table`
    #[arg(value_name = "TABLE.parquet")]
    pub table: PathBuf,
    /// How captures are grouped: by knob, to show wear and compare batches, or by rig, to show its drift
    #[arg(long, default_value = "knob", value_parser = GROUPS)]
    pub by: String,
    #[command(flatten)]
    pub results: ResultFiles,
}

const GROUPS: [&str; 2] = ["knob", "rig"];
const DAY_NS: f64 = 86_400e9;

pub fn run(options: &TrendOptions) -> anyhow::Result<()> {
    let (axis, trend) = read(&options.table, &options.by)?;
    let lines = trend.groups.iter().map(|group| words(&options.by, group));
    // Lines and JSON have the table's own names and units.
    let page = || axis.words(&report::trend_page(&trend)).into_owned();
    options.results.tell(Axis::default(), lines, &trend, page)
}

fn words(by: &str, group: &TrendGroup) -> String {
    let drifting = group.parameters.iter().filter(|one| one.drift.is_some_and(|drift| drift.is_significant()));
    let names: Vec<&str> = drifting.map(|one| one.name.as_str()).collect();
    let captures = group.parameters.iter().map(|one| one.captures).max().unwrap_or(0);
    let drift =
        if names.is_empty() { "no significant drift".to_owned() } else { format!("drift of {}", names.join(", ")) };
    let verdicts = if group.verdicts.is_empty() { String::new() } else { format!("; {}", group.verdicts_in_words()) };
    format!("{by} {}: {captures} captures; {drift}{verdicts}", group.name)
}

/// The trend, and the axis of what was captured.
fn read(table: &Path, by: &str) -> anyhow::Result<(Axis, Trend)> {
    let foreign = || format!("{} is not a table of captures; make one with `haptic-camera table`", table.display());
    let file = foreign_files::open(table).with_context(foreign)?;
    let rows = SerializedFileReader::new(file).with_context(foreign)?;
    let about = rows.metadata().file_metadata();
    let columns: Vec<String> = about.schema_descr().columns().iter().map(|column| column.name().to_owned()).collect();
    // A table with verdicts has further columns after those that every table has.
    let of_every_table = Row::columns(None).into_iter().map(|(name, _)| name);
    ensure!(of_every_table.eq(columns.iter().take(Row::columns(None).len()).cloned()), foreign());
    let metadata = about.key_value_metadata().into_iter().flatten();
    let units: HashMap<&str, &str> =
        metadata.filter_map(|pair| Some((pair.key.strip_prefix("unit.")?, pair.value.as_deref()?))).collect();
    // The unit of a load tells the axis; a table that somebody else wrote of rows has no units.
    let is_linear = units.get("residual_rms_mnm") == Some(&Axis::Linear.load_unit());
    let axis = if is_linear { Axis::Linear } else { Axis::Rotary };
    let mut trend = Trend {
        source: table.file_name().unwrap_or_default().to_string_lossy().into_owned(),
        by: by.to_owned(),
        software_version: env!("CARGO_PKG_VERSION").to_owned(),
        ..Trend::default()
    };
    let parameters: Vec<&String> =
        columns.iter().filter(|name| columns.contains(&format!("{name}{}", CI95_ENDS[0]))).collect();
    // Days since 1970 first: that of the first capture is not known before the last one is read.
    let mut groups: BTreeMap<String, Vec<Vec<TrendPoint>>> = BTreeMap::new();
    let mut first_days = f64::INFINITY;
    let mut verdicts: BTreeMap<String, BTreeMap<String, usize>> = BTreeMap::new();
    for row in rows.get_row_iter(None).with_context(foreign)? {
        let row = row.with_context(foreign)?;
        let cells: BTreeMap<&str, &Field> = row.get_column_iter().map(|(name, field)| (name.as_str(), field)).collect();
        let text = |name: &str| if let Some(Field::Str(text)) = cells.get(name) { Some(text.clone()) } else { None };
        let real = |name: &str| match cells.get(name)? {
            Field::Double(real) => Some(*real),
            Field::Long(count) => u64::try_from(*count).ok().map(|count| count as f64),
            _ => None,
        };
        if text("error").is_some() {
            trend.with_error += 1;
            continue;
        }
        let name = text(by).unwrap_or_else(|| "not known".to_owned());
        if let Some(verdict) = text("verdict") {
            *verdicts.entry(name.clone()).or_default().entry(verdict).or_default() += 1;
        }
        let group = groups.entry(name).or_insert_with(|| vec![Vec::new(); parameters.len()]);
        let Some(captured_at_ns) = real("captured_at_ns").filter(|time_ns| *time_ns > 0.0) else {
            trend.without_time += 1;
            continue;
        };
        let days = captured_at_ns / DAY_NS;
        first_days = first_days.min(days);
        for (points, name) in group.iter_mut().zip(&parameters) {
            let [low, high] = CI95_ENDS.map(|end| real(&format!("{name}{end}")));
            let ci95 = low.zip(high).map(|(low, high)| [low, high]);
            points.extend(real(name).map(|value| TrendPoint { days, value, ci95 }));
        }
    }
    let parameter = |(name, mut points): (&&String, Vec<TrendPoint>)| {
        points.iter_mut().for_each(|point| point.days -= first_days);
        let unit = units.get(name.as_str()).map(|unit| Cow::Borrowed(*unit));
        let unit = unit.or_else(|| Row::unit_of(name, None, axis)).unwrap_or_default();
        (!points.is_empty()).then(|| TrendParameter::of(name, &unit, points))
    };
    for (name, columns) in groups {
        let parameters = parameters.iter().zip(columns).filter_map(parameter).collect();
        let verdicts = verdicts.remove(&name).unwrap_or_default();
        trend.groups.push(TrendGroup { parameters, verdicts, name });
    }
    Ok((axis, trend))
}
