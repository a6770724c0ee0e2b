//! A pressed control is captured, fitted, reported, rendered and judged in mm and N.

use crate::program::{call, done, json, only, refused, words};
use serde_json::Value;

/// A dome of another size than the shipped one, damped more.
const BUTTON: &str = r#"name = "button"
axis = "linear"
[[effects]]
effect = "inertia"
inertia = 7e-5
[[effects]]
effect = "friction"
coulomb_negative = 0.05
coulomb_positive = 0.05
viscous_negative = 1e-3
viscous_positive = 1e-3
[[effects]]
effect = "return-spring"
spring_stiffness = 0.25
spring_centre = 0.0
[[effects]]
effect = "snap-through"
snap_height = 0.6
snap_flat_travel = 1.8
[[effects]]
effect = "bottom-out"
bottom_stiffness = 3.0
bottom_travel = 3.1
"#;

/// A slider with detents 1.9 mm apart.
const SLIDER: &str = r#"name = "slider"
axis = "linear"
[[effects]]
effect = "inertia"
inertia = 8e-5
[[effects]]
effect = "friction"
coulomb_negative = 0.15
coulomb_positive = 0.15
viscous_negative = 1e-3
viscous_positive = 1e-3
[[effects]]
effect = "detent"
detent_amplitude = 0.4
detent_period = 0.3
detent_phase = 0.3
"#;

#[test]
fn a_dome_is_captured_on_the_linear_rig_and_reported_in_its_own_units() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let output = call(folder, "capture --apparatus sim-linear --duration-s 4 --offline --no-viewer --out cap");
    assert!(output.status.success(), "{}", words(&output));
    let printed = words(&output);
    assert!(!printed.contains("mNm") && printed.contains("N s²/mm") && printed.contains("of the force"), "{printed}");
    let fit = json(&only(&folder.join("cap"), "json"));
    let inertia = &fit["parameters"]["inertia"];
    assert!((inertia["value"].as_f64().unwrap() / 4e-6 - 1.0).abs() < 0.08, "{inertia}");
    assert_eq!(inertia["unit"], "N s²/mm");
    assert!(fit["residual_rms_n"].as_f64().unwrap() < 0.005 && fit["residual_rms_mnm"].is_null());
    let page = std::fs::read_to_string(only(&folder.join("cap"), "html")).unwrap();
    assert!(page.contains("travel (mm)") && !page.contains("mNm"), "a page in other units");

    let archive = only(&folder.join("cap"), "mcap");
    done(folder, &format!("export {} --out table.csv", archive.display()));
    let table = std::fs::read_to_string(folder.join("table.csv")).unwrap();
    assert!(table.starts_with("t_s,travel_mm,velocity_mm_s,acceleration_mm_s2,force_n,contact\n"), "{}", &table[..80]);
    done(folder, "fit table.csv --json again.json");
    let again = json(&folder.join("again.json"));
    assert_eq!(again["parameters"]["inertia"]["value"], inertia["value"]);
}

#[test]
fn what_moves_along_the_other_axis_is_refused_in_a_sentence() {
    let folder = tempfile::tempdir().unwrap();
    for arguments in ["capture --apparatus sim-linear --knob 3 --offline", "capture --knob dome --offline"] {
        let output = call(folder.path(), arguments);
        let printed = words(&output);
        assert_eq!(output.status.code(), Some(1), "{printed}");
        assert!(printed.contains("rotary") && printed.contains("linear"), "{printed}");
    }
}

/// Force of the shipped dome's spring, truss and bottom at a travel, N.
fn dome_force_n(travel_mm: f64) -> f64 {
    let motion = dynamics::Motion { angle_rad: travel_mm, ..dynamics::Motion::default() };
    dynamics::knobs::dome().unwrap().place_torque_mnm(&motion)
}

