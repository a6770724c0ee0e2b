//! The report page, from simulated captures whose truth is known.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use dynamics::{Drive, Effect, Excitation, Model, Motion, effects, knobs};
use identification::{Fit, FitOptions, Samples, average, fit};
use report::{AveragePage, CaptureFacts, FitPage, average_page, fit_page};

const RATE_HZ: f64 = 5000.0;
/// Step of the torque sensor, mNm; it makes the residual.
const TORQUE_STEP_MNM: f64 = 0.18;

/// A fit of `knob` swept for `seconds`, in one direction only if `one_way`.
fn fitted(knob: &Model, seconds: f64, one_way: bool) -> Fit {
    let sweep = Excitation::named("linear-chirp", Drive::Position).unwrap();
    let mut columns: [Vec<f64>; 5] = Default::default();
    let mut time_s = 0.0;
    while time_s < seconds {
        let setpoint = sweep.at(time_s);
        let motion = Motion {
            time_s,
            angle_rad: setpoint.value + if one_way { 60.0 * time_s } else { 0.0 },
            velocity_rad_s: setpoint.rate + if one_way { 60.0 } else { 0.0 },
            acceleration_rad_s2: setpoint.acceleration,
        };
        if !one_way || motion.velocity_rad_s > 0.0 {
            let torque_mnm = (knob.torque_mnm(&motion) / TORQUE_STEP_MNM).round() * TORQUE_STEP_MNM;
            let row = [time_s, motion.angle_rad, motion.velocity_rad_s, motion.acceleration_rad_s2, torque_mnm];
            columns.iter_mut().zip(row).for_each(|(column, value)| column.push(value));
        }
        time_s += 1.0 / RATE_HZ;
    }
    let [t_s, angle_rad, velocity_rad_s, acceleration_rad_s2, torque_mnm] = &columns;
    let samples = Samples {
        t_s,
        angle_rad,
        velocity_rad_s: Some(velocity_rad_s),
        acceleration_rad_s2: Some(acceleration_rad_s2),
        torque_mnm,
    };
    fit(&samples, &FitOptions::default()).unwrap()
}

fn page_of(fit: &Fit, title: &str, truth: Option<&Model>) -> String {
    fit_page(&FitPage { fit, capture: facts(fit, title), truth })
}

fn facts(fit: &Fit, title: &str) -> CaptureFacts {
    CaptureFacts {
        title: title.to_owned(),
        source: "knob-3.mcap".to_owned(),
        knob: "knob 3".to_owned(),
        rig: "simulated rig".to_owned(),
        captured_at: "2026-03-04 12:34:56 UTC".to_owned(),
        rate_hz: RATE_HZ,
        duration_s: 6.0,
        samples: fit.samples as u64,
        missed_ticks: Some(0),
        gaps: Some(0),
        real_time: Some(true),
        software_version: "0.1.0".to_owned(),
    }
}

fn mean_page(fits: &[Fit], truth: Option<&Model>) -> String {
    let captures = fits.iter().map(|fit| facts(fit, "Knob 3")).collect();
    average_page(&AveragePage { average: &average(fits).unwrap(), fits, captures, truth })
}

/// The page as XML: its only element without an end is `meta`.
fn well_formed(page: &str) -> String {
    let body = page.strip_prefix("<!DOCTYPE html>").unwrap();
    body.split_inclusive('>')
        .map(|piece| match piece.find("<meta") {
            Some(_) => piece.replace('>', "/>"),
            None => piece.to_owned(),
        })
        .collect()
}

/// Text of the page without markup and style.
fn text_of(page: &str) -> String {
    let xml = well_formed(page);
    let document = roxmltree::Document::parse(&xml).unwrap();
    document
        .descendants()
        .filter(|node| node.is_text() && !node.ancestors().any(|parent| parent.has_tag_name("style")))
        .filter_map(|node| node.text())
        .collect::<Vec<_>>()
        .join("\n")
}

