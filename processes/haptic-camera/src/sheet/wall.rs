//! The paper's five knobs beside SmartKnob's default ones.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use archive::testers::Curve;
use dynamics::{Direction, Model, Motion, knobs};
use report::{WallKnob, WallPage};
use shared_types::Axis;
use sheet::{Branch, Sheet};
use simulator_formats::{SMARTKNOBS, SmartKnob};

use crate::terminal::decimals;

/// Speed at which a model is turned, rad/s: viscous friction is next to nothing.
const SLOW_RAD_S: f64 = 0.01;
const STEPS: u32 = 7200;
/// Detents that are shown of each knob.
const DETENTS: f64 = 4.0;

pub fn page() -> anyhow::Result<WallPage> {
    let papers = (1..=5).map(of_paper).collect::<anyhow::Result<Vec<WallKnob>>>()?;
    let smart: Vec<WallKnob> = SMARTKNOBS.iter().map(of_smartknob).collect();
    Ok(WallPage {
        title: "Five mechanical knobs and ten of SmartKnob’s".to_owned(),
        groups: vec![
            (
                "The paper’s knobs".to_owned(),
                "Torque of a slow turn in both directions, over four detents or, without detents, a full turn. \
                 Swindells and MacLean 2007, Tables 4 to 6; each plot has a scale of its own."
                    .to_owned(),
                papers,
            ),
            (
                "SmartKnob’s default knobs".to_owned(),
                "Voltage against the hand, there and back from the lower end stop over some positions, without the \
                 motor’s own friction and the firmware’s damping. github scottbez1/smartknob, firmware/src."
                    .to_owned(),
                smart,
            ),
        ],
        software_version: env!("CARGO_PKG_VERSION").to_owned(),
    })
}

fn of_paper(number: u32) -> anyhow::Result<WallKnob> {
    let model = knobs::paper_knob(number)?;
    let sheet = Sheet::of(&[slow_turn(&model)])?;
    let figure = |name: &str| sheet.figures.get(name).and_then(|figure| figure.value);
    let pitch = figure("detent_pitch");
    let facts = [
        ("detents in a turn", figure("detent_count").map(|count| format!("{count:.1}"))),
        ("pitch", pitch.map(|pitch| format!("{:.1}°", pitch.to_degrees()))),
        ("peak", figure("peak_torque").map(|peak| format!("{} mNm", short(peak)))),
        ("trough", figure("trough_torque").map(|trough| format!("{} mNm", short(trough)))),
        ("energy", figure("detent_energy").map(|energy| format!("{} mJ", short(energy)))),
        ("stiffness", figure("detent_stiffness").map(|slope| format!("{} mNm/rad", short(slope)))),
        ("running friction", figure("running_friction").map(|friction| format!("{} mNm", short(friction)))),
    ];
    Ok(WallKnob {
        name: format!("Knob {number}"),
        description: model.description.clone(),
        reach_rad: pitch.map_or(TAU, |pitch| DETENTS * pitch),
        torque: "torque (mNm)".to_owned(),
        facts: facts.into_iter().filter_map(|(word, number)| Some((word.to_owned(), number?))).collect(),
        sheet,
    })
}

/// What a slow turn there and back shows of a model.
fn slow_turn(model: &Model) -> Curve {
    let turn = |direction: Direction| {
        (0..=STEPS).map(move |step| {
            let angle_rad = TAU * f64::from(step) / f64::from(STEPS);
            let motion = Motion { angle_rad, velocity_rad_s: direction.sign() * SLOW_RAD_S, ..Motion::default() };
            (angle_rad, motion, direction)
        })
    };
    let back: Vec<_> = turn(Direction::Negative).collect();
    let rows = turn(Direction::Positive).chain(back.into_iter().rev().skip(1));
    let felt = |(angle_rad, motion, direction)| {
        (angle_rad, model.place_torque_mnm(&motion) + model.friction_mnm(&motion, direction))
    };
    let (position, load) = rows.map(felt).unzip();
    Curve { axis: Axis::Rotary, position, load, ..Curve::default() }
}

fn of_smartknob(knob: &SmartKnob) -> WallKnob {
    let positions = if knob.num_positions == 0 { "any number".to_owned() } else { knob.num_positions.to_string() };
    let facts = [
        ("positions", positions),
        ("width", format!("{}°", short(knob.position_width_radians.to_degrees()))),
        ("detent strength", short(knob.detent_strength_unit)),
        ("end stop strength", short(knob.endstop_strength_unit)),
        ("snap point", short(knob.snap_point)),
        ("peak", format!("{} V", short(knob.peak_v()))),
    ];
    WallKnob {
        name: knob.text.clone().into_owned(),
        description: String::new(),
        sheet: volts(knob),
        reach_rad: knob.reach_rad(),
        torque: "against the hand (V)".to_owned(),
        facts: facts.into_iter().map(|(word, number)| (word.to_owned(), number)).collect(),
    }
}

/// The motor's voltage against a slow turn there and back, as the curve of a data sheet without figures.
fn volts(knob: &SmartKnob) -> Sheet {
    let ([first, step], [there, back]) = knob.slow_turn();
    let branch =
        |load: Vec<f64>| Branch { axis: Axis::Rotary, first, step, load_ci95_half_width: vec![0.0; load.len()], load };
    let curve = BTreeMap::from([("positive", branch(there)), ("negative", branch(back))]);
    Sheet { axis: Axis::Rotary, runs: 1, figures: BTreeMap::new(), detents: Vec::new(), presses: Vec::new(), curve }
}

fn short(value: f64) -> String {
    let text = format!("{value:.*}", decimals(value, 3.0, [0.0, 4.0]));
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    text.replace('-', "−")
}
