//! A motor's cogging and friction, calibrated from the simulated rig's plant, which shares nothing with what is fitted to it.

use std::f64::consts::{PI, TAU};

use crate::common::{Commanded, Uniform, commanded};
use dynamics::knobs::Fixture;
use dynamics::{Calibration, Drive, Excitation};
use hal::simulated_rig::{Cogging, RigParameters};
use identification::calibration::{CalibrateError, Calibrated, CoggingEstimate, cogging, combine, friction};

/// Captures the gripper alone on a rig whose motor cogs.
fn turned(sweep: &str, duration_s: f64, motor_cogging: Vec<Cogging>, seed: u64) -> Commanded {
    let none = Fixture::None.model().unwrap();
    let excitation = Excitation::named(sweep, Drive::Position).unwrap();
    let parameters = RigParameters { motor_cogging, ..RigParameters::default() };
    commanded(&none, excitation, parameters, duration_s, seed).unwrap()
}

/// A slotted motor drawn at random: 1.5 mNm or so at a multiple of its slots, and what its making left unequal.
fn drawn(random: &mut Uniform) -> Vec<Cogging> {
    let slots = 6.0 + (7.0 * random.next()).floor();
    let (poles, multiple) = (slots + 2.0, 2.0 + (5.0 * random.next()).floor());
    [(multiple * slots, 1.0 + random.next()), (slots, 0.2 + 0.5 * random.next()), (poles, 0.1 + 0.3 * random.next())]
        .map(|(per_turn, torque_mnm)| Cogging {
            per_turn: per_turn as u32,
            torque_mnm,
            phase_rad: TAU * (random.next() - 0.5),
        })
        .to_vec()
}

#[test]
fn slow_turns_both_ways_tell_the_harmonics_that_the_motor_has_and_no_other() {
    let (mut told, mut held) = (0, 0);
    let (mut worst_mnm, mut worst_rad) = (0.0_f64, 0.0_f64);
    for seed in 1..=12 {
        let mut random = Uniform(seed * 0x9e37_79b9_7f4a_7c15);
        let mut truth = drawn(&mut random);
        let run = turned("slow-turn", 15.0, truth.clone(), seed);
        let known = run.capture.rig();
        assert_eq!(known.motor_cogging, None, "no rig comes with it");
        let found = cogging(&run.capture.samples(), &run.commanded_mnm, known).unwrap().cogging.unwrap();
        truth.sort_by(|one, other| other.torque_mnm.total_cmp(&one.torque_mnm));
        assert_eq!(
            found.iter().map(|harmonic| harmonic.per_turn).collect::<Vec<_>>(),
            truth.iter().map(|harmonic| harmonic.per_turn).collect::<Vec<_>>(),
            "seed {seed}: {found:?}"
        );
        for (harmonic, truth) in found.iter().zip(&truth) {
            let off_mnm = (harmonic.torque_mnm - truth.torque_mnm).abs();
            let off_rad = ((harmonic.phase_rad - truth.phase_rad + PI).rem_euclid(TAU) - PI).abs();
            held += u32::from(off_mnm <= harmonic.torque_half_width_mnm);
            held += u32::from(off_rad <= harmonic.phase_half_width_rad);
            told += 2;
            (worst_mnm, worst_rad) = (worst_mnm.max(off_mnm), worst_rad.max(off_rad * truth.torque_mnm));
        }
    }
    println!("{held} of {told} intervals hold; worst {worst_mnm:.4} mNm in amplitude, {worst_rad:.4} mNm by phase");
    // 72 intervals of 95 %: fewer than 61 would be a chance below one in 10³.
    assert!(held >= 61, "{held} of {told} intervals hold the truth");
    assert!(worst_mnm < 0.02 && worst_rad < 0.02, "{worst_mnm}, {worst_rad} mNm");
}

