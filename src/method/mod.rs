//! Methods as constants, and the engines that run them.
//!
//! A method is one constant, listed in [`ALL`]: its facts, and its step for each kind of body. A step is an
//! engine and its numbers; all other properties of a method follow from its steps.

mod alone;
mod any;
mod compositions;
mod deviations;
mod engine;
mod exponential;
mod midpoint;
mod moser_veselov;
mod orbit_steps;
mod runge_kutta;
mod splitting;
mod tableau;
mod tangent;
mod taylor;

pub use crate::series::{Coefficients, MAX_ORDER};
pub use alone::{COLUMNS, Columns, SeriesAlone, in_columns};
pub use any::{AnyMethod, default_step};
use compositions::check_composition;
pub use engine::EngineName;
pub(crate) use engine::engines;
pub(crate) use exponential::phi;
pub use exponential::{AffineSplitting, Exponential};
pub use midpoint::ImplicitMidpoint;
pub use moser_veselov::MoserVeselov;
pub use orbit_steps::OrbitSteps;
pub use runge_kutta::RungeKutta;
pub use splitting::{
    ComposedPlanar, Composition, Drift, ExactRotor, Flow, KickMoserVeselov, KickRotor, Planar, Processor,
    Round, Splitting,
};
pub use tableau::{Dop853Tableau, Rk4Tableau, Tableau};
pub use taylor::Taylor;
pub(crate) use taylor::{bound_of_margins, in_halves};

use crate::error::{Error, refuse};
use crate::forces::ForcesInterval;
use crate::forces::{ForceSet, Further, NO_FURTHER};
use crate::kinematics::{direction, direction_rate, dot, doubled_attitude_rate, plus, put};
use crate::real::Real;
use crate::scene::{Applied, Layout, Model, Parameters, ROWS_LEN, Scene, in_rows, quaternion};

/// The list of all methods: families, the modules of their constants, and these.
macro_rules! methods {
    ($($family:literal, $module:ident: $($name:ident)*;)*) => {
        $(pub use $module::{$($name),*};)*

        /// All methods, in the order in which they are listed to users.
        pub const ALL: &[&Method] = &[$($(&$name),*),*];
        /// The methods of each family.
        pub const FAMILIES: &[(&str, &[&Method])] = &[$(($family, &[$(&$name),*])),*];
    };
}
methods! {
    "Runge–Kutta", runge_kutta: RK4 DOP853;
    "Taylor series", taylor: TAYLOR12 TAYLOR16 TAYLOR20 TAYLOR26;
    "splitting", compositions: SPLITTING SPLITTING4 SPLITTING8;
    "free motion and kicks", compositions: CHIN4A PMLF4 PMLF6;
    "Moser–Veselov", compositions: DMV2 DMV10;
    "exponential", exponential: ETD4;
    "midpoint rule", midpoint: MIDPOINT;
}

/// Every step of every method, each once.
pub fn steps() -> Vec<Step> {
    let mut all: Vec<Step> = Vec::new();
    for step in ALL.iter().flat_map(|method| method.steps()) {
        if !all.contains(&step) {
            all.push(step);
        }
    }
    all
}

/// The default method of bodies without a closed form.
pub const DEFAULT: &Method = &RK4;

/// The method that cross-checks the samples of a map. The order is high, so that its errors differ from those of the
/// first method. A second run of the first method with half the step would have similar errors: at order 2 such a
/// check would not find one wrong classification in four.
pub const SECOND: &Method = &DOP853;

/// The method of motions that are judged at many times.
pub const MANY_TIMES: &Method = &TAYLOR12;

/// The method of motions that are asked for to rounding.
pub const TO_ROUNDING: &Method = &TAYLOR16;

/// The series that leaves rounding alone.
pub const SERIES: &Method = &TAYLOR20;

/// The method that knows its motion inside steps under the torque of a function, and adapts its steps there.
pub const FUNCTION: &Method = &DOP853;

/// The method for strong damping; without damping it is the default method.
pub const STIFF: &Method = &ETD4;

