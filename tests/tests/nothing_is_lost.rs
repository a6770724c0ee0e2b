//! The worst that can happen to a capture, and what is still there.
#![allow(clippy::unwrap_used, reason = "a test may stop at a failure")]

use std::process::Child;
use std::time::{Duration, Instant};

use archive::Capture;
use iceoryx2::service::attribute::AttributeVerifier;
use iceoryx2::service::builder::publish_subscribe::PublishSubscribeOpenError;
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use shared_types::services::{self, RigNode, SampleSubscriber};
use shared_types::{BlockHeader, Sample, rig};
use tests::{Bench, printed};

/// What a run's recorder may lose when everything dies at once, ns: a chunk is closed at least so often.
const FLUSH_PERIOD_NS: u64 = 500_000_000;

/// Follows a capture in this process's memory: the truth that its archive is compared with.
struct Witness {
    subscriber: SampleSubscriber,
    samples: Vec<Sample>,
    _node: RigNode,
}

impl Witness {
    fn follow(bench: &Bench) -> Self {
        // SAFETY: benches take turns, so no other test reads the environment meanwhile, and nothing else here does.
        #[allow(unsafe_code, reason = "the environment names the rig")]
        unsafe {
            std::env::set_var(rig::RUNTIME_DIR_VARIABLE, bench.path("rig"));
        }
        let node = services::attach("witness").unwrap();
        Self { subscriber: services::sample_subscriber(&node).unwrap(), samples: Vec::new(), _node: node }
    }