#[test]
fn a_motor_without_iron_has_no_cogging() {
    for seed in 1..=8 {
        let run = turned("slow-turn", 15.0, Vec::new(), seed);
        let told = cogging(&run.capture.samples(), &run.commanded_mnm, run.capture.rig()).unwrap();
        assert_eq!(told.cogging, Some(Vec::new()), "seed {seed}");
        assert!(told.notes[0].contains("no cogging"));
    }
}

#[test]
fn friction_is_told_as_well_from_a_motor_that_cogs_once_its_cogging_is_known() {
    let truth = vec![Cogging { per_turn: 48, torque_mnm: 2.0, phase_rad: 0.7 }];
    let turn = turned("slow-turn", 15.0, truth.clone(), 3);
    let known = cogging(&turn.capture.samples(), &turn.commanded_mnm, turn.capture.rig())
        .unwrap()
        .applied_to(turn.capture.rig());
    let sweep = turned("linear-chirp", 10.0, truth, 4);
    let of = |known: &Calibration| friction(&sweep.capture.samples(), &sweep.commanded_mnm, known).unwrap();
    let (with, without) = (of(&known), of(sweep.capture.rig()));
    let coulomb = |told: &Calibrated| *told.get("motor_coulomb_mnm").unwrap();
    println!("with {:?}, without {:?}", coulomb(&with), coulomb(&without));
    assert!((coulomb(&with).value - 3.0).abs() < 0.05, "{:?}", coulomb(&with));
    assert!(coulomb(&with).half_width < 0.5 * coulomb(&without).half_width);
}

#[test]
fn captures_that_cannot_tell_cogging_are_refused_in_one_sentence() {
    let refused = |sweep: &str, duration_s: f64| {
        let run = turned(sweep, duration_s, Vec::new(), 1);
        let error = cogging(&run.capture.samples(), &run.commanded_mnm, run.capture.rig()).unwrap_err();
        assert!(matches!(error, CalibrateError::NoCogging { .. }));
        error.to_string()
    };
    assert!(refused("linear-chirp", 4.0).contains("less than a whole turn"));
    assert!(refused("slow-turn", 7.2).contains("one direction only"));
    let run = turned("slow-turn", 7.2, Vec::new(), 1);
    let error = cogging(&run.capture.samples(), &run.commanded_mnm[1..], run.capture.rig());
    assert_eq!(error, Err(CalibrateError::NoCommand));
}

#[test]
fn captures_of_one_motor_are_combined_harmonic_by_harmonic() {
    let told = |per_turn, torque_mnm, phase_rad| Calibrated {
        cogging: Some(vec![CoggingEstimate {
            per_turn,
            torque_mnm,
            torque_half_width_mnm: 0.1,
            phase_rad,
            phase_half_width_rad: 0.1,
        }]),
        ..Calibrated::default()
    };
    let both = combine(&[told(12, 1.0, 3.1), told(24, 2.0, 0.0), told(12, 1.1, -3.1)]).unwrap().cogging.unwrap();
    assert_eq!(both.iter().map(|harmonic| harmonic.per_turn).collect::<Vec<_>>(), [24, 12]);
    assert!((both[1].torque_mnm - 1.05).abs() < 1e-9 && both[1].torque_half_width_mnm < 0.1);
    assert!((both[1].phase_rad.abs() - PI).abs() < 1e-9, "across the cut of the circle: {}", both[1].phase_rad);
}

#[test]
fn a_calibration_file_keeps_cogging_and_older_ones_still_read() {
    let mut known = turned("slow-turn", 0.1, Vec::new(), 1).capture.rig().clone();
    let older = known.to_toml();
    assert!(!older.contains("motor_cogging"));
    assert_eq!(Calibration::from_toml(&older).unwrap(), known);
    for harmonics in [vec![], vec![dynamics::CoggingHarmonic { per_turn: 48, torque_mnm: 1.5, phase_rad: 0.3 }]] {
        known.motor_cogging = Some(harmonics);
        assert_eq!(Calibration::from_toml(&known.to_toml()).unwrap(), known, "{}", known.to_toml());
    }
    assert!(known.to_toml().contains("[[motor_cogging]]\nper_turn = 48\n"));
}
