//! What was drawn, kept for the pages that ask for it.
//!
//! Everything that is drawn ends here as rerun's messages and leaves as rerun's files: each piece of the run is one,
//! complete in itself, encoded once. What belongs to no time (layout, styles, axes, detents) is kept in its newest
//! state as long as the viewer lives; of the run itself as much as there is room for.

use std::borrow::Borrow;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

use anyhow::Context as _;
use rerun::external::re_log_encoding::Encoder;
use rerun::log::{Chunk, LogMsg};
use serde::Serialize;

/// Bytes of the run at which an answer ends, and what a page that is opened is given at first: some 25 seconds. As much is
/// kept at least, for the pages that are there.
const ANSWER_BYTES: usize = 2 << 20;

/// What a page asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wish {
    /// Everything that belongs to no time, and the present.
    Beginning,
    /// What came with this number and since.
    Since(u64),
    /// What came before this number, the newest of it.
    Before(u64),
}

/// Where a page stands once it has what it was given; `None` where that is as before.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Standing {
    /// Number from which to ask for more of the run.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub next: Option<u64>,
    /// Number before which to ask for more of the past; 0 when that is all.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub oldest: Option<u64>,
    /// Whether more of what is new waits already.
    pub behind: bool,
}

/// What a page is given.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Given {
    /// Where it stands then.
    pub standing: Standing,
    /// rerun files, in the order in which they are to be shown.
    pub files: Vec<Arc<[u8]>>,
}

/// What was drawn, shared by those who draw and those who serve.
#[derive(Clone, Debug)]
pub struct Drawn(Arc<Mutex<Kept>>);

/// A message that belongs to no time, in the version with this number.
#[derive(Debug)]
struct Lasting {
    number: u64,
    key: Option<String>,
    message: LogMsg,
}

/// One piece of the run.
#[derive(Debug)]
struct Piece {
    number: u64,
    file: Arc<[u8]>,
}

#[derive(Debug)]
struct Kept {
    limit_bytes: u64,
    /// Not yet part of a piece.
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
            limit_bytes: limit_bytes.max(ANSWER_BYTES as u64),
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

    /// Makes what has come since the last time fit to be given away.
    ///
    /// # Errors
    /// When rerun cannot encode it; it is then left out.
    pub fn seal(&self) -> anyhow::Result<()> {
        self.with(Kept::seal)
    }

    /// What a page wishes, as far as it is kept.
    ///
    /// # Errors
    /// When rerun cannot encode it.
    pub fn give(&self, wish: Wish) -> anyhow::Result<Given> {
        self.with(|kept| kept.give(wish))
    }

