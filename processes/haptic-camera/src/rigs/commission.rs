//! `rig commission`: a rig turned for the first time, with so little torque that a wrong sign or scale does no harm.
//!
//! The runs command torques and follow no angle, so that nothing can run away. The torque rises until the knob surely moves. A
//! fit of the angle to the commanded torque then gives the inertia that the motor drives, and a fit to the measured torque the
//! inertia behind the sensor. Signs, inertia and the encoder's step follow; the results go into the rig's file.

use std::fmt;
use std::path::PathBuf;

use anyhow::Context as _;
use archive::whole_file::Replace;
use clap::Args;
use dynamics::Axis;
use hal::RigFile;
use identification::statistics::range;
use identification::{AccelerationUse, FitOptions, Samples, encoder_step};
use loaded_capture::LoadedCapture;
use rt_loop::request::RunRequest;
use shared_types::{Fault, RunDescription};
use toml_edit::{DocumentMut, Item, Value};

use super::RigFileOptions;
use crate::command_line::outputs::{is_same, write};
use crate::export::positive;
use crate::outcome::{Outcome, remark, say};
use crate::supervision::{EndedInFault, Interrupt};
use crate::terminal::digits;
use crate::{load, rig_run};

#[derive(Debug, Args)]
pub struct RigCommissionOptions {
    #[command(flatten)]
    pub rig: RigFileOptions,
    /// Largest torque to try, mNm, or force, N [default: a third of the limit]
    #[arg(long, value_name = "MNM", value_parser = positive, allow_negative_numbers = true)]
    pub most_torque: Option<f64>,
    /// Write the rig file with the results here [default: FILE.toml itself]
    #[arg(long, value_name = "FILE.toml")]
    pub out: Option<PathBuf>,
    /// Folder for the captures
    #[arg(long, default_value = "captures", value_name = "DIR")]
    pub captures_in: PathBuf,
}

impl RigCommissionOptions {
    /// The file that the results are written into.
    pub fn written(&self) -> &PathBuf {
        self.out.as_ref().unwrap_or(&self.rig.file)
    }

    /// What the results may replace: the rig's own file; at any other path, nothing.
    pub fn replaced(&self) -> Replace {
        if is_same(self.written(), &self.rig.file) { Replace::Anything } else { Replace::Nothing }
    }
}

/// First torque, as a share of the most that is tried.
const FIRST_SHARE: f64 = 1.0 / 16.0;
/// Most that is tried, as a share of the motor's limit.
const MOST_SHARE: f64 = 1.0 / 3.0;
/// By how much the torque rises from one try to the next.
const RISE: f64 = 1.5;
/// Length of a try, s.
const TRY_S: f64 = 4.0;
/// Least travel from which an inertia is fitted, rad, or a fingertip's way at that angle: beyond what a sticking knob yields.
const ENOUGH_RAD: f64 = 0.05;
/// Number of tries that are compared with each other.
const COMPARED: usize = 2;
/// Sweeps of the torque: a slow one, which moves the knob far with little torque, and a faster one for rigs that the slow one moves too far.
const SLOW: &str = "multisine";
const FAST: &str = "fast-multisine";
/// How often the knob may leave the permitted range.
const TOO_FAR: u32 = 5;
/// Ratio of two inertias of which one is wrong.
const DIFFERENT: f64 = 1.5;
/// Half width of an interval, as a share, beyond which the inertia is worth finding again.
const VAGUE_SHARE: f64 = 0.2;
/// Distance from a torque that moved the knob too far, as a share of it, within which no other is tried.
const CLOSE_SHARE: f64 = 0.05;

