//! The driver over SocketCAN, in a kernel that has it: Debian's user-mode Linux on the files of this machine.

use std::path::Path;
use std::process::{Command, Stdio};

use serde_json::Value;
use tests::{Bench, printed, program};

/// What runs in place of init: a virtual CAN interface, the server on one side of it and the commands of an owner on the other.
const INIT: &str = r#"#!/bin/sh
export PATH=/usr/sbin:/usr/bin:/sbin:/bin
mount -t proc proc /proc
mount -t sysfs sysfs /sys
mkdir -p /dev/shm
mount -t tmpfs tmpfs /dev/shm
mount -t tmpfs tmpfs /run
for module in net/can/can net/can/can-raw drivers/net/can/dev/can-dev drivers/net/can/vcan; do
    insmod "/usr/lib/uml/modules/$(uname -r)/kernel/$module.ko"
done
ip link set lo up
ip link add vcan0 type vcan && ip link set vcan0 mtu 72 up
cd /run
export HOME=/run HAPTIC_CAMERA_RUNTIME_DIR=/run/rig
# Like a controller it waits for no other task.
chrt -f 60 {server} --can vcan0 &
sleep 1
{camera} rig scan vcan0 --out rig.toml
sed -i 's/timeout_s = 0.1 /timeout_s = 1.0 /; s/stale_ticks = 20 /stale_ticks = 800 /' rig.toml
{camera} rig check rig.toml --rate-hz 500 --duration-s 3 --json {bench}/check.json
poweroff -f
"#;

/// Whether a program is there.
fn is_there(name: &str) -> bool {
    ["/usr/bin", "/usr/sbin", "/sbin"].iter().any(|folder| Path::new(folder).join(name).exists())
}

#[test]
fn a_controller_on_a_can_bus_is_found_brought_up_and_read() {
    if !is_there("linux.uml") || !is_there("insmod") {
        eprintln!("SKIPPED: no user-mode Linux here; `apt-get install user-mode-linux kmod`");
        return;
    }
    let bench = Bench::new().unwrap();
    let camera = program("haptic-camera").unwrap();
    let init = INIT
        .replace("{server}", env!("CARGO_BIN_EXE_moteus_server"))
        .replace("{camera}", &camera.to_string_lossy())
        .replace("{bench}", &bench.path("").to_string_lossy());
    let path = bench.path("init");
    std::fs::write(&path, init).unwrap();
    std::fs::set_permissions(&path, std::os::unix::fs::PermissionsExt::from_mode(0o755)).unwrap();
    let mut command = Command::new("timeout");
    command.args(["--kill-after=5", "180", "linux.uml", "mem=512M", "quiet", "root=/dev/root", "rootfstype=hostfs"]);
    command.args(["rootflags=/", "rw", "con=null", "con0=fd:0,fd:1", &format!("init={}", path.display())]);
    command.arg(format!("uml_dir={}", bench.path("").display()));
    let output = command.stdin(Stdio::null()).output().unwrap();
    let said = printed(&output);
    // With AMX the processor's state is larger than Debian's kernel (6.1) hands back, and no process of the guest ever starts.
    if said.contains("ptrace set fp regs failed") {
        eprintln!("SKIPPED: user-mode Linux starts no process on this processor: ptrace set fp regs failed");
        return;
    }
    assert!(said.contains("moteus 1, model 0x1") && said.contains("SocketCAN at 0.0000 revolutions"), "{said}");
    let found = std::fs::read(bench.path("check.json")).unwrap_or_else(|error| panic!("{error}: {said}"));
    let found: Value = serde_json::from_slice(&found).unwrap();
    eprintln!("{found}");
    // The watchdog ran out when nobody commanded, as the driver tries it. How many answers come in time is the machine's, which has
    // a kernel in a process.
    assert_eq!(found["watchdog"], "1 s, read back", "{said}");
    assert!(found["samples"].as_u64().unwrap() > 10, "{found}");
    assert!(found["channels"][1]["span"].as_f64().unwrap() > 0.0, "the current is read anew: {found}");
}
