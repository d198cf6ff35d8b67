//! What moves: the state that is carried, its kinematics, and the scenes.
//!
//! A state is a flat array `[R; D]`: three rates (or momenta, as the method likes), then `VECTORS` directions
//! that are fixed in space and seen from the body, then a quaternion if the attitude is wanted, then the balance of
//! a body that something acts on from outside: work, impulse and time.

mod driven;
mod free;
mod spin_free;
mod top;

pub use driven::Driven;
pub use free::Free;
pub use spin_free::SpinFree;
pub use top::Top;

use crate::real::Real;
use crate::special::rodrigues;

/// The constants of one body.
#[derive(Clone, Copy)]
pub struct Parameters<R> {
    /// Principal moments of inertia.
    pub moments: [R; 3],
    /// `mgl com`: weight times the vector from the fixed point to the centre of mass, in the body.
    pub weight: [R; 3],
    /// Time step.
    pub step: R,
}

/// What acts on one body from outside, over a time in which torques change evenly.
#[derive(Clone, Copy)]
pub struct Drive<R> {
    /// Torque in the body at the begin of that time, and its rate of change.
    pub body: [[R; 3]; 2],
    /// The same of a torque in space.
    pub space: [[R; 3]; 2],
    /// Damping: the torque is minus this matrix times the rates; its entries 11, 22, 33, 23, 31, 12.
    pub damping: [R; 6],
    /// The rates at which damping alone slows the body: eigenvalues of `I^(-1/2) D I^(-1/2)`.
    pub rates: [R; 3],
    /// Their vectors, as columns.
    pub modes: [[R; 3]; 3],
}

impl<R: Real> Drive<R> {
    /// Nothing.
    #[inline(always)]
    pub fn none() -> Self {
        let zero = R::splat(0.0);
        Drive {
            body: [[zero; 3]; 2],
            space: [[zero; 3]; 2],
            damping: [zero; 6],
            rates: [zero; 3],
            modes: [[zero; 3]; 3],
        }
    }
}

/// What is carried beside the rates.
pub trait Layout: Copy {
    /// Space-fixed directions seen from the body.
    const VECTORS: usize;
    /// Whether the attitude is carried.
    const QUATERNION: bool;
    /// Whether work, impulse and time are carried.
    const BALANCE: bool = false;
    /// The direction that a tilt is measured from: the last, or, of a frame, the vertical.
    const WATCHED: usize = if Self::BALANCE { 0 } else { Self::VECTORS.saturating_sub(1) };
    /// Length of the state.
    const LEN: usize = Self::BALANCE_AT + 3 * Self::BALANCE as usize;
    /// Where the quaternion begins.
    const QUATERNION_AT: usize = 3 + 3 * Self::VECTORS;
    /// Where the balance begins.
    const BALANCE_AT: usize = Self::QUATERNION_AT + 4 * Self::QUATERNION as usize;
}

