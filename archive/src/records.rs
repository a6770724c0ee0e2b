//! The records of an MCAP file whose checksums hold.
//!
//! A broken file cannot be trusted to say where its next record begins: one flipped bit in a
//! length leads anywhere. So this reader looks at every position for a chunk or an attachment whose
//! lengths agree with each other and whose checksum holds, and takes nothing else as content.
//! What lies between (indexes, summary, end) is made anew when the file is written again; the
//! reader only keeps account of the bytes that it could explain.

use std::io::{self, Read};
use std::ops::Range;

use mcap::records::{Record, op};
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};

use crate::parse::{Stretch, parse_record, shape};

/// The longest record that is taken seriously, bytes.
pub(crate) const MAX_RECORD_BYTES: usize = 256 * 1024 * 1024;
/// Bytes that content at any position may unpack to, in addition to those that [`UNPACKED_SHARE`] permits.
const UNPACKED_ALWAYS: u64 = 64 << 20;
/// Bytes that each byte of a file may unpack to. Samples of a sensor with noise unpack to three, those of a knob at rest to ten.
const UNPACKED_SHARE: u64 = 16;
/// Opcode and length.
const FRAME_HEAD: usize = 9;
/// Enough for a chunk's header, and for an attachment's with names of ordinary length.
const LOOK_AHEAD: usize = 1024;
/// Bytes read from the file at a time.
const READ_BYTES: usize = 256 * 1024;

/// Most bytes that a file of `length` bytes may unpack to: what holds more was made to fill memory.
pub(crate) const fn may_unpack_to(length: u64) -> u64 {
    UNPACKED_ALWAYS.saturating_add(UNPACKED_SHARE.saturating_mul(length))
}

/// A record of the file that is intact, as far as the format can say.
#[derive(Debug)]
pub(crate) enum IntactRecord {
    /// A chunk whose checksum holds.
    Chunk(Unpacked),
    /// The beginning of a chunk that the file's end cuts off; no checksum covers it.
    UnfinishedChunk(Unpacked),
    /// An attachment whose checksum holds.
    Attachment { name: String, media_type: String, log_time: u64, content: Vec<u8> },
    /// A metadata record; the format has no checksum for it.
    Metadata(mcap::records::Metadata),
}

/// The records of a chunk, decompressed.
#[derive(Debug, Default)]
pub(crate) struct Unpacked {
    pub(crate) bytes: Vec<u8>,
    /// Opcode and place of each record's body in `bytes`.
    pub(crate) records: Vec<(u8, Range<usize>)>,
}

/// What became of the file's bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Account {
    /// Bytes read.
    pub(crate) bytes: u64,
    /// Bytes that were neither intact content nor structure that can be rebuilt.
    pub(crate) dropped: u64,
    /// Chunks whose checksum holds.
    pub(crate) chunks: u64,
    /// Chunks whose checksum fails.
    pub(crate) damaged_chunks: u64,
    /// Chunks that the end of the file cuts off: none or one.
    pub(crate) unfinished_chunks: u64,
    /// The end of the data section was seen: the writer had finished.
    pub(crate) finished: bool,
    /// Of the dropped bytes, those before that end.
    pub(crate) dropped_content: u64,
}

/// Reads intact records from any reader, with memory for one record at a time.
pub(crate) struct IntactRecords<R> {
    window: Window<R>,
    /// Every byte before this position is content, structure or counted as dropped.
    accounted_to: u64,
    /// Where the last record that can be rebuilt began.
    last_frame: u64,
    /// Bytes that were unpacked and compared with checksums so far, in vain or not.
    checked_bytes: u64,
    account: Account,
    ended: bool,
}

impl<R: Read> IntactRecords<R> {
    pub(crate) fn new(input: R) -> Self {
        Self {
            window: Window { input, bytes: Vec::new(), start: 0, offset: 0, at_end: false },
            accounted_to: 0,
            last_frame: 0,
            checked_bytes: 0,
            account: Account::default(),
            ended: false,
        }
    }

