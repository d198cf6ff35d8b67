//! The list of kernels: systems and engines, and the code of each pair that a method can request.

use super::adaptive::{AdaptiveSteps, adaptive_block, dense_output};
use super::alone::{adaptive_alone, engine_alone};
use super::group::{ForcesRows, Group, MAX_STATE};
use super::step::{invariants, prepared, process, step_block};
use crate::forces::ForceSet;
use crate::method::*;
use crate::observe::Observed;
use crate::real::{Pack, Quad, Real};
use crate::scene::{
    Attitude, Axis, AxisAttitude, AxisSensitivity, AxisTangent, FREE, ForcedAxis, ForcedFrame,
    ForcedFrameTangent, ForcedRates, ForcedTurns, Free, FunctionFrame, FunctionTurns, FurtherFrame,
    FurtherFrameTangent, FurtherRates, FurtherTurns, Layout, Model, OrbitTurns, Parameters, Rates, Scene,
    StatesTurns, TOP, Top, Turns, TwoAxes,
};
#[cfg(target_arch = "x86_64")]
use crate::simd::{Arr, V4, V8};
use crate::simd::{Isa, LANES};
use std::marker::PhantomData;
use std::ops::Deref;

/// A kernel: system, step and observable.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kernel {
    /// Model and layout.
    pub system: System,
    /// The step of a method.
    pub step: Step,
    /// The observable.
    pub observed: Observed,
}