macro_rules! layouts {
    ($($(#[$doc:meta])* $name:ident: $vectors:literal, $quaternion:literal, $balance:literal;)*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy)]
        pub struct $name;
        impl Layout for $name {
            const VECTORS: usize = $vectors;
            const QUATERNION: bool = $quaternion;
            const BALANCE: bool = $balance;
        }
    )*};
}
layouts! {
    /// Rates only.
    Rates: 0, false, false;
    /// Rates and one direction: the vertical of a top, or where the watched axis of a free body started.
    Axis: 1, false, false;
    /// Rates, the vertical, and where the watched axis started.
    TwoAxes: 2, false, false;
    /// Rates and attitude.
    Attitude: 0, true, false;
    /// Rates, vertical and attitude: the rates are those of `Axis` to the bit.
    AxisAttitude: 1, true, false;
    /// Rates and balance.
    DrivenRates: 0, false, true;
    /// Rates, the vertical, the first and the second direction of space, and the balance.
    DrivenFrame: 3, false, true;
}

/// A scene: the torque and the conserved quantities. `y[3..6]` is the vertical wherever there is weight.
pub trait Model<R: Real>: Copy {
    /// Whether all moments are the same, and no torque acts along axis 3.
    const SPIN_FREE: bool = false;
    /// Whether there may be weight.
    const HEAVY: bool = true;
    /// Whether something acts from outside: torques or damping.
    const DRIVEN: bool = false;
    /// Constants of the equations of motion from those of the body.
    fn new(p: &Parameters<R>) -> Self;
    /// The same under what acts from outside.
    #[inline(always)]
    fn driven(p: &Parameters<R>, _drive: &Drive<R>) -> Self {
        Self::new(p)
    }
    /// Euler's equations from the products `w2 w3`, `w3 w1`, `w1 w2`. They are linear in these and in the vertical,
    /// so the Cauchy products of two series and the vertical of one order give the rate of change of that order.
    fn euler<const D: usize>(&self, products: &[R; 3], y: &[R; D]) -> [R; 3];
    /// Euler's equations: the rate of change of `omega` in the body.
    #[inline(always)]
    fn acceleration<const D: usize>(&self, omega: &[R; 3], y: &[R; D]) -> [R; 3] {
        let [w1, w2, w3] = *omega;
        self.euler(&[w2 * w3, w3 * w1, w1 * w2], y)
    }
    /// Torque from outside, damping included, at a state.
    #[inline(always)]
    fn outside<const D: usize>(&self, _y: &[R; D]) -> [R; 3] {
        [R::splat(0.0); 3]
    }
    /// One order of its series, after order 0, from the coefficients of the state of this order and of the one before;
    /// `start` is the state.
    #[inline(always)]
    fn outside_of_order<const D: usize>(&self, _start: &[R; D], _now: &[R; D], _before: &[R; D]) -> [R; 3] {
        [R::splat(0.0); 3]
    }
    /// All torques but damping: gyroscopic, of the weight, from outside.
    #[inline(always)]
    fn forcing<const D: usize>(&self, _y: &[R; D]) -> [R; 3] {
        [R::splat(0.0); 3]
    }
    /// The part of it that acts from outside.
    #[inline(always)]
    fn undamped<const D: usize>(&self, _y: &[R; D]) -> [R; 3] {
        [R::splat(0.0); 3]
    }
    /// What a torque changes of the rates.
    #[inline(always)]
    fn over_moments(&self, torque: &[R; 3]) -> [R; 3] {
        *torque
    }
    /// Power and rate of impulse of a torque from outside; linear in the torque and in the state.
    #[inline(always)]
    fn balance<const D: usize>(&self, _torque: &[R; 3], _y: &[R; D]) -> [R; 2] {
        [R::splat(0.0); 2]
    }
    /// Exact flow of the potential alone over the time `h`.
    fn kick<const D: usize>(p: &Parameters<R>, h: R, momentum: &mut [R; 3], y: &[R; D]);
    /// Exact flow over `h` of the potential `V - (weight / h) torque.torque / I`: with the gradient of the force.
    fn gradient_kick<const D: usize>(p: &Parameters<R>, h: R, weight: R, momentum: &mut [R; 3], y: &[R; D]);
    /// Torque of the potential in the body.
    fn torque<const D: usize>(p: &Parameters<R>, y: &[R; D]) -> [R; 3];
    /// Potential energy; less the work done from outside, if there is any.
    fn potential<const D: usize>(p: &Parameters<R>, y: &[R; D]) -> R;
    /// The conserved component of the angular momentum: `L.L` of a free body, `L.gamma` of a top; less what was given
    /// to it from outside, if anything was.
    fn conserved<const D: usize>(momentum: &[R; 3], y: &[R; D]) -> R;
}

/// a x b.
#[inline(always)]
pub fn cross<R: Real>(a: &[R; 3], b: &[R; 3]) -> [R; 3] {
    [a[1].fms(b[2], a[2] * b[1]), a[2].fms(b[0], a[0] * b[2]), a[0].fms(b[1], a[1] * b[0])]
}

/// a . b.
#[inline(always)]
pub fn dot<R: Real>(a: &[R; 3], b: &[R; 3]) -> R {
    a[0].fma(b[0], a[1].fma(b[1], a[2] * b[2]))
}

/// The direction `v` (0, 1, …) of a state.
#[inline(always)]
pub fn direction<R: Real, const D: usize>(y: &[R; D], v: usize) -> [R; 3] {
    [y[3 + 3 * v], y[4 + 3 * v], y[5 + 3 * v]]
}

/// Rate of change of a space-fixed direction seen from the body: n' = n x omega.
#[inline(always)]
pub fn direction_rate<R: Real>(n: &[R; 3], omega: &[R; 3]) -> [R; 3] {
    cross(n, omega)
}

/// Rate of change of the attitude: q' = q (0, omega) / 2.
#[inline(always)]
pub fn attitude_rate<R: Real>(q: &[R; 4], omega: &[R; 3]) -> [R; 4] {
    let half = R::splat(0.5);
    let [v1, v2, v3] = [omega[0] * half, omega[1] * half, omega[2] * half];
    let [q0, q1, q2, q3] = *q;
    [
        -(q3.fma(v3, q2.fma(v2, q1 * v1))),
        q3.fnma(v2, q2.fma(v3, q0 * v1)),
        q1.fnma(v3, q3.fma(v1, q0 * v2)),
        q2.fnma(v1, q1.fma(v2, q0 * v3)),
    ]
}

/// `sum` and `n x omega`, from the rates across axis 3.
#[inline(always)]
pub fn add_turn_across<R: Real>(n: &[R; 3], [w1, w2]: [R; 2], sum: &mut [R; 3]) {
    let [n1, n2, n3] = *n;
    *sum = [n3.fnma(w2, sum[0]), n3.fma(w1, sum[1]), n2.fnma(w1, n1.fma(w2, sum[2]))];
}

/// The same, from the rate about axis 3.
#[inline(always)]
pub fn add_turn_along<R: Real>(n: &[R; 3], w3: R, sum: &mut [R; 3]) {
    let [n1, n2, _] = *n;
    (sum[0], sum[1]) = (n2.fma(w3, sum[0]), n1.fnma(w3, sum[1]));
}

/// `sum` and `q (0, omega)`, from the rates across axis 3.
#[inline(always)]
pub fn add_roll_across<R: Real>(q: &[R; 4], [w1, w2]: [R; 2], sum: &mut [R; 4]) {
    let [q0, q1, q2, q3] = *q;
    *sum = [
        q2.fnma(w2, q1.fnma(w1, sum[0])),
        q3.fnma(w2, q0.fma(w1, sum[1])),
        q3.fma(w1, q0.fma(w2, sum[2])),
        q2.fnma(w1, q1.fma(w2, sum[3])),
    ];
}

/// The same, from the rate about axis 3.
#[inline(always)]
pub fn add_roll_along<R: Real>(q: &[R; 4], w3: R, sum: &mut [R; 4]) {
    let [q0, q1, q2, q3] = *q;
    *sum = [q3.fnma(w3, sum[0]), q2.fma(w3, sum[1]), q1.fnma(w3, sum[2]), q0.fma(w3, sum[3])];
}

/// Hamilton product of two quaternions, scalar first.
#[inline(always)]
pub fn quaternion_product<R: Real>(a: &[R; 4], b: &[R; 4]) -> [R; 4] {
    [
        a[3].fnma(b[3], a[2].fnma(b[2], a[0].fms(b[0], a[1] * b[1]))),
        a[3].fnma(b[2], a[2].fma(b[3], a[0].fma(b[1], a[1] * b[0]))),
        a[1].fnma(b[3], a[3].fma(b[1], a[0].fma(b[2], a[2] * b[0]))),
        a[2].fnma(b[1], a[1].fma(b[2], a[0].fma(b[3], a[3] * b[0]))),
    ]
}

/// `R.T e` for the attitude `q` (of any length): the space direction `e` seen from the body.
#[inline(always)]
pub fn seen_from_body<R: Real>(q: &[R; 4], e: &[R; 3]) -> [R; 3] {
    let u = [q[1], q[2], q[3]];
    let t = cross(e, &u);
    let t = [t[0] + t[0], t[1] + t[1], t[2] + t[2]];
    let s = cross(&t, &u);
    [0, 1, 2].map(|i| q[0].fma(t[i], e[i] + s[i]))
}

/// exp of a rotation vector, as a unit quaternion.
#[inline(always)]
pub fn rotation_by<R: Real>(v: &[R; 3]) -> [R; 4] {
    let quarter = dot(v, v) * R::splat(0.25);
    let (a, b) = rodrigues(quarter);
    let s = a * R::splat(0.5);
    [quarter.fnma(b, R::splat(1.0)), s * v[0], s * v[1], s * v[2]]
}
