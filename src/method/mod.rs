//! Schemes as tables of constants, and the engines that run them.

mod runge_kutta;
mod splitting;
mod taylor;

pub use runge_kutta::{RungeKutta, Tableau};
pub use splitting::{Composition, Flow, Splitting};
pub use taylor::{Coefficients, Series, Taylor};
pub(crate) use taylor::{MAX_ORDER, two_sum};

use crate::model::{Layout, Model, Parameters, dot};
use crate::real::Real;

/// What the first three numbers of a state are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// Angular velocity in the body.
    Rates,
    /// Angular momentum in the body.
    Momenta,
}

/// What a scheme promises, and who found it.
#[derive(Clone, Copy, Debug)]
pub struct Facts {
    /// The name to ask for.
    pub name: &'static str,
    /// One line.
    pub title: &'static str,
    /// Error of a run ~ step^order.
    pub order: u32,
    /// Evaluations of the equations of motion (Runge-Kutta), exact partial flows (splitting) or orders of the
    /// series (Taylor) a step.
    pub stages: usize,
    /// Preserves the symplectic (Poisson) structure.
    pub symplectic: bool,
    /// A step forward and a step back is the identity.
    pub reversible: bool,
    /// |L| of the free body, |gamma| and |q| stay as they are, up to rounding.
    pub group_preserving: bool,
    /// Largest angle that the body may turn in a step, when the step is left to us.
    pub angle_per_step: f64,
    /// Paper.
    pub citation: &'static str,
    /// Its DOI, if there is one.
    pub doi: &'static str,
}

/// One step of a scheme for one pack of bodies.
pub trait Scheme<R: Real, M: Model<R>, L: Layout, const D: usize>: Copy {
    /// The variables that it moves.
    const FORM: Form;
    /// Whether it keeps what rounding took from the state of one step for the next.
    const CARRIES: bool = false;
    /// Prepares the constants of the step.
    fn new(p: &Parameters<R>) -> Self;
    /// Advances the state by one step.
    fn step(&self, p: &Parameters<R>, y: &mut [R; D]);
    /// The same; `carry` is what the state has lost to rounding so far.
    #[inline(always)]
    fn step_carrying(&self, p: &Parameters<R>, y: &mut [R; D], _carry: &mut [R; D]) {
        self.step(p, y);
    }
    /// Of a series: the order of its highest coefficient; else 0.
    const ORDER: usize = 0;
    /// Of a series: the coefficients of the motion from `y` on, in powers of the time over `unit`; written where they
    /// are wanted, because moving them would cost a tenth of finding them.
    #[inline(always)]
    fn coefficients(&self, _unit: R, _y: &[R; D], _to: &mut Coefficients<R, D>) {
        unreachable!("only series have coefficients")
    }
    /// Rate of change of the first three numbers of the state.
    fn velocity(&self, p: &Parameters<R>, y: &[R; D]) -> [R; 3];
    /// The angular momentum in the body.
    fn momentum(p: &Parameters<R>, y: &[R; D]) -> [R; 3];
    /// Kinetic energy.
    fn kinetic(p: &Parameters<R>, y: &[R; D]) -> R;
}

/// Classical Runge-Kutta of order 4.
#[derive(Clone, Copy)]
pub struct Rk4;

/// Dormand-Prince of order 8.
#[derive(Clone, Copy)]
pub struct Dop853;

/// Planar rotations about the principal axes, for any body.
#[derive(Clone, Copy)]
pub struct Planar;

/// Exact rotor of a body that is symmetric about its axis 3.
#[derive(Clone, Copy)]
pub struct Rotor;

macro_rules! taylor_tables {
    ($($(#[$doc:meta])* $table:ident;)*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy)]
        pub struct $table;
    )*};
}
taylor_tables! {
    /// Taylor series of order 8.
    Taylor8;
    /// Taylor series of order 12.
    Taylor12;
    /// Taylor series of order 16.
    Taylor16;
    /// Taylor series of order 20.
    Taylor20;
    /// Taylor series of order 26.
    Taylor26;
}

/// The angular momentum, of rates.
#[inline(always)]
fn momentum_of_rates<R: Real, const D: usize>(p: &Parameters<R>, y: &[R; D]) -> [R; 3] {
    [p.moments[0] * y[0], p.moments[1] * y[1], p.moments[2] * y[2]]
}

/// Kinetic energy, of rates.
#[inline(always)]
fn kinetic_of_rates<R: Real, const D: usize>(p: &Parameters<R>, y: &[R; D]) -> R {
    dot(&momentum_of_rates(p, y), &[y[0], y[1], y[2]]) * R::splat(0.5)
}

/// A method as users name it; a splitting takes the rotor where the body is symmetric.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// `rk4`.
    Rk4,
    /// `dop853`.
    Dop853,
    /// `splitting`.
    Splitting,
    /// `taylor8`.
    Taylor8,
    /// `taylor12`.
    Taylor12,
    /// `taylor16`.
    Taylor16,
    /// `taylor20`.
    Taylor20,
    /// `taylor26`.
    Taylor26,
}

impl Method {
    /// The one list of methods: everything that is said of all methods is said over it.
    pub const ALL: [Method; 8] = [
        Method::Rk4,
        Method::Dop853,
        Method::Splitting,
        Method::Taylor8,
        Method::Taylor12,
        Method::Taylor16,
        Method::Taylor20,
        Method::Taylor26,
    ];

    /// What it promises.
    pub fn facts(self) -> Facts {
        match self {
            Method::Rk4 => Rk4::FACTS,
            Method::Dop853 => Dop853::FACTS,
            Method::Splitting => Planar::FACTS,
            Method::Taylor8 => Taylor8::FACTS,
            Method::Taylor12 => Taylor12::FACTS,
            Method::Taylor16 => Taylor16::FACTS,
            Method::Taylor20 => Taylor20::FACTS,
            Method::Taylor26 => Taylor26::FACTS,
        }
    }

    /// Whether it is a series, and so chooses its steps where it is given a tolerance.
    pub fn is_series(self) -> bool {
        !matches!(self, Method::Rk4 | Method::Splitting)
    }

    /// The method of that name.
    pub fn parse(name: &str) -> Result<Method, crate::error::Error> {
        Method::ALL.into_iter().find(|m| m.facts().name == name).ok_or_else(|| crate::error::Error::Unknown {
            argument: "method",
            value: name.to_string(),
            known: Method::ALL.map(|m| m.facts().name).join(", "),
        })
    }
}
