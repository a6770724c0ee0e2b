//! One pair of captures that hides what was asked for, at the strength asked for, and its answer.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use anyhow::{Context as _, Result, bail};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};

use crate::base_fit::{sliding, unexplained_rms};
use crate::draw::Draw;
use crate::effect::{Effect, Kind, catalogue, distinguishable, named, outside};
use crate::family::{Conditions, Family};
use crate::knob::{Knob, Wish};
use crate::motion::Motion;
use crate::plant::{Rig, run};
use crate::sensors::{Record, Sensors, ideal, record};

/// What is known of a pair of captures.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Answer {
    /// `effects`, `none` or `outside-library`.
    pub verdict: String,
    /// The catalogue's names of what is hidden.
    pub effects: Vec<String>,
    /// Intended ratio of effect to noise.
    pub strength: Option<f64>,
    /// RMS of the torque noise, its steps included, mNm.
    pub torque_noise_rms_mnm: f64,
    /// What the best base model leaves of noise-free training data, mNm RMS.
    pub effect_rms_mnm: f64,
    /// The effects' parameters, by name.
    pub parameters: Map<String, Value>,
    /// The base model.
    pub base: Knob,
    /// The family it came from, and the rig.
    #[serde(default)]
    pub rig: Value,
}

/// Both recordings and their answer.
pub struct Capture {
    /// Eight digits that say nothing.
    pub name: String,
    /// Training and held-out record.
    pub records: [Record; 2],
    /// What they hide.
    pub answer: Answer,
}

/// The names that capture `index` of a run hides, by what was asked for: a list of names with commas, `none`,
/// `outside-library`, `triple`, `pair`, `single`, or `mixed` (in turn: each effect once, one without, two outside, two
/// pairs).
///
/// # Errors
/// If a name is none of an effect.
pub fn hidden(asked: &str, index: usize, draw: &mut Draw) -> Result<Vec<&'static Kind>> {
    let (catalogue, outside) = (catalogue(), outside());
    let outside_at = |place: usize| vec![outside[place % outside.len()]];
    let round = catalogue.len() + 5;
    Ok(match asked {
        "none" => vec![],
        "outside-library" => outside_at(index),
        "single" => vec![catalogue[index % catalogue.len()]],
        "pair" => together(2, draw),
        "triple" => together(3, draw),
        "mixed" => match (index % round).checked_sub(catalogue.len()) {
            None => vec![catalogue[index % round]],
            Some(0) => vec![],
            Some(place @ (1 | 2)) => outside_at(2 * (index / round) + place - 1),
            Some(_) => together(2, draw),
        },
        list => {
            let mut names = Vec::new();
            for asked in list.split(',') {
                let Some(kind) = named(asked) else {
                    let known: Vec<&str> = catalogue.iter().chain(&outside).map(|kind| kind.name).collect();
                    bail!("no effect is called {asked}; there are: {}", known.join(", "));
                };
                names.push(kind);
            }
            names
        }
    })
}

/// So many effects, each distinguishable from each other one.
fn together(count: usize, draw: &mut Draw) -> Vec<&'static Kind> {
    let catalogue = catalogue();
    let mut kinds: Vec<&'static Kind> = Vec::new();
    while kinds.len() < count {
        let next = catalogue[draw.below(catalogue.len())];
        if kinds.iter().all(|kind| distinguishable(kind.name, next.name)) {
            kinds.push(next);
        }
    }
    kinds
}

/// Knobs and motions are drawn anew so often when an effect cannot reach its strength on them.
const TRIES: usize = 60;
/// Draws of a knob and its motions after which effects that are hidden together are drawn anew too.
const TRIES_TOGETHER: usize = 12;
/// The held-out capture must show an effect of at least this part of its size in the training capture.
const LEAST_HELD_OUT: f64 = 0.25;

impl Capture {
    /// Capture `index` of the run that `seed` decides, hiding what `asked` says (see [`hidden`]) at `strength`.
    ///
    /// # Errors
    /// If a name is unknown, or if on no knob drawn the effects reach the strength.
    pub fn new(seed: u64, index: usize, family: Family, asked: &str, strength: f64) -> Result<Self> {
        let mut draw = Draw::new(seed, &format!("{index} {} {asked} {strength}", family.name()));
        let name = draw.name();
        let mut names = hidden(asked, index, &mut draw)?;
        for attempt in 1..=TRIES {
            if let Some(bench) = Bench::draw(&names, family, strength, &mut draw) {
                return Ok(bench.capture(name, family, strength, &mut draw));
            }
            if attempt % TRIES_TOGETHER == 0 {
                // Two effects may ask for opposite knobs: other effects are then drawn. Choices that are not drawn stay the same.
                names = hidden(asked, index, &mut draw)?;
            }
        }
        let names: Vec<&str> = names.iter().map(|kind| kind.name).collect();
        bail!("{} reached {strength} times the noise on none of {TRIES} knobs", names.join(" and "))
    }

