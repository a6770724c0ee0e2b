//! A state that a device refuses, and why.

use ethercrab::error::Error;
use ethercrab::{MainDevice, RegisterAddress};

use super::error::BringUpError;
use crate::ethercat::codes;

/// A state that was refused; which device refused it is asked once ethercrab has let go of the group.
pub(super) struct Refused {
    pub(super) state: &'static str,
    pub(super) reason: Error,
}

impl From<Refused> for BringUpError {
    fn from(refused: Refused) -> Self {
        let Refused { state, reason } = refused;
        Self::State { device: String::new(), state, reason: reason.to_string() }
    }
}

/// The device that stands in the way of a state, with its own reason, if one has any.
pub(super) async fn with_reason(main_device: &MainDevice<'static>, error: BringUpError) -> BringUpError {
    let BringUpError::State { device, state, reason } = error else { return error };
    for index in 0..main_device.num_subdevices() {
        let address = FIRST_ADDRESS + index as u16;
        let read = |register: RegisterAddress| ethercrab::Command::fprd(address, register.into()).ignore_wkc();
        let status = read(RegisterAddress::AlStatus).receive::<u16>(main_device).await.unwrap_or(0);
        let code = read(RegisterAddress::AlStatusCode).receive::<u16>(main_device).await.unwrap_or(0);
        if status & AL_ERROR != 0 && code != 0 {
            let reason = codes::al_status(codes::al_status_code(code), code);
            return BringUpError::State { device: format!("at position {index}"), state, reason };
        }
    }
    let device = if device.is_empty() { "of the bus".to_owned() } else { device };
    BringUpError::State { device, state, reason }
}

/// The address that ethercrab gives the first device; the others follow.
const FIRST_ADDRESS: u16 = 0x1000;
/// The error bit of the AL status.
const AL_ERROR: u16 = 0x10;
