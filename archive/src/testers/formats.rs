//! The formats that are known by what stands in their first lines.

use shared_types::{Axis, Quantity};

use super::layout::{Contact, Layout, Source, Time};
use super::table::RawTable;

/// Everything that is known; the first that recognises a table has it.
const FORMATS: [fn(&RawTable) -> Option<Layout>; 6] =
    [open_switch_curve_meter, force_recorder, force_recorder_rows, button_bench, two_columns, ours];

/// Where everything lies in a table of a known format.
pub(super) fn recognise(table: &RawTable) -> Option<Layout> {
    FORMATS.iter().find_map(|format| format(table))
}

fn source(column: usize, quantity: Quantity, unit: &str) -> Option<Source> {
    Some(Source { column, factor: quantity.factor(unit)? })
}

/// A linear axis without time or contact.
fn pressed(travel: (usize, &str), force: (usize, &str)) -> Option<Layout> {
    Some(Layout {
        axis: Axis::Linear,
        position: source(travel.0, Quantity::Travel, travel.1)?,
        load: source(force.0, Quantity::Force, force.1)?,
        time: Time::None,
        contact: None,
    })
}

/// Open-Switch-Curve-Meter: `Millis,Steps,Travel (mm),Scale raw,Scale (grams)`.
fn open_switch_curve_meter(table: &RawTable) -> Option<Layout> {
    let travel = table.place("Travel (mm)")?;
    let force = table.place("Scale (grams)")?;
    let time = Time::Column(source(table.place("Millis")?, Quantity::Time, "ms")?);
    Some(Layout { time, ..pressed((travel, "mm"), (force, "gf"))? })
}

/// IMADA Force Recorder, high resolution: lines such as `UNIT = gf,mm` and `RECORDING RATE = 0.0005`, then force and
/// displacement.
fn force_recorder(table: &RawTable) -> Option<Layout> {
    let setting = |key: &str| {
        table.preamble.iter().find_map(|line| {
            let (name, value) = line.get(0)?.split_once('=')?;
            (name.trim() == key).then(|| (value.trim().to_owned(), line.get(1).unwrap_or_default().to_owned()))
        })
    };
    setting("MAX FORCE")?;
    let (force, travel) = setting("UNIT")?;
    let interval_s = setting("RECORDING RATE").and_then(|(rate, _)| table.number(&rate)).filter(|rate| *rate > 0.0);
    let time = interval_s.map_or(Time::None, Time::EachRow);
    Some(Layout { time, ..pressed((1, &travel), (0, &force))? })
}

/// IMADA Force Recorder, rows with units: `No.,Force,Unit,Displacement,Unit,Judge,…`.
fn force_recorder_rows(table: &RawTable) -> Option<Layout> {
    let (force, travel) = (table.place("Force")?, table.place("Displacement")?);
    let unit = |column: usize| table.rows.first()?.get(column + 1).filter(|_| table.header[column + 1] == "Unit");
    (table.header.len() > force.max(travel) + 1).then_some(())?;
    pressed((travel, unit(travel)?), (force, unit(force)?))
}

/// Automotive button benches: `Date Time , Index ,Force (N),Voltage (V),Linear (mm)`.
fn button_bench(table: &RawTable) -> Option<Layout> {
    let layout = pressed((table.place("Linear (mm)")?, "mm"), (table.place("Force (N)")?, "N"))?;
    let time = table.place("Date Time").map_or(Time::None, Time::Clock);
    Some(Layout { time, contact: table.place("Voltage (V)").map(Contact::Voltage), ..layout })
}

/// Tables of keyboard switches: `force` in gf and `displacement` in mm.
fn two_columns(table: &RawTable) -> Option<Layout> {
    // A table that has its units in a column says itself that they are not these.
    if table.header.iter().any(|name| name.eq_ignore_ascii_case("Unit")) {
        return None;
    }
    let layout = pressed((table.place("displacement")?, "mm"), (table.place("force")?, "gf"))?;
    Some(Layout { contact: table.place("judge").map(Contact::Flag), ..layout })
}

/// Our own column names, with or without a time.
fn ours(table: &RawTable) -> Option<Layout> {
    let time = match table.place("t_s") {
        Some(column) => Time::Column(source(column, Quantity::Time, "s")?),
        // What the unit of another time is, its owner has to say.
        None if table.header.iter().any(|name| is_time(name)) => return None,
        None => Time::None,
    };
    let pair = |position: &str, load: &str| Some((table.place(position)?, table.place(load)?));
    let (axis, (position, load)) = match pair("angle_rad", "torque_mnm") {
        Some(columns) => (Axis::Rotary, columns),
        None => (Axis::Linear, pair("travel_mm", "force_n")?),
    };
    let plain = |column| Source { column, factor: 1.0 };
    let contact = table.place("contact").map(Contact::Flag);
    Some(Layout { axis, position: plain(position), load: plain(load), time, contact })
}

/// Whether a column's name is that of a time.
fn is_time(name: &str) -> bool {
    let name = name.trim().to_ascii_lowercase();
    name == "t" || name.starts_with("t_") || name.starts_with("time")
}
