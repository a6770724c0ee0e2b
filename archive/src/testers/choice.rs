//! Which column of a table is what, and in which unit, as its owner says.

use std::str::FromStr;

use shared_types::{Axis, Quantity};

use super::layout::{Contact, Layout, Source, Time};
use super::table::{RawTable, without_brackets};

/// The columns of a table of any format, as in `angle=Winkel,torque=M` with units as in `angle=deg,torque=Ncm`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ColumnChoice {
    columns: Assignments,
    units: Assignments,
}

/// Words with a value each, as in `angle=deg,torque=Ncm`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Assignments(Vec<(String, String)>);

/// What is wrong with a choice of columns.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ChoiceError {
    /// Not of the form `word=value,word=value`.
    #[error("`{0}` assigns nothing; write WORD=VALUE,WORD=VALUE, as in angle=Winkel,torque=M or angle=deg,torque=Ncm")]
    Form(String),
    /// A word that means nothing here.
    #[error("`{0}` is none of angle, torque, travel, force, time and contact")]
    Word(String),
    /// A word that is assigned twice.
    #[error("`{0}` is assigned twice; give it once")]
    Twice(String),
    /// A column that is to be two things.
    #[error("the column `{0}` cannot be two things at once; give each its own")]
    Shared(String),
    /// A position without a load, or neither.
    #[error("name the columns of angle and torque, or of travel and force")]
    Incomplete,
    /// The table has no such column.
    #[error("it has no column `{name}`; it has the columns {columns}")]
    Missing {
        /// The column that was asked for.
        name: String,
        /// The columns that are there.
        columns: String,
    },
    /// Columns of the same name.
    #[error("several columns are called `{name}`; choose one by its number, such as {} or {}", numbers[0], numbers[1])]
    Several {
        /// The name.
        name: String,
        /// The numbers of the first two of them, from 1.
        numbers: [usize; 2],
    },
    /// A column whose name has a unit that is none of the quantity.
    #[error("the unit in `{name}` is none of {quantity}; give its unit, as in {quantity}={own}")]
    UnitInName {
        /// The column.
        name: String,
        /// The quantity.
        quantity: &'static str,
        /// The instrument's unit of it.
        own: &'static str,
    },
    /// A unit that is none of the quantity.
    #[error("`{unit}` is not a unit of {quantity}; known are {known}")]
    Unit {
        /// The unit.
        unit: String,
        /// The quantity.
        quantity: &'static str,
        /// The units of that quantity.
        known: String,
    },
}

impl FromStr for Assignments {
    type Err = ChoiceError;

    fn from_str(text: &str) -> Result<Self, ChoiceError> {
        let pair = |part: &str| {
            let (word, value) = part.split_once('=').ok_or_else(|| ChoiceError::Form(text.to_owned()))?;
            Ok((word.trim().to_owned(), value.trim().to_owned()))
        };
        Self::new(text.split(',').map(pair).collect::<Result<_, _>>()?)
    }
}

impl Assignments {
    /// The choice that these words with their values make.
    ///
    /// # Errors
    /// [`ChoiceError::Word`] for one that means nothing here, [`ChoiceError::Twice`] for one that is there again.
    pub fn new(pairs: Vec<(String, String)>) -> Result<Self, ChoiceError> {
        let known = ["angle", "torque", "travel", "force", "time", "contact"];
        for (index, (word, _)) in pairs.iter().enumerate() {
            if !known.contains(&word.as_str()) {
                return Err(ChoiceError::Word(word.clone()));
            }
            if pairs[..index].iter().any(|(earlier, _)| earlier == word) {
                return Err(ChoiceError::Twice(word.clone()));
            }
        }
        Ok(Self(pairs))
    }

    fn get(&self, word: &str) -> Option<&str> {
        self.0.iter().find(|(known, _)| known == word).map(|(_, value)| value.as_str())
    }
}

