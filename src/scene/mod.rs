//! Scenes, and the layouts of their states.

mod forced;
mod free;
mod further;
mod layout;
mod top;

pub use forced::{Applied, Torques, Varied};
pub use free::{FREE, Free};
pub use further::{FurtherRate, MOVED, Moved, add_turned_axes, moved_by};
pub use layout::{
    Attitude, Axis, AxisAttitude, AxisSensitivity, AxisTangent, ForcedAxis, ForcedFrame, ForcedFrameTangent,
    ForcedRates, ForcedTurns, FunctionFrame, FunctionTurns, FurtherFrame, FurtherFrameTangent, FurtherRates,
    FurtherTurns, Layout, OrbitTurns, ROWS_LEN, Rates, StatesTurns, Turns, TwoAxes, in_rows, quaternion,
};
pub use top::{TOP, Top};

use crate::body::Body;
use crate::dual::Dual;
use crate::error::Error;
use crate::forces::ParameterChange;
use crate::real::Real;

/// All scenes, in the order in which they are listed to users.
pub const ALL: &[&Scene] = &[&FREE, &TOP];

/// Properties of a scene outside the kernels. The systems of a scene are its rows in `kernels!`.
#[derive(Debug)]
pub struct Scene {
    /// The name, as in Python.
    pub kind: &'static str,
    /// Whether there may be weight; the vertical is then integrated with the rates.
    pub has_weight: bool,
    /// The conserved momentum.
    pub conserved: ConservedMomentum,
    /// Scales of the energy and of the conserved momentum of a body, for relative drifts.
    pub invariant_scales: fn(&Body) -> [f64; 2],
    /// The scene whose systems integrate these bodies too, if this scene has no system with the needed variables.
    pub special_case_of: Option<&'static Scene>,
}

/// Scenes are equal if their kinds are equal.
impl PartialEq for Scene {
    fn eq(&self, other: &Scene) -> bool {
        self.kind == other.kind
    }
}

impl Scene {
    /// The scene of that kind.
    ///
    /// # Errors
    /// If no scene has this kind.
    pub fn parse(kind: &str) -> Result<&'static Scene, Error> {
        ALL.iter().copied().find(|scene| scene.kind == kind).ok_or_else(|| Error::Unknown {
            argument: "scene",
            value: kind.to_string(),
            known: ALL.iter().map(|scene| scene.kind).collect::<Vec<_>>().join(", "),
        })
    }
}

/// The conserved momentum of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ConservedMomentum {
    /// `L.L`: there is no torque.
    Square,
    /// `L.gamma`: there is no torque about the vertical.
    Vertical,
}

impl ConservedMomentum {
    /// The vector whose product with the angular momentum is conserved.
    #[inline(always)]
    pub fn factor(self, momentum: [f64; 3], gamma: [f64; 3]) -> [f64; 3] {
        match self {
            ConservedMomentum::Square => momentum,
            ConservedMomentum::Vertical => gamma,
        }
    }

    /// The scale for an angular momentum of this length. A drift of `L.L` relative to `2 L.L` equals the relative drift
    /// of |L|.
    pub fn scale(self, length: f64) -> f64 {
        match self {
            ConservedMomentum::Square => 2.0 * length * length,
            ConservedMomentum::Vertical => length,
        }
    }
}

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

/// The equations of a scene: the torque and the conserved quantities. If there is weight, `y[3..6]` is the vertical.
pub trait Model<R: Real>: Copy {
    /// Whether there may be weight.
    const HEAVY: bool = true;
    /// The model of numbers that change.
    type Varied: Model<Dual<R>>;
    /// Constants of the equations of motion from the constants of the body.
    fn new(p: &Parameters<R>) -> Self;
    /// The constants with their change by that of the parameters, from one over the moments.
    fn varied(&self, by: &ParameterChange<R>, inverse: &[R; 3]) -> Self::Varied;
    /// Euler's equations from the products `w2 w3`, `w3 w1`, `w1 w2`. The equations are linear in the products and in
    /// the vertical, so Cauchy products and one order of the vertical give the same order of the rate of change.
    fn euler<const D: usize>(&self, products: &[R; 3], y: &[R; D]) -> [R; 3];
    /// `(I2 - I3) / I1` and its cyclic neighbours: the change of a rate per product of the others, without weight.
    fn ratios(&self) -> [R; 3];
    /// The model whose rates of change are those over a unit of time.
    fn in_units(&self, unit: R) -> Self;
    /// Exact flow of the potential alone over the time `h`.
    fn kick<const D: usize>(p: &Parameters<R>, h: R, momentum: &mut [R; 3], y: &[R; D]);
    /// Exact flow over `h` of the potential `V - (weight / h) torque.torque / I`, which contains the force gradient.
    fn gradient_kick<const D: usize>(p: &Parameters<R>, h: R, weight: R, momentum: &mut [R; 3], y: &[R; D]);
    /// Torque of the potential in the body.
    fn torque<const D: usize>(p: &Parameters<R>, y: &[R; D]) -> [R; 3];
    /// Potential energy.
    fn potential<const D: usize>(p: &Parameters<R>, y: &[R; D]) -> R;
    /// The conserved component of the angular momentum: `L.L` of a free body, `L.gamma` of a top.
    fn conserved<const D: usize>(momentum: &[R; 3], y: &[R; D]) -> R;
}