/// Properties of a method, and its source.
#[derive(Clone, Copy, Debug)]
pub struct Facts {
    /// The name that users pass as the method.
    pub name: &'static str,
    /// A description in one line.
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
    /// |L| of the free body, |gamma| and |q| are constant up to rounding.
    pub group_preserving: bool,
    /// What is constant up to rounding at any step of a free body: momentum (in space), energy.
    pub conserves: &'static [&'static str],
    /// Largest angle that the body turns in a default step.
    pub angle_per_step: f64,
    /// Largest angle of a step that the method bears: over a thousand radians the energy, the angular momentum and the
    /// length of the quaternion change by less than a thousandth. Measured for free bodies and tops, rounded
    /// down (`tests/python/solve/test_motion.py`).
    pub longest_angle: f64,
    /// The paper.
    pub citation: &'static str,
    /// DOI of the paper, if there is one.
    pub doi: &'static str,
}

/// A method as users name it.
#[derive(Clone, Copy)]
pub struct Method {
    /// Properties of the method.
    pub facts: Facts,
    /// The step of a body without symmetry.
    pub any: Step,
    /// The step of a body whose moments about two axes are equal.
    pub symmetric: Step,
    /// The step under torque and damping; `None` if the method does not integrate forced bodies.
    pub forced: Option<ForcedStep>,
}

/// The step of a method for bodies under torque and damping, and its limit of stability.
#[derive(Clone, Copy)]
pub struct ForcedStep {
    /// The step.
    pub step: Step,
    /// The largest product of step and damping rate for which the method is stable; infinite if the method is stable
    /// for every product. The limit of an explicit method is where its stability function, on the negative real axis,
    /// first leaves -1 .. 1, rounded down. The limit of a series is half of this value, because higher powers of the
    /// rates decay faster by their exponent.
    pub damping_limit: f64,
}

/// A step: an engine and its numbers.
#[derive(Clone, Copy)]
pub struct Step {
    /// The code of the step.
    pub engine: EngineName,
    /// The numbers that the code reads.
    pub numbers: &'static Numbers,
}

/// The first three variables of a state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variables {
    /// Angular velocity in the body.
    Rates,
    /// Angular momentum in the body.
    Momenta,
}

impl Variables {
    /// The angular velocity in the body, of a state.
    #[inline(always)]
    pub fn rates<R: Real, const D: usize>(self, p: &Parameters<R>, y: &[R; D]) -> [R; 3] {
        match self {
            Variables::Rates => [y[0], y[1], y[2]],
            Variables::Momenta => [y[0] / p.moments[0], y[1] / p.moments[1], y[2] / p.moments[2]],
        }
    }

    /// The angular momentum in the body, of a state.
    #[inline(always)]
    pub fn momentum<R: Real, const D: usize>(self, p: &Parameters<R>, y: &[R; D]) -> [R; 3] {
        match self {
            Variables::Rates => [p.moments[0] * y[0], p.moments[1] * y[1], p.moments[2] * y[2]],
            Variables::Momenta => [y[0], y[1], y[2]],
        }
    }

    /// Kinetic energy.
    #[inline(always)]
    pub fn kinetic<R: Real, const D: usize>(self, p: &Parameters<R>, y: &[R; D]) -> R {
        dot(&self.momentum(p, y), &self.rates(p, y)) * R::splat(0.5)
    }
}

/// The numbers of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Numbers {
    /// Order of a Taylor series, or of the polynomial inside a Runge-Kutta step.
    pub order: usize,
    /// Whether the rounding of a step of a series is added to the next.
    pub is_compensated: bool,
    /// Fractions of the step, flow after flow, round after round; the last round may contain only its first flow.
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
        Numbers {
            order: 0,
            is_compensated: false,
            fractions,
            gradients: &[],
            processor: None,
            drift_order: 0,
        }
    }
}

impl std::fmt::Debug for Step {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let makes = |method: &&&Method| method.steps().contains(self);
        let method = ALL.iter().find(makes).map_or("none", |method| method.facts.name);
        write!(f, "{:?} of {method}", self.engine)
    }
}

