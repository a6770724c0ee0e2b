//! Bristles, gaps and shafts in forward simulation, against closed solutions and against itself restarted.

use dynamics::simulate::{ForwardSimulation, SimulationError, State};
use dynamics::{Model, Motion};

use crate::model;

const STEP_S: f64 = 1e-4;

/// The motion at every step from rest under `torque(t)`, `gripper_inertia` turning with the knob.
fn driven(knob: &Model, gripper_inertia: f64, duration_s: f64, torque: impl Fn(f64) -> f64) -> Vec<Motion> {
    let mut simulation = ForwardSimulation::at_rest(knob, gripper_inertia, 0.0).unwrap();
    let steps = (duration_s / STEP_S).round() as usize;
    let mut motions = vec![simulation.motion(torque(0.0))];
    for index in 0..steps {
        let now = index as f64 * STEP_S;
        simulation.advance(STEP_S, torque(now), torque(now + STEP_S)).unwrap();
        motions.push(simulation.motion(torque(now + STEP_S)));
    }
    motions
}

#[test]
fn a_slightly_pushed_knob_swings_on_its_bristles_as_on_a_spring() {
    let (inertia, coulomb, deflection) = (0.05, 10.0, 0.02);
    let knob = model(&[
        ("inertia", &[inertia]),
        ("friction", &[coulomb, coulomb, 0.0, 0.0]),
        ("presliding-hysteresis", &[deflection, 0.0]),
    ]);
    // One ten-thousandth of the Coulomb friction: hysteresis is of second order.
    let push = 1e-4 * coulomb;
    let stiffness = coulomb / deflection;
    let omega = (stiffness / inertia).sqrt();
    for motion in driven(&knob, 0.0, 0.2, |_| push) {
        let exact = push / stiffness * (1.0 - (omega * motion.time_s).cos());
        assert!((motion.angle_rad - exact).abs() < 2e-3 * push / stiffness, "at {} s", motion.time_s);
    }
}

#[test]
fn a_knob_with_damped_bristles_creeps_to_where_they_carry_the_load_and_comes_back() {
    let (coulomb, deflection, load) = (10.0, 0.02, 6.0);
    let knob = model(&[
        ("inertia", &[0.05]),
        ("friction", &[coulomb, coulomb, 0.5, 0.5]),
        ("presliding-hysteresis", &[deflection, 1.0]),
    ]);
    // Slowly loaded it goes where C·(1 − e^(−θ/z₀)) is the load; unloaded, back along Dahl's other branch.
    let ramp = |time_s: f64| 0.5 * load * (1.0 - (std::f64::consts::TAU * time_s / 20.0).cos());
    let motions = driven(&knob, 0.0, 20.0, ramp);
    let far = -deflection * (1.0_f64 - load / coulomb).ln();
    assert!((motions[100_000].angle_rad - far).abs() < 1e-3 * far, "{} against {far}", motions[100_000].angle_rad);
    let back = far - deflection * (1.0_f64 + load / coulomb).ln();
    let end = motions.last().unwrap().angle_rad;
    assert!((end - back).abs() < 1e-3 * far, "{end} against {back}");
}

#[test]
fn a_shaft_turned_at_an_end_without_inertia_twists_as_spring_and_damper() {
    let (stiffness, damping, torque) = (500.0, 2.0, 3.0);
    let knob = model(&[
        ("inertia", &[0.05]),
        ("friction", &[2.0, 2.0, 0.1, 0.1]),
        ("karnopp-stick", &[10.0, 10.0, 0.01]),
        ("shaft-compliance", &[stiffness, damping]),
    ]);
    for motion in driven(&knob, 0.0, 0.05, |_| torque) {
        let decay = (-stiffness / damping * motion.time_s).exp();
        assert!((motion.angle_rad - torque / stiffness * (1.0 - decay)).abs() < 1e-12, "at {} s", motion.time_s);
        if motion.time_s > 0.0 {
            assert!((motion.velocity_rad_s - torque / damping * decay).abs() < 1e-9, "at {} s", motion.time_s);
        }
    }
}

#[test]
fn gripper_and_knob_swing_against_each_other_on_a_shaft() {
    let (inertia, gripper, stiffness, torque) = (0.05, 0.004, 500.0, 3.0);
    let whole = inertia + gripper;
    let knob = model(&[("inertia", &[inertia]), ("shaft-compliance", &[stiffness, 0.0])]);
    let with_its_cap = model(&[("inertia", &[whole]), ("shaft-compliance", &[stiffness, 0.0, gripper / whole])]);
    let reduced = inertia * gripper / whole;
    let omega = (stiffness / reduced).sqrt();
    let motions = [driven(&knob, gripper, 0.1, |_| torque), driven(&with_its_cap, 0.0, 0.1, |_| torque)];
    for motion in motions.into_iter().flatten() {
        let together = 0.5 * torque / (inertia + gripper) * motion.time_s.powi(2);
        let twist = torque / gripper / omega.powi(2) * (1.0 - (omega * motion.time_s).cos());
        let exact = together + inertia / (inertia + gripper) * twist;
        assert!(
            (motion.angle_rad - exact).abs() < 1e-8,
            "at {} s: {} against {exact}",
            motion.time_s,
            motion.angle_rad
        );
    }
}

