//! Adaptive steps of one body alone: those of `adaptive_block`, with the same bits, and the directions side by side.

use super::adaptive::{AdaptiveSteps, some_ends};
use super::group::{ForcesRows, Group, MAX_STATE};
use crate::forces::ForcesInterval;
use crate::method::{COLUMNS, Columns, Engine, Numbers, SeriesAlone, Taylor, bound_of_margins, in_columns};
use crate::real::{Quad, is_finite, two_sum};
use crate::scene::{Layout, Model, Parameters};
use crate::simd::Row;
use crate::special::ln;

/// The number of the first lane, in all lanes of a register.
#[inline(always)]
fn first<R: Quad>(row: &Row) -> R {
    R::splat(row.0[0])
}

#[inline(always)]
fn first3<R: Quad>(rows: &[Row; 3]) -> [R; 3] {
    [first(&rows[0]), first(&rows[1]), first(&rows[2])]
}

/// Reads the columns of the first lane.
#[inline(always)]
fn read_columns<R: Quad, L: Layout>(rows: &[Row; MAX_STATE]) -> Columns<R> {
    let mut columns = [R::splat(0.0); COLUMNS];
    for column in 0..COLUMNS {
        let mut numbers = [0.0; 4];
        for lane in 0..4 {
            if let Some(d) = in_columns::<L>(column, lane) {
                numbers[lane] = rows[d].0[0];
            }
        }
        columns[column] = R::load(&numbers);
    }
    columns
}

/// Writes columns to the first lane.
#[inline(always)]
fn write_columns<R: Quad, L: Layout>(columns: &Columns<R>, rows: &mut [Row; MAX_STATE]) {
    for column in 0..COLUMNS {
        let mut numbers = [0.0; 4];
        columns[column].store(&mut numbers);
        for lane in 0..4 {
            if let Some(d) = in_columns::<L>(column, lane) {
                rows[d].0[0] = numbers[lane];
            }
        }
    }
}

/// The engine of the body in the first lane.
#[inline(always)]
pub fn engine_alone<R: Quad, M: Model<R>, L: Layout, const D: usize>(
    g: &Group,
    forces: &ForcesRows,
    numbers: &'static Numbers,
) -> Taylor<R, M> {
    let p = Parameters { moments: first3(&g.moments), weight: first3(&g.weight), step: first(&g.step) };
    let mut interval = ForcesInterval::none();
    if L::BALANCE {
        for j in 0..2 {
            interval.body[j] = first3(&forces.numbers.body[j]);
            interval.space[j] = first3(&forces.numbers.space[j]);
        }
        for k in 0..6 {
            interval.damping[k] = first(&forces.numbers.damping[k]);
        }
    }
    <Taylor<R, M> as Engine<R, M, L, D>>::new(&p, &interval, numbers)
}

/// Advances the body in the first lane by adaptive steps, at most `most`, until it reaches its `next` time. See
/// `adaptive_block`.
#[inline(always)]
pub fn adaptive_alone<R: Quad, M: Model<R>, L: Layout, const D: usize>(
    g: &mut Group,
    l: &mut AdaptiveSteps,
    engine: &Taylor<R, M>,
    most: usize,
) {
    let (zero, one, tolerance) = (R::splat(0.0), R::splat(1.0), R::splat(l.tolerance));
    let (next, end, direction) = (first::<R>(&l.next), first::<R>(&l.end), first::<R>(&l.direction));
    let scales = one.with_last(first(&l.inverse_rate));
    let (mut y, mut compensation) = (read_columns::<R, L>(&g.state), read_columns::<R, L>(&g.compensation));
    let mut step = first::<R>(&l.trial);
    let mut now = [first::<R>(&l.now[0]), first::<R>(&l.now[1])];
    let mut c = SeriesAlone::new();
    let (mut unit, mut begin);
    let mut done = 0;
    loop {
        done += 1;
        (unit, begin) = (step, now);
        engine.expand_alone::<L, D>(unit, &y, &mut c);
        let order = c.highest();
        let last = log_margin(&c.directions(order), scales, tolerance);
        let before = log_margin(&c.directions(order - 1), scales, tolerance);
        let mut bound = bound_of_margins(last, before, order);
        if L::BALANCE {
            bound = ((end - (now[0] + now[1])) / unit).min(bound);
        }
        if L::BALANCE {
            // Their sums fill the time in which the logarithms wait for each other.
            engine.add_balance_alone(unit, y[COLUMNS - 1], &mut c);
        }
        let mut increment = c.columns::<L>(order);
        for k in (1..order).rev() {
            let columns = c.columns::<L>(k);
            for d in 0..COLUMNS {
                increment[d] = increment[d].fma(bound, columns[d]);
            }
        }
        for d in 0..COLUMNS {
            (y[d], compensation[d]) = two_sum(y[d], increment[d].fma(bound, compensation[d]));
        }
        // The next step need not wait for the look at the state.
        step = unit.fma(bound, zero);
        if !is_finite(&y) {
            step = R::splat(f64::NAN);
        }
        let (time, residue) = two_sum(begin[0], step + begin[1]);
        now = [time, residue];
        if some_ends((next - time) * direction) || done >= most {
            break;
        }
    }
    write_columns::<R, L>(&y, &mut g.state);
    write_columns::<R, L>(&compensation, &mut g.compensation);
    for k in 0..=c.highest() {
        write_columns::<R, L>(&c.columns::<L>(k), &mut l.powers[k]);
    }
    for i in 0..2 {
        l.begin[i].0[0] = begin[i].first();
        l.now[i].0[0] = now[i].first();
    }
    l.unit.0[0] = unit.first();
    l.trial.0[0] = step.first();
    g.step.0[0] = step.first();
    g.count.0[0] += done as f64;
}

/// ln of the tolerance over the largest number of a term, the same in all lanes; see `step_bound`.
#[inline(always)]
fn log_margin<R: Quad>(term: &[R; 3], scales: R, tolerance: R) -> R {
    let mut largest = R::splat(f64::MIN_POSITIVE);
    for i in 0..3 {
        largest = largest.max(term[i].abs() * scales);
    }
    ln(tolerance) - ln(largest.largest())
}
