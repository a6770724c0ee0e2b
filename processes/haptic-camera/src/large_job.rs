//! Runs and captures that are large for this machine: told before they start, and refused where they cannot end well.

use std::path::Path;

use anyhow::{Context as _, ensure};
use archive::memory;

use crate::outcome::remark;

/// Bytes of archive that a sample takes, compressed with its sensors' noise (66 to 68, measured over the five knobs).
const ARCHIVED_BYTES: f64 = 68.0;
/// Ticks from which on a run counts as large: a quarter of an hour at 20 kHz, a gigabyte of archive.
const LARGE: u64 = 18_000_000;
const GIGABYTE: f64 = 1e9;

/// Tells how large a run of so many ticks becomes, and refuses one for which disk or memory are too small.
///
/// One that `may_end_early` is not refused for what it could come to.
///
/// # Errors
/// One sentence with the longest run that would fit.
#[allow(clippy::cast_precision_loss, reason = "ticks of a day, and bytes for display")]
pub fn admit(ticks: u64, rate_hz: f64, archive: &Path, may_end_early: bool) -> anyhow::Result<()> {
    if ticks < LARGE {
        return Ok(());
    }
    let samples = ticks as f64;
    let archived = samples * ARCHIVED_BYTES;
    let analysed = archived * memory::OF_FILE;
    remark(format!(
        "up to {:.0} million samples: an archive of {:.1} GB, and {:.1} GB of memory to fit it",
        samples / 1e6,
        archived / GIGABYTE,
        analysed / GIGABYTE
    ));
    if may_end_early {
        return Ok(());
    }
    let folder = archive.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let disk = nix::sys::statvfs::statvfs(folder).with_context(|| format!("{} cannot be used", folder.display()))?;
    let on_disk = (disk.blocks_available() as f64) * disk.fragment_size() as f64;
    let fits = |what: &str, needed: f64, free: f64| {
        ensure!(
            needed <= free,
            "a run of {:.0} s takes {:.1} GB of {what}, and {:.1} GB are free: make it at most {:.0} s long",
            samples / rate_hz,
            needed / GIGABYTE,
            free / GIGABYTE,
            (samples / rate_hz * free / needed).floor()
        );
        Ok(())
    };
    fits(&format!("the disk of {}", folder.display()), archived, on_disk)?;
    memory::available().map_or(Ok(()), |free| fits("memory for its fit", analysed, free))
}