impl ColumnChoice {
    /// Columns with their units; a unit that is not given is the one in the column's name, as in `Time [ms]`, `torque (Nm)` or `t_ms`, or
    /// the instrument's.
    ///
    /// # Errors
    /// [`ChoiceError::Incomplete`] without a position and its load, [`ChoiceError::Shared`] for a column with two words,
    /// [`ChoiceError::Unit`] for a unit that is none.
    pub fn new(columns: Assignments, units: Assignments) -> Result<Self, ChoiceError> {
        let earlier = |index: usize, name: &str| columns.0[..index].iter().any(|(_, earlier)| earlier == name);
        if let Some((_, (_, name))) = columns.0.iter().enumerate().find(|(index, (_, name))| earlier(*index, name)) {
            return Err(ChoiceError::Shared(name.clone()));
        }
        let choice = Self { columns, units };
        let axis = choice.axis().ok_or(ChoiceError::Incomplete)?;
        for quantity in [axis.position(), axis.load(), Quantity::Time] {
            choice.unit(quantity).map(|unit| factor(quantity, unit)).transpose()?;
        }
        Ok(choice)
    }

    /// The axis whose position and load are chosen.
    pub(super) fn axis(&self) -> Option<Axis> {
        let has = |quantity: Quantity| self.columns.get(quantity.name()).is_some();
        [Axis::Rotary, Axis::Linear].into_iter().find(|axis| has(axis.position()) && has(axis.load()))
    }

    /// The name of the column that was chosen for a word such as `angle`.
    pub(super) fn column(&self, word: &str) -> Option<&str> {
        self.columns.get(word)
    }

    /// The unit that was chosen for a quantity.
    pub(super) fn unit(&self, quantity: Quantity) -> Option<&str> {
        self.units.get(quantity.name())
    }

    /// The factor from the unit of the column called `name` to the instrument's unit of the quantity.
    fn factor(&self, quantity: Quantity, name: &str) -> Result<f64, ChoiceError> {
        match self.unit(quantity) {
            Some(unit) => factor(quantity, unit),
            None => unit_in(name, quantity),
        }
    }

    /// Where the chosen columns lie in a table; a column without a name is chosen by its number, from 1.
    ///
    /// # Errors
    /// [`ChoiceError::Missing`] for a column that is not there, [`ChoiceError::Several`] for a name that several have,
    /// [`ChoiceError::Shared`] for a column with two words.
    pub(super) fn layout(&self, table: &RawTable) -> Result<Layout, ChoiceError> {
        let RawTable { header, units, .. } = table;
        let axis = self.axis().ok_or(ChoiceError::Incomplete)?;
        let mut taken = Vec::new();
        let mut place = |name: &str| {
            let called = |names: &[String]| -> Vec<usize> {
                (0..names.len()).filter(|column| names[*column].trim() == name).collect()
            };
            let named = Some(called(header)).filter(|columns| !columns.is_empty()).unwrap_or_else(|| called(units));
            let by_number = || name.parse::<usize>().ok()?.checked_sub(1).filter(|column| *column < table.width());
            let missing = || ChoiceError::Missing { name: name.to_owned(), columns: header.join(", ") };
            let column = match named.as_slice() {
                [] => by_number().ok_or_else(missing)?,
                [column] => *column,
                [first, second, ..] => {
                    return Err(ChoiceError::Several { name: name.to_owned(), numbers: [first + 1, second + 1] });
                }
            };
            // Its name and its number are the same column.
            if taken.contains(&column) {
                return Err(ChoiceError::Shared(name.to_owned()));
            }
            taken.push(column);
            Ok(column)
        };
        let mut source = |quantity: Quantity| {
            let Some(name) = self.column(quantity.name()) else { return Ok(None) };
            let column = place(name)?;
            let named = header.get(column).map_or("", String::as_str);
            let unit = units.get(column).map(|unit| without_brackets(unit)).filter(|unit| !unit.is_empty());
            let name = unit.map_or_else(|| named.to_owned(), |unit| format!("{named} [{unit}]"));
            Ok(Some(Source { column, factor: self.factor(quantity, &name)? }))
        };
        let mut required = |quantity| source(quantity)?.ok_or(ChoiceError::Incomplete);
        Ok(Layout {
            axis,
            position: required(axis.position())?,
            load: required(axis.load())?,
            time: source(Quantity::Time)?.map_or(Time::None, Time::Column),
            contact: self.column("contact").map(&mut place).transpose()?.map(Contact::Voltage),
        })
    }
}

