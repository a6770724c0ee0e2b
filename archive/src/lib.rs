//! Captures on disk: written, read, merged and recovered.
//!
//! A capture is an [MCAP](https://mcap.dev/spec) file with the profile `ros2`. Its channels are
//! `/sample`, `/fit`, `/status`, `/health` and, of a replay, `/models`; each message is a four-byte CDR
//! header and the bytes of the payload as they lay in shared memory (a model, which is text, as CDR
//! writes it), and each channel carries the `ros2msg` schema that says what those bytes are. Any
//! ROS 2, Foxglove or rerun tool opens it. Besides the messages a
//! capture holds
//!
//! - the metadata record `capture`: rig, knob, rate, clock, versions and the unit of every column;
//! - the metadata record `gaps`, where samples are missing: which ones, exactly;
//! - attachments: `run.json` (the run's description), `channels.json` (what each channel holds, so
//!   that a file whose first chunk is damaged can still be read), `excitation.toml`,
//!   `calibration.toml` and, for a simulated knob, `model.toml`. Attachments carry checksums.
//!
//! Chunks are written whole and closed at least every half second, so that a process which is
//! killed leaves a file that is sound up to its last chunk.
//!
//! | module | what it does |
//! |---|---|
//! | [`mod@write`] | [`CaptureWriter`]: the recorder's way in |
//! | [`capture`] | [`Capture`]: columns, from MCAP, CSV or ASAM MDF |
//! | [`columns`] | the list of the columns that a capture can have |
//! | [`schema`] | where each field lies in a message, from the schema in the file |
//! | [`recover`](mod@recover) | a whole file from a broken one, saying what was lost |
//! | [`merge`](mod@merge) | one file from the parts that a restarted recorder leaves |
//! | [`parts`], [`claim`] | the names of files while a run is recorded, and where they lie |
//! | [`testers`] | [`Curve`](testers::Curve): load over position, as other people's testers measured it |
//! | [`whole_file`] | every output: whole or not at all, and in nothing else's place |
//! | [`sequence`] | which samples are there and which are missing |
//!
//! ```
//! use archive::CaptureWriter;
//! use shared_types::Sample;
//!
//! # fn main() -> Result<(), archive::ArchiveError> {
//! # let description = archive::doc_example_description();
//! let mut writer = CaptureWriter::new(std::io::Cursor::new(Vec::new()), &description)?;
//! writer.sample(&Sample { seq: 0, tick: 0, torque_mnm: 1.5, ..Sample::default() })?;
//! writer.flush()?;
//! let (written, _file) = writer.finish()?;
//! assert_eq!(written.samples, 1);
//! # Ok(())
//! # }
//! ```

pub mod capture;
mod channels;
pub mod claim;
pub mod columns;
mod combine;
mod csv_file;
mod description;
mod error;
mod losses;
mod mcap_file;
pub mod memory;
pub mod merge;
mod overview;
pub mod own_file;
mod parse;
pub mod parts;
mod records;
pub mod recover;
mod rig_account;
pub mod schema;
pub mod sequence;
mod source;
pub mod testers;
pub mod whole_file;
pub mod write;

pub use capture::Capture;
pub use claim::Claim;
pub use description::{CAPTURE_METADATA, GAPS_METADATA, RECOVERY_METADATA, attachment, unit_of};
pub use error::ArchiveError;
pub use losses::{Loss, Place};
pub use merge::{MergeSummary, merge, run_id};
pub use overview::Overview;
pub use recover::{RecoverySummary, Unchecked, recover};
pub use rig_account::{RigAccount, RigClock};
pub use sequence::{Gap, SequenceLedger};
pub use write::{CaptureWriter, WriteSummary};

/// A run description for the examples in the documentation.
#[doc(hidden)]
#[must_use]
pub fn doc_example_description() -> shared_types::RunDescription {
    shared_types::RunDescription {
        run_id: 1,
        software_version: "0.1.0".to_owned(),
        apparatus: "sim".to_owned(),
        knob: "1".to_owned(),
        rate_hz: 10_000.0,
        planned_ticks: 10,
        ..shared_types::RunDescription::default()
    }
}
