//! The vendor's own codec at the other end, in Python: of the driver, and of the server that the other tests drive.

use std::path::{Path, PathBuf};
use std::process::Command;

use tests::{Bench, printed};

use super::{Server, rig};

/// A Python that has the vendor's package; `None` where there is none, which is said.
fn python() -> Option<PathBuf> {
    let repository = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let python = std::env::var_os("HAPTIC_CAMERA_PYTHON")
        .map_or_else(|| repository.join("target/python/bin/python"), PathBuf::from);
    let has_it =
        Command::new(&python).args(["-c", "import moteus"]).output().is_ok_and(|output| output.status.success());
    if !has_it {
        eprintln!("SKIPPED: {} has no package moteus; run `scripts/set-up tests`", python.display());
    }
    has_it.then_some(python)
}

#[test]
fn a_server_of_the_vendors_codec_is_captured() {
    let Some(python) = python() else { return };
    for way in [&[][..], &["--uart"]] {
        let bench = Bench::new().unwrap();
        let mut command = Command::new(&python);
        command.arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("moteus_server.py")).arg(bench.path("port")).args(way);
        let _server = Server::of(command);
        let file = rig(&bench, |text| text);
        let output = bench
            .run(&["capture", "--rig", &file, "--rate-hz", "1000", "--duration-s", "6", "--no-viewer", "--out", "out"])
            .unwrap();
        assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
        eprintln!("{}", printed(&output));
    }
}

#[test]
fn the_vendors_client_understands_the_compiled_server() {
    const CLIENT: &str = "
import asyncio, moteus, sys
async def main():
    transport = moteus.Fdcanusb(sys.argv[1])
    controller = moteus.Controller(id=1, transport=transport)
    await controller.set_stop()
    for _ in range(100):
        result = await controller.set_position(
            position=float('nan'), velocity=0.0, kp_scale=0.0, kd_scale=0.0, feedforward_torque=0.02, watchdog_timeout=1.0,
            query=True)
    assert result.values[moteus.Register.MODE] == moteus.Mode.POSITION, result
    assert abs(result.values[moteus.Register.TORQUE] - 0.02) < 0.01, result
    assert result.values[moteus.Register.FAULT] == 0, result
    await controller.set_stop()
    result = await controller.query()
    assert result.values[moteus.Register.MODE] == moteus.Mode.STOPPED, result
asyncio.run(main())
";
    let Some(python) = python() else { return };
    let bench = Bench::new().unwrap();
    let _server = Server::start(&bench, &["--uart"]);
    let output = Command::new(python).args(["-c", CLIENT]).arg(bench.path("port")).output().unwrap();
    assert!(output.status.success(), "{}", printed(&output));
}
