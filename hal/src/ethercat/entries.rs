//! Entries of process data: their names, and where they lie among a device's bytes.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, de};

/// An object that can be exchanged in every cycle, as 0x1600 and 0x1A00 have it (ETG.1000.6, 5.6.7.4.7).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Entry {
    /// The object's index; 0 is padding.
    pub index: u16,
    /// Its subindex.
    pub subindex: u8,
    /// Its length.
    pub bits: u8,
}

impl Entry {
    /// Its word in a mapping object.
    pub(super) fn word(self) -> u32 {
        u32::from(self.index) << 16 | u32::from(self.subindex) << 8 | u32::from(self.bits)
    }

    /// The entry of a word in a mapping object.
    pub(super) fn of_word(word: u32) -> Self {
        let [bits, subindex, low, high] = word.to_le_bytes();
        Self { index: u16::from_le_bytes([low, high]), subindex, bits }
    }
}

impl fmt::Display for Entry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:#06x}:{:02x}/{}", self.index, self.subindex, self.bits)
    }
}

/// `0x6071:00/16`: index and subindex in hexadecimal, length in bits.
impl FromStr for Entry {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parsed = text.split_once('/').and_then(|(object, bits)| Some((Object::parse(object)?, bits.parse().ok()?)));
        match parsed {
            Some((Object { index, subindex }, bits)) if (1..=64).contains(&bits) => Ok(Self { index, subindex, bits }),
            _ => Err(format!("'{text}' is no entry; write index, subindex and bits, as in 0x6071:00/16")),
        }
    }
}

impl<'de> Deserialize<'de> for Entry {
    fn deserialize<D: de::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        String::deserialize(deserializer)?.parse().map_err(de::Error::custom)
    }
}

/// An object by index and subindex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Object {
    pub(super) index: u16,
    pub(super) subindex: u8,
}

impl Object {
    pub(super) const fn new(index: u16, subindex: u8) -> Self {
        Self { index, subindex }
    }

    /// `0x6071:00`, or `0x6071`.
    fn parse(text: &str) -> Option<Self> {
        let (index, subindex) = text.split_once(':').unwrap_or((text, "0"));
        let index = u16::from_str_radix(index.strip_prefix("0x")?, 16).ok()?;
        Some(Self { index, subindex: u8::from_str_radix(subindex, 16).ok()? })
    }
}

impl fmt::Display for Object {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:#06x}:{:02x}", self.index, self.subindex)
    }
}

/// How bits stand for a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Coding {
    Signed,
    Unsigned,
    /// IEEE 754, of 32 or 64 bits.
    Real,
}

/// `DEVICE.0x6000:11`, with `u` behind it for an unsigned and `.real` for a real number; `drive.position`, `drive.velocity` and
/// `drive.torque` in rad, rad/s and mNm.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Source {
    pub(super) device: String,
    pub(super) what: What,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum What {
    Position,
    Velocity,
    Torque,
    Raw(Object, Coding),
}

impl fmt::Display for Source {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let device = &self.device;
        match self.what {
            What::Position => write!(f, "{device}.position"),
            What::Velocity => write!(f, "{device}.velocity"),
            What::Torque => write!(f, "{device}.torque"),
            What::Raw(object, Coding::Signed) => write!(f, "{device}.{object}"),
            What::Raw(object, Coding::Unsigned) => write!(f, "{device}.{object}u"),
            What::Raw(object, Coding::Real) => write!(f, "{device}.{object}.real"),
        }
    }
}

impl FromStr for Source {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || {
            format!(
                "the source '{text}' is none of this driver's: write drive.position, drive.velocity, drive.torque, or a device's \
                 name and an entry, as in drive.0x6077:00"
            )
        };
        let (device, name) = text.split_once('.').ok_or_else(wrong)?;
        let raw = |coding, object| Object::parse(object).map(|object| What::Raw(object, coding));
        let what = match name {
            "position" if device == DRIVE => Some(What::Position),
            "velocity" if device == DRIVE => Some(What::Velocity),
            "torque" if device == DRIVE => Some(What::Torque),
            _ => match (name.strip_suffix('u'), name.strip_suffix(".real")) {
                (Some(object), _) => raw(Coding::Unsigned, object),
                (_, Some(object)) => raw(Coding::Real, object),
                _ => raw(Coding::Signed, name),
            },
        };
        what.map(|what| Self { device: device.to_owned(), what }).ok_or_else(wrong)
    }
}

