//! The groups of a measurement, their channels, and the values of one.

use falcon_mdf::blocks::ChannelType;
use falcon_mdf::model::{Channel, ChannelGroup, DataGroup, ValueKind};
use falcon_mdf::{Mf4Error, Mf4File};
use shared_types::Quantity;

use super::in_words;
use crate::memory;

/// Most bytes that deflate makes of one, by its format.
const DEFLATE: u64 = 1032;
/// Copies of a group's values that are held at once, for each of its channels that is taken.
const COPIES: f64 = 4.0;
/// Bytes of a block's identifier, length and number of links.
const HEADER: u64 = 24;
/// Most channels, and letters of each, that an error quotes.
const QUOTED: (usize, usize) = (20, 40);

/// A group of channels that were sampled together.
pub(super) struct Group<'f> {
    /// Its number, from 1 in the order of the file.
    pub(super) number: usize,
    data: &'f DataGroup,
    channels: &'f ChannelGroup,
}

/// A channel and the place of its group among all.
#[derive(Clone, Copy)]
pub(super) struct Place<'f> {
    pub(super) group: usize,
    pub(super) channel: &'f Channel,
}

impl<'f> Group<'f> {
    /// All groups of a file.
    pub(super) fn all(file: &'f Mf4File) -> Vec<Self> {
        let channels =
            file.data_groups().iter().flat_map(|data| data.channel_groups.iter().map(move |group| (data, group)));
        channels.enumerate().map(|(place, (data, channels))| Self { number: place + 1, data, channels }).collect()
    }

    /// The channels whose samples are one number each, and are stored.
    pub(super) fn channels(&self) -> impl Iterator<Item = &'f Channel> {
        let is_number = |kind| {
            use ValueKind::{F32, F64, I8, I16, I32, I64, U8, U16, U32, U64};
            matches!(kind, F32 | F64 | I8 | I16 | I32 | I64 | U8 | U16 | U32 | U64)
        };
        self.channels.channels.iter().filter(move |channel| {
            matches!(channel.channel_type, ChannelType::FixedLength | ChannelType::Master)
                && channel.unreadable().is_none()
                && !channel.is_array()
                && is_number(channel.value_kind())
        })
    }

    /// The channel of its time.
    pub(super) fn master(&self) -> Option<&'f Channel> {
        self.channels.master_channel().filter(|master| master.is_time_channel())
    }

    /// Its times; none where it has no channel of them.
    pub(super) fn times(&self, file: &Mf4File) -> Result<Option<Vec<f64>>, String> {
        self.master().map(|master| Ok(self.values(file, master)?.0)).transpose()
    }

    /// A channel's values in its own unit, and which of them are valid if the file says so.
    pub(super) fn values(&self, file: &Mf4File, channel: &Channel) -> Result<(Vec<f64>, Option<Vec<bool>>), String> {
        self.admit(file)?;
        let wrong = |error: Mf4Error| in_words(&error);
        let signal = file.signal(channel).map_err(wrong)?;
        Ok((signal.values_f64().map_err(wrong)?, signal.validity()))
    }

    /// Refuses a group that lacks samples, or says that it has more than the file can hold or the machine has memory for.
    fn admit(&self, file: &Mf4File) -> Result<(), String> {
        let number = self.number;
        let bytes = self.data.block_index().total_size();
        let samples = self.channels.sample_count;
        let declared = self.declared_samples(file).map_err(|error| in_words(&error))?;
        if file.unfinalized().is_none() && declared != samples {
            return Err(format!("it is damaged: group {number} should have {declared} samples and has {samples}"));
        }
        let record = self.channels.payload_size() as u64;
        let possible = file.file_size().saturating_mul(DEFLATE);
        if samples.saturating_mul(record.max(1)) > bytes || bytes > possible {
            return Err(format!("it is damaged: group {number} declares more data than the file has"));
        }
        let needed = bytes as f64 + COPIES * size_of::<f64>() as f64 * samples as f64;
        match memory::available() {
            Some(available) if needed > available => Err(format!(
                "group {number} needs {:.1} GB of memory, of which {:.1} GB are free; cut the file into shorter ones",
                needed / 1e9,
                available / 1e9
            )),
            _ => Ok(()),
        }
    }

    /// The number of samples that the group's block declares. The crate only counts what it finds, and so overlooks data that are cut off.
    fn declared_samples(&self, file: &Mf4File) -> Result<u64, Mf4Error> {
        let number = |offset: u64| {
            let bytes = file.read_raw(offset, size_of::<u64>())?;
            Ok::<_, Mf4Error>(bytes.try_into().map_or(0, u64::from_le_bytes))
        };
        let block = self.channels.block_offset();
        let links = number(block + HEADER - 8)?;
        // The record ID stands before the number of samples.
        number(block.saturating_add(HEADER + 8).saturating_add(links.saturating_mul(8)))
    }

    /// The group's number and its number of samples.
    pub(super) fn in_words(&self) -> String {
        format!("group {}, {} samples", self.number, self.channels.sample_count)
    }
}

/// What the instrument calls its own column of a quantity.
pub(super) fn own_name(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::Angle => "angle_rad",
        Quantity::Torque => "torque_mnm",
        Quantity::Travel => "travel_mm",
        Quantity::Force => "force_n",
        Quantity::Time => "t_s",
        Quantity::Energy | Quantity::Number => "",
    }
}

/// Every channel of every group in words.
pub(super) fn listed(groups: &[Group<'_>]) -> String {
    let all = groups.iter().flat_map(|group| group.channels().map(move |channel| (group, channel)));
    let mut words: Vec<String> = all
        .take(QUOTED.0 + 1)
        .map(|(group, channel)| {
            let shown =
                |text: &str| text.chars().filter(|letter| !letter.is_control()).take(QUOTED.1).collect::<String>();
            let unit = if channel.unit.is_empty() { String::new() } else { format!(" in {}", shown(&channel.unit)) };
            format!("`{}/{}`{unit}", group.number, shown(&channel.name))
        })
        .collect();
    if words.len() > QUOTED.0 {
        words[QUOTED.0] = "more".to_owned();
    }
    if words.is_empty() { "no channels of numbers".to_owned() } else { format!("the channels {}", words.join(", ")) }
}
