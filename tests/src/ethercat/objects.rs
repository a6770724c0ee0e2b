//! A device's objects: what its mailbox answers, and what its process data are made of.

use std::collections::BTreeMap;

use super::{double_word, word};

/// Reasons for which a transfer is aborted (ETG.1000.6, table 41).
const READ_ONLY: u32 = 0x0601_0002;
const NO_OBJECT: u32 = 0x0602_0000;
const NOT_MAPPABLE: u32 = 0x0604_0041;
const WRONG_LENGTH: u32 = 0x0607_0010;

#[derive(Clone, Copy, Debug)]
pub struct Object {
    bytes: usize,
    pub value: u32,
    is_writable: bool,
    is_mappable: bool,
}

/// Objects by index and subindex.
#[derive(Clone, Debug, Default)]
pub struct Objects(BTreeMap<(u16, u8), Object>);

impl Objects {
    pub fn constant(&mut self, index: u16, subindex: u8, bytes: usize, value: u32) {
        self.0.insert((index, subindex), Object { bytes, value, is_writable: false, is_mappable: false });
    }

    pub fn parameter(&mut self, index: u16, subindex: u8, bytes: usize, value: u32) {
        self.0.insert((index, subindex), Object { bytes, value, is_writable: true, is_mappable: false });
    }

    pub fn exchanged(&mut self, index: u16, subindex: u8, bytes: usize, is_writable: bool) {
        self.0.insert((index, subindex), Object { bytes, value: 0, is_writable, is_mappable: true });
    }

    /// A list: subindex 0 has its length.
    pub fn list(&mut self, index: u16, bytes: usize, values: &[u32], room: u8) {
        self.parameter(index, 0, 1, values.len() as u32);
        for at in 0..room {
            self.parameter(index, at + 1, bytes, values.get(usize::from(at)).copied().unwrap_or(0));
        }
    }

    pub fn get(&self, index: u16, subindex: u8) -> u32 {
        self.0.get(&(index, subindex)).map_or(0, |object| object.value)
    }

    pub fn set(&mut self, index: u16, subindex: u8, value: u32) {
        if let Some(object) = self.0.get_mut(&(index, subindex)) {
            object.value = value;
        }
    }

    /// The mapped entries behind an assignment, each as index, subindex and bits.
    pub fn mapped(&self, assignment: u16) -> Vec<(u16, u8, usize)> {
        let list = |index: u16| (1..=self.get(index, 0) as u8).map(move |at| self.get(index, at));
        let entries = list(assignment).flat_map(|mapping| list(mapping as u16));
        entries.map(|word| ((word >> 16) as u16, (word >> 8) as u8, (word & 0xff) as usize)).collect()
    }

    /// Bytes that the entries behind an assignment take; all of them are of whole bytes.
    pub fn mapped_bytes(&self, assignment: u16) -> usize {
        self.mapped(assignment).iter().map(|(_, _, bits)| bits / 8).sum()
    }

    /// Puts the entries' values one after the other.
    pub fn pack(&self, assignment: u16, into: &mut [u8]) {
        let mut at = 0;
        for (index, subindex, bits) in self.mapped(assignment) {
            for byte in self.get(index, subindex).to_le_bytes().iter().take(bits / 8) {
                if let Some(place) = into.get_mut(at) {
                    *place = *byte;
                }
                at += 1;
            }
        }
    }

    /// Takes the entries' values.
    pub fn unpack(&mut self, assignment: u16, from: &[u8]) {
        let mut at = 0;
        for (index, subindex, bits) in self.mapped(assignment) {
            let mut value = [0; 4];
            for byte in value.iter_mut().take(bits / 8) {
                *byte = from.get(at).copied().unwrap_or(0);
                at += 1;
            }
            self.set(index, subindex, u32::from_le_bytes(value));
        }
    }

    fn write(&mut self, index: u16, subindex: u8, bytes: usize, value: u32) -> Result<(), u32> {
        let object = self.0.get(&(index, subindex)).copied().ok_or(NO_OBJECT)?;
        if !object.is_writable {
            return Err(READ_ONLY);
        }
        if bytes != object.bytes {
            return Err(WRONG_LENGTH);
        }
        if (index & 0xfff0 == 0x1600 || index & 0xfff0 == 0x1a00) && subindex > 0 {
            let found = self.0.get(&((value >> 16) as u16, (value >> 8) as u8));
            let fits = |object: &Object| object.is_mappable && object.bytes * 8 == (value & 0xff) as usize;
            if !found.is_some_and(fits) {
                return Err(NOT_MAPPABLE);
            }
        }
        self.set(index, subindex, value);
        Ok(())
    }

    /// Answers a mailbox message: an SDO upload or download that is expedited (ETG.1000.6, 5.6.2).
    pub fn answer(&mut self, request: &[u8]) -> Option<Vec<u8>> {
        const COE: u8 = 3;
        if request[5] & 0x0f != COE || word(request, 6) >> 12 != 2 {
            return None;
        }
        let command = request[8];
        let (index, subindex) = (word(request, 9), request[11]);
        let result = match command >> 5 {
            1 => {
                let bytes = if command & 1 == 1 { 4 - usize::from(command >> 2 & 3) } else { 4 };
                let value = double_word(request, 12) & (u64::MAX >> (64 - 8 * bytes)) as u32;
                self.write(index, subindex, bytes, value).map(|()| (0x60, 0))
            }
            2 => self
                .0
                .get(&(index, subindex))
                .ok_or(NO_OBJECT)
                .map(|object| (0x43 | ((4 - object.bytes as u8) << 2), object.value)),
            _ => Err(0x0504_0001),
        };
        let (service, command, value) = match result {
            Ok((command, value)) => (3_u16, command, value),
            Err(reason) => (2, 0x80, reason),
        };
        let mut answer = Vec::from([10, 0, 0, 0, 0, request[5]]);
        answer.extend((service << 12).to_le_bytes());
        answer.push(command);
        answer.extend(index.to_le_bytes());
        answer.push(subindex);
        answer.extend(value.to_le_bytes());
        Some(answer)
    }
}
