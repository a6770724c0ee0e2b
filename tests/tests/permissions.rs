//! What others on the machine may do: nothing.
#![allow(clippy::unwrap_used, clippy::print_stderr, reason = "a test may stop at a failure; a skipped one says so")]

use std::os::unix::fs::MetadataExt as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use archive::Capture;
use tests::live_view::{LiveView, listening_addresses};
use tests::{Bench, printed};

const CAPTURE: [&str; 6] = ["capture", "--duration-s", "4", "--no-viewer", "--out", "out"];

/// What of a bench's rig lies in shared memory.
fn in_shared_memory(bench: &Bench) -> Vec<PathBuf> {
    shared_types::clean_up::files_in_shared_memory(&bench.path("rig"))
}

/// A folder and everything in it.
fn with_everything_in(folder: &Path) -> Vec<PathBuf> {
    let mut found = vec![folder.to_owned()];
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        if entry.file_type().is_ok_and(|kind| kind.is_dir()) {
            found.extend(with_everything_in(&entry.path()));
        } else {
            found.push(entry.path());
        }
    }
    found
}

fn assert_closed_to_others(paths: &[PathBuf]) {
    for path in paths {
        // What is gone by now nobody can open.
        let mode = path.metadata().map_or(0, |found| found.mode());
        assert_eq!(mode & 0o077, 0, "{} has the mode {mode:o}", path.display());
    }
}

#[test]
fn shared_memory_runtime_directory_and_archives_are_open_to_the_user_alone() {
    let bench = Bench::new().unwrap();
    let child = bench.start(&CAPTURE).unwrap();
    bench.wait_for_process("recorder").unwrap();
    std::thread::sleep(std::time::Duration::from_secs(2));
    let segments = in_shared_memory(&bench);
    assert!(segments.len() > 10, "the rig is in shared memory: {segments:?}");
    // Whoever may not enter the folder in shared memory, or the runtime directory, reaches nothing in it.
    assert!(segments[1..].iter().all(|path| path.starts_with(&segments[0])), "{segments:?}");
    assert_closed_to_others(&[segments[0].clone(), bench.path("rig")]);
    assert_closed_to_others(&with_everything_in(&bench.path("out")));
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
    let files = with_everything_in(&bench.path("out"));
    assert!(files.len() >= 4, "the folder, archive, model and report: {files:?}");
    assert_closed_to_others(&files);
}

/// A program run by the user nobody, who has no group of ours.
fn as_nobody(program: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new("setpriv");
    command.args(["--reuid=65534", "--regid=65534", "--clear-groups", "--"]).arg(program).args(arguments);
    command
}

/// Whether there can be another user here; says so if not.
fn there_is_nobody() -> bool {
    let able = as_nobody(Path::new("true"), &[]).output().is_ok_and(|output| output.status.success());
    if !able {
        eprintln!("SKIPPED: only root can try what another user may do (setpriv refused)");
    }
    !able
}

#[test]
fn another_user_can_neither_read_the_rig_nor_command_nor_stop_it() {
    if there_is_nobody() {
        return;
    }
    let bench = Bench::new().unwrap();
    let child = bench.start(&CAPTURE).unwrap();
    let recorder = bench.wait_for_process("recorder").unwrap();
    let control_loop = bench.wait_for_process("rt-loop").unwrap();
    std::thread::sleep(std::time::Duration::from_secs(1));
    let segments = in_shared_memory(&bench);
    assert!(segments.len() > 10);
    for segment in &segments {
        for access in ["if", "of"] {
            let place = format!("{access}={}", segment.display());
            let output = as_nobody(Path::new("dd"), &[&place, "count=1", "conv=notrunc"]).output().unwrap();
            assert!(!output.status.success() || !segment.exists(), "nobody could open {}", segment.display());
        }
    }
    for place in ["rig", "out"] {
        let output = as_nobody(Path::new("ls"), &[&bench.path(place).to_string_lossy()]).output().unwrap();
        assert!(!output.status.success(), "nobody could list {place}");
    }
    for process in [recorder, control_loop] {
        for signal in ["-TERM", "-KILL", "-STOP"] {
            let output = as_nobody(Path::new("kill"), &[signal, &process.to_string()]).output().unwrap();
            assert!(!output.status.success(), "nobody could send {signal}");
        }
    }
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
    let capture = Capture::load(&bench.only_archive("out").unwrap()).unwrap();
    assert!(capture.gaps.is_empty());
    assert_eq!(capture.len() as u64 + capture.ticks_without_sample() + capture.tick[0], 40_000);
}

