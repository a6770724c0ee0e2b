//! Writes what the fuzzer begins with, `$SEEDS/TARGET/...`, and fuzzes nothing.
//!
//! It is a fuzz target since everything here is built with the fuzzer's instrumentation, and linked with it.
#![no_main]

use std::io::Cursor;
use std::path::Path;

use archive::CaptureWriter;
use dynamics::excitation::Shape;
use dynamics::{Drive, Excitation, knobs};
use shared_types::wire::WireMessage;
use shared_types::{
    ClockMapping, FitUpdate, LoopStatus, ModelAnswer, ModelChange, ProcessHealth, RunDescription, Sample,
};

libfuzzer_sys::fuzz_target!(init: write_seeds().expect("a place for the seeds"), |_input: &[u8]| {});

fn write_seeds() -> std::io::Result<()> {
    let folder = std::env::var_os("SEEDS").expect("SEEDS names a folder");
    let seed = |target: &str, name: &str, content: &[u8]| {
        let place = Path::new(&folder).join(target);
        std::fs::create_dir_all(&place)?;
        std::fs::write(place.join(name), content)
    };
    for number in 1..=5 {
        let model = knobs::paper_knob(number).expect("a shipped knob").to_toml();
        for target in ["model", "rendering"] {
            seed(target, &format!("knob-{number}"), model.as_bytes())?;
        }
    }
    seed("model", "every-effect", every_effect().as_bytes())?;
    let hold = Excitation { drive: Drive::Position, amplitude: 0.5, is_one_sided: false, shape: Shape::Hold };
    seed("rig_files", "hold", toml::to_string(&hold).expect("TOML").as_bytes())?;
    let run = description();
    seed("rig_files", "calibration", run.calibration_toml.as_bytes())?;
    seed("rig_files", "excitation", run.excitation_toml.as_bytes())?;
    let sweep: Vec<u8> = [1e-4_f64, 2.0, 5.0].into_iter().flat_map(f64::to_le_bytes).collect();
    seed("analysis", "sweep", &sweep)?;
    let pause = [&[0, 44, 1, 255], &0.3_f64.to_le_bytes()[..]].concat();
    seed("analysis", "pause", &[sweep, pause].concat())?;
    seed("torque_table", "table", b"angle_rad,torque_mnm\n0,0\n0.1,5\n0.2,-5e0\n0.3,0\n")?;
    let table =
        b"t_s,angle_rad,velocity_rad_s,acceleration_rad_s2,torque_mnm\n0,0,1,2,3\n1e-4,1,1,2,3\n2e-4,2,1,2,-3.5\n";
    seed("capture_file", "table", table)?;
    let whole = recording(&run);
    seed("capture_file", "archive", &whole)?;
    seed("capture_file", "cut-off", &whole[..whole.len() * 2 / 3])?;
    for (name, is_deflated) in [("plain", false), ("deflated", true)] {
        seed("measurement", name, &measurement(is_deflated)[8..])?;
    }
    // The records of the chunks, as the target of that name takes them.
    for (number, chunk) in chunks(&whole).into_iter().enumerate() {
        seed("archive_chunk", &format!("chunk-{number}"), &chunk)?;
    }
    seed("messages", "schema", format!("\0{}", Sample::schema_text()).as_bytes())?;
    let mut change = vec![1];
    change.extend(model_change().cdr_body());
    seed("messages", "model-change", &change)?;
    for (number, json) in [
        serde_json::to_vec(&run).expect("JSON"),
        serde_json::to_vec(&model_change()).expect("JSON"),
        serde_json::to_vec(&ModelAnswer::Refused { reason: "no".to_owned() }).expect("JSON"),
    ]
    .into_iter()
    .enumerate()
    {
        seed("messages", &format!("json-{number}"), &[&[2], &json[..]].concat())?;
    }
    seed("messages", "status", &[&[3], LoopStatus::default().wire_bytes()].concat())?;
    Ok(())
}

