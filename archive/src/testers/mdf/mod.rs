//! ASAM MDF 4: the measurements of automotive benches, channels with names and units, in groups with a time each.

mod group;
mod pick;

use std::path::Path;
use std::sync::Arc;

use falcon_mdf::io::range::read_seek_source;
use falcon_mdf::{Mf4Error, Mf4File};
use shared_types::Quantity;

use super::choice::{self, ColumnChoice};
use super::layout::{closed, refuse_falling};
use super::{Curve, wrong};
use crate::capture::first_bytes;
use crate::error::ArchiveError;
use group::{Group, Place};
use pick::Picked;

/// How a measurement begins, one that was finished and one whose recorder did not come to its end.
const MARKS: [&[u8]; 2] = [b"MDF     ", b"UnFinMF "];

/// Whether a file begins as a measurement in ASAM MDF does.
pub(crate) fn is_mdf(path: &Path) -> Result<bool, ArchiveError> {
    Ok(MARKS.contains(&&first_bytes(path, MARKS[0].len())?[..]))
}

/// Reads the channels that were chosen, or that names and units tell.
pub(super) fn read(path: &Path, chosen: Option<&ColumnChoice>) -> Result<Curve, ArchiveError> {
    let file = foreign_files::open(path).map_err(|error| ArchiveError::file(path, error))?;
    let open = || Mf4File::from_source(Arc::new(read_seek_source(file)?));
    let file = open().map_err(|error| wrong(path, in_words(&error)))?;
    let groups = Group::all(&file);
    let picked = match chosen {
        Some(chosen) => Picked::by_choice(&groups, chosen),
        None => Picked::by_name_or_unit(&groups),
    };
    picked.and_then(|picked| curve(&file, &groups, &picked, chosen)).map_err(|reason| wrong(path, reason))
}

/// What is wrong with a file, and what helps where something does.
fn in_words(error: &Mf4Error) -> String {
    match error {
        Mf4Error::UnsupportedVersion { major, minor } => {
            format!("it is MDF {major}.{minor}, and only MDF 4 is read; save it as MDF 4.10")
        }
        Mf4Error::Unsupported { .. } => format!("{error}; save it as MDF 4.10"),
        error => format!("it cannot be read as ASAM MDF 4: {error}"),
    }
}

/// The picked channels, row by row, without the rows that the file says are invalid.
fn curve(
    file: &Mf4File,
    groups: &[Group<'_>],
    picked: &Picked<'_>,
    chosen: Option<&ColumnChoice>,
) -> Result<Curve, String> {
    let Picked { axis, position, load, time, contact } = *picked;
    let mut valid = None;
    let mut read = |place: Place<'_>, quantity: Quantity| {
        let factor = factor(place, quantity, chosen)?;
        let (values, validity) = groups[place.group].values(file, place.channel)?;
        and(&mut valid, validity);
        Ok::<_, String>(values.into_iter().map(|value| value * factor).collect::<Vec<f64>>())
    };
    let (mut positions, mut loads) = (read(position, axis.position())?, read(load, axis.load())?);
    let mut t_s = time.map(|time| read(time, Quantity::Time)).transpose()?;
    let mut volts = contact.map(|contact| read(contact, Quantity::Number)).transpose()?;
    for (place, rows) in [(Some(load), Some(&loads)), (time, t_s.as_ref()), (contact, volts.as_ref())] {
        if let (Some(place), Some(rows)) = (place, rows)
            && place.group != position.group
        {
            refuse_other_times(file, groups, position, place, rows.len() == positions.len())?;
        }
    }
    if let Some(valid) = valid {
        let columns = [Some(&mut positions), Some(&mut loads), t_s.as_mut(), volts.as_mut()];
        columns.into_iter().flatten().for_each(|column| keep(column, &valid));
    }
    for (place, rows) in [(Some(position), Some(&positions)), (Some(load), Some(&loads)), (time, t_s.as_ref())] {
        if let (Some(place), Some(rows)) = (place, rows)
            && let Some(row) = rows.iter().position(|value| !value.is_finite())
        {
            return Err(format!("row {}: `{}` is {}", row + 1, place.channel.name, rows[row]));
        }
    }
    refuse_falling(t_s.as_deref())?;
    // Readings that all have the same time in their group were not timed: they are a curve.
    let is_chosen = chosen.is_some_and(|chosen| chosen.column(Quantity::Time.name()).is_some());
    let t_s = t_s.filter(|t_s| is_chosen || t_s.first() < t_s.last());
    let closed = volts.and_then(|volts| closed(&volts));
    Ok(Curve { axis, t_s, position: positions, load: loads, closed, ..Curve::default() })
}

/// The factor from a channel's unit, as chosen or else as the file has it, to the instrument's unit of the quantity.
fn factor(place: Place<'_>, quantity: Quantity, chosen: Option<&ColumnChoice>) -> Result<f64, String> {
    if quantity == Quantity::Number {
        return Ok(1.0);
    }
    let name = &place.channel.name;
    let unit = chosen.and_then(|chosen| chosen.unit(quantity)).unwrap_or(&place.channel.unit);
    match quantity.factor(unit) {
        Some(factor) => Ok(factor),
        // A master's time is in seconds by the standard.
        None if quantity == Quantity::Time && place.channel.is_time_channel() => Ok(1.0),
        None if name.eq_ignore_ascii_case(group::own_name(quantity)) && unit.is_empty() => Ok(1.0),
        None => {
            let word = quantity.name();
            let known = choice::factor(quantity, unit).err().map(|error| error.to_string()).unwrap_or_default();
            let known = if unit.is_empty() { "it has none".to_owned() } else { known };
            Err(format!(
                "the unit of `{name}` is unknown ({known}); name the columns, as in {word}=NAME,…, and their units, as in {word}={}",
                quantity.unit()
            ))
        }
    }
}

/// Channels of two groups belong together only if their groups have the same times.
fn refuse_other_times(
    file: &Mf4File,
    groups: &[Group<'_>],
    position: Place<'_>,
    other: Place<'_>,
    same_length: bool,
) -> Result<(), String> {
    let times = |place: Place<'_>| groups[place.group].times(file);
    if same_length && times(position)? == times(other)? {
        return Ok(());
    }
    let said = |place: Place<'_>| format!("`{}` ({})", place.channel.name, groups[place.group].in_words());
    Err(format!(
        "{} and {} were not sampled at the same times; name channels of one group, or resample the file to one raster first",
        said(position),
        said(other)
    ))
}

fn and(valid: &mut Option<Vec<bool>>, also: Option<Vec<bool>>) {
    match (valid.as_mut(), also) {
        (Some(valid), Some(also)) => valid.iter_mut().zip(also).for_each(|(valid, also)| *valid &= also),
        (None, also) => *valid = also,
        (Some(_), None) => {}
    }
}

fn keep(column: &mut Vec<f64>, valid: &[bool]) {
    let mut places = valid.iter();
    column.retain(|_| places.next().copied().unwrap_or(true));
}
