//! Capability and gauge studies beside those of others, and Q-DAS files read by others.
//!
//! The others are Python packages that `scripts/set-up tests` installs; `HAPTIC_CAMERA_PYTHON` names their interpreter.
#![allow(clippy::unwrap_used, reason = "a test may stop at a failure")]

use std::path::Path;
use std::process::Command;

use sheet::{Capability, Design, Gauge, Limits, QdasRow, kinds, qdas};

/// What a Python program prints as JSON; `None` where its packages are not at hand, which is said.
#[allow(clippy::print_stderr, reason = "a test that skips says so")]
fn python(program: &str, arguments: &[&str]) -> Option<serde_json::Value> {
    let interpreter = std::env::var_os("HAPTIC_CAMERA_PYTHON")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../target/python/bin/python"), Into::into);
    let has = |package: &str| {
        let found = Command::new(&interpreter).args(["-c", &format!("import {package}")]).output();
        found.is_ok_and(|output| output.status.success())
    };
    if !has("capstat_core") || !has("aqdefreader") {
        eprintln!("skipped: {} lacks capstat-core or aqdefreader; run scripts/set-up tests", interpreter.display());
        return None;
    }
    let output = Command::new(interpreter).args(["-c", program]).args(arguments).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    // The last line; the packages print words of their own before.
    let printed = String::from_utf8(output.stdout).unwrap();
    Some(serde_json::from_str(printed.lines().last().unwrap()).unwrap())
}

fn assert_same(what: &str, found: f64, expected: &serde_json::Value) {
    let expected = expected.as_f64().unwrap();
    assert!((found - expected).abs() <= 1e-9 * expected.abs().max(1.0), "{what}: {found} instead of {expected}");
}

/// Values that are even and yet irregular, about `middle`.
fn values(number: usize, middle: f64) -> Vec<f64> {
    (1..=number).map(|index| middle + (index as f64 * 0.618_034).fract() - 0.5 + 0.1 * (index as f64).sin()).collect()
}

#[test]
fn capability_is_that_of_capstat() {
    // Piston-ring diameters, mm: the first ten subgroups of table 6.3 in D. C. Montgomery's Introduction to Statistical Quality
    // Control, which capstat takes as its example too.
    let rings = [
        74.030, 74.002, 74.019, 73.992, 74.008, 73.995, 73.992, 74.001, 74.011, 74.004, 73.988, 74.024, 74.021, 74.005,
        74.002, 74.002, 73.996, 73.993, 74.015, 74.009, 73.992, 74.007, 74.015, 73.989, 74.014, 74.009, 73.994, 73.997,
        73.985, 73.993, 73.995, 74.006, 73.994, 74.000, 74.005, 73.985, 74.003, 73.993, 74.015, 73.988, 74.008, 73.995,
        74.009, 74.005, 74.004, 73.998, 74.000, 73.990, 74.007, 73.995,
    ];
    for (values, subgroup, min, max) in
        [(rings.to_vec(), 5, 73.95, 74.05), (rings.to_vec(), 1, 73.95, 74.05), (values(24, 10.0), 3, 8.5, 11.0)]
    {
        let program = "import sys, json\nfrom capstat_core.capability import capability\n\
            values, size, low, high = json.loads(sys.argv[1])\n\
            data = values if size == 1 else [values[at:at + size] for at in range(0, len(values), size)]\n\
            result = capability(data, lsl=low, usl=high)\n\
            names = ['mean', 'sigma_within', 'sigma_overall', 'cp', 'cpk', 'pp', 'ppk']\n\
            print(json.dumps({name: getattr(result, name) for name in names}))";
        let argument = serde_json::to_string(&(&values, subgroup, min, max)).unwrap();
        let Some(expected) = python(program, &[&argument]) else { return };
        let found = Capability::of(&values, subgroup, Limits { min: Some(min), max: Some(max) }).unwrap();
        for (what, value) in [
            ("mean", found.mean),
            ("sigma_within", found.deviation_within),
            ("sigma_overall", found.deviation_overall),
            ("cp", found.cp.unwrap().value),
            ("cpk", found.cpk.value),
            ("pp", found.pp.unwrap().value),
            ("ppk", found.ppk.value),
        ] {
            assert_same(what, value, &expected[what]);
        }
    }
}

#[test]
fn intervals_of_capability_hold_it_in_95_percent_of_processes() {
    use rand_xoshiro::rand_core::{RngCore as _, SeedableRng as _};
    let mut generator = rand_xoshiro::Xoshiro256PlusPlus::seed_from_u64(3);
    // A sum of twelve even values is near enough to a normal one.
    let mut normal = || (0..12).map(|_| generator.next_u64() as f64 / u64::MAX as f64).sum::<f64>() - 6.0;
    let limits = Limits { min: Some(-4.0), max: Some(3.0) };
    let (mut held, runs) = ([0_u32; 4], 1000);
    for _ in 0..runs {
        let values: Vec<f64> = (0..50).map(|_| normal()).collect();
        let result = Capability::of(&values, 5, limits).unwrap();
        let single = Capability::of(&values, 1, limits).unwrap();
        let indices = [result.cp.unwrap(), result.cpk, result.ppk, single.cpk];
        for ((held, index), truth) in held.iter_mut().zip(indices).zip([7.0 / 6.0, 1.0, 1.0, 1.0]) {
            *held += u32::from((index.ci95[0]..=index.ci95[1]).contains(&truth));
        }
    }
    assert!(held.iter().all(|held| (0.925..=0.975).contains(&(f64::from(*held) / f64::from(runs)))), "{held:?}");
}

