//! Where in a run samples are missing: between which ones, at which ticks and times.

use crate::sequence::{Gap, LISTED_GAPS, SequenceLedger};

/// A sample that is there, and when it was taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// Its number in the run.
    pub seq: u64,
    /// Its scheduled tick; `None` in a file that does not tell.
    pub tick: Option<u64>,
}

impl Place {
    /// Time in the run; the tick where the rate is not known, or the sample where the tick is not.
    pub(crate) fn in_words(self, rate_hz: Option<f64>) -> String {
        match (self.tick, rate_hz) {
            (Some(tick), Some(rate_hz)) => format!("{:.4} s", tick as f64 / rate_hz),
            (Some(tick), None) => format!("tick {tick}"),
            (None, _) => format!("sample {}", self.seq),
        }
    }
}

/// A run of missing samples and what lies on either side of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Loss {
    /// The samples that are missing.
    pub gap: Gap,
    /// The last sample before them; `None` at the start of the run.
    pub after: Option<Place>,
    /// The first sample behind them; `None` at the end.
    pub before: Option<Place>,
}

impl Loss {
    /// Which samples, and between which times.
    pub(crate) fn in_words(&self, rate_hz: Option<f64>) -> String {
        let Self { gap, after, before } = self;
        let place = |place: &Place| place.in_words(rate_hz);
        match (after, before) {
            (Some(after), Some(before)) => format!("{gap} between {} and {}", place(after), place(before)),
            (None, Some(before)) => format!("{gap} before {}", place(before)),
            (Some(after), None) => format!("{gap} after {}", place(after)),
            (None, None) => gap.to_string(),
        }
    }
}

/// Follows a ledger and takes note of what lies on either side of each gap.
#[derive(Debug, Default)]
pub(crate) struct Losses {
    first: Option<Place>,
    last: Option<Place>,
    missing: u64,
    losses: Vec<Loss>,
}

impl Losses {
    /// Takes note of what the ledger counted since the last time: a sample with its tick, or the end.
    pub(crate) fn note(&mut self, ledger: &SequenceLedger, tick: Option<u64>) {
        let here = ledger.last().filter(|&seq| self.last.is_none_or(|last| seq > last.seq));
        let here = here.map(|seq| Place { seq, tick });
        if ledger.missing() > self.missing
            && self.losses.len() < LISTED_GAPS
            && let Some(&gap) = ledger.gaps().last()
        {
            self.losses.push(Loss { gap, after: self.last, before: here });
        }
        self.missing = ledger.missing();
        self.first = self.first.or(here);
        self.last = here.or(self.last);
    }

    /// The first sample, the last one, and what is missing.
    pub(crate) fn into_parts(self) -> (Option<Place>, Option<Place>, Vec<Loss>) {
        (self.first, self.last, self.losses)
    }
}
