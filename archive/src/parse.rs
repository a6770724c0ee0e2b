//! Records of foreign files, parsed in no more memory than they fill.

use mcap::records::{Record, op};
use mcap::{McapError, McapResult};

/// A stretch of a record's body.
pub(crate) enum Stretch {
    /// So many bytes.
    Fixed(usize),
    /// A length of four bytes, and so many bytes: a text or a list.
    Counted,
    /// A length of four bytes, and so many bytes, which are texts themselves.
    Map,
}

/// What the body of a record consists of, up to what fills the rest of it (<https://mcap.dev/spec>, "Records").
pub(crate) const fn shape(opcode: u8) -> &'static [Stretch] {
    use Stretch::{Counted, Fixed, Map};
    match opcode {
        op::HEADER => &[Counted, Counted],
        op::FOOTER => &[Fixed(20)],
        op::SCHEMA => &[Fixed(2), Counted, Counted, Counted],
        op::CHANNEL => &[Fixed(4), Counted, Counted, Map],
        op::MESSAGE => &[Fixed(22)],
        op::CHUNK => &[Fixed(28), Counted],
        op::MESSAGE_INDEX => &[Fixed(2), Counted],
        op::CHUNK_INDEX => &[Fixed(32), Counted, Fixed(8), Counted, Fixed(16)],
        op::ATTACHMENT => &[Fixed(16), Counted, Counted],
        op::ATTACHMENT_INDEX => &[Fixed(40), Counted, Counted],
        op::STATISTICS => &[Fixed(42), Counted],
        op::METADATA => &[Counted, Map],
        op::METADATA_INDEX => &[Fixed(16), Counted],
        op::SUMMARY_OFFSET => &[Fixed(17)],
        op::DATA_END => &[Fixed(4)],
        _ => &[],
    }
}

/// Parses a record with [`mcap::parse_record`]. That allocates whatever length a text claims, so the lengths are checked first.
///
/// # Errors
/// When the body is no such record, or ends before a text in it does.
pub(crate) fn parse_record(opcode: u8, body: &[u8]) -> McapResult<Record<'_>> {
    if !is_filled(opcode, body) {
        return Err(McapError::UnexpectedEof);
    }
    mcap::parse_record(opcode, body)
}

/// Whether every length within the record ends within it too.
fn is_filled(opcode: u8, body: &[u8]) -> bool {
    let walked = shape(opcode).iter().try_fold(body, |rest, stretch| match stretch {
        Stretch::Fixed(count) => rest.get(*count..),
        Stretch::Counted => counted(rest).map(|(_, rest)| rest),
        Stretch::Map => counted(rest).filter(|(map, _)| is_counted_throughout(map)).map(|(_, rest)| rest),
    });
    walked.is_some()
}

fn is_counted_throughout(mut map: &[u8]) -> bool {
    while !map.is_empty() {
        let Some((_, rest)) = counted(map) else { return false };
        map = rest;
    }
    true
}

/// The bytes that a length counts, and what follows them.
fn counted(bytes: &[u8]) -> Option<(&[u8], &[u8])> {
    let (length, rest) = bytes.split_first_chunk()?;
    rest.split_at_checked(u32::from_le_bytes(*length) as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_that_claims_more_than_there_is_makes_no_room() {
        let text = |claimed: u32, bytes: &[u8]| [&claimed.to_le_bytes()[..], bytes].concat();
        let map = |content: &[u8]| text(u32::try_from(content.len()).unwrap_or(0), content);
        let sound = [text(1, b"a"), map(&[text(1, b"k"), text(2, b"vv")].concat())].concat();
        assert!(matches!(parse_record(op::METADATA, &sound), Ok(Record::Metadata(_))));
        for claims in [text(u32::MAX, b"a"), [text(1, b"a"), map(&text(0x7000_0000, b"k"))].concat()] {
            assert!(matches!(parse_record(op::METADATA, &claims), Err(McapError::UnexpectedEof)));
        }
        let schema = [&[1, 0][..], &text(1, b"n"), &text(1, b"e"), &text(9, b"short")].concat();
        assert!(parse_record(op::SCHEMA, &schema).is_err());
    }
}