#[test]
fn the_intervals_of_a_domes_mass_friction_and_curve_hold_them_as_often_as_they_say() {
    const SEEDS: u32 = 12;
    let folder = tempfile::tempdir().unwrap();
    let (mut of_mass, mut of_friction, mut points) = (0, 0, [0.0, 0.0]);
    for seed in 1..=SEEDS {
        let arguments = "capture --apparatus sim-linear --duration-s 4 --offline --no-viewer";
        done(folder.path(), &format!("{arguments} --seed {seed} --out {seed}"));
        let fit = json(&only(&folder.path().join(seed.to_string()), "json"));
        let holds = |interval: &Value, truth: f64| {
            let [low, high] = [0, 1].map(|end| interval[end].as_f64().unwrap());
            (low..=high).contains(&truth)
        };
        let parameter = |name: &str, truth: f64| u32::from(holds(&fit["parameters"][name]["ci95"], truth));
        of_mass += parameter("inertia", 4e-6);
        for (name, truth) in [
            ("coulomb_negative", 0.02),
            ("coulomb_positive", 0.02),
            ("viscous_negative", 2e-4),
            ("viscous_positive", 2e-4),
        ] {
            of_friction += parameter(name, truth);
        }
        for point in fit["characteristics"][0]["points"].as_array().unwrap() {
            if point["ci95"].is_array() {
                points[1] += 1.0;
                let truth = dome_force_n(point["at"].as_f64().unwrap());
                points[0] += f64::from(u8::from(holds(&point["ci95"], truth)));
            }
        }
    }
    // Of 12 intervals of 95 % more than three miss once in 2000 times.
    assert!(of_mass >= SEEDS - 3, "{of_mass} of {SEEDS}");
    assert!(of_friction >= 4 * SEEDS - 7, "{of_friction} of {}", 4 * SEEDS);
    assert!(points[0] > 0.88 * points[1], "{points:?}");
}

#[test]
fn what_is_pressed_or_slid_is_rendered_and_verified_as_knobs_are() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::write(folder.join("button.toml"), BUTTON).unwrap();
    std::fs::write(folder.join("slider.toml"), SLIDER).unwrap();
    for model in ["dome --nearest --seed 1", "dome --nearest --seed 2", "button.toml", "slider.toml"] {
        let output = call(folder, &format!("replay {model} --apparatus sim-linear --verify --offline --out ver"));
        let printed = words(&output);
        assert!(output.status.success(), "{model}: {printed}");
        assert!(!printed.contains("mNm") && !printed.contains("knob"), "{model}: {printed}");
    }
    // The plunger of the rig alone weighs more than the dome's.
    let output = call(folder, "replay dome --apparatus sim-linear --verify --offline --out ver");
    let printed = words(&output);
    assert_eq!(output.status.code(), Some(1), "{printed}");
    assert!(printed.contains("0.000004 N·s²/mm") && printed.contains("5.000e-5"), "{printed}");
}

