//! Waveforms, tables and origins in model files.

use dynamics::{Effect, Model, TorqueTable, effects};

use crate::{drawing, effect};

#[test]
fn waveforms_tables_and_origins_survive_their_own_file() {
    for seed in 1..=100 {
        let (angle_rad, torque_mnm, period_rad) = drawing(seed);
        let table = TorqueTable::kept(&angle_rad, &torque_mnm, Some(period_rad)).unwrap();
        let model = Model {
            name: "all of them".to_owned(),
            description: String::new(),
            effects: vec![
                effect("inertia", &[0.1]).with_origin("knob 2; \"inertia\" set to 0.1\n\\ and more"),
                effect("detent-triangle", &[1.0, 0.1, 0.2]).with_origin("a.toml"),
                effect("detent-sawtooth", &[1.0 / 3.0, 0.1, 0.2, 0.9]),
                Effect::new(&effects::torque_table::KIND, &[-0.7]).with_table(table).with_origin("drawn.csv"),
                effect("torque-ramp", &[3.0, 0.1, 0.2]),
            ],
            ..Model::default()
        };
        let read = Model::from_toml(&model.to_toml(), "written").unwrap();
        assert_eq!(read, model);
        let origins = |model: &Model| model.effects.iter().map(Effect::origin).collect::<Vec<_>>();
        assert_eq!(origins(&read), origins(&model));
        assert!(std::ptr::eq(read.effects[3].table().unwrap(), table));
    }
}

#[test]
fn a_table_in_a_model_file_repeats_its_first_point_or_has_a_period() {
    let entry = "[[effects]]\neffect = \"torque-table\"\nangle_rad = [0, 0.1, 0.2, 0.4]\n";
    let repeating = format!("{entry}torque_mnm = [0.0, 3.0, -3.0, 0.0]\n");
    let model = Model::from_toml(&repeating, "drawn").unwrap();
    let table = model.effects[0].table().unwrap();
    assert_eq!((table.period_rad(), table.points().len(), model.effects[0].values()), (Some(0.4), 3, &[1.0][..]));

    let with_period = format!("{entry}torque_mnm = [0.0, 3.0, -3.0, 1.0]\nperiod_rad = 0.5\ntable_scale = 2\n");
    let model = Model::from_toml(&with_period, "drawn").unwrap();
    let at = |angle_rad| model.free_torque_mnm(&dynamics::Motion { angle_rad, ..dynamics::Motion::default() });
    assert!((at(0.1 - 0.5) - 6.0).abs() < 1e-9 && (at(0.4 + 1.0) - 2.0).abs() < 1e-9);
}

#[test]
fn a_wrong_waveform_gets_one_sentence_that_says_what_would_do() {
    let table = "[[effects]]\neffect = \"torque-table\"\n";
    let cases = [
        (format!("{table}angle_rad = [0, 1, 2]\n"), "lacks 'torque_mnm'; its parameters are table_scale, angle_rad"),
        (format!("{table}angle_rad = 3\ntorque_mnm = [1, 2]\n"), "needs a list of numbers for 'angle_rad'"),
        (format!("{table}angle_rad = [0, 1, 2]\ntorque_mnm = [0, 1, \"2\"]\n"), "a list of numbers for 'torque_mnm'"),
        (
            format!("{table}angle_rad = [0, 1, 2]\ntorque_mnm = [0, 10, 1]\n"),
            "a jump of 1.000000 mNm where 0.010000 mNm is allowed; end it on the first torque",
        ),
        (
            format!("{table}angle_rad = [0, 1, 2]\ntorque_mnm = [0, nan, 0]\n"),
            "point 2 of the table has torque_mnm NaN",
        ),
        (
            format!("{table}angle_rad = [0, 1, 2]\ntorque_mnm = [0, 1, 0]\nperiod_rad = \"x\"\n"),
            "number for 'period_rad'",
        ),
        ("[[effects]]\neffect = \"inertia\"\ninertia = 1\nangle_rad = [1]\n".to_owned(), "no parameter 'angle_rad'"),
        ("[[effects]]\neffect = \"inertia\"\ninertia = 1\norigin = 3\n".to_owned(), "needs text for 'origin'"),
        (
            "[[effects]]\neffect = \"detent-sawtooth\"\nsawtooth_amplitude = 1\nsawtooth_period = 0.1\n\
             sawtooth_phase = 0\nsawtooth_rising_share = 1\n"
                .to_owned(),
            "sawtooth_rising_share is 1, but it must be more than zero and less than one",
        ),
    ];
    for (text, expected) in cases {
        let message = Model::from_toml(&text, "knob.toml").unwrap_err().to_string();
        assert!(message.contains(expected) && message.starts_with("knob.toml"), "{message}");
    }
}