/// The factor from the unit in a column's name to the instrument's unit; 1 if the name has no unit. Names are also written in capitals.
///
/// # Errors
/// [`ChoiceError::UnitInName`] if the text in brackets at its end is no unit of the quantity, if its last word is a unit of unknown size, or if
/// the word before that belongs to the unit.
fn unit_in(name: &str, quantity: Quantity) -> Result<f64, ChoiceError> {
    let unknown = || ChoiceError::UnitInName { name: name.to_owned(), quantity: quantity.name(), own: quantity.unit() };
    let named = |unit: &str| quantity.factor_in_any_case(unit.trim());
    let name = name.trim();
    let bracketed = |[open, close]: [char; 2]| name.split(open).skip(1).filter_map(move |rest| rest.split_once(close));
    let in_brackets = || [['[', ']'], ['(', ')']].into_iter().flat_map(bracketed);
    if let Some(factor) = in_brackets().find_map(|(unit, _)| named(unit)) {
        return Ok(factor);
    }
    // A table may have its units in a row of their own, which is then the header.
    let word = name.rsplit_once(BETWEEN_WORDS).map_or(name, |(_, unit)| unit.trim());
    let words = [word, last_capitalised(word)];
    let factor = words.into_iter().find_map(named);
    let is_unknown = in_brackets().any(|(_, behind)| behind.is_empty())
        || words.iter().any(|word| NO_KNOWN_UNITS.contains(&word.to_lowercase().as_str()) || is_parted(name, word))
        || factor.is_none() && words.iter().any(|word| is_spelled_out(word));
    if is_unknown { Err(unknown()) } else { Ok(factor.unwrap_or(1.0)) }
}

/// Whether a name ends in this unit, of whatever quantity, and the word before it belongs to it: `time_milli_seconds`, `torque_newton_m`,
/// `torqueMilliNm`.
fn is_parted(name: &str, unit: &str) -> bool {
    let before = name.strip_suffix(unit).unwrap_or_default().trim_end_matches(BETWEEN_WORDS);
    let word = last_capitalised(before.rsplit(BETWEEN_WORDS).next().unwrap_or_default()).to_lowercase();
    let belongs = PREFIXES.contains(&word.as_str()) || FACTORS.contains(&word.as_str());
    let quantities = [Quantity::Angle, Quantity::Torque, Quantity::Travel, Quantity::Force, Quantity::Time];
    belongs && quantities.iter().any(|quantity| quantity.factor_in_any_case(unit).is_some())
}

/// Whether a word is nothing but a unit with all its prefixes and factors, known or not: `kiloNewtons`. Meters alone may measure anything.
fn is_spelled_out(word: &str) -> bool {
    let word = word.to_lowercase();
    let (mut rest, mut ends_in_unit) = (word.as_str(), false);
    let part = |rest: &str, parts: &[&str]| parts.iter().find(|part| rest.starts_with(**part)).map(|part| part.len());
    loop {
        if let Some(length) = part(rest, &SPELLED_OUT) {
            (rest, ends_in_unit) = (&rest[length..], true);
        } else if let Some(length) = part(rest, &PREFIXES) {
            (rest, ends_in_unit) = (&rest[length..], false);
        } else {
            break;
        }
    }
    ends_in_unit && ["", "s", "force"].contains(&rest) && !["meter", "metre"].contains(&word.trim_end_matches('s'))
}

/// The end of a name such as `angleDeg` from its last capital behind a small letter on.
fn last_capitalised(name: &str) -> &str {
    let is_start = |((_, letter), before): &((usize, char), char)| letter.is_uppercase() && before.is_lowercase();
    let start = name.char_indices().skip(1).zip(name.chars()).filter(is_start).last();
    start.map_or(name, |((at, _), _)| &name[at..])
}

/// What stands between the words of a name.
const BETWEEN_WORDS: [char; 4] = ['_', ' ', '/', ','];
/// Prefixes of units.
const PREFIXES: [&str; 5] = ["milli", "micro", "nano", "kilo", "centi"];
/// First factors of units that are products.
const FACTORS: [&str; 5] = ["newton", "ounce", "pound", "oz", "lb"];
/// Units that are written in full, without prefixes.
const SPELLED_OUT: [&str; 10] =
    ["newton", "meter", "metre", "gram", "inches", "inch", "ounce", "pound", "radian", "hour"];
/// Words for units whose size a name does not tell: degrees in German are gradians, 400 of them in a turn, elsewhere.
const NO_KNOWN_UNITS: [&str; 9] = ["grad", "count", "counts", "tick", "ticks", "step", "steps", "volt", "volts"];