    /// What became of the bytes; complete once [`next`](Self::next) gave `None`.
    pub(crate) fn account(&self) -> Account {
        self.account
    }

    /// The next intact record; `None` at the end of the file.
    pub(crate) fn next(&mut self) -> io::Result<Option<IntactRecord>> {
        while !self.ended {
            let position = self.window.offset;
            let head = self.window.ahead(LOOK_AHEAD)?;
            let Some(&opcode) = head.first() else {
                self.end();
                break;
            };
            if position == 0 && head.starts_with(mcap::MAGIC) {
                self.accounted_to = mcap::MAGIC.len() as u64;
                self.window.skip(mcap::MAGIC.len());
                continue;
            }
            let frame = match opcode {
                op::CHUNK => chunk_length(head),
                op::ATTACHMENT => attachment_length(head),
                _ => None,
            };
            let found = match frame {
                Some(length) if opcode == op::CHUNK => self.chunk(length)?,
                Some(length) => self.attachment(length)?,
                None => self.structure()?,
            };
            if found.is_some() {
                return Ok(found);
            }
        }
        Ok(None)
    }

    fn chunk(&mut self, length: usize) -> io::Result<Option<IntactRecord>> {
        let position = self.window.offset;
        let frame = self.window.ahead(length)?;
        if frame.len() < length {
            let expected = position == self.accounted_to;
            let effort = u64_at(frame, 25).unwrap_or(0);
            let may_check = expected && may_check(&mut self.checked_bytes, effort, position + frame.len() as u64);
            let unpacked = if may_check { unpack(frame, false) } else { Unpacked::default() };
            self.window.skip(1);
            if !expected {
                return Ok(None);
            }
            self.account.unfinished_chunks += 1;
            return Ok(Some(IntactRecord::UnfinishedChunk(unpacked)));
        }
        // A checksum of zero means that there is none.
        let has_checksum = frame[33..37] != [0; 4];
        let effort = u64_at(frame, 25).unwrap_or(u64::MAX).saturating_add(length as u64);
        let unpacked = if has_checksum && may_check(&mut self.checked_bytes, effort, position + length as u64) {
            unpack(frame, true)
        } else {
            Unpacked::default()
        };
        if unpacked.records.is_empty() {
            self.account.damaged_chunks += 1;
            if position == self.accounted_to {
                self.account.dropped += length as u64;
                self.accounted_to = position + length as u64;
            }
            self.window.skip(1);
            return Ok(None);
        }
        self.account.chunks += 1;
        self.take(length);
        Ok(Some(IntactRecord::Chunk(unpacked)))
    }

    fn attachment(&mut self, length: usize) -> io::Result<Option<IntactRecord>> {
        let end = self.window.offset + length as u64;
        let frame = self.window.ahead(length)?;
        let has_checksum = frame.len() == length
            && frame[length - 4..] != [0; 4]
            && may_check(&mut self.checked_bytes, length as u64, end);
        let attachment = match has_checksum.then(|| parse_record(op::ATTACHMENT, &frame[FRAME_HEAD..])) {
            Some(Ok(Record::Attachment { header, data, .. })) => IntactRecord::Attachment {
                name: header.name,
                media_type: header.media_type,
                log_time: header.log_time,
                content: data.into_owned(),
            },
            _ => {
                self.window.skip(1);
                return Ok(None);
            }
        };
        self.take(length);
        Ok(Some(attachment))
    }

