//! The control step on readings made up here: no rig, no clock.
#![allow(clippy::unwrap_used, reason = "a test may stop at a failure")]

use dynamics::{Calibration, Drive, Excitation};
use hal::{ApparatusError, Limits, Measurement};
use rt_loop::control::{ControlPlan, ControlState, Reading, Request, ServoGains, StepOutput};
use shared_types::{Fault, LoopState, Sample};

const RATE_HZ: f64 = 10_000.0;

fn calibration() -> Calibration {
    Calibration {
        axis: dynamics::Axis::Rotary,
        gripper_inertia: 0.004,
        motor_inertia: 0.014,
        torque_sensor_stiffness_mnm_rad: 5e5,
        torque_zero_mnm: 0.0,
        torque_delay_s: 0.0,
        acceleration_zero_rad_s2: 0.0,
        acceleration_delay_s: 0.0,
        gravity_amplitude_rad_s2: 0.0,
        gravity_phase_rad: 0.0,
        angle_step_rad: 0.0,
        torque_step_mnm: 0.0,
        acceleration_step_rad_s2: 0.0,
        motor_coulomb_mnm: None,
        motor_viscous: None,
        command_delay_s: None,
        motor_cogging: None,
    }
}

fn plan(planned_ticks: u64) -> ControlPlan {
    ControlPlan {
        excitation: Excitation::named("linear-chirp", Drive::Position).unwrap(),
        gains: ServoGains::default(),
        limits: Limits {
            motor_torque_mnm: 300.0,
            sensor_torque_mnm: 1_000.0,
            speed_rad_s: 60.0,
            angle_rad: 50.0,
            following_error_rad: 0.5,
            rate_hz: 20_000.0,
        },
        rate_hz: RATE_HZ,
        planned_ticks,
        stale_limit: 3,
        torque_late_ticks: 0.0,
    }
}

/// A rotor that follows the torque, so that the servo has something to hold.
struct Rotor {
    control: ControlState,
    angle_rad: f64,
    velocity_rad_s: f64,
    last: StepOutput,
}

impl Rotor {
    fn new(planned_ticks: u64) -> Self {
        let control = ControlState::new(plan(planned_ticks), &calibration()).unwrap();
        let mut rotor =
            Self { control, angle_rad: 0.3, velocity_rad_s: 0.0, last: StepOutput { torque_mnm: 0.0, sample: None } };
        rotor.control.arm();
        for _ in 0..2_000 {
            rotor.tick(1);
        }
        rotor
    }

    /// Lets `elapsed` ticks pass and steps once.
    fn tick(&mut self, elapsed: u64) -> StepOutput {
        for _ in 0..elapsed {
            let acceleration = self.last.torque_mnm / 0.05;
            self.velocity_rad_s += acceleration / RATE_HZ;
            self.angle_rad += self.velocity_rad_s / RATE_HZ;
        }
        self.read(elapsed, Ok(Measurement { angle_rad: self.angle_rad, ..Measurement::default() }))
    }

    fn read(&mut self, elapsed_ticks: u64, measurement: Result<Measurement, ApparatusError>) -> StepOutput {
        self.last = self.control.step(&Reading { elapsed_ticks, measurement });
        self.last
    }

    /// A run that has been going for 0.1 s.
    fn running() -> Self {
        let mut rotor = Self::new(100_000);
        assert!(rotor.control.request(Request::Start));
        for _ in 0..1_000 {
            assert!(rotor.tick(1).sample.is_some());
        }
        rotor
    }
}

/// A small generator of repeatable irregularity (Lehmer, modulus 2^31 − 1).
fn irregular(state: &mut u64) -> u64 {
    *state = *state * 48_271 % 0x7fff_ffff;
    *state
}

#[test]
fn samples_and_missed_ticks_add_up_to_what_was_planned_however_the_host_stalls() {
    for seed in 1..200 {
        let mut random = seed;
        let planned = 3_000 + irregular(&mut random) % 500;
        let mut rotor = Rotor::new(planned);
        assert!(rotor.control.request(Request::Start));
        let (mut samples, mut missed, mut next_tick) = (0, 0, 0);
        while rotor.control.state() == LoopState::Running {
            let stall = irregular(&mut random).is_multiple_of(50);
            let elapsed = if stall { 1 + irregular(&mut random) % 40 } else { 1 };
            let sample: Sample = rotor.tick(elapsed).sample.unwrap();
            assert_eq!(sample.seq, samples);
            assert_eq!(sample.tick, next_tick + u64::from(sample.missed_ticks), "the miss is counted in this sample");
            samples += 1;
            missed += u64::from(sample.missed_ticks);
            next_tick = sample.tick + 1;
        }
        assert_eq!(samples + missed, planned, "seed {seed}");
    }
}

