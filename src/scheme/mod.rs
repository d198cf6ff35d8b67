//! Schemes as constants, and the engines that run them.
//!
//! A scheme is one constant, listed in [`ALL`]: its facts, and its step for each kind of body. A step is an
//! engine and its numbers; all other properties of a scheme follow from its steps.

mod compositions;
mod exponential;
mod midpoint;
mod moser_veselov;
mod runge_kutta;
mod splitting;
mod taylor;

use compositions::check_composition;
pub(crate) use exponential::phi;
pub use exponential::{AffineSplitting, Exponential};
pub use midpoint::ImplicitMidpoint;
pub use moser_veselov::MoserVeselov;
pub use runge_kutta::{Dop853Tableau, Rk4Tableau, RungeKutta, Tableau};
pub use splitting::{
    ComposedPlanar, Drift, ExactRotor, Flow, KickMoserVeselov, KickRotor, Planar, Processor, Round,
    Splitting, Way,
};
pub(crate) use taylor::two_sum;
pub use taylor::{Coefficients, Taylor};

use crate::error::Error;
use crate::forcing::ForcingInterval;
use crate::kinematics::dot;
use crate::real::Real;
use crate::scene::{Applied, Layout, Model, Parameters, Scene};

/// The list of all schemes, by the module of their constants.
macro_rules! schemes {
    ($($module:ident: $($name:ident)*;)*) => {
        $(pub use $module::{$($name),*};)*

        /// All schemes, in the order in which they are listed to users.
        pub const ALL: &[&Scheme] = &[$($(&$name),*),*];
    };
}
schemes! {
    runge_kutta: RK4 DOP853;
    taylor: TAYLOR8 TAYLOR12 TAYLOR16 TAYLOR20 TAYLOR26;
    compositions: SPLITTING SPLITTING4 SPLITTING6 SPLITTING8 CHIN4A SRKN6 SRKN11 SRKN14 PMLF4 PMLF6
        DMV2 DMV4 DMV6 DMV8 DMV10;
    exponential: ETD4;
    midpoint: MIDPOINT;
}

/// The default scheme of bodies without a closed form.
pub const DEFAULT: &Scheme = &RK4;

/// The scheme that cross-checks the samples of a map. It has a high order, so that it is right where the other scheme
/// is wrong: a run of the first scheme with half the step would have a similar error, and at order 2 one wrong
/// classification in four would not be found.
pub const SECOND: &Scheme = &TAYLOR16;

/// The scheme for strong damping; without damping it is the default scheme.
pub const STIFF: &Scheme = &ETD4;

/// Properties of a scheme, and its source.
#[derive(Clone, Copy, Debug)]
pub struct Facts {
    /// The name that users pass as the method.
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
    /// Largest angle that the body turns in a default step.
    pub angle_per_step: f64,
    /// Paper.
    pub citation: &'static str,
    /// DOI of the paper, if there is one.
    pub doi: &'static str,
}

/// A scheme as users name it.
#[derive(Clone, Copy)]
pub struct Scheme {
    /// Properties of the scheme.
    pub facts: Facts,
    /// The step of a body without symmetry.
    pub any: Step,
    /// The step of a body whose moments about two axes are equal.
    pub symmetric: Step,
    /// Whether the path of a Lagrange top is integrated as that of a reduced top. The oldest schemes are kept in the
    /// frame of the body, as they were published.
    pub reduced: bool,
    /// The step under torque and damping; `None` if the scheme does not integrate forced bodies.
    pub forced: Option<ForcedStep>,
}

/// The step of a scheme for bodies under torque and damping, and its limit of stability.
#[derive(Clone, Copy)]
pub struct ForcedStep {
    /// The step.
    pub step: Step,
    /// The largest product of step and damping rate with which the scheme is stable; infinite if every product is. For an
    /// explicit scheme: where its stability function, on the negative real axis, first leaves -1 .. 1, rounded down; for
    /// a series half of that, because higher powers of the rates decay faster by their exponent.
    pub damping_limit: f64,
}

/// A step: an engine and its numbers.
#[derive(Clone, Copy)]
pub struct Step {
    /// The code.
    pub engine: Engine,
    /// The numbers that the code reads.
    pub numbers: &'static Numbers,
}

