//! `sheet`, `judge`, `capability` and `gauge` as a user calls them.

use std::fmt::Write as _;

use crate::program::{call, done, only, refused, words};

/// A press of a made-up dome with its collapse at 1 mm, and its return: travel in mm, force in gf.
fn dome(collapse_gf: f64) -> String {
    let mut text = "Millis,Steps,Travel (mm),Scale raw,Scale (grams)\n".to_owned();
    let force = |travel: f64| {
        let bump = collapse_gf * (-((travel - 1.0) / 0.8).powi(2)).exp();
        let wall = (travel - 3.0).max(0.0).powi(2) * 2000.0;
        5.0 * travel + bump + wall
    };
    for row in 0..1400 {
        let steps = if row < 700 { row } else { 1399 - row };
        let travel = 0.005 * f64::from(steps);
        let noise = 0.05 * (f64::from(row) * 12.9898).sin();
        let friction = if row < 700 { 0.0 } else { -3.0 };
        writeln!(text, "{},{},{travel:.4},0,{:.4}", 34 * row, 8 * steps, force(travel) + noise + friction).unwrap();
    }
    text
}

#[test]
fn a_dome_has_its_sheet_as_table_json_csv_and_page() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("dome")).unwrap();
    for run in 1..4 {
        std::fs::write(folder.path().join(format!("dome/DataLog_{run}.csv")), dome(60.0 + f64::from(run))).unwrap();
    }
    let sheet = "sheet dome --json s.json --csv s.csv --report s.html";
    let printed = done(folder.path(), sheet);
    assert!(printed.starts_with("mean of 3 curves of dome, 95 % prediction intervals for another one"), "{printed}");
    assert!(printed.lines().take(18).all(|line| line.chars().count() <= 80), "{printed}");
    let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
    let json: serde_json::Value = serde_json::from_str(&read("s.json")).unwrap();
    let collapse = &json["figures"]["collapse_force"];
    // 62 gf of bump and 5 gf of slope.
    let force_n = collapse["value"].as_f64().unwrap();
    assert!((force_n - 67.1 * 9.806_65e-3).abs() < 0.005, "{force_n}");
    assert_eq!(collapse["unit"], "N");
    assert!(collapse["definition"].as_str().unwrap().starts_with("Force at the most prominent local maximum"));
    assert!(json["curve"]["press"]["travel_mm"].as_array().unwrap().len() > 600);
    assert!(json["detents"].as_array().unwrap().is_empty());
    assert!(
        read("s.csv")
            .starts_with("figure,angle_rad,direction,value,unit,ci95_low,ci95_high,definition\ncollapse_force,,,0.6")
    );
    assert!(read("s.html").contains("Force over travel as measured"));
    // What was written before may be written again.
    done(folder.path(), sheet);
}

/// Seven and a half radians of a made-up knob there and back: angle in rad, torque in mNm.
fn knob(friction_mnm: f64) -> String {
    let mut text = "angle_rad,torque_mnm\n".to_owned();
    for row in 0..16_000 {
        let (way, step) = if row < 8_000 { (1.0, row) } else { (-1.0, 15_999 - row) };
        let angle_rad = 7.5 * f64::from(step) / 8_000.0;
        let noise = 0.05 * (f64::from(row) * 12.9898).sin();
        writeln!(text, "{angle_rad},{}", 5.0 * (12.0 * angle_rad).sin() + way * friction_mnm + noise).unwrap();
    }
    text
}

#[test]
fn a_folder_stands_for_the_captures_in_it_and_for_nothing_that_was_made_of_them() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    done(folder, "capture --knob 3 --sweep slow-turn --duration-s 20 --rate-hz 5000 --offline --no-viewer --out made");
    let archive = only(&folder.join("made"), "mcap");
    let table = archive.with_extension("csv");
    done(folder, &format!("export {} --out {}", archive.display(), table.display()));
    let runs = || -> serde_json::Value {
        let sheet: serde_json::Value = serde_json::from_str(&done(folder, "sheet made --json -")).unwrap();
        sheet["runs"].clone()
    };
    assert_eq!(runs(), 1);
    std::fs::remove_file(&archive).unwrap();
    std::fs::rename(&table, table.with_extension("CSV")).unwrap();
    assert_eq!(runs(), 1);
    assert!(done(folder, "table made --out table.parquet").contains("table.parquet: 1 captures"));
}

#[test]
fn verdicts_are_exit_statuses_and_one_line_a_unit() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write("good.csv", &dome(60.0));
    write("weak.csv", &dome(40.0));
    write("spec.toml", "name = \"dome\"\n[figures.collapse_force]\nmin = 55\nmax = 75\nunit = \"gf\"\n");
    let judge = |units: &str, spec: &str| {
        let output = call(folder.path(), &format!("judge {units} --spec {spec} --report j.html"));
        (output.status.code().unwrap(), words(&output))
    };
    assert_eq!(judge("good.csv", "spec.toml"), (0, "pass       good.csv\n".to_owned()));
    let (status, printed) = judge("good.csv weak.csv", "spec.toml");
    assert_eq!((status, printed.lines().count()), (4, 2), "{printed}");
    assert!(
        printed.contains("fail       weak.csv: collapse_force 0.44243 N (")
            && printed.contains("is outside 0.5394 to 0.7355 N")
    );
    let json: serde_json::Value = serde_json::from_str(&done(folder.path(), "sheet good.csv --json -")).unwrap();
    write("edge.toml", &format!("[figures.collapse_force]\nmin = {}\n", json["figures"]["collapse_force"]["value"]));
    let (status, printed) = judge("good.csv", "edge.toml");
    assert!(status == 5 && printed.starts_with("undecided  good.csv: collapse_force"), "{printed}");
    let (status, printed) = judge("good.csv", "good.csv");
    assert!(status == 1 && printed.contains("good.csv is no specification"), "{printed}");
    let (status, printed) = judge("spec.toml", "spec.toml");
    assert!(status == 1 && printed.lines().count() == 1, "{printed}");
}