/// Turns the rig, more with every try, until its inertia is known, and writes it into the rig's file.
pub fn run(options: &RigCommissionOptions) -> anyhow::Result<Outcome> {
    let interrupt = Interrupt::listen()?;
    let request = options.rig.torque_request(TRY_S)?;
    let file = rt_loop::rigs::file(&request.rig)?;
    let of_limit_mnm = file.limits.map(|limits| MOST_SHARE * limits.motor_torque_mnm);
    let unknown = "the largest permitted torque is unknown; give --most-torque, or [limits] in the rig file";
    let most_mnm = options.most_torque.or(of_limit_mnm).context(unknown)?;
    let axis = file.axis;
    let mut amplitude_mnm = FIRST_SHARE * most_mnm;
    let (mut sweep, mut ceiling_mnm, mut too_far) = (SLOW, f64::INFINITY, 0);
    let mut tries = Vec::new();
    loop {
        say(axis.words(&format!("trying   {amplitude_mnm:.3} mNm")));
        let tried = RunRequest { sweep: sweep.to_owned(), amplitude: Some(amplitude_mnm), ..request.clone() };
        let archive = match rig_run::archive(tried, &options.captures_in, false, "rig-commission", &interrupt) {
            Ok((archive, _)) => archive,
            Err(error) if too_far < TOO_FAR && fault_of(&error) == Some(Fault::Angle) => {
                too_far += 1;
                let next = if sweep == SLOW {
                    sweep = FAST;
                    "faster torques, which move less"
                } else {
                    ceiling_mnm = amplitude_mnm;
                    amplitude_mnm *= 0.5;
                    "less"
                };
                say(axis.words(&format!("the angle left the permitted range: going on with {next}")));
                continue;
            }
            Err(error) => return Err(with_doubt_of_scale(error, axis)),
        };
        if let Some(found) = find(&load::load(&archive)?) {
            if let Some(amiss) = found.amiss() {
                remark(axis.words(&amiss));
                return Ok(Outcome::Failed);
            }
            tries.push(found);
        }
        if tries.len() == COMPARED || !tries.is_empty() && amplitude_mnm >= most_mnm {
            return conclude(&tries, &file, options);
        }
        let unit = axis.load_unit();
        anyhow::ensure!(
            amplitude_mnm < most_mnm,
            "the knob does not move at {most_mnm} {unit}: check that the amplifier is on and [channels.motor] scale, or try more with \
             --most-torque"
        );
        anyhow::ensure!(
            ceiling_mnm - amplitude_mnm > CLOSE_SHARE * amplitude_mnm,
            "{amplitude_mnm:.3} {unit} hardly move the knob, and a little more takes it out of the permitted range: widen [limits], or set the knob \
             to the middle of its travel"
        );
        amplitude_mnm = (RISE * amplitude_mnm).min(most_mnm).min(0.5 * (amplitude_mnm + ceiling_mnm));
    }
}

fn fault_of(error: &anyhow::Error) -> Option<Fault> {
    error.downcast_ref::<EndedInFault>().and_then(|ended| ended.fault)
}

/// Adds to a fault of angle, speed or jump the remark that the angle's scale may be too large.
fn with_doubt_of_scale(error: anyhow::Error, axis: Axis) -> anyhow::Error {
    if !matches!(fault_of(&error), Some(Fault::Angle | Fault::Speed | Fault::Jump)) {
        return error;
    }
    let scale = if axis.is_rotary() { "2π over its counts per turn" } else { "its step in mm" };
    anyhow::anyhow!(
        "{error:#}; give a smaller --most-torque, unless the rig did not move so far: then [channels.{}] scale is too large (an encoder's \
         is {scale})",
        axis.words("angle")
    )
}

/// A value with half its 95 % interval, mNm·s²/rad; below zero where the torque drives the other way.
#[derive(Clone, Copy, Debug)]
struct Inertia {
    value: f64,
    half_width: f64,
}

/// With the digits that its interval supports.
impl fmt::Display for Inertia {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { value, half_width } = self;
        let digits = digits(2.0 * half_width);
        let [low, high] = [value - half_width, value + half_width];
        write!(f, "{value:.digits$} mNm·s²/rad ({low:.digits$} to {high:.digits$})")
    }
}

struct Found {
    moved_rad: f64,
    /// Inertia that the motor drives.
    driven: Inertia,
    /// Inertia behind the torque sensor; `None` without a sensor, `Some(None)` where its torque does not determine the inertia.
    behind: Option<Option<Inertia>>,
    /// Least step of the encoder that was seen, rad.
    angle_step_rad: Option<f64>,
}

