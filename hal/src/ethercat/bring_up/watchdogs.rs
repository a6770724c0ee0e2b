//! The watchdogs by which devices let go of their outputs when nothing comes.

use ethercrab::subdevice_group::{NoDc, PreOpPdi};
use ethercrab::{MainDevice, RegisterAddress};

use super::error::{BringUpError, failed, unsuitable};
use crate::ethercat::bus::Group;

/// Has every device that takes process data let go of its outputs when none come for `asked_s`, and reads that back (ETG.1000.4,
/// 6.3; ET1100 data sheet, 0x0400 and 0x0420). Gives the working counter of a cycle, and the longest time read back, s.
pub(super) async fn arm_watchdogs(
    group: &Group<PreOpPdi, NoDc>,
    main_device: &MainDevice<'static>,
    asked_s: f64,
) -> Result<(u16, f64), BringUpError> {
    let (mut expected, mut longest_s) = (0, 0.0_f64);
    let count = (asked_s / (WATCHDOG_UNIT_S)).floor();
    for (index, device) in group.iter(main_device).enumerate() {
        let name = format!("{index} {}", device.name());
        let doing = || failed(format!("arming the watchdog of '{name}'"));
        expected += u16::from(!device.inputs_raw().is_empty());
        if device.outputs_raw().is_empty() {
            continue;
        }
        // A device adds one for reading and two for writing (ETG.1000.4, table 9).
        expected += 2;
        if !(1.0..=65_535.0).contains(&count) {
            return Err(unsuitable(&name, format!("cannot have a watchdog of {asked_s} s; give 0.0001 to 6.5 s")));
        }
        device.register_write(RegisterAddress::WatchdogDivider, WATCHDOG_DIVIDER).await.map_err(doing())?;
        device.register_write(RegisterAddress::SyncManagerWatchdog, count as u16).await.map_err(doing())?;
        let divider = device.register_read::<u16>(RegisterAddress::WatchdogDivider).await.map_err(doing())?;
        let ticks = device.register_read::<u16>(RegisterAddress::SyncManagerWatchdog).await.map_err(doing())?;
        let time_s = f64::from(ticks) * (f64::from(divider) + 2.0) * WATCHDOG_CLOCK_S;
        if time_s <= 0.0 || time_s > asked_s * 1.001 {
            let what = format!(
                "does not take a process-data watchdog of {asked_s} s (0x0400 and 0x0420 read back {divider:#06x} and {ticks}): its \
                 torque would stay when the program is killed; use another drive"
            );
            return Err(unsuitable(&name, what));
        }
        let mut is_watched = false;
        for manager in 0..SYNC_MANAGERS {
            let [.., control, _, activate, _] =
                device.register_read::<[u8; 8]>(FIRST_SYNC_MANAGER + 8 * manager).await.map_err(doing())?;
            let takes_outputs = activate & 1 == 1 && control & (BUFFERED_MASK | DIRECTION_MASK) == FROM_MAIN_DEVICE;
            is_watched |= takes_outputs && control & WATCHDOG_TRIGGER != 0;
        }
        if !is_watched {
            let what = "does not watch its outputs (bit 6 of its sync manager's control byte): its torque would stay when the program \
                        is killed; use another drive";
            return Err(unsuitable(&name, what));
        }
        longest_s = longest_s.max(time_s);
    }
    Ok((expected, longest_s))
}

/// 0x0400 for steps of 100 µs: the clock's ticks less two.
const WATCHDOG_DIVIDER: u16 = 2_498;
/// A step of the watchdog with it, s.
const WATCHDOG_UNIT_S: f64 = 1e-4;
/// A tick of the watchdog's clock of 25 MHz, s.
const WATCHDOG_CLOCK_S: f64 = 40e-9;
/// Sync managers, 8 bytes each: address, length, control, status, activate, PDI control (ET1100 data sheet, 0x0800).
const FIRST_SYNC_MANAGER: u16 = 0x0800;
const SYNC_MANAGERS: u16 = 4;
/// Fields of the control byte: mode (0 is buffered), direction (4 is from the main device), and whether process data feed the watchdog.
const BUFFERED_MASK: u8 = 0x03;
const DIRECTION_MASK: u8 = 0x0c;
const FROM_MAIN_DEVICE: u8 = 0x04;
const WATCHDOG_TRIGGER: u8 = 0x40;