#[test]
fn capability_and_gauge_take_captures_and_tables() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write("spec.toml", "[figures.collapse_force]\nmin = 50\nmax = 80\nunit = \"gf\"\n");
    for part in 0..3 {
        for operator in ["A", "B"] {
            let cell = format!("study/{part}/{operator}");
            std::fs::create_dir_all(folder.path().join(&cell)).unwrap();
            for trial in 0..2 {
                let off = if operator == "A" { 0.2 } else { -0.2 } + 0.1 * f64::from(trial);
                write(&format!("{cell}/{trial}.csv"), &dome(55.0 + 5.0 * f64::from(part) + off));
            }
        }
    }
    let captures: Vec<String> =
        (0..3).flat_map(|part| ["A", "B"].map(|operator| format!("study/{part}/{operator}"))).collect();
    let captures = captures.join(" ");
    let said = done(folder.path(), &format!("gauge {captures} --spec spec.toml"));
    assert!(said.contains("2 operators, 3 parts, 2 trials"), "{said}");
    let said = done(folder.path(), &format!("capability {captures} --spec spec.toml --dfq d.dfq --json -"));
    let json: serde_json::Value = serde_json::from_str(&said).unwrap();
    assert_eq!(json["collapse_force"]["number"], 12, "{said}");
    assert!(std::fs::read_to_string(folder.path().join("d.dfq")).unwrap().contains("K2002/1 collapse_force"));
    let rows = (0..12).fold("part,operator,value\n".to_owned(), |mut text, row| {
        writeln!(text, "{},{},{}", row / 4, row / 2 % 2, f64::from(row / 4) + 0.1 * f64::from(row % 2)).unwrap();
        text
    });
    write("values.csv", &rows);
    let said = done(folder.path(), "gauge --values values.csv --figure peak_torque");
    assert!(said.contains("peak_torque: %GRR "), "{said}");
    let named = (0..12).fold("part,operator,value\n".to_owned(), |mut text, row| {
        let (part, operator) = (["a 1", "b 2", "c 3"][row / 4], ["Anna", "\"Ben, jun.\""][row / 2 % 2]);
        writeln!(text, "{part},{operator},{}", (row / 4) as f64 + 0.1 * (row % 2) as f64).unwrap();
        text
    });
    write("named.csv", &named);
    assert_eq!(done(folder.path(), "gauge --values named.csv --figure peak_torque"), said);
    write("words.csv", &named.replace("Anna,0\n", "Anna,none\n"));
    let refusal = refused(folder.path(), "gauge --values words.csv --figure peak_torque");
    assert!(refusal.contains("`none` in the column value is not a number"), "{refusal}");
    let output = call(folder.path(), "gauge --values values.csv --figure peak");
    assert!(!output.status.success() && words(&output).contains("`peak` is not a figure"), "{}", words(&output));
}

#[test]
fn a_figure_that_turned_and_pressed_controls_share_is_that_of_the_captures() {
    let folder = tempfile::tempdir().unwrap();
    let frictions_mnm = [3.0, 3.1, 2.9, 3.05];
    for (number, friction_mnm) in frictions_mnm.into_iter().enumerate() {
        std::fs::write(folder.path().join(format!("{number}.csv")), knob(friction_mnm)).unwrap();
    }
    std::fs::write(folder.path().join("spec.toml"), "[figures.hysteresis_energy]\nmax = 60\n").unwrap();
    let line = "capability 0.csv 1.csv 2.csv 3.csv --figure hysteresis_energy --spec spec.toml --json -";
    let json: serde_json::Value = serde_json::from_str(&done(folder.path(), line)).unwrap();
    let mean_mj = json["hysteresis_energy"]["mean"].as_f64().unwrap();
    // Both ways round a turn.
    let expected_mj = 2.0 * std::f64::consts::TAU * frictions_mnm.iter().sum::<f64>() / 4.0;
    assert!((mean_mj - expected_mj).abs() < 0.2, "{mean_mj} instead of {expected_mj}");
}

#[test]
fn the_wall_has_the_papers_knobs_and_those_of_smartknob() {
    let folder = tempfile::tempdir().unwrap();
    done(folder.path(), "sheet --wall wall.html");
    let page = std::fs::read_to_string(folder.path().join("wall.html")).unwrap();
    assert_eq!(page.matches("<svg").count(), 15);
    assert!(page.contains("Knob 5") && page.contains("Coarse values, magnetic detents"));
}