#[test]
fn the_excitation_follows_time_and_not_the_count_of_samples() {
    let mut rotor = Rotor::new(100_000);
    rotor.control.request(Request::Start);
    let sweep = Excitation::named("linear-chirp", Drive::Position).unwrap();
    let start = rotor.tick(1).sample.unwrap().commanded_angle_rad;
    for elapsed in [1, 1, 7, 1, 23, 1] {
        let sample = rotor.tick(elapsed).sample.unwrap();
        let expected = start + sweep.at(sample.tick as f64 / RATE_HZ).value;
        assert!((sample.commanded_angle_rad - expected).abs() < 1e-12);
    }
}

#[test]
fn after_a_stall_the_excitation_goes_on_from_where_the_knob_is_and_a_knob_that_is_stuck_is_still_found() {
    let mut rotor = Rotor::running();
    let start_rad = 0.3;
    let sweep = Excitation::named("linear-chirp", Drive::Position).unwrap();
    let stuck = Measurement { angle_rad: rotor.angle_rad + 2.0, ..Measurement::default() };
    let first = rotor.read(500, Ok(stuck)).sample.unwrap();
    assert_eq!((first.missed_ticks, first.state), (499, LoopState::Running.code()));
    let away_rad =
        |sample: &Sample| sample.commanded_angle_rad - start_rad - sweep.at(sample.tick as f64 / RATE_HZ).value;
    // At 10 kHz the way back begins with a two thousandth.
    assert!((first.commanded_angle_rad - stuck.angle_rad).abs() < 2e-3);
    let mut next = first;
    for _ in 0..200 {
        next = rotor.read(1, Ok(stuck)).sample.unwrap();
    }
    let left = away_rad(&next) / away_rad(&first);
    assert!((left - (-0.1_f64).exp()).abs() < 1e-3, "after 20 ms of 200: {left}");
    while rotor.control.state() == LoopState::Running {
        rotor.read(1, Ok(stuck));
    }
    assert_eq!(rotor.control.fault(), Some(Fault::FollowingError));
}

#[test]
fn the_same_readings_give_the_same_torques_bit_for_bit() {
    let torques = || {
        let mut rotor = Rotor::new(5_000);
        rotor.control.request(Request::Start);
        (0..7_000).map(|index| rotor.tick(1 + u64::from(index % 97 == 0)).torque_mnm.to_bits()).collect::<Vec<_>>()
    };
    assert_eq!(torques(), torques());
}

#[test]
fn every_limit_ends_the_run_torque_free_with_the_cause_in_the_last_sample() {
    let normal = |rotor: &Rotor| Measurement { angle_rad: rotor.angle_rad, ..Measurement::default() };
    type Cause = fn(Measurement) -> Result<Measurement, ApparatusError>;
    let cases: [(Fault, Cause); 8] = [
        (Fault::Torque, |reading| Ok(Measurement { torque_mnm: -1_001.0, ..reading })),
        (Fault::FollowingError, Ok),
        (Fault::Runaway, Ok),
        (Fault::Sensor, |reading| Ok(Measurement { torque_mnm: f64::NAN, ..reading })),
        (Fault::Apparatus, |_| Err(ApparatusError::Amplifier)),
        (Fault::Watchdog, |_| Err(ApparatusError::Watchdog)),
        (Fault::Jump, |reading| Ok(Measurement { angle_rad: reading.angle_rad - 100.0, ..reading })),
        (Fault::Clock, |reading| Ok(Measurement { after_s: 1.0, ..reading })),
    ];
    for (expected, cause) in cases {
        let mut rotor = Rotor::running();
        let mut output = rotor.last;
        let mut drift = 0.0;
        let stuck_rad = rotor.angle_rad;
        // These two build up step by step, where the knob is stuck and where it turns against the motor; the others come at once.
        while rotor.control.state() == LoopState::Running {
            let mut reading = cause(normal(&rotor));
            if expected == Fault::FollowingError {
                reading = Ok(Measurement { angle_rad: stuck_rad, ..Measurement::default() });
            }
            if expected == Fault::Runaway {
                drift -= 0.002;
                reading = reading.map(|reading| Measurement { angle_rad: reading.angle_rad + drift, ..reading });
            }
            output = rotor.read(1, reading);
        }
        let fault = rotor.control.fault().unwrap();
        assert_eq!(fault, expected);
        let sample = output.sample.unwrap();
        assert_eq!((sample.state, sample.fault), (LoopState::Fault.code(), fault.code()));
        assert_eq!(output.torque_mnm, 0.0);
        for _ in 0..100 {
            let after = rotor.tick(1);
            assert!(after.torque_mnm == 0.0 && after.sample.is_none(), "torque-free and silent until restarted");
        }
        assert!(!rotor.control.request(Request::Start), "a fault is not overrun by a start");
    }
}

