//! What the consumers print while a panel is on the terminal: collected in a file, and printed above the panel.

use std::fs::File;
use std::os::unix::fs::FileExt as _;
use std::process::Command;

use crate::outcome::remark;

/// Most bytes to print at a time.
const MOST_BYTES: usize = 1 << 16;

/// A file without a name that the consumers print to. Unlike a pipe it never fills, and never fails whoever writes to it
/// after this process is gone.
pub(super) struct Words {
    file: Option<File>,
    printed: u64,
}

impl Words {
    /// For a run with a panel; otherwise the consumers print for themselves.
    pub(super) fn apart_from_panel(panel: bool) -> Self {
        // Without such a file they disturb the panel, which is no reason not to run.
        Self { file: panel.then(|| tempfile::tempfile().ok()).flatten(), printed: 0 }
    }

    /// Redirects a program's output here.
    pub(super) fn take_from(&self, command: &mut Command) {
        let Some(file) = &self.file else { return };
        if let (Ok(output), Ok(errors)) = (file.try_clone(), file.try_clone()) {
            command.stdout(output).stderr(errors);
        }
    }

    /// Prints the lines that have come since the last time.
    pub(super) fn tell(&mut self) {
        let Some(file) = &self.file else { return };
        if file.metadata().is_ok_and(|file| file.len() <= self.printed) {
            return;
        }
        let mut bytes = vec![0; MOST_BYTES];
        let read = file.read_at(&mut bytes, self.printed).unwrap_or(0);
        let Some(end) = bytes[..read].iter().rposition(|&byte| byte == b'\n') else { return };
        self.printed += end as u64 + 1;
        String::from_utf8_lossy(&bytes[..end]).lines().for_each(remark);
    }
}