    /// Moves past a byte at which no content begins, and accounts for the known structure that begins there, if any.
    fn structure(&mut self) -> io::Result<Option<IntactRecord>> {
        let position = self.window.offset;
        let mut metadata = None;
        let frame =
            if position == self.accounted_to { rebuildable_frame(self.window.ahead(FRAME_HEAD)?) } else { None };
        if let Some((opcode, length)) = frame
            && let frame = self.window.ahead(length)?
            && adds_up(frame, opcode, length)
        {
            let complete = frame.len() == length;
            if opcode == op::METADATA
                && complete
                && let Ok(Record::Metadata(record)) = parse_record(opcode, &frame[FRAME_HEAD..])
            {
                metadata = Some(IntactRecord::Metadata(record));
            }
            if opcode == op::DATA_END && complete {
                self.account.finished = true;
                self.account.dropped_content = self.account.dropped;
            }
            self.last_frame = position;
            self.accounted_to = position.saturating_add(length as u64);
        } else if position == self.accounted_to && self.window.ahead(mcap::MAGIC.len() + 1)? == mcap::MAGIC {
            self.last_frame = position;
            self.accounted_to = position + mcap::MAGIC.len() as u64;
        }
        self.window.skip(1);
        self.window
            .skip_until(|byte, offset| byte == op::CHUNK || byte == op::ATTACHMENT || offset == self.accounted_to);
        Ok(metadata)
    }

    fn take(&mut self, length: usize) {
        let position = self.window.offset;
        self.account.dropped += position.saturating_sub(self.accounted_to);
        self.accounted_to = position + length as u64;
        self.last_frame = self.accounted_to;
        self.window.skip(length);
    }

    fn end(&mut self) {
        let total = self.window.offset;
        self.account.bytes = total;
        self.account.dropped +=
            if self.accounted_to > total { total - self.last_frame.min(total) } else { total - self.accounted_to };
        if !self.account.finished {
            self.account.dropped_content = self.account.dropped;
        }
        self.ended = true;
    }
}

/// Whether `more_bytes` of a record that ends at `position` may be unpacked and compared with a checksum; if so, counts them. Without a
/// limit, records inside records could keep the reader busy for ever.
fn may_check(checked_bytes: &mut u64, more_bytes: u64, position: u64) -> bool {
    let total = checked_bytes.saturating_add(more_bytes);
    let permitted = total <= 2 * may_unpack_to(position);
    if permitted {
        *checked_bytes = total;
    }
    permitted
}

/// Length of the whole record, if the lengths in a chunk's header agree with each other.
fn chunk_length(head: &[u8]) -> Option<usize> {
    let length = u64_at(head, 1)?;
    let compression = u64::from(u32_at(head, 37)?);
    if compression > 64 {
        return None;
    }
    let compressed = u64_at(head, 41 + usize::try_from(compression).ok()?)?;
    let agrees = length == compressed.checked_add(40 + compression)?;
    record_length(length).filter(|_| agrees)
}

/// Length of the whole record, if the lengths in an attachment agree with each other.
fn attachment_length(head: &[u8]) -> Option<usize> {
    let length = u64_at(head, 1)?;
    let agrees = attachment_body_length(&head[FRAME_HEAD..]) == Some(length);
    record_length(length).filter(|_| agrees)
}

/// The length of an attachment's body that follows from the lengths inside it.
///
/// `mcap::parse_record` takes it for granted that they fit.
pub(crate) fn attachment_body_length(body: &[u8]) -> Option<u64> {
    let name = u64::from(u32_at(body, 16)?);
    let media_type = u64::from(u32_at(body, usize::try_from(20 + name).ok()?)?);
    let content = u64_at(body, usize::try_from(24 + name + media_type).ok()?)?;
    content.checked_add(36 + name + media_type)
}

/// Opcode and whole length of a record that is made anew when the file is written again.
fn rebuildable_frame(head: &[u8]) -> Option<(u8, usize)> {
    let opcode = *head.first()?;
    let length = record_length(u64_at(head, 1)?)?;
    is_rebuildable(opcode).then_some((opcode, length))
}

/// Whether a record is made anew when the file is written again.
const fn is_rebuildable(opcode: u8) -> bool {
    !matches!(opcode, op::CHUNK | op::MESSAGE | op::ATTACHMENT) && !shape(opcode).is_empty()
}

