//! Layout and schema are one definition; another definition is refused.
#![allow(clippy::unwrap_used, reason = "a test may stop at a failure")]

use iceoryx2::service::attribute::AttributeVerifier;
use shared_types::services::{self, LOOP_STATUS, ServiceError};
use shared_types::wire::WireMessage;
use shared_types::{
    ControlRequest, ControlResponse, Estimate, Fault, FitUpdate, LoopState, LoopStatus, ProcessHealth, Sample,
};

#[test]
fn every_payload_is_as_long_as_its_fields_without_padding() {
    fn check<Message: WireMessage>() {
        let fields = Message::fields();
        let mut expected = 0;
        for field in &fields {
            assert_eq!(field.offset, expected, "{} of {}", field.name, Message::SCHEMA_NAME);
            expected += match field.ros_type.as_str() {
                "uint64" | "float64" => 8,
                "uint32" => 4,
                "uint64[12]" => 96,
                "haptic_camera/Estimate" => 32,
                other => panic!("no size known for {other}"),
            };
        }
        assert_eq!(expected, size_of::<Message>());
    }
    check::<Sample>();
    check::<Estimate>();
    check::<FitUpdate>();
    check::<LoopStatus>();
    check::<ProcessHealth>();
}

#[test]
fn a_schema_carries_the_definitions_it_uses_once() {
    let text = FitUpdate::schema_text();
    assert_eq!(text.matches("MSG: haptic_camera/Estimate").count(), 1);
    assert!(text.contains("haptic_camera/Estimate inertia"));
}

#[test]
fn wire_codes_stand_for_one_meaning_each() {
    for code in 0..10 {
        assert!(LoopState::from_code(code).is_none_or(|state| state.code() == code));
        assert!(Fault::from_code(code).is_none_or(|fault| fault.code() == code));
    }
    assert_eq!(LoopState::from_code(77), None);
}

#[test]
fn a_process_built_from_another_layout_is_refused_with_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    // SAFETY: this test binary sets the variable in one thread before any other reads it.
    #[allow(unsafe_code, reason = "the environment names the rig")]
    unsafe {
        std::env::set_var(shared_types::rig::RUNTIME_DIR_VARIABLE, folder.path());
    }
    let node = services::attach("another-build").unwrap();
    // The same payload by name and size, but with other fields: only the layout identity tells.
    let layout = AttributeVerifier::new()
        .require(&"layout".try_into().unwrap(), &"0123456789abcdef".try_into().unwrap())
        .unwrap();
    let other = node
        .service_builder(&"haptic-camera/loop-status".try_into().unwrap())
        .publish_subscribe::<LoopStatus>()
        .open_or_create_with_attributes(&layout)
        .unwrap();
    // A payload of another type altogether.
    let stranger = node
        .service_builder(&"haptic-camera/samples".try_into().unwrap())
        .publish_subscribe::<[u64]>()
        .open_or_create()
        .unwrap();

    let other_commands = node
        .service_builder(&"haptic-camera/control".try_into().unwrap())
        .request_response::<ControlRequest, ControlResponse>()
        .open_or_create_with_attributes(&layout)
        .unwrap();

    let control = services::control_client(&node).unwrap_err();
    assert!(matches!(control, ServiceError::OtherLayout { .. }), "{control}");
    let status = LOOP_STATUS.subscriber(&node).unwrap_err();
    assert!(matches!(status, ServiceError::OtherLayout { .. }), "{status}");
    assert!(status.to_string().contains("use programs of the same build"));
    let samples = services::sample_subscriber(&node).unwrap_err();
    assert!(matches!(samples, ServiceError::OtherLayout { .. }), "{samples}");
    drop((other, stranger, other_commands, node));
    assert_eq!(shared_types::clean_up::clear_shared_memory().unwrap(), 0, "nothing is left");
}
