//! `recover`: a whole archive of a broken one, or of the parts that a killed recorder left.

use std::path::{Path, PathBuf};

use anyhow::Context as _;
use archive::Unchecked;
use archive::whole_file::beside;

use crate::command_line::RecoverOptions;
use crate::outcome::{Outcome, remark, say};

/// Recovers what is sound and says what was kept and lost.
///
/// # Errors
/// When nothing can be read or the result cannot be written.
pub fn run(options: &RecoverOptions) -> anyhow::Result<Outcome> {
    let RecoverOptions { broken, out, keep_unchecked } = options;
    let unchecked = if *keep_unchecked { Unchecked::Keep } else { Unchecked::LeaveOut };
    let parts = if broken.exists() { Vec::new() } else { parts_of(broken) };
    let summary = match parts.as_slice() {
        [] => archive::recover(broken, out, unchecked)?,
        [part] => {
            remark(format!("{} was never closed; recovering its part {}", broken.display(), part.display()));
            archive::recover(part, out, unchecked)?
        }
        _ => return merge(broken, &parts, out),
    };
    say(format!("{}: {summary}", out.display()));
    Ok(if summary.lossy { Outcome::DataLost } else { Outcome::Done })
}

/// The parts of an archive that was never closed, as the recorder names them: beside it, and in the temporary directory.
fn parts_of(archive: &Path) -> Vec<PathBuf> {
    let elsewhere = std::env::temp_dir().join(archive.file_name().unwrap_or_default());
    let places = if elsewhere == archive { vec![archive] } else { vec![archive, elsewhere.as_path()] };
    let numbered = |place: &Path| (0..1_000).map(|number| beside(place, &format!(".part-{number:03}"))).collect();
    places.into_iter().flat_map(|place| -> Vec<PathBuf> { numbered(place) }).filter(|path| path.is_file()).collect()
}

/// Makes one archive of the parts of a recording that nobody ended.
fn merge(archive: &Path, parts: &[PathBuf], out: &Path) -> anyhow::Result<Outcome> {
    let merged = archive::merge(parts, out, None)
        .with_context(|| format!("{} was never closed, and its parts cannot be merged", archive.display()))?;
    let ledger = &merged.ledger;
    let bounds = ledger.first().zip(ledger.last()).map_or_else(String::new, |(a, b)| format!(" ({a} to {b})"));
    let gaps: Vec<String> = ledger.gaps().iter().take(10).map(ToString::to_string).collect();
    let missing = if gaps.is_empty() { "none missing between them".to_owned() } else { gaps.join(", ") + " missing" };
    say(format!(
        "{}: kept {} samples{bounds} of {} parts, {missing}; {} bytes dropped; the recording was not finished, what \
         came after is not in the parts",
        out.display(),
        ledger.admitted(),
        parts.len(),
        merged.bytes_dropped
    ));
    Ok(Outcome::DataLost)
}
