//! What an owner of a drive begins with.

use tests::printed;

use super::{Running, Wired};

#[test]
fn what_is_on_the_bus_is_listed_and_makes_a_rig_file_that_comes_up() {
    let Some(wired) = Wired::new(&[]) else { return };
    let output = wired.bench.run(&["rig", "scan", "hc0", "--out", "found.toml"]).unwrap();
    let said = printed(&output);
    assert_eq!(output.status.code(), Some(0), "{said}");
    for words in [
        "0  HC-SERVO: vendor 0xabcdef, product 0x402, alias 7, a CiA 402 drive, with a distributed clock",
        "takes 0x6040:00/16 0x607a:00/32",
        "1  HC-ANALOG: vendor 0xabcdef, product 0x3104, alias 0",
        "gives 0x6000:01/16 0x6000:11/32 0x6010:11/16",
    ] {
        assert!(said.contains(words), "'{words}' in\n{said}");
    }
    let check = ["rig", "check", "found.toml", "--rate-hz", "1000", "--duration-s", "1", "--json", "check.json"];
    // A loaded host may keep frames back for longer than the file's limit.
    let mut runs = (0..4).map(|_| wired.bench.run(&check).unwrap());
    let output = runs.find(|output| output.status.success());
    let said = output.map_or_else(|| "no run came up".to_owned(), |output| printed(&output));
    let json = std::fs::read(wired.bench.path("check.json")).unwrap_or_else(|error| panic!("{error}: {said}"));
    let found: serde_json::Value = serde_json::from_slice(&json).unwrap();
    assert_eq!(found["watchdog"], "0.05 s, read back", "{said}");

    let output = wired.bench.run(&["rig", "scan", "hc9"]).unwrap();
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(errors.contains("no driver knows 'hc9'; give an Ethernet interface"), "{errors}");
}

#[test]
fn the_calls_of_a_tick_are_those_that_are_declared() {
    let Some(wired) = Wired::new(&[]) else { return };
    let arguments = ["capture", "--rig", "rig.toml", "--rate-hz", "1000", "--duration-s", "2", "--no-viewer"];
    let mut command = wired.bench.command(&arguments).unwrap();
    let output = command.env("HAPTIC_CAMERA_WATCH_CALLS", "1").output().unwrap();
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    if errors.contains("cannot be watched here") {
        eprintln!("SKIPPED: {errors}");
        return;
    }
    // One is the exchange's; in the tick of a fault, as on a host that keeps frames back, another asks for the reason.
    let most = errors.split("that the rig declares, at most ").nth(1).and_then(|rest| rest.split(' ').next());
    assert!(most.is_some_and(|most| ["1", "2"].contains(&most)), "{errors}");
}

#[test]
fn the_doctor_looks_at_the_interface() {
    let Some(wired) = Wired::new(&[]) else { return };
    let looked_at =
        || String::from_utf8_lossy(&wired.bench.run(&["doctor", "--rig", "rig.toml"]).unwrap().stdout).into_owned();
    let said = looked_at();
    assert!(said.contains("the driver of 'servo' is available") && !said.contains("hc0"), "{said}");
    assert!(super::ip("link set hc0 down"));
    let said = looked_at();
    assert!(said.contains("hc0 is down; `ip link set hc0 up`"), "{said}");
}

#[test]
fn a_knob_is_replayed_within_bounds_that_follow_from_the_drives_delay() {
    let Some(mut wired) = Wired::new(&[]) else { return };
    let known = |wired: &Wired, delay_s: &str| {
        wired.rig(|text| {
            let calibration = "[calibration]\nmotor_coulomb_mnm = 0.0\nmotor_viscous = 0.0\ncommand_delay_s = ";
            text.replace("[calibration]\n", &format!("{calibration}{delay_s}\n"))
        });
    };
    let replay = ["replay", "3", "--rig", "rig.toml", "--rate-hz", "1000", "--duration-s", "2", "--no-viewer"];
    // The drive takes its torque with the frame.
    known(&wired, "0.0");
    wired.segment = Running::start(&["--bare"]);
    let calibrate = ["calibrate", "latency", "--rig", "rig.toml", "--rate-hz", "1000", "--out", "calibrated.toml"];
    let output = wired.bench.run(&calibrate).unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
    let calibrated = std::fs::read_to_string(wired.bench.path("calibrated.toml")).unwrap();
    let delay_s = calibrated.lines().find_map(|line| line.strip_prefix("command_delay_s = ")).unwrap();
    eprintln!("the drive's delay: {delay_s} s");
    assert!(delay_s.parse::<f64>().unwrap().abs() < 1e-4, "{delay_s}");
    wired.segment = Running::start(&[]);
    known(&wired, delay_s);
    let output = wired.bench.run(&replay).unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
    assert!(printed(&output).contains("rendered Knob 3"), "{}", printed(&output));
    known(&wired, "5e-3");
    let output = wired.bench.run(&replay).unwrap();
    assert_eq!(output.status.code(), Some(1), "{}", printed(&output));
    assert!(printed(&output).contains("the rig 'servo' cannot render a knob stably in a hand"), "{}", printed(&output));
}
