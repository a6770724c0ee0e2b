//! The page of several knobs side by side: the paper's Tables 4 to 6 with the captures of today.

mod captures;
mod curves;
mod forest;
mod input;
mod scale;
mod table;

use maud::{Markup, html};

pub use input::{
    ComparedCapture, ComparedKnob, ComparedParameters, ComparedQuality, ComparedValue, Comparison, PaperKnob,
    PaperValue,
};

use crate::numbers::three;
use crate::page::{document, footer, uppercase_first};
use crate::preparation::method;

pub(crate) fn comparison_page(compared: &Comparison) -> Markup {
    let captures: usize = compared.knobs.iter().map(|knob| knob.captures.len()).sum();
    let models = compared.knobs.iter().filter(|knob| knob.captures.is_empty()).count();
    let names: Vec<&str> = compared.knobs.iter().map(|knob| knob.name.as_str()).collect();
    let title = if names.len() > 3 { format!("{} knobs compared", names.len()) } else { names.join(" beside ") };
    let (curves, count) = curves::figures(compared, 1);
    let several: Vec<&ComparedKnob> = compared.knobs.iter().filter(|knob| knob.captures.len() > 1).collect();
    let sources: Vec<&str> = compared
        .knobs
        .iter()
        .flat_map(|knob| {
            knob.captures.iter().map(|capture| capture.facts.source.as_str()).chain(knob.model_file.as_deref())
        })
        .collect();
    let content = html! {
        header {
            p.kind { "Comparison of " (subjects(captures, models)) }
            h1 { (title) }
            @for sentence in ranges(compared) { p.verdict { (sentence) } }
        }
        @if compared.knobs.iter().any(|knob| knob.paper.is_some()) {
            section {
                h2 { "The paper’s knobs" }
                (descriptions(compared))
            }
        }
        section {
            h2 { "Parameters" }
            (table::parameters(compared))
        }
        section {
            h2 { "The models as curves" }
            (curves)
        }
        @if let Some(forest) = forest::figure(compared, 1 + count) {
            section {
                h2 { "Parameter by parameter" }
                (forest)
            }
        }
        section {
            h2 { "The captures" }
            (captures::list(compared))
        }
        @if !several.is_empty() {
            section {
                h2 { "How the captures of a knob repeat" }
                @for knob in &several { (captures::side_by_side(knob)) }
                p.note {
                    "Difference: largest less smallest value of the captures; below it how many times the 95 % interval of such a \
                     difference that is, from the captures’ own intervals. Up to 1 is what chance explains. Phases of detents are \
                     compared at the captures’ mean angle, and shown at angle zero."
                }
            }
        }
        section {
            h2 { "What the data could not tell" }
            (not_identifiable(compared))
        }
        section {
            h2 { "How the numbers were made" }
            (method(false))
            p {
                "Captures are of one knob if their archives name the same knob and were made of it in the same way; a table without such \
                 a name stands alone. The mean of several captures is that of whole parameter vectors, each capture counting with the \
                 inverse of the covariance of its parameters. A model file stands for itself: its values have no intervals."
            }
            p {
                "Tables 4 to 6 of Swindells and MacLean 2007 describe five knobs, the means of two captures each. Their static friction and \
                 stick velocity were read off plots of torque against velocity by hand; here static friction is what the knob was seen \
                 to break away at, where a capture shows that often enough."
            }
        }
        (footer(&compared.software_version, &sources.join(", ")))
    };
    document(&title, &content)
}

fn subjects(captures: usize, models: usize) -> String {
    let counted =
        |count: usize, what: &str| if count == 1 { format!("one {what}") } else { format!("{count} {what}s") };
    match (captures, models) {
        (captures, 0) => counted(captures, "capture"),
        (0, models) => counted(models, "model"),
        (captures, models) => format!("{} and {}", counted(captures, "capture"), counted(models, "model")),
    }
}

/// The knobs with the least and the most inertia, friction and detents, in a sentence.
fn ranges(compared: &Comparison) -> Vec<String> {
    let quantities = [
        ("inertia", "inertia"),
        ("coulomb_positive", "Coulomb friction turning positively"),
        ("detent_amplitude", "detents"),
    ];
    let reach = |(name, words): (&str, &str)| {
        let knobs = compared.knobs.iter().filter_map(|knob| {
            let own = knob.parameters.get(name)?;
            Some((knob.name.as_str(), own.value.filter(|value| *value > 0.0)?, own.unit))
        });
        let knobs: Vec<_> = knobs.collect();
        let least = knobs.iter().min_by(|a, b| a.1.total_cmp(&b.1))?;
        let most = knobs.iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
        (least.0 != most.0).then(|| {
            format!(
                "{words} from {} ({}) to {}\u{a0}{} ({})",
                three(least.1),
                least.0,
                three(most.1),
                most.2.replace(' ', "\u{a0}"),
                most.0
            )
        })
    };
    let ranges: Vec<String> = quantities.into_iter().filter_map(reach).collect();
    if ranges.is_empty() { Vec::new() } else { vec![format!("{}.", uppercase_first(&ranges.join("; ")))] }
}

/// Table 4.
fn descriptions(compared: &Comparison) -> Markup {
    html! {
        div.scroll {
            table {
                thead { tr { th { "knob" } th.number { "no. in the paper" } th { "description in the paper’s Table 4" } } }
                tbody.plain {
                    @for knob in &compared.knobs {
                        @if let Some(paper) = &knob.paper {
                            tr {
                                th scope="row" { (knob.name) }
                                td.number { (paper.number) }
                                td.words { (paper.description) }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// The parameters that are not identifiable, with the reasons, and other remarks.
fn not_identifiable(compared: &Comparison) -> Markup {
    let mut words: Vec<(String, Vec<&str>, String)> = Vec::new();
    for knob in &compared.knobs {
        for (name, own) in &knob.parameters {
            let Some(reason) = &own.reason else { continue };
            match words.iter_mut().find(|(of, _, known)| *of == knob.name && known == reason) {
                Some((_, names, _)) => names.push(name),
                None => words.push((knob.name.clone(), vec![name], reason.clone())),
            }
        }
    }
    let notes: Vec<(&str, &String)> =
        compared.knobs.iter().flat_map(|knob| knob.notes.iter().map(|note| (knob.name.as_str(), note))).collect();
    html! {
        @if words.is_empty() && notes.is_empty() {
            p { "Every parameter is identifiable, and there are no warnings." }
        } @else {
            ul {
                @for (knob, names, reason) in &words {
                    li {
                        (knob) ": "
                        @for (index, name) in names.iter().enumerate() { @if index > 0 { ", " } code { (name) } }
                        ": " (reason) "."
                    }
                }
                @for (knob, note) in &notes { li { (knob) ": " (note.trim_end_matches('.')) "." } }
            }
        }
    }
}