impl Found {
    /// What is wrong with the rig, in a sentence.
    fn amiss(&self) -> Option<String> {
        if self.driven.value < 0.0 {
            return Some(
                "a positive torque makes the angle decrease: invert [channels.motor] sign or [channels.angle] sign, \
                 then commission again"
                    .to_owned(),
            );
        }
        match self.behind? {
            None => Some("the torque sensor shows no inertia: check [channels.torque] source and scale".to_owned()),
            Some(behind) if behind.value < 0.0 => Some(
                "the torque sensor has the wrong sign: invert [channels.torque] sign, then commission again".to_owned(),
            ),
            Some(behind) if behind.value >= self.driven.value => Some(format!(
                "the inertia behind the torque sensor is {behind}, more than the total: check the scales of \
                 [channels.torque] and [channels.motor]"
            )),
            Some(_) => None,
        }
    }

    /// The motor's own inertia: the inertia that it drives less the inertia behind the sensor.
    fn motor(&self) -> Inertia {
        let Inertia { value, half_width } = self.driven;
        let Some(Some(behind)) = self.behind else { return self.driven };
        Inertia { value: value - behind.value, half_width: half_width.hypot(behind.half_width) }
    }
}

/// Reports the results of all tries and writes them into the rig's file, the motor's inertia only if a sensor separates it from
/// the knob's.
fn conclude(tries: &[Found], file: &RigFile, options: &RigCommissionOptions) -> anyhow::Result<Outcome> {
    let axis = file.axis;
    let say = |text: String| say(axis.words(&text));
    let last = tries.last().context("no try moved the knob")?;
    // The last value, with an interval that contains the intervals of all tries.
    let of_all = |inertia: fn(&Found) -> Inertia| {
        let value = inertia(last).value;
        let reach = tries.iter().map(inertia).map(|one| (one.value - value).abs() + one.half_width);
        Inertia { value, half_width: reach.fold(0.0, f64::max) }
    };
    let (driven, motor) = (of_all(|found| found.driven), of_all(Found::motor));
    say(format!("moved    {:.3} rad", last.moved_rad));
    say(format!("inertia  {driven} in total, driven by the motor"));
    if let Some(Some(behind)) = last.behind {
        say(format!("behind   the torque sensor {behind}"));
    }
    if let Some(step_rad) = last.angle_step_rad {
        say(format!("step     of the encoder: {step_rad:.3e} rad"));
    }
    if motor.half_width > VAGUE_SHARE * motor.value {
        remark(axis.words(&format!(
            "the motor's inertia is {motor}: too uncertain to be written; commission again with more torque (--most-torque)"
        )));
        return Ok(Outcome::Failed);
    }
    let path = options.written();
    let has_sensor = last.behind.is_some();
    let before = file.calibration()?.map(|known| known.motor_inertia).filter(|_| has_sensor);
    if let Some(before) = before.filter(|before| !(before / DIFFERENT..DIFFERENT * before).contains(&motor.value)) {
        remark(axis.words(&format!(
            "motor_inertia was {before} in the rig file; if that is from a data sheet, the scale of [channels.angle], [channels.torque] or \
             [channels.motor] is wrong: check them, and commission again"
        )));
    }
    let known = [("motor_inertia", has_sensor.then_some(motor.value)), ("angle_step_rad", last.angle_step_rad)];
    let own = &options.rig.file;
    let text = std::fs::read_to_string(own).with_context(|| format!("{} cannot be read", own.display()))?;
    let changed = with(&text, axis, known).with_context(|| format!("{} is not changed", own.display()))?;
    write(path, options.replaced(), &changed)?;
    // Without a sensor nothing tells what was on the gripper.
    let (done, condition) = if has_sensor { ("written ", "") } else { ("write   ", ", if nothing was on the gripper") };
    say(format!("{done} motor_inertia = {motor} under [calibration] of {}{condition}", path.display()));
    Ok(Outcome::Done)
}

