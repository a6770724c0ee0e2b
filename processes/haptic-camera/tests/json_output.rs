//! `--json -`: standard output is one JSON document, whatever else the command has to say.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

fn run(folder: &Path, line: &str) -> Output {
    Command::new(env!("CARGO_BIN_EXE_haptic-camera")).args(line.split(' ')).current_dir(folder).output().unwrap()
}

fn errors(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Makes an archive of that name.
fn archive(folder: &Path, line: &str, name: &str) {
    let output = run(folder, &format!("{line} --offline --rate-hz 5000 --out made"));
    assert_eq!(output.status.code(), Some(0), "{line}: {}", errors(&output));
    let made = std::fs::read_dir(folder.join("made")).unwrap().map(|entry| entry.unwrap().path());
    let made = made.into_iter().find(|path| path.extension().is_some_and(|ending| ending == "mcap")).unwrap();
    std::fs::rename(made, folder.join(name)).unwrap();
    std::fs::remove_dir_all(folder.join("made")).unwrap();
}

/// Every command that takes `--json`, with more that it may tell of. That of `rig check` drives a rig: `tests` has it.
const LINES: [&str; 16] = [
    "fit one.mcap --out fitted.toml --report fit.html",
    "fit one.mcap two.mcap",
    "fit one.mcap --into joint.xml --joint knob",
    "diagnose one.mcap --heldout two.mcap --report diagnosis.html",
    "check one.mcap two.mcap",
    "compare one.mcap 3 --report compared.html",
    "sheet slow.mcap --report sheet.html --csv figures.csv",
    "judge slow.mcap --spec spec.toml --report verdicts.html",
    "capability --values values.csv --figure peak_torque --spec spec.toml",
    "gauge --values values.csv --figure peak_torque",
    "list .",
    "recompute felt.mcap",
    "trend table.parquet --report trend.html",
    "rig-test --offline --report rig-test.html",
    "replay 4 --verify --offline --report verified.html",
    "capture --diagnose --budget 2 --offline --rate-hz 5000 --duration-s 6 --report captured.html",
];

#[test]
fn standard_output_is_the_json_alone() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    archive(folder, "capture --knob 3 --duration-s 6", "one.mcap");
    archive(folder, "capture --knob 3 --duration-s 6 --sweep multisine", "two.mcap");
    archive(folder, "capture --knob 3 --duration-s 20 --sweep slow-turn", "slow.mcap");
    archive(folder, "replay 3 --duration-s 2 --hand multisine", "felt.mcap");
    for (name, text) in [
        ("spec.toml", "[figures.peak_torque]\nmin = 1.0\nmax = 9.0\n"),
        ("values.csv", "part,operator,value\n1,1,5.0\n1,1,5.1\n1,2,5.0\n1,2,5.2\n2,1,6.0\n2,1,6.1\n2,2,6.2\n2,2,6.0\n"),
        ("joint.xml", "<mujoco><worldbody><body><joint name=\"knob\"/></body></worldbody></mujoco>"),
    ] {
        std::fs::write(folder.join(name), text).unwrap();
    }
    assert_eq!(run(folder, "table . --out table.parquet").status.code(), Some(0));
    let tested = LINES.map(|line| line.split(' ').next().unwrap());
    let help = String::from_utf8(run(folder, "--help").stdout).unwrap();
    let names = help.lines().filter_map(|line| line.strip_prefix("  ")?.split_whitespace().next());
    for name in names.filter(|name| *name != "help" && !tested.contains(name)) {
        let help = String::from_utf8(run(folder, &format!("{name} --help")).stdout).unwrap();
        assert!(!help.contains("--json"), "`{name}` takes --json and is not tested");
    }
    for line in LINES {
        let output = run(folder, &format!("{line} --json -"));
        let said: Result<Value, _> = serde_json::from_slice(&output.stdout);
        let said = said.unwrap_or_else(|error| {
            panic!("{line}: {error} in\n{}\n{}", String::from_utf8_lossy(&output.stdout), errors(&output))
        });
        assert_eq!(said["made_by"], "haptic-camera", "{line}");
    }
}
