//! What keeps iceoryx2 from giving shared memory, where it can be told.

use nix::sys::resource::{Resource, getrlimit};

/// Open files that a process of the rig needs besides those it has when it attaches: every segment is one.
const NEEDED_FILES: u64 = 100;

/// What to do about shared memory that cannot be had: iceoryx2's own word does not tell a limit from a full disk.
pub(crate) fn advice() -> String {
    let open = std::fs::read_dir("/proc/self/fd").map_or(u64::MAX, |files| files.count() as u64);
    match getrlimit(Resource::RLIMIT_NOFILE) {
        Ok((limit, _)) if limit < open.saturating_add(NEEDED_FILES) => {
            format!("the limit of {limit} open files is too low: raise it, as by `ulimit -n 1024`")
        }
        _ => "check permissions and space in /dev/shm".to_owned(),
    }
}
