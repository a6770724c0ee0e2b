//! What a rig's channels read while nothing moves it, as `rig check --json` writes it.

use archive::Capture;
use identification::statistics::{mean, range, standard_deviation};
use serde::Serialize;

/// Share of the ticks that may be missed or stale before the rate counts as not held.
const MISSED_SHARE: f64 = 0.01;

/// Share of a period above which the mean exchange with the rig counts as the cause of missed ticks.
const SLOW_SHARE: f64 = 0.5;

/// A stall of the loop longer than this is the machine's own, s, …
const LONG_STALL_S: f64 = 5e-3;
/// … if it also takes more ticks than a loop that is too slow for its rate misses at once: no lower rate avoids it.
const LONG_STALL_TICKS: f64 = 2.0;

/// What a channel read while nothing moved it.
#[derive(Clone, Debug, Serialize)]
pub struct Reading {
    /// Its name.
    pub channel: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Mean of all readings.
    pub mean: f64,
    /// Difference between its largest and its smallest reading.
    pub span: f64,
    /// RMS of the noise of one reading, from the differences of neighbours.
    pub noise_rms: f64,
}

/// What was read, and what is wrong with it.
#[derive(Clone, Debug, Serialize)]
pub struct RigCheck {
    /// The rig.
    pub rig: String,
    /// Ticks per second.
    pub rate_hz: f64,
    /// Ticks that were read.
    pub samples: u64,
    /// Ticks that the loop missed.
    pub missed_ticks: u64,
    /// Ticks without new data.
    pub stale_ticks: u64,
    /// Mean time from when a tick was due to when the encoder was read, µs; `None` where every tick was read when it was due.
    pub read_after_us: Option<f64>,
    /// Standard deviation of the same, µs.
    pub read_after_sd_us: Option<f64>,
    /// Time of the amplifier's watchdog as it was read back; `None` where the rig does not say.
    pub watchdog: Option<String>,
    /// What each channel read.
    pub channels: Vec<Reading>,
    /// What in its file looks like another unit, or is counted twice, in sentences.
    pub doubts: Vec<String>,
    /// What is wrong, in sentences.
    pub amiss: Vec<String>,
}

