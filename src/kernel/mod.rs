//! The one place where generic schemes meet instruction sets.
//!
//! A burst advances all bodies of a `Group` by some steps; the code that fills and empties lanes around it is
//! ordinary scalar code. No lane looks at another.

mod kinds;

pub use kinds::{Kernel, System, Table, Watch};

use crate::group::{DriftRows, Drives, Group, LANES, MAX_STATE, Row};
use crate::leaps::{Leaps, inside, leap};
use crate::method::{
    Affine, AffineSplitting, Coefficients, Dmv10, Dop853, Etd4, Exponential, ImplicitMidpoint, Midpoint,
    Numbers, Planar, Planar8, Rk4, Rotor, RungeKutta, Scheme, Splitting, Taylor, Taylor8, Taylor12, Taylor16,
    Taylor20, Taylor26,
};
use crate::model::{
    Attitude, Axis, AxisAttitude, Driven, DrivenFrame, DrivenRates, Free, Layout, Model, Parameters, Rates,
    SpinFree, Top, TwoAxes, direction, dot,
};
use crate::observe::{Flips, Tilt, Watched};
use crate::real::{Pack, Real};
use crate::simd::Isa;
#[cfg(target_arch = "x86_64")]
use crate::simd::{Arr, V4, V8};
use kinds::NO_NUMBERS;

#[inline(always)]
fn load3<P: Pack>(rows: &[Row; 3], at: usize) -> [P; 3] {
    [P::load(&rows[0].0[at..]), P::load(&rows[1].0[at..]), P::load(&rows[2].0[at..])]
}

#[inline(always)]
fn load_watched<P: Pack>(g: &Group, at: usize) -> Watched<P> {
    Watched {
        axis: load3(&g.axis, at),
        side: P::load(&g.side.0[at..]),
        flips: P::load(&g.flips.0[at..]),
        left: P::load(&g.left.0[at..]),
        cosine: P::load(&g.cosine.0[at..]),
        sine2: P::load(&g.sine2.0[at..]),
        limit: [P::load(&g.limit[0].0[at..]), P::load(&g.limit[1].0[at..])],
    }
}

#[inline(always)]
fn store_watched<P: Pack>(g: &mut Group, at: usize, w: &Watched<P>) {
    w.side.store(&mut g.side.0[at..]);
    w.flips.store(&mut g.flips.0[at..]);
    w.left.store(&mut g.left.0[at..]);
    w.cosine.store(&mut g.cosine.0[at..]);
    w.sine2.store(&mut g.sine2.0[at..]);
}

/// Deviation of an invariant at the end of a burst. A NaN stays: the second argument of `max` wins.
#[inline(always)]
fn update_drift<P: Pack>(rows: &mut DriftRows, at: usize, now: P) {
    let off = (now - P::load(&rows.start.0[at..])).abs() * P::load(&rows.inverse_scale.0[at..]);
    P::load(&rows.worst.0[at..]).max(off).store(&mut rows.worst.0[at..]);
}

/// The constants of the bodies and of their schemes, pack by pack.
#[inline(always)]
fn prepared<P, const PACKS: usize, M, L, S, const D: usize>(
    g: &Group,
    drives: &Drives,
    numbers: &'static Numbers,
) -> [(Parameters<P>, S); PACKS]
where
    P: Pack,
    M: Model<P>,
    L: Layout,
    S: Scheme<P, M, L, D>,
{
    const { assert!(D == L::LEN && PACKS * P::LANES == LANES) };
    let mut p = Parameters {
        moments: load3::<P>(&g.moments, 0),
        weight: load3::<P>(&g.weight, 0),
        step: P::load(&g.step.0),
    };
    let mut bodies = [(p, scheme::<P, M, L, S, D>(&p, drives, 0, numbers)); PACKS];
    for b in 1..PACKS {
        let at = b * P::LANES;
        p = Parameters {
            moments: load3(&g.moments, at),
            weight: load3(&g.weight, at),
            step: P::load(&g.step.0[at..]),
        };
        bodies[b] = (p, scheme::<P, M, L, S, D>(&p, drives, at, numbers));
    }
    bodies
}

