//! What differs from place to place is told place by place: each detent, a scratch, and what has no name.

use std::f64::consts::TAU;

use crate::hidden;
use hidden_effects::capture::Answer;
use identification::diagnosis::{Diagnosis, Value, Verdict};

/// A diagnosis of captures of the plant under `tests/hidden-effects`, and what they hide.
fn diagnosed(seed: u64, asked: &str, strength: f64) -> (Diagnosis, Answer) {
    let ([train, heldout], answer) = hidden::hidden(seed, asked, strength);
    (hidden::diagnosed(&train, &heldout), answer)
}

/// A knob whose detents differ, as the plant has it.
struct Detents {
    period: f64,
    phase: f64,
    amplitude_mnm: f64,
    shifts: Vec<f64>,
    heights: Vec<f64>,
    end_on_walls: bool,
}

impl Detents {
    fn of(answer: &Answer) -> Self {
        let hidden = &answer.parameters["unequal-detents"];
        let numbers = |key: &str| hidden[key].as_array().unwrap().iter().map(|value| value.as_f64().unwrap()).collect();
        Self {
            period: answer.base.detent_period.unwrap(),
            phase: answer.base.detent_phase.unwrap(),
            amplitude_mnm: answer.base.detent_amplitude,
            shifts: numbers("shift_pitches"),
            heights: numbers("relative_height"),
            end_on_walls: hidden["ends_on_walls"].as_bool().unwrap(),
        }
    }

    fn at(values: &[f64], detent: f64) -> f64 {
        values[detent.rem_euclid(values.len() as f64) as usize]
    }

    fn nearest(&self, rest_rad: f64) -> f64 {
        ((rest_rad / self.period + self.phase) / TAU).round()
    }

    fn rest_rad(&self, detent: f64) -> f64 {
        let shift = if self.end_on_walls {
            0.5 * (Self::at(&self.shifts, detent - 1.0) + Self::at(&self.shifts, detent))
        } else {
            Self::at(&self.shifts, detent)
        };
        self.period * (TAU * (detent + shift) - self.phase)
    }

    fn peak_mnm(&self, detent: f64) -> f64 {
        let of = if self.end_on_walls { detent - 1.0 } else { detent };
        self.amplitude_mnm * (1.0 + Self::at(&self.heights, of))
    }
}

/// Shafts that are tried.
const SHAFTS: u64 = 6;

fn holds(value: &Value, truth: f64) -> bool {
    value.ci95.is_some_and(|[low, high]| (low..=high).contains(&truth))
}

#[test]
fn unequal_detents_are_told_one_by_one() {
    let (mut pitches, mut peaks, mut count) = (0, 0, 0);
    for seed in 0..6 {
        let (found, answer) = diagnosed(4000 + seed, "unequal-detents", 3.0);
        assert_eq!(found.effects, ["unequal-detents"], "seed {seed}: {}", found.summary);
        let detents = Detents::of(&answer);
        for one in &found.steps[0].detents {
            let detent = detents.nearest(one.rest.value);
            let pitch_rad = detents.rest_rad(detent + 1.0) - detents.rest_rad(detent);
            let peak_mnm = detents.peak_mnm(detent);
            assert!((one.pitch.value / pitch_rad - 1.0).abs() < 0.02, "{one:?}, {pitch_rad} rad");
            assert!((one.peak.value / peak_mnm - 1.0).abs() < 0.15, "{one:?}, {peak_mnm} mNm");
            count += 1;
            pitches += usize::from(holds(&one.pitch, pitch_rad));
            peaks += usize::from(holds(&one.peak, peak_mnm));
        }
    }
    assert!(count >= 40, "{count} detents");
    for held in [pitches, peaks] {
        assert!(held as f64 >= 0.85 * f64::from(count), "{held} of {count} intervals hold");
    }
}

#[test]
fn a_scratch_is_named_and_located() {
    for seed in 0..3 {
        let (found, answer) = diagnosed(4100 + seed, "scratch", 3.0);
        assert_eq!(found.effects, ["scratch"], "seed {seed}: {}", found.summary);
        let hidden = &answer.parameters["scratch"];
        for (name, key) in [("scratch_begin", "begin_rad"), ("scratch_end", "end_rad")] {
            let truth = hidden[key].as_f64().unwrap();
            let value = found.steps[0].parameters[name].value;
            assert!((value - truth).abs() < 0.05, "{name} {value}, {truth}");
        }
    }
}

#[test]
fn a_shaft_between_two_inertias_is_named_with_their_shares() {
    let mut held = 0;
    for seed in 0..SHAFTS {
        let (found, answer) = diagnosed(4300 + seed, "shaft-compliance", 3.0);
        assert_eq!(found.effects, ["shaft-compliance"], "seed {seed}: {}", found.summary);
        let truth = answer.parameters["shaft-compliance"]["outer_share_of_inertia"].as_f64().unwrap();
        let share = found.steps[0].parameters.get("shaft_outer_share");
        held += u64::from(share.map_or(truth == 0.0, |share| holds(share, truth)));
    }
    assert!(held + 1 >= SHAFTS, "{held} of {SHAFTS} intervals hold");
}

#[test]
fn what_has_no_name_is_measured_and_part_of_the_model() {
    let mut measured = 0;
    for seed in 0..2 {
        let (found, _) = diagnosed(4200 + seed, "friction-step", 5.0);
        assert_eq!(found.verdict, Verdict::OutsideLibrary, "seed {seed}: {}", found.summary);
        for characteristic in &found.characteristics {
            measured += 1;
            assert!(found.model.effect(characteristic.effect).is_some_and(|effect| effect.table().is_some()));
            assert!(
                characteristic.heldout_rms_after < characteristic.heldout_rms_before.min(characteristic.placebo_rms)
            );
        }
    }
    assert!(measured >= 2, "{measured}");
}
