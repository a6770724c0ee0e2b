//! `compose` as an operator uses it.

use std::path::Path;

use crate::program::{call, done, errors, only};
use dynamics::{Model, Motion};

/// What is written on standard output and on standard error.
fn composed(folder: &Path, arguments: &str) -> (String, String) {
    let output = call(folder, &format!("compose {arguments}"));
    assert_eq!(output.status.code(), Some(0), "{arguments}: {}", errors(&output));
    (String::from_utf8_lossy(&output.stdout).into_owned(), errors(&output))
}

/// The one line of error, and the exit status.
fn refused(folder: &Path, arguments: &str) -> (String, i32) {
    let output = call(folder, &format!("compose {arguments}"));
    assert!(output.stdout.is_empty(), "{arguments}: {}", String::from_utf8_lossy(&output.stdout));
    (errors(&output), output.status.code().unwrap())
}

const DRAWN: &str = "angle_rad,torque_mnm\n0.0,0.0\n0.05,6.0\n0.1,0.0\n0.15,-6.0\n0.2,0.0\n";

#[test]
fn the_parts_of_three_knobs_make_one_that_says_where_each_is_from() {
    let folder = tempfile::tempdir().unwrap();
    let (printed, remarks) =
        composed(folder.path(), "--inertia 2 --friction 1 --detents 3 --set detent_amplitude=1.5 --out mix.toml");
    let model = Model::load(&folder.path().join("mix.toml")).unwrap();
    assert_eq!(model.name, "mix");
    assert_eq!(model.description, "inertia of knob 2, friction of knob 1, detents of knob 3");
    let values = ["inertia", "coulomb_positive", "static_positive", "detent_amplitude", "detent_period"];
    assert_eq!(values.map(|name| model.parameter(name).unwrap()), [0.28, 46.0, 150.0, 1.5, 0.034]);
    let origins: Vec<_> = model.effects.iter().map(|effect| effect.origin().unwrap()).collect();
    assert_eq!(origins, ["knob 2", "knob 1", "knob 1", "knob 3; detent_amplitude set to 1.5"]);

    let row = |name: &str| {
        let line = printed.lines().find(|line| line.contains(name)).unwrap().to_owned();
        line.split_whitespace().skip_while(|word| *word != name).map(str::to_owned).collect::<Vec<_>>()
    };
    assert_eq!(row("detent_amplitude"), ["detent_amplitude", "1.5", "mNm", "set", "to", "1.5"]);
    assert_eq!(row("coulomb_negative"), ["coulomb_negative", "46", "mNm", "knob", "1"]);
    // 1.5 mNm over 0.034 rad.
    assert!(printed.contains("mix.toml: 4 effects; its torque changes by up to 44.1176 mNm/rad"), "{printed}");
    assert!(remarks.contains("the detents reach 1.500 mNm, less than the 150.000 mNm"), "{remarks}");
}

#[test]
fn a_number_is_changed_and_the_model_composed_again_in_its_place() {
    let folder = tempfile::tempdir().unwrap();
    for amplitude in [2.0, 3.0] {
        composed(folder.path(), &format!("--inertia 3 --detents 3 --set detent_amplitude={amplitude} --out mix.toml"));
        let model = Model::load(&folder.path().join("mix.toml")).unwrap();
        assert_eq!(model.parameter("detent_amplitude"), Some(amplitude));
    }
}

#[test]
fn a_drawn_table_becomes_the_detents() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("drawn.csv"), DRAWN).unwrap();
    let (printed, _) = composed(
        folder.path(),
        "--inertia 3 --detents drawn.csv --set table_scale=2 --extra 5:backlash --from inertia=1 --out mix.toml",
    );
    assert!(printed.contains("4 over 0.2 rad"), "{printed}");
    let model = Model::load(&folder.path().join("mix.toml")).unwrap();
    assert_eq!(model.effect("torque-table").unwrap().origin(), Some("drawn.csv; table_scale set to 2"));
    assert_eq!((model.inertia(), model.coupling().is_some()), (0.091, true));
    for (angle_rad, expected) in [(0.05, 12.0), (0.1, 0.0), (0.15, -12.0), (0.25, 12.0), (-0.05, -12.0)] {
        let motion = Motion { angle_rad, ..Motion::default() };
        assert!((model.free_torque_mnm(&motion) - expected).abs() < 1e-9, "{angle_rad}");
    }
}