impl PartialEq for Step {
    #[inline]
    fn eq(&self, other: &Step) -> bool {
        let same = std::ptr::eq(self.numbers, other.numbers);
        self.engine == other.engine && (same || self.numbers == other.numbers)
    }
}

impl Step {
    /// A step of an engine without numbers, or with numbers that are literals in the code.
    const fn plain(engine: EngineName) -> Step {
        Step { engine, numbers: &Numbers::NONE }
    }

    /// Whether the step is a Taylor series, which has dense output and may be adaptive.
    pub const fn is_series(self) -> bool {
        self.engine.facts().is_series
    }

    /// Whether the rounding of a fixed step is carried to the next one.
    pub const fn is_compensated(self) -> bool {
        self.numbers.is_compensated
    }

    /// Whether the step moves a deviation vector by its derivative: one with force gradients or a processor has none.
    pub const fn has_tangent(self) -> bool {
        self.engine.facts().has_tangent && self.numbers.gradients.is_empty() && !self.is_processed()
    }

    /// Whether the step uses other variables than the state, so that nothing can be observed between steps.
    pub const fn is_processed(self) -> bool {
        self.numbers.processor.is_some()
    }

    /// The step of bodies on an orbit on which nothing else acts, over its eccentric anomaly, if the method has one.
    pub const fn on_orbit(self) -> Option<Step> {
        orbit_steps::on_orbit(self)
    }

    /// Whether the step is over the eccentric anomaly of an orbit, in place of the time.
    #[inline]
    pub const fn is_on_clock(self) -> bool {
        self.engine.facts().is_on_clock
    }

    /// Whether the step integrates bodies with weight: a composition without kicks is a free motion.
    pub const fn moves_weight(self) -> bool {
        let Some(flows) = self.engine.facts().flows else { return true };
        let mut i = 0;
        while i < self.numbers.fractions.len() {
            if matches!(flows[i % flows.len()], Flow::Kick) && self.numbers.fractions[i] != 0.0 {
                return true;
            }
            i += 1;
        }
        false
    }

    /// The step for a body without weight: kicks and drifts become one drift, exact or of the highest order.
    pub const fn torque_free(self) -> Step {
        match self.engine {
            EngineName::KickRotor => SPLITTING.symmetric,
            EngineName::KickMoserVeselov if self.moves_weight() => DMV10.any,
            _ => self,
        }
    }
}

/// Methods are equal if their names are equal.
impl PartialEq for Method {
    fn eq(&self, other: &Method) -> bool {
        self.facts.name == other.facts.name
    }
}
impl Eq for Method {}

impl std::fmt::Debug for Method {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.facts.name)
    }
}

impl Method {
    /// A method with one step for all bodies, stable under torque and damping up to a product of step and damping rate.
    const fn direct(facts: Facts, step: Step, damping_limit: f64) -> Method {
        Method { facts, any: step, symmetric: step, forced: Some(ForcedStep { step, damping_limit }) }
    }

    /// The steps of the method; a step may occur more than once.
    pub fn steps(&self) -> Vec<Step> {
        [self.any, self.symmetric].into_iter().chain(self.forced.map(|forced| forced.step)).collect()
    }

