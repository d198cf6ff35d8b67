//! The variables that are integrated.
//!
//! A state is a flat array `[R; D]`: three rates or momenta (the method decides which), then `VECTORS` directions that
//! are fixed in space, in body components, then a quaternion if the attitude is requested, then the balance of a forced
//! body: work, impulse and time; then a deviation vector of the motion if its growth is requested; then the variables of
//! further forces; then the states of a function.

use crate::forces::{Further, MOST_STATES};
use crate::kinematics::{put, space_axes};
use crate::real::{Pack, Real};

/// The variables that are integrated with the rates.
pub trait Layout: Copy {
    /// Number of space-fixed directions, in body components.
    const VECTORS: usize = 0;
    /// Whether the attitude is integrated.
    const QUATERNION: bool = false;
    /// Whether the equations read the space axes from the quaternion; see [`in_rows`].
    const TURNS: bool = false;
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
    /// Whether the function has states of its own.
    const STATES: bool = false;
    /// Whether the eccentric anomaly of the orbit takes the place of the time; see [`OrbitTurns`].
    const CLOCK: bool = false;
    /// The bodies that are integrated side by side where the registers hold those of `P`: eight under the torque of a
    /// function, which may be told eight at once.
    type Lanes<P: Pack>: Pack;
    /// The layout with the space axes in place of the quaternion, as the equations read it.
    type Rows: Layout;
    /// Whether the state tells all space axes.
    const HAS_FRAME: bool = Self::VECTORS == 3 || Self::TURNS;
    /// The direction from which a tilt is measured: the last direction, or the vertical of a frame.
    const OBSERVED: usize = if Self::BALANCE { 0 } else { Self::VECTORS.saturating_sub(1) };
    /// Length of the state.
    const LEN: usize = Self::STATES_AT + MOST_STATES * Self::STATES as usize;
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
    const OWN: usize = if Self::CLOCK || (Self::FURTHER && Self::HAS_FRAME) { Further::VARIABLES } else { 0 };
    /// Index of these variables.
    const OWN_AT: usize = Self::TANGENT_AT + 6 * Self::TANGENT as usize;
    /// Index of the states of the function, of which there are as many as there may be.
    const STATES_AT: usize = Self::OWN_AT + Self::OWN;
}

