//! The page of a rendering: every number that it is given, one file, and no panic on anything that it may lack.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::f64::consts::TAU;

use dynamics::{Model, knobs};
use identification::diagnosis::Verdict;
use identification::{Fit, FitOptions, Samples, fit};
use report::{
    AddedByRendering, CaptureFacts, HeldStill, RenderedParameter, Rendering, RenderingLimits, RenderingPage,
    rendering_page,
};

/// Four seconds of knob 3 swept by formula, and its fit.
fn fitted(model: &Model) -> Fit {
    let time_s: Vec<f64> = (0..20_000).map(|index| f64::from(index) / 5_000.0).collect();
    let motion = |t_s: f64| {
        let w = TAU * 1.5;
        dynamics::Motion {
            time_s: t_s,
            angle_rad: 0.7 * (w * t_s).sin(),
            velocity_rad_s: 0.7 * w * (w * t_s).cos(),
            acceleration_rad_s2: -0.7 * w * w * (w * t_s).sin(),
        }
    };
    let columns: Vec<[f64; 2]> =
        time_s.iter().map(|t_s| [motion(*t_s).angle_rad, model.torque_mnm(&motion(*t_s))]).collect();
    let [angle_rad, torque_mnm] = [0, 1].map(|index| columns.iter().map(|row| row[index]).collect::<Vec<f64>>());
    let samples = Samples {
        t_s: &time_s,
        angle_rad: &angle_rad,
        velocity_rad_s: None,
        acceleration_rad_s2: None,
        torque_mnm: &torque_mnm,
    };
    fit(&samples, &FitOptions::default()).unwrap()
}

fn parameter(name: &'static str, intended: f64, rendered: Option<f64>, passed: Option<bool>) -> RenderedParameter {
    RenderedParameter {
        name,
        unit: "mNm",
        intended,
        rendered,
        ci95: rendered.map(|value| [value - 0.0123, value + 0.0123]),
        difference_percent: rendered.map(|value| 100.0 * (value / intended - 1.0)),
        passed,
        reason: rendered.is_none().then(|| "the knob did not break away".to_owned()),
    }
}

fn page<'a>(model: &'a Model, fit: &'a Fit) -> RenderingPage<'a> {
    let rendering = Rendering {
        model: model.name.clone(),
        capture: CaptureFacts {
            source: "sweep.mcap".to_owned(),
            software_version: "0.1.0".to_owned(),
            ..CaptureFacts::default()
        },
        captures: vec!["run/sweep.mcap".into(), "run/creep.mcap".into()],
        rate_hz: 9_500.0,
        parameters: vec![
            parameter("coulomb_positive", 2.3, Some(2.307), Some(true)),
            parameter("coulomb_negative", 2.6, Some(2.9), Some(false)),
            parameter("static_positive", 10.37, None, None),
        ],
        limits: RenderingLimits { difference_percent: 2.1, static_difference_percent: 5.3, torque_error_percent: 5.7 },
        torque_error_rms_mnm: 0.0517,
        torque_rms_mnm: 2.741,
        torque_error_percent: 1.886,
        lost_motion: None,
        held_still: Some(HeldStill { torque_mnm: 5.13, duration_s: 9.47, encoder_steps: 0.0 }),
        added: Some(AddedByRendering {
            verdict: Verdict::Effects,
            effects: vec!["shaft-compliance".to_owned(), "stribeck".to_owned()],
            heldout_rms_before: 0.2519,
            heldout_rms_after: 0.0913,
            noise_floor_rms: 0.0671,
        }),
        notes: vec!["the knob was warm".to_owned()],
        passed: false,
    };
    RenderingPage { intended: model, fit, rendering }
}

/// The page's text, its style and tick labels apart.
fn text_of(page: &str) -> String {
    let body = page.strip_prefix("<!DOCTYPE html>").unwrap();
    let xml: String = body
        .split_inclusive('>')
        .map(|piece| if piece.contains("<meta") { piece.replace('>', "/>") } else { piece.to_owned() })
        .collect();
    let document = roxmltree::Document::parse(&xml).unwrap();
    let nodes = document
        .descendants()
        .filter(|node| node.is_text())
        .filter(|node| !node.ancestors().any(|parent| parent.has_tag_name("style") || parent.has_tag_name("svg")));
    nodes.filter_map(|node| node.text()).collect::<Vec<_>>().join(" ").replace('−', "-")
}

#[test]
fn every_number_that_it_is_given_is_on_the_page() {
    let model = knobs::paper_knob(3).unwrap();
    let fit = fitted(&model);
    let text = text_of(&rendering_page(&page(&model, &fit)));
    for words in [
        "Knob 3",
        "differs from the model in coulomb_negative.",
        "2.307",
        "2.295 … 2.319",
        "0.30",
        "too far",
        "in its interval",
        "2.900",
        "11.54",
        "10.4",
        "the knob did not break away",
        "0.0517",
        "2.74",
        "1.89",
        "5.70",
        "9500",
        "5.13",
        "9.47",
        "shaft-compliance",
        "stribeck",
        "0.252",
        "0.0913",
        "0.0671",
        "2.10",
        "5.30",
        "The knob was warm",
        "sweep.mcap, creep.mcap",
    ] {
        assert!(text.contains(words), "{words} is missing in {text}");
    }
}

#[test]
fn what_is_lacking_is_stated_in_words_and_a_rendering_that_passes_says_so() {
    let model = knobs::paper_knob(3).unwrap();
    let fit = fitted(&model);
    let whole = page(&model, &fit);
    assert_eq!(rendering_page(&whole).matches("<svg class=\"plot\"").count(), 3);
    let mut pointless = fit.clone();
    pointless.points.clear();
    for verdict in [Verdict::None, Verdict::OutsideLibrary] {
        let added = whole.rendering.added.clone();
        let added = added.map(|added| AddedByRendering { verdict, effects: Vec::new(), ..added });
        let rendering = Rendering { added, passed: true, ..whole.rendering.clone() };
        let text = text_of(&rendering_page(&RenderingPage { rendering, ..whole }));
        let expected = if verdict == Verdict::None { "Nothing" } else { "Something without a name." };
        assert!(text.contains(expected) && text.contains("The rendered knob is the model’s."), "{text}");
    }
    let lacking = Rendering {
        parameters: Vec::new(),
        held_still: None,
        added: None,
        notes: Vec::new(),
        torque_error_percent: f64::NAN,
        ..whole.rendering
    };
    let page = rendering_page(&RenderingPage { intended: &model, fit: &pointless, rendering: lacking });
    let text = text_of(&page);
    for words in ["Too few rows", "bears no torque at rest", "could not tell"] {
        assert!(text.contains(words), "{words} is missing in {text}");
    }
    assert!(!page.contains("NaN"));
}

#[test]
fn the_page_fetches_nothing_and_shows_markup_as_text() {
    let title = "<script>alert('5 < 6')</script>";
    let model = Model { name: title.to_owned(), ..knobs::paper_knob(3).unwrap() };
    let fit = fitted(&model);
    let page = rendering_page(&page(&model, &fit));
    assert!(text_of(&page).contains(title));
    let page = page.replace("xmlns=\"http://www.w3.org/2000/svg\"", "");
    for fetching in ["http", "src=", "href=", "url(", "@import", "<script"] {
        assert!(!page.contains(fetching), "the page has {fetching}");
    }
}
