//! The bytes of a payload mean what the schema in the archive says.

#![allow(clippy::unwrap_used, reason = "tests")]

mod common;

use archive::schema::{Layout, SchemaError};
use shared_types::wire::WireMessage;
use shared_types::{FitUpdate, LoopStatus, ProcessHealth, Sample};

fn layout<Payload: WireMessage>() -> Layout {
    let layout = Layout::parse(&Payload::schema_text()).unwrap();
    assert_eq!(layout.size, Some(size_of::<Payload>()), "{}", Payload::SCHEMA_NAME);
    for field in Payload::fields() {
        let nested = format!("{}.", field.name);
        let found = layout.fields.iter().find(|found| found.name == field.name || found.name.starts_with(&nested));
        assert_eq!(found.unwrap().offset, field.offset, "{} of {}", field.name, Payload::SCHEMA_NAME);
    }
    layout
}

#[test]
fn every_field_of_a_sample_decodes_through_the_schema_text() {
    let sample = Sample {
        dropped_samples: 11,
        fault: 5,
        flags: 1,
        measured_after_s: 2e-5,
        device_code: 7,
        stale_ticks: 3,
        ..common::sample(123_456)
    };
    let layout = layout::<Sample>();
    let bytes = sample.wire_bytes();
    let count = |name: &str| layout.field(name).unwrap().as_u64(bytes).unwrap();
    let real = |name: &str| layout.field(name).unwrap().as_f64(bytes).unwrap().to_bits();
    // All fields by name: one that is added without a test does not compile.
    let Sample {
        seq,
        tick,
        monotonic_time_ns,
        lateness_ns,
        angle_rad,
        velocity_rad_s,
        acceleration_rad_s2,
        torque_mnm,
        contact,
        commanded_angle_rad,
        commanded_torque_mnm,
        measured_after_s,
        sensor_read_ns,
        control_ns,
        push_ns,
        missed_ticks,
        dropped_samples,
        state,
        fault,
        flags,
        device_code,
        stale_ticks,
    } = sample;
    assert_eq!(count("seq"), seq);
    assert_eq!(count("tick"), tick);
    assert_eq!(count("monotonic_time_ns"), monotonic_time_ns);
    assert_eq!(count("lateness_ns"), lateness_ns);
    assert_eq!(real("angle_rad"), angle_rad.to_bits());
    assert_eq!(real("velocity_rad_s"), velocity_rad_s.to_bits());
    assert_eq!(real("acceleration_rad_s2"), acceleration_rad_s2.to_bits());
    assert_eq!(real("torque_mnm"), torque_mnm.to_bits());
    assert_eq!(real("contact"), contact.to_bits());
    assert_eq!(real("commanded_angle_rad"), commanded_angle_rad.to_bits());
    assert_eq!(real("commanded_torque_mnm"), commanded_torque_mnm.to_bits());
    assert_eq!(count("sensor_read_ns"), u64::from(sensor_read_ns));
    assert_eq!(count("control_ns"), u64::from(control_ns));
    assert_eq!(count("push_ns"), u64::from(push_ns));
    assert_eq!(count("missed_ticks"), u64::from(missed_ticks));
    assert_eq!(count("dropped_samples"), u64::from(dropped_samples));
    assert_eq!(count("state"), u64::from(state));
    assert_eq!(count("fault"), u64::from(fault));
    assert_eq!(count("flags"), u64::from(flags));
    assert_eq!(real("measured_after_s"), measured_after_s.to_bits());
    assert_eq!(count("device_code"), u64::from(device_code));
    assert_eq!(count("stale_ticks"), u64::from(stale_ticks));
}