/// The code that makes a step. Schemes that differ only in their numbers share an engine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Engine {
    /// Runge-Kutta with the tableau of `rk4`: its numbers are literals in the code.
    Rk4,
    /// Runge-Kutta with the tableau of `dop853`.
    Dop853,
    /// A Taylor series of any order.
    Taylor,
    /// A Taylor series with compensated sums.
    CompensatedTaylor,
    /// Planar rotations about the principal axes and kicks, of order 2.
    Planar,
    /// The planar rotations and kicks with any numbers.
    ComposedPlanar,
    /// The exact rotor of a body that is symmetric about its axis 3, and kicks.
    KickRotor,
    /// Discrete Moser-Veselov drifts of any body, and kicks.
    KickMoserVeselov,
    /// Planar rotations, and one kick by torque and damping together.
    Affine,
    /// Exponential Runge-Kutta.
    Exponential,
    /// The implicit midpoint rule.
    Midpoint,
}

/// The first three variables of a state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variables {
    /// Angular velocity in the body.
    Rates,
    /// Angular momentum in the body.
    Momenta,
}

/// The numbers of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Numbers {
    /// Order of a Taylor series.
    pub order: usize,
    /// Fractions of the step, flow after flow, round after round; the last round may break off after one flow.
    pub fractions: &'static [f64],
    /// Weight of the force gradient in the kicks of each round: `c` adds `-c h^3 tau.tau/I` to `b h V`.
    pub gradients: &'static [f64],
    /// The processor: a change of variables before the first step, undone after the last.
    pub processor: Option<Processor>,
    /// Order of a drift that is not exact.
    pub drift_order: usize,
}

impl Numbers {
    /// No numbers.
    pub const NONE: Numbers = Numbers::of(&[]);

    /// Flows over fractions of the step, and nothing else.
    pub const fn of(fractions: &'static [f64]) -> Numbers {
        Numbers { order: 0, fractions, gradients: &[], processor: None, drift_order: 0 }
    }
}

impl Engine {
    /// The variables that it integrates.
    pub const fn variables(self) -> Variables {
        use Engine::*;
        match self {
            Rk4 | Dop853 | Taylor | CompensatedTaylor | Exponential => Variables::Rates,
            Planar | ComposedPlanar | KickRotor | KickMoserVeselov | Affine | Midpoint => Variables::Momenta,
        }
    }

    /// The flows of a round, if it composes exact flows of parts of the motion.
    const fn flows(self) -> Option<&'static [Flow]> {
        match self {
            Engine::Planar => Some(Planar::FLOWS),
            Engine::ComposedPlanar => Some(ComposedPlanar::FLOWS),
            Engine::KickRotor => Some(KickRotor::FLOWS),
            Engine::KickMoserVeselov => Some(KickMoserVeselov::FLOWS),
            _ => None,
        }
    }
}

impl std::fmt::Debug for Step {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let makes = |scheme: &&&Scheme| scheme.steps().contains(self);
        let scheme = ALL.iter().find(makes).map_or("none", |scheme| scheme.facts.name);
        write!(f, "{:?} of {scheme}", self.engine)
    }
}

impl PartialEq for Step {
    fn eq(&self, other: &Step) -> bool {
        let same = std::ptr::eq(self.numbers, other.numbers);
        self.engine == other.engine && (same || self.numbers == other.numbers)
    }
}

impl Step {
    /// A step of an engine that has no numbers, or has them as literals.
    const fn plain(engine: Engine) -> Step {
        Step { engine, numbers: &Numbers::NONE }
    }

    /// Whether it leaves the polynomial of the motion behind, and may choose its size by a tolerance.
    pub const fn is_series(self) -> bool {
        matches!(self.engine, Engine::Taylor | Engine::CompensatedTaylor)
    }

    /// Whether it is made in other variables than the state, so that nothing can be observed between steps.
    pub const fn is_processed(self) -> bool {
        self.numbers.processor.is_some()
    }