    /// The method of this name.
    ///
    /// # Errors
    /// If no method has this name; the message lists all names.
    pub fn parse(name: &str) -> Result<&'static Method, Error> {
        ALL.iter().copied().find(|method| method.facts.name == name).ok_or_else(|| Error::Unknown {
            argument: "method",
            value: name.to_string(),
            known: ALL.iter().map(|method| method.facts.name).collect::<Vec<_>>().join(", "),
        })
    }

    /// Whether the method is a series, whose steps are adaptive if a tolerance is given.
    pub const fn is_series(&self) -> bool {
        self.any.is_series()
    }

    /// Whether the steps are adaptive under these forces if a tolerance is given, and the motion inside them is known.
    pub fn is_known_inside(&self, forces: ForceSet) -> bool {
        let of_function = |forced: ForcedStep| forced.step.engine.facts().of_function.is_series;
        if forces.function { self.forced.is_some_and(of_function) } else { self.is_series() }
    }

    /// Whether the steps use other variables than the state, so that nothing can be observed between steps.
    pub const fn is_processed(&self) -> bool {
        self.any.is_processed()
    }

    /// Whether the method integrates deviation vectors: of all bodies, or of those without forces by exact flows.
    pub const fn has_tangent(&self) -> bool {
        let of_free = self.any.has_tangent() && self.symmetric.has_tangent();
        of_free && (self.has_forced_tangent() || self.any.engine.facts().flows.is_some())
    }

    /// Whether the method integrates deviation vectors of forced bodies, and those by a change of parameters.
    pub const fn has_forced_tangent(&self) -> bool {
        match self.forced {
            Some(forced) => self.any.has_tangent() && forced.step.has_tangent(),
            None => false,
        }
    }

    /// Whether the method integrates bodies with weight.
    pub const fn moves_tops(&self) -> bool {
        self.any.moves_weight()
    }

    /// See [`ForcedStep::damping_limit`]; `None` if the method does not integrate bodies under torque and damping.
    pub fn damping_limit(&self) -> Option<f64> {
        self.forced.map(|forced| forced.damping_limit)
    }

    /// The limit of [`Method::damping_limit`].
    ///
    /// # Errors
    /// If the method does not integrate bodies under torque and damping.
    pub fn forced_limit(&self) -> Result<f64, Error> {
        match self.damping_limit() {
            Some(limit) => Ok(limit),
            None => self.refuse("moves bodies without torque and damping only"),
        }
    }

    /// Refuses a step that is unstable at a damping rate. The body is named if it is one among many.
    ///
    /// # Errors
    /// If the method does not integrate bodies under torque and damping, or is unstable with this step.
    pub fn check_damping(&self, body: Option<usize>, step: f64, rate: f64) -> Result<(), Error> {
        let limit = self.forced_limit()?;
        if step * rate > limit {
            // Shorter by more than four digits are rounded, so that a step of these digits is stable.
            let (name, longest) = (self.facts.name, 0.9994 * limit / rate);
            return Err(Error::Unstable { body, step, rate, name, longest });
        }
        Ok(())
    }

    /// Whether the method is stable under damping of any strength.
    pub fn is_stiff(&self) -> bool {
        self.damping_limit() == Some(f64::INFINITY)
    }

    /// Whether the method integrates damping exactly, in steps much longer than the time of the damping.
    pub const fn damps_exactly(&self) -> bool {
        match self.forced {
            Some(forced) => matches!(forced.step.engine, EngineName::Exponential | EngineName::Affine),
            None => false,
        }
    }

    /// The forces that the method integrates, by name.
    pub fn forces(&self) -> Vec<&'static str> {
        let Some(forced) = self.forced else { return Vec::new() };
        let facts = forced.step.engine.facts();
        let further = Further::LIST.iter().map(|(name, ..)| *name).filter(|_| facts.moves_further);
        let function = facts.of_function.moves.then_some("function");
        ["torque", "damping"].into_iter().chain(further).chain(function).collect()
    }

    /// Raises an error for a method that does not integrate what acts on a body.
    ///
    /// # Errors
    /// Naming the method and the rule.
    pub fn check_forces(&self, forces: ForceSet) -> Result<(), Error> {
        if !forces.act {
            return Ok(());
        }
        let Some(forced) = self.forced else { return self.forced_limit().map(drop) };
        let facts = forced.step.engine.facts();
        let rule = if forces.further && !facts.moves_further {
            NO_FURTHER
        } else if forces.function && !facts.of_function.moves {
            "cannot integrate the torque of a function; use 'rk4', 'dop853' or 'midpoint'"
        } else if forces.states && !facts.moves_further {
            "does not integrate the states of a function, as 'rk4' and 'dop853' do"
        } else {
            return Ok(());
        };
        self.refuse(rule)
    }

    /// The method that cross-checks samples classified by this method. A method for strong damping is cross-checked by
    /// [`STIFF`], because an explicit method could need a thousand times the steps.
    pub fn second(&self, is_forced: bool) -> &'static Method {
        if is_forced && self.is_stiff() { STIFF } else { SECOND }
    }

    /// Raises an error for a method that integrates no deviation vectors, or not those of forced bodies.
    ///
    /// # Errors
    /// Naming the method and the rule.
    pub fn check_tangent(&self, is_forced: bool) -> Result<(), Error> {
        let rule = match (self.has_tangent(), self.has_forced_tangent()) {
            (_, true) => return Ok(()),
            (true, false) if !is_forced => return Ok(()),
            (true, false) => "has a tangent without torque and damping only, and none by parameters",
            _ => {
                "has no tangent: only Runge-Kutta methods, Taylor series and splittings into rotations return the \
                 derivative of their steps"
            }
        };
        self.refuse(rule)
    }

    /// Raises an error for a scene that the method does not integrate.
    ///
    /// # Errors
    /// Naming the method and the rule.
    pub fn check(&self, scene: &Scene) -> Result<(), Error> {
        if scene.has_weight && !self.moves_tops() {
            return self.refuse("integrates free bodies only, and a top has weight");
        }
        Ok(())
    }

    /// Raises an error for a method whose motions no map observes: in steps that use other variables than the state, and
    /// inside those of a series.
    ///
    /// # Errors
    /// Naming the method and the rule.
    pub fn check_observed(&self) -> Result<(), Error> {
        if self.is_processed() {
            return self.refuse(
                "a processed method has states only at requested times, but a map needs the state after every step",
            );
        }
        if self.is_series() {
            return self
                .refuse("a map looks inside its steps, but not inside those of a series; use 'dop853'");
        }
        Ok(())
    }

    /// Refuses the method by a rule.
    pub(crate) fn refuse<T>(&self, rule: &'static str) -> Result<T, Error> {
        refuse("method", format_args!("'{}'", self.facts.name), rule)
    }
}