#[test]
fn whatever_is_said_of_a_linear_axis_is_in_its_words_and_units() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::write(folder.join("slider.toml"), SLIDER).unwrap();
    for (sweep, name) in [("linear-chirp", "sweep"), ("stepped-amplitude", "heldout")] {
        let arguments = "capture --apparatus sim-linear --knob slider.toml --duration-s 4 --offline --no-viewer";
        done(folder, &format!("{arguments} --sweep {sweep} --out {name}"));
    }
    done(folder, "replay slider.toml --apparatus sim-linear --offline --duration-s 1 --out felt");
    let [sweep, heldout, felt] =
        ["sweep", "heldout", "felt"].map(|name| only(&folder.join(name), "mcap").display().to_string());
    let said = [
        format!("check {sweep} --model slider.toml --json check.json"),
        format!(
            "diagnose {sweep} --heldout {heldout} --json diagnosis.json --report diagnosis.html --out diagnosed.toml"
        ),
        format!("compare {sweep} slider.toml dome"),
        format!("simulate slider.toml --like {sweep}"),
        "compose --inertia slider.toml --friction slider.toml --detents slider.toml --out composed.toml".to_owned(),
        "export dome --out dome.h".to_owned(),
        "calibrate friction --apparatus sim-linear --offline --out friction.toml".to_owned(),
        "calibrate latency --apparatus sim-linear --offline --out latency.toml".to_owned(),
        "rig-test --apparatus sim-linear --offline --json rig-test.json --report rig-test.html".to_owned(),
        "table sweep --out table.parquet".to_owned(),
        "trend table.parquet --json trend.json --report trend.html".to_owned(),
        format!("recompute {felt} --json recomputed.json"),
    ];
    for arguments in &said {
        let output = call(folder, arguments);
        let printed = words(&output);
        assert!(output.status.success(), "{arguments}: {printed}");
        let foreign = ["mNm", "torque", "angle", "rad/s", "°"].into_iter().find(|word| printed.contains(word));
        assert_eq!(foreign, None, "{arguments}: {printed}");
    }
    for file in [
        "check.json",
        "diagnosis.json",
        "diagnosis.html",
        "composed.toml",
        "diagnosed.toml",
        "dome.h",
        "friction.toml",
        "rig-test.html",
        "trend.html",
        "recomputed.json",
    ] {
        let text = std::fs::read_to_string(folder.join(file)).unwrap();
        assert!(!text.to_lowercase().contains("mnm"), "{file}: {text}");
    }
    let header = std::fs::read_to_string(folder.join("dome.h")).unwrap();
    assert!(
        header.contains("DOME_BOTTOM_TRAVEL_MM 3.3f") && header.contains("dome_force_at_n(float travel_mm)"),
        "{header}"
    );
    let number = |text: &str, key: &str| -> f64 {
        let line = text.lines().find(|line| line.starts_with(key)).unwrap();
        line.rsplit("= ").next().unwrap().parse().unwrap()
    };
    let calibration = std::fs::read_to_string(folder.join("latency.toml")).unwrap();
    assert!((number(&calibration, "command_delay_s") - 53e-6).abs() < 8e-6, "{calibration}");
    let rig_test = json(&folder.join("rig-test.json"));
    for lag in rig_test["lag_at_30_hz"].as_array().unwrap() {
        assert!(lag["phase_rad"].as_f64().unwrap().abs() < 0.5, "{lag}");
        assert!((lag["gain"].as_f64().unwrap() - 1.0).abs() < 0.1, "{lag}");
    }
    let trend = json(&folder.join("trend.json"));
    let parameters = trend["groups"][0]["parameters"].as_array().unwrap();
    let unit = |name: &str| &parameters.iter().find(|one| one["name"] == name).unwrap()["unit"];
    assert_eq!((unit("inertia"), unit("coulomb_negative")), (&"N s²/mm".into(), &"N".into()));
    let list = words(&call(folder, "list sweep"));
    assert!(list.contains("mNm or N") && !list.lines().nth(1).unwrap().contains(" - "), "{list}");
    let output = call(folder, "calibrate gravity --apparatus sim-linear --offline --out gravity.toml");
    assert!(words(&output).contains("calibrate zero"), "{}", words(&output));
}

#[test]
fn what_is_only_for_a_rotary_axis_is_refused_with_what_to_do_instead() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let robot = "<mujoco><worldbody><body><joint name=\"key\"/></body></worldbody></mujoco>";
    std::fs::write(folder.join("robot.xml"), robot).unwrap();
    done(folder, "capture --apparatus sim-linear --duration-s 4 --offline --no-viewer --out pressed");
    done(folder, "capture --knob 3 --duration-s 4 --offline --no-viewer --out turned");
    let pressed = only(&folder.join("pressed"), "mcap").display().to_string();
    for line in [
        "export dome --out dome.xml",
        "export dome --out dome.urdf",
        "export dome --out dome.json --motor-mnm-per-v 10",
        &format!("fit {pressed} --into robot.xml"),
    ] {
        let said = refused(folder, line);
        assert!(said.contains("has a linear axis") && said.ends_with("export its force over travel as .csv"), "{said}");
    }
    assert_eq!(std::fs::read_to_string(folder.join("robot.xml")).unwrap(), robot);
}

