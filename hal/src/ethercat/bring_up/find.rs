//! The devices on the bus, and those of them that the file names.

use ethercrab::error::Error;
use ethercrab::subdevice_group::{NoDc, PreOp};
use ethercrab::{MainDevice, SubDevice};
use shared_types::rig::monotonic_time_ns;

use super::error::{BringUpError, failed};
use crate::ethercat::bus::{Group, MOST_BYTES, MOST_DEVICES};
use crate::ethercat::entries::{DRIVE, Entry};
use crate::ethercat::settings::{Device, Settings};

/// Finds the devices and takes them to PRE-OP.
pub(in crate::ethercat) async fn find(
    main_device: &MainDevice<'_>,
    interface: &str,
) -> Result<Group<PreOp, NoDc>, BringUpError> {
    let found = main_device.init_single_group::<MOST_DEVICES, MOST_BYTES>(monotonic_time_ns).await;
    let group = match found {
        Ok(group) if group.is_empty() => return Err(BringUpError::Silent(interface.to_owned())),
        Err(Error::Timeout(_)) if main_device.num_subdevices() == 0 => {
            return Err(BringUpError::Silent(interface.to_owned()));
        }
        found => found.map_err(failed("finding the devices"))?,
    };
    Ok(group)
}

/// A device in words.
pub(in crate::ethercat) fn device_in_words(position: usize, device: &SubDevice) -> String {
    let identity = device.identity();
    format!(
        "{position} '{}' (vendor {:#x}, product {:#x}, alias {})",
        device.name(),
        identity.vendor_id,
        identity.product_id,
        device.alias_address()
    )
}

/// A device that the file names, on the bus.
pub(super) struct Named<'a> {
    pub(super) name: &'a str,
    pub(super) asked: &'a Device,
    pub(super) index: usize,
    pub(super) outputs: Vec<Entry>,
    pub(super) inputs: Vec<Entry>,
}

/// Finds the devices that the file names.
pub(super) fn choose<'a>(
    group: &Group<PreOp, NoDc>,
    main_device: &MainDevice<'_>,
    settings: &'a Settings,
) -> Result<Vec<Named<'a>>, BringUpError> {
    let there: Vec<_> = group.iter(main_device).collect();
    let all =
        || there.iter().enumerate().map(|(at, device)| device_in_words(at, device)).collect::<Vec<_>>().join(", ");
    let asked = settings.terminals.iter().map(|(name, device)| (name.as_str(), device));
    let asked = std::iter::once((DRIVE, &settings.drive)).chain(asked);
    asked
        .map(|(name, asked)| {
            let is_it = |index: usize, device: &SubDevice| {
                asked.vendor.is_none_or(|vendor| vendor == device.identity().vendor_id)
                    && asked.product.is_none_or(|product| product == device.identity().product_id)
                    && asked.alias.is_none_or(|alias| alias == device.alias_address())
                    && asked.position.is_none_or(|position| position == index)
            };
            let mut found = there.iter().enumerate().filter(|(index, device)| is_it(*index, device));
            match (found.next(), found.count()) {
                (Some((index, _)), 0) => Ok(Named { name, asked, index, outputs: Vec::new(), inputs: Vec::new() }),
                (Some(_), others) => Err(BringUpError::Ambiguous {
                    name: name.to_owned(),
                    count: others + 1,
                    asked: asked.in_words(),
                    there: all(),
                }),
                (None, _) => {
                    Err(BringUpError::Missing { name: name.to_owned(), asked: asked.in_words(), there: all() })
                }
            }
        })
        .collect()
}
