//! What formats leave out, and what becomes of somebody's own file.

#![allow(clippy::unwrap_used, reason = "a test panics")]

use dynamics::effects::{detent, friction, inertia, torque_offset};
use dynamics::{Axis, Effect, Model, Motion};
use simulator_formats::{fmi, into_mjcf, isaac_lab, left_out_mnm, mjcf, smartknob, urdf};

const ROBOT: &str = "<mujoco>\n  <worldbody>\n    <body name=\"cap\"><joint name='volume' damping='7'/><!-- kept --></body>\n  \
                     </worldbody>\n</mujoco>\n";

fn knob(viscous: [f64; 2]) -> Model {
    Model {
        name: "a knob -- of <three> parts".to_owned(),
        description: String::new(),
        effects: vec![
            Effect::new(&inertia::KIND, &[0.05]),
            Effect::new(&friction::KIND, &[2.0, 3.0, viscous[0], viscous[1]]),
            Effect::new(&detent::KIND, &[1.5, 0.034, 0.4]),
            Effect::new(&torque_offset::KIND, &[5.0]),
        ],
        ..Model::default()
    }
}

fn turning_at(velocity_rad_s: f64) -> Vec<Motion> {
    let at = |time_s: f64| Motion { time_s, angle_rad: velocity_rad_s * time_s, velocity_rad_s, ..Motion::default() };
    (0..5000).map(|sample| at(1e-3 * f64::from(sample))).collect()
}

#[test]
fn what_is_left_out_is_reported_as_torque() {
    let differs = knob([0.1, 0.3]);
    let export = mjcf(&differs).unwrap();
    // Half of the difference, times the speed; what the sensor misreads is no part of the knob.
    assert!((left_out_mnm(&differs, &export.said, &turning_at(2.0)) - 0.1 * 2.0).abs() < 1e-12);
    assert!(left_out_mnm(&knob([0.2; 2]), &mjcf(&knob([0.2; 2])).unwrap().said, &turning_at(2.0)) < 1e-12);
    assert!(export.left_out.iter().any(|words| words.contains("differs by direction")), "{:?}", export.left_out);
    // Of URDF the detents too, and Coulomb friction that differs by direction.
    let lost = left_out_mnm(&knob([0.2; 2]), &urdf(&knob([0.2; 2])).unwrap().said, &turning_at(2.0));
    let expected = (0.5_f64.powi(2) + 0.5 * 1.5_f64.powi(2)).sqrt();
    assert!((lost - expected).abs() < 0.02, "{lost} is not {expected}");
}

#[test]
fn names_end_neither_comments_nor_attributes() {
    for export in [mjcf(&knob([0.1, 0.3])), urdf(&knob([0.1, 0.3]))] {
        roxmltree::Document::parse(&export.unwrap().content).unwrap();
    }
}

#[test]
fn a_joint_is_written_to_and_nothing_else() {
    let once = into_mjcf(ROBOT, None, &knob([0.1, 0.3])).unwrap();
    assert_eq!(into_mjcf(&once, Some("volume"), &knob([0.1, 0.3])).unwrap().matches("<dcmotor").count(), 1);
    let document = roxmltree::Document::parse(&once).unwrap();
    let joint = document.descendants().find(|node| node.has_tag_name("joint")).unwrap();
    let number = |key: &str| joint.attribute(key).unwrap().parse::<f64>().unwrap();
    assert!((number("armature") - 5e-5).abs() < 1e-18 && (number("damping") - 2e-4).abs() < 1e-18);
    assert!((number("frictionloss") - 2.5e-3).abs() < 1e-18);
    assert!(once.contains("<!-- kept -->"));
}

#[test]
fn a_file_without_the_joint_is_refused_in_one_sentence() {
    let model = knob([0.1, 0.3]);
    let two = ROBOT.replace("<!-- kept -->", "<joint name='tilt'/>");
    let refused = [
        ("no xml", None, "it is not XML"),
        ("<robot/>", None, "its root is <robot>"),
        ("<mujoco/>", None, "it has 0 joints"),
        (two.as_str(), None, "it has 2 joints; name one of its joints: volume, tilt"),
        (ROBOT, Some("tilt"), "it has no joint 'tilt'; name one of its joints: volume"),
    ];
    for (file, name, words) in refused {
        let error = into_mjcf(file, name, &model).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
    let nameless = ROBOT.replace("name='volume'", "");
    assert!(into_mjcf(&nameless, None, &model).unwrap_err().to_string().contains("give it one"));
}

#[test]
fn a_model_of_what_is_pressed_is_refused_by_every_format_of_what_turns() {
    let pressed = Model { axis: Axis::Linear, ..knob([0.1, 0.3]) };
    let refusals = [
        mjcf(&pressed).unwrap_err().to_string(),
        urdf(&pressed).unwrap_err().to_string(),
        isaac_lab(&pressed).unwrap_err().to_string(),
        smartknob(&pressed, 10.0, &[]).unwrap_err().to_string(),
        fmi::fmu(&pressed, b"library").unwrap_err().to_string(),
        into_mjcf(ROBOT, None, &pressed).unwrap_err().to_string(),
    ];
    for refusal in refusals {
        assert!(refusal.contains("has a linear axis") && refusal.ends_with("as .csv"), "{refusal}");
    }
}