/// When another user tries something.
#[derive(Clone, Copy, PartialEq)]
enum When {
    Before,
    /// Before, and the rig is named by nothing but the user and the temporary directory.
    BeforeUnnamed,
    During,
}

/// What another user tries, as a shell script. Of the victim he knows everything but the contents of closed folders: the folder of
/// captures `OUT` and the temporary directory `TMP`, in which everybody may make files, the runtime directory `RIG`, the process
/// ids `PIDS`, the names of the coming seconds. `STRANGER` is an archive of another knob that says nothing of its run, `SECRET` a
/// file of the victim's that anybody may read. Where the script gets at something it says LEAK.
const TRIES: [(&str, &str, When, &str); 31] = [
    ("plant", "samples as parts, in the temporary directory", When::Before, "each cp $STRANGER $TMP/_T_.mcap.part-001"),
    ("plant", "samples as parts, beside the archive", When::Before, "each cp $STRANGER $OUT/_T_.mcap.part-001"),
    ("plant", "an archive, in the temporary directory", When::Before, "each cp $STRANGER $TMP/_T_.mcap"),
    (
        "plant",
        "an archive under the run's name",
        When::Before,
        "each cp $STRANGER $OUT/_T_.mcap; each cp $STRANGER $OUT/_T__02.mcap",
    ),
    ("plant", "pipes as parts", When::Before, "each mkfifo $TMP/_T_.mcap.part-000; each mkfifo $OUT/_T_.mcap.part-001"),
    ("plant", "folders as parts", When::Before, "each mkdir $TMP/_T_.mcap.part-000; each mkdir $OUT/_T_.mcap.part-000"),
    (
        "plant",
        "samples as parts of the running capture",
        When::During,
        "for n in 001 002; do cp $STRANGER $PART.$n; mv $PART.$n ${PART%000}$n; done; cp $STRANGER $TMP/$(basename ${PART%000}001)",
    ),
    (
        "plant",
        "a pipe under the archive's name, while it is recorded",
        When::During,
        "mkfifo ${PART%.part-000}; mkfifo $TMP/$(basename ${PART%.part-000})",
    ),
    ("plant", "a fallback folder", When::Before, "mkdir $TMP/haptic-camera-0 $TMP/haptic-camera-0-0000000000000000"),
    (
        "link",
        ".incomplete to the victim's file",
        When::Before,
        "each cp $STRANGER $OUT/_T_.mcap.part-001; each ln -s $SECRET $OUT/_T_.mcap.incomplete; each ln -s $SECRET $OUT/_T_.toml.incomplete; each ln -s $SECRET $TMP/_T_.mcap.incomplete",
    ),
    (
        "link",
        "parts to the victim's file",
        When::Before,
        "each ln -s $SECRET $TMP/_T_.mcap.part-001; each ln -s $SECRET $OUT/_T_.mcap.part-001",
    ),
    ("link", "the archive's name to the victim's file", When::Before, "each ln -s $SECRET $OUT/_T_.mcap"),
    (
        "link",
        "the results' names to the victim's file",
        When::Before,
        "for e in toml html json; do each ln -s $SECRET $OUT/_T_.$e; done",
    ),
    ("link", "the claim's name to the victim's file", When::Before, "each ln -s $SECRET $OUT/._T_.incomplete"),
    ("link", "hard, the victim's file as a part", When::Before, "each ln $SECRET $OUT/_T_.mcap.part-001 2> $TMP/said"),
    (
        "link",
        "shared memory to the victim's file",
        When::Before,
        "ln -s $SECRET /dev/shm/hc_${HASH}_x; ln -s $SECRET /dev/shm/${HASH}_x",
    ),
    (
        "link",
        "the runtime directory to the victim's folder",
        When::BeforeUnnamed,
        "ln -s $(dirname $SECRET) $TMP/haptic-camera-0",
    ),
    (
        "touch",
        "a name in shared memory",
        When::Before,
        "touch /dev/shm/hc_${HASH}_x /dev/shm/haptic-camera /dev/shm/haptic-camera-0",
    ),
    ("touch", "the runtime directory's name", When::BeforeUnnamed, "touch $TMP/haptic-camera-0"),
    ("touch", "the archive's names", When::Before, "each touch $OUT/_T_.mcap; each touch $OUT/_T__02.mcap"),
    ("touch", "the claims' names", When::Before, "each touch $OUT/._T_.incomplete"),
    (
        "touch",
        "all names of the running capture",
        When::During,
        "A=${PART%.mcap.part-000}; touch $A.mcap $A.toml $A.html $A.json",
    ),
    (
        "touch",
        "the running capture's part: removed, moved",
        When::During,
        "rm -f $PART && echo LEAK; mv $PART $TMP/mine && echo LEAK",
    ),
    ("flood", "1,000 names of parts", When::During, "for n in $(seq -w 1 999); do touch ${PART%000}$n; done"),
    (
        "flood",
        "4,000 names in shared memory",
        When::Before,
        "(cd /dev/shm; for i in $(seq 2000); do echo hc_${HASH}_$i haptic-camera-$i; done | xargs touch)",
    ),
    (
        "flood",
        "4,000 folders in the temporary directory",
        When::Before,
        "(cd $TMP; seq -f haptic-camera-0-%g 4000 | xargs mkdir)",
    ),
    (
        "read",
        "shared memory and the runtime directory",
        When::During,
        "for f in $SEGMENTS; do cat $f > $TMP/said && echo LEAK $f; done; ls $RIG && echo LEAK; cat $RIG/rig.lock && echo LEAK",
    ),
    (
        "read",
        "archive and memory of the processes",
        When::During,
        "cat $PART && echo LEAK; for p in $PIDS; do cat /proc/$p/environ > $TMP/said && echo LEAK; ls -l /proc/$p/fd/ > $TMP/said && echo LEAK; done",
    ),
    (
        "connect",
        "commands and a recorder of his own",
        When::During,
        "export HAPTIC_CAMERA_RUNTIME_DIR=$RIG; $BIN/haptic-camera tune && echo LEAK; $BIN/recorder --out $TMP/theirs.mcap && echo LEAK",
    ),
    (
        "signal",
        "TERM, KILL, STOP",
        When::During,
        "for p in $PIDS; do for s in TERM KILL STOP; do kill -$s $p && echo LEAK; done; done",
    ),
    (
        "signal",
        "INT, HUP, USR1",
        When::During,
        "for p in $PIDS; do for s in INT HUP USR1; do kill -$s $p && echo LEAK; done; done",
    ),
];

