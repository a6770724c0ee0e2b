//! A command replaces no file without being asked to, and reports what cannot be written.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read as _;
use std::os::unix::fs::FileTypeExt as _;
use std::path::Path;
use std::process::{Command, Output, Stdio};

use crate::program::{call, command, done};

fn said(output: &Output) -> String {
    format!("{:?}: {}", output.status, String::from_utf8_lossy(&output.stderr))
}

/// A folder with one file of every kind that commands read or write, and a foreign one of each.
fn folder_of_everything() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    done(path, "capture --offline --knob 3 --duration-s 1 --rate-hz 2000 --out made");
    done(path, "capture --offline --knob 3 --duration-s 1 --rate-hz 2000 --seed 2 --out made");
    let mut made: Vec<_> = std::fs::read_dir(path.join("made")).unwrap().map(|entry| entry.unwrap().path()).collect();
    made.sort();
    let archives = made.iter().filter(|path| path.extension().is_some_and(|ending| ending == "mcap"));
    for (archive, name) in archives.zip(["one", "two"]) {
        std::fs::rename(archive, path.join(format!("{name}.mcap"))).unwrap();
    }
    std::fs::remove_dir_all(path.join("made")).unwrap();
    done(path, "export one.mcap --out table.csv");
    done(path, "export 3 --out knob.h");
    done(path, "fit one.mcap --json fit.json --report fit.html --out fitted.toml");
    done(path, "compose --inertia 3 --friction 1 --out mix.toml");
    done(path, "simulate mix.toml --like one.mcap --out simulated.mcap");
    for (name, content) in [
        ("package.json", "{\"name\": \"thesis\"}"),
        ("thesis.html", "<html><body>years of work</body></html>"),
        ("config.toml", "name = \"mine\"\n"),
        ("board.h", "#define PIN 3\n"),
        ("notes.txt", "knob bought in May\n"),
        ("drawing.csv", "angle_rad,torque_mnm\n0,0\n1,1\n"),
    ] {
        std::fs::write(path.join(name), content).unwrap();
    }
    folder
}

fn contents(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap());
    entries.map(|entry| (entry.file_name().into_string().unwrap(), std::fs::read(entry.path()).unwrap())).collect()
}

/// Every option that names an output; `OUT` is the output, and the other files are inputs. What lies at the end of a line may
/// be replaced by it.
const OUTPUTS: [(&str, &[&str]); 26] = [
    ("fit one.mcap two.mcap --json OUT", &["fit.json"]),
    ("fit one.mcap --json OUT", &["fit.json"]),
    ("fit one.mcap --out OUT", &["fitted.toml"]),
    ("fit one.mcap --report OUT", &["fit.html"]),
    ("fit table.csv --json OUT", &["fit.json"]),
    ("fit table.csv --out OUT", &["fitted.toml"]),
    ("diagnose one.mcap --heldout two.mcap --json OUT", &["fit.json"]),
    ("diagnose one.mcap --heldout two.mcap --out OUT", &[]),
    ("diagnose one.mcap --model fitted.toml --report OUT", &["fit.html"]),
    ("diagnose one.mcap --recording OUT", &[]),
    ("calibrate gripper one.mcap two.mcap --out OUT", &["table.calibration.toml"]),
    ("calibrate gripper one.mcap --calibration table.calibration.toml --out OUT", &["table.calibration.toml"]),
    ("rig-test --offline --captures-in made --calibration table.calibration.toml --json OUT", &["fit.json"]),
    ("rig-test --offline --captures-in made --report OUT", &["fit.html"]),
    ("check one.mcap two.mcap --model fitted.toml --json OUT", &["fit.json"]),
    ("compare one.mcap mix.toml --json OUT", &["fit.json"]),
    ("compare one.mcap mix.toml --report OUT", &["fit.html"]),
    ("simulate mix.toml --like one.mcap --out OUT", &["simulated.mcap"]),
    ("compose --inertia mix.toml --friction fitted.toml --out OUT", &[]),
    ("compose --inertia 3 --friction fitted.toml --out OUT", &["mix.toml"]),
    ("export one.mcap --out OUT", &[]),
    ("export fitted.toml --out OUT", &["knob.h"]),
    ("table . --out OUT", &[]),
    ("list . --json OUT", &["fit.json"]),
    ("recompute one.mcap --json OUT", &["fit.json"]),
    ("recover one.mcap --out OUT", &[]),
];

#[test]
fn no_output_takes_the_place_of_an_input_or_of_a_file_of_another_kind_or_making() {
    let folder = folder_of_everything();
    let folder = folder.path();
    let before = contents(folder);
    assert_eq!(before.len(), 16, "{:?}", before.keys());
    let mut refusals = 0;
    for (line, replaced) in OUTPUTS {
        for name in before.keys().filter(|name| !replaced.contains(&name.as_str())) {
            for out in [name.clone(), format!("./{name}"), "linked".to_owned(), "link".to_owned()] {
                match out.as_str() {
                    "linked" => std::fs::hard_link(folder.join(name), folder.join(&out)).unwrap(),
                    "link" => std::os::unix::fs::symlink(name, folder.join(&out)).unwrap(),
                    _ => {}
                }
                let line = line.replace("OUT", &out);
                let output = call(folder, &line);
                let printed = said(&output);
                assert!(matches!(output.status.code(), Some(1 | 2)), "{line}: {printed}");
                assert_eq!(printed.lines().filter(|line| line.contains("error: ")).count(), 1, "{line}: {printed}");
                if out.starts_with("link") {
                    std::fs::remove_file(folder.join(&out)).unwrap();
                }
                refusals += 1;
            }
        }
        assert!(contents(folder) == before, "{line} changed {:?}", changed(&before, &contents(folder)));
    }
    eprintln!("{refusals} calls refused, nothing changed");
}

