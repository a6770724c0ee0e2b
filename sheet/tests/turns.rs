//! Slow turns made by a plain equation: what is in them comes back, with intervals that hold it.
#![allow(clippy::unwrap_used, reason = "a test may stop at a failure")]

use std::f64::consts::TAU;

use archive::testers::Curve;
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{RngCore as _, SeedableRng as _};
use shared_types::Axis;
use sheet::{CurveError, Detent, DetentFigure, Sheet, SheetError, Specification, Verdict};

/// Friction turning positively and negatively, mNm.
const FRICTION_MNM: [f64; 2] = [3.0, 2.0];
const NOISE_MNM: f64 = 0.2;

/// Sines of unequal width and height: where each begins, and its height.
///
/// Where neighbours differ in height over width, the torque bends sharply at the rest between them; no knob of steel does.
fn detents(random: &mut Random, bends: bool) -> Vec<[f64; 2]> {
    let mut at = 0.0;
    let mut detents = Vec::new();
    while at < 1.3 * TAU {
        let width_deg = 30.0 + 3.0 * random.even();
        let height = if bends { 10.0 * (1.0 + 0.2 * random.even()) } else { width_deg / 3.0 };
        detents.push([at, height]);
        at += width_deg.to_radians();
    }
    detents
}

struct Random(Xoshiro256PlusPlus);