/// The fault that ends a run which commands a torque while the knob turns at a speed.
fn fault_at_speed(speed_rad_s: f64) -> Option<Fault> {
    let mut plan = plan(100_000);
    plan.excitation = Excitation::named("linear-chirp", Drive::Torque).unwrap();
    let mut control = ControlState::new(plan, &calibration()).unwrap();
    control.arm();
    let mut angle_rad = 0.0;
    let mut turn = |control: &mut ControlState| {
        let measurement = Ok(Measurement { angle_rad, ..Measurement::default() });
        angle_rad += speed_rad_s / RATE_HZ;
        control.step(&Reading { elapsed_ticks: 1, measurement })
    };
    turn(&mut control);
    control.request(Request::Start);
    while control.state() == LoopState::Running {
        assert!(turn(&mut control).sample.unwrap().angle_rad < 50.1);
    }
    control.fault()
}

#[test]
fn a_knob_that_turns_too_far_under_a_torque_is_an_angle_fault() {
    assert_eq!(fault_at_speed(40.0), Some(Fault::Angle));
}

#[test]
fn a_knob_that_runs_away_is_a_speed_fault() {
    assert_eq!(fault_at_speed(70.0), Some(Fault::Speed));
}

#[test]
fn an_encoders_step_and_an_angle_that_was_read_late_are_no_speed_fault() {
    let mut rotor = Rotor::running();
    // 20 rad/s, to steps of 4,000 a turn; every seventh angle is read half a tick late.
    let step_rad = std::f64::consts::TAU / 4_000.0;
    let start_rad = rotor.angle_rad;
    for tick in 0..200_u32 {
        let late = if tick % 7 == 0 { 0.5 } else { 0.0 };
        let turned_rad = 20.0 * (f64::from(tick) + late) / RATE_HZ;
        let angle_rad = start_rad + (turned_rad / step_rad).floor() * step_rad;
        rotor.read(1, Ok(Measurement { angle_rad, ..Measurement::default() }));
        assert_ne!(rotor.control.fault(), Some(Fault::Speed), "tick {tick}");
    }
}

#[test]
fn the_torque_comes_down_without_a_step_at_every_stop() {
    let mut rotor = Rotor::running();
    let mut previous = rotor.last.torque_mnm;
    assert!(rotor.control.request(Request::Stop));
    let mut steps = 0;
    while rotor.control.state() == LoopState::Stopping {
        let torque = rotor.tick(1).torque_mnm;
        assert!((torque - previous).abs() < 5.0, "a step of {} mNm", torque - previous);
        previous = torque;
        steps += 1;
    }
    assert_eq!(rotor.control.state(), LoopState::Idle);
    assert!(previous.abs() < 1.0 && steps > 100, "{previous} mNm left after {steps} ticks");
    assert_eq!(rotor.tick(1).torque_mnm, 0.0);
    rotor.read(1, Err(ApparatusError::Amplifier));
    assert_eq!(
        (rotor.control.state(), rotor.control.fault()),
        (LoopState::Idle, None),
        "a rig that is off may be silent"
    );
}