#[test]
fn a_crossed_gauge_study_is_that_of_capstat() {
    let program = "import sys, json, numpy\nfrom capstat_core.gage_rr import gage_rr\n\
        values, tolerance = json.loads(sys.argv[1])\n\
        result = gage_rr(numpy.transpose(values, (1, 0, 2)), tolerance=tolerance)\n\
        names = ['var_repeatability', 'var_operator', 'var_interaction', 'var_part', 'pct_study_var_gage_rr',\n\
                 'pct_tolerance_gage_rr', 'interaction_pvalue', 'ndc']\n\
        print(json.dumps({name: getattr(result, name) for name in names}))";
    // The study of AIAG's manual: three operators, ten parts, three trials; and one with an interaction.
    for interaction in [0.0, 0.6] {
        let noise = values(90, 0.0);
        let study: Vec<Vec<Vec<f64>>> = (0..3)
            .map(|operator| {
                let of_part = |part: usize| {
                    let level = (part as f64 * 1.3).sin() + 0.2 * operator as f64;
                    let twist = interaction * ((part * (operator + 2)) as f64).cos();
                    (0..3).map(|trial| level + twist + 0.2 * noise[operator * 30 + part * 3 + trial]).collect()
                };
                (0..10).map(of_part).collect()
            })
            .collect();
        let Some(expected) = python(program, &[&serde_json::to_string(&(&study, 4.0)).unwrap()]) else { return };
        let found = Gauge::of(&study, Design::Crossed, Some(4.0)).unwrap();
        for (what, value) in [
            ("var_repeatability", found.repeatability_variance),
            ("var_operator", found.operator_variance),
            ("var_interaction", found.interaction_variance),
            ("var_part", found.part_variance),
            ("pct_study_var_gage_rr", found.grr_percent),
            ("pct_tolerance_gage_rr", found.grr_tolerance_percent.unwrap()),
            ("interaction_pvalue", found.interaction_p_value.unwrap()),
            ("ndc", found.ndc.unwrap() as f64),
        ] {
            assert_same(what, value, &expected[what]);
        }
        assert_eq!(found.interaction_variance > 0.0, interaction > 0.0);
    }
}

#[test]
fn a_nested_gauge_study_takes_each_operators_parts_for_their_own() {
    // Two operators with two parts each, two trials: mean squares by hand 50, 8.5 and 0.5.
    let study = vec![vec![vec![1.0, 2.0], vec![4.0, 5.0]], vec![vec![6.0, 7.0], vec![8.5, 10.5]]];
    let found = Gauge::of(&study, Design::Nested, None).unwrap();
    let error = (3.0 * 0.5 + 2.0) / 4.0;
    let parts = (9.0 + 9.0) / 2.0;
    let operators = 2.0 * 4.0 * 2.5_f64.powi(2);
    assert!((found.repeatability_variance - error).abs() < 1e-12, "{found:?}");
    assert!((found.part_variance - (parts - error) / 2.0).abs() < 1e-12, "{found:?}");
    assert!((found.operator_variance - (operators - parts) / 4.0).abs() < 1e-12, "{found:?}");
}

#[test]
fn a_qdas_file_opens_in_aqdefreader() {
    let kind = |name: &str| kinds().find(|kind| kind.name == name).unwrap();
    let characteristics = [
        (kind("collapse_force"), Limits { min: Some(0.5), max: Some(0.7) }),
        (kind("collapse_travel"), Limits { min: None, max: Some(1.3) }),
    ];
    let row = |second: u32, values: [Option<f64>; 2]| QdasRow {
        measured_at: format!("22.11.2026/09:30:{second:02}"),
        values: values.to_vec(),
    };
    let rows = [row(1, [Some(0.6167), Some(1.14)]), row(2, [Some(-0.25), None]), row(3, [Some(0.6), Some(1e-3)])];
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("domes.dfq");
    std::fs::write(&path, qdas("Dome", &characteristics, &rows)).unwrap();
    let program = "import sys, json\nfrom aqdefreader import read_dfq_file\n\
        part = read_dfq_file(sys.argv[1]).get_part(0)\n\
        result = [{'name': of.get_data('K2002'), 'unit': of.get_data('K2142'), 'max': of.get_data('K2111'),\n\
                 'values': [m.value for m in of.get_measurements()],\n\
                 'times': [m.datetime.isoformat() for m in of.get_measurements()]} for of in part.get_characteristics()]\n\
        print(json.dumps({'part': part.get_data('K1002'), 'characteristics': result}))";
    let Some(read) = python(program, &[path.to_str().unwrap()]) else { return };
    assert_eq!(read["part"], "Dome");
    let [force, travel] = [0, 1].map(|index| &read["characteristics"][index]);
    assert_eq!((&force["name"], &force["unit"]), (&"collapse_force".into(), &"N".into()));
    assert_eq!(force["values"], serde_json::json!([0.6167, -0.25, 0.6]));
    assert_eq!(travel["values"], serde_json::json!([1.14, 0.001]));
    assert_eq!(force["times"][1], "2026-11-22T09:30:02");
}
