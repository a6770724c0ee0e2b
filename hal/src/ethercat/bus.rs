//! The bus: ethercrab's futures driven over the socket, and the cycle in which all devices are exchanged with.

use std::ops::ControlFlow;
use std::pin::pin;
use std::task::{Context, Poll, Waker};

use ethercrab::subdevice_group::{CycleInfo, HasDc, NoDc, Op, TxRxResponse};
use ethercrab::{
    Command, DefaultLock, MainDevice, PduRx, PduStorage, PduTx, RegisterAddress, SubDeviceGroup, SubDeviceState,
};
use shared_types::rig::monotonic_time_ns;

use super::codes;
use super::entries::{Coding, Place};
use super::socket::{LONGEST, Socket};

/// Most devices on a bus.
pub(super) const MOST_DEVICES: usize = 32;
/// Most process data of all devices, bytes: one frame holds them.
pub(super) const MOST_BYTES: usize = 1_024;
/// Frames on their way at once.
const FRAMES: usize = 16;

/// The frames that one process has; there can be one bus in it, once.
pub(super) static FRAMES_OF_THIS_PROCESS: PduStorage<FRAMES, { PduStorage::element_size(1_100) }> = PduStorage::new();

pub(super) type Group<State, Clocks> = SubDeviceGroup<MOST_DEVICES, MOST_BYTES, DefaultLock, State, Clocks>;

/// The bit that a controller sets in a frame's source address once the frame has come through. ethercrab takes a frame with its own
/// source address for an outgoing one, and not everything that sends frames back sets the bit.
const SOURCE_AT: usize = 6;
const CAME_THROUGH: u8 = 0x02;

/// Frames that go out and come back.
pub(super) struct Wire {
    pub(super) socket: Socket,
    pub(super) tx: PduTx<'static>,
    pub(super) rx: PduRx<'static>,
    pub(super) frame: [u8; LONGEST],
}

/// Why a future came to nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Unanswered {
    /// Whoever waits gave up.
    GaveUp,
    /// The interface took no frame.
    NotSent,
}

impl Wire {
    /// Drives a future until it is ready; each time that nothing has come, `idle` says whether to go on.
    ///
    /// Every frame is sent by one call; a second one is sent only where the future asks for it.
    pub(super) fn drive<F: Future>(
        &mut self,
        future: F,
        mut idle: impl FnMut() -> ControlFlow<()>,
    ) -> Result<F::Output, Unanswered> {
        let mut future = pin!(future);
        let mut context = Context::from_waker(Waker::noop());
        loop {
            if let Poll::Ready(output) = future.as_mut().poll(&mut context) {
                return Ok(output);
            }
            while let Some(frame) = self.tx.next_sendable_frame() {
                let sent = frame
                    .send_blocking(|bytes| self.socket.send(bytes).map_err(|_| ethercrab::error::Error::SendFrame));
                sent.map_err(|_| Unanswered::NotSent)?;
            }
            if !self.take() && idle().is_break() {
                return Err(Unanswered::GaveUp);
            }
        }
    }

    /// Takes a frame that has come; returns whether there was one.
    fn take(&mut self) -> bool {
        let Some(length) = self.socket.receive(&mut self.frame) else { return false };
        self.frame[SOURCE_AT] |= CAME_THROUGH;
        // One that nobody waits for any more is passed over.
        let _ = self.rx.receive_frame(&self.frame[..length]);
        true
    }

    /// Passes over frames that came too late.
    fn clear(&mut self) {
        while self.take() {}
    }
}

/// The devices, with or without clocks that are kept together.
pub(super) enum Devices {
    Free(Group<Op, NoDc>),
    Clocked(Group<Op, HasDc>),
}

/// Where the drive's process data lie.
#[derive(Clone, Copy, Debug)]
pub(super) struct DrivePlaces {
    pub(super) device: usize,
    pub(super) controlword: Place,
    pub(super) target_torque: Place,
    pub(super) mode: Option<Place>,
    pub(super) statusword: Place,
    pub(super) mode_display: Option<Place>,
    pub(super) error_code: Option<Place>,
}

/// Where a channel's value lies, and by what it is multiplied.
#[derive(Clone, Copy, Debug)]
pub(super) struct ChannelPlace {
    pub(super) device: usize,
    pub(super) place: Place,
    pub(super) coding: Coding,
    pub(super) factor: f64,
}

/// What a cycle asks of the drive.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct DriveCommand {
    pub(super) controlword: u16,
    /// Thousandths of the rated torque.
    pub(super) target_torque: i16,
}

/// A bus in operation.
pub(super) struct Bus {
    pub(super) wire: Wire,
    pub(super) main_device: MainDevice<'static>,
    pub(super) devices: Devices,
    pub(super) drive: DrivePlaces,
    pub(super) channels: Vec<ChannelPlace>,
    /// What the working counter is when every device takes part.
    pub(super) expected: u16,
    pub(super) mode: u8,
}

/// What a cycle brought.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cycle {
    /// When the devices had the frame, halfway between when it went out and came back (CLOCK_MONOTONIC), ns.
    pub(super) time_ns: u64,
    /// Whether every device took part.
    pub(super) is_complete: bool,
    /// The first device that is not in OP.
    pub(super) fallen: Option<usize>,
    /// How long after the devices' SYNC0 the frame passed, ns, where clocks are kept together.
    pub(super) after_sync_ns: Option<u64>,
}

