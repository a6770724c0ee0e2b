//! What was identified, written into a joint of somebody's own MJCF; all else of the file stays as it is, byte for byte.

use std::fmt::Write as _;
use std::ops::Range;

use dynamics::Model;
use roxmltree::{Document, Node};

use crate::joint::Joint;
use crate::said::LinearAxis;
use crate::xml::{attribute, si};

/// What keeps a joint from being written to.
#[derive(Debug, thiserror::Error)]
pub enum IntoMjcfError {
    /// The text is no XML.
    #[error("it is not XML ({0}); give an MJCF file")]
    NotXml(#[from] roxmltree::Error),
    /// The document is something else.
    #[error("its root is <{0}>; give an MJCF file, whose root is <mujoco>")]
    NotMjcf(String),
    /// There are several joints, and none was named, or none has the name.
    #[error("{problem}; name one of its joints: {known}")]
    Joint {
        /// What is wrong.
        problem: String,
        /// The names that would do.
        known: String,
    },
    /// A joint that no actuator can be given to.
    #[error("the joint has no name, which its detents need; give it one")]
    Nameless,
    /// A model of what is pressed or slid.
    #[error(transparent)]
    Linear(#[from] LinearAxis),
}

/// The file with `armature`, `damping` and `frictionloss` of a joint from a model, and with a passive `dcmotor` for each sinusoid
/// of the angle. Without a `name`, the joint is the file's only one.
///
/// # Errors
/// [`IntoMjcfError`], one sentence on what is wrong with the file, the name or the model.
pub fn into_mjcf(file: &str, name: Option<&str>, model: &Model) -> Result<String, IntoMjcfError> {
    let document = Document::parse(file)?;
    let root = document.root_element();
    if root.tag_name().name() != "mujoco" {
        return Err(IntoMjcfError::NotMjcf(root.tag_name().name().to_owned()));
    }
    let found = find_joint(root, name)?;
    let joint = Joint::of(model)?;
    let mut edits = Vec::new();
    let values = [
        ("armature", joint.inertia),
        ("damping", Joint::mean(joint.viscous)),
        ("frictionloss", Joint::mean(joint.coulomb_mnm)),
    ];
    for (key, value) in values {
        edits.push(set_attribute(file, found, key, &si(value)));
    }
    edits.extend(set_motors(root, found, &joint)?);
    // From the end on, so that places before an edit stay where they are.
    edits.sort_by_key(|edit| std::cmp::Reverse((edit.place.start, edit.place.end)));
    let mut text = file.to_owned();
    for Edit { place, with } in edits {
        text.replace_range(place, &with);
    }
    Ok(text)
}

/// A place of the file and what comes there instead.
struct Edit {
    place: Range<usize>,
    with: String,
}

fn find_joint<'a, 'input>(root: Node<'a, 'input>, name: Option<&str>) -> Result<Node<'a, 'input>, IntoMjcfError> {
    // Those of a body; joints elsewhere refer to them or are defaults.
    let in_body = |node: &Node<'_, '_>| {
        node.has_tag_name("joint") && node.parent().is_some_and(|parent| parent.has_tag_name("body"))
    };
    let joints: Vec<Node<'_, '_>> = root.descendants().filter(in_body).collect();
    let wanted: Vec<_> = joints.iter().filter(|joint| name.is_none() || joint.attribute("name") == name).collect();
    let known = || joints.iter().filter_map(|joint| joint.attribute("name")).collect::<Vec<_>>().join(", ");
    match (wanted.as_slice(), name) {
        ([joint], _) => Ok(**joint),
        (_, Some(name)) => Err(IntoMjcfError::Joint { problem: format!("it has no joint '{name}'"), known: known() }),
        (several, None) => {
            Err(IntoMjcfError::Joint { problem: format!("it has {} joints", several.len()), known: known() })
        }
    }
}

fn set_attribute(file: &str, node: Node<'_, '_>, key: &str, value: &str) -> Edit {
    match node.attribute_node(key) {
        Some(there) => Edit { place: there.range_value(), with: value.to_owned() },
        None => {
            let after_tag = node.range().start
                + 1
                + file[node.range().start + 1..].find(|letter: char| !is_name(letter)).unwrap_or(0);
            Edit { place: after_tag..after_tag, with: format!(" {key}=\"{value}\"") }
        }
    }
}

fn is_name(letter: char) -> bool {
    letter.is_alphanumeric() || "_-:.".contains(letter)
}

/// The motors of the joint's sinusoids in place of those that an earlier call wrote.
fn set_motors(root: Node<'_, '_>, found: Node<'_, '_>, joint: &Joint) -> Result<Vec<Edit>, IntoMjcfError> {
    let on = found.attribute("name");
    let prefix = format!("{}-angle-torque-", on.unwrap_or_default());
    let earlier = root.descendants().filter(|node| {
        node.has_tag_name("dcmotor") && node.attribute("name").is_some_and(|name| name.starts_with(&prefix))
    });
    let mut edits: Vec<Edit> = earlier.map(|node| Edit { place: node.range(), with: String::new() }).collect();
    if joint.sines.is_empty() {
        return Ok(edits);
    }
    let on = attribute(on.ok_or(IntoMjcfError::Nameless)?);
    let mut motors = String::from("  <actuator>\n");
    for (number, sine) in (1..).zip(&joint.sines) {
        let _ = writeln!(
            motors,
            "    <dcmotor name=\"{on}-angle-torque-{number}\" joint=\"{on}\" input=\"none\" motorconst=\"0\" resistance=\"1\" \
             cogging=\"{} {} {}\"/>",
            si(-sine.amplitude_mnm),
            sine.per_rad,
            sine.phase_rad
        );
    }
    motors.push_str("  </actuator>\n");
    // MJCF takes any number of such sections.
    let end = root.document().input_text()[..root.range().end].rfind("</").unwrap_or(root.range().end);
    edits.push(Edit { place: end..end, with: motors });
    Ok(edits)
}
