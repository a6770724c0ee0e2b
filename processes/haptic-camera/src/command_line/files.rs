//! The files that each command reads and writes, as its options name them.

use std::path::PathBuf;

use analysis::ends_in;
use archive::whole_file::Replace;

use super::Command;
use super::outputs::{Files, is_same, kind};
use crate::calibrate::CalibrateOptions;
use crate::export::ExportOptions;
use crate::rigs::RigCommand;
use crate::simulate::SimulateOptions;
use crate::studies::StudyOptions;

impl Command {
    pub fn files(&self) -> Files {
        let files = Files::default();
        let study = |study: &StudyOptions| {
            Files::default().reading(&study.captures).reading(&study.values).writing(&study.json, kind::JSON)
        };
        match self {
            Self::Capture(options) => files
                .reading(&options.request.knob)
                .reading(&options.spec)
                .reading(&options.request.rig.rig)
                .reading(&options.request.rig.calibration)
                .telling(&options.results)
                .writing(&options.recording, kind::RECORDING),
            Self::Replay(options) => files
                .reading([&options.model, &options.hand.hand])
                .reading(&options.rig.rig)
                .reading(&options.rig.calibration)
                .telling(&options.results),
            Self::Fit(options) => files
                .reading(&options.captures)
                .telling(&options.results)
                .writing(&options.out, kind::FITTED_MODEL)
                // The file is changed in place.
                .writing(&options.into, Replace::Anything),
            Self::Diagnose(options) => files
                .reading([&options.train])
                .reading(&options.heldout)
                .reading(&options.model)
                .telling(&options.results)
                .writing(&options.out, kind::DIAGNOSED_MODEL)
                .writing(&options.recording, kind::RECORDING),
            Self::Calibrate(options) => files
                .reading(&options.captures)
                .reading(&options.rig.request.rig)
                .writing(&options.out, options.replaced()),
            Self::RigTest(options) => files
                .reading(&options.rig.request.rig)
                .reading(&options.rig.request.calibration)
                .telling(&options.results),
            Self::Check(options) => {
                files.reading(&options.captures).reading(&options.model).writing(&options.json, kind::JSON)
            }
            Self::Compare(options) => files.reading(&options.subjects).telling(&options.results),
            Self::Judge(options) => files.reading(&options.captures).reading([&options.spec]).telling(&options.results),
            Self::Capability(options) => {
                study(&options.study).reading([&options.spec]).writing(&options.dfq, kind::QDAS)
            }
            Self::Gauge(options) => study(&options.study).reading(&options.spec),
            Self::Sheet(options) => files
                .reading(&options.captures)
                .reading(&options.dynamic)
                .telling(&options.results)
                .writing(&options.csv, kind::FIGURES)
                .writing(&options.wall, kind::PAGE),
            Self::Simulate(options) => {
                files.reading([&options.model, &options.like]).writing(&options.out, options.kind())
            }
            Self::Export(options) => files
                .reading([&options.source])
                .reading(&options.along)
                .writing(&options.out, options.kind())
                .writing(options.isaac_lab().as_ref(), kind::JSON),
            Self::Table(options) => files.reading(&options.spec).writing(&options.out, kind::DATA),
            Self::Trend(options) => files.reading([&options.table]).telling(&options.results),
            Self::List(options) => files.writing(&options.json, kind::JSON),
            Self::Recompute(options) => files.reading([&options.capture]).writing(&options.json, kind::JSON),
            Self::Recover(options) => files.reading([&options.broken]).writing(&options.out, kind::DATA),
            Self::Rig(RigCommand::Check(options)) => {
                files.reading([&options.rig.file]).writing(&options.json, kind::JSON)
            }
            Self::Rig(RigCommand::Commission(options)) => files.writing(options.written(), options.replaced()),
            Self::Rig(RigCommand::New { out, .. }) => files.writing(out, kind::DATA),
            Self::Rig(RigCommand::Scan { out, .. }) => files.writing(out, kind::DATA),
            Self::Compose(options) => files.reading(options.sources()).writing(&options.out, options.replaced()),
            // `man` writes into a folder.
            Self::Man { .. }
            | Self::Tune(_)
            | Self::View(_)
            | Self::Doctor(_)
            | Self::Rig(RigCommand::List)
            | Self::Completions { .. } => files,
        }
    }
}

impl CalibrateOptions {
    /// What the calibration may replace: the one that was given, or an earlier output.
    pub fn replaced(&self) -> Replace {
        let is_given = self.rig.request.calibration.as_deref().is_some_and(|given| is_same(given, &self.out));
        if is_given { Replace::Anything } else { kind::CALIBRATION }
    }
}

impl SimulateOptions {
    pub fn writes_table(&self) -> bool {
        self.out.as_deref().is_some_and(|out| ends_in(out, "csv"))
    }

    fn kind(&self) -> Replace {
        if self.writes_table() { kind::DATA } else { kind::SIMULATION }
    }
}

impl ExportOptions {
    /// The file of Isaac Lab's fields, next to a URDF file.
    pub fn isaac_lab(&self) -> Option<PathBuf> {
        ends_in(&self.out, "urdf").then(|| self.out.with_extension("isaac.json"))
    }

    fn kind(&self) -> Replace {
        let ending = self.out.extension().map(|ending| ending.to_string_lossy().to_lowercase());
        match ending.as_deref() {
            Some("h") => kind::HEADER,
            Some("xml" | "urdf" | "fmu") => kind::SIMULATOR,
            Some("json") => kind::JSON,
            _ => kind::DATA,
        }
    }
}
