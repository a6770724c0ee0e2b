//! What crosses a process border, and the schemas in foreign files.
#![no_main]

use archive::schema::Layout;
use libfuzzer_sys::fuzz_target;
use shared_types::{
    CommandKind, ControlRequest, Fault, FitUpdate, LoopState, LoopStatus, ModelAnswer, ModelChange, ProcessHealth,
    ProcessKind, RunDescription, Sample, Verdict,
};
use zerocopy::FromBytes as _;

fuzz_target!(|input: &[u8]| fuzz::bounded(input.len(), || {
    let Some((&kind, body)) = input.split_first() else { return };
    match kind {
        0 => schema(body),
        1 => {
            if let Some(change) = ModelChange::from_cdr_body(body) {
                assert_eq!(ModelChange::from_cdr_body(&change.cdr_body()), Some(change));
            }
        }
        2 => json(body),
        _ => fixed_size(body),
    }
}));

fn schema(body: &[u8]) {
    let Ok(layout) = Layout::parse(&String::from_utf8_lossy(body)) else { return };
    for field in &layout.fields {
        let _ = (field.as_f64(&[0xff; 64]), field.as_u64(&[0xff; 64]));
    }
}

fn json(body: &[u8]) {
    let _ = serde_json::from_slice::<ModelAnswer>(body);
    let _ = serde_json::from_slice::<ModelChange>(body);
    if let Ok(run) = serde_json::from_slice::<RunDescription>(body) {
        let _ = run.clock.wall_clock(u64::MAX);
    }
}

/// Bytes as another process may have left them in shared memory: every code of theirs has an answer.
fn fixed_size(body: &[u8]) {
    if let Ok((request, _)) = ControlRequest::read_from_prefix(body) {
        let _ = CommandKind::from_code(request.kind);
    }
    if let Ok((status, _)) = LoopStatus::read_from_prefix(body) {
        let _ = (LoopState::from_code(status.state), Fault::from_code(status.fault));
        assert!(LoopStatus::lateness_bin(status.max_lateness_ns) < status.lateness_counts.len());
    }
    if let Ok((health, _)) = ProcessHealth::read_from_prefix(body) {
        let _ = ProcessKind::from_code(health.process).map(ProcessKind::name);
    }
    if let Ok((sample, _)) = Sample::read_from_prefix(body) {
        let _ = sample.time_s(10_000.0);
    }
    if let Ok((update, _)) = FitUpdate::read_from_prefix(body) {
        for (_, estimate) in update.estimates() {
            let _ = Verdict::from_code(estimate.verdict);
        }
    }
}
