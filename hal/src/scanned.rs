//! What a driver finds where it looks for its devices.

/// The devices at a target.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Scanned {
    /// What is there, for people, a line each.
    pub lines: Vec<String>,
    /// The text of a rig file to begin with; `None` where nothing was found to make one of.
    pub rig_file: Option<String>,
}
