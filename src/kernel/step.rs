//! Blocks of steps of a group.
//!
//! A block advances all bodies of a `Group` by some steps. Lanes are loaded and read by scalar code. No lane depends on
//! another.

use super::group::{DeviationRows, DriftRows, ForcesRows, Group};
use crate::forces::ForcesInterval;
use crate::kinematics::{direction, dot, half_rows, put, squared_length, vertical};
use crate::method::{Coefficients, Engine, Numbers};
use crate::observe::{Observed, Segment};
use crate::real::{Pack, Real};
use crate::scene::{Layout, Model, Parameters, in_rows, quaternion};
use crate::simd::{LANES, load_rows, store_rows};

/// The constants of the body and of its step in the pack that begins at a lane.
#[inline(always)]
fn parameters<P: Pack>(g: &Group, at: usize) -> Parameters<P> {
    Parameters {
        moments: load_rows(&g.moments, at),
        weight: load_rows(&g.weight, at),
        step: P::load(&g.step.0[at..]),
    }
}

/// Deviation of an invariant at the end of a block. A NaN remains, because `max` returns its second argument then.
#[inline(always)]
fn update_drift<P: Pack>(rows: &mut DriftRows, at: usize, now: P) {
    let off = (now - P::load(&rows.start.0[at..])).abs() * P::load(&rows.inverse_scale.0[at..]);
    P::load(&rows.worst.0[at..]).max(off).store(&mut rows.worst.0[at..]);
}

/// The same, and the engine of the body.
#[inline(always)]
fn prepared_pack<P: Pack, M: Model<P>, L: Layout, S: Engine<P, M, L, D>, const D: usize>(
    g: &Group,
    forces: &ForcesRows,
    at: usize,
    numbers: &'static Numbers,
) -> (Parameters<P>, S) {
    let p = parameters(g, at);
    let acts = L::BALANCE || L::CHANGED || L::CLOCK;
    // SAFETY: the engine ends with its block of steps, during which `forces` is borrowed.
    let interval = if acts { unsafe { forces.load(at) } } else { ForcesInterval::none() };
    (p, S::new(&p, &interval, numbers))
}

/// Number of packs with a body: one body alone does not pay for the lanes of a whole group.
#[inline(always)]
pub(super) fn used_packs<P: Pack, const PACKS: usize>(g: &Group) -> usize {
    g.used.div_ceil(P::LANES).min(PACKS)
}

/// Most packs that are written out one after another.
const MOST_WRITTEN_OUT: usize = 8;

/// Writes a statement once for each pack.
macro_rules! each_pack {
    ($b:ident < $packs:ident => $body:block) => {
        each_pack!(@each $b $packs $body 0 1 2 3 4 5 6 7);
    };
    (@each $b:ident $packs:ident $body:block $($number:literal)*) => {$({
        const $b: usize = $number;
        if const { $b < $packs } $body
    })*};
}

/// The constants of the bodies and of their steps, pack by pack.
#[inline(always)]
pub(super) fn prepared<P, const PACKS: usize, M, L, S, const D: usize>(
    g: &Group,
    forces: &ForcesRows,
    numbers: &'static Numbers,
) -> [(Parameters<P>, S); PACKS]
where
    P: Pack,
    M: Model<P>,
    L: Layout,
    S: Engine<P, M, L, D>,
{
    const { assert!(D == L::LEN && PACKS * P::LANES <= LANES) };
    let mut bodies = [prepared_pack::<P, M, L, S, D>(g, forces, 0, numbers); PACKS];
    if const { S::IS_SHORT && PACKS <= MOST_WRITTEN_OUT } {
        // The loop below stays a loop here, in which the compiler copies the constants of a pack by calls.
        each_pack!(B < PACKS => {
            if const { B != 0 } {
                bodies[B] = prepared_pack::<P, M, L, S, D>(g, forces, B * P::LANES, numbers);
            }
        });
        return bodies;
    }
    for b in 1..PACKS {
        bodies[b] = prepared_pack::<P, M, L, S, D>(g, forces, b * P::LANES, numbers);
    }
    bodies
}