/// Advances all lanes by adaptive steps; see `adaptive_block`.
type Adaptive = unsafe fn(&mut Group, &ForcesRows, &mut AdaptiveSteps, usize, &'static Numbers);
/// A state of one lane inside its last step; see `dense_output`.
type Dense = unsafe fn(&AdaptiveSteps, usize, f64, &'static Numbers) -> [f64; MAX_STATE];

/// The code of a kernel for an instruction set. Code that no method can request is not compiled.
#[derive(Clone, Copy)]
pub(super) struct Code {
    /// Advances all lanes of a group by some steps.
    pub(super) advance: unsafe fn(&mut Group, &ForcesRows, usize, Observed, &'static Numbers),
    /// Transforms all lanes of a group to the variables of their steps, or back.
    pub(super) process: Option<unsafe fn(&mut Group, bool, &'static Numbers)>,
    /// Energy and conserved momentum of one body, with the arithmetic of the kernel.
    pub(super) invariants: unsafe fn(&Parameters<f64>, &[f64; MAX_STATE]) -> [f64; 2],
    /// Whether the further deviation vectors of a group are moved with its motions.
    pub(super) shares_motion: bool,
    pub(super) adaptive: Option<Adaptive>,
    /// The same for a group of one body.
    pub(super) alone: Option<Adaptive>,
    pub(super) dense: Option<Dense>,
}

/// The code of a kernel for each instruction set.
struct Codes {
    #[cfg(target_arch = "x86_64")]
    avx512: Option<Code>,
    #[cfg(target_arch = "x86_64")]
    avx2: Option<Code>,
    #[cfg(plain)]
    scalar: Option<Code>,
}

/// The functions of kernels for an instruction set. `S` makes the steps of packs, `T` the steps of a single body.
macro_rules! entry_points {
    ($isa:ident [$($feature:tt)*]) => {
        #[allow(clippy::extra_unused_type_parameters)] // A kernel is its types.
        pub mod $isa {
            use super::*;

            /// Bodies in packs.
            pub struct Packs<P, S, M, L, const D: usize, const PACKS: usize>(PhantomData<(P, S, M, L)>);

            impl<P, S, M, L, const D: usize, const PACKS: usize> Packs<P, S, M, L, D, PACKS>
            where
                P: Pack,
                S: Engine<P, M, L, D>,
                M: Model<P>,
                L: Layout,
            {
                $($feature)*
                fn advance(
                    g: &mut Group,
                    forces: &ForcesRows,
                    steps: usize,
                    observed: Observed,
                    numbers: &'static Numbers,
                ) {
                    step_block::<P, PACKS, M, L, S, D>(g, forces, steps, observed, numbers)
                }

                $($feature)*
                fn processed(g: &mut Group, leaving: bool, numbers: &'static Numbers) {
                    process::<P, PACKS, M, L, S, D>(g, leaving, numbers)
                }

                $($feature)*
                fn adaptive(
                    g: &mut Group,
                    forces: &ForcesRows,
                    l: &mut AdaptiveSteps,
                    most: usize,
                    numbers: &'static Numbers,
                ) {
                    let mut bodies = prepared::<P, PACKS, M, L, S, D>(g, forces, numbers);
                    adaptive_block::<P, PACKS, M, L, S, D>(g, l, &mut bodies, most)
                }

                pub const fn code<T, N>(alone: Option<Adaptive>) -> Option<Code>
                where
                    T: Engine<f64, N, L, D>,
                    N: Model<f64>,
                {
                    if !S::MOVES || S::ON_CLOCK != L::CLOCK || (L::TANGENT && !S::HAS_TANGENT) {
                        return None;
                    }
                    Some(Code {
                        advance: Self::advance,
                        process: if S::PROCESSED { Some(Self::processed) } else { None },
                        invariants: invariants_of::<T, N, L, D>,
                        shares_motion: S::SHARES_MOTION,
                        adaptive: if S::IS_SERIES { Some(Self::adaptive) } else { None },
                        alone: match S::IS_SERIES {
                            // One lane pays for one body.
                            true if L::FUNCTION => Some(Packs::<f64, T, N, L, D, 1>::adaptive),
                            true => alone,
                            false => None,
                        },
                        dense: if S::IS_SERIES { Some(dense::<D>) } else { None },
                    })
                }
            }

            $($feature)*
            fn dense<const D: usize>(
                l: &AdaptiveSteps,
                lane: usize,
                units: f64,
                numbers: &'static Numbers,
            ) -> [f64; MAX_STATE] {
                dense_output::<D>(l, numbers.order, lane, units)
            }

            $($feature)*
            fn invariants_of<T, N, L, const D: usize>(
                p: &Parameters<f64>,
                y: &[f64; MAX_STATE],
            ) -> [f64; 2]
            where
                T: Engine<f64, N, L, D>,
                N: Model<f64>,
                L: Layout,
            {
                let mut state = [0.0; D];
                for d in 0..D {
                    state[d] = y[d];
                }
                invariants::<f64, N, L, T, D>(p, &state)
            }

            $($feature)*
            #[allow(dead_code)] // Plain code has no such registers.
            fn alone<R: Quad, M: Model<R>, L: Layout, const D: usize>(
                g: &mut Group,
                forces: &ForcesRows,
                l: &mut AdaptiveSteps,
                most: usize,
                numbers: &'static Numbers,
            ) {
                let engine = engine_alone::<R, M, L, D>(g, forces, numbers);
                adaptive_alone::<R, M, L, D>(g, l, &engine, most)
            }

            /// Adaptive steps of a body whose directions stand side by side. With one direction nothing is gained.
            #[allow(dead_code)] // As above.
            pub const fn code_alone<R: Quad, M: Model<R>, L: Layout, const D: usize>() -> Option<Adaptive> {
                let has_more = L::TANGENT || L::FURTHER || L::FUNCTION;
                if L::VECTORS > 1 && !has_more { Some(alone::<R, M, L, D>) } else { None }
            }
        }
    };
}

/// Whether a layout is compiled for AVX-512 too: without forces and under a function. Changes of parameters are less often asked
/// for.
const fn unforced<L: Layout>() -> bool {
    !L::CHANGED && (!L::BALANCE || L::FUNCTION)
}

/// The same of an engine by which forced bodies gain too (benches/README.md).
const fn forced<L: Layout>() -> bool {
    unforced::<L>() || !L::CHANGED && !L::FURTHER
}

/// The kernels: each engine of the list of `method` with each system that the engine integrates. The first system with
/// the needed variables is taken, so a system with fewer variables stands before a system with more.
macro_rules! kernels {
    (systems { $($system:ident: $scene:ident, $model:ident, $layout:ident;)* } engines $engines:tt) => {
        /// A model, and the variables that are integrated with the rates.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[allow(missing_docs)] // The names are those of `scene`.
        pub enum System {
            $($system,)*
        }

        impl System {
            const ALL: &[System] = &[$(System::$system,)*];

            #[inline]
            const fn traits(self) -> &'static Traits {
                match self {
                    $(System::$system => const { &Traits::of::<$layout>(&$scene) },)*
                }
            }

            /// Whether the observable fits the system.
            pub const fn can_observe(self, observed: Observed) -> bool {
                match self {
                    $(System::$system => observed.fits::<$model<f64>, $layout, { <$layout as Layout>::LEN }>(),)*
                }
            }
        }

        /// A model has weight where its scene has.
        const _: () = {
            $(assert!($scene.has_weight == <$model<f64> as Model<f64>>::HEAVY);)*
        };

        kernels!(@modules $engines);

        fn codes(system: System, engine: EngineName) -> &'static Codes {
            match system {
                $(System::$system => kernels!(@codes engine, $model, $layout, $engines),)*
            }
        }
    };
    // The compiler works by modules. Each engine has its own module, so a change of one engine compiles only the
    // kernels of this engine.
    (@modules { $($(#[$doc:meta])* $engine:ident: $code:ty, $avx2:ty $(, $avx512:ty where $gains:ident)?;)* }) => {
        mod kernels_of {$(
            #[allow(non_snake_case)]
            pub mod $engine {
                use super::super::*;

                $(kernels!(@avx512 $avx512);)?
                #[cfg(target_arch = "x86_64")]
                entry_points!(avx2 [#[target_feature(enable = "avx2,fma")]]);
                #[cfg(plain)]
                entry_points!(scalar []);
            }
        )*}
    };
    (@avx512 $pack:ty) => {
        #[cfg(target_arch = "x86_64")]
        entry_points!(avx512 [#[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,avx2,fma")]]);
    };
    (@codes $which:ident, $model:ident, $layout:ident,
        { $($(#[$doc:meta])* $engine:ident: $code:ty, $avx2:ty $(, $avx512:ty where $gains:ident)?;)* }) => {
        match $which {
            $(EngineName::$engine => const {
                type R = f64;
                type M = $model<R>;
                type Alone = $code;
                type AloneModel = M;
                const D: usize = <$layout as Layout>::LEN;
                &Codes {
                    // The first, if there is one.
                    #[cfg(target_arch = "x86_64")]
                    avx512: [$({
                        type R = <$layout as Layout>::Lanes<$avx512>;
                        type M = $model<R>;
                        let alone = kernels_of::$engine::avx512::code_alone::<V4, $model<V4>, $layout, D>();
                        if $gains::<$layout>() {
                            kernels_of::$engine::avx512::Packs::<R, $code, M, $layout, D, { LANES / R::LANES }>::code::<Alone, AloneModel>(alone)
                        } else {
                            None
                        }
                    },)? None][0],
                    #[cfg(target_arch = "x86_64")]
                    avx2: {
                        type R = <$layout as Layout>::Lanes<$avx2>;
                        type M = $model<R>;
                        let alone = kernels_of::$engine::avx2::code_alone::<V4, $model<V4>, $layout, D>();
                        kernels_of::$engine::avx2::Packs::<R, $code, M, $layout, D, { LANES / R::LANES }>::code::<Alone, AloneModel>(alone)
                    },
                    #[cfg(plain)]
                    scalar: {
                        type R = <$layout as Layout>::Lanes<f64>;
                        type M = $model<R>;
                        kernels_of::$engine::scalar::Packs::<R, $code, M, $layout, D, { LANES / R::LANES }>::code::<Alone, AloneModel>(None)
                    },
                }
            },)*
        }
    };
}
engines! { kernels
    systems {
        FreeRates: FREE, Free, Rates;
        FreeAxis: FREE, Free, Axis;
        FreeAttitude: FREE, Free, Attitude;
        TopAxis: TOP, Top, Axis;
        TopAttitude: TOP, Top, AxisAttitude;
        TopTurns: TOP, Top, Turns;
        TopTwoAxes: TOP, Top, TwoAxes;
        ForcedRates: FREE, Free, ForcedRates;
        ForcedAxis: TOP, Top, ForcedAxis;
        ForcedFrame: TOP, Top, ForcedFrame;
        ForcedTurns: TOP, Top, ForcedTurns;
        OrbitTurns: FREE, Free, OrbitTurns;
        FurtherRates: FREE, Free, FurtherRates;
        FurtherFrame: TOP, Top, FurtherFrame;
        FurtherTurns: TOP, Top, FurtherTurns;
        FunctionFrame: TOP, Top, FunctionFrame;
        FunctionTurns: TOP, Top, FunctionTurns;
        StatesTurns: TOP, Top, StatesTurns;
        TopTangent: TOP, Top, AxisTangent;
        TopSensitivity: TOP, Top, AxisSensitivity;
        ForcedTangent: TOP, Top, ForcedFrameTangent;
        FurtherTangent: TOP, Top, FurtherFrameTangent;
    }
}

/// The code of a system and an engine for an instruction set; `None` if the engine does not integrate the system.
pub(super) fn code(system: System, engine: EngineName, isa: Isa) -> Option<&'static Code> {
    let codes = codes(system, engine);
    match isa {
        #[cfg(target_arch = "x86_64")]
        Isa::Avx512 => codes.avx512.as_ref().or(codes.avx2.as_ref()),
        #[cfg(target_arch = "x86_64")]
        Isa::Avx2 => codes.avx2.as_ref(),
        #[cfg(plain)]
        Isa::Scalar => codes.scalar.as_ref(),
    }
}

/// The variables that a system must integrate with the rates.
#[derive(Clone, Copy, Debug)]
pub struct Needs {
    /// What acts.
    pub forces: ForceSet,
    /// The least number of directions.
    pub directions: usize,
    /// Whether the attitude is needed, as a quaternion or as rows of its matrix.
    pub attitude: bool,
    /// Whether a deviation vector is integrated with the motion.
    pub tangent: bool,
    /// Whether a change of the parameters adds to the deviation vector.
    pub is_changed: bool,
}

/// What a system has, from its scene and its layout.
#[derive(Debug)]
pub struct Traits {
    /// The scene of the system. The system integrates the bodies of this scene and of its special cases.
    pub scene: &'static Scene,
    /// Length of the state.
    pub len: usize,
    /// Number of directions in the state.
    pub vectors: usize,
    has_frame: bool,
    /// Whether the equations read the space axes from the quaternion.
    pub turns: bool,
    /// Index of the quaternion in the state; `None` without a quaternion.
    pub quaternion_at: Option<usize>,
    /// Index of work, impulse and time; `None` if the system is not forced.
    pub balance_at: Option<usize>,
    is_further: bool,
    is_function: bool,
    /// Whether the eccentric anomaly of an orbit takes the place of the time.
    pub is_on_clock: bool,
    /// Index of the variables of further forces; `None` without any.
    pub own_at: Option<usize>,
    /// Index of the states of a function; `None` without any.
    pub states_at: Option<usize>,
    /// Index of the deviation vector; `None` without one.
    pub tangent_at: Option<usize>,
    is_changed: bool,
    /// Index of the direction from which a tilt is measured.
    pub observed_at: usize,
}

impl Traits {
    const fn of<L: Layout>(scene: &'static Scene) -> Traits {
        Traits {
            scene,
            len: L::LEN,
            vectors: L::VECTORS,
            has_frame: L::HAS_FRAME,
            turns: L::TURNS,
            quaternion_at: if L::QUATERNION { Some(L::QUATERNION_AT) } else { None },
            balance_at: if L::BALANCE { Some(L::BALANCE_AT) } else { None },
            is_further: L::FURTHER,
            is_function: L::FUNCTION,
            is_on_clock: L::CLOCK,
            own_at: if L::OWN > 0 { Some(L::OWN_AT) } else { None },
            states_at: if L::STATES { Some(L::STATES_AT) } else { None },
            tangent_at: if L::TANGENT { Some(L::TANGENT_AT) } else { None },
            is_changed: L::CHANGED,
            observed_at: 3 + 3 * L::OBSERVED,
        }
    }
}

impl Deref for System {
    type Target = Traits;

    #[inline]
    fn deref(&self) -> &Traits {
        self.traits()
    }
}

impl System {
    /// The first system of a scene, or of the scene that contains this one as a special case, that has the needed
    /// variables and that the step integrates. Panics if there is no such system; methods are checked when a request is
    /// made.
    pub fn carrying(scene: &Scene, step: Step, needs: Needs) -> System {
        let forces = needs.forces;
        let directions = if forces.in_space { 3 } else { needs.directions };
        let on_clock = step.is_on_clock();
        let acts = forces.act && !on_clock;
        let directions = if on_clock { 0 } else { directions };
        let carries = |system: System| {
            system.scene == scene
                && system.is_on_clock == on_clock
                && system.is_forced() == acts
                // Beside a function the further forces may act.
                && (system.is_further == (forces.further && acts) || system.is_further && forces.function)
                && system.is_function == forces.function
                && system.states_at.is_some() == forces.states
                && system.tangent_at.is_some() == needs.tangent
                && (system.is_changed || !needs.is_changed)
                && (system.has_frame || system.vectors >= directions)
                && (!needs.attitude || system.quaternion_at.is_some() || system.has_rows())
                && system.is_moved_by(step)
        };
        match (System::ALL.iter().copied().find(|&system| carries(system)), scene.special_case_of) {
            (Some(system), _) => system,
            (None, Some(general)) => System::carrying(general, step, needs),
            (None, None) => panic!("{step:?} integrates no system with {needs:?}"),
        }
    }

    /// Whether the system is forced.
    #[inline]
    pub fn is_forced(self) -> bool {
        self.balance_at.is_some()
    }

    /// Whether the attitude is integrated as rows of its matrix: the third row, which is the vertical, then the first.
    #[inline]
    pub fn has_rows(self) -> bool {
        self.vectors > 1
    }

    /// Whether the step integrates the system. A system without weight is integrated by the torque-free part of a step.
    pub fn is_moved_by(self, step: Step) -> bool {
        let Some(code) = code(self, step.engine, Isa::NARROWEST) else { return false };
        let suits = if self.scene.has_weight { step.moves_weight() } else { step == step.torque_free() };
        let is_known = self.tangent_at.is_none() || step.has_tangent();
        suits && is_known && (code.process.is_some() || !step.is_processed())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::method;

    #[test]
    fn a_system_carries_what_is_needed_and_no_more() {
        use System::*;
        let needs = |directions, attitude| Needs {
            forces: ForceSet::NONE,
            directions,
            attitude,
            tangent: false,
            is_changed: false,
        };
        let act = ForceSet { act: true, ..ForceSet::NONE };
        let forced = |needs| Needs { forces: act, ..needs };
        let in_space = |needs| Needs { forces: ForceSet { in_space: true, ..act }, ..needs };
        let further = |needs| Needs { forces: ForceSet { further: true, ..act }, ..needs };
        let function = |needs| Needs { forces: ForceSet { function: true, ..act }, ..needs };
        let states = |needs| Needs { forces: ForceSet { function: true, states: true, ..act }, ..needs };
        let orbit = ForceSet { further: true, in_space: true, orbit_alone: true, ..act };
        let on_orbit = |needs| Needs { forces: orbit, ..needs };
        let tangent = |needs| Needs { tangent: true, ..needs };
        let changed = |needs| Needs { tangent: true, is_changed: true, ..needs };
        // A series does not integrate a top with a quaternion.
        let (rotations, series) = (method::SPLITTING4.any, method::TAYLOR12.any);
        let on_clock = method::DOP853.any.on_orbit().unwrap();
        for (scene, step, needs, system) in [
            (&FREE, series, needs(0, false), FreeRates),
            (&FREE, series, needs(1, false), FreeAxis),
            (&FREE, series, needs(0, true), FreeAttitude),
            (&TOP, series, needs(0, false), TopAxis),
            (&TOP, series, needs(1, false), TopAxis),
            (&TOP, series, needs(2, false), TopTwoAxes),
            (&TOP, series, needs(0, true), TopTwoAxes),
            (&TOP, rotations, needs(0, true), TopAttitude),
            (&FREE, series, forced(needs(0, false)), ForcedRates),
            (&FREE, series, forced(needs(1, false)), ForcedAxis),
            (&FREE, series, in_space(needs(0, false)), ForcedFrame),
            (&FREE, series, forced(needs(0, true)), ForcedFrame),
            (&TOP, method::DOP853.any, needs(0, true), TopTurns),
            (&TOP, method::DOP853.any, forced(needs(0, true)), ForcedTurns),
            (&TOP, series, forced(needs(0, false)), ForcedAxis),
            (&FREE, series, further(needs(0, false)), FurtherRates),
            (&FREE, series, further(needs(0, true)), FurtherFrame),
            (&FREE, series, on_orbit(needs(0, false)), FurtherFrame),
            (&FREE, on_clock, on_orbit(needs(1, true)), OrbitTurns),
            (&FREE, method::DOP853.any, on_orbit(needs(0, false)), FurtherTurns),
            (&FREE, series, on_orbit(tangent(needs(0, false))), FurtherTangent),
            (&FREE, method::RK4.any, function(needs(0, false)), FunctionTurns),
            (&TOP, method::MIDPOINT.any, function(needs(0, true)), FunctionFrame),
            (&FREE, method::DOP853.any, states(needs(0, true)), StatesTurns),
            // A free body is a top without weight.
            (&FREE, series, tangent(needs(0, false)), TopTangent),
            (&TOP, series, tangent(needs(0, false)), TopTangent),
            (&FREE, series, forced(tangent(needs(0, false))), ForcedTangent),
            (&FREE, series, changed(needs(0, false)), TopSensitivity),
            (&FREE, series, forced(changed(needs(0, false))), ForcedTangent),
        ] {
            assert_eq!(System::carrying(scene, step, needs), system, "{} {needs:?}", scene.kind);
        }
    }
}
