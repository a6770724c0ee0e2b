//! Publishes a synthetic run, so that the viewer can be looked at without a rig.
//!
//! ```text
//! export HAPTIC_CAMERA_RUNTIME_DIR=/tmp/synthetic-rig
//! cargo run --release -p rerun-viewer --example synthetic_source -- 60 &
//! cargo run --release -p rerun-viewer
//! ```
//!
//! The knob is the paper's Knob 3 (Table 5) driven by a chirp at 10 kHz; the fit's intervals
//! narrow with the square root of time.

use std::time::{Duration, Instant};

use iceoryx2::port::update_connections::UpdateConnections as _;
use shared_types::services::{self, SAMPLES_PER_BLOCK};
use shared_types::{
    Axis, BlockHeader, ClockMapping, Estimate, FitUpdate, LoopState, LoopStatus, ProcessHealth, ProcessKind,
    RunDescription, Sample, Verdict, realtime, rig,
};

const RATE_HZ: f64 = 10_000.0;
/// Inertia, Coulomb and viscous friction either way, detent amplitude, period and phase of Knob 3.
const PARAMETERS: [f64; 8] = [0.035, 2.3, 2.3, -0.15, -0.24, 1.1, 0.034, 0.16];
/// How sure the fit is of each after one second, half an interval.
const INTERVALS: [f64; 8] = [0.004, 0.3, 0.3, 0.08, 0.08, 0.25, 0.002, 0.4];

/// Numbers that look random: xorshift64*.
struct Noise(u64);

