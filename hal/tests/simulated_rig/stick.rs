//! Stick and slip.

use dynamics::{Model, Motion, knobs};
use hal::Apparatus;
use hal::simulated_rig::{RigParameters, SimulatedRig};

use super::{Run, assert_close, frictionless_motor, ideal_sensors};

/// Angle by which a torque turns the cap ahead of the inner body, rad.
fn lost_motion_rad(knob: &Model, torque_mnm: f64) -> f64 {
    knob.parameter("backlash_half_gap").map_or(0.0, |half_gap_rad| {
        half_gap_rad.copysign(torque_mnm) + torque_mnm / knob.parameter("backlash_stiffness").unwrap()
    })
}

#[test]
fn a_stuck_knob_does_not_creep_under_a_torque_that_it_holds() {
    for (number, torque_mnm) in [(1, 140.0), (1, -140.0), (2, 15.0), (3, 9.0), (4, -17.0), (5, 180.0)] {
        let parameters = ideal_sensors();
        let windup_rad = torque_mnm / parameters.torque_sensor_stiffness_mnm_rad;
        let knob = knobs::paper_knob(number).unwrap();
        // What the motor's own friction may take of the torque.
        let slack_mnm = 1.01 * parameters.motor_coulomb_mnm;
        let contact = knob.parameter("backlash_stiffness").map_or(0.0, f64::recip);
        let slack_rad = slack_mnm * (parameters.torque_sensor_stiffness_mnm_rad.recip() + contact);
        let mut run = Run::new(parameters, knob.clone(), 5000);
        // Laid on slowly: a sudden torque would overshoot to nearly twice itself in the sensor's spring.
        for tick in 0..5_000_u32 {
            run.tick(torque_mnm * f64::from(tick) / 5e3);
        }
        run.ticks(50_000, torque_mnm);
        let truth = run.rig.truth();
        assert_eq!(truth.inner_angle_rad.to_bits(), 0.0_f64.to_bits(), "knob {number} moved");
        assert_eq!(truth.inner_velocity_rad_s.to_bits(), 0.0_f64.to_bits(), "knob {number} moves");
        let lost_rad = lost_motion_rad(&knob, torque_mnm);
        assert_close(truth.motor_angle_rad, windup_rad + lost_rad, slack_rad, "the motor's angle");
    }
}

#[test]
fn a_held_knob_does_not_buzz_under_a_noisy_servo() {
    let mut run = Run::new(RigParameters::default(), knobs::paper_knob(1).unwrap(), 10_000);
    for _ in 0..100_000 {
        let angle_rad = run.rig.read(run.tick * run.period_ns).unwrap().angle_rad;
        run.rig.write_torque(-3000.0 * (angle_rad - 0.01)).unwrap();
        run.tick += 1;
    }
    let truth = run.rig.truth();
    assert!(truth.knob_stuck);
    assert_eq!(truth.knob_angle_rad.to_bits(), 0.0_f64.to_bits());
}

#[test]
fn each_knob_breaks_away_at_its_static_torque() {
    for number in 1..=5 {
        for sign in [1.0, -1.0] {
            let knob = knobs::paper_knob(number).unwrap();
            let at_rest = Motion::default();
            let limits = knob.stick_limits(&at_rest);
            let bears_mnm = if sign > 0.0 { limits.positive_mnm } else { -limits.negative_mnm };
            let expected_mnm = bears_mnm + knob.free_torque_mnm(&at_rest);
            // A motor that turns as in honey: a knob with lost motion shall not be broken loose by the blow of its cap.
            let parameters = RigParameters { motor_viscous: 50.0, ..frictionless_motor() };
            let mut run = Run::new(parameters, knob, 10_000);
            let step_mnm = 0.01;
            let mut last_held_mnm = 0.0;
            for tick in 0..40_000_u32 {
                run.tick(sign * step_mnm * f64::from(tick));
                if !run.rig.truth().knob_stuck {
                    break;
                }
                last_held_mnm = run.rig.truth().sensor_torque_mnm;
            }
            assert!(!run.rig.truth().knob_stuck, "knob {number} never broke away");
            assert_close(last_held_mnm, expected_mnm, 2.0 * step_mnm, "the breakaway torque in mNm");
        }
    }
}

