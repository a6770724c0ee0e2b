//! A process that may open no further file says so, and does not blame the shared memory.
#![allow(clippy::unwrap_used, reason = "a test may stop at a failure")]

use nix::sys::resource::{Resource, getrlimit, setrlimit};
use shared_types::rig::RUNTIME_DIR_VARIABLE;
use shared_types::services;

#[test]
fn want_of_file_descriptors_is_reported_as_what_it_is() {
    let folder = tempfile::tempdir().unwrap();
    // SAFETY: the only test of this binary, and no other thread reads the environment.
    #[allow(unsafe_code, reason = "the environment names the rig")]
    unsafe {
        std::env::set_var(RUNTIME_DIR_VARIABLE, folder.path().join("rig"));
    }
    let node = services::attach("test").unwrap();
    let open = std::fs::read_dir("/proc/self/fd").unwrap().count() as u64;
    let (_, most) = getrlimit(Resource::RLIMIT_NOFILE).unwrap();
    setrlimit(Resource::RLIMIT_NOFILE, open, most).unwrap();
    let error = services::sample_publisher(&node).unwrap_err().to_string();
    setrlimit(Resource::RLIMIT_NOFILE, most.min(1024), most).unwrap();
    assert!(error.contains("ulimit -n") && !error.contains("/dev/shm"), "{error}");
    drop(node);
    shared_types::clean_up::clear_shared_memory().unwrap();
}
