//! The page of a diagnosis: every number of its JSON, one file, and no panic on anything that a diagnosis may lack.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use dynamics::simulate::RigMotor;
use dynamics::{Effect, Model, effects};
use identification::diagnosis::{
    Diagnosis, ForwardFromCommand, Location, NextExperiment, Partial, Rival, Row, Step, Value, Verdict,
};
use report::{CaptureFacts, DiagnosisPage, diagnosis_page};
use serde_json::Value as Json;

/// Rounding of what stands on the page: three significant digits, and two for what these words name.
const ROUNDING: f64 = 0.005;
const TWO_DIGITS: (f64, [&str; 4]) = (0.05, ["explain", "p_value", "steadiness", "probability"]);
/// Numbers below this are reported as being below it.
const SMALLEST: f64 = 1e-6;

fn location(coordinate: &'static str, explained_percent: f64, p_value: f64, significant: bool) -> Location {
    let map =
        (0..24).map(|bin| f64::from(bin) / 4.0 - 3.0).map(|at| [at, explained_percent * 0.1 * at.sin()]).collect();
    Location { coordinate, unit: "rad/s", explained_percent, p_value, significant, map }
}

fn rival(effect: &'static str, rms: f64, evidence: f64, probability: f64, disqualified: Option<&str>) -> Rival {
    Rival { effect, heldout_rms_after: rms, evidence, probability, disqualified: disqualified.map(str::to_owned) }
}

fn rows(after: f64) -> Vec<Row> {
    let row = |index: i32| {
        let t_s = f64::from(index) / 500.0;
        let (angle_rad, velocity_rad_s) = ((TAU * t_s).sin(), TAU * (TAU * t_s).cos());
        Row {
            t_s,
            angle_rad,
            velocity_rad_s,
            torque_mnm: 9.0 * velocity_rad_s.signum() + 3.0 * angle_rad,
            residual_before_mnm: 3.0 * angle_rad + after * (91.0 * t_s).sin(),
            residual_after_mnm: after * (91.0 * t_s).sin(),
        }
    };
    (0..2000).map(row).collect()
}

/// A return spring that was found, with a rival that ties and one that is ruled out.
fn spring() -> Diagnosis {
    let parameters = BTreeMap::from([
        ("spring_stiffness", Value { value: 3.0417, unit: "mNm/rad", ci95: Some([2.913, 3.171]) }),
        ("spring_centre", Value { value: 0.2731, unit: "rad", ci95: None }),
    ]);
    let step = Step {
        detents: Vec::new(),
        effect: "return-spring",
        parameters,
        train_rms_before: 2.412,
        train_rms_after: 0.2215,
        heldout_rms_before: 2.637,
        heldout_rms_after: 0.2318,
        evidence: 4129.0,
        false_discovery_rate: 1e-6,
        steadiness: 12.6,
        placebo_rms: 2.729,
        rivals: vec![
            rival("mass-imbalance", 0.3644, 4127.5, 0.182, None),
            rival("end-stop", 0.8519, 1713.0, 1.7e-9, Some("stop_upper stands on its bound")),
            rival("stribeck", 71.3, -55.1, 0.0, None),
        ],
        ties: vec!["mass-imbalance"],
    };
    Diagnosis {
        characteristics: Vec::new(),
        verdict: Verdict::Effects,
        complete: true,
        effects: vec!["return-spring"],
        refined: std::collections::BTreeMap::new(),
        summary: "Missing: return-spring (or mass-imbalance: a tie).".to_owned(),
        train_rms_before: 2.412,
        train_rms_after: 0.2215,
        heldout_rms_before: 2.637,
        heldout_rms_after: 0.2318,
        noise_floor_rms: 0.2044,
        forward_angle_rms_rad: Some([0.0123, 0.00234]),
        forward_from_command: Some(ForwardFromCommand {
            angle_rms_rad: vec![0.0456, 0.00567],
            window_s: 0.1,
            motor: RigMotor { inertia: 0.016, coulomb_mnm: 3.0, viscous: 0.001 },
        }),
        heldout_relative_error_percent: [14.83, 1.307],
        steps: vec![step],
        partial: vec![Partial { effect: "cogging", explains_percent: 6.71, disqualified: None }],
        locations: vec![
            location("angle", 87.2, 3.3e-5, true),
            location("travel-since-reversal", 33.9, 0.0017, true),
            location("time", 0.0, 0.9133, false),
        ],
        where_after: vec![location("angle", 1.13, 0.211, false), location("time", 0.0, 0.947, false)],
        next_experiment: Some(NextExperiment {
            excitation: "slow-turn".to_owned(),
            amplitude_rad: 5.437,
            tells_apart: ["return-spring".to_owned(), "mass-imbalance".to_owned()],
            difference_rms_mnm: 7.731,
            difference_over_noise: 37.8,
            expected_evidence: 4711.0,
            reason: "there they differ".to_owned(),
        }),
        heldout_is_own: false,
        captures_are_exchanged: false,
        band_hz: 183.0,
        notes: vec!["the knob was warm".to_owned()],
        model: Model {
            name: String::new(),
            description: String::new(),
            effects: vec![
                Effect::new(&effects::inertia::KIND, &[0.0173]),
                Effect::new(&effects::return_spring::KIND, &[3.0417, 0.2731]),
            ],
            ..Model::default()
        },
        chain: Vec::new(),
        rows: [rows(0.2), rows(0.2)],
    }
}

