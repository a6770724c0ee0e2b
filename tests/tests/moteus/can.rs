//! The driver over SocketCAN, in a kernel that has it: Debian's, under QEMU, on the files of this machine.

use std::process::Command;

use archive::Capture;
use serde_json::Value;
use tests::{printed, program};

use super::captures::is_the_plants;

/// A virtual CAN interface, the server on one side of it and the commands of an owner on the other. Programs are read before they
/// are run: a clock that goes by instructions leaps ahead while the guest waits for a file. They are stripped, since an emulated processor
/// reads slowly.
const SCRIPT: &str = r#"
ip link add vcan0 type vcan && ip link set vcan0 mtu 72 up
cat {programs}/* >/dev/null
export HAPTIC_CAMERA_RUNTIME_DIR=/run/rig
# Like a controller it waits for no other task; it ends with the interface and starts with it again.
while :; do chrt -f 60 {programs}/moteus_server --can vcan0; sleep 0.1; done &
sleep 1
{programs}/haptic-camera rig scan vcan0 --out rig.toml
{programs}/haptic-camera rig check rig.toml --rate-hz 1000 --duration-s 1 --json {folder}/check.json
{programs}/haptic-camera capture --rig rig.toml --rate-hz 1000 --duration-s 5 --no-viewer --out out
mv out/*.mcap {folder}/capture.mcap; mv out/*.json {folder}/fit.json
{programs}/haptic-camera capture --rig rig.toml --rate-hz 1000 --duration-s 60 --no-viewer --out cut >cut.log &
capture=$!
until grep -q capturing cut.log; do sleep 0.1; done
sleep 1
ip link set vcan0 down
wait $capture; echo "with the link down: status $?"
mv cut/*.mcap {folder}/cut.mcap
ip link set vcan0 up
sleep 1
{programs}/haptic-camera capture --rig rig.toml --rate-hz 1000 --duration-s 1 --no-viewer --out again >/dev/null
echo "with the link up: status $?"
"#;

/// The exit status of `scripts/in-guest` where there is no QEMU or no kernel for it.
const NO_GUEST: i32 = 77;

#[test]
fn a_plant_behind_a_controller_on_a_can_bus_is_captured_as_it_is_and_a_link_that_goes_down_is_reported() {
    // No bench, which would wait for its turn: the guest has a rig and a clock of its own.
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    std::fs::create_dir(path("programs")).unwrap();
    let programs = ["haptic-camera", "rt-loop", "recorder", "live-fitter"].map(|name| program(name).unwrap());
    for from in programs.into_iter().chain([env!("CARGO_BIN_EXE_moteus_server").into()]) {
        let to = path("programs").join(from.file_name().unwrap());
        let stripped = Command::new("strip").arg("-o").arg(&to).arg(&from).status();
        assert!(stripped.unwrap().success(), "{} is not stripped", from.display());
    }
    let script = SCRIPT
        .replace("{programs}", &path("programs").to_string_lossy())
        .replace("{folder}", &path("").to_string_lossy());
    std::fs::write(path("script"), script).unwrap();
    let mut guest = Command::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../scripts/in-guest"));
    let output = guest.arg(path("script")).args(["can-raw", "vcan"]).output().unwrap();
    let said = printed(&output);
    if output.status.code() == Some(NO_GUEST) {
        eprintln!("SKIPPED: {said}");
        return;
    }
    assert!(said.contains("moteus 1, model 0x1") && said.contains("SocketCAN at 0.0000 revolutions"), "{said}");
    let json = |name: &str| -> Value {
        let bytes = std::fs::read(path(name)).unwrap_or_else(|error| panic!("{name}: {error}: {said}"));
        serde_json::from_slice(&bytes).unwrap()
    };
    // The watchdog ran out when nobody commanded, as the driver tries it.
    assert_eq!(json("check.json")["watchdog"], "0.1 s, read back", "{said}");
    is_the_plants(&json("fit.json")["parameters"]);
    let capture = Capture::load(&path("capture.mcap")).unwrap();
    // Ticks are missed where the guest's clock leaps while it waits for its host; samples are not lost.
    assert!(capture.len() > 4_500 && capture.gaps.is_empty(), "{} samples: {said}", capture.len());
    assert!(said.contains("its port is gone, or its CAN interface is down"), "{said}");
    assert!(said.contains("with the link down: status 1") && said.contains("with the link up: status 0"), "{said}");
    let cut = Capture::load(&path("cut.mcap")).unwrap();
    assert!(cut.len() > 500 && cut.gaps.is_empty(), "{} samples: {said}", cut.len());
}
