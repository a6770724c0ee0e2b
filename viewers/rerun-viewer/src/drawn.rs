//! What was drawn, kept for the pages that ask for it.
//!
//! Everything that is drawn ends here as rerun's messages, a few for each frame. A page asks for a range of frames and is
//! given one rerun file in which the frames are merged: one message for each entity, however many frames there are, since
//! what rerun's program takes in costs it by the message, not by the point. What belongs to no time (layout, styles, axes,
//! detents) is kept in its newest state as long as the viewer lives; of the run itself as much as there is room for.

use std::borrow::Borrow;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

use anyhow::Context as _;
use rerun::SizeBytes as _;
use rerun::external::re_log_encoding::Encoder;
use rerun::external::re_log_types::StoreId;
use rerun::log::{Chunk, LogMsg};
use serde::Serialize;

use crate::drawing::TIMELINE;

/// Bytes of the run at which an answer ends. It is more than the plots show, 10 s, and as much is kept at least, for the
/// pages that are there.
const ANSWER_BYTES: u64 = 2 << 20;
/// Frames at which an answer ends: the 10 s that the plots show.
const ANSWER_FRAMES: usize = 40;

/// The frames that a page lacks, by their numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameRange {
    /// The first.
    pub from: u64,
    /// The first that it does not lack; `None` for all that are new, and what belongs to no time besides.
    pub to: Option<u64>,
}

/// Metadata of the file sent to a page.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Contents {
    /// The first frame in the file; earlier ones that were asked for are kept, and can be asked for again.
    pub first: u64,
    /// The frame after the last one.
    pub next: u64,
    /// The recording that the newest row belongs to.
    pub recording: Option<String>,
    /// The time of that row, ns: once the viewer holds it, it has taken the file in.
    pub newest_ns: Option<i64>,
}

/// What a page is given.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Answer {
    /// What is in the file.
    pub contents: Contents,
    /// A rerun file; empty when nothing is new.
    pub file: Vec<u8>,
}

/// What was drawn, shared by those who draw and those who serve.
#[derive(Clone, Debug)]
pub struct Drawn(Arc<Mutex<Kept>>);

/// A message that belongs to no time, which came with the frame of this number.
#[derive(Debug)]
struct Lasting {
    number: u64,
    key: Option<String>,
    message: LogMsg,
}

/// One frame of the run.
#[derive(Debug)]
struct Piece {
    number: u64,
    chunks: Vec<(StoreId, Chunk)>,
    bytes: u64,
}

#[derive(Debug)]
struct Kept {
    limit_bytes: u64,
    /// Not yet part of a frame.
    loose: Vec<LogMsg>,
    lasting: Vec<Lasting>,
    pieces: VecDeque<Piece>,
    pieces_bytes: u64,
    next: u64,
}

impl Drawn {
    /// Nothing yet; of the run no more than `limit_bytes` will be kept, or one answer.
    #[must_use]
    pub fn new(limit_bytes: u64) -> Self {
        Self(Arc::new(Mutex::new(Kept {
            limit_bytes: limit_bytes.max(ANSWER_BYTES),
            loose: Vec::new(),
            lasting: Vec::new(),
            pieces: VecDeque::new(),
            pieces_bytes: 0,
            next: 0,
        })))
    }

    /// Takes messages as rerun hands them over.
    pub fn take_in(&self, messages: &[LogMsg]) {
        self.with(|kept| kept.loose.extend_from_slice(messages));
    }

    /// Makes a frame of what has come since the last one.
    pub fn seal(&self) {
        self.with(Kept::seal);
    }