/// The same without anything that may be lacking.
fn empty(verdict: Verdict) -> Diagnosis {
    Diagnosis {
        verdict,
        effects: Vec::new(),
        summary: String::new(),
        steps: Vec::new(),
        partial: Vec::new(),
        locations: Vec::new(),
        where_after: Vec::new(),
        next_experiment: None,
        notes: Vec::new(),
        model: Model { effects: Vec::new(), ..Model::default() },
        forward_from_command: None,
        rows: [Vec::new(), Vec::new()],
        ..spring()
    }
}

fn facts(source: &str, title: &str) -> CaptureFacts {
    CaptureFacts {
        title: title.to_owned(),
        source: source.to_owned(),
        rate_hz: 5000.0,
        duration_s: 6.0,
        samples: 30_000,
        software_version: "0.1.0".to_owned(),
        ..CaptureFacts::default()
    }
}

fn page_of(found: &Diagnosis) -> String {
    let heldout = (!found.heldout_is_own).then(|| facts("heldout.csv", "heldout.csv"));
    diagnosis_page(&DiagnosisPage { found, train: facts("train.csv", "Knob 3"), heldout })
}

/// The page as XML: its only element without an end is `meta`.
fn well_formed(page: &str) -> String {
    let body = page.strip_prefix("<!DOCTYPE html>").unwrap();
    body.split_inclusive('>')
        .map(|piece| if piece.contains("<meta") { piece.replace('>', "/>") } else { piece.to_owned() })
        .collect()
}

fn text_of(page: &str) -> String {
    let xml = well_formed(page);
    let document = roxmltree::Document::parse(&xml).unwrap();
    // Tick labels are no part of what a page tells.
    let is_tick = |node: &roxmltree::Node<'_, '_>| {
        let parent = node.parent_element();
        parent.is_some_and(|parent| parent.has_tag_name("text") && parent.attribute("class") == Some("label"))
            && node.text().is_some_and(|text| text.replace('−', "-").parse::<f64>().is_ok())
    };
    let texts: Vec<&str> = document
        .descendants()
        .filter(|node| node.is_text() && !node.ancestors().any(|parent| parent.has_tag_name("style")))
        .filter(|node| !is_tick(node))
        .filter_map(|node| node.text())
        .collect();
    texts.join(" ")
}

fn figures(page: &str) -> usize {
    let xml = well_formed(page);
    let document = roxmltree::Document::parse(&xml).unwrap();
    document.descendants().filter(|node| node.attribute("class").is_some_and(|class| class.starts_with("plot"))).count()
}

/// Every number in a text, with a true minus sign and powers of ten.
fn numbers_in(text: &str) -> Vec<f64> {
    let plain: String = text
        .replace("\u{a0}×\u{a0}10", "e")
        .chars()
        .map(|letter| match letter {
            '−' | '⁻' => '-',
            _ => "⁰¹²³⁴⁵⁶⁷⁸⁹"
                .chars()
                .position(|digit| digit == letter)
                .map_or(letter, |digit| char::from_digit(u32::try_from(digit).unwrap(), 10).unwrap()),
        })
        .collect();
    plain
        .split(|letter: char| !(letter.is_ascii_digit() || "-.e".contains(letter)))
        .filter_map(|word| word.trim_end_matches(['.', 'e']).parse().ok())
        .collect()
}

/// Every number of a JSON value with the way to it; the bins of maps are in the plots.
fn numbers_of(json: &Json, way: &str, found: &mut Vec<(String, f64)>) {
    match json {
        Json::Number(number) => found.push((way.to_owned(), number.as_f64().unwrap())),
        Json::Array(items) => {
            items.iter().enumerate().for_each(|(index, item)| numbers_of(item, &format!("{way}[{index}]"), found));
        }
        Json::Object(fields) => fields
            .iter()
            .filter(|(name, _)| *name != "map")
            .for_each(|(name, item)| numbers_of(item, &format!("{way}.{name}"), found)),
        _ => {}
    }
}

/// Numbers of the JSON, multiplied by a factor, that are not on the page.
fn missing(found: &Diagnosis, factor: f64) -> Vec<String> {
    let shown = numbers_in(&text_of(&page_of(found)));
    let mut numbers = Vec::new();
    numbers_of(&serde_json::to_value(found).unwrap(), "", &mut numbers);
    assert!(numbers.len() > 30, "the JSON has {} numbers", numbers.len());
    let is_shown = |way: &str, value: f64| {
        let rounding = if TWO_DIGITS.1.iter().any(|word| way.contains(word)) { TWO_DIGITS.0 } else { ROUNDING };
        shown.iter().any(|on_page| (on_page - value).abs() <= rounding * value.abs())
    };
    numbers
        .into_iter()
        .filter(|(_, value)| value.abs() == 0.0 || value.abs() >= SMALLEST)
        .filter(|(way, value)| !is_shown(way, factor * value))
        .map(|(way, value)| format!("{way} = {value}"))
        .collect()
}