/// Layouts by what they have: `name (rows of the quaternion) (bodies side by side): constants of the trait;`.
macro_rules! layouts {
    (@rows $rows:ident) => { $rows };
    (@rows) => { Self };
    (@lanes $pack:ident $eight:ident) => { $pack::$eight };
    (@lanes $pack:ident) => { $pack };
    ($(
        $(#[$doc:meta])*
        $name:ident $(as $rows:ident)? $(in $eight:ident)?: $($constant:ident = $value:literal),*;
    )*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy)]
        pub struct $name;
        impl Layout for $name {
            $(const $constant: layouts!(@type $constant) = $value;)*
            type Lanes<P: Pack> = layouts!(@lanes P $($eight)?);
            type Rows = layouts!(@rows $($rows)?);
        }
    )*};
    (@type VECTORS) => { usize };
    (@type $flag:ident) => { bool };
}
layouts! {
    /// Rates only.
    Rates: ;
    /// Rates and one direction: the vertical of a top, or the initial direction of the observed axis of a free body.
    Axis: VECTORS = 1;
    /// Rates, the vertical, and the initial direction of the observed axis.
    TwoAxes: VECTORS = 2;
    /// Rates and attitude of a body without torques.
    Attitude: QUATERNION = true;
    /// Rates and attitude, in the steps of Runge-Kutta methods.
    Turns as Frame: QUATERNION = true, TURNS = true;
    /// Rates, vertical and attitude; the rates are equal to those of `Axis` to the bit.
    AxisAttitude: VECTORS = 1, QUATERNION = true;
    /// Rates and the space axes z, x and y.
    Frame: VECTORS = 3;
    /// Rates and balance.
    ForcedRates: BALANCE = true;
    /// Rates, the vertical, and the balance: no torque is fixed in space.
    ForcedAxis: VECTORS = 1, BALANCE = true;
    /// Rates, the space axes z, x and y, and the balance.
    ForcedFrame: VECTORS = 3, BALANCE = true;
    /// Rates, attitude and balance, in the steps of Runge-Kutta methods.
    ForcedTurns as ForcedFrame: QUATERNION = true, TURNS = true, BALANCE = true;
    /// Rates, the vertical, and a deviation vector; the other numbers are equal to those of `Axis` to the bit, except by
    /// `dop853`.
    AxisTangent: VECTORS = 1, TANGENT = true;
    /// The same with a change of the parameters.
    AxisSensitivity: VECTORS = 1, TANGENT = true, CHANGED = true;
    /// Rates, the space axes, the balance and a deviation vector, with a change of the parameters.
    ForcedFrameTangent: VECTORS = 3, BALANCE = true, TANGENT = true, CHANGED = true;
    /// Rates and balance of a body under further forces that do not depend on the attitude.
    FurtherRates: BALANCE = true, FURTHER = true;
    /// Rates, the space axes z, x and y, the balance and the variables of the further forces.
    FurtherFrame: VECTORS = 3, BALANCE = true, FURTHER = true;
    /// Rates, attitude, the balance and the variables of the further forces, in the steps of Runge-Kutta methods.
    FurtherTurns as FurtherFrame: QUATERNION = true, TURNS = true, BALANCE = true, FURTHER = true;
    /// A body on an orbit on which nothing else acts, over the eccentric anomaly E: the rates over the pace of the
    /// anomaly, `Q = omega r / n`, the quaternion from the body to the frame of the orbit (radial, along, normal), and
    /// the numbers of `Orbit::clock_at`.
    OrbitTurns: QUATERNION = true, CLOCK = true;
    /// The same as `FurtherFrame` with a deviation vector, and a change of the parameters.
    FurtherFrameTangent: VECTORS = 3, BALANCE = true, TANGENT = true, CHANGED = true, FURTHER = true;
    /// Rates, the space axes z, x and y, and the balance of a body under the torque that a function returns.
    FunctionFrame in Eight: VECTORS = 3, BALANCE = true, FUNCTION = true;
    /// The same as `FurtherTurns` under the torque that a function returns, beside which the further forces may act.
    FunctionTurns as FurtherFrame in Eight:
        QUATERNION = true, TURNS = true, BALANCE = true, FURTHER = true, FUNCTION = true;
    /// The same with the states of the function.
    StatesTurns as FurtherFrame in Eight:
        QUATERNION = true, TURNS = true, BALANCE = true, FURTHER = true, FUNCTION = true, STATES = true;
}

/// Length of the longest state with the space axes in place of a quaternion.
pub const ROWS_LEN: usize = FurtherFrame::LEN;

/// The quaternion of a state.
#[inline(always)]
pub fn quaternion<L: Layout, R: Real, const D: usize>(y: &[R; D]) -> [R; 4] {
    let at = L::QUATERNION_AT;
    [y[at], y[at + 1], y[at + 2], y[at + 3]]
}

/// A state with the space axes in place of its quaternion, which is a unit quaternion up to the error of the steps.
/// Nothing is divided by its length: to the order of the method the motion is the same.
#[inline(always)]
#[allow(clippy::manual_memcpy)] // The compiler does not always inline `copy_from_slice`.
pub fn in_rows<L: Layout, R: Real, const D: usize>(y: &[R; D]) -> [R; ROWS_LEN] {
    let mut rows = [y[0]; ROWS_LEN];
    let [third, first, second] = space_axes(&quaternion::<L, R, D>(y));
    put(&mut rows, 0, [y[0], y[1], y[2]]);
    put(&mut rows, 3, third);
    put(&mut rows, 6, first);
    put(&mut rows, 9, second);
    for i in 0..L::STATES_AT - L::BALANCE_AT {
        rows[12 + i] = y[L::BALANCE_AT + i];
    }
    rows
}
