//! Costs of closed forms: set-up, rates, one state with attitude, one classification.
//!
//! The unit is one sincos of a long phase in the same registers. The rates of a symmetric body cost this and nine more
//! operations.
//!
//! `cargo bench --bench closed_forms`. Thread CPU time, the parts one after the other, medians.

#[path = "timing.rs"]
mod timing;

use rigid::body::Body;
use rigid::exact::{Evaluator, Exit, StartRows, StateRows};
use rigid::simd::Isa;
use rigid::simd::{LANES, Row};
use std::hint::black_box;

const REPEATS: usize = 31;
const ROUNDS: usize = 100;

/// Bodies of one kind: away from all limits, or close to a separatrix, or both in one register.
fn starts(kind: Evaluator, tame: bool, mixed: bool) -> StartRows {
    let body = |lane: usize| {
        let x = 1e-3 * lane as f64;
        let near = !tame && (!mixed || lane.is_multiple_of(2));
        let (moments, weight) = match kind {
            Evaluator::Symmetric => ([1.0, 1.0, 0.7], [0.0; 3]),
            Evaluator::Free => ([1.0, 1.6, 2.1], [0.0; 3]),
            Evaluator::Lagrange => ([1.0, 1.0, 0.5], [0.0, 0.0, 1.0]),
        };
        let omega = match kind {
            Evaluator::Lagrange if near => [1e-6, 2e-6, 2.5 + x],
            Evaluator::Lagrange => [0.3 + x, -0.2, 6.0],
            _ if near => [1e-6 + 1e-6 * x, 1.0, 1e-6],
            _ => [0.2 + x, 0.3, 1.0],
        };
        let attitude = if near { [1.0, 1e-6, 0.0, 0.0] } else { [0.8, 0.36, 0.48, 0.0] };
        Body { moments, weight, omega, attitude }
    };
    let mut rows = StartRows::filled(&body(0));
    for lane in 0..LANES {
        rows.set(lane, &body(lane));
    }
    rows
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Nanoseconds per body of a call on all lanes.
fn timed(mut call: impl FnMut()) -> Result<f64, String> {
    let elapsed = timing::timed(|| (0..ROUNDS).for_each(|_| call()))?;
    Ok(elapsed / (ROUNDS * LANES) as f64)
}

/// Prints a row for each kind of body; returns how many.
///
/// # Errors
/// If a result is impossible.
pub fn print_rows(repeats: usize) -> Result<usize, String> {
    let mut count = 0;
    const TIMES: usize = 64;
    let times: Vec<Row> = (0..TIMES).map(|k| Row([3.0 + 1.7 * k as f64; LANES])).collect();
    let mut out = vec![StateRows::ZERO; TIMES];
    println!(
        "{:32} {:>7} {:>9} {:>9} {:>9} {:>9} {:>8} {:>8}",
        "ns per body", "path", "set-up", "rates", "state", "exit", "sincos", "state/sc"
    );
    for isa in Isa::available() {
        let (symmetric, spinning) = (Evaluator::Symmetric, starts(Evaluator::Symmetric, true, false));
        for kind in [Evaluator::Symmetric, Evaluator::Free, Evaluator::Lagrange] {
            for (name, tame, mixed) in
                [("tame", true, false), ("separatrix", false, false), ("mixed", false, true)]
            {
                let starts = starts(kind, tame, mixed);
                let limits = Exit {
                    axis: Row([1.0; LANES]),
                    limit: [Row([0.3; LANES]), Row([1.7; LANES])],
                    direction: Row([1.0; LANES]),
                };
                let mut exits = Row([0.0; LANES]);
                let mut columns: [Vec<f64>; 6] = Default::default();
                for _ in 0..repeats {
                    let starts = black_box(&starts);
                    let one = brief(|| kind.states(isa, starts, black_box(&times[..1]), &mut out[..1]))?;
                    let all = timed(|| kind.states(isa, starts, black_box(&times), &mut out))?;
                    let rates = timed(|| kind.rates(isa, starts, black_box(&times), &mut out))?;
                    let rate = brief(|| kind.rates(isa, starts, black_box(&times[..1]), &mut out[..1]))?;
                    let exit = brief(|| kind.exits(isa, starts, black_box(&limits), &mut exits))?;
                    let sincos = timed(|| symmetric.rates(isa, &spinning, black_box(&times), &mut out))?;
                    let first =
                        brief(|| symmetric.rates(isa, &spinning, black_box(&times[..1]), &mut out[..1]))?;
                    let sc = (sincos - first) / (TIMES - 1) as f64;
                    let state = (all - one) / (TIMES - 1) as f64;
                    let values =
                        [one - state, (rates - rate) / (TIMES - 1) as f64, state, exit, sc, state / sc];
                    for (column, value) in columns.iter_mut().zip(values) {
                        column.push(value);
                    }
                }
                timing::changed(&vec![0.0; 7 * LANES], &numbers(&out[TIMES - 1]))?;
                let medians = columns.map(median);
                timing::positive(&medians)
                    .map_err(|why| format!("{kind:?} {name}, {}: {why}", isa.name()))?;
                let [setup, rates, state, exit, sc, ratio] = medians;
                println!(
                    "{:32} {:>7} {setup:>9.1} {rates:>9.2} {state:>9.2} {exit:>9.1} {sc:>8.3} {ratio:>8.1}",
                    format!("{kind:?} {name}"),
                    isa.name()
                );
                count += 1;
            }
        }
    }
    Ok(count)
}

/// Nanoseconds of work too short for the clock: it is timed some times in a row.
fn brief(mut work: impl FnMut()) -> Result<f64, String> {
    const TIMES: usize = 16;
    timed(|| (0..TIMES).for_each(|_| work())).map(|all| all / TIMES as f64)
}

/// Rates and attitudes of all lanes.
fn numbers(states: &StateRows) -> Vec<f64> {
    states.omega.iter().chain(&states.attitude).flat_map(|row| row.0).collect()
}

#[allow(dead_code)] // A test prints rows too.
fn main() -> Result<(), String> {
    print_rows(REPEATS).map(|_| ())
}