/// The constants of a scheme for the bodies of a pack.
#[inline(always)]
fn scheme<P: Pack, M: Model<P>, L: Layout, S: Scheme<P, M, L, D>, const D: usize>(
    p: &Parameters<P>,
    drives: &Drives,
    at: usize,
    numbers: &'static Numbers,
) -> S {
    if M::DRIVEN { S::driven(p, &drives.load(at), numbers) } else { S::with(p, numbers) }
}

/// Advances all lanes by `steps`, the packs side by side, and compares the invariants at the end.
#[inline(always)]
fn burst<P, const PACKS: usize, M, L, S, const D: usize>(
    g: &mut Group,
    drives: &Drives,
    steps: usize,
    watch: Watch,
    numbers: &'static Numbers,
) where
    P: Pack,
    M: Model<P>,
    L: Layout,
    S: Scheme<P, M, L, D>,
{
    let bodies = prepared::<P, PACKS, M, L, S, D>(g, drives, numbers);
    for i in 0..steps {
        for b in 0..PACKS {
            let at = b * P::LANES;
            let mut y = [P::splat(0.0); D];
            for d in 0..D {
                y[d] = P::load(&g.state[d].0[at..]);
            }
            let before = y;
            let (p, scheme) = &bodies[b];
            let mut carry = y;
            let mut course = Coefficients::new();
            if S::CARRIES {
                for d in 0..D {
                    carry[d] = P::load(&g.carry[d].0[at..]);
                }
            }
            scheme.step_leaving(p, &mut y, &mut carry, &mut course);
            if S::CARRIES {
                for d in 0..D {
                    carry[d].store(&mut g.carry[d].0[at..]);
                }
            }
            for d in 0..D {
                y[d].store(&mut g.state[d].0[at..]);
            }
            if watch != Watch::Nothing {
                let mut watched = load_watched::<P>(g, at);
                let time = (P::load(&g.count.0[at..]) + P::splat(i as f64)) * p.step;
                if watch == Watch::Flips {
                    Flips::after_step::<P, M, L, S, D>(scheme, p, &mut watched, time, [&before, &y], &course);
                } else if const { L::VECTORS > 0 } {
                    Tilt::after_step::<P, M, L, S, D>(p, &mut watched, time, [&before, &y], &course);
                }
                store_watched(g, at, &watched);
            }
        }
    }
    for b in 0..PACKS {
        let at = b * P::LANES;
        let mut y = [P::splat(0.0); D];
        for d in 0..D {
            y[d] = P::load(&g.state[d].0[at..]);
        }
        let [energy, momentum] = invariants::<P, M, L, S, D>(&bodies[b].0, &y);
        update_drift(&mut g.energy, at, energy);
        update_drift(&mut g.momentum, at, momentum);
        for v in 0..L::VECTORS {
            let n = direction(&y, v);
            // |n| - 1, to first order.
            let off = (dot(&n, &n) - P::splat(1.0)).abs() * P::splat(0.5);
            P::load(&g.unit.0[at..]).max(off).store(&mut g.unit.0[at..]);
        }
        (P::load(&g.count.0[at..]) + P::splat(steps as f64)).store(&mut g.count.0[at..]);
    }
}

/// Takes the lanes with a step into the variables of their steps, or back; the others keep every bit.
#[inline(always)]
fn process<P, const PACKS: usize, M, L, S, const D: usize>(
    g: &mut Group,
    leaving: bool,
    numbers: &'static Numbers,
) where
    P: Pack,
    M: Model<P>,
    L: Layout,
    S: Scheme<P, M, L, D>,
{
    for b in 0..PACKS {
        let at = b * P::LANES;
        let p = Parameters {
            moments: load3::<P>(&g.moments, at),
            weight: load3(&g.weight, at),
            step: P::load(&g.step.0[at..]),
        };
        let mut y = [P::splat(0.0); D];
        for d in 0..D {
            y[d] = P::load(&g.state[d].0[at..]);
        }
        let before = y;
        S::with(&p, numbers).process(&p, &mut y, leaving);
        let steps = P::splat(0.0).lt(p.step.abs());
        for d in 0..D {
            P::select(steps, y[d], before[d]).store(&mut g.state[d].0[at..]);
        }
    }
}

