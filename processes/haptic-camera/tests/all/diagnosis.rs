//! `diagnose` as an operator uses it, on captures of a knob whose law is written here.

use std::fmt::Write as _;
use std::path::Path;

use dynamics::{Drive, Excitation};

const RATE_HZ: f64 = 2000.0;
/// Step of the torque sensor, mNm; it makes the noise.
const TORQUE_STEP_MNM: f64 = 0.18;
/// Stiffness and centre of the spring that the base model lacks, mNm/rad and rad.
const SPRING: (f64, f64) = (6.0, 0.4);
/// Columns of a terminal.
const TERMINAL: usize = 80;

/// Inertia and friction with a spring, turned by the excitation `name`.
fn capture(path: &Path, name: &str, seconds: f64) {
    let sweep = Excitation::named(name, Drive::Position).unwrap();
    let mut table = "t_s,angle_rad,velocity_rad_s,acceleration_rad_s2,torque_mnm\n".to_owned();
    let mut t_s = 0.0;
    while t_s < seconds {
        let set = sweep.at(t_s);
        let friction = if set.rate == 0.0 { 0.0 } else { 9.0 * set.rate.signum() + 0.2 * set.rate };
        let torque = 0.05 * set.acceleration + friction + SPRING.0 * (set.value - SPRING.1);
        let read = (torque / TORQUE_STEP_MNM).round() * TORQUE_STEP_MNM;
        writeln!(table, "{t_s},{},{},{},{read}", set.value, set.rate, set.acceleration).unwrap();
        t_s += 1.0 / RATE_HZ;
    }
    std::fs::write(path, table).unwrap();
}

#[test]
fn a_spring_that_the_model_lacks_is_on_the_terminal_and_on_the_page() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    capture(&folder.join("train.csv"), "linear-chirp", 6.0);
    capture(&folder.join("heldout.csv"), "multisine", 4.0);
    let said = crate::program::done(folder, "diagnose train.csv --heldout heldout.csv --report page.html");
    let page = std::fs::read_to_string(folder.join("page.html")).unwrap();
    for words in ["return-spring", "spring_stiffness", "mNm/rad"] {
        assert!(said.contains(words), "{words} is not in:\n{said}");
        assert!(page.contains(words), "{words} is not on the page");
    }
    let widest = said.lines().map(|line| line.chars().count()).max().unwrap();
    assert!(widest <= TERMINAL, "{widest} columns:\n{said}");
}