/// Advances all lanes by `steps`, with interleaved packs, and updates the drifts at the end.
#[inline(always)]
pub(super) fn step_block<P, const PACKS: usize, M, L, S, const D: usize>(
    g: &mut Group,
    forces: &ForcesRows,
    steps: usize,
    observed: Observed,
    numbers: &'static Numbers,
) where
    P: Pack,
    M: Model<P>,
    L: Layout,
    S: Engine<P, M, L, D>,
{
    let packs = used_packs::<P, PACKS>(g);
    let is_observed = !matches!(observed, Observed::Nothing);
    if const { S::IS_SHORT && PACKS <= MOST_WRITTEN_OUT } && !is_observed && packs == PACKS {
        short_steps::<P, PACKS, M, L, S, D>(g, forces, steps, numbers);
        return;
    }
    let bodies = prepared::<P, PACKS, M, L, S, D>(g, forces, numbers);
    for i in 0..steps {
        // A loop to a constant, which the compiler unrolls: else it copies the stages of a step by calls. Beside the calls
        // of a function that is little, and four copies of twelve stages with a search inside are long to compile.
        let unrolled = if const { L::FUNCTION } { packs } else { PACKS };
        for b in 0..unrolled {
            if b == packs {
                break;
            }
            let at = b * P::LANES;
            let mut y: [P; D] = load_rows(&g.state, at);
            let before = y;
            let (p, engine) = &bodies[b];
            if const { L::FUNCTION } && !P::any(P::splat(0.0).lt(p.step.abs())) {
                // Nobody is in the lane: the function would be called for nothing.
                continue;
            }
            let mut compensation = y;
            let mut dense = Coefficients::new();
            if S::COMPENSATES {
                compensation = load_rows(&g.compensation, at);
            }
            engine.step_on(p, &mut y, &mut compensation, &mut dense);
            if S::COMPENSATES {
                store_rows(&compensation, &mut g.compensation, at);
            }
            store_rows(&y, &mut g.state, at);
            if is_observed {
                let begin = (P::load(&g.count.0[at..]) + P::splat(i as f64)) * p.step;
                let segment = Segment { engine, p, begin, before: &before, after: &y, dense: &dense };
                observed.after_step::<P, M, L, S, D>(&mut g.observed, at, &segment);
            }
            if const { S::SHARES_MOTION } {
                for rows in &mut g.further {
                    move_deviation::<P, M, L, S, D>(engine, rows, at, &mut dense);
                }
            }
        }
    }
    for b in 0..PACKS {
        let at = b * P::LANES;
        let y: [P; D] = load_rows(&g.state, at);
        end_block::<P, M, L, S, D>(g, at, &bodies[b].0, &y, steps);
    }
}

/// Moves a further deviation vector of the pack that begins at a lane by the last step.
#[inline(always)]
fn move_deviation<P: Pack, M: Model<P>, L: Layout, S: Engine<P, M, L, D>, const D: usize>(
    engine: &S,
    rows: &mut DeviationRows,
    at: usize,
    dense: &mut Coefficients<P, D>,
) {
    let (mut deviation, mut compensation) = (load_rows(&rows.state, at), [P::splat(0.0); 6]);
    if S::COMPENSATES {
        compensation = load_rows(&rows.compensation, at);
    }
    engine.move_deviation(&mut deviation, &mut compensation, dense);
    store_rows(&deviation, &mut rows.state, at);
    if S::COMPENSATES {
        store_rows(&compensation, &mut rows.compensation, at);
    }
}

/// Notes how much the length of a direction or quaternion differs from one, to first order, by the square of it.
#[inline(always)]
fn note_length<P: Pack>(g: &mut Group, at: usize, square: P) {
    let off = (square - P::splat(1.0)).abs() * P::splat(0.5);
    P::load(&g.unit.0[at..]).max(off).store(&mut g.unit.0[at..]);
}

/// Updates the drifts and the steps of the pack that begins at a lane, at the end of a block.
#[inline(always)]
fn end_block<P: Pack, M: Model<P>, L: Layout, S: Engine<P, M, L, D>, const D: usize>(
    g: &mut Group,
    at: usize,
    p: &Parameters<P>,
    y: &[P; D],
    steps: usize,
) {
    let [energy, momentum] = invariants::<P, M, L, S, D>(p, y);
    update_drift(&mut g.energy, at, energy);
    update_drift(&mut g.momentum, at, momentum);
    for v in 0..L::VECTORS {
        let n = direction(y, v);
        note_length(g, at, dot(&n, &n));
    }
    if const { L::TURNS } {
        note_length(g, at, squared_length(&quaternion::<L, P, D>(y)));
    }
    if const { L::CLOCK } {
        let [p, q, r, t] = [y[3], y[4], y[5], y[6]];
        let off = (dot(&[p, q, r], &[p, q, r]) + (t * t - P::splat(1.0))).abs() * P::splat(0.5);
        P::load(&g.unit.0[at..]).max(off).store(&mut g.unit.0[at..]);
    }
    (P::load(&g.count.0[at..]) + P::splat(steps as f64)).store(&mut g.count.0[at..]);
}

