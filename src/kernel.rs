//! Bodies side by side, and the one place where generic kernels meet instruction sets.
//!
//! A `Group` holds `LANES` bodies, component by component. A burst advances all of them by some steps; the
//! code that fills and empties lanes around it is ordinary scalar code. No lane looks at another.

use crate::method::{Form, PlanarStrang, Rk4, RotorStrang, RungeKutta, Scheme, Splitting};
use crate::model::{
    Attitude, Axis, AxisAttitude, Free, Layout, Model, Parameters, Rates, Top, TwoAxes, direction, dot,
};
use crate::observe::{Flips, Nothing, Observe, Tilt, Watched};
use crate::real::{Pack, Real};
use crate::simd::Isa;
#[cfg(target_arch = "x86_64")]
use crate::simd::{Arr, V4, V8};
use std::sync::OnceLock;

/// Bodies in a group: four AVX-512 registers, so that each hides the latency of the others.
pub const LANES: usize = 32;

/// Longest state: rates, vertical and quaternion.
pub const MAX_STATE: usize = 10;

/// One number for each body of a group.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
pub struct Row(pub [f64; LANES]);

impl Row {
    const ZERO: Row = Row([0.0; LANES]);
}

/// The invariants at the start and the largest deviation from them seen at the ends of bursts.
#[derive(Clone, Copy)]
pub struct DriftRows {
    /// Value at the start.
    pub start: Row,
    /// One over the scale that the deviation is measured in.
    pub inverse_scale: Row,
    /// Largest deviation.
    pub worst: Row,
}

/// The bodies in flight and all that is known of them.
#[derive(Clone)]
pub struct Group {
    /// Rates or momenta, directions, quaternion.
    pub state: [Row; MAX_STATE],
    /// Principal moments.
    pub moments: [Row; 3],
    /// `mgl com`.
    pub weight: [Row; 3],
    /// Time step; 0 makes a lane wait.
    pub step: Row,
    /// Steps made.
    pub count: Row,
    /// See `Watched`.
    pub axis: [Row; 3],
    /// See `Watched`.
    pub side: Row,
    /// See `Watched`.
    pub flips: Row,
    /// See `Watched`.
    pub left: Row,
    /// See `Watched`.
    pub cosine: Row,
    /// See `Watched`.
    pub sine2: Row,
    /// See `Watched`.
    pub limit: [Row; 2],
    /// Energy.
    pub energy: DriftRows,
    /// `L.L` of a free body, `L.gamma` of a top.
    pub momentum: DriftRows,
    /// Largest deviation of the length of a direction from one.
    pub unit: Row,
}

impl Group {
    /// Lanes that wait.
    pub fn waiting() -> Group {
        static WAITING: OnceLock<Group> = OnceLock::new();
        WAITING.get_or_init(Group::all_waiting).clone()
    }

    fn all_waiting() -> Group {
        let drift = DriftRows { start: Row::ZERO, inverse_scale: Row::ZERO, worst: Row::ZERO };
        let mut group = Group {
            state: [Row::ZERO; MAX_STATE],
            moments: [Row([1.0; LANES]); 3],
            weight: [Row::ZERO; 3],
            step: Row::ZERO,
            count: Row::ZERO,
            axis: [Row::ZERO; 3],
            side: Row::ZERO,
            flips: Row::ZERO,
            left: Row::ZERO,
            cosine: Row::ZERO,
            sine2: Row::ZERO,
            limit: [Row::ZERO; 2],
            energy: drift,
            momentum: drift,
            unit: Row::ZERO,
        };
        for lane in 0..LANES {
            group.wait(lane);
        }
        group
    }

    /// Makes a lane wait: a unit sphere at rest, its watched axis where it started, and a step of 0.
    pub fn wait(&mut self, lane: usize) {
        for row in &mut self.state {
            row.0[lane] = 0.0;
        }
        for direction in [3, 6] {
            self.state[direction].0[lane] = 1.0;
        }
        for k in 0..3 {
            self.moments[k].0[lane] = 1.0;
            self.weight[k].0[lane] = 0.0;
            self.axis[k].0[lane] = if k == 0 { 1.0 } else { 0.0 };
        }
        self.step.0[lane] = 0.0;
        self.side.0[lane] = 0.0;
        self.flips.0[lane] = 0.0;
        self.left.0[lane] = f64::INFINITY;
        self.cosine.0[lane] = 1.0;
        self.sine2.0[lane] = 0.0;
        self.limit[0].0[lane] = f64::NEG_INFINITY;
        self.limit[1].0[lane] = f64::INFINITY;
        self.unit.0[lane] = 0.0;
        for drift in [&mut self.energy, &mut self.momentum] {
            drift.start.0[lane] = 0.0;
            drift.inverse_scale.0[lane] = 0.0;
            drift.worst.0[lane] = 0.0;
        }
    }
}

