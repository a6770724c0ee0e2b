//! A rig that shares no code with ours: the example plug-in, compiled here, from its file to a fitted model, and all that can go
//! wrong with it.
#![allow(clippy::unwrap_used, reason = "a test may stop at a failure")]

mod captures;
mod faults;
mod interface;

use std::path::{Path, PathBuf};
use std::process::Command;

use tests::Bench;

/// The folder of the repository.
fn repository() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap()
}

/// Compiles a library in the bench's folder.
fn compile(bench: &Bench, source: &Path, library: &str) -> PathBuf {
    let compiled = bench.path(library);
    let output = Command::new("cc")
        .args(["-O2", "-Wall", "-Wextra", "-Werror", "-shared", "-fPIC", "-I"])
        .arg(repository().join("hal/src/plugin"))
        .arg("-o")
        .args([&compiled, source])
        .arg("-lm")
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    compiled
}

/// The example's library and a file of its rig, changed by `edit`, with further settings; the file's name.
///
/// A slow watchdog by default, so that stalls of the host cost ticks and not the run.
fn rig(bench: &Bench, settings: &str, edit: impl Fn(String) -> String) -> String {
    let example = repository().join("hal/examples/plug-in");
    if !bench.path("rotary_plant.so").exists() {
        compile(bench, &example.join("rotary_plant.c"), "rotary_plant.so");
    }
    let text = std::fs::read_to_string(example.join("rotary_plant.toml")).unwrap();
    let library = "library = \"rotary_plant.so\"";
    assert!(text.contains(library), "{text}");
    let text = text.replace(library, &format!("{library}\n{settings}")).replace("timeout_s = 0.1", "timeout_s = 1.0");
    std::fs::write(bench.path("rig.toml"), edit(text)).unwrap();
    "rig.toml".to_owned()
}

/// Takes a table out of a rig file.
fn without(text: &str, table: &str) -> String {
    let start = text.find(table).unwrap();
    let end = text[start + 1..].find("\n[").map_or(text.len(), |end| start + 1 + end);
    format!("{}{}", &text[..start], &text[end..])
}
