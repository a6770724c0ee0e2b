//! Sweeps that end once enough is known, on the simulated rig offline.

use std::path::Path;
use std::process::Output;

use crate::program::{call, errors, json, only};
use dynamics::effects::detent::canonical;
use serde_json::Value;

const PLANNED_S: f64 = 20.0;
const JUDGED: [&str; 8] = [
    "inertia",
    "coulomb_negative",
    "coulomb_positive",
    "viscous_negative",
    "viscous_positive",
    "detent_amplitude",
    "detent_period",
    "detent_phase",
];

fn capture(folder: &Path, arguments: &str) -> Output {
    call(folder, &format!("capture --offline --out out {arguments}"))
}

/// Half widths as shares of their values, of a phase as such, and whether each interval holds the truth.
fn judged(knob: u32, fit: &Value) -> Vec<(&'static str, f64, bool)> {
    let model = dynamics::knobs::paper_knob(knob).unwrap();
    let true_value = |name: &str| match name {
        "detent_amplitude" => model.parameter(name).map(f64::abs),
        "detent_phase" => {
            let amplitude = model.parameter("detent_amplitude")?;
            Some(canonical(amplitude, model.parameter(name)?).1)
        }
        _ => model.parameter(name),
    };
    let judge = |name: &'static str| {
        let (low, high) = (fit["parameters"][name]["ci95"][0].as_f64()?, fit["parameters"][name]["ci95"][1].as_f64()?);
        let truth = true_value(name)?;
        let scale = if name == "detent_phase" { 1.0 } else { truth.abs() };
        Some((name, 0.5 * (high - low) / scale, (low..=high).contains(&truth)))
    };
    JUDGED.into_iter().filter_map(judge).collect()
}

#[test]
fn a_sweep_ends_early_and_the_archive_s_own_fit_knows_what_was_asked_for() {
    let mut held = Vec::new();
    for (knob, seed, parameters) in [(1, 1, 5), (2, 1, 5), (3, 1, 8), (3, 2, 8), (4, 1, 8), (4, 2, 8)] {
        let folder = tempfile::tempdir().unwrap();
        let amplitude = 0.97 + 0.01 * f64::from(knob + seed);
        let asked =
            format!("--knob {knob} --seed {seed} --amplitude {amplitude} --duration-s {PLANNED_S} --until-ci 3%");
        let output = capture(folder.path(), &asked);
        let said = String::from_utf8_lossy(&output.stdout).into_owned();
        assert_eq!(output.status.code(), Some(0), "{said}{}", errors(&output));
        assert!(said.contains("known within 3 % after") && said.contains("s saved"), "{said}");
        let archive = archive::Overview::read(&only(&folder.path().join("out"), "mcap")).unwrap();
        assert!(archive.duration_s < 0.7 * PLANNED_S, "it took {} s", archive.duration_s);
        assert_eq!((archive.lost_samples, archive.fault), (0, false));
        let fit = json(&only(&folder.path().join("out"), "json"));
        let judged = judged(knob, &fit);
        assert_eq!(judged.len(), parameters, "{judged:?}");
        for (name, share, _) in &judged {
            assert!(*share <= 0.03, "knob {knob}: {name} is known within {share}");
        }
        held.extend(judged.iter().map(|(.., held)| *held));
    }
    // Of 42 intervals of 95 % at most 6 miss, but for once in a hundred times; the study counts more of them.
    let missed = held.iter().filter(|held| !**held).count();
    assert!(missed <= 6, "{missed} of {} intervals miss the truth", held.len());
}

#[test]
fn a_sweep_that_comes_to_its_end_first_says_what_is_not_known() {
    let folder = tempfile::tempdir().unwrap();
    let output = capture(folder.path(), "--knob 3 --duration-s 4 --until-ci 0.1%");
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert_eq!(output.status.code(), Some(0), "{said}");
    assert!(said.contains("not known within 0.1 % by the end: ") && said.contains("viscous_negative ±"), "{said}");
    let samples = archive::Overview::read(&only(&folder.path().join("out"), "mcap")).unwrap().samples;
    assert_eq!(samples, 40_000);
}

#[test]
fn a_share_is_printed_as_it_was_given() {
    let folder = tempfile::tempdir().unwrap();
    for (given, printed) in [("7%", "7 %"), ("1e-4%", "0.0001 %"), ("33.3333%", "33.3333 %")] {
        let output = capture(folder.path(), &format!("--knob 3 --duration-s 0.5 --until-ci {given}"));
        let said = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(said.contains(&format!("until ± {printed}, at most 0.5 s")), "{given}: {said}");
    }
}

#[test]
fn a_share_that_is_none_is_wrong_usage_with_what_to_give_instead() {
    let folder = tempfile::tempdir().unwrap();
    for wrong in ["0", "0%", "abc", "200%", "-1%", "1"] {
        let output = capture(folder.path(), &format!("--until-ci {wrong}"));
        let said = errors(&output);
        assert_eq!(output.status.code(), Some(2), "{wrong}: {said}");
        assert!(said.contains("as in 1% or 0.5%") && said.contains(wrong), "{wrong}: {said}");
        assert!(!folder.path().join("out").exists(), "nothing is begun");
    }
}
