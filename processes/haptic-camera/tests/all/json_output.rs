//! `--json -`: standard output is one JSON document, whatever else the command has to say.

use std::path::Path;

use crate::program::{call, done, only, words};
use serde_json::Value;

/// Makes an archive of that name.
fn archive(folder: &Path, line: &str, name: &str) {
    done(folder, &format!("{line} --offline --rate-hz 5000 --out made"));
    std::fs::rename(only(&folder.join("made"), "mcap"), folder.join(name)).unwrap();
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
    done(folder, "table . --out table.parquet");
    let tested = LINES.map(|line| line.split(' ').next().unwrap());
    let help = done(folder, "--help");
    let names = help.lines().filter_map(|line| line.strip_prefix("  ")?.split_whitespace().next());
    for name in names.filter(|name| *name != "help" && !tested.contains(name)) {
        let help = words(&call(folder, &format!("{name} --help")));
        assert!(!help.contains("--json"), "`{name}` takes --json and is not tested");
    }
    for line in LINES {
        let output = call(folder, &format!("{line} --json -"));
        let said: Result<Value, _> = serde_json::from_slice(&output.stdout);
        let said = said.unwrap_or_else(|error| panic!("{line}: {error} in\n{}", words(&output)));
        assert_eq!(said["made_by"], "haptic-camera", "{line}");
    }
}