/// Which model moves and what is carried beside the rates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)] // The names are those of `model`.
pub enum System {
    FreeRates,
    FreeAxis,
    FreeAttitude,
    TopAxis,
    TopTwoAxes,
    TopAttitude,
}

/// Which table moves it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)] // The names are those of `method`.
pub enum Table {
    Rk4,
    Planar,
    Rotor,
}

/// What is looked at after each step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)] // The names are those of `observe`.
pub enum Watch {
    Nothing,
    Flips,
    Tilt,
}

/// A kernel: system, table and observable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Kernel {
    /// What moves.
    pub system: System,
    /// How.
    pub table: Table,
    /// What is watched.
    pub watch: Watch,
}

impl System {
    /// Numbers in the state.
    #[allow(clippy::len_without_is_empty)] // No state is empty.
    pub fn len(self) -> usize {
        match self {
            System::FreeRates => Rates::LEN,
            System::FreeAxis | System::TopAxis => Axis::LEN,
            System::FreeAttitude => Attitude::LEN,
            System::TopTwoAxes => TwoAxes::LEN,
            System::TopAttitude => AxisAttitude::LEN,
        }
    }

    /// Whether there is weight; the vertical is then the first direction carried.
    pub fn is_top(self) -> bool {
        matches!(self, System::TopAxis | System::TopTwoAxes | System::TopAttitude)
    }

    /// Where the quaternion begins, if one is carried.
    pub fn quaternion_at(self) -> Option<usize> {
        match self {
            System::FreeAttitude => Some(Attitude::QUATERNION_AT),
            System::TopAttitude => Some(AxisAttitude::QUATERNION_AT),
            _ => None,
        }
    }
}

impl Table {
    /// All tables.
    pub const ALL: [Table; 3] = [Table::Rk4, Table::Planar, Table::Rotor];

    /// The variables that it moves.
    pub fn form(self) -> Form {
        match self {
            Table::Rk4 => Form::Rates,
            Table::Planar | Table::Rotor => Form::Momenta,
        }
    }
}

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

