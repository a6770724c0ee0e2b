//! What reading a capture takes of the machine's memory.

/// Bytes of memory that reading and fitting a capture takes for each byte of its file: measured, 3.5 for an archive and 3 for
/// a table.
pub const OF_FILE: f64 = 4.0;
/// Bytes that each row of a table takes besides, as its numbers, however few letters these have.
pub(crate) const OF_ROW: f64 = 64.0;
/// The same where the cells are kept as text until it is known what they are: a record with its two allocations.
pub(crate) const OF_FOREIGN_ROW: f64 = 300.0;

/// Memory that the machine can still give, bytes (`MemAvailable` of proc(5)); `None` where it does not say.
#[must_use]
pub fn available() -> Option<f64> {
    let account = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = account.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    let kibibytes: f64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kibibytes * 1024.0)
}