#[test]
fn every_number_of_the_json_is_on_the_page() {
    let missing = missing(&spring(), 1.0);
    assert!(missing.is_empty(), "not on the page: {missing:?}");
}

#[test]
fn numbers_of_another_diagnosis_are_not_on_the_page() {
    let missing = missing(&spring(), 1.17);
    assert!(missing.len() > 20, "only {missing:?}");
}

#[test]
fn verdict_ties_reasons_units_and_the_law_are_stated_in_words() {
    let text = text_of(&page_of(&spring()));
    for words in [
        "Missing: return-spring (or mass-imbalance: a tie).",
        "A tie.",
        "stop_upper stands on its bound",
        "mNm/rad",
        effects::return_spring::KIND.source,
        "travel since reversal",
        "--sweep slow-turn",
        "The knob was warm",
        "heldout.csv",
        "null effect",
    ] {
        assert!(text.contains(words), "{words} is missing");
    }
}

#[test]
fn the_maps_come_before_the_first_step() {
    let page = page_of(&spring());
    let place = |words: &str| page.find(words).unwrap();
    let order = [
        "The gap",
        "Where the first model",
        "Step 1: return-spring",
        "The way down",
        "What is left",
        "What to capture next",
    ];
    let places = order.map(place);
    assert!(places.is_sorted(), "{places:?}");
}

#[test]
fn a_page_of_an_effect_has_all_its_plots() {
    // Residual, two maps, the effect alone, rivals, stairs, two maps before and after less the one that has no after,
    // torque against angle and velocity.
    assert_eq!(figures(&page_of(&spring())), 9);
}

#[test]
fn a_shape_outside_the_catalogue_is_drawn_and_described() {
    let found = Diagnosis {
        verdict: Verdict::OutsideLibrary,
        effects: Vec::new(),
        where_after: vec![location("velocity", 61.4, 2.1e-4, true)],
        partial: vec![Partial { effect: "return-spring", explains_percent: 41.9, disqualified: None }],
        ..spring()
    };
    let text = text_of(&page_of(&found));
    for words in [
        "This is its shape",
        "Highest",
        "explain part of the residual, but cannot be what is missing",
        "explains  42  %",
    ] {
        let squeezed = |words: &str| words.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(squeezed(&text).contains(&squeezed(words)), "{words} is missing");
    }
}

#[test]
fn a_diagnosis_without_steps_rows_maps_or_effects_still_makes_a_page() {
    for verdict in [Verdict::None, Verdict::Effects, Verdict::OutsideLibrary] {
        for heldout_is_own in [false, true] {
            let page = page_of(&Diagnosis { heldout_is_own, ..empty(verdict) });
            assert!(text_of(&page).contains("Too few rows"));
            assert_eq!(figures(&page), 0);
        }
    }
}

#[test]
fn a_step_without_rivals_or_parameters_and_maps_without_bins_still_make_a_page() {
    let mut found = spring();
    found.steps[0].rivals.clear();
    found.steps[0].ties.clear();
    found.steps[0].parameters.clear();
    found.steps[0].effect = "no-such-effect";
    found.locations[0].map.clear();
    found.where_after.clear();
    let text = text_of(&page_of(&found));
    assert!(text.contains("No rival could take its place") && text.contains("no-such-effect"));
}

#[test]
fn values_that_are_not_numbers_are_left_out() {
    let mut found = spring();
    found.noise_floor_rms = f64::NAN;
    found.heldout_rms_after = f64::NAN;
    found.steps[0].placebo_rms = f64::NAN;
    found.steps[0].heldout_rms_before = f64::NAN;
    found.locations[0].explained_percent = f64::NAN;
    found.rows[1][7].residual_after_mnm = f64::NAN;
    found.steps[0].rivals[0].heldout_rms_after = f64::INFINITY;
    found.steps[0].rivals[1].probability = f64::NAN;
    found.locations[0].map[3] = [f64::NAN, f64::INFINITY];
    let page = page_of(&found);
    assert!(!page.contains("NaN"));
    assert!(!text_of(&page).split(|letter: char| !letter.is_alphanumeric()).any(|word| word == "inf"));
}

#[test]
fn the_page_fetches_nothing_and_shows_markup_as_text() {
    let title = "<script>alert('5 < 6')</script>";
    let found = Diagnosis { summary: title.to_owned(), ..spring() };
    let page = page_of(&found);
    assert!(text_of(&page).contains(title));
    let page = page.replace("xmlns=\"http://www.w3.org/2000/svg\"", "");
    for fetching in ["http", "src=", "href=", "url(", "@import", "<script"] {
        assert!(!page.contains(fetching), "the page has {fetching}");
    }
}
