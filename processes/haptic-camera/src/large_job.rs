//! Runs and captures that are large for this machine: a warning before they start, a refusal where they cannot succeed.

use std::path::Path;

use anyhow::{Context as _, ensure};
use archive::memory;
use archive::whole_file::folder_of;

use crate::outcome::remark;

/// Bytes of archive that a sample takes, compressed with its sensors' noise (66 to 68, measured over the five knobs).
const ARCHIVED_BYTES: f64 = 68.0;
/// Ticks from which on a run counts as large: a quarter of an hour at 20 kHz, a gigabyte of archive.
const LARGE: u64 = 18_000_000;
const GIGABYTE: f64 = 1e9;

/// Tells how large the archive of a run of so many ticks becomes, and how much memory its fit takes.
pub fn tell(ticks: u64) {
    if ticks >= LARGE {
        let (millions, archived_gb) = (ticks as f64 / 1e6, ticks as f64 * ARCHIVED_BYTES / GIGABYTE);
        let fitted_gb = archived_gb * memory::OF_FILE;
        remark(format!(
            "up to {millions:.0} million samples: an archive of {archived_gb:.1} GB, and {fitted_gb:.1} GB of memory to fit it"
        ));
    }
}

pub fn admit(ticks: u64, rate_hz: f64, archive: &Path) -> anyhow::Result<()> {
    if ticks < LARGE {
        return Ok(());
    }
    let archived = ticks as f64 * ARCHIVED_BYTES;
    let duration_s = ticks as f64 / rate_hz;
    let folder = folder_of(archive);
    let disk = nix::sys::statvfs::statvfs(folder).with_context(|| format!("{} cannot be used", folder.display()))?;
    let on_disk = (disk.blocks_available() as f64) * disk.fragment_size() as f64;
    let fits = |what: &str, needed: f64, free: f64| -> anyhow::Result<()> {
        ensure!(
            needed <= free,
            "a run of {duration_s:.0} s takes {:.1} GB of {what}, and {:.1} GB are free: make it at most {:.0} s long",
            needed / GIGABYTE,
            free / GIGABYTE,
            (duration_s * free / needed).floor()
        );
        Ok(())
    };
    fits(&format!("the disk of {}", folder.display()), archived, on_disk)?;
    memory::available().map_or(Ok(()), |free| fits("memory for its fit", archived * memory::OF_FILE, free))
}
