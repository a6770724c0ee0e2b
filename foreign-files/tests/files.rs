//! What a path may stand for, and what is done about it.
#![allow(clippy::unwrap_used, reason = "tests")]

use std::path::Path;

#[test]
fn what_is_no_file_is_refused_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("pipe");
    nix::unistd::mkfifo(&pipe, nix::sys::stat::Mode::S_IRWXU).unwrap();
    let socket = folder.path().join("socket");
    let _listener = std::os::unix::net::UnixListener::bind(&socket).unwrap();
    for (path, what) in [
        (pipe.as_path(), "a pipe"),
        (socket.as_path(), "a socket"),
        (folder.path(), "a folder"),
        (Path::new("/dev/zero"), "a device"),
        (Path::new("/dev/full"), "a device"),
    ] {
        assert_eq!(foreign_files::open(path).unwrap_err().to_string(), format!("it is {what}, not a file"));
    }
}

#[test]
fn a_text_is_read_whole_or_not_at_all() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.toml");
    std::fs::write(&path, "name = \"ü\"").unwrap();
    assert_eq!(foreign_files::read_text(&path).unwrap(), "name = \"ü\"");
    std::fs::write(&path, b"name = \"\xff\"").unwrap();
    assert_eq!(foreign_files::read_text(&path).unwrap_err().to_string(), "it is not UTF-8 text");
    // A hole: nothing on the disk, and a length of 8 GiB.
    std::fs::File::create(&path).unwrap().set_len(8 << 30).unwrap();
    assert_eq!(foreign_files::read_text(&path).unwrap_err().to_string(), "it is longer than 4 MiB");
}