/// A model with one of each effect, at the middle of what each parameter may be.
fn every_effect() -> String {
    dynamics::effects::ALL
        .iter()
        .map(|kind| {
            let parameters: String =
                kind.parameters.iter().map(|parameter| format!("{} = 0.5\n", parameter.name)).collect();
            format!("[[effects]]\neffect = \"{}\"\n{parameters}", kind.name)
        })
        .collect()
}

fn model_change() -> ModelChange {
    let model_toml = knobs::paper_knob(3).expect("a shipped knob").to_toml();
    ModelChange { run_id: 5, tick: 7, monotonic_time_ns: 9, model_toml }
}

/// As the control loop would describe a short run of the simulated rig.
fn description() -> RunDescription {
    // A torque: with the fuzzer's instrumentation the compiler gets the check of the servo wrong, which is sound without.
    let options =
        <rt_loop::request::Options as clap::Parser>::try_parse_from(["rt-loop", "--duration-s=1", "--torque"]);
    let plan = rt_loop::plan::Plan::new(&options.expect("options").into()).expect("a plan");
    RunDescription {
        run_id: 5,
        clock: ClockMapping { monotonic_time_ns: 1, wall_clock_time_ns: 1_700_000_000_000_000_000 },
        ..plan.description().expect("a description")
    }
}

fn recording(run: &RunDescription) -> Vec<u8> {
    let mut writer = CaptureWriter::new(Cursor::new(Vec::new()), run).expect("memory");
    for seq in 0..12 {
        writer.sample(&Sample { seq, tick: seq + seq / 5, angle_rad: 0.1, ..Sample::default() }).expect("memory");
        if seq == 5 {
            writer.status(&LoopStatus::default()).expect("memory");
            writer.fit(&FitUpdate::default()).expect("memory");
            writer.health(&ProcessHealth::default()).expect("memory");
            writer.model(&model_change()).expect("memory");
            writer.flush().expect("memory");
        }
    }
    writer.finish().expect("memory").1.into_inner()
}

/// A measurement whose second group has angle and torque, its records among those of the first.
fn measurement(is_deflated: bool) -> Vec<u8> {
    let times: Vec<f64> = (0..40).map(|row| 1e-3 * f64::from(row)).collect();
    let mut file = falcon_mdf::Mf4Writer::new();
    file.set_compression(is_deflated);
    file.add_group(&times[..9]).and_then(|group| group.add_channel("Temp", "degC", &times[..9])).expect("a group");
    let group = file.add_group_in(0, &times).expect("a group");
    for (name, unit) in [("Angle", "deg"), ("Torque", "Nm")] {
        group.add_channel(name, unit, &times).expect("a channel");
    }
    let mut whole = Vec::new();
    file.write(&mut whole).expect("memory");
    whole
}

/// The uncompressed records of every chunk.
fn chunks(file: &[u8]) -> Vec<Vec<u8>> {
    let mut chunks = Vec::new();
    let mut reader = mcap::sans_io::LinearReader::new();
    let mut rest = file;
    let mut records = Vec::new();
    while let Some(event) = reader.next_event() {
        match event.expect("a sound file") {
            mcap::sans_io::LinearReadEvent::ReadRequest(need) => {
                let length = need.min(rest.len());
                reader.insert(length).copy_from_slice(&rest[..length]);
                reader.notify_read(length);
                rest = &rest[length..];
            }
            mcap::sans_io::LinearReadEvent::Record { data, opcode } => match opcode {
                mcap::records::op::SCHEMA | mcap::records::op::CHANNEL | mcap::records::op::MESSAGE => {
                    records.push(opcode);
                    records.extend((data.len() as u64).to_le_bytes());
                    records.extend_from_slice(data);
                }
                mcap::records::op::MESSAGE_INDEX if !records.is_empty() => chunks.push(std::mem::take(&mut records)),
                mcap::records::op::DATA_END => break,
                _ => {}
            },
        }
    }
    chunks
}
