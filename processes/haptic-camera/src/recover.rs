//! `recover`: a whole archive of a broken one.

use crate::command_line::RecoverOptions;
use crate::outcome::{Outcome, say};

/// Recovers what is sound and says what was kept and lost.
///
/// # Errors
/// When nothing can be read or the result cannot be written.
pub fn run(options: &RecoverOptions) -> anyhow::Result<Outcome> {
    let summary = archive::recover(&options.broken, &options.out)?;
    say(format!("{}: {summary}", options.out.display()));
    Ok(if summary.lossy { Outcome::DataLost } else { Outcome::Done })
}
