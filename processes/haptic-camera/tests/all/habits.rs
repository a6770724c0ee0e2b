//! What is expected of a program at a command line: help with examples, completions, manual pages, no colours in a pipe.

use std::process::{Command, Output};

fn haptic_camera(arguments: &[&str]) -> Output {
    // Where there is no terminal, this is how wide the help is.
    Command::new(env!("CARGO_BIN_EXE_haptic-camera")).args(arguments).env("COLUMNS", "80").output().unwrap()
}

fn said(arguments: &[&str]) -> String {
    let output = haptic_camera(arguments);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// The commands, as the help lists them.
fn commands() -> Vec<String> {
    let help = said(&["--help"]);
    let listed = help.lines().skip_while(|line| *line != "Commands:").skip(1).take_while(|line| !line.is_empty());
    // A description that goes on is indented further than a name.
    let names = listed.filter(|line| line.starts_with("  ") && !line.starts_with("   "));
    names.map(|line| line.split_whitespace().next().unwrap().to_owned()).filter(|name| name != "help").collect()
}

#[test]
fn every_command_s_help_has_an_example_and_fits_80_columns() {
    let commands = commands();
    for expected in ["capture", "list", "export", "completions", "man"] {
        assert!(commands.iter().any(|name| name == expected), "{expected} is not in {commands:?}");
    }
    for command in &commands {
        let help = said(&[command, "--help"]);
        assert!(help.contains(&format!("  haptic-camera {command}")), "{command} has no example:\n{help}");
        assert!(!help.contains('\u{1b}'), "colours in a pipe");
        // A usage line is not wrapped.
        let wide = |line: &&str| line.chars().count() > 80 && !line.starts_with("Usage:");
        let long: Vec<&str> = help.lines().filter(wide).collect();
        assert!(long.is_empty(), "{command}: {long:?}");
    }
    let help = said(&["--help"]);
    for words in ["RUST_LOG", "NO_COLOR", "Exit status: 0 done, 1 failed, 2 wrong usage, 3 done but data was lost"] {
        assert!(help.contains(words), "{words} is not in\n{help}");
    }
}

#[test]
fn completions_and_manual_pages_know_every_command() {
    let commands = commands();
    for shell in ["bash", "zsh", "fish"] {
        let script = said(&["completions", shell]);
        for command in &commands {
            assert!(script.contains(command.as_str()), "{shell} does not know {command}");
        }
        assert!(script.contains("until-ci"), "{shell} does not know the options");
    }
    let bash = said(&["completions", "bash"]);
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("haptic-camera"), bash).unwrap();
    let checked = Command::new("bash").arg("-n").arg(folder.path().join("haptic-camera")).output().unwrap();
    assert!(checked.status.success(), "{}", String::from_utf8_lossy(&checked.stderr));
    let pages = folder.path().join("man1");
    said(&["man", pages.to_str().unwrap()]);
    for command in &commands {
        let page = std::fs::read_to_string(pages.join(format!("haptic-camera-{command}.1"))).unwrap();
        assert!(page.starts_with(".ie") || page.contains(".TH"), "{page}");
    }
    assert!(pages.join("haptic-camera.1").exists());
    assert_eq!(haptic_camera(&["completions", "tcsh"]).status.code(), Some(2));
    std::fs::write(folder.path().join("file"), "").unwrap();
    let taken = folder.path().join("file");
    assert_eq!(haptic_camera(&["man", taken.to_str().unwrap()]).status.code(), Some(1));
}

#[test]
fn options_that_would_have_no_effect_are_wrong_usage() {
    for line in [
        "sheet --wall wall.html --json sheet.json",
        "sheet --wall wall.html --csv sheet.csv",
        "sheet --wall wall.html --columns angle=1,torque=2",
        "gauge --values values.csv --figure peak_torque --columns angle=1,torque=2",
        "calibrate zero capture.mcap --offline --out zero.toml",
        "capture --spec spec.toml --sweep multisine --offline",
        "capture --spec spec.toml --duration-s 3 --offline",
    ] {
        let output = haptic_camera(&line.split(' ').collect::<Vec<_>>());
        let said = String::from_utf8_lossy(&output.stderr);
        // Clap says of an option that it goes with others, or with none of them.
        let is_refused = said.contains("cannot be used with") || said.contains("required arguments");
        assert!(output.status.code() == Some(2) && is_refused, "{line}: {said}");
    }
}

#[test]
fn a_log_in_a_pipe_has_no_colours() {
    let output = Command::new(env!("CARGO_BIN_EXE_haptic-camera"))
        .args(["fit", "nowhere.mcap"])
        .env("RUST_LOG", "debug")
        .output()
        .unwrap();
    let log = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1));
    assert!(log.contains("DEBUG") && !log.contains('\u{1b}'), "{log}");
}
