//! What the consumers print while a panel is on the terminal: kept apart from it, and told above it.

use std::fs::File;
use std::os::unix::fs::FileExt as _;
use std::process::Command;

use crate::outcome::remark;

/// Most that is told at a time, bytes.
const MOST_BYTES: usize = 1 << 16;

/// A file without a name that the consumers print to. Unlike a pipe it never fills, and never fails whoever writes to it
/// after this process is gone.
pub(super) struct Words {
    file: Option<File>,
    told: u64,
}

impl Words {
    /// For a run with a panel; otherwise the consumers print for themselves.
    pub(super) fn apart_from_panel(panel: bool) -> Self {
        // Without such a file they disturb the panel, which is no reason not to run.
        Self { file: panel.then(|| tempfile::tempfile().ok()).flatten(), told: 0 }
    }

    /// Has a program print here.
    pub(super) fn take_from(&self, command: &mut Command) {
        let Some(file) = &self.file else { return };
        if let (Ok(output), Ok(errors)) = (file.try_clone(), file.try_clone()) {
            command.stdout(output).stderr(errors);
        }
    }

    /// Tells the lines that have been printed since the last time.
    pub(super) fn tell(&mut self) {
        let Some(file) = &self.file else { return };
        if file.metadata().is_ok_and(|file| file.len() <= self.told) {
            return;
        }
        let mut bytes = vec![0; MOST_BYTES];
        let read = file.read_at(&mut bytes, self.told).unwrap_or(0);
        let Some(end) = bytes[..read].iter().rposition(|&byte| byte == b'\n') else { return };
        self.told += end as u64 + 1;
        String::from_utf8_lossy(&bytes[..end]).lines().for_each(remark);
    }
}