/// Runs a command for the names that a capture of knob 3 may have that begins in the next seconds, `_T_` in its words.
const EACH: &str =
    "each() { for s in $(seq 0 15); do T=$(date -d \"+$s seconds\" +%Y%m%d-%H%M%S)-knob-3; \"${@//_T_/$T}\"; done; }\n";

/// FNV-1a, 64 bit, of the runtime directory: what everybody can compute.
fn computable(runtime_dir: &Path) -> String {
    let bytes = runtime_dir.as_os_str().as_encoded_bytes();
    let hash = bytes
        .iter()
        .fold(0xcbf2_9ce4_8422_2325_u64, |hash, &byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3));
    format!("{hash:016x}")
}

/// A folder in which everybody may make files, and remove his own.
fn shared_folder(path: &Path) {
    use std::os::unix::fs::PermissionsExt as _;
    std::fs::create_dir(path).unwrap();
    std::fs::set_permissions(path, std::fs::Permissions::from_mode(0o1777)).unwrap();
}

/// What one try led to that it should not; empty is how it should be.
fn effects_of(when: When, script: &str, stranger: &Path) -> Vec<String> {
    use std::os::unix::fs::PermissionsExt as _;
    let bench = Bench::new().unwrap();
    std::fs::set_permissions(bench.path("."), std::fs::Permissions::from_mode(0o755)).unwrap();
    let (out, tmp, victim) = (bench.path("out"), bench.path("tmp"), bench.path("victim"));
    shared_folder(&out);
    shared_folder(&tmp);
    std::fs::create_dir(&victim).unwrap();
    std::fs::set_permissions(&victim, std::fs::Permissions::from_mode(0o755)).unwrap();
    let secret = victim.join("secret");
    std::fs::write(&secret, "the victim's\n").unwrap();
    std::fs::set_permissions(&secret, std::fs::Permissions::from_mode(0o644)).unwrap();
    let state = |path: &Path| path.metadata().map(|found| (found.mode(), found.uid(), found.len(), found.ino())).ok();
    let before = (state(&victim), state(&secret));
    let attack = |script: &str, environment: &[(&str, String)]| {
        let mut command = as_nobody(Path::new("timeout"), &["40", "bash", "-c", &format!("{EACH}{script}")]);
        command.env("OUT", &out).env("TMP", &tmp).env("RIG", bench.path("rig")).env("SECRET", &secret);
        command.env("STRANGER", stranger).env("HASH", computable(&bench.path("rig"))).env("TMPDIR", &tmp);
        command.envs(environment.iter().map(|(name, value)| (*name, value)));
        command.output().unwrap()
    };
    let mut said = String::new();
    if when != When::During {
        said += &printed(&attack(script, &[]));
    }
    let mut command = bench.command(&["capture", "--duration-s", "2", "--no-viewer", "--out", "out"]).unwrap();
    command.env("TMPDIR", &tmp);
    if when == When::BeforeUnnamed {
        command.env_remove(shared_types::rig::RUNTIME_DIR_VARIABLE).env_remove("XDG_RUNTIME_DIR");
    }
    let mut child = command.spawn().unwrap();
    if when == When::During {
        let part = wait_for_part(&out);
        let names = ["haptic-camera", "rt-loop", "recorder", "live-fitter"];
        let pids: Vec<String> =
            names.iter().flat_map(|name| bench.processes(name)).map(|process| process.to_string()).collect();
        let segments: Vec<String> = in_shared_memory(&bench).iter().map(|path| path.display().to_string()).collect();
        let bin = tests::program("recorder").unwrap().parent().unwrap().display().to_string();
        let known = [
            ("PART", part.display().to_string()),
            ("PIDS", pids.join(" ")),
            ("SEGMENTS", segments.join(" ")),
            ("BIN", bin),
        ];
        said += &printed(&attack(script, &known));
    }
    let deadline = std::time::Instant::now() + std::time::Duration::from_secs(90);
    while child.try_wait().unwrap().is_none() {
        if std::time::Instant::now() > deadline {
            child.kill().unwrap();
        }
        std::thread::sleep(std::time::Duration::from_millis(50));
    }
    let output = child.wait_with_output().unwrap();
    let mut effects = Vec::new();
    if said.contains("LEAK") {
        effects.push(format!(
            "got at something: {}",
            said.lines().filter(|line| line.contains("LEAK")).collect::<Vec<_>>().join("; ")
        ));
    }
    if output.status.code() != Some(0) {
        effects.push(format!("status {:?}: {}", output.status.code(), printed(&output).trim().replace('\n', " | ")));
    }
    effects.extend(effect_on_archive(&bench, &output));
    if (state(&victim), state(&secret)) != before || std::fs::read(&secret).unwrap() != b"the victim's\n" {
        effects.push("the victim's file was changed".to_owned());
    }
    effects.extend(bench.leftovers().into_iter().map(|left| format!("{left} is left behind")));
    remove_from_shared_memory(&computable(&bench.path("rig")));
    effects
}