#[test]
fn a_sliding_knob_sticks_only_below_its_stick_velocity_and_at_a_torque_that_it_bears() {
    for number in 1..=5 {
        let knob = knobs::paper_knob(number).unwrap();
        let mut rig = SimulatedRig::new(RigParameters::default(), knob.clone(), 1).unwrap();
        rig.enable().unwrap();
        // What friction holds, and what goes on turning in front of it when it does.
        let gripper_inertia = RigParameters::default().gripper_inertia;
        let (held_inertia, cap_inertia) = match knob.parameter("backlash_inner_share") {
            Some(share) => (share * knob.inertia(), gripper_inertia + (1.0 - share) * knob.inertia()),
            None => (gripper_inertia + knob.inertia(), 0.0),
        };
        // The state before the last two substeps.
        let mut earlier = [rig.truth(); 2];
        let mut rests = 0;
        for tick in 0..300_000_u32 {
            rig.read(u64::from(tick) * 10_000).unwrap();
            let time_s = f64::from(tick) * 1e-5;
            let wanted_rad = 0.5 * (4.0 * time_s).sin();
            let wanted_rad_s = 2.0 * (4.0 * time_s).cos();
            let torque_mnm = 3000.0 * (wanted_rad - earlier[1].motor_angle_rad)
                + 20.0 * (wanted_rad_s - earlier[1].motor_velocity_rad_s);
            rig.write_torque(torque_mnm).unwrap();
            let now = rig.truth();
            assert_eq!(now.knob_stuck, now.inner_velocity_rad_s == 0.0, "stuck means at rest: {now:?}");
            let motion = Motion { angle_rad: now.inner_angle_rad, ..Motion::default() };
            let limits = knob.stick_limits(&motion);
            let static_mnm = limits.positive_mnm.max(limits.negative_mnm);
            if now.knob_stuck && earlier[1].knob_stuck {
                let speeding_up_mnm = cap_inertia * now.knob_acceleration_rad_s2;
                let holding_mnm = now.sensor_torque_mnm - speeding_up_mnm - knob.free_torque_mnm(&motion);
                assert!(holding_mnm.abs() <= static_mnm + 1e-6, "knob {number} holds {holding_mnm} mNm");
                if !earlier[0].knob_stuck {
                    rests += 1;
                    // Above the stick velocity only a turning point, which friction and the drive
                    // reach within one substep, can be where the knob comes to rest.
                    let turning_rad_s = 1e-5 * 2.0 * static_mnm / held_inertia;
                    let slow_rad_s = limits.velocity_rad_s.max(turning_rad_s);
                    let speed_rad_s = earlier[0].inner_velocity_rad_s.abs();
                    assert!(speed_rad_s <= slow_rad_s, "knob {number} stuck from {speed_rad_s} rad/s");
                }
            }
            earlier = [earlier[1], now];
        }
        println!("knob {number} came to rest {rests} times in 3 s");
        assert!((2..200).contains(&rests), "knob {number} came to rest {rests} times in 3 s");
    }
}

#[test]
fn a_hand_can_turn_the_knob_of_a_rig_that_is_off() {
    let mut rig = SimulatedRig::new(RigParameters::default(), knobs::paper_knob(3).unwrap(), 1).unwrap();
    rig.set_hand_torque(9.0);
    rig.read(0).unwrap();
    rig.read(10_000_000).unwrap();
    assert!(rig.truth().knob_stuck, "9 mNm are less than the 10 mNm that knob 3 bears");
    rig.set_hand_torque(40.0);
    rig.read(20_000_000).unwrap();
    assert!(rig.truth().knob_velocity_rad_s > 0.0);
}