/// No series has a higher order.
const _: () = assert!(
    MAX_ORDER == {
        let (mut highest, mut i) = (0, 0);
        while i < ALL.len() {
            let order = ALL[i].any.numbers.order;
            highest = if order > highest { order } else { highest };
            i += 1;
        }
        highest
    }
);

/// Every method is checked when it is compiled.
const _: () = {
    let mut i = 0;
    while i < ALL.len() {
        let Method { facts, any, symmetric, .. } = *ALL[i];
        assert!(any.is_series() == symmetric.is_series() && any.is_processed() == symmetric.is_processed());
        if any.is_series() {
            assert!(any.numbers.order == facts.order as usize && facts.order % 2 == 0);
        }
        if any.engine.facts().flows.is_some() && any.moves_weight() {
            assert!(any.numbers.fractions.len() == facts.stages);
            check_composition(any, facts);
            check_composition(symmetric, facts);
        }
        i += 1;
    }
};

/// A power of a number, for the checks and tables of constants.
const fn power(x: f64, n: usize) -> f64 {
    if n == 0 { 1.0 } else { x * power(x, n - 1) }
}

/// Euler's equations: the rate of change of the rates, from a state of rates.
#[inline(always)]
fn acceleration<R: Real, M: Model<R>, L: Layout, const D: usize>(
    model: &M,
    applied: &Applied<R>,
    y: &[R; D],
) -> [R; 3] {
    if L::FURTHER {
        return applied.under_further::<M, L, D>(model, &applied.torques(), y).omega;
    }
    if L::TURNS {
        return acceleration::<R, M, L::Rows, ROWS_LEN>(model, applied, &in_rows::<L, R, D>(y));
    }
    let torque = if L::BALANCE { applied.torque::<L, D>(y) } else { [R::splat(0.0); 3] };
    acceleration_by::<R, M, L, D>(model, applied, y, &torque)
}

/// Euler's equations with this applied torque, if the body is forced.
#[inline(always)]
fn acceleration_by<R: Real, M: Model<R>, L: Layout, const D: usize>(
    model: &M,
    applied: &Applied<R>,
    y: &[R; D],
    torque: &[R; 3],
) -> [R; 3] {
    let [w1, w2, w3] = [y[0], y[1], y[2]];
    let mut rate = model.euler(&[w2 * w3, w3 * w1, w1 * w2], y);
    if L::BALANCE {
        applied.add_over_moments(torque, &mut rate);
    }
    rate
}

