//! An EtherCAT segment made of numbers: controllers, a CiA 402 drive and an analogue terminal on a plant that turns by the clock.
//!
//! It knows the protocol from its standards (ETG.1000.4 and .6, the ET1100 data sheet, IEC 61800-7-201) and shares no code with the
//! driver that it is a peer of.

mod controller;
mod drive;
mod eeprom;
mod objects;
mod plant;
mod port;
mod segment;

pub use port::Port;
pub use segment::{Options, Segment};

/// Reads a little-endian word.
fn word(bytes: &[u8], at: usize) -> u16 {
    u16::from_le_bytes([bytes[at], bytes[at + 1]])
}

/// Reads a little-endian double word.
fn double_word(bytes: &[u8], at: usize) -> u32 {
    u32::from(word(bytes, at)) | u32::from(word(bytes, at + 2)) << 16
}
