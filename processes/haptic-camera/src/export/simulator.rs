//! Models for simulators, and how much torque they leave out.

use anyhow::Context as _;
use archive::whole_file::write_bytes;
use dynamics::excitation::{Drive, Excitation};
use dynamics::{Axis, Model, Motion, knobs};
use simulators::{Export, fmi, isaac_lab, left_out_mnm};

use super::ExportOptions;
use crate::load;
use crate::outcome::{Outcome, say};
use crate::outputs::{kind, write};
use crate::supervision::program_path;

/// The library of the crate `knob-fmu`, which is built beside the programs.
const FMU_LIBRARY: &str = "libhaptic_knob.so";

/// Length and rate of the default sweep along which the omitted torque is computed, s and Hz.
const SWEEP_S: f64 = 6.0;
const SWEEP_HZ: f64 = 2_000.0;

/// Writes the file and tells what it leaves out.
fn write_export<Content: AsRef<[u8]>>(
    options: &ExportOptions,
    model: &Model,
    export: &Export<Content>,
) -> anyhow::Result<Outcome> {
    let (motions, motion) = motion(options, model.axis)?;
    write_bytes(&options.out, kind::SIMULATOR, export.content.as_ref())?;
    let left_out_mnm = left_out_mnm(model, &export.said, &motions);
    let left_out = model.axis.words(&format!("leaves out {left_out_mnm:.6} mNm RMS")).into_owned();
    say(format!("{}: {left_out} along {motion}", options.out.display()));
    export.left_out.iter().for_each(|words| say(format!("- {}", model.axis.words(words))));
    Ok(Outcome::Done)
}

/// The model for MuJoCo.
pub(super) fn mjcf(options: &ExportOptions) -> anyhow::Result<Outcome> {
    let model = knobs::named(&options.source)?;
    write_export(options, &model, &simulators::mjcf(&model))
}

/// The URDF, and beside it the fields of Isaac Lab's actuators, for which URDF has no place.
pub(super) fn urdf(options: &ExportOptions) -> anyhow::Result<Outcome> {
    let model = knobs::named(&options.source)?;
    let done = write_export(options, &model, &simulators::urdf(&model))?;
    let Some(beside) = options.isaac_lab() else { return Ok(done) };
    write(&beside, kind::JSON, &isaac_lab(&model))?;
    say(format!("{}: armature and friction as Isaac Lab's ImplicitActuatorCfg takes them", beside.display()));
    Ok(done)
}

/// An FMU around the library that lies beside this program.
pub(super) fn fmu(options: &ExportOptions) -> anyhow::Result<Outcome> {
    let model = knobs::named(&options.source)?;
    let place = program_path(FMU_LIBRARY)?;
    let library = std::fs::read(&place).with_context(|| {
        format!("{} cannot be read; build it with `cargo build --release -p knob-fmu`", place.display())
    })?;
    write_export(options, &model, &fmi::fmu(&model, &library)?)
}

/// The motion along which torques are compared, and what it is called.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a few thousand samples")]
pub(super) fn motion(options: &ExportOptions, axis: Axis) -> anyhow::Result<(Vec<Motion>, String)> {
    if let Some(capture) = &options.along {
        let loaded = load::load(capture)?;
        let motions = identification::knob_motion(&loaded.samples(), loaded.calibration.as_ref())?;
        return Ok((motions, format!("the motion of {}", capture.display())));
    }
    let sweep = Excitation::named("linear-chirp", Drive::Position)?.on(axis);
    let samples = 0..(SWEEP_S * SWEEP_HZ) as u32;
    let motions = samples.map(|sample| {
        let time_s = f64::from(sample) / SWEEP_HZ;
        let asked = sweep.at(time_s);
        Motion { time_s, angle_rad: asked.value, velocity_rad_s: asked.rate, acceleration_rad_s2: asked.acceleration }
    });
    Ok((motions.collect(), format!("{SWEEP_S} s of the sweep linear-chirp")))
}