    /// The newest of the frames that a page lacks, as far as they are kept.
    ///
    /// # Errors
    /// When rerun cannot merge or encode them.
    pub fn answer(&self, wanted: FrameRange) -> anyhow::Result<Answer> {
        let (contents, lasting, chunks) = self.with(|kept| kept.pick(wanted));
        let mut messages = lasting;
        let mut chunks = merged(chunks)?;
        // The newest row last: once the viewer holds it, it holds all of them.
        chunks.sort_by_key(|(_, chunk)| newest_ns(chunk));
        for (store, chunk) in chunks {
            messages.push(LogMsg::ArrowMsg(store, chunk.to_arrow_msg()?));
        }
        let file = if messages.is_empty() { Vec::new() } else { encode(&messages)? };
        Ok(Answer { contents, file })
    }

    fn with<T>(&self, work: impl FnOnce(&mut Kept) -> T) -> T {
        // Whatever panicked in between left whole messages.
        work(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl Kept {
    fn seal(&mut self) {
        let mut chunks = Vec::new();
        for message in std::mem::take(&mut self.loose) {
            match Row::of(message) {
                Row::Passing(store, chunk) => chunks.push((store, chunk)),
                Row::Lasting(key, message) => {
                    // Its newer version takes the place of the older one.
                    if key.is_some() {
                        self.lasting.retain(|old| old.key != key);
                    }
                    self.lasting.push(Lasting { number: self.next, key, message });
                }
            }
        }
        let number = self.next;
        self.next += 1;
        if !chunks.is_empty() {
            let bytes = chunks.iter().map(|(_, chunk)| chunk.total_size_bytes()).sum();
            self.pieces_bytes += bytes;
            self.pieces.push_back(Piece { number, chunks, bytes });
        }
        while self.pieces_bytes > self.limit_bytes
            && let Some(oldest) = self.pieces.pop_front()
        {
            self.pieces_bytes -= oldest.bytes;
        }
    }

    /// What an answer tells, what belongs to no time in it, and the rows of the run in the order in which they were drawn.
    fn pick(&self, FrameRange { from, to }: FrameRange) -> (Contents, Vec<LogMsg>, Vec<(StoreId, Chunk)>) {
        let end = to.unwrap_or(self.next).min(self.next);
        let begin = self.pieces.partition_point(|piece| piece.number < from);
        let after = self.pieces.partition_point(|piece| piece.number < end);
        let mut first = after;
        let mut bytes = 0;
        while first > begin && after - first < ANSWER_FRAMES && bytes < ANSWER_BYTES {
            first -= 1;
            bytes += self.pieces[first].bytes;
        }
        let chunks: Vec<_> =
            self.pieces.range(first..after.max(first)).flat_map(|piece| piece.chunks.iter().cloned()).collect();
        let newest =
            chunks.iter().filter_map(|(store, chunk)| Some((store, newest_ns(chunk)?))).max_by_key(|(_, time)| *time);
        let contents = Contents {
            first: if first > begin { self.pieces[first].number } else { from },
            next: end,
            recording: newest.map(|(store, _)| store.recording_id().to_string()),
            newest_ns: newest.map(|(_, time)| time),
        };
        let new = |lasting: &&Lasting| to.is_none() && lasting.number >= from;
        let lasting = self.lasting.iter().filter(new).map(|lasting| lasting.message.clone()).collect();
        (contents, lasting, chunks)
    }
}

/// The time of a chunk's newest row, ns.
fn newest_ns(chunk: &Chunk) -> Option<i64> {
    let times = chunk.timelines().values().find(|times| times.name() == TIMELINE)?;
    Some(times.time_range().max().as_i64())
}

/// One chunk for all rows of an entity that have the same columns.
fn merged(chunks: Vec<(StoreId, Chunk)>) -> anyhow::Result<Vec<(StoreId, Chunk)>> {
    let mut alike: Vec<(StoreId, Vec<Chunk>)> = Vec::new();
    for (store, chunk) in chunks {
        match alike.iter_mut().find(|(other, group)| *other == store && group[0].concatenable(&chunk)) {
            Some((_, group)) => group.push(chunk),
            None => alike.push((store, vec![chunk])),
        }
    }
    let whole = |(store, mut group): (StoreId, Vec<Chunk>)| -> anyhow::Result<(StoreId, Chunk)> {
        // By pairs, so that no row is copied more often than the logarithm of their number.
        while group.len() > 1 {
            group = group
                .chunks(2)
                .map(|pair| match pair {
                    [one, other] => Chunk::concat_and_sort(one, other),
                    _ => Ok(pair[0].clone()),
                })
                .collect::<Result<Vec<_>, _>>()?;
        }
        Ok((store, group.remove(0)))
    };
    alike.into_iter().map(whole).collect()
}

/// Whether a message belongs to a time of the run.
enum Row {
    Passing(StoreId, Chunk),
    /// It does not, and takes the place of what had this key.
    Lasting(Option<String>, LogMsg),
}

impl Row {
    fn of(message: LogMsg) -> Self {
        let chunk = match &message {
            LogMsg::ArrowMsg(store, data) if !store.is_blueprint() => {
                Chunk::from_arrow_msg(data).ok().map(|chunk| (store.clone(), chunk))
            }
            // Names of recordings and the layout.
            _ => None,
        };
        match chunk {
            Some((store, chunk)) if chunk.is_static() => {
                let mut components: Vec<_> = chunk.components_identifiers().map(|name| name.to_string()).collect();
                components.sort_unstable();
                let key = format!("{} {} {}", store.recording_id(), chunk.entity_path(), components.join(" "));
                Self::Lasting(Some(key), message)
            }
            Some((store, chunk)) => Self::Passing(store, chunk),
            None => Self::Lasting(None, message),
        }
    }
}

fn encode(messages: &[impl Borrow<LogMsg>]) -> anyhow::Result<Vec<u8>> {
    let encode = || {
        let mut encoder = Encoder::local()?;
        // An index for whoever seeks in a file; here each is read once from its beginning.
        encoder.do_not_emit_footer();
        encoder.extend(messages.iter().map(|message| Ok(message.borrow())))?;
        encoder.finish()?;
        encoder.into_inner()
    };
    encode().context("what was drawn cannot be encoded")
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "test")]
mod tests {
    use rerun::external::re_log_encoding::Decoder;
    use rerun::sink::CallbackSink;
    use rerun::{RecordingStream, RecordingStreamBuilder, Scalars, TextDocument};

    use super::*;

    fn drawn(limit_bytes: u64) -> (Drawn, RecordingStream) {
        let drawn = Drawn::new(limit_bytes);
        let recording = RecordingStreamBuilder::new("test").buffered().unwrap();
        let sink = drawn.clone();
        recording.set_sink(Box::new(CallbackSink::new(move |messages| sink.take_in(messages))));
        (drawn, recording)
    }

    /// A piece of the run: a value for this moment.
    fn draw(drawn: &Drawn, recording: &RecordingStream, moment: i64) {
        recording.set_time_sequence(TIMELINE, moment);
        recording.log("value", &Scalars::single(moment as f64)).unwrap();
        recording.flush_blocking().unwrap();
        drawn.seal();
    }

    /// A large share of an answer, and nothing that compresses.
    fn draw_much(drawn: &Drawn, recording: &RecordingStream, moment: u64) {
        let noise = (0..40_000).map(|index| ((index * 2_654_435_761_u64 + moment) as f64).sqrt().sin());
        recording.set_time_sequence(TIMELINE, i64::try_from(moment).unwrap());
        recording.log("value", &Scalars::new(noise)).unwrap();
        recording.flush_blocking().unwrap();
        drawn.seal();
    }

    fn draw_lasting(drawn: &Drawn, recording: &RecordingStream, text: &str) {
        recording.log_static("text", &TextDocument::new(text)).unwrap();
        recording.flush_blocking().unwrap();
        drawn.seal();
    }

    /// The chunks in what a page was given: their entities and numbers of rows.
    fn chunks(answer: &Answer) -> Vec<(String, usize)> {
        if answer.file.is_empty() {
            return Vec::new();
        }
        let messages = Decoder::decode_eager(answer.file.as_slice()).unwrap();
        messages
            .filter_map(|message| match message.unwrap() {
                LogMsg::ArrowMsg(_, data) => Some(Chunk::from_arrow_msg(&data).unwrap()),
                _ => None,
            })
            .map(|chunk| (chunk.entity_path().to_string(), chunk.num_rows()))
            .filter(|(entity, _)| !entity.starts_with("/__"))
            .collect()
    }

    fn rows(answer: &Answer, wanted: &str) -> usize {
        chunks(answer).iter().filter(|(entity, _)| entity == wanted).map(|(_, rows)| rows).sum()
    }

    fn new(drawn: &Drawn, from: u64) -> Answer {
        drawn.answer(FrameRange { from, to: None }).unwrap()
    }

    #[test]
    fn a_page_is_given_each_row_once() {
        let (drawn, recording) = drawn(u64::MAX);
        (0..3).for_each(|moment| draw(&drawn, &recording, moment));
        let first = new(&drawn, 0);
        assert_eq!((rows(&first, "/value"), first.contents.first), (3, 0));
        let next = first.contents.next;
        assert!(new(&drawn, next).file.is_empty());
        (3..5).for_each(|moment| draw(&drawn, &recording, moment));
        let more = new(&drawn, next);
        assert_eq!((rows(&more, "/value"), more.contents.first), (2, next));
        assert!(new(&drawn, more.contents.next).file.is_empty());
    }

    #[test]
    fn whoever_is_behind_is_given_one_message_for_each_entity() {
        let (drawn, recording) = drawn(u64::MAX);
        (0..17).for_each(|moment| draw(&drawn, &recording, moment));
        let given = new(&drawn, 0);
        assert_eq!(chunks(&given), [("/value".to_owned(), 17)]);
        assert_eq!(given.contents.newest_ns, Some(16));
        let store = recording.store_info().unwrap().store_id;
        assert_eq!(given.contents.recording, Some(store.recording_id().to_string()));
    }

    #[test]
    fn the_present_comes_before_the_past_and_the_past_completely() {
        let (drawn, recording) = drawn(u64::MAX);
        let frames = 3 * ANSWER_FRAMES as i64 + 5;
        (0..frames).for_each(|moment| draw(&drawn, &recording, moment));
        let mut given = new(&drawn, 0);
        assert_eq!(given.contents.newest_ns, Some(frames - 1));
        let mut found = rows(&given, "/value");
        while given.contents.first > 0 {
            let to = given.contents.first;
            given = drawn.answer(FrameRange { from: 0, to: Some(to) }).unwrap();
            assert!(given.contents.first < to, "it goes back");
            found += rows(&given, "/value");
        }
        assert_eq!(found, frames as usize);
    }

    #[test]
    fn an_answer_is_no_larger_than_it_may_be() {
        let (drawn, recording) = drawn(u64::MAX);
        (0..20).for_each(|moment| draw_much(&drawn, &recording, moment));
        let given = new(&drawn, 0);
        assert!((1..20).contains(&rows(&given, "/value")), "{:?}", chunks(&given));
        assert!(given.contents.first > 0, "the rest can be asked for");
    }

    #[test]
    fn what_belongs_to_no_time_is_kept_in_its_newest_state_whatever_the_limit() {
        let (drawn, recording) = drawn(0);
        draw_lasting(&drawn, &recording, "before");
        let next = new(&drawn, 0).contents.next;
        (0..20).for_each(|moment| draw_much(&drawn, &recording, moment));
        draw_lasting(&drawn, &recording, "after");
        let given = new(&drawn, 0);
        assert_eq!(rows(&given, "/text"), 1);
        assert!((1..20).contains(&rows(&given, "/value")), "the newest of the run: {:?}", chunks(&given));
        let to = Some(given.contents.first);
        assert!(drawn.answer(FrameRange { from: 0, to }).unwrap().file.is_empty(), "nothing else is kept");
        assert_eq!(rows(&new(&drawn, next), "/text"), 1, "a page that is there is given the new one");
    }
}