#[test]
fn a_parameter_of_a_pressed_control_goes_by_the_name_in_its_file() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    composed(folder, "--inertia dome --extra dome:bottom-out --set bottom_travel=3 --out low.toml");
    composed(folder, "--inertia dome --extra dome:bottom-out --from bottom_travel=low.toml --out again.toml");
    for name in ["low.toml", "again.toml"] {
        let text = std::fs::read_to_string(folder.join(name)).unwrap();
        assert!(text.contains("bottom_travel = 3.0"), "{text}");
    }
    let (error, status) = refused(folder, "--extra dome:bottom-out --set botom_travel=3 --out new.toml");
    assert!(error.contains("'botom_travel'") && error.contains("the nearest is bottom_travel"), "{error}");
    assert_eq!(status, 2);
}

#[test]
fn nothing_but_a_composed_model_is_written_over() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let fitted = dynamics::knobs::paper_knob(3).unwrap().to_toml();
    std::fs::write(path("drawn.csv"), DRAWN).unwrap();
    std::fs::write(path("fitted.toml"), &fitted).unwrap();
    composed(folder.path(), "--inertia 1 --out mix.toml");
    let mix = std::fs::read_to_string(path("mix.toml")).unwrap();
    for (arguments, expected) in [
        ("--inertia 1 --out fitted.toml", "fitted.toml is an existing file, not an earlier output of the same kind"),
        ("--inertia 1 --out drawn.csv", "drawn.csv is there already"),
        ("--inertia 1 --out nowhere/mix.toml", "nowhere/mix.toml cannot be written"),
        ("--inertia 7 --out new.toml", "there is no shipped knob 7; choose 1 to 5 or give a model file"),
        ("--inertia lost.toml --out new.toml", "the model file lost.toml cannot be read"),
        ("--detents lost.csv --out new.toml", "the table lost.csv cannot be read"),
    ] {
        let (error, status) = refused(folder.path(), arguments);
        assert!(error.starts_with("error: ") && error.contains(expected) && status == 1, "{arguments}: {error}");
    }
    // A failure leaves what was there.
    for (arguments, expected) in [
        ("--inertia 2 --set inertia=-1 --out mix.toml", "inertia"),
        ("--inertia mix.toml --detents 3 --out ./mix.toml", "./mix.toml is also an input"),
    ] {
        let (error, status) = refused(folder.path(), arguments);
        assert!(error.contains(expected) && status == 2, "{arguments}: {error}");
    }
    let now = |name: &str| std::fs::read_to_string(path(name)).unwrap();
    assert_eq!((now("mix.toml"), now("fitted.toml"), now("drawn.csv")), (mix, fitted, DRAWN.to_owned()));
    assert!(!path("new.toml").exists());

    composed(folder.path(), "--inertia 1 --out fitted.toml --overwrite");
    assert_eq!(Model::load(&path("fitted.toml")).unwrap().inertia(), 0.091);
}