/// The rates of change of directions and quaternion, twice those of the latter, by the angular velocity of the frame.
#[inline(always)]
fn put_turned<R: Real, L: Layout, const D: usize>(y: &[R; D], turning: &[R; 3], dy: &mut [R; D]) {
    for v in 0..L::VECTORS {
        put(dy, 3 + 3 * v, direction_rate(&direction(y, v), turning));
    }
    if L::QUATERNION {
        put(dy, L::QUATERNION_AT, doubled_attitude_rate(&quaternion::<L, R, D>(y), turning));
    }
}

/// The rates of change of a state by those of its first three numbers, and by the angular velocity of the frame.
#[inline(always)]
fn moved<R: Real, L: Layout, const D: usize>(y: &[R; D], velocity: [R; 3], turning: &[R; 3]) -> [R; D] {
    let mut change = [R::splat(0.0); D];
    put(&mut change, 0, velocity);
    put_turned::<R, L, D>(y, turning, &mut change);
    if L::QUATERNION {
        for k in 0..4 {
            change[L::QUATERNION_AT + k] = change[L::QUATERNION_AT + k] * R::splat(0.5);
        }
    }
    change
}

/// The cubic inside a step, in powers of the fraction of the step, from the states and their slopes at both ends.
#[inline(always)]
fn cubic_inside<R: Real, const N: usize, const D: usize>(
    step: R,
    [before, after]: [&[R; N]; 2],
    slopes: &[[R; N]; 2],
    dense: &mut Coefficients<R, D>,
) {
    let mut rows = [[R::splat(0.0); D]; 4];
    for d in 0..N {
        let (first, last) = (slopes[0][d] * step, slopes[1][d] * step);
        let change = after[d] - before[d];
        rows[0][d] = before[d];
        rows[1][d] = first;
        rows[2][d] = change * R::splat(3.0) - (first + first + last);
        rows[3][d] = (first + last) - (change + change);
    }
    dense.clear();
    for row in rows {
        dense.push(row);
    }
}

/// The angular velocity with which a state of rates turns the frame of the body: a sink adds to the rates.
#[inline(always)]
fn turning_of_rates<R: Real, M: Model<R>, L: Layout, const D: usize>(
    model: &M,
    applied: &Applied<R>,
    y: &[R; D],
) -> [R; 3] {
    let omega = [y[0], y[1], y[2]];
    if !L::FURTHER {
        return omega;
    }
    let turn = applied.under_further::<M, L, D>(model, &applied.torques(), y).turn;
    plus(&omega, &turn)
}

/// What limits an adaptive step.
pub struct Limits<R> {
    /// Size of the last terms of a series, or of the error of a Runge-Kutta step.
    pub tolerance: R,
    /// One over the scale of the rates.
    pub inverse_rate: R,
    /// The time to the next knot of the forces.
    pub room: R,
}

/// An adaptive step.
pub struct Proposal<R, const D: usize> {
    /// The change of the state over the share.
    pub change: [R; D],
    /// The length of the step, in units.
    pub share: R,
    /// The error over the tolerance; zero of a series, whose step is as long as the error allows.
    pub error: R,
}