impl Noise {
    /// Uniform in −1 to 1.
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

fn torque_mnm(angle_rad: f64, velocity_rad_s: f64, acceleration_rad_s2: f64) -> f64 {
    let [inertia, coulomb_negative, coulomb_positive, viscous_negative, viscous_positive, amplitude, period, phase] =
        PARAMETERS;
    let friction = if velocity_rad_s < 0.0 {
        -coulomb_negative + viscous_negative * velocity_rad_s
    } else {
        coulomb_positive + viscous_positive * velocity_rad_s
    };
    inertia * acceleration_rad_s2 + friction + amplitude * (angle_rad / period + phase).sin()
}

fn sample(seq: u64, start_ns: u64, noise: &mut Noise) -> Sample {
    let time_s = seq as f64 / RATE_HZ;
    // Starts again every 30 s: 0.3 rad, up to 3 Hz.
    let sweep_s = time_s % 30.0;
    let phase = std::f64::consts::TAU * (0.2 * sweep_s + 0.045 * sweep_s * sweep_s);
    let frequency = std::f64::consts::TAU * (0.2 + 0.09 * sweep_s);
    let angle_rad = 0.3 * phase.sin();
    let velocity_rad_s = 0.3 * frequency * phase.cos();
    let acceleration_rad_s2 = -0.3 * frequency * frequency * phase.sin();
    let stumble = if noise.next() > 0.9998 { 40_000.0 * (1.0 + noise.next()) } else { 0.0 };
    Sample {
        seq,
        tick: seq,
        monotonic_time_ns: start_ns + (time_s * 1e9) as u64,
        lateness_ns: (70.0 + 30.0 * noise.next() + stumble) as u64,
        angle_rad,
        velocity_rad_s: velocity_rad_s + 0.01 * noise.next(),
        acceleration_rad_s2: acceleration_rad_s2 + 2.8 * noise.next(),
        torque_mnm: torque_mnm(angle_rad, velocity_rad_s, acceleration_rad_s2) + 0.18 * noise.next(),
        contact: f64::NAN,
        commanded_angle_rad: angle_rad,
        state: LoopState::Running.code(),
        ..Sample::default()
    }
}

fn fit_update(run_id: u64, newest: &Sample, noise: &mut Noise) -> FitUpdate {
    let time_s = newest.time_s(RATE_HZ);
    let estimates: [Estimate; 8] = std::array::from_fn(|index| {
        let half_width = INTERVALS[index] / time_s.max(0.1).sqrt();
        let value = PARAMETERS[index] + 0.3 * half_width * noise.next();
        // Detents are identified later than friction.
        let enough = time_s > if index >= 5 { 4.0 } else { 1.0 };
        let verdict = if enough { Verdict::Estimated } else { Verdict::NotYet };
        Estimate {
            value,
            ci95_low: value - half_width,
            ci95_high: value + half_width,
            verdict: verdict.code(),
            convergence: u32::from(enough),
        }
    });
    FitUpdate {
        run_id,
        monotonic_time_ns: newest.monotonic_time_ns,
        latest_tick: newest.tick,
        samples: newest.seq,
        residual_rms_mnm: 0.104,
        inertia: estimates[0],
        coulomb_negative: estimates[1],
        coulomb_positive: estimates[2],
        viscous_negative: estimates[3],
        viscous_positive: estimates[4],
        detent_amplitude: estimates[5],
        detent_period: estimates[6],
        detent_phase: estimates[7],
        ..FitUpdate::default()
    }
}

fn description(run_id: u64, planned_ticks: u64) -> RunDescription {
    RunDescription {
        run_id,
        software_version: env!("CARGO_PKG_VERSION").to_owned(),
        apparatus: "sim".to_owned(),
        axis: Axis::Rotary,
        contact: false,
        knob: "Knob 3".to_owned(),
        rate_hz: RATE_HZ,
        planned_ticks,
        clock: ClockMapping {
            monotonic_time_ns: rig::monotonic_time_ns(),
            wall_clock_time_ns: rig::wall_clock_time_ns(),
        },
        realtime: realtime::FULL,
        torque_late_ticks: None,
        excitation_toml: String::new(),
        calibration_toml: String::new(),
        simulated_knob_toml: None,
        rendered_model_toml: None,
        control_toml: None,
        device_codes: Vec::new(),
        notes: Vec::new(),
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let duration_s: f64 = std::env::args().nth(1).map_or(Ok(60.0), |seconds| seconds.parse())?;
    let planned_ticks = (duration_s * RATE_HZ) as u64;
    let node = services::attach("synthetic")?;
    let samples = services::sample_publisher(&node)?;
    let descriptions = services::RUN_DESCRIPTION.publisher(&node)?;
    let statuses = services::LOOP_STATUS.publisher(&node)?;
    let fits = services::FIT_UPDATES.publisher(&node)?;
    let reports = services::PROCESS_HEALTH.publisher(&node)?;

    let start_ns = rig::monotonic_time_ns();
    let run_id = start_ns;
    let json = serde_json::to_vec(&description(run_id, planned_ticks))?;
    descriptions.loan_slice_uninit(json.len())?.write_from_slice(&json).send()?;

    let mut noise = Noise(run_id | 1);
    let mut status = LoopStatus {
        run_id,
        planned_ticks,
        rate_hz: RATE_HZ,
        realtime: realtime::FULL,
        state: LoopState::Running.code(),
        process_id: std::process::id(),
        ..LoopStatus::default()
    };
    let start = Instant::now();
    let mut millisecond = 0_u64;
    while status.published_samples < planned_ticks {
        let due = ((start.elapsed().as_secs_f64() * RATE_HZ) as u64).min(planned_ticks);
        while status.published_samples < due {
            let count = (due - status.published_samples).min(SAMPLES_PER_BLOCK as u64);
            let block: Vec<Sample> =
                (0..count).map(|index| sample(status.published_samples + index, start_ns, &mut noise)).collect();
            for sample in &block {
                status.lateness_counts[LoopStatus::lateness_bin(sample.lateness_ns)] += 1;
                status.max_lateness_ns = status.max_lateness_ns.max(sample.lateness_ns);
            }
            status.published_samples += count;
            let mut loan = samples.loan_slice_uninit(block.len())?;
            *loan.user_header_mut() = BlockHeader { run_id };
            loan.write_from_slice(&block).send()?;
        }
        status.monotonic_time_ns = rig::monotonic_time_ns();
        if millisecond.is_multiple_of(100) {
            statuses.send_copy(status)?;
            // A subscriber that came late is given the description when its coming is noticed.
            descriptions.update_connections()?;
        }
        if millisecond.is_multiple_of(50) && status.published_samples > 0 {
            let newest = sample(status.published_samples - 1, start_ns, &mut noise);
            fits.send_copy(fit_update(run_id, &newest, &mut noise))?;
        }
        if millisecond.is_multiple_of(500) {
            for (kind, share, mebibytes) in [(ProcessKind::Recorder, 0.03, 21), (ProcessKind::LiveFitter, 0.11, 34)] {
                reports.send_copy(ProcessHealth {
                    monotonic_time_ns: rig::monotonic_time_ns(),
                    process: kind.code(),
                    cpu_time_ns: (share * start.elapsed().as_secs_f64() * 1e9) as u64,
                    resident_bytes: mebibytes << 20,
                    latency_ns: (1.5e6 * (1.5 + noise.next())) as u64,
                    received_samples: status.published_samples,
                    ..ProcessHealth::default()
                })?;
            }
        }
        millisecond += 1;
        let next = start + Duration::from_millis(millisecond);
        std::thread::sleep(next.saturating_duration_since(Instant::now()));
    }
    statuses.send_copy(LoopStatus { finished: 1, state: LoopState::Idle.code(), ..status })?;
    std::thread::sleep(Duration::from_secs(1));
    Ok(())
}
