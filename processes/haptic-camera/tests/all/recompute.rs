//! `recompute`: a replay's torques from what its archive recorded.

use std::path::{Path, PathBuf};

use crate::program::{call, done, errors, only};
use archive::Capture;
use serde_json::Value;

/// A replay without a clock; its archive.
fn replayed(folder: &Path, arguments: &str) -> PathBuf {
    done(folder, &format!("replay --offline --out {arguments}"));
    only(&folder.join(arguments.split_whitespace().next().unwrap()), "mcap")
}

/// Exit status and JSON of `recompute`.
fn recomputed(folder: &Path, archive: &Path) -> (Option<i32>, Value) {
    let output = call(folder, &format!("recompute {} --json -", archive.display()));
    let json = serde_json::from_slice(&output.stdout);
    (output.status.code(), json.unwrap_or_else(|_| panic!("{}", errors(&output))))
}

#[test]
fn an_archive_that_was_not_touched_gives_the_same_torques_and_one_that_was_does_not() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let hand = "--hand multisine --grip 6 --duration-s 2 --motor-cogging 48:1.5";
    let archive = replayed(folder, &format!("one 3 {hand} --rate-hz 7919.3"));
    let (status, json) = recomputed(folder, &archive);
    assert_eq!((status, &json["equal"], &json["first_difference"]), (Some(0), &Value::Bool(true), &Value::Null));
    assert_eq!(json["ticks"], 15_839);

    let whole = Capture::load(&archive).unwrap();
    let tampered = |name: &str, change: &dyn Fn(&mut Capture)| {
        let mut capture = whole.clone();
        change(&mut capture);
        let path = folder.join(name);
        capture.write_mcap(&path).unwrap();
        recomputed(folder, &path)
    };
    // Written again as it is, it is still the same.
    assert_eq!(tampered("same.mcap", &|_| ()).0, Some(0));
    // The last bit of one command.
    let (status, json) = tampered("command.mcap", &|capture| {
        let command_mnm = &mut capture.commanded_torque_mnm.as_mut().unwrap()[9_000];
        *command_mnm = command_mnm.next_up();
    });
    assert_eq!(
        (status, &json["first_difference"]["tick"], &json["different_ticks"]),
        (Some(1), &9_000.into(), &1.into())
    );
    // A step of the encoder: its torque differs, and what follows from it.
    let (status, json) = tampered("angle.mcap", &|capture| capture.angle_rad[9_000] += 9.8e-6);
    assert_eq!((status, &json["first_difference"]["tick"]), (Some(1), &9_000.into()));
    assert!(json["different_ticks"].as_u64().unwrap() > 1);
    // Another calibration, another model.
    let (status, json) = tampered("calibration.mcap", &|capture| {
        let run = capture.description.as_mut().unwrap();
        run.calibration_toml = run.calibration_toml.replace("torque_zero_mnm = 0.6", "torque_zero_mnm = 0.7");
    });
    assert_eq!((status, &json["first_difference"]["tick"]), (Some(1), &0.into()));
    // A sample that is not there: up to it all is well, and data was lost.
    let (status, json) = tampered("lost.mcap", &|capture| {
        for seq in &mut capture.seq[12_000..] {
            *seq += 1;
        }
    });
    assert_eq!((status, &json["missing_from_sample"], &json["ticks"]), (Some(3), &12_000.into(), &12_000.into()));
}

#[test]
fn what_cannot_be_computed_again_is_refused_in_one_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let refused = |arguments: &str, expected: &str| {
        let said = crate::program::refused(folder, arguments);
        assert!(said.contains(expected), "'{expected}' is missing in: {said}");
    };
    let archive = replayed(folder, "one 4 --duration-s 0.1");
    std::fs::write(folder.join("table.csv"), "t_s,angle_rad,torque_mnm\n0,1,1\n0.1,1,1\n0.2,1,1\n").unwrap();
    refused("recompute table.csv", "only the archive of a replay");
    let whole = Capture::load(&archive).unwrap();
    let older = |name: &str, change: &dyn Fn(&mut Capture)| {
        let mut capture = whole.clone();
        change(&mut capture);
        capture.write_mcap(&folder.join(name)).unwrap();
    };
    older("older.mcap", &|capture| capture.description.as_mut().unwrap().control_toml = None);
    refused("recompute older.mcap", "does not record its gains");
    older("sweep.mcap", &|capture| capture.description.as_mut().unwrap().rendered_model_toml = None);
    refused("recompute sweep.mcap", "only a replay");
    older("model.mcap", &|capture| capture.flags.as_mut().unwrap()[500] |= shared_types::Sample::MODEL_TAKEN);
    refused("recompute model.mcap", "is rendered from tick 500 on");
}