    /// Whether it integrates bodies that have weight: a composition without kicks is a free motion.
    pub const fn moves_weight(self) -> bool {
        let Some(flows) = self.engine.flows() else { return true };
        let mut i = 0;
        while i < self.numbers.fractions.len() {
            if matches!(flows[i % flows.len()], Flow::Kick) && self.numbers.fractions[i] != 0.0 {
                return true;
            }
            i += 1;
        }
        false
    }

    /// The step of a body without weight: kicks and drifts become one drift that is exact, or of the highest order.
    pub const fn torque_free(self) -> Step {
        match self.engine {
            Engine::KickRotor => SPLITTING.symmetric,
            Engine::KickMoserVeselov if self.moves_weight() => DMV10.any,
            _ => self,
        }
    }
}

/// Schemes are equal if their names are equal.
impl PartialEq for Scheme {
    fn eq(&self, other: &Scheme) -> bool {
        self.facts.name == other.facts.name
    }
}
impl Eq for Scheme {}

impl std::fmt::Debug for Scheme {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.facts.name)
    }
}

impl Scheme {
    /// A scheme that makes one step for all bodies, stable under torque and damping up to that product of step and
    /// damping rate.
    const fn direct(facts: Facts, step: Step, reduced: bool, damping_limit: f64) -> Scheme {
        Scheme {
            facts,
            any: step,
            symmetric: step,
            reduced,
            forced: Some(ForcedStep { step, damping_limit }),
        }
    }

    /// The steps that it makes, of some body.
    pub fn steps(&self) -> Vec<Step> {
        [self.any, self.symmetric].into_iter().chain(self.forced.map(|forced| forced.step)).collect()
    }

    /// The scheme of that name.
    ///
    /// # Errors
    /// If there is none: the message lists all names.
    pub fn parse(name: &str) -> Result<&'static Scheme, Error> {
        ALL.iter().copied().find(|scheme| scheme.facts.name == name).ok_or_else(|| Error::Unknown {
            argument: "method",
            value: name.to_string(),
            known: ALL.iter().map(|scheme| scheme.facts.name).collect::<Vec<_>>().join(", "),
        })
    }

    /// Whether it is a series, and so chooses its steps where it is given a tolerance.
    pub const fn is_series(&self) -> bool {
        self.any.is_series()
    }

    /// Whether its steps are made in other variables than the states between them, so that nothing can be observed.
    pub const fn is_processed(&self) -> bool {
        self.any.is_processed()
    }

    /// Whether it integrates bodies that have weight.
    pub const fn moves_tops(&self) -> bool {
        self.any.moves_weight()
    }

    /// See [`ForcedStep::damping_limit`]; `None` if it does not integrate bodies under torque and damping.
    pub fn damping_limit(&self) -> Option<f64> {
        self.forced.map(|forced| forced.damping_limit)
    }

    /// Whether it is stable under damping of any strength.
    pub fn is_stiff(&self) -> bool {
        self.damping_limit() == Some(f64::INFINITY)
    }

    /// The scheme that cross-checks samples classified by this scheme. A scheme for strong damping is cross-checked by
    /// [`STIFF`], because an explicit scheme could need a thousand times the steps.
    pub fn second(&self, is_forced: bool) -> &'static Scheme {
        if is_forced && self.is_stiff() { STIFF } else { SECOND }
    }

    /// Raises an error for a scene that it does not integrate, and for observation of variables that are not the state.
    ///
    /// # Errors
    /// Naming the scheme and the rule.
    pub fn check(&self, scene: &Scene, is_observed: bool) -> Result<(), Error> {
        let refuse =
            |rule| Err(Error::Value { argument: "method", value: format!("'{}'", self.facts.name), rule });
        if scene.has_weight && !self.moves_tops() {
            return refuse("moves free bodies only, a top has weight");
        }
        if is_observed && self.is_processed() {
            return refuse("a processed method has states only at wanted times, a map watches every step");
        }
        Ok(())
    }
}

/// Highest order of any series.
pub const MAX_ORDER: usize = {
    let (mut highest, mut i) = (0, 0);
    while i < ALL.len() {
        let order = ALL[i].any.numbers.order;
        highest = if order > highest { order } else { highest };
        i += 1;
    }
    highest
};