#[test]
fn a_cap_crosses_its_gap_freely_and_then_pushes_until_the_inner_body_breaks_away() {
    let (half_gap, stiffness, held) = (0.05, 2000.0, 10.0);
    let knob = model(&[
        ("inertia", &[0.05]),
        ("friction", &[2.0, 2.0, 0.1, 0.1]),
        ("karnopp-stick", &[held, held, 0.01]),
        ("backlash", &[half_gap, 0.8, stiffness, 1.0]),
    ]);
    let motions = driven(&knob, 0.0, 0.4, |_| 6.0);
    for motion in motions.iter().take_while(|motion| motion.angle_rad < half_gap) {
        assert!((motion.angle_rad - 0.5 * 6.0 / 0.01 * motion.time_s.powi(2)).abs() < 1e-9, "at {} s", motion.time_s);
    }
    // 6 mNm alone would not move it, but the cap arrives with speed.
    let end = motions.last().unwrap();
    assert!(end.angle_rad > half_gap + 6.0 / stiffness, "{}", end.angle_rad);
    // Pushed gently it holds, and the contact carries the load.
    let gently = |time_s: f64| 8.0 * (time_s / 4.0).powi(2) * (3.0 - time_s / 2.0);
    let end = driven(&knob, 0.0, 4.0, gently).last().unwrap().angle_rad;
    assert!((end - half_gap - 8.0 / stiffness).abs() < 1e-6, "{end}");
}

#[test]
fn a_simulation_restarted_from_its_state_goes_on_as_before() {
    let base: [(&str, &[f64]); 3] =
        [("inertia", &[0.05]), ("friction", &[4.0, 3.0, 0.3, 0.4]), ("detent", &[3.0, 0.1, 0.0])];
    let further: [&[(&str, &[f64])]; 6] = [
        &[("karnopp-stick", &[9.0, 9.0, 0.05])],
        &[("presliding-hysteresis", &[0.02, 0.05])],
        &[("shaft-compliance", &[800.0, 0.5])],
        &[("backlash", &[0.02, 0.6, 4000.0, 5.0])],
        &[("backlash", &[0.02, 0.6, 4000.0, 5.0]), ("presliding-hysteresis", &[0.02, 0.05])],
        &[("shaft-compliance", &[800.0, 0.5]), ("karnopp-stick", &[9.0, 9.0, 0.05])],
    ];
    let torque = |index: usize| 14.0 * (std::f64::consts::TAU * 4.0 * index as f64 * STEP_S).sin();
    for effects in further {
        let knob = model(&base.iter().chain(effects).copied().collect::<Vec<_>>());
        for gripper in [0.0, 0.004] {
            let mut whole = ForwardSimulation::at_rest(&knob, gripper, 0.0).unwrap();
            let mut pieces = whole.clone();
            for index in 0..10_000 {
                if index % 97 == 0 {
                    pieces = ForwardSimulation::from_state(&knob, gripper, &pieces.state(), torque(index)).unwrap();
                }
                whole.advance(STEP_S, torque(index), torque(index + 1)).unwrap();
                pieces.advance(STEP_S, torque(index), torque(index + 1)).unwrap();
            }
            let (whole, pieces) = (whole.motion(0.0), pieces.motion(0.0));
            assert!(whole.angle_rad.abs() > 0.01, "{effects:?}: it never moved");
            assert!((whole.angle_rad - pieces.angle_rad).abs() < 1e-6, "{effects:?}, {gripper}: {whole:?} {pieces:?}");
        }
    }
}

#[test]
fn a_knob_started_in_steady_sliding_goes_on_sliding_steadily() {
    let further: [&[(&str, &[f64])]; 4] = [
        &[],
        &[("presliding-hysteresis", &[0.02, 0.05])],
        &[("shaft-compliance", &[800.0, 0.5])],
        &[("backlash", &[0.02, 0.6, 4000.0, 5.0]), ("presliding-hysteresis", &[0.02, 0.05])],
    ];
    for effects in further {
        let base: [(&str, &[f64]); 2] = [("inertia", &[0.05]), ("friction", &[4.0, 3.0, 0.3, 0.4])];
        let knob = model(&base.iter().chain(effects).copied().collect::<Vec<_>>());
        for velocity_rad_s in [-2.0, 2.0] {
            let motion = Motion { velocity_rad_s, ..Motion::default() };
            let torque = knob.torque_mnm(&motion);
            let state = State::sliding(&knob, &motion);
            let mut simulation = ForwardSimulation::from_state(&knob, 0.0, &state, torque).unwrap();
            for _ in 0..1_000 {
                simulation.advance(STEP_S, torque, torque).unwrap();
                let now = simulation.motion(torque);
                assert!((now.velocity_rad_s - velocity_rad_s).abs() < 1e-6, "{effects:?}: {now:?}");
            }
        }
    }
}

#[test]
fn what_cannot_be_simulated_says_why() {
    let weightless = model(&[("inertia", &[0.05]), ("backlash", &[0.02, 1.0, 1e3, 0.0])]);
    let error = ForwardSimulation::at_rest(&weightless, 0.0, 0.0).unwrap_err();
    assert_eq!(error, SimulationError::WeightlessCap { inertia: 0.0 });
    assert!(ForwardSimulation::at_rest(&weightless, 0.004, 0.0).is_ok(), "with a gripper it has inertia");
    let stiff = model(&[("inertia", &[0.05]), ("shaft-compliance", &[1e15, 0.0])]);
    let mut simulation = ForwardSimulation::at_rest(&stiff, 0.004, 0.0).unwrap();
    let error = (0..10_000).find_map(|_| simulation.advance(STEP_S, 5.0, 5.0).err());
    assert!(matches!(error, Some(SimulationError::TooStiff { .. })), "{error:?}");
}
