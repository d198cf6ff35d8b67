//! Closed forms of bodies side by side: where the generic motions meet instruction sets.

use super::{Exit, Free, Kind, Lagrange, Motion, Symmetric};
use crate::group::{LANES, Row};
use crate::real::Pack;
use crate::simd::Isa;
#[cfg(target_arch = "x86_64")]
use crate::simd::{Arr, V4, V8};
use crate::start::Body;

/// Bodies at their start, one in each lane, in the variables of their closed form.
#[derive(Clone, Copy)]
pub struct StartRows {
    moments: [Row; 3],
    weight: [Row; 3],
    omega: [Row; 3],
    attitude: [Row; 4],
}

impl StartRows {
    /// The same body in all lanes.
    pub fn filled(body: &Body) -> StartRows {
        StartRows {
            moments: body.moments.map(|x| Row([x; LANES])),
            weight: body.weight.map(|x| Row([x; LANES])),
            omega: body.omega.map(|x| Row([x; LANES])),
            attitude: body.attitude.map(|x| Row([x; LANES])),
        }
    }

    /// Puts a body into a lane.
    pub fn set(&mut self, lane: usize, body: &Body) {
        for k in 0..3 {
            self.moments[k].0[lane] = body.moments[k];
            self.weight[k].0[lane] = body.weight[k];
            self.omega[k].0[lane] = body.omega[k];
        }
        for k in 0..4 {
            self.attitude[k].0[lane] = body.attitude[k];
        }
    }
}

/// The states of all lanes at one time each.
#[derive(Clone, Copy)]
pub struct StateRows {
    /// Rates.
    pub omega: [Row; 3],
    /// Unit quaternions; untouched if only rates were wanted.
    pub attitude: [Row; 4],
}

impl StateRows {
    /// Zeros.
    pub const ZERO: StateRows = StateRows { omega: [Row([0.0; LANES]); 3], attitude: [Row([0.0; LANES]); 4] };
}

#[inline(always)]
fn load<P: Pack, const N: usize>(rows: &[Row; N], at: usize) -> [P; N] {
    let mut out = [P::splat(0.0); N];
    for k in 0..N {
        out[k] = P::load(&rows[k].0[at..]);
    }
    out
}

/// Sets up the motion of each lane once, then evaluates it at each row of times.
#[inline(always)]
fn states<P: Pack, M: Motion<P>, const ATTITUDE: bool>(
    starts: &StartRows,
    times: &[Row],
    out: &mut [StateRows],
) {
    for at in (0..LANES).step_by(P::LANES) {
        let motion = M::new(
            &load(&starts.moments, at),
            &load(&starts.weight, at),
            &load(&starts.omega, at),
            &load(&starts.attitude, at),
        );
        for (time, state) in times.iter().zip(out.iter_mut()) {
            let t = P::load(&time.0[at..]);
            if const { ATTITUDE } {
                let (omega, attitude) = motion.state(t);
                for k in 0..3 {
                    omega[k].store(&mut state.omega[k].0[at..]);
                }
                for k in 0..4 {
                    attitude[k].store(&mut state.attitude[k].0[at..]);
                }
            } else {
                let omega = motion.rates(t);
                for k in 0..3 {
                    omega[k].store(&mut state.omega[k].0[at..]);
                }
            }
        }
    }
}

/// What each lane may leave; see `Exit`.
#[derive(Clone, Copy)]
pub struct ExitRows {
    /// Watched component.
    pub axis: Row,
    /// Limit.
    pub limit: Row,
    /// Direction.
    pub direction: Row,
}

/// The time at which each lane leaves what is asked for.
#[inline(always)]
fn exits<P: Pack, M: Motion<P>>(starts: &StartRows, questions: &ExitRows, out: &mut Row) {
    for at in (0..LANES).step_by(P::LANES) {
        let motion = M::new(
            &load(&starts.moments, at),
            &load(&starts.weight, at),
            &load(&starts.omega, at),
            &load(&starts.attitude, at),
        );
        let question = Exit {
            axis: P::load(&questions.axis.0[at..]),
            limit: P::load(&questions.limit.0[at..]),
            direction: P::load(&questions.direction.0[at..]),
        };
        motion.exit(&question).store(&mut out.0[at..]);
    }
}

type Exits = unsafe fn(&StartRows, &ExitRows, &mut Row);
type States = unsafe fn(&StartRows, &[Row], &mut [StateRows]);

/// The closed form of a kind, compiled for an instruction set that this CPU has.
#[derive(Clone, Copy)]
pub struct Evaluator {
    rates: States,
    states: States,
    exits: Exits,
}

macro_rules! evaluator {
    ($isa:ident, $motion:ident, $avx512:ty, $avx2:ty) => {{
        #[cfg(target_arch = "x86_64")]
        evaluator!(@functions avx512, [#[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,avx2,fma")]],
            $avx512, $motion);
        #[cfg(target_arch = "x86_64")]
        evaluator!(@functions avx2, [#[target_feature(enable = "avx2,fma")]], $avx2, $motion);
        evaluator!(@functions scalar, [], f64, $motion);
        match $isa {
            #[cfg(target_arch = "x86_64")]
            Isa::Avx512 => Evaluator { rates: avx512::rates, states: avx512::full, exits: avx512::exits_of },
            #[cfg(target_arch = "x86_64")]
            Isa::Avx2 => Evaluator { rates: avx2::rates, states: avx2::full, exits: avx2::exits_of },
            _ => Evaluator { rates: scalar::rates, states: scalar::full, exits: scalar::exits_of },
        }
    }};
    (@functions $name:ident, [$($feature:tt)*], $pack:ty, $motion:ident) => {
        mod $name {
            use super::*;
            $($feature)*
            pub fn rates(starts: &StartRows, times: &[Row], out: &mut [StateRows]) {
                states::<$pack, $motion<$pack>, false>(starts, times, out)
            }
            $($feature)*
            pub fn full(starts: &StartRows, times: &[Row], out: &mut [StateRows]) {
                states::<$pack, $motion<$pack>, true>(starts, times, out)
            }
            $($feature)*
            pub fn exits_of(starts: &StartRows, questions: &ExitRows, out: &mut Row) {
                exits::<$pack, $motion<$pack>>(starts, questions, out)
            }
        }
    };
}

impl Evaluator {
    /// The evaluator for that instruction set; panics if the CPU lacks it.
    pub fn new(kind: Kind, isa: Isa) -> Evaluator {
        assert!(isa.is_available(), "{} is not available on this CPU", isa.name());
        match kind {
            Kind::Symmetric => evaluator!(isa, Symmetric, V8, V4),
            // Two packs in flight hide the latency of its square roots (benches/README.md).
            Kind::Free => evaluator!(isa, Free, Arr<V8, 2>, Arr<V4, 2>),
            Kind::Lagrange => evaluator!(isa, Lagrange, V8, V4),
        }
    }

    /// The rates of all lanes at each row of times.
    pub fn rates(self, starts: &StartRows, times: &[Row], out: &mut [StateRows]) {
        // Safety: `new` has seen the features that the entry point needs.
        unsafe { (self.rates)(starts, times, out) }
    }

    /// The states of all lanes at each row of times.
    pub fn states(self, starts: &StartRows, times: &[Row], out: &mut [StateRows]) {
        // Safety: as above.
        unsafe { (self.states)(starts, times, out) }
    }

    /// The times at which the lanes leave what is asked for.
    pub fn exits(self, starts: &StartRows, questions: &ExitRows, out: &mut Row) {
        // Safety: as above.
        unsafe { (self.exits)(starts, questions, out) }
    }
}
