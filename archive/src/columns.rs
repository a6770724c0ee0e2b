//! The columns of a capture, each in one entry: archives, tables and exports are read, checked and written along this list.
//!
//! A new column is a field of [`Sample`], whose comment describes it in every archive's schema, a field of [`Capture`], and an
//! entry here. Its name carries its [unit](crate::unit_of).

use std::borrow::Cow;
use std::collections::HashMap;
use std::sync::LazyLock;

use shared_types::{Axis, LoopState, Sample};

use crate::capture::Capture;
use crate::schema::FieldLayout;

/// The values of a column, one for each sample.
#[derive(Clone, Debug, PartialEq)]
pub enum Values<'a> {
    /// Counts.
    Counts(Cow<'a, [u64]>),
    /// Real numbers; NaN where there is none.
    Reals(Cow<'a, [f64]>),
    /// Codes and bits.
    Codes(Cow<'a, [u32]>),
}

/// A column of a capture.
pub(crate) struct Column {
    /// Its name within the program, which is that of a rotary axis.
    pub(crate) name: &'static str,
    /// Whether every capture has it.
    pub(crate) required: bool,
    /// What to begin with when its values come one by one.
    pub(crate) empty: fn() -> Values<'static>,
    /// The capture's values; `None` where it has none.
    values: fn(&Capture) -> Option<Values<'_>>,
    /// Gives the capture these values.
    pub(crate) store: fn(&mut Capture, Values<'static>),
    /// Gives the sample the capture's value in a row; `None` where samples have no such field.
    pub(crate) fill: Option<fn(&mut Sample, &Capture, usize)>,
}

/// The entry of a required column, or of an optional column with the value that samples have where the capture lacks the column.
macro_rules! column {
    ($name:ident, $kind:ident) => {
        Column {
            fill: Some(|sample, capture, row| sample.$name = capture.$name[row]),
            ..column!($name, $kind, no field)
        }
    };
    ($name:ident, $kind:ident, no field) => {
        Column {
            name: stringify!($name),
            required: true,
            empty: || Values::$kind(Cow::default()),
            values: |capture| Some(Values::$kind(Cow::from(&capture.$name))),
            store: |capture, values| {
                if let Values::$kind(values) = values {
                    capture.$name = values.into_owned();
                }
            },
            fill: None,
        }
    };
    ($name:ident, $kind:ident, or $absent:expr) => {
        Column {
            name: stringify!($name),
            required: false,
            empty: || Values::$kind(Cow::default()),
            values: |capture| capture.$name.as_deref().map(|values| Values::$kind(Cow::from(values))),
            store: |capture, values| {
                if let Values::$kind(values) = values {
                    capture.$name = Some(values.into_owned());
                }
            },
            fill: Some(|sample, capture, row| {
                sample.$name = capture.$name.as_ref().map_or($absent, |values| values[row]);
            }),
        }
    };
}

static COUNTED: [Column; 2] = [column!(seq, Counts), column!(tick, Counts)];
/// What a CSV table has: finite numbers throughout.
pub(crate) static MEASURED: [Column; 6] = [
    column!(t_s, Reals, no field),
    column!(angle_rad, Reals),
    column!(velocity_rad_s, Reals, or f64::NAN),
    column!(acceleration_rad_s2, Reals, or f64::NAN),
    column!(torque_mnm, Reals),
    column!(contact, Reals, or f64::NAN),
];
static OTHER: [Column; 6] = [
    column!(commanded_angle_rad, Reals, or f64::NAN),
    column!(commanded_torque_mnm, Reals, or f64::NAN),
    column!(measured_after_s, Reals, or 0.0),
    column!(state, Codes, or LoopState::Running.code()),
    column!(missed_ticks, Codes, or 0),
    column!(flags, Codes, or 0),
];
/// What samples have and exports do not: it is kept for a copy of the archive.
static OF_ARCHIVES: [Column; 2] = [column!(fault, Codes, or 0), column!(device_code, Codes, or 0)];

impl Column {
    /// Its name in files about that axis.
    pub(crate) fn name_on(&self, axis: Axis) -> &'static str {
        static LINEAR: LazyLock<HashMap<&'static str, String>> =
            LazyLock::new(|| all().map(|column| (column.name, Axis::Linear.words(column.name).into_owned())).collect());
        if axis.is_rotary() { self.name } else { LINEAR.get(self.name).map_or(self.name, String::as_str) }
    }
}

/// Every column, in the order of exports.
fn all() -> impl Iterator<Item = &'static Column> {
    COUNTED.iter().chain(&MEASURED).chain(&OTHER)
}

/// The columns that are fields of a sample.
pub(crate) fn of_samples() -> impl Iterator<Item = &'static Column> {
    all().filter(|column| column.fill.is_some()).chain(&OF_ARCHIVES)
}

/// The columns that a capture has, with their names.
pub fn of(capture: &Capture) -> impl Iterator<Item = (&'static str, Values<'_>)> {
    all().filter_map(|column| Some((column.name_on(capture.axis), (column.values)(capture)?)))
}

/// How many values each column has that the capture has, with its name.
pub(crate) fn lengths(capture: &Capture) -> impl Iterator<Item = (&'static str, usize)> {
    all().chain(&OF_ARCHIVES).filter_map(|column| Some((column.name_on(capture.axis), (column.values)(capture)?.len())))
}

/// The measured columns that a capture has, with their names.
pub(crate) fn measured(capture: &Capture) -> Vec<(&'static str, &[f64])> {
    let reals = |column: &Column| match (column.values)(capture)? {
        Values::Reals(Cow::Borrowed(values)) => Some((column.name_on(capture.axis), values)),
        _ => None,
    };
    MEASURED.iter().filter_map(reals).collect()
}

impl Values<'_> {
    /// Number of values.
    #[must_use]
    pub fn len(&self) -> usize {
        match self {
            Self::Counts(values) => values.len(),
            Self::Reals(values) => values.len(),
            Self::Codes(values) => values.len(),
        }
    }

    /// True without any value.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Whether there is any value but NaN: a column that is NaN throughout was never measured.
    pub(crate) fn has_any(&self) -> bool {
        match self {
            Self::Reals(values) => values.iter().any(|value| !value.is_nan()),
            _ => !self.is_empty(),
        }
    }

    /// Adds the value of a field; `None` when the message's body does not hold it.
    pub(crate) fn push(&mut self, field: &FieldLayout, body: &[u8]) -> Option<()> {
        match self {
            Self::Counts(values) => values.to_mut().push(field.as_u64(body)?),
            Self::Reals(values) => values.to_mut().push(field.as_f64(body)?),
            Self::Codes(values) => values.to_mut().push(u32::try_from(field.as_u64(body)?).ok()?),
        }
        Some(())
    }

    /// The last value.
    pub(crate) fn last(&self) -> Option<f64> {
        match self {
            Self::Counts(values) => values.last().map(|count| *count as f64),
            Self::Reals(values) => values.last().copied(),
            Self::Codes(values) => values.last().map(|code| f64::from(*code)),
        }
    }

    /// Keeps the values whose place is marked.
    pub(crate) fn keep(&mut self, kept: &[bool]) {
        fn keep<Value: Copy>(values: &mut Vec<Value>, kept: &[bool]) {
            let mut places = kept.iter();
            values.retain(|_| places.next().copied().unwrap_or(true));
        }
        match self {
            Self::Counts(values) => keep(values.to_mut(), kept),
            Self::Reals(values) => keep(values.to_mut(), kept),
            Self::Codes(values) => keep(values.to_mut(), kept),
        }
    }
}
