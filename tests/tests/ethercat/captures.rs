//! What a capture of the plant tells, at the rates of drives.

use archive::Capture;
use serde_json::Value;
use tests::printed;
use tests::rotary_plant::is_the_plants;

use super::{RIG, Wired};

/// Share by which a torque that is held over the periods of 1 kHz misses the plant's friction and detents: where the rotor has a quarter of the
/// inertia, they are not half a period late as the inertia's torque is, but three eighths.
const OF_HOLD_AT_1_KHZ: f64 = 0.03;

/// The rig's file for torques that are read sooner than just before they change, by this share of a period.
fn read_sooner(text: &str, rate_hz: f64, by: f64) -> String {
    let delay_s = -by / rate_hz;
    let [torque, acceleration] = ["scale = 0.001\n", "scale = 0.5\n"];
    assert!(text.contains(torque) && text.contains(acceleration));
    let delayed = |line: &str| format!("{line}delay_s = {delay_s}\n");
    text.replace(torque, &delayed(torque)).replace(acceleration, &delayed(acceleration))
}

/// Most captures made to get one in which the host hardly stalls: during a stall it is unknown when the frame passed the devices, and after a
/// long one the knob is rightly stopped, since it has fallen behind.
const ATTEMPTS: usize = 6;
/// Share of the ticks below which the loop misses them on a host that hardly stalls.
const HARDLY: f64 = 1e-3;

/// Captures at a rate and fits; gives the capture and its fit's parameters.
fn fitted(wired: &Wired, rate_hz: &str) -> (Capture, Value) {
    let attempt = |attempt| {
        let (said, status, capture) = wired.capture(rate_hz, "10");
        let capture = capture.unwrap_or_else(|| panic!("{said}"));
        let missed: u32 = capture.missed_ticks.iter().flatten().sum();
        let stalls = f64::from(missed) >= HARDLY * capture.tick.len() as f64;
        if stalls && attempt < ATTEMPTS {
            return None;
        }
        assert_eq!(status, Some(0), "{said}");
        Some(capture)
    };
    let capture = (1..=ATTEMPTS).find_map(attempt).unwrap();
    let archive = wired.bench.only_archive("out").unwrap();
    let output = wired.bench.run(&["fit", &archive.to_string_lossy(), "--json", "-"]).unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
    let fit: Value = serde_json::from_slice(&output.stdout).unwrap();
    eprintln!("{rate_hz} Hz: {}", fit["parameters"]);
    (capture, fit["parameters"].clone())
}

#[test]
fn the_plant_behind_a_drive_is_captured_as_it_is_at_one_two_and_four_kilohertz() {
    let Some(wired) = Wired::new(&[]) else { return };
    for (rate_hz, khz) in [("1000", 1.0), ("2000", 2.0), ("4000", 4.0)] {
        let (capture, parameters) = fitted(&wired, rate_hz);
        is_the_plants(&parameters, OF_HOLD_AT_1_KHZ / khz, rate_hz);
        assert!(capture.gaps.is_empty(), "{rate_hz}");
        assert_eq!(capture.rig.clock, None, "ticks that follow the machine's clock");
        let run = capture.description.unwrap();
        assert_eq!((run.apparatus.as_str(), run.knob.as_str()), ("servo", "unnamed"));
        assert_eq!(run.simulated_knob_toml, None, "nobody knows what a real knob is");
        let note = |name: &str| run.notes.iter().find(|(known, _)| known == name).map(|(_, value)| value.as_str());
        assert_eq!(note("watchdog"), Some("0.5 s, read back"));
        assert_eq!(note("rated torque"), Some("100 mNm"), "as the drive tells");
        assert_eq!(note("encoder"), Some("524288 counts per turn"), "as the drive tells");
        assert!(run.device_codes.iter().any(|(code, meaning)| *code == 0x2310 && meaning.contains("over current")));
    }
}

#[test]
fn ticks_follow_the_drives_clock() {
    let Some(wired) = Wired::new(&["--clock-ppm", "80"]) else { return };
    // Inputs are taken at SYNC0, and the torque at once with its frame, which passes 0.3 of a period later.
    wired.rig(|text| read_sooner(&text, 1e3, 0.3).replace("[settings]\n", "[settings]\ndistributed_clocks = true\n"));
    let (capture, parameters) = fitted(&wired, "1000");
    is_the_plants(&parameters, OF_HOLD_AT_1_KHZ, "distributed clocks");
    let clock = capture.rig.clock.unwrap();
    eprintln!("{clock:?}");
    assert!((clock.drift_ppm - 80.0).abs() < 5.0, "{clock:?}");
    assert!((clock.phase_s + 0.3e-3).abs() < 0.05e-3, "{clock:?}");
    let after_s = capture.measured_after_s.unwrap();
    let late = after_s.iter().filter(|after_s| (**after_s + 0.3e-3).abs() > 0.1e-3).count();
    assert!(late * 10 < after_s.len(), "{late} of {} ticks are out of phase", after_s.len());
}

#[test]
fn the_torque_may_come_from_the_motors_current() {
    let Some(wired) = Wired::new(&["--same-source"]) else { return };
    wired.rig(|text| {
        let of_motor = "source = \"drive.torque\"\nof_motor = true\n";
        text.replace("source = \"sensor.0x6000:11\"\nscale = 0.001\n", of_motor)
    });
    assert!(RIG.contains("source = \"sensor.0x6000:11\"\nscale = 0.001\n"));
    let (_, parameters) = fitted(&wired, "2000");
    is_the_plants(&parameters, 0.01, "torque from the motor's current");
}