/// The factor from a unit to the instrument's unit of the quantity.
///
/// # Errors
/// [`ChoiceError::Unit`] for a unit that is none of the quantity.
pub(super) fn factor(quantity: Quantity, unit: &str) -> Result<f64, ChoiceError> {
    quantity.factor(unit).ok_or_else(|| ChoiceError::Unit {
        unit: unit.to_owned(),
        quantity: quantity.name(),
        known: quantity.units().iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", "),
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may stop at a failure")]
mod tests {
    use super::*;

    #[test]
    fn a_units_place_and_capitals_in_a_columns_name_do_not_matter() {
        let degree = std::f64::consts::PI / 180.0;
        let names = [
            (Quantity::Angle, "ANGLE_DEG", degree),
            (Quantity::Angle, "angle_degrees", degree),
            (Quantity::Angle, "Winkel (motor side) [deg]", degree),
            (Quantity::Angle, "position", 1.0),
            (Quantity::Torque, "Torque [Nm] CH1", 1e3),
            (Quantity::Torque, "Moment (Nm), gefiltert", 1e3),
            (Quantity::Torque, "TORQUE_MNM", 1.0),
            (Quantity::Time, "time_msec", 1e-3),
            (Quantity::Time, "t_μs", 1e-6),
            (Quantity::Time, "Time (Milliseconds)", 1e-3),
            (Quantity::Time, "timestamp_nanoseconds", 1e-9),
            (Quantity::Angle, "angle_radians", 1.0),
            (Quantity::Angle, "jointAngleDeg", degree),
            (Quantity::Torque, "motorTorqueMNm", 1.0),
            (Quantity::Torque, "torqueNm", 1e3),
            (Quantity::Angle, "motorPosition", 1.0),
            (Quantity::Travel, "Signal In", 1.0),
            (Quantity::Travel, "travel (in)", 25.4),
            (Quantity::Travel, "travel_meters", 1e3),
            (Quantity::Travel, "travel_centimeters", 10.0),
            (Quantity::Travel, "travel_micrometers", 1e-3),
            (Quantity::Travel, "travel_inches", 25.4),
            (Quantity::Angle, "angle_milliradians", 1e-3),
            (Quantity::Force, "force_grams", 9.806_65e-3),
            (Quantity::Force, "forceMillinewtons", 1e-3),
            (Quantity::Torque, "torque_millinewtonmeters", 1.0),
            (Quantity::Torque, "torque_newtonmetre", 1e3),
            (Quantity::Force, "Force meter", 1.0),
            (Quantity::Angle, "potentiometer", 1.0),
        ];
        for (quantity, name, factor) in names {
            assert_eq!(unit_in(name, quantity), Ok(factor), "{name}");
        }
        for name in ["Winkel_Grad", "Angle [Grad]", "Angle [counts]", "encoder_counts", "encoderCounts"] {
            assert!(unit_in(name, Quantity::Angle).is_err(), "{name}");
        }
        for (quantity, name) in [
            (Quantity::Torque, "torque_newton_meters"),
            (Quantity::Torque, "Torque Newton m"),
            (Quantity::Torque, "torqueMilliNm"),
            (Quantity::Torque, "torque_milliNm"),
            (Quantity::Torque, "torque_inch_pounds"),
            (Quantity::Time, "timeMilliSeconds"),
            (Quantity::Time, "time_milli_seconds"),
            (Quantity::Time, "time_hours"),
            (Quantity::Force, "force_kilonewtons"),
            (Quantity::Force, "forcePounds"),
        ] {
            let error = unit_in(name, quantity);
            assert!(matches!(error, Err(ChoiceError::UnitInName { .. })), "{name}: {error:?}");
        }
    }

    #[test]
    fn a_name_that_several_columns_have_and_a_number_beyond_them_are_refused() {
        let table = RawTable::of("Angle [deg],Torque [Nm],Torque [Nm]\n1,2,3\n4,5,6\n").unwrap();
        let layout = |torque: &str| {
            let columns = format!("angle=Angle [deg],torque={torque}").parse().unwrap();
            ColumnChoice::new(columns, Assignments::default()).unwrap().layout(&table)
        };
        let several = layout("Torque [Nm]").unwrap_err().to_string();
        assert!(several.contains("number") && several.contains("2 or 3"), "{several}");
        assert_eq!(layout("3").unwrap().load, Source { column: 2, factor: 1e3 });
        assert!(matches!(layout("4"), Err(ChoiceError::Missing { .. })));
    }
}