impl RigCheck {
    /// Looks at a capture of the rig without torque.
    #[must_use]
    pub fn of(capture: &Capture) -> Self {
        let run = capture.description.as_ref();
        let angle = reading("angle", "rad", &capture.angle_rad);
        let torque = reading("torque", "mNm", &capture.torque_mnm);
        let acceleration = capture.acceleration_rad_s2.as_ref().map(|column| reading("acceleration", "rad/s²", column));
        let contact = capture.contact.as_ref().map(|column| reading("contact", "1 if closed", column));
        let after_us = |after_s: &Vec<f64>| (1e6 * mean(after_s), 1e6 * standard_deviation(after_s));
        let (read_after_us, read_after_sd_us) = capture.measured_after_s.as_ref().map(after_us).unzip();
        let missed_ticks = capture.missed_tick_count();
        let ticks = capture.len() as f64 + capture.unmeasured_samples() as f64 + missed_ticks as f64;
        let mut amiss = Vec::new();
        if torque.span == 0.0 {
            amiss.push("the torque is constant; check its source, and the sensor's cable and supply".to_owned());
        }
        if acceleration.as_ref().is_some_and(|channel| channel.span == 0.0) {
            amiss.push("the acceleration is constant; check it, or omit [channels.acceleration]".to_owned());
        }
        if missed_ticks as f64 > MISSED_SHARE * ticks {
            let (exchange_ms, period_ms) = (1e3 * capture.rig.mean_exchange_s, 1e3 / capture.rate_hz);
            let before_stale = capture.unmeasured.iter().map(|sample| sample.missed_ticks);
            let stalls = capture.missed_ticks.iter().flatten().copied().chain(before_stale);
            let is_long = |stall: &u32| f64::from(*stall) > (LONG_STALL_S * capture.rate_hz).max(LONG_STALL_TICKS);
            let in_long_stalls: u64 = stalls.clone().filter(is_long).map(u64::from).sum();
            let cause = if exchange_ms > SLOW_SHARE * period_ms {
                format!(
                    "an exchange with the rig takes {exchange_ms:.2} ms of a period of {period_ms:.2} ms: its driver or library \
                     waits; have it return at once, or try a lower rate"
                )
            } else if 2 * in_long_stalls > missed_ticks {
                format!(
                    "the machine stopped the loop for up to {:.0} ms; check again, and see `haptic-camera doctor` if it persists",
                    1e3 * f64::from(stalls.max().unwrap_or(0)) / capture.rate_hz
                )
            } else {
                "this machine cannot hold the rate; try a lower rate".to_owned()
            };
            amiss.push(format!("{missed_ticks} of {ticks} ticks were missed: {cause}"));
        }
        if capture.unmeasured_samples() as f64 > MISSED_SHARE * ticks {
            let stale = capture.unmeasured_samples();
            amiss.push(format!(
                "{stale} of {ticks} ticks had no new data: the device is slower than the rate; lower [rates] fastest_hz"
            ));
        }
        let notes = run.map(|run| run.notes.as_slice()).unwrap_or_default();
        let note = |name: &str| notes.iter().find(|(known, _)| known == name).map(|(_, value)| value.clone());
        let watchdog = note("watchdog");
        if watchdog.is_none() {
            amiss.push(
                "the rig does not read back its watchdog: make sure that killing the program removes the torque"
                    .to_owned(),
            );
        }
        Self {
            rig: run.map(|run| run.apparatus.clone()).unwrap_or_default(),
            rate_hz: capture.rate_hz,
            samples: capture.len() as u64,
            missed_ticks,
            stale_ticks: capture.unmeasured_samples(),
            read_after_us,
            read_after_sd_us,
            watchdog,
            doubts: note("delay").into_iter().collect(),
            channels: [angle, torque].into_iter().chain(acceleration).chain(contact).collect(),
            amiss,
        }
    }
}

fn reading(channel: &'static str, unit: &'static str, values: &[f64]) -> Reading {
    let steps: Vec<f64> = values.windows(2).map(|pair| pair[1] - pair[0]).collect();
    // The difference of two readings has the noise of both.
    let noise_rms = standard_deviation(&steps) / std::f64::consts::SQRT_2;
    let [low, high] = range(values);
    Reading { channel, unit, mean: mean(values), span: high - low, noise_rms }
}

#[cfg(test)]
mod tests {
    use archive::Capture;
    use shared_types::Sample;

    use super::RigCheck;

    /// What is found wrong with 1000 samples at 5 kHz, with so many ticks missed before each of them, and before a stale one at the start.
    fn amiss(missed_before: impl Fn(usize) -> u32, before_stale: u32) -> String {
        let missed_ticks: Vec<u32> = (0..1000).map(missed_before).collect();
        let mut tick = u64::from(before_stale);
        let ticks = missed_ticks.iter().map(|missed| {
            tick += u64::from(*missed) + 1;
            tick
        });
        let capture = Capture {
            rate_hz: 5000.0,
            tick: ticks.collect(),
            missed_ticks: Some(missed_ticks),
            angle_rad: vec![0.0; 1000],
            torque_mnm: (0..1000).map(f64::from).collect(),
            unmeasured: vec![Sample { missed_ticks: before_stale, ..Sample::default() }],
            ..Capture::default()
        };
        RigCheck::of(&capture).amiss.join(" ")
    }

    #[test]
    fn a_machine_that_stalled_is_distinguished_from_one_that_is_too_slow() {
        assert!(amiss(|row| if row == 500 { 100 } else { 0 }, 0).contains("stopped the loop for up to 20 ms"));
        assert!(amiss(|_| 0, 100).contains("stopped the loop for up to 20 ms"), "a stall before a stale sample");
        assert!(amiss(|row| u32::from(row % 20 == 0), 0).contains("cannot hold the rate; try a lower rate"));
        assert!(!amiss(|row| u32::from(row == 500), 0).contains("missed"), "one tick in a thousand");
    }
}
