//! The files that each command reads and writes, as its options name them.

use std::path::PathBuf;

use archive::whole_file::Replace;

use super::Command;
use crate::calibrate::CalibrateOptions;
use crate::export::ExportOptions;
use crate::outputs::{Files, Kind, is_same};
use crate::rigs::RigCommand;
use crate::simulate::SimulateOptions;

impl Command {
    /// The files to check before the command starts.
    pub fn files(&self) -> Files {
        let files = Files::default();
        match self {
            Self::Capture(options) => files
                .reading(&options.request.knob)
                .reading(&options.spec)
                .reading(&options.request.rig.rig)
                .reading(&options.request.rig.calibration)
                .writing(options.json.as_ref(), Kind::Json)
                .writing(options.report.as_ref(), Kind::Page)
                .writing(options.recording.as_ref(), Kind::Recording),
            Self::Replay(options) => files
                .reading([&options.model, &options.hand.hand])
                .reading(&options.rig.rig)
                .reading(&options.rig.calibration)
                .writing(options.json.as_ref(), Kind::Json)
                .writing(options.report.as_ref(), Kind::Page),
            Self::Fit(options) => files
                .reading(&options.captures)
                .writing(options.json.as_ref(), Kind::Json)
                .writing(options.out.as_ref(), Kind::FittedModel)
                .writing(options.report.as_ref(), Kind::Page)
                // The file is changed in place.
                .replacing(options.into.as_ref(), Replace::Anything),
            Self::Diagnose(options) => files
                .reading([&options.train])
                .reading(&options.heldout)
                .reading(&options.model)
                .writing(options.json.as_ref(), Kind::Json)
                .writing(options.out.as_ref(), Kind::DiagnosedModel)
                .writing(options.report.as_ref(), Kind::Page)
                .writing(options.recording.as_ref(), Kind::Recording),
            Self::Calibrate(options) => {
                // The given calibration may be overwritten.
                files.reading(&options.captures).replacing(Some(&options.out), options.replaced())
            }
            Self::RigTest(options) => files
                .reading(&options.rig.request.calibration)
                .writing(options.json.as_ref(), Kind::Json)
                .writing(options.report.as_ref(), Kind::Page),
            Self::Check(options) => {
                files.reading(&options.captures).reading(&options.model).writing(options.json.as_ref(), Kind::Json)
            }
            Self::Compare(options) => files
                .reading(&options.subjects)
                .writing(options.json.as_ref(), Kind::Json)
                .writing(options.report.as_ref(), Kind::Page),
            Self::Judge(options) => files
                .reading(&options.captures)
                .reading([&options.spec])
                .writing(options.json.as_ref(), Kind::Json)
                .writing(options.report.as_ref(), Kind::Page),
            Self::Capability(options) => files
                .reading(&options.study.captures)
                .reading(&options.study.values)
                .reading([&options.spec])
                .writing(options.study.json.as_ref(), Kind::Json)
                .writing(options.dfq.as_ref(), Kind::Qdas),
            Self::Gauge(options) => files
                .reading(&options.study.captures)
                .reading(&options.study.values)
                .reading(&options.spec)
                .writing(options.study.json.as_ref(), Kind::Json),
            Self::Sheet(options) => files
                .reading(&options.captures)
                .reading(&options.dynamic)
                .writing(options.json.as_ref(), Kind::Json)
                .writing(options.csv.as_ref(), Kind::Figures)
                .writing(options.wall.as_ref(), Kind::Page)
                .writing(options.report.as_ref(), Kind::Page),
            Self::Simulate(options) => {
                files.reading([&options.model, &options.like]).writing(options.out.as_ref(), options.kind())
            }
            Self::Export(options) => files
                .reading([&options.source])
                .reading(&options.along)
                .writing(Some(&options.out), options.kind())
                .writing(options.isaac_lab().as_ref(), Kind::Json),
            Self::Table(options) => files.reading(&options.spec).writing(Some(&options.out), Kind::Data),
            Self::Trend(options) => files
                .reading([&options.table])
                .writing(options.json.as_ref(), Kind::Json)
                .writing(options.report.as_ref(), Kind::Page),
            Self::List(options) => files.writing(options.json.as_ref(), Kind::Json),
            Self::Recompute(options) => files.reading([&options.capture]).writing(options.json.as_ref(), Kind::Json),
            Self::Recover(options) => files.reading([&options.broken]).writing(Some(&options.out), Kind::Data),
            Self::Rig(RigCommand::Check(options)) => {
                files.reading([&options.file]).writing(options.json.as_ref(), Kind::Json)
            }
            // `compose` checks its own output, because of `--overwrite`; `man` writes into a folder.
            Self::Compose(_)
            | Self::Man(_)
            | Self::Tune(_)
            | Self::View(_)
            | Self::Doctor(_)
            | Self::Rig(_)
            | Self::Completions(_) => files,
        }
    }
}

impl CalibrateOptions {
    /// What the calibration may replace: the one that was given, or an earlier output.
    #[must_use]
    pub fn replaced(&self) -> Replace {
        let is_given = self.rig.request.calibration.as_deref().is_some_and(|given| is_same(given, &self.out));
        if is_given { Replace::Anything } else { Kind::Calibration.replaces() }
    }
}

impl SimulateOptions {
    /// Whether the simulated capture is written as a table.
    #[must_use]
    pub fn writes_table(&self) -> bool {
        self.out.as_ref().is_some_and(|out| out.extension().is_some_and(|extension| extension == "csv"))
    }

    fn kind(&self) -> Kind {
        if self.writes_table() { Kind::Data } else { Kind::Simulation }
    }
}

impl ExportOptions {
    /// The file of Isaac Lab's fields, next to a URDF file.
    #[must_use]
    pub fn isaac_lab(&self) -> Option<PathBuf> {
        let is_urdf = self.out.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("urdf"));
        is_urdf.then(|| self.out.with_extension("isaac.json"))
    }

    fn kind(&self) -> Kind {
        let ending = self.out.extension().map(|ending| ending.to_string_lossy().to_lowercase());
        match ending.as_deref() {
            Some("h") => Kind::Header,
            Some("xml" | "urdf" | "fmu") => Kind::Simulator,
            Some("json") => Kind::Json,
            _ => Kind::Data,
        }
    }
}
