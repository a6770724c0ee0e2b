//! What another user of the machine tries against a capture has no effect.
#![allow(clippy::unwrap_used, clippy::print_stderr, reason = "a test may stop at a failure; a skipped one says so")]

mod tries;

use std::os::unix::fs::{MetadataExt as _, PermissionsExt as _};
use std::path::{Path, PathBuf};

use archive::Capture;
use tests::other_user::{as_nobody, there_is_nobody};
use tests::{Bench, printed};
use tries::{EACH, TRIES, When};

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
    std::fs::create_dir(path).unwrap();
    std::fs::set_permissions(path, std::fs::Permissions::from_mode(0o1777)).unwrap();
}

/// What one try led to that it should not; empty is how it should be.
fn effects_of(when: When, script: &str, stranger: &Path) -> Vec<String> {
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
        let segments: Vec<String> = bench.shared_memory().iter().map(|path| path.display().to_string()).collect();
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
