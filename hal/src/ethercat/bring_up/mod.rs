//! A bus from its power-up to where the drive only has to be enabled.

mod error;
mod find;
mod places;
mod refused;
mod set_up;
mod watchdogs;

use std::ops::ControlFlow;
use std::time::Duration;

use ethercrab::subdevice_group::DcConfiguration;
use ethercrab::{DcSync, MainDevice, MainDeviceConfig, RetryBehaviour, Timeouts};

use super::bus::{Bus, ChannelPlace, Devices, DrivePlaces, FRAMES_OF_THIS_PROCESS, Unanswered, Wire};
use super::drive::CYCLIC_SYNCHRONOUS_TORQUE;
use super::entries::{DRIVE, Source};
use super::settings::Settings;
use super::socket::{LONGEST, Socket};
use error::{failed, unsuitable};
use find::choose;
use places::{Scales, channel_place, drive_places};
use refused::{Refused, with_reason};
use set_up::{set_up, set_up_drive};
use watchdogs::arm_watchdogs;

pub use error::BringUpError;
pub(super) use find::{device_in_words, find};
pub(super) use set_up::{Reference, mapped};

/// Time that a frame of the preparation may take, which no tick waits for.
const FRAME_TIMEOUT: Duration = Duration::from_millis(100);
/// Frames by which the clocks are first brought together (ETG.1020: some thousands).
const FIRST_SYNC_FRAMES: u32 = 10_000;
/// Time from when the clocks are set up to the first SYNC0.
const SYNC_BEGINS: Duration = Duration::from_millis(100);

/// Frames on an interface, and ethercrab on top of them.
pub(super) fn open(interface: &str, first_sync_frames: u32) -> Result<(Wire, MainDevice<'static>), BringUpError> {
    let socket = Socket::open(interface).map_err(|reason| BringUpError::Interface {
        interface: interface.to_owned(),
        remedy: match reason.raw_os_error() {
            Some(libc::EPERM | libc::EACCES) => {
                "raw frames need root, or `setcap cap_net_raw,cap_sys_nice,cap_ipc_lock+ep` on rt-loop and haptic-camera"
            }
            _ => "`ip link` lists those that there are",
        },
        reason,
    })?;
    let (tx, rx, pdu_loop) = FRAMES_OF_THIS_PROCESS.try_split().map_err(|()| BringUpError::Again)?;
    let timeouts = Timeouts {
        pdu: FRAME_TIMEOUT,
        eeprom: Duration::from_millis(500),
        wait_loop_delay: Duration::from_micros(200),
        state_transition: Duration::from_secs(10),
        ..Timeouts::default()
    };
    let config =
        MainDeviceConfig { dc_static_sync_iterations: first_sync_frames, retry_behaviour: RetryBehaviour::Count(3) };
    Ok((Wire { socket, tx, rx, frame: [0; LONGEST] }, MainDevice::new(pdu_loop, timeouts, config)))
}

/// Drives a future of the preparation, and gives up when asked to stop.
pub(super) fn wait<T>(
    wire: &mut Wire,
    interface: &str,
    stop: &dyn Fn() -> bool,
    future: impl Future<Output = Result<T, BringUpError>>,
) -> Result<T, BringUpError> {
    let idle = || {
        std::thread::yield_now();
        if stop() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    match wire.drive(future, idle) {
        Ok(done) => done,
        Err(Unanswered::GaveUp) => Err(BringUpError::Stopped),
        Err(Unanswered::NotSent) => Err(BringUpError::Down(interface.to_owned())),
    }
}

/// What a bus becomes.
pub(super) struct BroughtUp {
    pub(super) devices: Devices,
    pub(super) drive: DrivePlaces,
    pub(super) channels: Vec<ChannelPlace>,
    pub(super) expected: u16,
    /// The torque that a target of 1000 stands for, mNm.
    pub(super) rated_torque_mnm: f64,
    /// Longest time of a watchdog as read back, s.
    pub(super) watchdog_s: f64,
    /// What is worth keeping with a capture.
    pub(super) notes: Vec<(String, String)>,
}

/// What the bring-up needs besides the bus.
pub(super) struct Asked<'a> {
    pub(super) settings: &'a Settings,
    pub(super) sources: &'a [Source],
    pub(super) rate_hz: f64,
    pub(super) watchdog_s: f64,
}

/// Frames by which the clocks are first brought together, if they are.
pub(super) fn first_sync_frames(settings: &Settings) -> u32 {
    if settings.distributed_clocks { FIRST_SYNC_FRAMES } else { 0 }
}

