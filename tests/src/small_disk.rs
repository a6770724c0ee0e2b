//! A disk that is soon full.
#![allow(clippy::unwrap_used, clippy::print_stderr, reason = "a test may stop at a failure; a skipped one says so")]

use std::path::{Path, PathBuf};
use std::process::Command;

/// A disk of so many kilobytes, for as long as it lives.
#[derive(Debug)]
pub struct SmallDisk(PathBuf);

impl SmallDisk {
    /// Mounts it at a folder, which is created if need be; `None`, and a word on standard error, where that is not permitted.
    ///
    /// # Panics
    /// If the folder cannot be created.
    #[must_use]
    pub fn mount(folder: &Path, kilobytes: u32) -> Option<Self> {
        std::fs::create_dir_all(folder).unwrap();
        let size = format!("size={kilobytes}k");
        let mounted = Command::new("mount").args(["-t", "tmpfs", "-o", &size, "tmpfs"]).arg(folder).output();
        if mounted.is_ok_and(|output| output.status.success()) {
            return Some(Self(folder.to_owned()));
        }
        eprintln!("SKIPPED: no permission to mount a small disk");
        None
    }

    /// The folder at which it is mounted.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.0
    }

    /// Mounts it again with other options.
    ///
    /// # Panics
    /// If that fails.
    pub fn remount(&self, options: &str) {
        let options = format!("remount,{options}");
        assert!(Command::new("mount").args(["-o", &options]).arg(&self.0).status().unwrap().success());
    }
}

impl Drop for SmallDisk {
    fn drop(&mut self) {
        // What stays mounted goes with the machine; there is nothing better to do.
        let _ = Command::new("umount").arg("--lazy").arg(&self.0).status();
    }
}
