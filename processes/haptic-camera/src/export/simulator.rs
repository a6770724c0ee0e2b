//! Models for simulators and for SmartKnob, and how much torque they leave out.

use anyhow::{Context as _, anyhow};
use archive::whole_file::write_bytes;
use dynamics::excitation::{Drive, Excitation};
use dynamics::{Model, Motion, knobs};
use serde_json::json;
use simulator_formats::{Export, SmartKnobExport, fmi, isaac_lab, left_out_mnm};

use super::ExportOptions;
use crate::command_line::outputs::{kind, write, write_json};
use crate::load;
use crate::outcome::UsageError;
use crate::supervision::program_path;

/// The library of the crate `knob-fmu`, which is built beside the programs.
const FMU_LIBRARY: &str = "libhaptic_knob.so";

/// Length and rate of the default sweep along which the omitted torque is computed, s and Hz.
const SWEEP_S: f64 = 6.0;
const SWEEP_HZ: f64 = 2_000.0;

/// Writes the file; gives what it leaves out, in words.
pub(super) fn write_export<Content: AsRef<[u8]>>(
    options: &ExportOptions,
    model: &Model,
    export: &Export<Content>,
) -> anyhow::Result<String> {
    let (motions, motion) = motion(options)?;
    write_bytes(&options.out, kind::SIMULATOR, export.content.as_ref())?;
    Ok(in_words(left_out_mnm(model, &export.said, &motions), &motion, &export.left_out))
}

fn in_words(left_out_mnm: f64, along: &str, left_out: &[String]) -> String {
    let mut words = format!("leaves out {left_out_mnm:.6} mNm RMS along {along}");
    words.extend(left_out.iter().map(|left_out| format!("\n- {left_out}")));
    words
}

/// The URDF, and beside it the fields of Isaac Lab's actuators, for which URDF has no place.
pub(super) fn urdf(model: &Model, options: &ExportOptions) -> anyhow::Result<String> {
    let words = write_export(options, model, &simulator_formats::urdf(model)?)?;
    let Some(beside) = options.isaac_lab() else { return Ok(words) };
    write(&beside, kind::JSON, &isaac_lab(model)?)?;
    let beside = beside.display();
    Ok(format!("{words}\n{beside}: armature and friction as Isaac Lab's ImplicitActuatorCfg takes them"))
}

pub(super) fn fmu(model: &Model, options: &ExportOptions) -> anyhow::Result<String> {
    let place = program_path(FMU_LIBRARY)?;
    let library = std::fs::read(&place).with_context(|| {
        format!("{} cannot be read; build it with `cargo build --release -p knob-fmu`", place.display())
    })?;
    write_export(options, model, &fmi::fmu(model, &library)?)
}

/// A model as SmartKnob's configuration, the message `SmartKnobConfig` of `proto/smartknob.proto` (github scottbez1/smartknob) in
/// protobuf's own JSON, and what it leaves out.
pub(super) fn smartknob(options: &ExportOptions) -> anyhow::Result<String> {
    let motor_mnm_per_v = options.motor_mnm_per_v.ok_or_else(|| {
        UsageError(anyhow!("SmartKnob's strengths are in volts; give the motor's torque per volt as --motor-mnm-per-v"))
    })?;
    let model = knobs::named(&options.source)?;
    let (motions, along) = motion(options)?;
    let SmartKnobExport { knob: smartknob_config, left_out, left_out_mnm: left_out_rms_mnm } =
        simulator_formats::smartknob(&model, motor_mnm_per_v, &motions)?;
    let file = json!({
        "smartknob_config": smartknob_config,
        "motor_mnm_per_v": motor_mnm_per_v,
        "left_out_rms_mnm": left_out_rms_mnm,
        "along": along,
        "left_out": left_out,
    });
    write_json(model.axis, &Some(options.out.clone()), &file)?;
    Ok(in_words(left_out_rms_mnm, &along, &left_out))
}

/// The motion along which torques are compared, and what it is called.
fn motion(options: &ExportOptions) -> anyhow::Result<(Vec<Motion>, String)> {
    if let Some(capture) = &options.along {
        let loaded = load::load(capture)?;
        let motions = identification::knob_motion(&loaded.samples(), loaded.capture.axis, loaded.calibration.as_ref())?;
        return Ok((motions, format!("the motion of {}", capture.display())));
    }
    let sweep = Excitation::named("linear-chirp", Drive::Position)?;
    let samples = 0..(SWEEP_S * SWEEP_HZ) as u32;
    let motions = samples.map(|sample| {
        let time_s = f64::from(sample) / SWEEP_HZ;
        let asked = sweep.at(time_s);
        Motion { time_s, angle_rad: asked.value, velocity_rad_s: asked.rate, acceleration_rad_s2: asked.acceleration }
    });
    Ok((motions.collect(), format!("{SWEEP_S} s of the sweep linear-chirp")))
}