fn changed(before: &BTreeMap<String, Vec<u8>>, after: &BTreeMap<String, Vec<u8>>) -> Vec<String> {
    let names = before.keys().chain(after.keys().filter(|name| !before.contains_key(*name)));
    names.filter(|name| before.get(*name) != after.get(*name)).cloned().collect()
}

#[test]
fn an_earlier_output_of_the_same_kind_is_replaced() {
    let folder = folder_of_everything();
    let folder = folder.path();
    for line in [
        "fit two.mcap --json fit.json --report fit.html --out fitted.toml",
        "compare one.mcap two.mcap --json fit.json --report fit.html",
        "fit one.mcap two.mcap --out fitted.toml",
        "compose --inertia 1 --friction 1 --out mix.toml",
        "export 4 --out knob.h",
        "simulate fitted.toml --like two.mcap --out simulated.mcap",
        "man pages",
        "man pages",
    ] {
        done(folder, line);
    }
    // A name made by `mktemp` holds nothing yet.
    File::create(folder.join("empty.json")).unwrap();
    done(folder, "fit two.mcap --json empty.json");
    let output = call(folder, "fit one.mcap --json both --out both");
    assert_eq!(output.status.code(), Some(2), "{}", said(&output));
    assert!(!folder.join("both").exists());
}

#[test]
fn devices_and_pipes_are_written_to_and_stay() {
    let folder = folder_of_everything();
    let folder = folder.path();
    let made = Command::new("mknod").args(["null", "c", "1", "3"]).current_dir(folder).output().unwrap();
    // A device of one's own, so that a failure costs the machine nothing; a mount may forbid to open it.
    let device = folder.join("null");
    if made.status.success() && File::options().write(true).open(&device).is_ok() {
        done(folder, "fit one.mcap --json null --report null --out null");
        assert!(device.symlink_metadata().unwrap().file_type().is_char_device(), "the device was replaced");
    } else {
        eprintln!("SKIPPED: no permission to make a device");
    }
    assert!(Command::new("mkfifo").arg("pipe").current_dir(folder).status().unwrap().success());
    let writer = command(folder, "fit one.mcap --json pipe").stdout(Stdio::null()).spawn().unwrap();
    let mut piped = String::new();
    File::open(folder.join("pipe")).unwrap().read_to_string(&mut piped).unwrap();
    assert!(writer.wait_with_output().unwrap().status.success());
    assert!(piped.starts_with('{') && piped.ends_with("}\n"), "{piped}");
    assert!(folder.join("pipe").symlink_metadata().unwrap().file_type().is_fifo(), "the pipe was replaced");
    // Behind what was printed before, in a file that the shell opened.
    let file = File::create(folder.join("all.txt")).unwrap();
    let written = command(folder, "fit one.mcap --json /dev/stdout").stdout(file).status().unwrap();
    let text = std::fs::read_to_string(folder.join("all.txt")).unwrap();
    assert!(written.success() && text.contains("residual ") && text.contains("\"made_by\""), "{text}");
}

#[test]
fn a_link_of_ones_own_is_written_through() {
    let folder = folder_of_everything();
    let folder = folder.path();
    std::os::unix::fs::symlink("fit.json", folder.join("latest.json")).unwrap();
    done(folder, "fit two.mcap --json latest.json");
    assert!(folder.join("latest.json").symlink_metadata().unwrap().is_symlink());
    assert!(std::fs::read_to_string(folder.join("fit.json")).unwrap().contains("two.mcap"));
}

/// Every command that prints.
const PRINTING: [&str; 16] = [
    "--help",
    "--version",
    "fit --help",
    "fit one.mcap",
    "fit one.mcap --json -",
    "fit one.mcap two.mcap",
    "check one.mcap --model fitted.toml",
    "compare one.mcap mix.toml",
    "simulate mix.toml --like one.mcap --out again.mcap",
    "compose --inertia 3 --friction 1 --out new.toml",
    "export one.mcap --out new.csv",
    "list .",
    "list . --json",
    "completions bash",
    "man pages",
    "doctor",
];

#[test]
fn what_standard_output_does_not_take_is_reported_and_no_success() {
    let folder = folder_of_everything();
    let folder = folder.path();
    for line in PRINTING {
        let full = File::options().write(true).open("/dev/full").unwrap();
        let output = command(folder, line).stdout(full).stderr(Stdio::piped()).spawn().unwrap().wait_with_output();
        let output = output.unwrap();
        assert_eq!(output.status.code(), Some(1), "{line}: {}", said(&output));
        assert!(said(&output).contains("standard output could not be written"), "{line}: {}", said(&output));
        for made in ["again.mcap", "new.csv"] {
            let _ = std::fs::remove_file(folder.join(made));
        }
        // Whoever closes the pipe has seen enough.
        let mut child = command(folder, line).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        assert!(matches!(output.status.code(), Some(0 | 1)), "{line}: {}", said(&output));
        assert!(!said(&output).contains("standard output") && !said(&output).contains("panicked"), "{}", said(&output));
        for made in ["again.mcap", "new.csv"] {
            let _ = std::fs::remove_file(folder.join(made));
        }
    }
}