/// Advances all lanes by `steps`, the packs side by side, and compares the invariants at the end.
#[inline(always)]
fn burst<P, const PACKS: usize, M, L, S, W, const D: usize>(g: &mut Group, steps: usize)
where
    P: Pack,
    M: Model<P>,
    L: Layout,
    S: Scheme<P, M, L, D>,
    W: Observe,
{
    const { assert!(D == L::LEN && PACKS * P::LANES == LANES) };
    let mut p = [Parameters {
        moments: load3::<P>(&g.moments, 0),
        weight: load3::<P>(&g.weight, 0),
        step: P::load(&g.step.0),
    }; PACKS];
    let mut schemes = [S::new(&p[0]); PACKS];
    for b in 1..PACKS {
        let at = b * P::LANES;
        p[b] = Parameters {
            moments: load3(&g.moments, at),
            weight: load3(&g.weight, at),
            step: P::load(&g.step.0[at..]),
        };
        schemes[b] = S::new(&p[b]);
    }
    for i in 0..steps {
        for b in 0..PACKS {
            let at = b * P::LANES;
            let mut y = [P::splat(0.0); D];
            for d in 0..D {
                y[d] = P::load(&g.state[d].0[at..]);
            }
            let before = y;
            schemes[b].step(&p[b], &mut y);
            for d in 0..D {
                y[d].store(&mut g.state[d].0[at..]);
            }
            if const { W::WATCHES } {
                let mut watched = load_watched::<P>(g, at);
                let time = (P::load(&g.count.0[at..]) + P::splat(i as f64)) * p[b].step;
                W::after_step::<P, M, L, S, D>(&schemes[b], &p[b], &mut watched, time, &before, &y);
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
        let [energy, momentum] = invariants::<P, M, L, S, D>(&p[b], &y);
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
    PlanarStrang: Splitting<R>, Arr<V8, 2>, Arr<V4, 2>;
    RotorStrang: Splitting<R>, V8, V4;
}

/// Advances all lanes of a group by some steps.
type Advance = unsafe fn(&mut Group, usize);
/// Energy and conserved momentum of one body, with the arithmetic of the kernel.
type Invariants = unsafe fn(&Parameters<f64>, &[f64; MAX_STATE]) -> [f64; 2];

/// A kernel compiled for an instruction set that this CPU has.
#[derive(Clone, Copy)]
pub struct Compiled {
    advance: Advance,
    invariants: Invariants,
}

impl Compiled {
    /// The kernel for that instruction set; panics if the CPU lacks it.
    pub fn new(kernel: Kernel, isa: Isa) -> Compiled {
        assert!(isa.is_available(), "{} is not available on this CPU", isa.name());
        entry(kernel, isa)
    }

    /// Advances every lane of the group.
    pub fn advance(self, group: &mut Group, steps: usize) {
        // Safety: `new` has seen the features that the entry point needs.
        unsafe { (self.advance)(group, steps) }
    }

    /// Energy and conserved momentum of one body.
    pub fn invariants(self, p: &Parameters<f64>, y: &[f64; MAX_STATE]) -> [f64; 2] {
        // Safety: as above.
        unsafe { (self.invariants)(p, y) }
    }
}

/// The functions of a model, layout, table and observable for an instruction set.
macro_rules! compiled {
    ($isa:ident, $model:ident, $layout:ident, $d:literal, $table:ident, $watch:ident) => {{
        #[cfg(target_arch = "x86_64")]
        compiled!(@functions avx512, [#[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,avx2,fma")]],
            <$table as Engine>::Avx512, $model, $layout, $d, $table, $watch);
        #[cfg(target_arch = "x86_64")]
        compiled!(@functions avx2, [#[target_feature(enable = "avx2,fma")]],
            <$table as Engine>::Avx2, $model, $layout, $d, $table, $watch);
        compiled!(@functions scalar, [], f64, $model, $layout, $d, $table, $watch);
        match $isa {
            #[cfg(target_arch = "x86_64")]
            Isa::Avx512 => Compiled { advance: avx512::advance, invariants: avx512::invariants_of },
            #[cfg(target_arch = "x86_64")]
            Isa::Avx2 => Compiled { advance: avx2::advance, invariants: avx2::invariants_of },
            _ => Compiled { advance: scalar::advance, invariants: scalar::invariants_of },
        }
    }};
    (@functions $name:ident, [$($feature:tt)*], $pack:ty,
     $model:ident, $layout:ident, $d:literal, $table:ident, $watch:ident) => {
        mod $name {
            use super::*;
            type P = $pack;
            type Scheme<R> = <$table as Engine>::Scheme<R, $model<R>>;
            $($feature)*
            pub fn advance(g: &mut Group, steps: usize) {
                burst::<P, { LANES / P::LANES }, $model<P>, $layout, Scheme<P>, $watch, $d>(g, steps)
            }
            $($feature)*
            pub fn invariants_of(p: &Parameters<f64>, y: &[f64; MAX_STATE]) -> [f64; 2] {
                let mut state = [0.0; $d];
                state.copy_from_slice(&y[..$d]);
                invariants::<f64, $model<f64>, $layout, Scheme<f64>, $d>(p, &state)
            }
        }
    };
}

/// The match from a kernel to its compiled forms: every listed pair of system and observable with every table.
macro_rules! entries {
    ($($system:ident $watch:ident: $model:ident, $layout:ident, $d:literal;)*) => {
        fn entry(kernel: Kernel, isa: Isa) -> Compiled {
            match (kernel.system, kernel.watch, kernel.table) {
                $(
                    (System::$system, Watch::$watch, Table::Rk4) => {
                        compiled!(isa, $model, $layout, $d, Rk4, $watch)
                    }
                    (System::$system, Watch::$watch, Table::Planar) => {
                        compiled!(isa, $model, $layout, $d, PlanarStrang, $watch)
                    }
                    (System::$system, Watch::$watch, Table::Rotor) => {
                        compiled!(isa, $model, $layout, $d, RotorStrang, $watch)
                    }
                )*
                (system, watch, _) => unreachable!("{watch:?} is not watched on {system:?}"),
            }
        }
    };
}
entries! {
    FreeRates Nothing: Free, Rates, 3;
    FreeRates Flips: Free, Rates, 3;
    FreeAxis Nothing: Free, Axis, 6;
    FreeAxis Tilt: Free, Axis, 6;
    FreeAttitude Nothing: Free, Attitude, 7;
    TopAxis Nothing: Top, Axis, 6;
    TopAxis Flips: Top, Axis, 6;
    TopAxis Tilt: Top, Axis, 6;
    TopTwoAxes Tilt: Top, TwoAxes, 9;
    TopAttitude Nothing: Top, AxisAttitude, 10;
}