/// Takes the devices to where they ask for process data: everything is set up, and OP is requested.
pub(super) async fn bring_up(main_device: &MainDevice<'static>, asked: &Asked<'_>) -> Result<BroughtUp, BringUpError> {
    let settings = asked.settings;
    let mut group = find(main_device, &settings.interface).await?;
    let mut named = choose(&group, main_device, settings)?;
    let mut notes = Vec::new();
    for device in &mut named {
        let reference = group.subdevice(main_device, device.index).map_err(failed("looking at a device"))?;
        notes.push((format!("device {}", device.name), device_in_words(device.index, &reference)));
        set_up(&reference, device).await?;
    }
    let drive =
        named.iter().find(|device| device.name == DRIVE).ok_or(BringUpError::Silent(settings.interface.clone()))?;
    let index = drive.index;
    let reference = group.subdevice(main_device, index).map_err(failed("looking at the drive"))?;
    let (rated_torque_mnm, counts_per_turn) = set_up_drive(&reference, asked).await?;
    notes.push(("rated torque".to_owned(), format!("{rated_torque_mnm} mNm")));
    notes.extend(counts_per_turn.map(|counts| ("encoder".to_owned(), format!("{counts} counts per turn"))));
    notes.push(("smallest torque".to_owned(), format!("{} mNm", rated_torque_mnm / 1e3)));
    let places = drive_places(drive)?;
    let scales = Scales { rated_torque_mnm, counts_per_turn };
    let channels =
        asked.sources.iter().map(|source| channel_place(source, &named, scales)).collect::<Result<_, _>>()?;
    if settings.distributed_clocks {
        let mut devices = group.iter_mut(main_device);
        if let Some(mut drive) = devices.nth(index) {
            if !drive.dc_support().any() {
                return Err(unsuitable(DRIVE, "has no distributed clock; set distributed_clocks = false"));
            }
            drive.set_dc_sync(DcSync::Sync0);
        }
    }
    let group = group.into_pre_op_pdi(main_device).await.map_err(failed("setting up process data"))?;
    let (expected, watchdog_s) = arm_watchdogs(&group, main_device, asked.watchdog_s).await?;
    notes.push(("working counter".to_owned(), expected.to_string()));
    let devices = if settings.distributed_clocks {
        let period = Duration::from_secs_f64(1.0 / asked.rate_hz);
        let clocks = DcConfiguration { start_delay: SYNC_BEGINS, sync0_period: period, sync0_shift: Duration::ZERO };
        let group = group.configure_dc_sync(main_device, clocks).await.map_err(failed("setting up the clocks"))?;
        let group = group.into_safe_op(main_device).await;
        let group = group.map_err(|reason| Refused { state: "SAFE-OP", reason })?;
        Devices::Clocked(group.request_into_op(main_device).await.map_err(|reason| Refused { state: "OP", reason })?)
    } else {
        let group = group.into_safe_op(main_device).await;
        let group = group.map_err(|reason| Refused { state: "SAFE-OP", reason })?;
        Devices::Free(group.request_into_op(main_device).await.map_err(|reason| Refused { state: "OP", reason })?)
    };
    Ok(BroughtUp { devices, drive: places, channels, expected, rated_torque_mnm, watchdog_s, notes })
}

/// Takes a bus to where OP is asked for, which the devices reach once process data come.
pub(super) fn start(asked: &Asked<'_>, stop: &dyn Fn() -> bool) -> Result<(Bus, BroughtUpRest), BringUpError> {
    let interface = &asked.settings.interface;
    let (mut wire, main_device) = open(interface, first_sync_frames(asked.settings))?;
    let brought = wait(&mut wire, interface, stop, bring_up(&main_device, asked));
    let brought = match brought {
        Err(error @ BringUpError::State { .. }) => {
            let named = wait(&mut wire, interface, stop, async { Ok(with_reason(&main_device, error).await) })?;
            return Err(named);
        }
        other => other?,
    };
    let BroughtUp { devices, drive, channels, expected, rated_torque_mnm, watchdog_s, notes } = brought;
    let bus = Bus { wire, main_device, devices, drive, channels, expected, mode: CYCLIC_SYNCHRONOUS_TORQUE };
    Ok((bus, BroughtUpRest { rated_torque_mnm, watchdog_s, notes }))
}

/// What is left when the bus runs.
pub(super) struct BroughtUpRest {
    pub(super) rated_torque_mnm: f64,
    pub(super) watchdog_s: f64,
    pub(super) notes: Vec<(String, String)>,
}