/// What a try tells; `None` where the knob hardly moved.
fn find(loaded: &LoadedCapture) -> Option<Found> {
    let capture = &loaded.capture;
    let [lowest_rad, highest_rad] = range(&capture.angle_rad);
    let moved_rad = highest_rad - lowest_rad;
    if moved_rad < ENOUGH_RAD * capture.axis.fingertip_travel() {
        return None;
    }
    let is_of_motor = capture.description.as_ref().is_some_and(RunDescription::has_motors_torque);
    Some(Found {
        moved_rad,
        driven: inertia(loaded, loaded.commanded_torque_mnm()?)?,
        behind: (!is_of_motor).then(|| inertia(loaded, &capture.torque_mnm)),
        angle_step_rad: encoder_step(&capture.angle_rad),
    })
}

/// The inertia that a torque drives, from a fit of the capture's angle to it. A fit gives no negative inertia, so a second one
/// with the torque reversed follows where the first fails.
fn inertia(loaded: &LoadedCapture, torque_mnm: &[f64]) -> Option<Inertia> {
    let fit = |torque_mnm: &[f64]| {
        let samples = Samples { torque_mnm, velocity_rad_s: None, acceleration_rad_s2: None, ..loaded.samples() };
        let axis = loaded.capture.axis;
        let options = FitOptions { axis, acceleration: AccelerationUse::Encoder, ..FitOptions::default() };
        let fit = identification::fit(&samples, &options).ok()?;
        let parameter = fit.parameters.get("inertia")?;
        Some(Inertia { value: parameter.value?, half_width: parameter.half_width().unwrap_or(0.0) })
    };
    let turned: Vec<f64> = torque_mnm.iter().map(|torque_mnm| -torque_mnm).collect();
    fit(torque_mnm).or_else(|| fit(&turned).map(|found| Inertia { value: -found.value, ..found }))
}

/// The text of a rig file with what is known in it, by its names in a calibration.
fn with(text: &str, axis: Axis, known: [(&str, Option<f64>); 2]) -> anyhow::Result<String> {
    let mut document: DocumentMut = text.parse().context("it is no TOML")?;
    anyhow::ensure!(
        !document.contains_key("calibration_file"),
        "its calibration is in another file (calibration_file): enter the values there"
    );
    let table = document.entry("calibration").or_insert(toml_edit::table());
    // Four digits: no more are known.
    let rounded = |number: f64| format!("{number:.3e}").parse().unwrap_or(number);
    for (key, number) in known.into_iter().filter_map(|(key, number)| Some((axis.words(key), rounded(number?)))) {
        let key = key.as_ref();
        match table.get_mut(key).and_then(Item::as_value_mut) {
            // A maker's figure for an encoder is more exact than the step that was seen.
            Some(before) if before.as_float().is_some_and(|before| (before / number - 1.0).abs() < SAME_SHARE) => {}
            Some(before) => {
                let comment = before.decor().clone();
                *before = Value::from(number);
                *before.decor_mut() = comment;
            }
            None => table[key] = toml_edit::value(number),
        }
    }
    Ok(document.to_string())
}

/// Relative difference from the result below which a number of the file is kept.
const SAME_SHARE: f64 = 1e-3;

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop at a failure")]
    use dynamics::Axis;

    use super::with;

    #[test]
    fn numbers_change_and_comments_stay() {
        let known = [("motor_inertia", Some(0.020_023_4)), ("angle_step_rad", Some(0.001))];
        let text = "# mine\nname = \"a\"\n\n[calibration]\nmotor_inertia = 0.5   # a guess\n";
        let changed =
            "# mine\nname = \"a\"\n\n[calibration]\nmotor_inertia = 0.02002   # a guess\nangle_step_rad = 0.001\n";
        assert_eq!(with(text, Axis::Rotary, known).unwrap(), changed);
        assert!(
            with("name = \"a\"\n", Axis::Rotary, known).unwrap().contains("[calibration]\nmotor_inertia = 0.02002\n")
        );
        assert!(with("name = \"a\"\n", Axis::Linear, known).unwrap().contains("\ntravel_step_mm = 0.001\n"));
        assert!(with("calibration_file = \"b.toml\"\n", Axis::Rotary, known).is_err());
    }
}
