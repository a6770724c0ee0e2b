//! What a rig file says under `[settings]` of a bus and its devices.

use std::collections::BTreeMap;

use serde::Deserialize;

use super::entries::Entry;

/// The driver's settings.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// The network interface.
    pub interface: String,
    /// Whether the devices' clocks are kept together, and the ticks follow them.
    #[serde(default)]
    pub distributed_clocks: bool,
    /// The torque that the drive's target of 1000 stands for, mNm, where 0x6076 does not tell.
    pub rated_torque_mnm: Option<f64>,
    /// Encoder increments in a turn of the motor, where 0x608F does not tell.
    pub counts_per_turn: Option<f64>,
    /// The drive that turns the knob.
    pub drive: Device,
    /// Further devices, by the names that channels have for them.
    #[serde(default)]
    pub terminals: BTreeMap<String, Device>,
}

/// How a device is found, and how it is set before it runs.
///
/// Every key that is given must match.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Device {
    /// Its vendor.
    pub vendor: Option<u32>,
    /// Its product code.
    pub product: Option<u32>,
    /// Its configured station alias.
    pub alias: Option<u16>,
    /// Its place on the bus, from 0.
    pub position: Option<usize>,
    /// What is written to its objects before its process data are set up.
    #[serde(default)]
    pub startup: Vec<Startup>,
    /// The entries that it is to take, written to 0x1600; its own where nothing is said.
    pub outputs: Option<Vec<Entry>>,
    /// The entries that it is to give, written to 0x1A00; its own where nothing is said.
    pub inputs: Option<Vec<Entry>>,
}

/// A value that is written to an object.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Startup {
    /// The object's index.
    pub index: u16,
    /// Its subindex.
    #[serde(default)]
    pub subindex: u8,
    /// Its length: 8, 16 or 32 bits.
    pub bits: u8,
    /// The value.
    pub value: i64,
}

impl Device {
    /// In words, as the file has it.
    pub(super) fn in_words(&self) -> String {
        let keys = [
            self.vendor.map(|vendor| format!("vendor {vendor:#x}")),
            self.product.map(|product| format!("product {product:#x}")),
            self.alias.map(|alias| format!("alias {alias}")),
            self.position.map(|position| format!("position {position}")),
        ];
        let keys: Vec<String> = keys.into_iter().flatten().collect();
        if keys.is_empty() { "any device".to_owned() } else { keys.join(", ") }
    }
}
