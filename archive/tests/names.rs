//! Names are claimed and never taken from what has them.

#![allow(clippy::unwrap_used, reason = "tests")]

use std::fs;
use std::path::PathBuf;

use archive::whole_file::{Replace, put_in_place, write_bytes};
use archive::{ArchiveError, Claim, claim, own_file};

#[test]
fn claims_of_one_name_made_at_once_are_all_different_and_leave_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let claims: Vec<Claim> = std::thread::scope(|scope| {
        let takers: Vec<_> = (0..16).map(|_| scope.spawn(|| Claim::take(folder.path(), "run"))).collect();
        takers.into_iter().map(|taker| taker.join().unwrap()).collect()
    });
    let mut names: Vec<PathBuf> = claims.iter().map(|claim| claim.archive().to_owned()).collect();
    names.sort();
    names.dedup();
    assert_eq!(names.len(), 16);
    assert!(names.contains(&folder.path().join("run.mcap")) && names.contains(&folder.path().join("run_16.mcap")));
    drop(claims);
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    // Results and parts of an earlier run have the name too, and so has a link to nothing.
    fs::write(folder.path().join("run.json"), "{}").unwrap();
    fs::write(folder.path().join("run_02.mcap.part-000"), "").unwrap();
    std::os::unix::fs::symlink("nowhere", folder.path().join("run_03.toml")).unwrap();
    assert_eq!(Claim::take(folder.path(), "run").archive(), folder.path().join("run_04.mcap"));
    let folders = [(); 3].map(|()| claim::folder(folder.path(), "made").unwrap());
    assert_eq!(folders, ["made", "made_02", "made_03"].map(|name| folder.path().join(name)));
}

#[test]
fn a_file_takes_the_place_of_its_own_kind_and_of_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out");
    let mark = Replace::Marked("made by us");
    write_bytes(&path, mark, b"made by us: 1").unwrap();
    write_bytes(&path, mark, b"made by us: 2").unwrap();
    write_bytes(&path, mark, b"another").unwrap();
    for replace in [mark, Replace::Nothing] {
        let refused = write_bytes(&path, replace, b"made by us: 3");
        assert!(matches!(refused, Err(ArchiveError::Occupied { .. })), "{refused:?}");
    }
    assert_eq!(fs::read(&path).unwrap(), b"another");
    write_bytes(&path, Replace::Anything, b"made by us: 4").unwrap();
    // A file that is finished elsewhere takes no name that another has.
    let finished = folder.path().join("finished");
    fs::write(&finished, "the run").unwrap();
    assert!(matches!(put_in_place(&finished, &path), Err(ArchiveError::Occupied { .. })));
    assert_eq!(fs::read(&finished).unwrap(), b"the run");
    put_in_place(&finished, &folder.path().join("free")).unwrap();
    let mut left: Vec<_> = fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    left.sort();
    assert_eq!(left, ["free", "out"]);
}

#[test]
fn only_a_file_is_opened() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    fs::write(path("file"), "here").unwrap();
    std::os::unix::fs::symlink("file", path("link")).unwrap();
    nix::unistd::mkfifo(&path("pipe"), nix::sys::stat::Mode::S_IRUSR).unwrap();
    own_file::open(&path("file")).unwrap();
    for name in ["link", "pipe", "."] {
        assert!(own_file::open(&path(name)).is_err(), "{name}");
    }
}