    fn with<Answer>(&self, work: impl FnOnce(&mut Kept) -> Answer) -> Answer {
        // Whatever panicked in between left whole messages.
        work(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl Kept {
    fn seal(&mut self) -> anyhow::Result<()> {
        let mut passing = Vec::new();
        for message in std::mem::take(&mut self.loose) {
            match time_of(&message) {
                Time::Passing => passing.push(message),
                Time::Lasting(key) => {
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
        if !passing.is_empty() {
            let file: Arc<[u8]> = encode(&passing)?.into();
            self.pieces_bytes += file.len() as u64;
            self.pieces.push_back(Piece { number, file });
        }
        while self.pieces_bytes > self.limit_bytes
            && let Some(oldest) = self.pieces.pop_front()
        {
            self.pieces_bytes -= oldest.file.len() as u64;
        }
        Ok(())
    }

    fn give(&self, wish: Wish) -> anyhow::Result<Given> {
        let newest_first = self.pieces.iter().rev();
        match wish {
            Wish::Beginning => {
                let mut given = back_in_time(newest_first);
                given.standing.next = Some(self.next);
                given.files.splice(0..0, self.lasting_since(0)?);
                Ok(given)
            }
            Wish::Before(number) => Ok(back_in_time(newest_first.skip_while(|piece| piece.number >= number))),
            Wish::Since(number) => {
                let mut files = self.lasting_since(number)?;
                let new = self.pieces.partition_point(|piece| piece.number < number);
                let (pieces, more) = one_answer(self.pieces.iter().skip(new));
                files.extend(pieces);
                let next = Some(more.map_or(self.next, |piece| piece.number));
                Ok(Given { standing: Standing { next, oldest: None, behind: more.is_some() }, files })
            }
        }
    }

    /// What belongs to no time and has changed since a number: one file, or none.
    fn lasting_since(&self, number: u64) -> anyhow::Result<Vec<Arc<[u8]>>> {
        let changed: Vec<&LogMsg> =
            self.lasting.iter().filter(|lasting| lasting.number >= number).map(|lasting| &lasting.message).collect();
        if changed.is_empty() { Ok(Vec::new()) } else { Ok(vec![encode(&changed)?.into()]) }
    }
}

/// As many of `pieces` as go into one answer, and the first that does not.
fn one_answer<'a>(pieces: impl Iterator<Item = &'a Piece>) -> (Vec<Arc<[u8]>>, Option<&'a Piece>) {
    let mut files = Vec::new();
    let mut bytes = 0;
    for piece in pieces {
        if bytes > ANSWER_BYTES {
            return (files, Some(piece));
        }
        bytes += piece.file.len();
        files.push(Arc::clone(&piece.file));
    }
    (files, None)
}

/// The first of `pieces`, which go back in time, in the order of time.
fn back_in_time<'a>(pieces: impl Iterator<Item = &'a Piece>) -> Given {
    let (mut files, more) = one_answer(pieces);
    files.reverse();
    let oldest = Some(more.map_or(0, |piece| piece.number + 1));
    Given { standing: Standing { next: None, oldest, behind: false }, files }
}

/// Whether a message belongs to a time of the run.
enum Time {
    Passing,
    /// It does not, and takes the place of what had this key.
    Lasting(Option<String>),
}

fn time_of(message: &LogMsg) -> Time {
    match message {
        LogMsg::ArrowMsg(store, data) if !store.is_blueprint() => match Chunk::from_arrow_msg(data) {
            Ok(chunk) if chunk.is_static() => {
                let mut components: Vec<_> = chunk.components_identifiers().map(|name| name.to_string()).collect();
                components.sort_unstable();
                let key = format!("{} {} {}", store.recording_id(), chunk.entity_path(), components.join(" "));
                Time::Lasting(Some(key))
            }
            // What cannot be read here may still be shown.
            _ => Time::Passing,
        },
        // Names of recordings and the layout.
        _ => Time::Lasting(None),
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
        recording.set_time_sequence("moment", moment);
        recording.log("value", &Scalars::single(moment as f64)).unwrap();
        recording.flush_blocking().unwrap();
        drawn.seal().unwrap();
    }

    /// A large share of an answer, and nothing that compresses.
    fn draw_much(drawn: &Drawn, recording: &RecordingStream, moment: u64) {
        let noise = (0..40_000).map(|index| ((index * 2_654_435_761_u64 + moment) as f64).sqrt().sin());
        recording.set_time_sequence("moment", i64::try_from(moment).unwrap());
        recording.log("value", &Scalars::new(noise)).unwrap();
        recording.flush_blocking().unwrap();
        drawn.seal().unwrap();
    }

    fn draw_lasting(drawn: &Drawn, recording: &RecordingStream, text: &str) {
        recording.log_static("text", &TextDocument::new(text)).unwrap();
        recording.flush_blocking().unwrap();
        drawn.seal().unwrap();
    }

    /// The chunks in what a page was given, one file after the other: their entities, and whether they belong to no time.
    fn chunks(given: &Given) -> Vec<(String, bool)> {
        let all = given.files.concat();
        if all.is_empty() {
            return Vec::new();
        }
        let messages = Decoder::decode_eager(all.as_slice()).unwrap();
        messages
            .filter_map(|message| match message.unwrap() {
                LogMsg::ArrowMsg(_, data) => Some(Chunk::from_arrow_msg(&data).unwrap()),
                _ => None,
            })
            .map(|chunk| (chunk.entity_path().to_string(), chunk.is_static()))
            .filter(|(entity, _)| !entity.starts_with("/__"))
            .collect()
    }

    fn count(given: &Given, wanted: &str) -> usize {
        chunks(given).iter().filter(|(entity, _)| entity == wanted).count()
    }

    #[test]
    fn a_page_is_given_each_piece_once() {
        let (drawn, recording) = drawn(u64::MAX);
        (0..3).for_each(|moment| draw(&drawn, &recording, moment));
        let first = drawn.give(Wish::Beginning).unwrap();
        assert_eq!(count(&first, "/value"), 3);
        assert_eq!(first.standing.oldest, Some(0));
        let next = first.standing.next.unwrap();
        assert_eq!(drawn.give(Wish::Since(next)).unwrap().files.len(), 0);
        (3..5).for_each(|moment| draw(&drawn, &recording, moment));
        let more = drawn.give(Wish::Since(next)).unwrap();
        assert_eq!(count(&more, "/value"), 2);
        assert!(!more.standing.behind);
        assert_eq!(drawn.give(Wish::Since(more.standing.next.unwrap())).unwrap().files.len(), 0);
    }

    #[test]
    fn the_past_comes_after_the_present_and_completely() {
        let (drawn, recording) = drawn(u64::MAX);
        (0..20).for_each(|moment| draw_much(&drawn, &recording, moment));
        let given = drawn.give(Wish::Beginning).unwrap();
        let mut oldest = given.standing.oldest.unwrap();
        let mut found = count(&given, "/value");
        assert!((1..20).contains(&found), "{found} of 20 in the first answer");
        assert!(drawn.give(Wish::Since(0)).unwrap().standing.behind, "as many do not go into one answer");
        while oldest > 0 {
            let past = drawn.give(Wish::Before(oldest)).unwrap();
            found += count(&past, "/value");
            assert!(past.standing.oldest.unwrap() < oldest, "it goes back");
            oldest = past.standing.oldest.unwrap();
        }
        assert_eq!(found, 20);
    }

    #[test]
    fn what_belongs_to_no_time_is_kept_in_its_newest_state_whatever_the_limit() {
        let (drawn, recording) = drawn(0);
        draw_lasting(&drawn, &recording, "before");
        let next = drawn.give(Wish::Beginning).unwrap().standing.next.unwrap();
        (0..20).for_each(|moment| draw_much(&drawn, &recording, moment));
        draw_lasting(&drawn, &recording, "after");
        let given = drawn.give(Wish::Beginning).unwrap();
        assert_eq!(count(&given, "/text"), 1);
        assert!((1..20).contains(&count(&given, "/value")), "the newest of the run: {:?}", chunks(&given));
        assert_eq!(given.standing.oldest, Some(0), "nothing else is kept");
        assert_eq!(
            count(&drawn.give(Wish::Since(next)).unwrap(), "/text"),
            1,
            "a page that is there is given the new one"
        );
    }
}
