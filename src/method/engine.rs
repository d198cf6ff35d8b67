//! The list of engines. What an engine can do follows from its code.

use super::*;
use crate::scene::{AxisTangent, FunctionFrame, FunctionTurns, FurtherRates, Top};

/// Gives the list of engines to a macro. `R` stands for the pack and `M` for the model in this pack. After the code
/// stand the packs for AVX2, and for AVX-512 where some layouts gain, with the function that tells which. Engines with long chains of rotations are fastest with two
/// packs side by side inside the step (`Arr`), other engines with one (benches/README.md).
macro_rules! engines {
    ($then:ident $($before:tt)*) => {
        $then! { $($before)* engines {
            /// Runge-Kutta with the tableau of `rk4`: its numbers are literals in the code.
            Rk4: RungeKutta<Rk4Tableau, R, M>, V4, V8 where forced;
            /// Runge-Kutta with the tableau of `dop853`.
            Dop853: RungeKutta<Dop853Tableau, R, M>, V4, V8 where forced;
            /// Over the anomaly of an orbit, with the tableau of `rk4`.
            OrbitRk4: OrbitSteps<Rk4Tableau, R>, V4, V8 where unforced;
            /// Over the anomaly of an orbit, with the tableau of `dop853`.
            OrbitDop853: OrbitSteps<Dop853Tableau, R>, V4, V8 where unforced;
            /// A Taylor series of any order.
            Taylor: Taylor<R, M>, V4, V8 where unforced;
            /// Planar rotations about the principal axes and kicks, of order 2.
            Planar: Splitting<Planar, R>, Arr<V4, 2>, Arr<V8, 2> where unforced;
            /// The planar rotations and kicks with any numbers.
            ComposedPlanar: Splitting<ComposedPlanar, R>, Arr<V4, 2>;
            /// The exact rotor of a body that is symmetric about its axis 3, and kicks.
            KickRotor: Splitting<KickRotor, R>, V4, V8 where unforced;
            /// Discrete Moser-Veselov drifts of any body, and kicks.
            KickMoserVeselov: Splitting<KickMoserVeselov, R>, Arr<V4, 2>;
            /// Planar rotations, and one kick by torque and damping together.
            Affine: AffineSplitting<R>, V4;
            /// Exponential Runge-Kutta.
            Exponential: Exponential<R, M>, V4;
            /// The implicit midpoint rule.
            Midpoint: ImplicitMidpoint<R>, V4;
        } }
    };
}
pub(crate) use engines;

macro_rules! with_facts {
    (engines { $($(#[$doc:meta])* $engine:ident: $code:ty, $avx2:ty $(, $avx512:ty where $gains:ident)?;)* }) => {
        /// The code that makes a step. Methods that differ only in their numbers share an engine.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum EngineName {
            $($(#[$doc])* $engine,)*
        }

        impl EngineName {
            /// What the engine can do.
            pub(super) const fn facts(self) -> &'static EngineFacts {
                type R = f64;
                type M = Top<R>;
                match self {
                    $(EngineName::$engine => const { &EngineFacts::of::<$code>() },)*
                }
            }
        }
    };
}
engines!(with_facts);

impl EngineName {
    /// The variables that the engine integrates.
    pub const fn variables(self) -> Variables {
        self.facts().variables
    }
}

/// What an engine can do, by the constants of its code; see [`Engine`].
pub(super) struct EngineFacts {
    pub(super) variables: Variables,
    pub(super) is_series: bool,
    pub(super) has_tangent: bool,
    pub(super) is_on_clock: bool,
    pub(super) flows: Option<&'static [Flow]>,
    /// Whether it integrates the further forces.
    pub(super) moves_further: bool,
    /// What it can do under the torque of a function.
    pub(super) of_function: FactsOfFunction,
}

/// What an engine can do under the torque of a function.
pub(super) struct FactsOfFunction {
    pub(super) moves: bool,
    pub(super) is_series: bool,
}

impl EngineFacts {
    const fn of<S>() -> EngineFacts
    where
        S: Engine<f64, Top<f64>, AxisTangent, { AxisTangent::LEN }>
            + Engine<f64, Top<f64>, FurtherRates, { FurtherRates::LEN }>
            + Engine<f64, Top<f64>, FunctionFrame, { FunctionFrame::LEN }>
            + Engine<f64, Top<f64>, FunctionTurns, { FunctionTurns::LEN }>,
    {
        EngineFacts {
            variables: <S as Engine<f64, Top<f64>, AxisTangent, { AxisTangent::LEN }>>::VARIABLES,
            is_series: <S as Engine<f64, Top<f64>, AxisTangent, { AxisTangent::LEN }>>::IS_SERIES,
            has_tangent: <S as Engine<f64, Top<f64>, AxisTangent, { AxisTangent::LEN }>>::HAS_TANGENT,
            is_on_clock: <S as Engine<f64, Top<f64>, AxisTangent, { AxisTangent::LEN }>>::ON_CLOCK,
            flows: <S as Engine<f64, Top<f64>, AxisTangent, { AxisTangent::LEN }>>::FLOWS,
            moves_further: <S as Engine<f64, Top<f64>, FurtherRates, { FurtherRates::LEN }>>::MOVES,
            of_function: FactsOfFunction {
                moves: <S as Engine<f64, Top<f64>, FunctionFrame, { FunctionFrame::LEN }>>::MOVES
                    || <S as Engine<f64, Top<f64>, FunctionTurns, { FunctionTurns::LEN }>>::MOVES,
                is_series: <S as Engine<f64, Top<f64>, FunctionFrame, { FunctionFrame::LEN }>>::IS_SERIES,
            },
        }
    }
}
