//! A motor that cogs, against conservation of energy and statics.

use std::f64::consts::TAU;

use hal::Apparatus as _;
use hal::simulated_rig::{Cogging, RigParameters, SimulatedRig};

use super::{Run, assert_close, clamped, flywheel, frictionless_motor};

/// A slotted motor with 48 periods in a turn, and what its making left unequal.
fn slotted() -> Vec<Cogging> {
    vec![
        Cogging { per_turn: 48, torque_mnm: 1.5, phase_rad: 0.4 },
        Cogging { per_turn: 12, torque_mnm: 0.7, phase_rad: -1.1 },
    ]
}

/// Energy of the magnets at an angle, mNm·rad: minus the work that the rotor is given on its way.
fn stored(angle_rad: f64) -> f64 {
    slotted()
        .iter()
        .map(|harmonic| {
            let per_turn = f64::from(harmonic.per_turn);
            -harmonic.torque_mnm / per_turn * (per_turn * angle_rad + harmonic.phase_rad).cos()
        })
        .sum()
}

#[test]
fn a_motor_that_coasts_trades_speed_for_the_energy_of_its_magnets() {
    let parameters = RigParameters { motor_cogging: slotted(), ..frictionless_motor() };
    let (of_motor, of_load) = (parameters.motor_inertia(), parameters.gripper_inertia + 0.01);
    let mut run = Run::new(parameters, flywheel(0.01), 10_000);
    run.ticks(200, 20.0);
    // Amplifier off: what remains is inertia and magnets. Current and the shaft's swing need a moment to run out.
    run.rig.disable();
    let advance = |run: &mut Run| {
        run.rig.read(run.tick * run.period_ns).unwrap();
        run.tick += 1;
        let truth = run.rig.truth();
        let kinetic =
            0.5 * (of_motor * truth.motor_velocity_rad_s.powi(2) + of_load * truth.knob_velocity_rad_s.powi(2));
        (truth.motor_angle_rad, kinetic)
    };
    for _ in 0..1_000 {
        advance(&mut run);
    }
    let (angle_rad, kinetic) = advance(&mut run);
    let whole = kinetic + stored(angle_rad);
    let (mut least_kinetic, mut most_kinetic) = (f64::INFINITY, 0.0_f64);
    for _ in 0..5_000 {
        let (angle_rad, kinetic) = advance(&mut run);
        // The sensor twists a little: what it takes up and damps is in neither term.
        assert_close((kinetic + stored(angle_rad)) / whole, 1.0, 1e-4, "the energy over that at the start");
        (least_kinetic, most_kinetic) = (least_kinetic.min(kinetic), most_kinetic.max(kinetic));
    }
    let turned_rad = run.rig.truth().motor_angle_rad;
    assert!(turned_rad > TAU, "it turned by {turned_rad} rad");
    let energies = (0..10_000).map(|place| stored(f64::from(place) * TAU / 10_000.0));
    let (least, most) = energies
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), energy| (least.min(energy), most.max(energy)));
    let traded = most_kinetic - least_kinetic;
    assert_close(traded / (most - least), 1.0, 0.01, "the energy traded over that of the magnets");
}

#[test]
fn at_rest_the_sensor_bears_what_the_command_has_left_of_the_cogging() {
    for (phase_rad, torque_mnm) in [(0.0, 0.0), (0.5, 2.0), (-1.2, 2.0), (3.0, 2.0)] {
        let motor_cogging = vec![Cogging { per_turn: 24, torque_mnm, phase_rad }];
        let parameters = RigParameters { motor_cogging, ..frictionless_motor() };
        let mut run = Run::new(parameters, clamped(), 10_000);
        run.ticks(3_000, 5.0);
        let borne_mnm = run.tick(5.0).torque_mnm;
        // By the twist of the sensor the rotor lies 10 µrad further.
        assert_close(borne_mnm, 5.0 - torque_mnm * phase_rad.sin(), 2e-3, "the torque in the sensor in mNm");
    }
}

#[test]
fn a_motor_that_cannot_be_is_refused() {
    for (per_turn, torque_mnm) in [(0, 1.0), (5_000, 1.0), (12, f64::NAN)] {
        let motor_cogging = vec![Cogging { per_turn, torque_mnm, phase_rad: 0.0 }];
        let refused = SimulatedRig::new(RigParameters { motor_cogging, ..frictionless_motor() }, flywheel(0.01), 1);
        assert!(refused.unwrap_err().to_string().contains("motor_cogging"));
    }
}