    fn watch(&mut self, duration: Duration) {
        let end = Instant::now() + duration;
        while Instant::now() < end {
            self.take();
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    fn take(&mut self) {
        while let Some(block) = self.subscriber.receive().unwrap() {
            self.samples.extend_from_slice(block.payload());
        }
    }
}

fn start(bench: &Bench, duration_s: &str) -> Child {
    let child = bench.start(&["capture", "--duration-s", duration_s, "--no-viewer", "--out", "out"]).unwrap();
    bench.wait_for_process("recorder").unwrap();
    child
}

/// Asserts that every row is, bit for bit, the sample that was published under its `seq`.
fn assert_nothing_invented(capture: &Capture, witnessed: &[Sample]) {
    assert!(witnessed.iter().enumerate().all(|(index, sample)| sample.seq == index as u64), "the witness missed none");
    for (row, &seq) in capture.seq.iter().enumerate() {
        let Some(sample) = witnessed.get(usize::try_from(seq).unwrap()) else { continue };
        let recorded = [capture.angle_rad[row], capture.torque_mnm[row]].map(f64::to_bits);
        assert_eq!(recorded, [sample.angle_rad, sample.torque_mnm].map(f64::to_bits), "sample {seq}");
        assert_eq!(capture.tick[row], sample.tick);
    }
}

#[test]
fn everything_killed_at_once_costs_no_sample_older_than_the_flush_period() {
    let bench = Bench::new().unwrap();
    let mut child = start(&bench, "30");
    let mut witness = Witness::follow(&bench);
    witness.watch(Duration::from_millis(3_700));
    let programs = ["recorder", "rt-loop", "live-fitter", "haptic-camera"];
    let victims: Vec<Pid> = programs.iter().flat_map(|name| bench.processes(name)).collect();
    assert_eq!(victims.len(), programs.len(), "{victims:?}");
    let killed_ns = rig::monotonic_time_ns();
    for victim in victims {
        kill(victim, Signal::SIGKILL).unwrap();
    }
    child.wait().unwrap();
    witness.take();

    let part = bench.only_archive("out").unwrap();
    let before = std::fs::read(&part).unwrap();
    let name = part.to_string_lossy().into_owned();
    let archive = name.strip_suffix(".part-000").expect("a part, since nobody could close the archive").to_owned();
    let refused = bench.run(&["fit", &name]).unwrap();
    assert_eq!(refused.status.code(), Some(1));
    assert!(printed(&refused).contains("haptic-camera recover"), "{}", printed(&refused));

    let output = bench.run(&["recover", &archive, "--out", "fixed.mcap"]).unwrap();
    assert_eq!(output.status.code(), Some(3), "{}", printed(&output));
    assert_eq!(std::fs::read(&part).unwrap(), before, "the original is left as it was");
    let capture = Capture::load(&bench.path("fixed.mcap")).unwrap();
    assert!(printed(&output).contains(&format!("kept {} samples", capture.len())), "{}", printed(&output));
    assert_nothing_invented(&capture, &witness.samples);
    assert!(capture.seq.iter().enumerate().all(|(row, &seq)| seq == row as u64), "no gap before the end");
    let old = witness.samples.iter().filter(|sample| sample.monotonic_time_ns + FLUSH_PERIOD_NS < killed_ns).count();
    assert!(old > 10_000, "the run was under way");
    assert!(capture.len() >= old, "{} samples of {old} older than the flush period", capture.len());

    drop(witness);
    let output = bench.run(&["capture", "--duration-s", "1", "--no-viewer", "--out", "again"]).unwrap();
    assert_eq!(output.status.code(), Some(0), "the next capture starts at once: {}", printed(&output));
    assert_eq!(bench.leftovers(), Vec::<String>::new());
}

#[test]
fn a_recorder_stopped_for_longer_than_its_queue_loses_what_it_says_and_no_more() {
    let bench = Bench::new().unwrap();
    let child = start(&bench, "23");
    let mut witness = Witness::follow(&bench);
    witness.watch(Duration::from_secs(2));
    // The supervisor too, which would replace a recorder that hangs.
    let stopped = ["haptic-camera", "recorder"].map(|program| bench.wait_for_process(program).unwrap());
    stopped.iter().for_each(|&process| kill(process, Signal::SIGSTOP).unwrap());
    witness.watch(Duration::from_secs(19));
    let [supervisor, recorder] = stopped;
    kill(recorder, Signal::SIGCONT).unwrap();
    witness.watch(Duration::from_millis(700));
    kill(supervisor, Signal::SIGCONT).unwrap();
    while !child_has_ended(&bench) {
        witness.watch(Duration::from_millis(50));
    }
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(3), "{}", printed(&output));
    let capture = Capture::load(&bench.only_archive("out").unwrap()).unwrap();
    assert_nothing_invented(&capture, &witness.samples);
    let missing = capture.lost_samples();
    assert!(missing > 0);
    assert_eq!(capture.len() as u64 + missing, witness.samples.len() as u64, "kept and lost are all there were");
    for gap in &capture.gaps {
        assert!(printed(&output).contains(&gap.to_string()), "{gap} is not in {}", printed(&output));
    }
    assert_eq!(witness.samples.last().unwrap().tick, 229_999, "the loop had every tick of the run");
    drop(witness);
    assert_eq!(shared_types::clean_up::clear_shared_memory().unwrap(), 0);
}

fn child_has_ended(bench: &Bench) -> bool {
    bench.processes("haptic-camera").is_empty()
}

#[test]
fn a_consumer_built_from_other_types_is_refused_and_the_run_goes_on() {
    let bench = Bench::new().unwrap();
    let child = start(&bench, "3");
    let mut witness = Witness::follow(&bench);
    witness.watch(Duration::from_secs(1));
    let node = services::attach("another-build").unwrap();
    let samples = "haptic-camera/samples".try_into().unwrap();
    // Fields of another size; and the same size with another meaning, which only the layout identity tells.
    let other_size = node.service_builder(&samples).publish_subscribe::<[u64]>().open();
    assert!(matches!(other_size, Err(PublishSubscribeOpenError::IncompatibleTypes)), "{other_size:?}");
    let value = "0123456789abcdef".try_into().unwrap();
    let layout = AttributeVerifier::new().require(&"layout".try_into().unwrap(), &value).unwrap();
    let other_meaning = node
        .service_builder(&samples)
        .publish_subscribe::<[Sample]>()
        .user_header::<BlockHeader>()
        .open_with_attributes(&layout);
    assert!(matches!(other_meaning, Err(PublishSubscribeOpenError::IncompatibleAttributes)), "{other_meaning:?}");
    drop(node);
    while !child_has_ended(&bench) {
        witness.watch(Duration::from_millis(50));
    }
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
    let capture = Capture::load(&bench.only_archive("out").unwrap()).unwrap();
    assert_nothing_invented(&capture, &witness.samples);
    assert!(capture.gaps.is_empty());
    assert_eq!(capture.tick.last(), Some(&29_999), "the loop had every tick of the run");
    drop(witness);
    assert_eq!(shared_types::clean_up::clear_shared_memory().unwrap(), 0);
}