#[test]
fn the_contact_of_a_dome_is_in_the_archive_and_in_its_sheet_and_may_fail_a_unit() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let capture = "capture --apparatus sim-linear --sweep slow-turn --duration-s 45 --offline --no-viewer --out cap";
    done(folder, capture);
    let archive = only(&folder.join("cap"), "mcap").display().to_string();
    let sheet = call(folder, &format!("sheet {archive} --json sheet.json"));
    assert!(sheet.status.success(), "{}", words(&sheet));
    let told = json(&folder.join("sheet.json"));
    // As the rig's file has it.
    let truths = [
        ("contact_closing_travel", 3.1),
        ("contact_opening_travel", 2.9),
        ("contact_hysteresis", 0.2),
        ("contact_closing_bounce", 1.2),
        ("contact_opening_bounce", 0.8),
    ];
    for (name, truth) in truths {
        let [low, high] = [0, 1].map(|end| told["figures"][name]["ci95"][end].as_f64().unwrap());
        assert!((low..=high).contains(&truth) && high - low < 0.5 * truth, "{name}: {low} to {high}");
    }
    assert_eq!(told["presses"].as_array().unwrap().len(), 3);
    std::fs::write(folder.join("spec.toml"), "[figures.contact_closing_bounce]\nmax = 0.5\nunit = \"ms\"\n").unwrap();
    let judged = call(folder, &format!("judge {archive} --spec spec.toml"));
    assert_eq!(judged.status.code(), Some(4), "{}", words(&judged));
}

#[test]
fn a_unit_is_turned_until_its_verdict_is_certain() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::write(folder.join("wide.toml"), "[figures.collapse_force]\nmin = 0.3\nmax = 0.8\n").unwrap();
    std::fs::write(folder.join("low.toml"), "[figures.collapse_force]\nmax = 0.3\n").unwrap();
    for (spec, status) in [("wide.toml", 0), ("low.toml", 4)] {
        let output =
            call(folder, &format!("capture --apparatus sim-linear --spec {spec} --offline --no-viewer --out out"));
        assert_eq!(output.status.code(), Some(status), "{}", words(&output));
        assert!(words(&output).contains("after the first slow turn"), "{}", words(&output));
    }
}

#[test]
fn a_diagnosis_starts_from_the_curve_that_was_measured_and_names_what_hides_beside_it() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let drag = "[[effects]]\neffect = \"quadratic-drag\"\ndrag_coefficient = 4e-6\n";
    for (name, model, hidden) in
        [("bare", BUTTON.to_owned(), &[][..]), ("dragged", format!("{BUTTON}{drag}"), &["quadratic-drag"][..])]
    {
        std::fs::write(folder.join(format!("{name}.toml")), model).unwrap();
        for (sweep, seed) in [("linear-chirp", 1), ("multisine", 2)] {
            let arguments = "--apparatus sim-linear --duration-s 6 --offline --no-viewer";
            let command =
                format!("capture {arguments} --knob {name}.toml --sweep {sweep} --seed {seed} --out {name}-{seed}");
            done(folder, &command);
        }
        let [train, heldout] = [1, 2].map(|seed| only(&folder.join(format!("{name}-{seed}")), "mcap"));
        let command = format!("diagnose {} --heldout {} --json {name}.json", train.display(), heldout.display());
        let said = done(folder, &command);
        let found = json(&folder.join(format!("{name}.json")));
        assert_eq!(found["effects"], serde_json::json!(hidden), "{said}");
        assert_eq!(found["complete"], true, "{said}");
    }
}