impl Random {
    /// Evenly between −1 and 1.
    fn even(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    fn normal(&mut self) -> f64 {
        (-2.0 * (0.5 * (1.0 - self.even())).max(1e-300).ln()).sqrt() * (0.5 * TAU * self.even()).cos()
    }
}

fn turn(detents: &[[f64; 2]], seconds: f64, random: &mut Random) -> Curve {
    // As many as the rig takes in 7.5 s.
    let rows = 75_000;
    let mut curve = Curve { axis: Axis::Rotary, t_s: Some(Vec::new()), ..Curve::default() };
    for row in 0..2 * rows {
        let there = row < rows;
        let share = f64::from(if there { row } else { 2 * rows - 1 - row }) / f64::from(rows);
        let angle = 0.05 + 1.2 * TAU * share;
        let index = detents.iter().rposition(|[at, _]| *at <= angle).unwrap();
        let [at, height] = detents[index];
        let width = detents[index + 1][0] - at;
        let torque = height * (TAU * (angle - at) / width).sin();
        let friction = if there { FRICTION_MNM[0] } else { -FRICTION_MNM[1] };
        curve.position.push(angle);
        curve.load.push(torque + friction + NOISE_MNM * random.normal());
        if let Some(t_s) = &mut curve.t_s {
            t_s.push(f64::from(row) * seconds / f64::from(2 * rows));
        }
    }
    curve
}

/// Pitch and peak of every detent turning positively, as read and true.
fn read_and_true(random: &mut Random, bends: bool) -> Vec<[(DetentFigure, f64); 2]> {
    let truth = detents(random, bends);
    let sheet = Sheet::of(&[turn(&truth, 15.0, random)]).unwrap();
    assert!(sheet.detents.len() >= 24, "{} detents", sheet.detents.len());
    let friction = sheet.figures["running_friction"].value.unwrap();
    assert!((friction - 2.5).abs() < 0.02, "{friction}");
    let positive = sheet.detents.iter().filter(|detent| detent.direction == "positive");
    let pair = |detent: &Detent| {
        let off = |at: &[f64; 2]| (at[0] - detent.angle_rad).abs();
        let index = (0..truth.len()).min_by(|a, b| off(&truth[*a]).total_cmp(&off(&truth[*b]))).unwrap();
        let (pitch, peak) = (truth[index + 1][0] - truth[index][0], truth[index][1] + FRICTION_MNM[0]);
        [(detent.figures["detent_pitch"], pitch), (detent.figures["peak_torque"], peak)]
    };
    positive.map(pair).collect()
}

#[test]
fn unequal_detents_come_back_one_by_one() {
    let mut random = Random(Xoshiro256PlusPlus::seed_from_u64(5));
    for _ in 0..4 {
        for [(pitch, true_pitch), (peak, true_peak)] in read_and_true(&mut random, true) {
            assert!((pitch.value - true_pitch).abs() < 0.1_f64.to_radians(), "{pitch:?} instead of {true_pitch}");
            assert!((peak.value - true_peak).abs() < 0.01 * true_peak, "{peak:?} instead of {true_peak}");
        }
    }
}

#[test]
fn the_intervals_of_detents_hold_them_in_95_percent() {
    let mut random = Random(Xoshiro256PlusPlus::seed_from_u64(8));
    let all: Vec<[(DetentFigure, f64); 2]> = (0..12).flat_map(|_| read_and_true(&mut random, false)).collect();
    for figure in [0, 1] {
        let holds = |(read, truth): (DetentFigure, f64)| (read.ci95[0]..=read.ci95[1]).contains(&truth);
        let held = all.iter().filter(|pair| holds(pair[figure])).count() as f64 / all.len() as f64;
        assert!((0.9..=0.99).contains(&held), "figure {figure}: {held} of {}", all.len());
    }
}

#[test]
fn a_control_that_was_turned_too_fast_or_one_way_only_has_no_sheet() {
    let mut random = Random(Xoshiro256PlusPlus::seed_from_u64(6));
    let truth = detents(&mut random, false);
    let fast = turn(&truth, 1.0, &mut random);
    let error = Sheet::of(&[fast]).unwrap_err();
    assert!(matches!(error, SheetError::Curve { error: CurveError::TooFast { .. }, .. }), "{error}");
    let mut one_way = turn(&truth, 15.0, &mut random);
    for column in [&mut one_way.position, &mut one_way.load, one_way.t_s.as_mut().unwrap()] {
        column.truncate(75_000);
    }
    let error = Sheet::of(&[one_way]).unwrap_err();
    assert!(matches!(error, SheetError::Curve { error: CurveError::OneWay, .. }), "{error}");
    assert_eq!(Sheet::of(&[]).unwrap_err(), SheetError::NoCurve);
}

#[test]
fn a_knob_passes_fails_or_is_undecided_by_its_interval() {
    let mut random = Random(Xoshiro256PlusPlus::seed_from_u64(7));
    let truth: Vec<[f64; 2]> = (0..17).map(|index| [30_f64.to_radians() * f64::from(index), 10.0]).collect();
    let sheet = Sheet::of(&[turn(&truth, 15.0, &mut random)]).unwrap();
    let judge = |limits: &str| {
        let specification = Specification::from_toml(limits).unwrap();
        let judgement = specification.judge(&sheet);
        (judgement.verdict, judgement.reasons.join("; "))
    };
    let pitch = "[figures.detent_pitch]\nmin = 27\nmax = 33\nunit = \"deg\"\n";
    assert_eq!(judge(pitch), (Verdict::Pass, String::new()));
    let (verdict, reasons) = judge(&format!("{pitch}[figures.peak_torque]\nmax = 1.1\nunit = \"Ncm\"\n"));
    assert_eq!(verdict, Verdict::Fail);
    assert!(
        reasons.starts_with("peak_torque 12.")
            && reasons.contains("is outside at most 11 mNm; 0.9 perception thresholds"),
        "{reasons}"
    );
    let peak = sheet.figures["peak_torque"].value.unwrap();
    assert_eq!(judge(&format!("[figures.peak_torque]\nmin = {peak}")).0, Verdict::Undecided);
    assert_eq!(judge("[figures.end_stop_high]\nmin = 1").0, Verdict::Undecided);
    let envelope = |high: f64| {
        format!("[[envelope]]\nbranch = \"positive\"\nposition = [1, 6]\nlow = [-20, -20]\nhigh = [{high}, {high}]\n")
    };
    assert_eq!(judge(&envelope(14.0)).0, Verdict::Pass);
    assert_eq!(judge(&envelope(12.0)).0, Verdict::Fail);
    // The knob was turned through eight radians: what lies beyond nobody has seen.
    let farther = |high| envelope(high).replace("[1, 6]", "[1, 12]");
    let (verdict, reasons) = judge(&farther(14.0));
    assert_eq!(verdict, Verdict::Undecided);
    assert!(reasons.contains("its envelope from 1 to 12; capture all of it"), "{reasons}");
    assert_eq!(judge(&farther(12.0)).0, Verdict::Fail);

    let wrong = |text: &str| Specification::from_toml(text).unwrap_err().to_string();
    assert!(wrong("[figures.peak]\nmin = 1").starts_with("`peak` is not a figure; known are collapse_force, "));
    assert_eq!(wrong("[figures.snap]\nmin = 1\nunit = \"N\""), "snap: `N` is not a unit of it; its unit is `share`");
    assert_eq!(wrong("[figures.snap]\nmin = 2\nmax = 1"), "snap: it needs min, max or both, and min below max");
    assert_eq!(wrong("risk = 0.7\n[figures.snap]\nmin = 1"), "risk = 0.7, but it must lie between 0 and 0.5");
    assert!(wrong("name = \"x\"").contains("nothing could fail"));
}