#[test]
fn a_run_that_commands_a_torque_ends_without_feedback_and_within_the_limits() {
    let mut plan = plan(1_000);
    plan.excitation = Excitation::named("linear-chirp", Drive::Torque).unwrap();
    let at_speed = |speed_rad_s: f64| {
        let mut control = ControlState::new(plan, &calibration()).unwrap();
        control.arm();
        let (mut angle_rad, mut torques_mnm) = (0.0, Vec::new());
        let mut turn = |control: &mut ControlState, speed_rad_s: f64| {
            angle_rad += speed_rad_s / RATE_HZ;
            let measurement = Ok(Measurement { angle_rad, ..Measurement::default() });
            control.step(&Reading { elapsed_ticks: 1, measurement }).torque_mnm
        };
        turn(&mut control, 5.0);
        assert!(control.request(Request::Start));
        while control.state() == LoopState::Running {
            torques_mnm.push(turn(&mut control, 5.0));
        }
        let last_mnm = torques_mnm.last().unwrap().abs();
        while control.state() == LoopState::Stopping {
            let torque_mnm = turn(&mut control, speed_rad_s).abs();
            assert!(torque_mnm <= last_mnm, "{torque_mnm} of {last_mnm} mNm");
        }
        control.fault()
    };
    assert_eq!(at_speed(5.0), None);
    assert_eq!(at_speed(70.0), Some(Fault::Speed));
}

#[test]
fn commands_beyond_the_motor_are_clipped_and_marked() {
    let mut rotor = Rotor::running();
    let behind = Measurement { angle_rad: rotor.angle_rad - 0.1, ..Measurement::default() };
    let output = rotor.read(40, Ok(behind));
    assert_eq!(output.torque_mnm, 300.0);
    assert_eq!(output.sample.unwrap().flags & Sample::TORQUE_CLIPPED, Sample::TORQUE_CLIPPED);
}

#[test]
fn nothing_is_published_and_no_run_begins_before_the_rig_is_armed() {
    let mut control = ControlState::new(plan(100), &calibration()).unwrap();
    assert!(!control.request(Request::Start));
    let output = control.step(&Reading { elapsed_ticks: 1, measurement: Ok(Measurement::default()) });
    assert!(output.sample.is_none() && output.torque_mnm == 0.0);
}

#[test]
fn no_run_begins_before_the_first_reading_which_must_come_in_time() {
    let armed = || {
        let mut control = ControlState::new(plan(100), &calibration()).unwrap();
        control.arm();
        control
    };
    let step = |control: &mut ControlState, measurement| {
        control.step(&Reading { elapsed_ticks: 1, measurement: Ok(measurement) });
    };
    let mut control = armed();
    step(&mut control, Measurement::stale(-7));
    assert!(control.awaits_reading() && !control.request(Request::Start), "no angle to begin at");
    step(&mut control, Measurement { angle_rad: 2.0, ..Measurement::default() });
    assert!(!control.awaits_reading() && control.request(Request::Start));
    let mut control = armed();
    (0..4).for_each(|_| step(&mut control, Measurement::stale(-7)));
    assert_eq!((control.fault(), control.device_code()), (Some(Fault::Stale), -7));
}

#[test]
fn ticks_that_bring_nothing_new_are_flagged_and_too_many_of_them_end_the_run() {
    let mut rotor = Rotor::running();
    let stale = Measurement { angle_rad: f64::NAN, ..Measurement::stale(-7) };
    let before = rotor.tick(1).sample.unwrap();
    for ticks in 1..=3 {
        let sample = rotor.read(1, Ok(stale)).sample.unwrap();
        assert_eq!((sample.stale_ticks, sample.flags & Sample::STALE), (ticks, Sample::STALE));
        assert_eq!(sample.device_code.cast_signed(), -7, "why, in the rig's own words");
        assert_eq!(sample.angle_rad.to_bits(), before.angle_rad.to_bits(), "the last one known");
    }
    let last = rotor.read(1, Ok(stale)).sample.unwrap();
    assert_eq!(last.fault, Fault::Stale.code());
    assert_eq!((rotor.control.fault(), rotor.control.device_code()), (Some(Fault::Stale), -7));
}

#[test]
fn a_time_that_does_not_rise_brings_nothing_new() {
    let mut rotor = Rotor::running();
    let fresh = rotor.tick(1).sample.unwrap();
    assert_eq!((fresh.stale_ticks, fresh.device_code), (0, 0));
    let same = Measurement { angle_rad: rotor.angle_rad, after_s: -1.0, ..Measurement::default() };
    assert_eq!(rotor.read(1, Ok(same)).sample.unwrap().stale_ticks, 1);
}

#[test]
fn a_devices_own_code_is_in_the_last_sample() {
    let mut rotor = Rotor::running();
    let last = rotor.read(1, Err(ApparatusError::Device(-110))).sample.unwrap();
    assert_eq!((last.fault, last.device_code.cast_signed()), (Fault::Apparatus.code(), -110));
}