/// Energy and conserved momentum of a state.
#[inline(always)]
fn invariants<R: Real, M: Model<R>, L: Layout, S: Scheme<R, M, L, D>, const D: usize>(
    p: &Parameters<R>,
    y: &[R; D],
) -> [R; 2] {
    [S::kinetic(p, y) + M::potential(p, y), M::conserved(&S::momentum(p, y), y)]
}

/// The engine of a table, and the packs it runs best with: a long chain of rotations wants two packs in
/// flight inside the scheme, the others leave it to the interleaving of packs (benches/README.md).
trait Engine {
    type Scheme<R: Real, M: Model<R>>;
    #[cfg(target_arch = "x86_64")]
    type Avx512: Pack;
    #[cfg(target_arch = "x86_64")]
    type Avx2: Pack;
}
macro_rules! engines {
    ($($table:ty: $scheme:ident <$($argument:ident),*>, $avx512:ty, $avx2:ty;)*) => {$(
        impl Engine for $table {
            type Scheme<R: Real, M: Model<R>> = $scheme<$table, $($argument),*>;
            #[cfg(target_arch = "x86_64")]
            type Avx512 = $avx512;
            #[cfg(target_arch = "x86_64")]
            type Avx2 = $avx2;
        }
    )*};
}
engines! {
    Rk4: RungeKutta<R, M>, V8, V4;
    Dop853: RungeKutta<R, M>, V8, V4;
    Planar: Splitting<R>, Arr<V8, 2>, Arr<V4, 2>;
    Planar8: Splitting<R>, Arr<V8, 2>, Arr<V4, 2>;
    Rotor: Splitting<R>, V8, V4;
    Taylor8: Taylor<R, M>, V8, V4;
    Taylor12: Taylor<R, M>, V8, V4;
    Taylor16: Taylor<R, M>, V8, V4;
    Taylor20: Taylor<R, M>, V8, V4;
    Taylor26: Taylor<R, M>, V8, V4;
    Dmv10: Splitting<R>, Arr<V8, 2>, Arr<V4, 2>;
    Affine: AffineSplitting<R, M>, V8, V4;
    Etd4: Exponential<R, M>, V8, V4;
    Midpoint: ImplicitMidpoint<R, M>, V8, V4;
}

