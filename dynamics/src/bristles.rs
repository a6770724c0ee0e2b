//! Friction whose contacts bend before they slip.

/// Dahl's bristles: Coulomb friction builds up over an angle instead of at once.
///
/// The mean deflection z, in units of the deflection at which bristles slip, follows
/// dz/dt = (θ̇ − |θ̇|·z)/z₀ and carries the torque C·z + σ·z₀·dz/dt. Source: P. Dahl, *A solid friction model*,
/// Aerospace Corp. TOR-158 (1968); with the damping of C. Canudas de Wit et al., *A new model for control of systems
/// with friction*, IEEE Trans. Automatic Control 40 (1995) 419–425.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bristles {
    /// Angle over which friction builds up, z₀, rad.
    pub deflection_rad: f64,
    /// Damping while the bristles bend, σ, mNm·s/rad.
    pub damping: f64,
}

impl Bristles {
    /// Deflection z after the knob has turned by `turned_rad` since the deflection was `deflection`: exact for any motion
    /// in one direction.
    #[must_use]
    pub fn bent(&self, deflection: f64, turned_rad: f64) -> f64 {
        if turned_rad == 0.0 {
            return deflection;
        }
        let slipping = turned_rad.signum();
        slipping + (deflection - slipping) * (-turned_rad.abs() / self.deflection_rad).exp()
    }

    /// Rate z₀·dz/dt of bending at a velocity, rad/s: what damping acts on.
    #[must_use]
    pub fn bending_rad_s(deflection: f64, velocity_rad_s: f64) -> f64 {
        velocity_rad_s - velocity_rad_s.abs() * deflection
    }
}
