//! Taking away what a rig's processes left in shared memory.

use std::path::{Path, PathBuf};
use std::time::Duration;

use iceoryx2::node::{CleanupState, Node, NodeState};
use iceoryx2::prelude::CallbackProgression;

use crate::private_ipc::PrivateIpc;
use crate::rig;
use crate::services::{self, ServiceError};
use crate::shared_memory_dir;

/// A process that was killed is not known as dead to iceoryx2 at once, hence retries.
const RETRIES: u32 = 10;

/// Removes what dead processes of this rig left, and, when no process is attached any more, all of the rig's files.
///
/// Gives the number of the rig's files that are still there: 0 unless a process is still attached.
///
/// # Errors
/// [`ServiceError`] when the rig cannot be attached to.
pub fn clear_shared_memory() -> Result<usize, ServiceError> {
    let node = services::attach("clean-up")?;
    for _ in 0..RETRIES {
        let CleanupState { failed_cleanups, .. } = node.blocking_cleanup_dead_nodes(Duration::from_millis(200));
        if failed_cleanups == 0 && attached(&node) == 1 {
            break;
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    // Nobody attaches between the look and the removal.
    let held = shared_memory_dir::hold()?;
    let alone = attached(&node) == 1;
    drop(node);
    if alone && let Err(error) = shared_memory_dir::remove(&held) {
        return Err(services::unavailable("clean-up", &error));
    }
    drop(held);
    Ok(files_in_shared_memory(&rig::runtime_dir()).len())
}

/// What the rig with this runtime directory has in shared memory: its folder there and everything in it.
#[must_use]
pub fn files_in_shared_memory(runtime_dir: &Path) -> Vec<PathBuf> {
    let mut found = shared_memory_dir::of_rig(runtime_dir);
    let mut next = 0;
    while let Some(path) = found.get(next) {
        // What is no folder has no entries.
        let entries =
            std::fs::read_dir(path).into_iter().flatten().flatten().map(|entry| entry.path()).collect::<Vec<_>>();
        found.extend(entries);
        next += 1;
    }
    found
}

/// Nodes of this rig that are not known to be dead, the caller's included.
fn attached(node: &services::RigNode) -> usize {
    let mut count = 0;
    let listed = Node::<PrivateIpc>::list(node.config(), |state| {
        count += usize::from(!matches!(state, NodeState::Dead(_)));
        CallbackProgression::Continue
    });
    // What cannot be listed may be alive.
    if listed.is_ok() { count } else { usize::MAX }
}