#[test]
fn nested_structs_and_arrays_lie_where_the_schema_says() {
    let mut update = FitUpdate::default();
    update.detent_phase.ci95_high = 0.1 + 0.2;
    let phase = layout::<FitUpdate>().field("detent_phase.ci95_high").unwrap().as_f64(update.wire_bytes());
    assert_eq!(phase.unwrap().to_bits(), (0.1_f64 + 0.2).to_bits());

    let mut status = LoopStatus { process_id: 4711, ..LoopStatus::default() };
    status.lateness_counts[0] = 99;
    let status_layout = layout::<LoopStatus>();
    let counts = status_layout.field("lateness_counts").unwrap();
    assert_eq!((counts.count, counts.as_u64(status.wire_bytes())), (12, Some(99)));
    assert_eq!(status_layout.field("process_id").unwrap().as_u64(status.wire_bytes()), Some(4711));

    layout::<ProcessHealth>();
}

#[test]
fn a_bound_and_a_default_value_are_no_constant() {
    let layout = Layout::parse("uint8 ONE = 1\nuint16 a 3\nfloat64 b\nstring<=8 name \"c=d\"\nuint8 e\n").unwrap();
    let places: Vec<(&str, usize)> = layout.fields.iter().map(|field| (field.name.as_str(), field.offset)).collect();
    assert_eq!((places, layout.size), (vec![("a", 0), ("b", 8)], None));
    assert_eq!(Layout::parse("int32[<=5] a\nuint8 b\n").unwrap().size, None);
}

#[test]
fn cdr_aligns_each_primitive_to_its_own_size() {
    let layout = Layout::parse(
        "# comment only\nuint8 MARK=7\nbool a\nuint16 b\nbyte c\nfloat32 d\nint8[3] e\nfloat64 f\nInner[2] g\nint64 h\n\
         ===\nMSG: pkg/Inner\nuint8 x\nuint32 y\n",
    )
    .unwrap();
    let places: Vec<(&str, usize)> = layout.fields.iter().map(|field| (field.name.as_str(), field.offset)).collect();
    assert_eq!(
        places,
        [
            ("a", 0),
            ("b", 2),
            ("c", 4),
            ("d", 8),
            ("e", 12),
            ("f", 16),
            ("g[0].x", 24),
            ("g[0].y", 28),
            ("g[1].x", 32),
            ("g[1].y", 36),
            ("h", 40)
        ]
    );
}

#[test]
fn fields_behind_one_of_variable_size_have_no_place() {
    let layout = Layout::parse("uint64 seq\nstring name\nfloat64 torque_mnm\n").unwrap();
    assert!(layout.field("seq").is_some());
    assert!(layout.field("torque_mnm").is_none());
    assert_eq!(layout.size, None);
}

#[test]
fn a_schema_that_makes_no_sense_is_refused() {
    assert!(matches!(Layout::parse("float64\n"), Err(SchemaError::NotAField { line: 1, .. })));
    assert!(matches!(Layout::parse("Thing x\n"), Err(SchemaError::UnknownType { .. })));
    assert!(matches!(Layout::parse("p/A x\n===\nMSG: p/A\np/A x\n"), Err(SchemaError::TooLarge)));
    assert!(matches!(Layout::parse("p/A[99999999] x\n===\nMSG: p/A\nuint8 x\n"), Err(SchemaError::TooLarge)));
    // Of types without a field there could be any number.
    let endless = "p/A[999999999999999999] x\n===\nMSG: p/A\n# nothing\n";
    assert!(matches!(Layout::parse(endless), Err(SchemaError::TooLarge)));
    let towering: String = (0..10).map(|level| format!("===\nMSG: p/L{level}\np/L{}[99] x\n", level + 1)).collect();
    assert!(matches!(Layout::parse(&format!("p/L0 x\n{towering}===\nMSG: p/L10\n")), Err(SchemaError::TooLarge)));
}

#[test]
fn names_that_repeat_in_every_element_of_an_array_are_bounded() {
    // 60 kB that would become 6 GB of names.
    let long = format!("p/T[99000] {}\n===\nMSG: p/T\nuint8 x\n", "a".repeat(60_000));
    assert!(matches!(Layout::parse(&long), Err(SchemaError::TooLarge)));
}
