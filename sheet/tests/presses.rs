//! Presses with a contact that closes, opens and bounces where the test says.
#![allow(clippy::unwrap_used, reason = "a test may stop at a failure")]

use archive::testers::Curve;
use shared_types::Axis;
use sheet::Sheet;

const STEP_S: f64 = 1e-4;
const DEPTH_MM: f64 = 3.4;
/// Time of a press, and of a return, s.
const LEG_S: f64 = 2.0;
/// Where each press closes the contact; it opens 0.2 mm higher.
const CLOSING_MM: [f64; 4] = [3.10, 3.08, 3.11, 3.09];
/// How long each closing bounces, s; each opening half as long.
const BOUNCE_S: [f64; 4] = [1.20e-3, 1.32e-3, 1.14e-3, 1.25e-3];

/// Force that collapses at 1.2 mm, with 0.02 N of friction.
fn force_n(travel_mm: f64, direction: f64) -> f64 {
    0.15 * travel_mm
        + 0.3 * (travel_mm * std::f64::consts::PI / 2.4).sin()
        + (travel_mm - 3.3).max(0.0) * 8.0
        + 0.02 * direction
}

/// Whether a contact that changed so long ago, and bounces that long, is where it went: back once, in the last fifth.
fn settled(since_s: f64, bounce_s: f64) -> bool {
    !(0.8 * bounce_s..bounce_s).contains(&since_s)
}

fn curve(presses: std::ops::Range<usize>) -> Curve {
    let speed = DEPTH_MM / LEG_S;
    let mut curve = Curve { axis: Axis::Linear, t_s: Some(Vec::new()), closed: Some(Vec::new()), ..Curve::default() };
    for (count, press) in presses.enumerate() {
        for row in 0..(2.0 * LEG_S / STEP_S).round() as usize {
            let within_s = row as f64 * STEP_S;
            let (travel, direction) =
                if within_s < LEG_S { (speed * within_s, 1.0) } else { (speed * (2.0 * LEG_S - within_s), -1.0) };
            let closing_s = CLOSING_MM[press] / speed;
            let opening_s = 2.0 * LEG_S - (CLOSING_MM[press] - 0.2) / speed;
            let closed = if within_s >= opening_s {
                !settled(within_s - opening_s, 0.5 * BOUNCE_S[press])
            } else {
                within_s >= closing_s && settled(within_s - closing_s, BOUNCE_S[press])
            };
            curve.t_s.as_mut().unwrap().push(count as f64 * 2.0 * LEG_S + within_s);
            curve.position.push(travel);
            // A step of ±1 mN for noise.
            curve.load.push(force_n(travel, direction) + if row % 3 == 0 { 2e-3 } else { -1e-3 });
            curve.closed.as_mut().unwrap().push(closed);
        }
    }
    curve
}

#[test]
fn each_press_of_a_curve_is_read_by_itself_and_their_mean_holds_what_is_true() {
    let sheet = Sheet::of(&[curve(0..4)]).unwrap();
    assert_eq!((sheet.runs, sheet.presses.len()), (4, 4));
    let mean = |values: [f64; 4]| values.iter().sum::<f64>() / 4.0;
    let closing = mean(CLOSING_MM);
    let truths = [
        ("contact_closing_travel", closing),
        ("contact_closing_force", force_n(closing, 1.0)),
        ("contact_opening_travel", closing - 0.2),
        ("contact_opening_force", force_n(closing - 0.2, -1.0)),
        ("contact_hysteresis", 0.2),
        ("contact_closing_bounce", 1e3 * mean(BOUNCE_S)),
        ("contact_opening_bounce", 0.5e3 * mean(BOUNCE_S)),
        ("actuation_travel", closing),
    ];
    for (name, truth) in truths {
        let figure = &sheet.figures[name];
        let [low, high] = figure.ci95.unwrap();
        assert!((low..=high).contains(&truth), "{name}: {truth} is not within {low} to {high}");
        // A bounce is known to the time between two rows.
        let most = if name.ends_with("bounce") { 1e3 * STEP_S } else { 0.03 * truth };
        assert!((figure.value.unwrap() - truth).abs() < most, "{name}: {:?} instead of {truth}", figure.value);
    }
    for (press, closing) in sheet.presses.iter().zip(CLOSING_MM) {
        assert!((press["contact_closing_travel"].value - closing).abs() < 5e-3);
    }
    let by_themselves = Sheet::of(&[0, 1, 2, 3].map(|press| curve(press..press + 1))).unwrap();
    assert!(
        (sheet.figures["collapse_force"].value.unwrap() - by_themselves.figures["collapse_force"].value.unwrap()).abs()
            < 1e-3
    );
}

#[test]
fn bounce_is_told_by_rows_that_are_dense_in_time_only() {
    let whole = curve(0..1);
    let reason = |curve: Curve, name: &str| {
        let sheet = Sheet::of(&[curve]).unwrap();
        assert!((sheet.figures["contact_closing_travel"].value.unwrap() - CLOSING_MM[0]).abs() < 0.01);
        sheet.figures[name].reason.clone().unwrap()
    };
    let untimed = Curve { t_s: None, ..whole.clone() };
    assert!(reason(untimed, "contact_closing_bounce").contains("the file has none"));
    let t_s = whole.t_s.iter().flatten().map(|time_s| 100.0 * time_s).collect();
    assert!(reason(Curve { t_s: Some(t_s), ..whole.clone() }, "contact_opening_bounce").contains("more than 1 ms"));
    let unwatched_rows = whole.len();
    let unwatched = Sheet::of(&[Curve { closed: None, ..whole }]).unwrap();
    assert!(unwatched.figures["contact_hysteresis"].reason.as_ref().unwrap().contains("no contact"));
    let still = Curve { position: vec![1.0; unwatched_rows], ..curve(0..1) };
    assert!(Sheet::of(&[still]).unwrap_err().to_string().contains("almost no press"));
    assert!(unwatched.figures["actuation_travel"].value.unwrap() < 2.0, "without a contact where it collapses");
}

#[test]
fn a_press_that_is_cut_off_does_not_count_beside_whole_ones() {
    let mut cut = curve(0..3);
    let rows = cut.len() * 5 / 6 - 1_000;
    for column in [&mut cut.position, &mut cut.load, cut.t_s.as_mut().unwrap()] {
        column.truncate(rows);
    }
    cut.closed.as_mut().unwrap().truncate(rows);
    let sheet = Sheet::of(&[cut]).unwrap();
    assert_eq!(sheet.runs, 2);
    assert!(sheet.figures["return_force"].value.is_some());
}