/// Access to one device's bytes, whatever the clocks.
macro_rules! with_devices {
    ($bus:expr, $group:ident => $do:expr) => {
        match &$bus.devices {
            Devices::Free($group) => $do,
            Devices::Clocked($group) => $do,
        }
    };
}

impl Bus {
    /// Sends the command and receives the inputs of all devices; waits until `until_ns` (CLOCK_MONOTONIC) at most.
    ///
    /// One `sendto`, and no other system call.
    pub(super) fn cycle(&mut self, command: DriveCommand, until_ns: u64) -> Result<Cycle, Unanswered> {
        self.wire.clear();
        let DrivePlaces { device, controlword, target_torque, mode, .. } = self.drive;
        with_devices!(self, group => {
            if let Ok(drive) = group.subdevice(&self.main_device, device) {
                let mut outputs = drive.outputs_raw_mut();
                controlword.write_bits(&mut outputs, u64::from(command.controlword));
                target_torque.write_bits(&mut outputs, u64::from(command.target_torque.cast_unsigned()));
                if let Some(mode) = mode {
                    mode.write_bits(&mut outputs, u64::from(self.mode));
                }
            }
        });
        let begun_ns = monotonic_time_ns();
        let wait = || match monotonic_time_ns() < until_ns {
            true => {
                std::hint::spin_loop();
                ControlFlow::Continue(())
            }
            false => ControlFlow::Break(()),
        };
        let (found, after_sync_ns) = match &self.devices {
            Devices::Free(group) => (answer_of(self.wire.drive(group.tx_rx(&self.main_device), wait)?)?, None),
            Devices::Clocked(group) => {
                let response = self.wire.drive(group.tx_rx_dc(&self.main_device), wait)?;
                let after = response.as_ref().ok().map(
                    |TxRxResponse { extra: CycleInfo { cycle_start_offset, .. }, .. }| {
                        cycle_start_offset.as_nanos() as u64
                    },
                );
                (answer_of(response)?, after)
            }
        };
        let ended_ns = monotonic_time_ns();
        let (working_counter, fallen) = found;
        Ok(Cycle {
            time_ns: begun_ns + (ended_ns - begun_ns) / 2,
            is_complete: working_counter == self.expected,
            fallen,
            after_sync_ns,
        })
    }

    /// A place among the inputs of a device, as bits.
    fn input(&self, device: usize, place: Place) -> u64 {
        with_devices!(self, group => {
            group.subdevice(&self.main_device, device).map_or(0, |device| place.read_bits(&device.inputs_raw()))
        })
    }

    /// The drive's statusword.
    pub(super) fn statusword(&self) -> u16 {
        self.input(self.drive.device, self.drive.statusword) as u16
    }

    /// The drive's mode of operation, where it is among its process data and not the one asked for.
    pub(super) fn other_mode(&self) -> Option<u8> {
        let displayed = self.drive.mode_display.map(|place| self.input(self.drive.device, place) as u8);
        displayed.filter(|mode| *mode != self.mode)
    }

    /// The drive's code for its fault, 0 where it is not among its process data.
    pub(super) fn error_code(&self) -> u16 {
        self.drive.error_code.map_or(0, |place| self.input(self.drive.device, place) as u16)
    }

    /// A channel's value.
    pub(super) fn channel(&self, index: usize) -> f64 {
        let Some(ChannelPlace { device, place, coding, factor }) = self.channels.get(index).copied() else {
            return 0.0;
        };
        with_devices!(self, group => {
            group.subdevice(&self.main_device, device).map_or(0.0, |device| factor * place.read(&device.inputs_raw(), coding))
        })
    }

    /// Why a device left OP: one further frame.
    pub(super) fn why_fallen(&mut self, device: usize, until_ns: u64) -> i32 {
        let main_device = &self.main_device;
        let address = with_devices!(self, group => group.subdevice(main_device, device).map(|device| device.configured_address()));
        let Ok(address) = address else { return codes::NOT_OPERATIONAL };
        let status =
            Command::fprd(address, RegisterAddress::AlStatusCode.into()).ignore_wkc().receive::<u16>(main_device);
        let wait = || if monotonic_time_ns() < until_ns { ControlFlow::Continue(()) } else { ControlFlow::Break(()) };
        match self.wire.drive(status, wait) {
            Ok(Ok(code)) => codes::of_al_status(code),
            _ => codes::NOT_OPERATIONAL,
        }
    }

    /// Asks every device to go back to INIT, without waiting for it.
    pub(super) fn leave(&mut self) {
        let init = Command::bwr(RegisterAddress::AlControl.into()).ignore_wkc().send(&self.main_device, 0x0011_u16);
        let until_ns = monotonic_time_ns() + 5_000_000;
        let wait = || if monotonic_time_ns() < until_ns { ControlFlow::Continue(()) } else { ControlFlow::Break(()) };
        let _ = self.wire.drive(init, wait);
    }
}

/// Working counter, and the first device that is not in OP; a frame that cannot be read is as good as lost. A device that does
/// not answer has no state, and shows in the working counter.
fn answer_of<Extra>(
    response: Result<TxRxResponse<MOST_DEVICES, Extra>, ethercrab::error::Error>,
) -> Result<(u16, Option<usize>), Unanswered> {
    let response = response.map_err(|_| Unanswered::GaveUp)?;
    let is_fallen = |state: &SubDeviceState| !matches!(state, SubDeviceState::Op | SubDeviceState::None);
    let fallen = response.subdevice_states.iter().position(is_fallen);
    Ok((response.working_counter, fallen))
}