/// Advances full groups by steps of few operations that nothing observes. The steps of all packs are written out: the
/// loop over packs, with the constants of a pack at an address that it computes, takes a quarter of such a step.
#[inline(always)]
fn short_steps<P, const PACKS: usize, M, L, S, const D: usize>(
    g: &mut Group,
    forces: &ForcesRows,
    steps: usize,
    numbers: &'static Numbers,
) where
    P: Pack,
    M: Model<P>,
    L: Layout,
    S: Engine<P, M, L, D>,
{
    let bodies = prepared::<P, PACKS, M, L, S, D>(g, forces, numbers);
    let mut states = [[P::splat(0.0); D]; PACKS];
    each_pack!(B < PACKS => {
        states[B] = load_rows(&g.state, B * P::LANES);
    });
    for _ in 0..steps {
        each_pack!(B < PACKS => {
            let (p, engine) = &bodies[B];
            engine.step(p, &mut states[B]);
        });
    }
    each_pack!(B < PACKS => {
        store_rows(&states[B], &mut g.state, B * P::LANES);
        end_block::<P, M, L, S, D>(g, B * P::LANES, &bodies[B].0, &states[B], steps);
    });
}

/// Transforms active lanes to the variables of their steps, or back; inactive lanes keep every bit.
#[inline(always)]
pub(super) fn process<P, const PACKS: usize, M, L, S, const D: usize>(
    g: &mut Group,
    leaving: bool,
    numbers: &'static Numbers,
) where
    P: Pack,
    M: Model<P>,
    L: Layout,
    S: Engine<P, M, L, D>,
{
    for b in 0..PACKS {
        let at = b * P::LANES;
        let p = parameters(g, at);
        let mut y: [P; D] = load_rows(&g.state, at);
        let before = y;
        S::new(&p, &ForcesInterval::none(), numbers).process(&p, &mut y, leaving);
        let steps = P::splat(0.0).lt(p.step.abs());
        for d in 0..D {
            P::select(steps, y[d], before[d]).store(&mut g.state[d].0[at..]);
        }
    }
}

/// Energy and conserved momentum of a state, minus work and impulse if the body is forced; zeros where nothing that is
/// integrated is constant.
#[inline(always)]
pub(super) fn invariants<R: Real, M: Model<R>, L: Layout, S: Engine<R, M, L, D>, const D: usize>(
    p: &Parameters<R>,
    y: &[R; D],
) -> [R; 2] {
    if L::CLOCK {
        // No momentum is constant; the square of the rates shows whether the steps are short enough.
        return [jacobi(p, y), dot(&[y[0], y[1], y[2]], &[y[0], y[1], y[2]])];
    }
    let momentum = S::VARIABLES.momentum(p, y);
    let (mut potential, mut conserved) = if const { L::TURNS } {
        let mut rows = in_rows::<L, R, D>(y);
        put(&mut rows, 3, vertical(&quaternion::<L, R, D>(y)));
        (M::potential(p, &rows), M::conserved(&momentum, &rows))
    } else {
        (M::potential(p, y), M::conserved(&momentum, y))
    };
    if L::BALANCE {
        potential = potential - y[L::BALANCE_AT];
        conserved = conserved - y[L::IMPULSE_AT];
    }
    [S::VARIABLES.kinetic(p, y) + potential, conserved]
}

/// The Jacobi integral of a body on a circular orbit over the square of the mean motion; zero on an eccentric orbit, where
/// nothing that is integrated is constant.
#[inline(always)]
fn jacobi<R: Real, const D: usize>(p: &Parameters<R>, y: &[R; D]) -> R {
    let [outward, _, normal] = half_rows(&[y[3], y[4], y[5], y[6]]);
    let (zero, six) = (R::splat(0.0), R::splat(6.0));
    let mut sum = zero;
    for k in 0..3 {
        // The vectors are halves.
        let part = y[k].fma(y[k] * R::splat(0.5) - (normal[k] + normal[k]), six * (outward[k] * outward[k]));
        sum = p.moments[k].fma(part, sum);
    }
    R::select(zero.lt(y[7].abs() + y[8].abs()), zero, sum)
}