#[test]
fn wrong_usage_is_reported_in_one_line_that_says_what_would_do() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("open.csv"), "angle_rad,torque_mnm\n0,0\n0.1,5\n0.2,1\n").unwrap();
    for (arguments, expected) in [
        ("--detents 1 --out new.toml", "Of the shipped knobs 3, 4 and 5 have"),
        ("--inertia 1 --set inertai=1 --out new.toml", "the nearest is inertia"),
        (
            "--inertia 1 --set inertia=nan --out new.toml",
            "inertia would be NaN mNm s²/rad, but it must be zero or more",
        ),
        ("--inertia 1 --set inertia=-0.1 --out new.toml", "inertia would be -0.1"),
        ("--inertia 1 --set inertia=1 --set inertia=2 --out new.toml", "inertia is given two values"),
        ("--inertia 1 --set detent_phase=1 --out new.toml", "detent_phase belongs to detent"),
        ("--detents 3 --extra 4:detent --out new.toml", "detent would come from knob 3 and again from knob 4"),
        ("--detents 3 --extra 5:backlsh --out new.toml", "the nearest is backlash"),
    ] {
        let (error, status) = refused(folder.path(), arguments);
        assert!(error.starts_with("error: ") && error.contains(expected) && status == 2, "{arguments}: {error}");
        assert_eq!(error.lines().count(), 1, "{error}");
    }
    for (arguments, expected) in [
        ("--out new.toml", "required"),
        ("--inertia 1 --inertia 2 --out new.toml", "cannot be used multiple times"),
        ("--inertia 1 --set inertia --out new.toml", "it must be a parameter and a number, as in detent_amplitude=1.5"),
        ("--inertia 1 --set inertia=heavy --out new.toml", "'heavy' is not a number"),
        ("--extra 5 --out new.toml", "as in 5:backlash"),
    ] {
        let (error, status) = refused(folder.path(), arguments);
        assert!(error.contains(expected) && status == 2, "{arguments}: {error}");
    }
    let (error, status) = refused(folder.path(), "--detents open.csv --out new.toml");
    assert!(error.contains("open.csv: the table does not repeat") && status == 1, "{error}");
    assert!(error.contains("a jump of 1.000000 mNm where 0.005000 mNm is allowed"), "{error}");
    assert!(!folder.path().join("new.toml").exists());
}

#[test]
fn the_rig_turns_a_composed_knob_with_drawn_detents() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("drawn.csv"), DRAWN).unwrap();
    composed(folder.path(), "--inertia 3 --friction 3 --detents drawn.csv --out drawn.toml");
    let arguments = "capture --knob drawn.toml --offline --no-viewer --sweep slow-turn --duration-s 4 --out captures";
    done(folder.path(), arguments);
    let capture = archive::Capture::load(&only(&folder.path().join("captures"), "mcap")).unwrap();
    // Half of the mean difference between angles a quarter of a period before and after the drawn zeros: friction,
    // zero offset and noise drop out. Within 1 % of the period around the peaks.
    let at_phase = |phase: f64| {
        let near = |angle: &f64| ((angle / 0.2 - phase).rem_euclid(1.0) - 0.5).abs() > 0.49;
        let torques: Vec<f64> = capture
            .angle_rad
            .iter()
            .zip(&capture.torque_mnm)
            .skip(10_000)
            .filter(|(angle, _)| near(angle))
            .map(|(_, torque)| *torque)
            .collect();
        assert!(torques.len() > 100, "the knob must pass phase {phase}");
        torques.iter().sum::<f64>() / torques.len() as f64
    };
    let peak_mnm = 0.5 * (at_phase(0.25) - at_phase(0.75));
    assert!((peak_mnm - 6.0).abs() < 0.2, "{peak_mnm} mNm for the 6 mNm drawn");
}

#[test]
fn a_drawn_table_is_nothing_that_a_diagnosis_can_start_from() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("drawn.csv"), DRAWN).unwrap();
    composed(folder.path(), "--inertia 3 --friction 3 --detents drawn.csv --out drawn.toml");
    std::fs::write(folder.path().join("capture.csv"), "t_s,angle_rad,torque_mnm\n0,0,0\n0.001,0,0\n0.002,0,0\n")
        .unwrap();
    let error = crate::program::refused(folder.path(), "diagnose capture.csv --model drawn.toml");
    assert!(error.contains("drawn.toml has a torque-table, which is drawn and cannot be fitted"), "{error}");
}