/// Every scheme is checked when it is compiled.
const _: () = {
    let mut i = 0;
    while i < ALL.len() {
        let Scheme { facts, any, symmetric, .. } = *ALL[i];
        assert!(any.is_series() == symmetric.is_series() && any.is_processed() == symmetric.is_processed());
        if any.is_series() {
            assert!(any.numbers.order == facts.order as usize && facts.order % 2 == 0);
        }
        if any.engine.flows().is_some() && any.moves_weight() {
            assert!(any.numbers.fractions.len() == facts.stages);
            check_composition(any, facts);
            check_composition(symmetric, facts);
        }
        i += 1;
    }
};

/// Euler's equations: the rate of change of the rates, of a state of rates.
#[inline(always)]
fn acceleration<R: Real, M: Model<R>, L: Layout, const D: usize>(
    model: &M,
    applied: &Applied<R>,
    y: &[R; D],
) -> [R; 3] {
    let [w1, w2, w3] = [y[0], y[1], y[2]];
    let mut rate = model.euler(&[w2 * w3, w3 * w1, w1 * w2], y);
    if L::BALANCE {
        let change = applied.over_moments(&applied.torque::<L, D>(y));
        for i in 0..3 {
            rate[i] = rate[i] + change[i];
        }
    }
    rate
}

/// The step of an engine for one pack of bodies. `R` is the pack; a state of the layout `L` has `D` numbers.
pub trait Stepper<R: Real, M: Model<R>, L: Layout, const D: usize>: Copy {
    /// The variables that it integrates: those of its engine.
    const VARIABLES: Variables;
    /// Whether it integrates that model with that layout. Code is made where it does.
    const MOVES: bool;
    /// Whether it compensates the rounding error of the state in the next step.
    const COMPENSATED: bool = false;
    /// Whether a step leaves the coefficients of its polynomial behind.
    const IS_SERIES: bool = false;
    /// Whether it can make its steps in other variables than the state.
    const PROCESSED: bool = false;
    /// Prepares the constants of the step.
    fn new(p: &Parameters<R>, forcing: &ForcingInterval<R>, numbers: &'static Numbers) -> Self;
    /// Into the variables of the steps, before the first of a run of equal steps; or back, after the last.
    #[inline(always)]
    fn process(&self, _p: &Parameters<R>, _y: &mut [R; D], _leaving: bool) {}
    /// Advances the state by one step. A compensated sum keeps in `compensation` the rounding error of the state so
    /// far, and a series leaves its coefficients in `dense`, in powers of the fraction of the step.
    fn step(
        &self,
        p: &Parameters<R>,
        y: &mut [R; D],
        compensation: &mut [R; D],
        dense: &mut Coefficients<R, D>,
    );
    /// The coefficients of the motion from `y` on, in powers of the time over `unit`; of a series. Written in place,
    /// because moving the coefficients would cost a tenth of their computation.
    #[inline(always)]
    fn expand(&self, _unit: R, _y: &[R; D], _dense: &mut Coefficients<R, D>) {
        unreachable!("only series have coefficients")
    }
    /// Rate of change of the first three numbers of the state.
    fn velocity(&self, p: &Parameters<R>, y: &[R; D]) -> [R; 3];
    /// The angular velocity in the body.
    #[inline(always)]
    fn rates(p: &Parameters<R>, y: &[R; D]) -> [R; 3] {
        match Self::VARIABLES {
            Variables::Rates => [y[0], y[1], y[2]],
            Variables::Momenta => [y[0] / p.moments[0], y[1] / p.moments[1], y[2] / p.moments[2]],
        }
    }
    /// The angular momentum in the body.
    #[inline(always)]
    fn momentum(p: &Parameters<R>, y: &[R; D]) -> [R; 3] {
        match Self::VARIABLES {
            Variables::Rates => [p.moments[0] * y[0], p.moments[1] * y[1], p.moments[2] * y[2]],
            Variables::Momenta => [y[0], y[1], y[2]],
        }
    }
    /// Kinetic energy.
    #[inline(always)]
    fn kinetic(p: &Parameters<R>, y: &[R; D]) -> R {
        dot(&Self::momentum(p, y), &Self::rates(p, y)) * R::splat(0.5)
    }
}
