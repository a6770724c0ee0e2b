//! Recorder, live fitter and viewer: started, brought back when they die or hang, ended.

use std::path::Path;
use std::time::{Duration, Instant};

use shared_types::ProcessKind;

use super::consumer::Consumer;
use super::loop_link::LoopLink;
use super::words::Words;
use crate::terminal;
use crate::until_ci::Share;

/// After the run a recorder that cannot be started, or dies at once, is tried for so long.
const RECORDER_BACK: Duration = Duration::from_secs(10);

pub(crate) struct Consumers {
    recorder: Consumer,
    others: Vec<Consumer>,
    words: Words,
}

impl Consumers {
    /// Starts them, off the control loop's core where there is another. Only the recorder is indispensable.
    pub(crate) fn start(
        archive: &Path,
        viewer: Option<&str>,
        until: Option<Share>,
        loop_core: u32,
    ) -> anyhow::Result<Self> {
        let words = Words::apart_from_panel(terminal::size().is_some());
        let out = vec![format!("--out={}", archive.display())];
        let mut recorder = Consumer::new(ProcessKind::Recorder, out, loop_core);
        recorder.start(&words)?;
        let share = until.map(|share| format!("--share={}", share.get())).into_iter().collect();
        let mut others = vec![Consumer::new(ProcessKind::LiveFitter, share, loop_core)];
        others.extend(viewer.map(|place| Consumer::new(ProcessKind::Viewer, vec![place.to_owned()], loop_core)));
        others.iter_mut().for_each(|consumer| consumer.try_to_start(&words));
        Ok(Self { recorder, others, words })
    }

    pub(crate) fn revive(&mut self, link: &LoopLink) {
        let Self { recorder, others, words } = self;
        words.tell();
        for consumer in others.iter_mut().chain([recorder]) {
            consumer.end_if_hung(link);
            consumer.revive(words);
        }
    }

    /// Waits for the recorder to close the archive, starting it again if it dies on the way while the `source` lives that
    /// it must hear from; gives its exit code.
    pub(crate) fn finish_recorder(
        &mut self,
        patience: Duration,
        mut source_lives: impl FnMut() -> bool,
    ) -> Option<i32> {
        let deadline = Instant::now() + patience;
        let mut seen_alive = Instant::now();
        while Instant::now() < deadline {
            let source_lives = source_lives();
            self.words.tell();
            self.recorder.end_if_stopped();
            if self.recorder.is_away() {
                let exit = self.recorder.child().and_then(|child| child.exit_code());
                if matches!(exit, Some(0 | 3)) || !source_lives || seen_alive.elapsed() > RECORDER_BACK {
                    return exit;
                }
                self.recorder.revive(&self.words);
            } else if self.recorder.has_lived() {
                seen_alive = Instant::now();
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        let child = self.recorder.child()?;
        child.end(Duration::from_secs(5));
        child.exit_code()
    }

    /// Ends whatever still runs; gives the restarts of each.
    pub(crate) fn end(mut self) -> Vec<(ProcessKind, u32)> {
        let Self { recorder, others, words } = &mut self;
        let mut all: Vec<&mut Consumer> = [recorder].into_iter().chain(others).collect();
        for child in all.iter_mut().filter_map(|consumer| consumer.child()) {
            child.let_go();
        }
        for child in all.iter_mut().filter_map(|consumer| consumer.child()) {
            child.end(Duration::from_secs(4));
        }
        words.tell();
        all.iter().map(|consumer| (consumer.kind, consumer.restarts())).collect()
    }
}
