//! Knobs side by side, for the wall.

use maud::{Markup, html};
use sheet::Sheet;

use super::curves::small;
use crate::page::document;
use crate::plot::ink::Ink;
use crate::plot::{Axis, Layer, Plot};

/// Size of a small plot, SVG units.
const SIZE: (u32, u32) = (288, 170);

/// Knobs side by side.
#[derive(Clone, Debug)]
pub struct WallPage {
    /// Headline.
    pub title: String,
    /// Groups of knobs, each with a heading and a sentence on what they are.
    pub groups: Vec<(String, String, Vec<WallKnob>)>,
    /// Version of the program that made the page.
    pub software_version: String,
}

/// One knob on the wall.
#[derive(Clone, Debug)]
pub struct WallKnob {
    /// Its name.
    pub name: String,
    /// What it is, in a line.
    pub description: String,
    /// Its sheet.
    pub sheet: Sheet,
    /// Angle over which its curve is shown, rad.
    pub reach_rad: f64,
    /// What the torque axis says.
    pub torque: String,
    /// What stands below the curve: a word and a number with its unit.
    pub facts: Vec<(String, String)>,
}

pub(crate) fn wall_page(page: &WallPage) -> Markup {
    let content = html! {
        header {
            p.kind { "Knobs side by side" }
            h1 { (page.title) }
        }
        @for (heading, words, knobs) in &page.groups {
            section {
                h2 { (heading) }
                p.lead { (words) }
                figure.maps { div.thirds { @for knob in knobs { (panel(knob)) } } }
            }
        }
        footer { "Made by haptic-camera " (page.software_version) "." }
    };
    document(&page.title, &content)
}

fn panel(knob: &WallKnob) -> Markup {
    let lines = small(&knob.sheet, knob.reach_rad);
    let points = || {
        lines.iter().filter_map(|line| if let Layer::Line(_, points) = line { Some(points) } else { None }).flatten()
    };
    let plot = Plot {
        size: SIZE,
        x: Axis::around("angle (rad)", points().map(|(at, _)| *at)),
        y: Axis::around(&knob.torque, points().map(|(_, torque)| *torque).chain([0.0])),
        layers: [Layer::Level(Ink::Zero, 0.0)].into_iter().chain(lines.clone()).collect(),
    };
    html! {
        div.map {
            p { strong { (knob.name) } span.faint { (knob.description) } }
            (plot.svg(&format!("Torque of {} over the angle", knob.name)))
            dl.wall { @for (word, number) in &knob.facts { div { dt { (word) } dd { (number) } } } }
        }
    }
}