#[test]
fn the_page_is_well_formed_and_has_every_plot() {
    let knob = knobs::paper_knob(3).unwrap();
    let page = page_of(&fitted(&knob, 6.0, false), "Knob 3", Some(&knob));
    let xml = well_formed(&page);
    let document = roxmltree::Document::parse(&xml).unwrap();
    let figures = document.descendants().filter(|node| node.has_tag_name("figure"));
    let plots = figures.filter(|figure| figure.descendants().any(|node| node.attribute("class") == Some("plot")));
    // Angle, velocity; inertia, friction, detent; excerpt, residual, histogram, orders.
    assert_eq!(plots.count(), 9);
}

#[test]
fn every_parameter_and_every_fact_is_on_the_page() {
    let knob = knobs::paper_knob(3).unwrap();
    let fit = fitted(&knob, 6.0, false);
    let text = text_of(&page_of(&fit, "Knob 3", Some(&knob)));
    for parameter in &fit.parameters.0 {
        assert!(text.contains(parameter.name), "{} is missing", parameter.name);
    }
    for fact in ["Knob 3", "knob-3.mcap", "simulated rig", "2026-03-04 12:34:56 UTC", "30\u{202f}000", "missed ticks"] {
        assert!(text.contains(fact), "{fact} is missing");
    }
}

#[test]
fn a_true_value_outside_its_interval_is_called_outside() {
    let knob = knobs::paper_knob(3).unwrap();
    let fit = fitted(&knob, 6.0, false);
    let mut heavier = knob.clone();
    let inertia = heavier.effects.iter_mut().find(|effect| effect.kind().name == "inertia").unwrap();
    inertia.values_mut()[0] *= 2.0;
    let outside = |page: &str| page.matches("class=\"outside\"").count();
    let [right, wrong] = [&knob, &heavier].map(|truth| outside(&page_of(&fit, "Knob 3", Some(truth))));
    assert_eq!(wrong, right + 1);
}

#[test]
fn detents_written_with_a_negative_amplitude_are_the_same_detents() {
    let knob = knobs::paper_knob(3).unwrap();
    let mut mirrored = knob.clone();
    for effect in &mut mirrored.effects {
        if let [amplitude, period, phase] = *effect.values()
            && effect.kind().name == "detent"
        {
            *effect = Effect::new(&effects::detent::KIND, &[-amplitude, period, phase + 5.0 * std::f64::consts::PI]);
        }
    }
    let fit = fitted(&knob, 6.0, false);
    let inside = |truth: &Model| page_of(&fit, "Knob 3", Some(truth)).matches("class=\"inside\"").count();
    assert_eq!(inside(&mirrored), inside(&knob));
}

#[test]
fn a_title_with_markup_is_shown_as_text() {
    let fit = fitted(&knobs::paper_knob(3).unwrap(), 6.0, false);
    let title = "<script>alert('5 < 6 & \"7\"')</script>";
    let page = page_of(&fit, title, None);
    assert!(!page.contains("<script"));
    assert!(text_of(&page).contains(title));
}

#[test]
fn the_page_fetches_nothing() {
    let fit = fitted(&knobs::paper_knob(3).unwrap(), 6.0, false);
    let page = page_of(&fit, "Knob 3", None).replace("xmlns=\"http://www.w3.org/2000/svg\"", "");
    for fetching in ["http", "src=", "href=", "url(", "@import", "<script"] {
        assert!(!page.contains(fetching), "the page has {fetching}");
    }
}

#[test]
fn values_that_are_not_numbers_are_left_out() {
    let mut fit = fitted(&knobs::paper_knob(3).unwrap(), 6.0, false);
    fit.points[7].torque_model_mnm = f64::NAN;
    fit.points[8].angle_rad = f64::INFINITY;
    fit.mean_ci95_mnm = f64::NAN;
    fit.residual_rms_mnm = f64::NAN;
    fit.parameters.0[0].ci95 = Some([f64::NAN, f64::INFINITY]);
    let page = page_of(&fit, "Knob 3", None);
    let text = text_of(&page);
    assert!(!page.contains("NaN"));
    assert!(!text.split(|letter: char| !letter.is_alphanumeric()).any(|word| word == "inf"));
}

