//! Report pages beside the JSON of the same commands, and the comparison of several knobs.

use std::path::Path;

use crate::pages::{compared, not_in_json};
use crate::program::{done, json, only, refused};
use serde_json::Value;

/// Columns of a terminal.
const TERMINAL: usize = 80;

/// An archive of a shipped knob on the simulated rig.
fn captured(folder: &Path, name: &str, options: &str) -> String {
    done(folder, &format!("capture --offline --duration-s 4 --rate-hz 5000 --out {name} {options}"));
    let archive = only(&folder.join(name), "mcap");
    format!("{name}/{}", archive.file_name().unwrap().to_str().unwrap())
}

/// What a command writes as `page.html` and `page.json`.
fn written(folder: &Path, command: &str) -> (String, Value) {
    done(folder, &format!("{command} --json page.json --report page.html"));
    (std::fs::read_to_string(folder.join("page.html")).unwrap(), json(&folder.join("page.json")))
}

fn same(command: &str, (page, json): &(String, Value), fewest: usize) {
    let missing = not_in_json(page, json);
    assert!(missing.is_empty(), "{command}: on the page and not in the JSON: {missing:#?}");
    assert!(compared(page) >= fewest, "{command}: only {} numbers were compared", compared(page));
    let fetches = ["<script", "<link", "<img", "url(", "@import"].map(|tag| page.contains(tag));
    assert!(!fetches.contains(&true), "{command}: the page is not self-contained");
}

#[test]
fn every_number_on_a_page_is_in_the_json_of_the_same_command() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let one = captured(folder, "one", "--knob 3 --seed 1");
    let two = captured(folder, "two", "--knob 3 --seed 2");
    let other = captured(folder, "other", "--knob 3 --sweep multisine --seed 3");
    for (command, fewest) in [
        (format!("fit {one}"), 60),
        (format!("fit {one} {two}"), 120),
        (format!("compare {one} {two} 5"), 100),
        (format!("diagnose {one} --heldout {other}"), 60),
        // Four channels with five and four numbers each, four runs with four.
        ("rig-test --offline".to_owned(), 52),
    ] {
        same(&command, &written(folder, &command), fewest);
    }
}

#[test]
fn a_number_that_is_not_in_the_json_is_seen() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let capture = captured(folder, "one", "--knob 4");
    let (page, json) = written(folder, &format!("fit {capture}"));
    let value = json["parameters"]["inertia"]["value"].as_f64().unwrap();
    // As many decimals as its interval warrants.
    let cells = (2..=6).map(|decimals| format!("<td class=\"number value\">{value:.decimals$}</td>"));
    let shown = cells.into_iter().find(|cell| page.contains(cell)).unwrap();
    // Another parameter's number is no number of this row.
    let other = json["parameters"]["viscous_positive"]["value"].as_f64().unwrap();
    for wrong in [1.5 * value, other] {
        let changed = page.replace(&shown, &format!("<td class=\"number value\">{wrong:.4}</td>"));
        assert_eq!(not_in_json(&changed, &json).len(), 1, "{wrong}: {:?}", not_in_json(&changed, &json));
    }
}

#[test]
fn captures_of_one_knob_share_a_column_beside_what_the_paper_prints() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let captures = [
        captured(folder, "first", "--knob 4 --seed 1"),
        captured(folder, "between", "--knob 2 --seed 2"),
        captured(folder, "again", "--knob 4 --seed 3"),
    ];
    std::fs::copy(folder.join(&captures[1]).with_extension("toml"), folder.join("fitted.toml")).unwrap();
    let command = format!("compare {} fitted.toml 5", captures.join(" "));
    let said = done(folder, &command);
    let widest = said.lines().map(|line| line.chars().count()).max().unwrap();
    assert!(widest <= TERMINAL, "{widest} columns:\n{said}");
    let (page, json) = written(folder, &command);
    let knobs = json["knobs"].as_array().unwrap();
    let names: Vec<&str> = knobs.iter().map(|knob| knob["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["Knob 4", "Knob 2", "fitted, model", "Knob 5, model"]);
    // Table 5: A of knob 4 is printed with the other sign.
    let amplitude = &knobs[0]["paper"]["parameters"]["detent_amplitude"];
    assert_eq!((&amplitude["value"], &amplitude["printed"]), (&Value::from(11.0), &Value::from(-11.0)));
    let fitted = knobs[0]["parameters"]["detent_amplitude"]["value"].as_f64().unwrap();
    assert!((fitted - 11.0).abs() < 0.1, "{fitted}");
    assert_eq!(knobs[0]["captures"].as_array().unwrap().len(), 2);
    assert!(knobs[0]["repeatability"]["inertia"]["ratio"].is_number());
    assert!(knobs[2].get("paper").is_none(), "a fitted model is not the paper's");
    assert_eq!(knobs[3]["paper"]["number"], 5);
    for words in
        ["Moderate detents; moderate friction; low inertia", "paper 11 (−11)", "Birge ratio", "Knob 4: its captures"]
    {
        assert!(page.contains(words), "{words} is not on the page");
    }
}

#[test]
fn what_cannot_be_compared_gets_one_sentence() {
    let folder = tempfile::tempdir().unwrap();
    for subject in ["6", "missing.mcap", "missing.toml"] {
        refused(folder.path(), &format!("compare {subject}"));
    }
}
