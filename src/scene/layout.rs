//! The variables that are integrated.
//!
//! A state is a flat array `[R; D]`: three rates or momenta (the method decides which), then `VECTORS` directions that
//! are fixed in space, in body components, then a quaternion if the attitude is requested, then the balance of a forced
//! body: work, impulse and time; then a deviation vector of the motion if its growth is requested; then the variables of
//! further forces.

use crate::forces::Further;
use crate::real::Pack;

/// The variables that are integrated with the rates.
pub trait Layout: Copy {
    /// Number of space-fixed directions, in body components.
    const VECTORS: usize;
    /// Whether the attitude is integrated.
    const QUATERNION: bool;
    /// Whether work, impulse and time are integrated.
    const BALANCE: bool = false;
    /// Whether a deviation vector is integrated with the motion: a change of the rates, and a rotation vector in the
    /// body.
    const TANGENT: bool = false;
    /// Whether a change of the parameters adds to the deviation vector.
    const CHANGED: bool = false;
    /// Whether the further forces act.
    const FURTHER: bool = false;
    /// Whether a function of the user returns a torque.
    const FUNCTION: bool = false;
    /// Whether the eccentric anomaly of the orbit takes the place of the time; see [`OrbitTurns`].
    const CLOCK: bool = false;
    /// The bodies that are integrated side by side where the registers hold those of `P`: eight under the torque of a
    /// function, which may be told eight at once.
    type Lanes<P: Pack>: Pack;
    /// The direction from which a tilt is measured: the last direction, or the vertical of a frame.
    const OBSERVED: usize = if Self::BALANCE { 0 } else { Self::VECTORS.saturating_sub(1) };
    /// Length of the state.
    const LEN: usize = Self::OWN_AT + Self::OWN;
    /// Index of the first component of the quaternion.
    const QUATERNION_AT: usize = 3 + 3 * Self::VECTORS;
    /// Index of the balance, which begins with the work.
    const BALANCE_AT: usize = Self::QUATERNION_AT + 4 * Self::QUATERNION as usize;
    /// Index of the impulse of a forced body.
    const IMPULSE_AT: usize = Self::BALANCE_AT + 1;
    /// Index of the time of a forced body.
    const TIME_AT: usize = Self::BALANCE_AT + 2;
    /// Index of the deviation vector, and length of the state without it.
    const TANGENT_AT: usize = Self::BALANCE_AT + 3 * Self::BALANCE as usize;
    /// How many variables of further forces are integrated.
    const OWN: usize =
        if Self::CLOCK || (Self::FURTHER && Self::VECTORS > 0) { Further::VARIABLES } else { 0 };
    /// Index of these variables.
    const OWN_AT: usize = Self::TANGENT_AT + 6 * Self::TANGENT as usize;
}

macro_rules! layouts {
    ($(
        $(#[$doc:meta])*
        $name:ident: $vectors:literal, $quaternion:literal, $balance:literal, $tangent:literal, $changed:literal;
    )*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy)]
        pub struct $name;
        impl Layout for $name {
            const VECTORS: usize = $vectors;
            const QUATERNION: bool = $quaternion;
            const BALANCE: bool = $balance;
            const TANGENT: bool = $tangent;
            const CHANGED: bool = $changed;
            type Lanes<P: Pack> = P;
        }
    )*};
}
layouts! {
    /// Rates only.
    Rates: 0, false, false, false, false;
    /// Rates and one direction: the vertical of a top, or the initial direction of the observed axis of a free body.
    Axis: 1, false, false, false, false;
    /// Rates, the vertical, and the initial direction of the observed axis.
    TwoAxes: 2, false, false, false, false;
    /// Rates and attitude.
    Attitude: 0, true, false, false, false;
    /// Rates, vertical and attitude; the rates are equal to those of `Axis` to the bit.
    AxisAttitude: 1, true, false, false, false;
    /// Rates and balance.
    ForcedRates: 0, false, true, false, false;
    /// Rates, the space axes z, x and y, and the balance.
    ForcedFrame: 3, false, true, false, false;
    /// Rates, the vertical, and a deviation vector; the other numbers are equal to those of `Axis` to the bit.
    AxisTangent: 1, false, false, true, false;
    /// The same with a change of the parameters.
    AxisSensitivity: 1, false, false, true, true;
    /// Rates, the space axes, the balance and a deviation vector, with a change of the parameters.
    ForcedFrameTangent: 3, false, true, true, true;
}

/// Rates and balance of a body under further forces that do not depend on the attitude.
#[derive(Clone, Copy)]
pub struct FurtherRates;
impl Layout for FurtherRates {
    const VECTORS: usize = 0;
    const QUATERNION: bool = false;
    const BALANCE: bool = true;
    const FURTHER: bool = true;
    type Lanes<P: Pack> = P;
}

/// Rates, the space axes z, x and y, the balance and the variables of the further forces.
#[derive(Clone, Copy)]
pub struct FurtherFrame;
impl Layout for FurtherFrame {
    const VECTORS: usize = 3;
    const QUATERNION: bool = false;
    const BALANCE: bool = true;
    const FURTHER: bool = true;
    type Lanes<P: Pack> = P;
}

/// A body on an orbit on which nothing else acts, over the eccentric anomaly E: the rates over the pace of the anomaly,
/// `Q = omega r / n`, the quaternion from the body to the frame of the orbit (radial, along, normal), and `e cos E`,
/// `e sin E`.
#[derive(Clone, Copy)]
pub struct OrbitTurns;
impl Layout for OrbitTurns {
    const VECTORS: usize = 0;
    const QUATERNION: bool = true;
    const CLOCK: bool = true;
    type Lanes<P: Pack> = P;
}

/// The same as `FurtherFrame` with a deviation vector, and a change of the parameters.
#[derive(Clone, Copy)]
pub struct FurtherFrameTangent;
impl Layout for FurtherFrameTangent {
    const VECTORS: usize = 3;
    const QUATERNION: bool = false;
    const BALANCE: bool = true;
    const TANGENT: bool = true;
    const CHANGED: bool = true;
    const FURTHER: bool = true;
    type Lanes<P: Pack> = P;
}

/// Rates, the space axes z, x and y, and the balance of a body under the torque that a function returns.
#[derive(Clone, Copy)]
pub struct FunctionFrame;
impl Layout for FunctionFrame {
    const VECTORS: usize = 3;
    const QUATERNION: bool = false;
    const BALANCE: bool = true;
    const FUNCTION: bool = true;
    type Lanes<P: Pack> = P::Eight;
}
