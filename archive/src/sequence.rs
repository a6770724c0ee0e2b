//! Which samples are there and which are missing.

use serde::{Deserialize, Serialize};

/// A run of samples that were published and are not there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Gap {
    /// The first missing `seq`.
    pub first_missing_seq: u64,
    /// The last missing `seq`.
    pub last_missing_seq: u64,
    /// How many are missing: last - first + 1.
    pub count: u64,
}

impl Gap {
    fn between(first_missing_seq: u64, last_missing_seq: u64) -> Self {
        Self { first_missing_seq, last_missing_seq, count: last_missing_seq - first_missing_seq + 1 }
    }
}

impl std::fmt::Display for Gap {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { first_missing_seq, last_missing_seq, count } = self;
        if *count == 1 {
            write!(f, "sample {first_missing_seq}")
        } else {
            write!(f, "samples {first_missing_seq} to {last_missing_seq} ({count})")
        }
    }
}

/// Keeps account of a stream of `seq` numbers: what came, what came again, what never came.
///
/// ```
/// use archive::SequenceLedger;
///
/// let mut ledger = SequenceLedger::default();
/// assert!(ledger.admit(0));
/// assert!(!ledger.admit(0), "the same sample again");
/// assert!(ledger.admit(3));
/// assert_eq!(ledger.missing(), 2);
/// assert_eq!(ledger.gaps()[0].to_string(), "samples 1 to 2 (2)");
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SequenceLedger {
    first: Option<u64>,
    last: Option<u64>,
    admitted: u64,
    repeated: u64,
    gaps: Vec<Gap>,
    missing: u64,
}

/// Gaps that are listed one by one; further ones are only counted.
pub const LISTED_GAPS: usize = 10_000;

impl SequenceLedger {
    /// Takes note of a sample; false when it, or a later one, was there already.
    #[must_use]
    pub fn admit(&mut self, seq: u64) -> bool {
        let next = self.next();
        if seq < next {
            self.repeated += 1;
            return false;
        }
        if seq > next {
            self.note_gap(next, seq - 1);
        }
        self.first.get_or_insert(seq);
        self.last = Some(seq);
        self.admitted += 1;
        true
    }

    /// Takes note that the run had `published` samples: what is missing at the end is a gap too.
    pub fn close(&mut self, published: u64) {
        if published > self.next() {
            self.note_gap(self.next(), published - 1);
        }
    }

    fn note_gap(&mut self, first: u64, last: u64) {
        let gap = Gap::between(first, last);
        self.missing += gap.count;
        if self.gaps.len() < LISTED_GAPS {
            self.gaps.push(gap);
        }
    }

    /// The `seq` that continues the stream.
    #[must_use]
    pub fn next(&self) -> u64 {
        self.last.map_or(0, |last| last.saturating_add(1))
    }

    /// The first `seq` that came.
    #[must_use]
    pub fn first(&self) -> Option<u64> {
        self.first
    }

    /// The last `seq` that came.
    #[must_use]
    pub fn last(&self) -> Option<u64> {
        self.last
    }

    /// Samples that came, each counted once.
    #[must_use]
    pub fn admitted(&self) -> u64 {
        self.admitted
    }

    /// Samples that came again.
    #[must_use]
    pub fn repeated(&self) -> u64 {
        self.repeated
    }

    /// Samples that never came.
    #[must_use]
    pub fn missing(&self) -> u64 {
        self.missing
    }

    /// Where samples are missing, in order; at most [`LISTED_GAPS`].
    #[must_use]
    pub fn gaps(&self) -> &[Gap] {
        &self.gaps
    }
}
