//! Taking away what a rig's processes left in shared memory.

use std::path::Path;
use std::time::Duration;

use iceoryx2::node::{CleanupState, Node, NodeState};
use iceoryx2::prelude::{CallbackProgression, ipc};

use crate::rig::{self, SHARED_MEMORY};
use crate::services::{self, ServiceError};

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
    let alone = attached(&node) == 1;
    drop(node);
    if alone {
        // iceoryx2 keeps a file per rig for good; with nobody attached nobody needs it.
        for file in files_in_shared_memory(&rig::runtime_dir()) {
            let _ = std::fs::remove_file(Path::new(SHARED_MEMORY).join(file));
        }
    }
    Ok(files_in_shared_memory(&rig::runtime_dir()).len())
}

/// Names of the files that the rig with this runtime directory has in shared memory.
#[must_use]
pub fn files_in_shared_memory(runtime_dir: &Path) -> Vec<String> {
    let prefix = rig::shared_memory_prefix_of(runtime_dir);
    let entries = std::fs::read_dir(SHARED_MEMORY).into_iter().flatten().flatten();
    entries
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .filter(|name| name.starts_with(&prefix))
        .collect()
}

/// Nodes of this rig that are not known to be dead, the caller's included.
fn attached(node: &services::RigNode) -> usize {
    let mut count = 0;
    let listed = Node::<ipc::Service>::list(node.config(), |state| {
        count += usize::from(!matches!(state, NodeState::Dead(_)));
        CallbackProgression::Continue
    });
    // What cannot be listed may be alive.
    if listed.is_ok() { count } else { usize::MAX }
}