/// The code of an engine for one pack of bodies. `R` is the pack; a state of the layout `L` has `D` numbers.
pub trait Engine<R: Real, M: Model<R>, L: Layout, const D: usize>: Copy {
    /// The variables that the engine integrates.
    const VARIABLES: Variables;
    /// Whether the engine integrates the model in the layout. Code is compiled only then.
    const MOVES: bool;
    /// Whether the engine can add the rounding error of a step to the next.
    const COMPENSATES: bool = false;
    /// Whether a step is a series, and stores its coefficients: the motion inside the step is known.
    const IS_SERIES: bool = false;
    /// Whether the length of an adaptive step is tried: a step with too large an error is made again, shorter.
    const IS_TRIED: bool = false;
    /// Whether a step moves a deviation vector by the derivative of the step.
    const HAS_TANGENT: bool = false;
    /// Whether a step can move further deviation vectors with the same motion.
    const SHARES_MOTION: bool = false;
    /// Whether the steps are over the eccentric anomaly of an orbit, in place of the time.
    const ON_CLOCK: bool = false;
    /// Whether a step has so few operations that the loop over packs counts. Its sums are not
    /// compensated.
    const IS_SHORT: bool = false;
    /// Whether steps are so long that what is observed is sought inside them too.
    const IS_LONG: bool = false;
    /// Whether the steps can use other variables than the state.
    const PROCESSED: bool = false;
    /// The flows of a round, if the engine composes exact flows of parts of the motion.
    const FLOWS: Option<&'static [Flow]> = None;
    /// Prepares the constants of the step.
    fn new(p: &Parameters<R>, forces: &ForcesInterval<'static, R>, numbers: &'static Numbers) -> Self;
    /// Transforms a state to the variables of the steps, before the first of equal steps; or back, after the last.
    #[inline(always)]
    fn process(&self, _p: &Parameters<R>, _y: &mut [R; D], _leaving: bool) {}
    /// Advances the state by one step.
    fn step(&self, p: &Parameters<R>, y: &mut [R; D]);
    /// The same. An engine with compensation keeps the rounding error of the state in `compensation`. A series stores its
    /// coefficients in `dense`, in powers of the fraction of the step.
    #[inline(always)]
    fn step_on(
        &self,
        p: &Parameters<R>,
        y: &mut [R; D],
        _compensation: &mut [R; D],
        _dense: &mut Coefficients<R, D>,
    ) {
        self.step(p, y);
    }
    /// The motion inside a step between two states, in powers of the fraction of the step: of a short step the cubic with
    /// the values and slopes at both ends.
    #[inline(always)]
    fn motion_inside(
        &self,
        p: &Parameters<R>,
        [before, after]: [&[R; D]; 2],
        dense: &mut Coefficients<R, D>,
    ) {
        let slopes = [self.rates_of_change(p, before), self.rates_of_change(p, after)];
        cubic_inside(p.step, [before, after], &slopes, dense);
    }
    /// Moves a further deviation vector by the last step, whose coefficients of the motion are known; those of the
    /// deviation vector are replaced.
    #[inline(always)]
    fn move_deviation(
        &self,
        _deviation: &mut [R; 6],
        _compensation: &mut [R; 6],
        _dense: &mut Coefficients<R, D>,
    ) {
        unreachable!("only some steps move further deviation vectors")
    }
    /// An adaptive step from `y` on. What is known of the motion inside is written to `inside`, because a move would cost a
    /// tenth of its computation: of a series the coefficients, in powers of the time over `unit`; of a step that is tried
    /// the slopes, that of `y` first.
    #[inline(always)]
    fn propose(
        &mut self,
        _unit: R,
        _limits: &Limits<R>,
        _y: &[R; D],
        _inside: &mut Coefficients<R, D>,
    ) -> Proposal<R, D> {
        unreachable!("only series choose their steps")
    }
    /// The coefficients of a step that was proposed and made, between two states; only in lanes in which `wanted` is above
    /// zero.
    #[inline(always)]
    fn expand(&mut self, _wanted: R, _ends: [&[R; D]; 2], _inside: &mut Coefficients<R, D>) {}
    /// The rates of change of a state, without those of its balance and of a deviation vector.
    #[inline(always)]
    fn rates_of_change(&self, p: &Parameters<R>, y: &[R; D]) -> [R; D] {
        moved::<R, L, D>(y, self.velocity(p, y), &self.turning(p, y))
    }
    /// The angular velocity with which a state turns the frame of the body.
    #[inline(always)]
    fn turning(&self, p: &Parameters<R>, y: &[R; D]) -> [R; 3] {
        Self::VARIABLES.rates(p, y)
    }
    /// Its rate of change.
    #[inline(always)]
    fn turning_rate(&self, p: &Parameters<R>, y: &[R; D]) -> [R; 3] {
        Self::VARIABLES.rates(p, &self.velocity(p, y))
    }
    /// Rate of change of the first three numbers of the state.
    fn velocity(&self, p: &Parameters<R>, y: &[R; D]) -> [R; 3];
}