    /// Writes both recordings into a folder of the capture's name.
    ///
    /// # Errors
    /// If they cannot be written.
    pub fn write(&self, folder: &Path) -> Result<()> {
        let folder = folder.join(&self.name);
        fs::create_dir_all(&folder).with_context(|| format!("cannot make {}", folder.display()))?;
        for (record, file) in self.records.iter().zip(["train.csv", "heldout.csv"]) {
            fs::write(folder.join(file), csv(record)?).with_context(|| format!("cannot write {file}"))?;
        }
        Ok(())
    }
}

/// A knob on a rig, its motions, and effects scaled to their strength.
struct Bench {
    rig: Rig,
    knob: Knob,
    sensors: Sensors,
    conditions: Conditions,
    motions: [Motion; 2],
    effects: Vec<Effect>,
    effect_rms_mnm: f64,
}

impl Bench {
    /// `None` if on this knob an effect does not reach its strength.
    fn draw(kinds: &[&'static Kind], family: Family, strength: f64, draw: &mut Draw) -> Option<Self> {
        let conditions = family.conditions(draw);
        let sensors = Sensors::draw(draw, conditions.rate_hz);
        let target = strength * sensors.torque_noise_rms_mnm();
        let wish = kinds.iter().map(|kind| (kind.wish)(target)).fold(Wish::default(), |all, one| Wish {
            detents: all.detents.or(one.detents),
            least_detent_mnm: all.least_detent_mnm.max(one.least_detent_mnm),
            least_coulomb_mnm: all.least_coulomb_mnm.max(one.least_coulomb_mnm),
            most_coulomb_mnm: all.most_coulomb_mnm.max(one.most_coulomb_mnm),
        });
        let extreme = family == Family::ExtremeKnob;
        let knob = if extreme { Knob::draw_extreme(draw, wish) } else { Knob::draw(draw, wish) };
        let soft = family == Family::SoftServo;
        let rig = Rig {
            rotor_inertia: draw.uniform(0.0142, 0.03),
            servo_hz: if soft { draw.uniform(5.0, 12.0) } else { draw.uniform(40.0, 90.0) },
            servo_damping: draw.uniform(0.6, 1.0),
            current_lag_s: draw.uniform(5e-5, 1.5e-4),
        };
        let [train_s, held_out_s] = conditions.durations_s;
        let moves = family == Family::DriveLog;
        let train = if moves { Motion::moves(train_s, draw) } else { Motion::sweeps(train_s, draw) };
        let mut held_out = Motion::held_out(held_out_s, draw);
        if kinds.iter().any(|kind| kind.name == "end-stop") {
            // Both captures must meet the stop.
            held_out = held_out.spanning(train.travel_rad());
        }
        let mut bench = Self {
            rig,
            knob,
            sensors,
            conditions,
            motions: [train, held_out],
            effects: Vec::new(),
            effect_rms_mnm: 0.0,
        };
        let mut effects = Vec::new();
        for kind in kinds {
            let travel = bench.motions[0].travel_rad();
            let effect = Effect::draw(kind, &bench.knob, travel, bench.conditions.durations_s, draw);
            effects.push(bench.scaled(effect, target)?);
        }
        if !effects.is_empty() {
            bench.effect_rms_mnm = bench.unexplained(&effects, 0);
            // What the held-out motion does not stir cannot be judged on it: a stop not met, a range not reached.
            if bench.unexplained(&effects, 1) < LEAST_HELD_OUT * bench.effect_rms_mnm {
                return None;
            }
        }
        bench.effects = effects;
        Some(bench)
    }

    /// The effect alone on this knob, scaled to leave `target` mNm RMS unexplained.
    fn scaled(&self, mut effect: Effect, target: f64) -> Option<Effect> {
        let [weakest, strongest] = effect.acts().size_limits().map(f64::ln);
        let mut rms_at = |size: f64| {
            effect.size = size.exp();
            self.unexplained(std::slice::from_ref(&effect), 0)
        };
        let least = rms_at(weakest);
        if least.is_nan() || least > target {
            return None;
        }
        // Walks up from the weak end: far beyond the strength, what the effect leaves may no longer grow with its size.
        let rung = |number: u32| weakest + f64::from(number) / 8.0 * (strongest - weakest);
        let beyond = (1..=8).find(|number| rms_at(rung(*number)) > target)?;
        let (mut weak, mut strong) = (rung(beyond - 1), rung(beyond));
        let mut rms = f64::NAN;
        for _ in 0..12 {
            let middle = 0.5 * (weak + strong);
            rms = rms_at(middle);
            if (rms / target - 1.0).abs() < 0.01 {
                break;
            }
            if rms > target { strong = middle } else { weak = middle }
        }
        ((rms / target - 1.0).abs() < 0.1).then_some(effect)
    }

    fn unexplained(&self, effects: &[Effect], which: usize) -> f64 {
        let duration_s = self.conditions.durations_s[which];
        let course = run(self.rig, &self.knob, effects, &self.motions[which], duration_s, which);
        let samples = ideal(&course, effects, self.conditions.rate_hz, duration_s);
        unexplained_rms(&sliding(&samples, self.conditions.rate_hz), self.knob.detent_period)
    }

    fn capture(self, name: String, family: Family, strength: f64, draw: &mut Draw) -> Capture {
        let records = [0, 1].map(|which| {
            let duration_s = self.conditions.durations_s[which];
            let course = run(self.rig, &self.knob, &self.effects, &self.motions[which], duration_s, which);
            record(&course, &self.effects, self.sensors, &self.conditions, duration_s, draw)
        });
        let outside = self.effects.iter().any(|effect| !effect.kind.in_catalogue);
        let verdict = match (self.effects.is_empty(), outside) {
            (true, _) => "none",
            (_, true) => "outside-library",
            _ => "effects",
        };
        let known = self.effects.iter().filter(|_| !outside).map(|effect| effect.kind.name.to_owned());
        let Conditions { rate_hz, noise, ring, clipped_share, jitter, jitter_is_recorded, encoder_step_rad, .. } =
            self.conditions;
        let answer = Answer {
            verdict: verdict.to_owned(),
            effects: known.collect(),
            strength: (!self.effects.is_empty()).then_some(strength),
            torque_noise_rms_mnm: rounded(self.sensors.torque_noise_rms_mnm()),
            effect_rms_mnm: rounded(self.effect_rms_mnm),
            parameters: self
                .effects
                .iter()
                .map(|effect| (effect.kind.name.to_owned(), effect.acts().parameters(effect.size, &self.knob)))
                .collect(),
            base: self.knob,
            rig: json!({
                "family": family.name(), "rate_hz": rate_hz, "noise": format!("{noise:?}"),
                "ring": ring.map(|ring| [ring.frequency_hz, ring.damping]), "clipped_share": clipped_share,
                "jitter_of_a_tick": jitter, "jitter_is_recorded": jitter_is_recorded, "encoder_step_rad": encoder_step_rad,
                "servo_hz": self.rig.servo_hz, "rotor_inertia": self.rig.rotor_inertia,
            }),
        };
        Capture { name, records, answer }
    }
}

fn rounded(value: f64) -> f64 {
    (value * 1e5).round() / 1e5
}

fn csv(record: &Record) -> Result<String> {
    let Record { time_s, angle_rad, velocity_rad_s, acceleration_rad_s2, torque_mnm } = record;
    let columns = [
        ("t_s", time_s, 7),
        ("angle_rad", angle_rad, 6),
        ("velocity_rad_s", velocity_rad_s, 4),
        ("acceleration_rad_s2", acceleration_rad_s2, 1),
        ("torque_mnm", torque_mnm, 2),
    ];
    let logged: Vec<_> = columns.into_iter().filter(|(_, values, _)| !values.is_empty()).collect();
    let mut text = logged.iter().map(|(name, ..)| *name).collect::<Vec<_>>().join(",");
    for row in 0..time_s.len() {
        for (column, (_, values, decimals)) in logged.iter().enumerate() {
            let separator = if column == 0 { '\n' } else { ',' };
            write!(text, "{separator}{:.decimals$}", values[row])?;
        }
    }
    text.push('\n');
    Ok(text)
}