/// The first part of the only capture that runs into a folder.
fn wait_for_part(out: &Path) -> PathBuf {
    for _ in 0..2_000 {
        let paths = std::fs::read_dir(out).unwrap().flatten().map(|entry| entry.path());
        if let Some(part) = paths.into_iter().find(|path| path.to_string_lossy().ends_with(".part-000")) {
            return part;
        }
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    panic!("no recorder begins");
}

/// Whether the capture was written where reported, is whole, and is of the knob that was turned.
fn effect_on_archive(bench: &Bench, output: &std::process::Output) -> Option<String> {
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    let line = said.lines().find_map(|line| line.strip_prefix("archive  "));
    let Some(archive) = line.map(|line| bench.path(line.split(" (").next().unwrap())) else {
        return Some("there is no archive".to_owned());
    };
    let capture = match Capture::load(&archive) {
        Ok(capture) => capture,
        Err(error) => return Some(error.to_string()),
    };
    let model = said.lines().find_map(|line| line.strip_prefix("model    ")).map(|path| bench.path(path));
    let inertia = model.and_then(|path| std::fs::read_to_string(path).ok()).and_then(|text| {
        let line = text.lines().find(|line| line.starts_with("inertia = "))?.to_owned();
        line.split_whitespace().nth(2)?.parse::<f64>().ok()
    });
    let ticks = capture.len() as u64 + capture.ticks_without_sample() + capture.tick[0];
    let whole = capture.gaps.is_empty() && ticks == 20_000;
    let right = inertia.is_some_and(|inertia| (inertia / 0.035 - 1.0).abs() < 0.1);
    (!whole || !right).then(|| format!("{ticks} of 20000 ticks, gaps {:?}, inertia {inertia:?}", capture.gaps))
}

/// Takes away what a try left in shared memory.
fn remove_from_shared_memory(hash: &str) {
    for entry in std::fs::read_dir("/dev/shm").unwrap().flatten() {
        let of_nobody = entry.metadata().is_ok_and(|found| found.uid() == 65534);
        if of_nobody || entry.file_name().to_string_lossy().contains(hash) {
            let _ = std::fs::remove_file(entry.path());
        }
    }
}

#[test]
fn nothing_that_another_user_tries_has_an_effect() {
    if there_is_nobody() {
        return;
    }
    let folder = tempfile::tempdir_in("/var/tmp").unwrap();
    let stranger = stranger_in(folder.path());
    let chosen = std::env::var("HAPTIC_CAMERA_TRY").unwrap_or_default();
    let mut with_effect = Vec::new();
    for (number, (verb, what, when, script)) in TRIES.iter().enumerate() {
        if !format!("{verb} {what}").contains(&chosen) {
            continue;
        }
        let effects = effects_of(*when, script, &stranger);
        let listed = if effects.is_empty() { "none".to_owned() } else { effects.join("; ") };
        eprintln!("| {} | {verb} | {what} | {listed} |", number + 1);
        with_effect.extend(effects);
    }
    assert!(with_effect.is_empty(), "{} effects: {with_effect:#?}", with_effect.len());
}

/// An archive of knob 1 that says nothing of its run, for everybody to read.
fn stranger_in(folder: &Path) -> PathBuf {
    use std::os::unix::fs::PermissionsExt as _;
    let bench = Bench::new().unwrap();
    let line = ["capture", "--offline", "--knob", "1", "--duration-s", "2", "--out", "made"];
    assert!(bench.run(&line).unwrap().status.success());
    let made = std::fs::read_dir(bench.path("made")).unwrap().flatten().map(|entry| entry.path());
    let archive = made.into_iter().find(|path| path.extension().is_some_and(|ending| ending == "mcap")).unwrap();
    let mut bytes = std::fs::read(archive).unwrap();
    let name = bytes.windows(8).position(|bytes| bytes == b"run.json").unwrap();
    bytes[name] = b'X';
    let stranger = folder.join("stranger.mcap");
    std::fs::write(&stranger, bytes).unwrap();
    for (path, mode) in [(folder, 0o755), (&stranger, 0o644)] {
        std::fs::set_permissions(path, std::fs::Permissions::from_mode(mode)).unwrap();
    }
    stranger
}

#[test]
fn another_user_cannot_lock_the_page_out() {
    if there_is_nobody() {
        return;
    }
    let bench = Bench::new().unwrap();
    let child = bench.start(&["capture", "--duration-s", "10", "--out", "out"]).unwrap();
    let view = LiveView::of_rig(&bench.path("rig")).unwrap();
    view.wait_for(|status| status["time_s"].as_f64() > Some(0.5)).unwrap();
    let addresses = listening_addresses(bench.wait_for_process("rerun-viewer").unwrap()).unwrap();
    let (_, port) = addresses[0].split_once(':').unwrap();
    let port = u16::from_str_radix(port, 16).unwrap();
    let hold =
        format!("for i in $(seq 200); do exec {{fd}}<>/dev/tcp/127.0.0.1/{port} || break; echo $i; done; sleep 4");
    let flood = as_nobody(Path::new("bash"), &["-c", &hold]).stdout(std::process::Stdio::piped()).spawn().unwrap();
    std::thread::sleep(std::time::Duration::from_secs(2));
    let ask = format!(
        "exec 3<>/dev/tcp/127.0.0.1/{port}; printf 'GET /status HTTP/1.1\\r\\nHost: 127.0.0.1:{port}\\r\\nConnection: close\\r\\n\\r\\n' >&3; timeout 5 cat <&3"
    );
    let answer = Command::new("bash").args(["-c", &ask]).output().unwrap().stdout;
    let opened = flood.wait_with_output().unwrap().stdout;
    assert!(opened.ends_with(b"\n200\n"), "200 connections: {}", String::from_utf8_lossy(&opened));
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
    assert!(answer.starts_with(b"HTTP/1.1 200"), "the page answers its own user: {}", String::from_utf8_lossy(&answer));
}

#[test]
fn another_user_is_shown_nothing_by_the_live_view() {
    if there_is_nobody() {
        return;
    }
    let bench = Bench::new().unwrap();
    let child = bench.start(&["capture", "--duration-s", "6", "--out", "out"]).unwrap();
    let view = LiveView::of_rig(&bench.path("rig")).unwrap();
    view.wait_for(|status| status["time_s"].as_f64() > Some(0.5)).unwrap();
    let addresses = listening_addresses(bench.wait_for_process("rerun-viewer").unwrap()).unwrap();
    assert_eq!(addresses.len(), 1, "the page and nothing else: {addresses:?}");
    let (_, port) = addresses[0].split_once(':').unwrap();
    let port = u16::from_str_radix(port, 16).unwrap();
    let question = |path: &str, host: &str| {
        let words = format!("GET /{path} HTTP/1.1\\r\\nHost: {host}\\r\\nConnection: close\\r\\n\\r\\n");
        format!("exec 3<>/dev/tcp/127.0.0.1/{port}; printf '{words}' >&3; cat <&3")
    };
    for path in ["status", "drawn", ""] {
        let ask = question(path, &format!("127.0.0.1:{port}"));
        let ours = Command::new("bash").args(["-c", &ask]).output().unwrap().stdout;
        assert!(ours.starts_with(b"HTTP/1.1 200"), "{}", String::from_utf8_lossy(&ours));
        let theirs = as_nobody(Path::new("bash"), &["-c", &ask]).output().unwrap().stdout;
        assert!(theirs.starts_with(b"HTTP/1.1 403"), "{}", String::from_utf8_lossy(&theirs));
        assert!(theirs.len() < 1000, "{} bytes for another user", theirs.len());
        // A page of somebody whose name means this machine, in our own browser.
        let by_name = Command::new("bash").args(["-c", &question(path, "knobs.example:80")]).output().unwrap().stdout;
        assert!(by_name.starts_with(b"HTTP/1.1 403"), "{}", String::from_utf8_lossy(&by_name));
    }
    assert_closed_to_others(&[bench.path("rig")]);
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
}
