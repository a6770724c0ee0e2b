//! The protocol, from its documents: lines of text, and registers in their frames.

/// A request of a frame.
#[derive(Debug, PartialEq)]
pub enum Request {
    /// A register is to hold a value.
    Write { register: u32, value: f64 },
    /// Registers are to be told, in a type.
    Read { kind: u8, first: u32, count: u32 },
    /// Text for the stream of this channel.
    Said { channel: u8, text: Vec<u8> },
    /// What the stream has to say is asked for, at most so many bytes.
    Poll { channel: u8, most: u8 },
}

/// `can send ID DATA FLAGS`, as identifier and data; whether it had a checksum, and a right one.
pub fn parse_line(line: &str) -> Option<(u32, Vec<u8>, Option<bool>)> {
    let (content, checksum) = match line.rsplit_once('*') {
        Some((content, sum)) if sum.len() == 2 => {
            (content, Some(u8::from_str_radix(sum, 16).is_ok_and(|sum| sum == crc8(content.as_bytes()))))
        }
        _ => (line, None),
    };
    let mut words = content.split_whitespace();
    if (words.next(), words.next()) != (Some("can"), Some("send")) {
        return None;
    }
    let identifier = u32::from_str_radix(words.next()?, 16).ok()?;
    let digits = words.next()?;
    let bytes = (0..digits.len() / 2).map(|i| u8::from_str_radix(digits.get(2 * i..2 * i + 2)?, 16).ok());
    Some((identifier, bytes.collect::<Option<_>>()?, checksum))
}

/// The polynomial 0x97, bit by bit.
pub fn crc8(bytes: &[u8]) -> u8 {
    bytes.iter().fold(0, |sum, byte| {
        (0..8).fold(sum ^ byte, |sum: u8, _| if sum & 0x80 != 0 { sum << 1 ^ 0x97 } else { sum << 1 })
    })
}

/// What a frame asks for, up to the first thing that is not understood.
pub fn requests(data: &[u8]) -> Vec<Request> {
    let mut rest = data;
    let mut found = Vec::new();
    while request(&mut rest, &mut found).is_some() {}
    found
}

fn request(rest: &mut &[u8], found: &mut Vec<Request>) -> Option<()> {
    let command = byte(rest)?;
    match command {
        0x50 => {}
        0x00..=0x1f => {
            let kind = command >> 2 & 3;
            let count = if command & 3 == 0 { number(rest)? } else { u32::from(command & 3) };
            let first = number(rest)?;
            if command & 0x10 != 0 {
                found.push(Request::Read { kind, first, count });
            } else {
                for register in first..first + count {
                    found.push(Request::Write { register, value: value(rest, kind)? });
                }
            }
        }
        0x40 => {
            let channel = byte(rest)?;
            let length = usize::from(byte(rest)?);
            let (text, after) = rest.split_at_checked(length)?;
            *rest = after;
            found.push(Request::Said { channel, text: text.to_vec() });
        }
        0x42 => found.push(Request::Poll { channel: byte(rest)?, most: byte(rest)? }),
        _ => return None,
    }
    Some(())
}

fn byte(rest: &mut &[u8]) -> Option<u8> {
    let (&first, after) = rest.split_first()?;
    *rest = after;
    Some(first)
}

fn number(rest: &mut &[u8]) -> Option<u32> {
    let mut number = 0;
    for shift in (0..35).step_by(7) {
        let part = byte(rest)?;
        number |= u32::from(part & 0x7f) << shift;
        if part & 0x80 == 0 {
            return Some(number);
        }
    }
    None
}

/// A value as it stands: an integer's least is none, others are counted in the register's unit by whoever knows it.
fn value(rest: &mut &[u8], kind: u8) -> Option<f64> {
    let mut bytes = [0; 4];
    let length = [1, 2, 4, 4][usize::from(kind)];
    for slot in &mut bytes[..length] {
        *slot = byte(rest)?;
    }
    Some(match kind {
        0 => whole(i64::from(bytes[0].cast_signed()), i64::from(i8::MIN)),
        1 => whole(i64::from(i16::from_le_bytes([bytes[0], bytes[1]])), i64::from(i16::MIN)),
        2 => whole(i64::from(i32::from_le_bytes(bytes)), i64::from(i32::MIN)),
        _ => f64::from(f32::from_le_bytes(bytes)),
    })
}

fn whole(value: i64, none: i64) -> f64 {
    if value == none { f64::NAN } else { value as f64 }
}

/// Appends the answer for a run of registers to a frame.
pub fn answer(frame: &mut Vec<u8>, kind: u8, first: u32, values: &[f64]) {
    frame.extend([0x20 | kind << 2, values.len() as u8]);
    append_number(frame, first);
    for &value in values {
        match kind {
            0 => frame.push((value as i8).cast_unsigned()),
            1 => frame.extend((value as i16).to_le_bytes()),
            2 => frame.extend((value as i64 as i32).to_le_bytes()),
            _ => frame.extend((value as f32).to_le_bytes()),
        }
    }
}

fn append_number(frame: &mut Vec<u8>, mut number: u32) {
    while number >= 0x80 {
        frame.push(number as u8 | 0x80);
        number >>= 7;
    }
    frame.push(number as u8);
}