/// Advances all lanes of a group by some steps.
type Advance = unsafe fn(&mut Group, &Drives, usize, Watch, &'static Numbers);
/// Takes all lanes of a group into the variables of their steps, or back.
type Process = unsafe fn(&mut Group, bool, &'static Numbers);
/// Energy and conserved momentum of one body, with the arithmetic of the kernel.
type Invariants = unsafe fn(&Parameters<f64>, &[f64; MAX_STATE]) -> [f64; 2];

/// Advances all lanes by steps of their own; see `leaps::leap`.
type Leap = unsafe fn(&mut Group, &Drives, &mut Leaps, usize) -> usize;
/// A state of one lane inside its last step; see `leaps::inside`.
type Inside = unsafe fn(&Leaps, usize, f64) -> [f64; MAX_STATE];

/// The code of a kernel for an instruction set.
#[derive(Clone, Copy)]
struct Code {
    advance: Advance,
    process: Process,
    invariants: Invariants,
    leap: Leap,
    inside: Inside,
}

/// A kernel compiled for an instruction set that this CPU has.
#[derive(Clone, Copy)]
pub struct Compiled {
    code: Code,
    watch: Watch,
    numbers: &'static Numbers,
}

impl Compiled {
    /// The kernel for that instruction set; panics if the CPU lacks it, or if the system cannot be watched so.
    pub fn new(kernel: Kernel, isa: Isa) -> Compiled {
        assert!(isa.is_available(), "{} is not available on this CPU", isa.name());
        let Kernel { system, watch, .. } = kernel;
        assert!(system.shows(watch), "{watch:?} is not watched on {system:?}");
        assert!(kernel.table.moves(system), "{:?} does not move {system:?}", kernel.table);
        Compiled { code: code(kernel, isa), watch, numbers: kernel.table.numbers() }
    }

    /// Advances every lane of the group.
    pub fn advance(self, group: &mut Group, steps: usize) {
        self.advance_driven(group, &Drives::NONE, steps);
    }

    /// The same under what acts from outside; only driven systems feel it.
    pub fn advance_driven(self, group: &mut Group, drives: &Drives, steps: usize) {
        // Safety: `new` has seen the features that the entry point needs.
        unsafe { (self.code.advance)(group, drives, steps, self.watch, self.numbers) }
    }

    /// Whether the steps are made in other variables than the state.
    pub fn is_processed(self) -> bool {
        self.numbers.processor.is_some()
    }

    /// Takes every lane with a step into the variables of its steps: before the first of a run of equal steps.
    pub fn enter(self, group: &mut Group) {
        self.process(group, false);
    }

    /// Takes every lane with a step back: after the last.
    pub fn leave(self, group: &mut Group) {
        self.process(group, true);
    }

    fn process(self, group: &mut Group, leaving: bool) {
        // Safety: as above.
        unsafe { (self.code.process)(group, leaving, self.numbers) }
    }

    /// Advances every lane by steps of its own until one has to be looked at; only of series.
    pub fn leap(self, group: &mut Group, drives: &Drives, leaps: &mut Leaps, most: usize) -> usize {
        // Safety: as above.
        unsafe { (self.code.leap)(group, drives, leaps, most) }
    }

    /// The state of a lane inside its last step, that many of its units after its begin.
    pub fn inside(self, leaps: &Leaps, lane: usize, units: f64) -> [f64; MAX_STATE] {
        // Safety: as above.
        unsafe { (self.code.inside)(leaps, lane, units) }
    }

    /// Energy and conserved momentum of one body.
    pub fn invariants(self, p: &Parameters<f64>, y: &[f64; MAX_STATE]) -> [f64; 2] {
        // Safety: as above.
        unsafe { (self.code.invariants)(p, y) }
    }
}

/// The functions of a model, layout and table for an instruction set.
macro_rules! code_of {
    ($isa:expr, $model:ident, $layout:ident, $d:literal, $table:ident) => {{
        #[cfg(target_arch = "x86_64")]
        code_of!(@functions avx512, [#[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,avx2,fma")]],
            <$table as Engine>::Avx512, $model, $layout, $d, $table);
        #[cfg(target_arch = "x86_64")]
        code_of!(@functions avx2, [#[target_feature(enable = "avx2,fma")]],
            <$table as Engine>::Avx2, $model, $layout, $d, $table);
        code_of!(@functions scalar, [], f64, $model, $layout, $d, $table);
        match $isa {
            #[cfg(target_arch = "x86_64")]
            Isa::Avx512 => avx512::CODE,
            #[cfg(target_arch = "x86_64")]
            Isa::Avx2 => avx2::CODE,
            _ => scalar::CODE,
        }
    }};
    (@functions $name:ident, [$($feature:tt)*], $pack:ty, $model:ident, $layout:ident, $d:literal, $table:ident) => {
        mod $name {
            use super::*;
            type P = $pack;
            type Scheme<R> = <$table as Engine>::Scheme<R, $model<R>>;
            pub const CODE: Code = Code {
                advance,
                process: process_of,
                invariants: invariants_of,
                leap: leap_of,
                inside: inside_of,
            };
            $($feature)*
            fn process_of(g: &mut Group, leaving: bool, numbers: &'static Numbers) {
                // Nothing of two directions is processed: they are watched.
                if const { $d != 9 } {
                    process::<P, { LANES / P::LANES }, $model<P>, $layout, Scheme<P>, $d>(g, leaving, numbers)
                }
            }
            $($feature)*
            fn leap_of(g: &mut Group, drives: &Drives, l: &mut Leaps, most: usize) -> usize {
                const PACKS: usize = LANES / P::LANES;
                let bodies = prepared::<P, PACKS, $model<P>, $layout, Scheme<P>, $d>(g, drives, &NO_NUMBERS);
                leap::<P, PACKS, $model<P>, $layout, Scheme<P>, $d>(g, l, &bodies, most)
            }
            $($feature)*
            fn inside_of(l: &Leaps, lane: usize, units: f64) -> [f64; MAX_STATE] {
                type S = Scheme<f64>;
                let order = <S as crate::method::Scheme<f64, $model<f64>, $layout, $d>>::ORDER;
                inside::<$d>(l, order, lane, units)
            }
            $($feature)*
            fn advance(
                g: &mut Group,
                drives: &Drives,
                steps: usize,
                watch: Watch,
                numbers: &'static Numbers,
            ) {
                const PACKS: usize = LANES / P::LANES;
                burst::<P, PACKS, $model<P>, $layout, Scheme<P>, $d>(g, drives, steps, watch, numbers)
            }
            $($feature)*
            fn invariants_of(p: &Parameters<f64>, y: &[f64; MAX_STATE]) -> [f64; 2] {
                let mut state = [0.0; $d];
                state.copy_from_slice(&y[..$d]);
                invariants::<f64, $model<f64>, $layout, Scheme<f64>, $d>(p, &state)
            }
        }
    };
}

/// The match from a table to its code, over the engines that move the system.
macro_rules! among {
    ($kernel:ident, $isa:ident: $model:ident, $layout:ident, $d:literal; smooth $($more:ident)*) => {
        among!($kernel, $isa: $model, $layout, $d;
            Dop853 Taylor8 Taylor12 Taylor16 Taylor20 Taylor26 $($more)*)
    };
    ($kernel:ident, $isa:ident: $model:ident, $layout:ident, $d:literal; $($table:ident)*) => {
        match $kernel.table.engine() {
            $(Table::$table => code_of!($isa, $model, $layout, $d, $table),)*
            #[allow(unreachable_patterns)] // Most systems are moved by all tables.
            table => unreachable!("{table:?} does not move {:?}", $kernel.system),
        }
    };
}

fn code(kernel: Kernel, isa: Isa) -> Code {
    match kernel.system {
        System::FreeRates => {
            among!(kernel, isa: Free, Rates, 3; smooth Rk4 Planar Planar8 Rotor Dmv10 Midpoint)
        }
        System::FreeAxis => {
            among!(kernel, isa: Free, Axis, 6; smooth Rk4 Planar Planar8 Rotor Dmv10 Midpoint)
        }
        System::FreeAttitude => {
            among!(kernel, isa: Free, Attitude, 7; smooth Rk4 Planar Planar8 Rotor Dmv10 Midpoint)
        }
        System::TopAxis => among!(kernel, isa: Top, Axis, 6; smooth Rk4 Planar Planar8 Rotor Dmv10 Midpoint),
        System::TopTwoAxes => {
            among!(kernel, isa: Top, TwoAxes, 9; smooth Rk4 Planar Planar8 Rotor Dmv10 Midpoint)
        }
        System::TopAttitude => among!(kernel, isa: Top, AxisAttitude, 10; Rk4 Planar Planar8 Rotor Dmv10),
        System::SpinFreeAxis => among!(kernel, isa: SpinFree, Axis, 6; smooth Rotor),
        System::SpinFreeTwoAxes => among!(kernel, isa: SpinFree, TwoAxes, 9; smooth),
        System::SpinFreeAttitude => among!(kernel, isa: SpinFree, AxisAttitude, 10; Rotor),
        System::DrivenRates => among!(kernel, isa: Driven, DrivenRates, 6; smooth Rk4 Affine Etd4 Midpoint),
        System::DrivenFrame => among!(kernel, isa: Driven, DrivenFrame, 15; smooth Rk4 Affine Etd4 Midpoint),
    }
}