#[test]
fn a_direction_that_was_never_turned_has_its_reason_on_the_page() {
    let fit = fitted(&knobs::paper_knob(3).unwrap(), 6.0, true);
    let reason = fit.parameters.get("coulomb_negative").unwrap().reason.clone().unwrap();
    let text = text_of(&page_of(&fit, "Knob 3", None));
    assert!(text.contains("not identifiable") && text.contains(&reason));
}

#[test]
fn without_rows_the_page_says_so() {
    let mut fit = fitted(&knobs::paper_knob(3).unwrap(), 6.0, false);
    fit.points.clear();
    assert!(text_of(&page_of(&fit, "Knob 3", None)).contains("Too few rows"));
}

#[test]
fn a_hundred_thousand_rows_stay_below_a_megabyte_and_a_half() {
    let mut fit = fitted(&knobs::paper_knob(3).unwrap(), 6.0, false);
    let rows = fit.points.clone();
    let last_s = rows.last().unwrap().t_s;
    let mut turn = 0.0;
    while fit.points.len() < 100_000 {
        turn += 1.0;
        // Irrational shifts, so that no two dots coincide.
        fit.points.extend(rows.iter().map(|point| {
            let mut point = *point;
            point.t_s += turn * last_s;
            point.angle_rad += 0.001 * f64::sin(turn);
            point.torque_mnm += 0.01 * f64::cos(turn);
            point
        }));
    }
    let page = page_of(&fit, "Knob 3", None);
    assert!(page.len() < 1_500_000, "the page has {} bytes", page.len());
}

#[test]
fn a_capture_without_noise_and_a_residual_of_zero_still_make_a_page() {
    let mut fit = fitted(&knobs::paper_knob(3).unwrap(), 6.0, false);
    fit.points.iter_mut().for_each(|point| {
        point.residual_mnm = 0.0;
        point.torque_mnm = 3.0;
        point.torque_model_mnm = 3.0;
    });
    fit.residual_rms_mnm = 0.0;
    fit.preparation.torque_noise_mnm = 0.0;
    let page = page_of(&fit, "Knob 3", None);
    assert!(!page.contains("NaN") && roxmltree::Document::parse(&well_formed(&page)).is_ok());
}

#[test]
fn the_page_of_a_mean_has_a_forest_for_each_parameter_and_the_torques_of_each_capture() {
    let knob = knobs::paper_knob(3).unwrap();
    let fits = [fitted(&knob, 6.0, false), fitted(&knob, 5.0, false), fitted(&knob, 4.0, false)];
    let page = mean_page(&fits, Some(&knob));
    let xml = well_formed(&page);
    let document = roxmltree::Document::parse(&xml).unwrap();
    let plots = |within: &str| {
        let class = |node: &roxmltree::Node<'_, '_>| node.attribute("class") == Some(within);
        document
            .descendants()
            .filter(|node| node.attribute("class") == Some("plot") && node.ancestors().any(|parent| class(&parent)))
            .count()
    };
    let estimated = fits[0].parameters.0.iter().filter(|parameter| parameter.value.is_some()).count();
    assert_eq!(plots("forest"), estimated);
    let all = document.descendants().filter(|node| node.attribute("class") == Some("plot")).count();
    assert_eq!(all, estimated + 2 * fits.len(), "two torque plots of each capture");
    let text = text_of(&page);
    for expected in ["Mean of 3 captures", "degrees of freedom", "capture 3", "Birge ratio", "true value"] {
        assert!(text.contains(expected), "{expected} is missing");
    }
    assert!(!page.contains("NaN") && !page.contains("<script") && !page.contains("http-equiv"));
}

#[test]
fn a_mean_of_many_captures_leaves_single_values_to_the_plots_and_names_a_knob_that_they_share() {
    let knob = knobs::paper_knob(3).unwrap();
    let fits: Vec<Fit> = (0..6).map(|index| fitted(&knob, 4.0 + 0.3 * f64::from(index), false)).collect();
    let text = text_of(&mean_page(&fits, None));
    assert!(text.contains("Single captures are in the figure below"));
    assert!(text.contains("knob 3, 6 captures") && !text.contains("true value"));
}