/// The name that sources have for the drive.
pub(super) const DRIVE: &str = "drive";

/// Where an entry lies among the bytes of a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Place {
    bit: usize,
    bits: u8,
}

impl Place {
    /// Where an object lies among entries that follow each other.
    pub(super) fn of(object: Object, entries: &[Entry]) -> Option<Self> {
        let mut bit = 0;
        for entry in entries {
            if Object::new(entry.index, entry.subindex) == object {
                return Some(Self { bit, bits: entry.bits });
            }
            bit += usize::from(entry.bits);
        }
        None
    }

    /// The number there; 0 beyond the end.
    pub(super) fn read(self, bytes: &[u8], coding: Coding) -> f64 {
        let bits = self.read_bits(bytes);
        let unused = 64 - u32::from(self.bits);
        match coding {
            Coding::Signed => ((bits << unused).cast_signed() >> unused) as f64,
            Coding::Unsigned => bits as f64,
            Coding::Real if self.bits == 32 => f64::from(f32::from_bits((bits & 0xffff_ffff) as u32)),
            Coding::Real => f64::from_bits(bits),
        }
    }

    /// The bits there.
    pub(super) fn read_bits(self, bytes: &[u8]) -> u64 {
        (0..usize::from(self.bits)).fold(0, |found, bit| {
            let at = self.bit + bit;
            let byte = bytes.get(at / 8).copied().unwrap_or(0);
            found | u64::from(byte >> (at % 8) & 1) << bit
        })
    }

    /// Puts bits there.
    pub(super) fn write_bits(self, bytes: &mut [u8], value: u64) {
        for bit in 0..usize::from(self.bits) {
            let at = self.bit + bit;
            if let Some(byte) = bytes.get_mut(at / 8) {
                *byte = *byte & !(1 << (at % 8)) | u8::from(value >> bit & 1 == 1) << (at % 8);
            }
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may stop at a failure")]
mod tests {
    use super::*;

    #[test]
    fn entries_and_sources_are_read_as_they_are_written() {
        let entry: Entry = "0x6071:00/16".parse().unwrap();
        assert_eq!((entry, entry.to_string()), (Entry { index: 0x6071, subindex: 0, bits: 16 }, "0x6071:00/16".into()));
        assert_eq!((entry.word(), Entry::of_word(0x6071_0010)), (0x6071_0010, entry));
        for wrong in ["6071:00/16", "0x6071", "0x6071:00/0", "0x6071:00/65", "", "0x16071:00/8"] {
            assert!(wrong.parse::<Entry>().is_err(), "{wrong}");
        }
        let source = |text: &str| text.parse::<Source>().map(|source| source.what);
        assert_eq!(source("drive.position"), Ok(What::Position));
        assert_eq!(source("torque.0x6000:11"), Ok(What::Raw(Object::new(0x6000, 0x11), Coding::Signed)));
        assert_eq!(source("torque.0x6000:11u"), Ok(What::Raw(Object::new(0x6000, 0x11), Coding::Unsigned)));
        assert_eq!(source("torque.0x9000:01.real"), Ok(What::Raw(Object::new(0x9000, 1), Coding::Real)));
        for wrong in ["position", "torque.position", "drive.6071", "drive.0x6071:zz"] {
            assert!(source(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn numbers_lie_where_the_mapping_has_them_across_bytes_too() {
        let entries: Vec<Entry> =
            ["0x6041:00/16", "0x0000:00/3", "0x6064:00/32"].iter().map(|text| text.parse().unwrap()).collect();
        let place = Place::of(Object::new(0x6064, 0), &entries).unwrap();
        let mut bytes = [0xff; 8];
        place.write_bits(&mut bytes, u64::from((-123_456_i32).cast_unsigned()));
        assert_eq!(place.read(&bytes, Coding::Signed), -123_456.0);
        assert_eq!(place.read(&bytes, Coding::Unsigned), 4_294_843_840.0);
        assert_eq!((bytes[0], bytes[2] & 7, bytes[7]), (0xff, 7, 0xff), "neighbours keep their bits");
        place.write_bits(&mut bytes, u64::from(1.5_f32.to_bits()));
        assert_eq!(place.read(&bytes, Coding::Real), 1.5);
        assert_eq!(Place::of(Object::new(0x6077, 0), &entries), None);
    }
}
