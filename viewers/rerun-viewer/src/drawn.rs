//! What was drawn, kept for the pages that ask for it.
//!
//! A page asks for a range of frames and is given one rerun file with one message for each entity, since rerun's program spends
//! its time per message, not per point. Messages without a time (layout, styles, axes, detents) are kept in their newest
//! state as long as the viewer lives; of the run itself, as much is kept as there is room for.

use std::collections::VecDeque;
use std::sync::Arc;

use anyhow::Context as _;
use parking_lot::Mutex;
use rerun::SizeBytes as _;
use rerun::external::re_log_encoding::Encoder;
use rerun::external::re_log_types::StoreId;
use rerun::log::{Chunk, LogMsg};
use rerun::sink::CallbackSink;
use serde::Serialize;

use crate::drawing::TIMELINE;

/// Bytes of the run at which an answer ends: more than the 10 s that the plots show. At least as much is kept, for the pages that
/// are open.
const ANSWER_BYTES: u64 = 2 << 20;
/// Frames at which an answer ends: the 10 s that the plots show.
const ANSWER_FRAMES: usize = 40;

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

/// What was drawn, shared by those who draw and those who serve.
#[derive(Clone, Debug)]
pub struct Drawn(Arc<Mutex<Kept>>);

#[derive(Debug)]
struct Kept {
    limit_bytes: u64,
    /// Not yet part of a frame.
    loose: Vec<LogMsg>,
    lasting: Vec<Lasting>,
    pieces: VecDeque<Piece>,
    next: u64,
}

/// A message that belongs to no time, which came with the frame of this number.
#[derive(Debug)]
struct Lasting {
    number: u64,
    /// The key that a newer version of the message shares; `None` for names of recordings and the layout.
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

impl Drawn {
    /// An empty store that will keep at most `limit_bytes` of the run, but never less than one answer.
    pub fn new(limit_bytes: u64) -> Self {
        let limit_bytes = limit_bytes.max(ANSWER_BYTES);
        let (loose, lasting, pieces) = Default::default();
        Self(Arc::new(Mutex::new(Kept { limit_bytes, loose, lasting, pieces, next: 0 })))
    }

    /// Where a recording sends what is drawn.
    pub fn sink(&self) -> CallbackSink {
        let drawn = self.clone();
        CallbackSink::new(move |messages| drawn.0.lock().loose.extend_from_slice(messages))
    }

    /// Makes a frame of what has come since the last one.
    pub fn seal(&self) {
        self.0.lock().seal();
    }

    /// The newest of the kept frames from number `from` to before number `to`, as a rerun file that is empty when nothing is new.
    /// Without `to`, the frames reach to the newest one, and the file also has the new messages without a time.
    pub fn answer(&self, from: u64, to: Option<u64>) -> anyhow::Result<(Contents, Vec<u8>)> {
        let (contents, mut messages, chunks) = self.0.lock().pick(from, to);
        let mut chunks = merged(chunks)?;
        // The newest row last: once the viewer holds it, it holds all of them.
        chunks.sort_by_key(|(_, chunk)| newest_ns(chunk));
        for (store, chunk) in chunks {
            messages.push(LogMsg::ArrowMsg(store, chunk.to_arrow_msg()?));
        }
        let encoded = if messages.is_empty() { Ok(Vec::new()) } else { encode(&messages) };
        Ok((contents, encoded.context("what was drawn cannot be encoded")?))
    }
}

impl Kept {
    fn seal(&mut self) {
        let (number, mut chunks) = (self.next, Vec::new());
        for message in std::mem::take(&mut self.loose) {
            let key = match &message {
                LogMsg::ArrowMsg(store, data) if !store.is_blueprint() => match Chunk::from_arrow_msg(data) {
                    Ok(chunk) if !chunk.is_static() => {
                        chunks.push((store.clone(), chunk));
                        continue;
                    }
                    lasting => lasting.ok().map(|chunk| key(store, &chunk)),
                },
                _ => None,
            };
            self.lasting.retain(|old| key.is_none() || old.key != key);
            self.lasting.push(Lasting { number, key, message });
        }
        self.next += 1;
        if !chunks.is_empty() {
            let bytes = chunks.iter().map(|(_, chunk)| chunk.total_size_bytes()).sum();
            self.pieces.push_back(Piece { number, chunks, bytes });
        }
        let mut kept_bytes: u64 = self.pieces.iter().map(|piece| piece.bytes).sum();
        while kept_bytes > self.limit_bytes
            && let Some(oldest) = self.pieces.pop_front()
        {
            kept_bytes -= oldest.bytes;
        }
    }

