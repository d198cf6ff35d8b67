//! Schemes as tables of constants, and the engines that run them.

mod compositions;
mod midpoint;
mod moser_veselov;
mod runge_kutta;
mod splitting;
mod stiff;
mod taylor;

pub use midpoint::ImplicitMidpoint;
pub use moser_veselov::MoserVeselov;
pub use runge_kutta::{RungeKutta, Tableau};
pub use splitting::{Composition, Drift, ExactRotor, Flow, Numbers, Processor, Splitting, Way};
pub(crate) use stiff::phi;
pub use stiff::{AffineSplitting, Exponential};
pub use taylor::{Coefficients, Series, Taylor};
pub(crate) use taylor::{MAX_ORDER, two_sum};

use crate::error::Error;

use crate::model::{Drive, Layout, Model, Parameters, dot};
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
    /// Evaluations of the equations of motion (Runge-Kutta), exact partial flows (splitting), orders of the
    /// series (Taylor) or Newton's steps (midpoint) a step.
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
    /// The same for the numbers of another table that the engine may run; most run their own alone.
    #[inline(always)]
    fn with(p: &Parameters<R>, _numbers: &'static Numbers) -> Self {
        Self::new(p)
    }
    /// The same under what acts from outside.
    #[inline(always)]
    fn driven(p: &Parameters<R>, _drive: &Drive<R>, numbers: &'static Numbers) -> Self {
        Self::with(p, numbers)
    }
    /// Into the variables of the steps, before the first of a run of equal steps; or back, after the last.
    #[inline(always)]
    fn process(&self, _p: &Parameters<R>, _y: &mut [R; D], _leaving: bool) {}
    /// Advances the state by one step.
    fn step(&self, p: &Parameters<R>, y: &mut [R; D]);
    /// The same; `carry` is what the state has lost to rounding so far, and a series leaves its coefficients behind, in
    /// powers of the share of the step.
    #[inline(always)]
    fn step_leaving(
        &self,
        p: &Parameters<R>,
        y: &mut [R; D],
        _carry: &mut [R; D],
        _to: &mut Coefficients<R, D>,
    ) {
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

macro_rules! tables {
    ($($doc:literal $($name:ident)*;)*) => {$($(
        #[doc = $doc]
        #[derive(Clone, Copy)]
        pub struct $name;
    )*)*};
}
tables! {
    "Classical Runge-Kutta of order 4."
        Rk4;
    "Dormand-Prince of order 8."
        Dop853;
    "Taylor series of that order."
        Taylor8 Taylor12 Taylor16 Taylor20 Taylor26;
    "Planar rotations about the principal axes, for any body; the number is the order of a composition."
        Planar Planar4 Planar6 Planar8;
    "Exact rotor of a body that is symmetric about its axis 3, and kicks."
        Rotor Rotor4 Rotor6 Rotor8 Chin4a Srkn6 Srkn11 Srkn14 Pmlf4 Pmlf6;
    "The same kicks between discrete Moser-Veselov drifts, for any body."
        DmvChin4a DmvSrkn6 DmvSrkn11 DmvSrkn14 DmvPmlf4 DmvPmlf6;
    "Discrete Moser-Veselov drifts alone, for any free body."
        Dmv2 Dmv4 Dmv6 Dmv8 Dmv10;
    "Planar rotations and a kick by torques and damping together, for driven bodies."
        Affine;
    "Exponential Runge-Kutta of order 4, for driven bodies."
        Etd4;
    "Implicit midpoint rule."
        Midpoint;
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

macro_rules! methods {
    ($($name:ident: $table:ident;)*) => {
        /// A method as users name it; the table follows from the body.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[allow(missing_docs)] // The names are those of the facts.
        pub enum Method {
            $($name,)*
        }
        impl Method {
            /// The one list of methods: everything that is said of all methods is said over it.
            pub const ALL: [Method; [$(Method::$name),*].len()] = [$(Method::$name),*];

            /// What it promises.
            pub fn facts(self) -> Facts {
                match self {
                    $(Method::$name => $table::FACTS,)*
                }
            }
        }
    };
}
methods! {
    Rk4: Rk4;
    Dop853: Dop853;
    Taylor8: Taylor8;
    Taylor12: Taylor12;
    Taylor16: Taylor16;
    Taylor20: Taylor20;
    Taylor26: Taylor26;
    Splitting: Planar;
    Splitting4: Planar4;
    Splitting6: Planar6;
    Splitting8: Planar8;
    Chin4a: Chin4a;
    Srkn6: Srkn6;
    Srkn11: Srkn11;
    Srkn14: Srkn14;
    Pmlf4: Pmlf4;
    Pmlf6: Pmlf6;
    Dmv2: Dmv2;
    Dmv4: Dmv4;
    Dmv6: Dmv6;
    Dmv8: Dmv8;
    Dmv10: Dmv10;
    Etd4: Etd4;
    Midpoint: Midpoint;
}

impl Method {
    /// Whether it is a series, and so chooses its steps where it is given a tolerance.
    pub fn is_series(self) -> bool {
        use Method::*;
        matches!(self, Taylor8 | Taylor12 | Taylor16 | Taylor20 | Taylor26)
    }

    /// The method of that name.
    pub fn parse(name: &str) -> Result<Method, Error> {
        Method::ALL.into_iter().find(|m| m.facts().name == name).ok_or_else(|| Error::Unknown {
            argument: "method",
            value: name.to_string(),
            known: Method::ALL.map(|m| m.facts().name).join(", "),
        })
    }

    /// The largest product of step and damping rate with which it is stable under damping (infinite: any); `None` if it
    /// does not move bodies under torque and damping. Of an explicit method: where its stability function, on the
    /// negative real axis, first leaves -1 .. 1, rounded down; of a series half of that, because what the rates leave
    /// of higher powers decays that many times as fast.
    pub fn damping_limit(self) -> Option<f64> {
        use Method::*;
        match self {
            Rk4 => Some(2.78),
            Dop853 => Some(6.39),
            Taylor8 => Some(2.15),
            Taylor12 => Some(2.91),
            Taylor16 => Some(3.66),
            Taylor20 => Some(4.41),
            Taylor26 => Some(5.53),
            Splitting | Etd4 | Midpoint => Some(f64::INFINITY),
            _ => None,
        }
    }

    /// Whether steps are made in other variables than the states between them, so that nothing can be watched.
    pub fn is_processed(self) -> bool {
        matches!(self, Method::Pmlf4 | Method::Pmlf6)
    }

    /// Whether it moves bodies that have weight.
    pub fn moves_tops(self) -> bool {
        !matches!(self, Method::Dmv2 | Method::Dmv4 | Method::Dmv6 | Method::Dmv8 | Method::Dmv10)
    }

    /// Refuses a scene that it does not move, and what is watched in variables that are not the state.
    pub fn check(self, is_top: bool, is_watched: bool) -> Result<(), Error> {
        let refuse =
            |rule| Err(Error::Value { argument: "method", value: format!("'{}'", self.facts().name), rule });
        if is_top && !self.moves_tops() {
            return refuse("moves free bodies only, a top has weight");
        }
        if is_watched && self.is_processed() {
            return refuse("a processed method has states only at wanted times, a map watches every step");
        }
        Ok(())
    }
}
