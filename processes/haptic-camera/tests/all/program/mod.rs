//! Calls of the program in a folder, and what came of them.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

/// The program in a folder, with the words of a line.
pub fn command(folder: &Path, line: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_haptic-camera"));
    command.args(line.split_whitespace()).current_dir(folder);
    command
}

pub fn call(folder: &Path, line: &str) -> Output {
    command(folder, line).output().unwrap()
}

/// What a call that succeeds prints on standard output.
pub fn done(folder: &Path, line: &str) -> String {
    let output = call(folder, line);
    assert_eq!(output.status.code(), Some(0), "{line}: {}", words(&output));
    String::from_utf8(output.stdout).unwrap()
}

/// The one sentence of a call that fails.
pub fn refused(folder: &Path, line: &str) -> String {
    let output = call(folder, line);
    let said = errors(&output).trim().to_owned();
    assert_eq!(output.status.code(), Some(1), "{line}: {said}");
    assert_eq!(said.lines().count(), 1, "one sentence: {said}");
    said
}

pub fn errors(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Everything that was printed.
pub fn words(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned() + &errors(output)
}

/// The files of a folder with this ending.
pub fn files(folder: &Path, ending: &str) -> Vec<PathBuf> {
    let all = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    all.filter(|path| path.extension().is_some_and(|found| found == ending)).collect()
}

/// The only file of a folder with this ending.
pub fn only(folder: &Path, ending: &str) -> PathBuf {
    let mut found = files(folder, ending);
    assert_eq!(found.len(), 1, "{found:?}");
    found.remove(0)
}

pub fn json(path: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
}