    /// The contents of an answer, its messages without a time, and the rows of the run in the order in which they were
    /// drawn.
    fn pick(&self, from: u64, to: Option<u64>) -> (Contents, Vec<LogMsg>, Vec<(StoreId, Chunk)>) {
        let end = to.unwrap_or(self.next).min(self.next);
        let [begin, after] = [from, end].map(|end| self.pieces.partition_point(|piece| piece.number < end));
        let mut first = after;
        let mut bytes = 0;
        while first > begin && after - first < ANSWER_FRAMES && bytes < ANSWER_BYTES {
            first -= 1;
            bytes += self.pieces[first].bytes;
        }
        let chunks: Vec<_> = self.pieces.range(first..after).flat_map(|piece| piece.chunks.iter().cloned()).collect();
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

/// The key that a newer version of a message has in common with the version that it replaces.
fn key(store: &StoreId, chunk: &Chunk) -> String {
    let mut components: Vec<_> = chunk.components_identifiers().map(|name| name.to_string()).collect();
    components.sort_unstable();
    format!("{} {} {}", store.recording_id(), chunk.entity_path(), components.join(" "))
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

fn encode(messages: &[LogMsg]) -> anyhow::Result<Vec<u8>> {
    let mut encoder = Encoder::local()?;
    // An index for whoever seeks in a file; here each is read once from its beginning.
    encoder.do_not_emit_footer();
    encoder.extend(messages.iter().map(Ok))?;
    encoder.finish()?;
    Ok(encoder.into_inner()?)
}

#[cfg(test)]
mod tests {
    use rerun::external::re_log_encoding::Decoder;
    use rerun::{RecordingStream, RecordingStreamBuilder, Scalars, TextDocument};

    use super::*;

    /// Values that make a large share of an answer.
    const MUCH: i64 = 40_000;

    /// A recording that is drawn in.
    struct Bench {
        drawn: Drawn,
        recording: RecordingStream,
    }

    impl Bench {
        fn new(limit_bytes: u64) -> Self {
            let drawn = Drawn::new(limit_bytes);
            let recording = RecordingStreamBuilder::new("test").buffered().unwrap();
            recording.set_sink(Box::new(drawn.sink()));
            Self { drawn, recording }
        }

        fn seal(&self) {
            self.recording.flush_blocking().unwrap();
            self.drawn.seal();
        }

        /// Pieces of the run: so many values at each of these moments, which do not compress.
        fn draw(&self, moments: std::ops::Range<i64>, values: i64) {
            let noise = |moment, index| ((index * 2_654_435_761 + moment) as f64).sqrt().sin();
            for moment in moments {
                self.recording.set_time_sequence(TIMELINE, moment);
                self.recording.log("value", &Scalars::new((0..values).map(|index| noise(moment, index)))).unwrap();
                self.seal();
            }
        }

        fn draw_lasting(&self, text: &str) {
            self.recording.log_static("text", &TextDocument::new(text)).unwrap();
            self.seal();
        }

        /// What a page is given: the metadata, and the entities in its file with their numbers of rows.
        fn given(&self, from: u64, to: Option<u64>) -> (Contents, Vec<(String, usize)>) {
            let (contents, file) = self.drawn.answer(from, to).unwrap();
            let file = Some(file.as_slice()).filter(|file| !file.is_empty());
            let messages = file.into_iter().flat_map(|file| Decoder::decode_eager(file).unwrap());
            let chunks = messages.filter_map(|message| match message.unwrap() {
                LogMsg::ArrowMsg(_, data) => Some(Chunk::from_arrow_msg(&data).unwrap()),
                _ => None,
            });
            let rows = chunks.map(|chunk| (chunk.entity_path().to_string(), chunk.num_rows()));
            (contents, rows.filter(|(entity, _)| !entity.starts_with("/__")).collect())
        }
    }

    fn rows(of: &str, chunks: &[(String, usize)]) -> usize {
        chunks.iter().filter(|(entity, _)| entity == of).map(|(_, rows)| rows).sum()
    }

    #[test]
    fn a_page_is_given_each_row_once() {
        let bench = Bench::new(u64::MAX);
        let mut next = 0;
        for moments in [0..3, 3..5] {
            let fresh = moments.clone().count();
            bench.draw(moments, 1);
            let (contents, chunks) = bench.given(next, None);
            assert_eq!((rows("/value", &chunks), contents.first), (fresh, next));
            next = contents.next;
            assert!(bench.drawn.answer(next, None).unwrap().1.is_empty());
        }
    }

    #[test]
    fn whoever_is_behind_is_given_one_message_for_each_entity() {
        let bench = Bench::new(u64::MAX);
        bench.draw(0..17, 1);
        let (contents, chunks) = bench.given(0, None);
        assert_eq!(chunks, [("/value".to_owned(), 17)]);
        assert_eq!(contents.newest_ns, Some(16));
        let store = bench.recording.store_info().unwrap().store_id;
        assert_eq!(contents.recording, Some(store.recording_id().to_string()));
    }

    #[test]
    fn the_present_comes_before_the_past_and_the_past_completely() {
        let bench = Bench::new(u64::MAX);
        let frames = 3 * ANSWER_FRAMES + 5;
        bench.draw(0..frames as i64, 1);
        let (mut contents, chunks) = bench.given(0, None);
        assert_eq!(contents.newest_ns, Some(frames as i64 - 1));
        let mut found = rows("/value", &chunks);
        while contents.first > 0 {
            let to = contents.first;
            let (earlier, chunks) = bench.given(0, Some(to));
            assert!(earlier.first < to, "it goes back");
            found += rows("/value", &chunks);
            contents = earlier;
        }
        assert_eq!(found, frames);
    }

    #[test]
    fn what_belongs_to_no_time_is_kept_in_its_newest_state_and_of_the_run_one_answer_whatever_the_limit() {
        let bench = Bench::new(0);
        bench.draw_lasting("before");
        let (Contents { next, .. }, _) = bench.given(0, None);
        bench.draw(0..20, MUCH);
        bench.draw_lasting("after");
        let (contents, chunks) = bench.given(0, None);
        assert_eq!(rows("/text", &chunks), 1);
        assert!((1..20).contains(&rows("/value", &chunks)), "the newest of the run: {chunks:?}");
        assert!(bench.drawn.answer(0, Some(contents.first)).unwrap().1.is_empty(), "nothing else is kept");
        assert_eq!(rows("/text", &bench.given(next, None).1), 1, "a page that is there is given the new one");
    }

    #[test]
    fn an_answer_is_no_larger_than_it_may_be() {
        let bench = Bench::new(u64::MAX);
        bench.draw(0..20, MUCH);
        let (contents, chunks) = bench.given(0, None);
        assert!((1..20).contains(&rows("/value", &chunks)), "{chunks:?}");
        assert!(contents.first > 0, "the rest can be asked for");
    }
}