/// True when the lengths inside a record add up to `length`, as far as `frame` shows them.
///
/// Without this, a chunk whose opcode is damaged would pass for an index and not be missed.
fn adds_up(frame: &[u8], opcode: u8, length: usize) -> bool {
    let mut end = FRAME_HEAD;
    for stretch in shape(opcode) {
        end += match stretch {
            Stretch::Fixed(bytes) => *bytes,
            Stretch::Counted | Stretch::Map => match u32_at(frame, end) {
                Some(bytes) => 4 + bytes as usize,
                None => return frame.len() < length && end < length,
            },
        };
        if end > length {
            return false;
        }
    }
    end == length
}

fn record_length(body: u64) -> Option<usize> {
    let length = usize::try_from(body).ok()?.checked_add(FRAME_HEAD)?;
    (length <= MAX_RECORD_BYTES).then_some(length)
}

fn u64_at(bytes: &[u8], offset: usize) -> Option<u64> {
    Some(u64::from_le_bytes(*bytes.get(offset..)?.first_chunk()?))
}

fn u32_at(bytes: &[u8], offset: usize) -> Option<u32> {
    Some(u32::from_le_bytes(*bytes.get(offset..)?.first_chunk()?))
}

/// Decompresses a chunk. If `checked`, a chunk whose checksum is wrong gives no records; else it gives those before the first damaged
/// byte.
fn unpack(frame: &[u8], checked: bool) -> Unpacked {
    let mut reader = LinearReader::new_with_options(
        LinearReaderOptions::default()
            .with_skip_start_magic(true)
            .with_skip_end_magic(true)
            .with_prevalidate_chunk_crcs(checked)
            .with_record_length_limit(MAX_RECORD_BYTES),
    );
    let mut unpacked = Unpacked::default();
    let mut rest = frame;
    while let Some(event) = reader.next_event() {
        match event {
            Ok(LinearReadEvent::ReadRequest(need)) => {
                if rest.is_empty() {
                    break;
                }
                let length = need.clamp(1, rest.len());
                let (now, later) = rest.split_at(length);
                reader.insert(length).copy_from_slice(now);
                reader.notify_read(length);
                rest = later;
            }
            Ok(LinearReadEvent::Record { data, opcode }) => {
                let start = unpacked.bytes.len();
                unpacked.bytes.extend_from_slice(data);
                unpacked.records.push((opcode, start..unpacked.bytes.len()));
            }
            Err(_damaged) if checked => return Unpacked::default(),
            Err(_cut_off) => break,
        }
    }
    unpacked
}

/// A sliding view of a file.
struct Window<R> {
    input: R,
    bytes: Vec<u8>,
    start: usize,
    /// Position of the view's first byte in the file.
    offset: u64,
    at_end: bool,
}

impl<R: Read> Window<R> {
    /// The next `length` bytes, or fewer where the file ends.
    fn ahead(&mut self, length: usize) -> io::Result<&[u8]> {
        while self.bytes.len() - self.start < length && !self.at_end {
            if self.start >= READ_BYTES {
                self.bytes.drain(..self.start);
                self.start = 0;
            }
            let filled = self.bytes.len();
            self.bytes.resize(filled + READ_BYTES, 0);
            let read = loop {
                match self.input.read(&mut self.bytes[filled..]) {
                    Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                    other => break other,
                }
            };
            self.bytes.truncate(filled + *read.as_ref().unwrap_or(&0));
            self.at_end = read? == 0;
        }
        let end = self.bytes.len().min(self.start.saturating_add(length));
        Ok(&self.bytes[self.start..end])
    }

    fn skip(&mut self, length: usize) {
        let length = length.min(self.bytes.len() - self.start);
        self.start += length;
        self.offset += length as u64;
    }

    /// Moves within what is already read to the first byte of interest.
    fn skip_until(&mut self, interesting: impl Fn(u8, u64) -> bool) {
        let offset = self.offset;
        let view = &self.bytes[self.start..];
        let length =
            view.iter().zip(offset..).position(|(&byte, position)| interesting(byte, position)).unwrap_or(view.len());
        self.skip(length);
    }
}
