//! The errors of states from a second run, or from a coarser run.

use super::batch::{Batch, Solver, picked};
use super::second_run::{HALVINGS, Steps, is_checked_by_compensated, second_run};
use super::tolerances::is_ruled_by_rounding;
use crate::error::Error;
use crate::estimate::{
    Estimate, ROUNDINGS, Recorded, Run, Stated, depends_on_change, measured_change, phase_error, stated,
};
use crate::memory;
use crate::status::Status;
use crate::trajectory::{StatesPart, time_range};
use std::collections::BTreeMap;

/// Factor from the difference of two runs to the stated error.
pub const SAFETY: f64 = 3.0;

/// Factor for the finer of two runs, if its error is a quarter of the error of the other.
const SAFETY_OF_FINER: f64 = 2.0;

/// Most times besides output times at which runs that may differ by whole turns are compared.
const BETWEEN: f64 = 64.0;

/// Bodies judged between two questions whether to stop.
pub const BETWEEN_QUESTIONS: usize = 64;

/// States of the bodies of a batch: those of all, or the rows of its bodies.
#[derive(Clone, Copy)]
pub struct Rows<'a> {
    pub states: &'a StatesPart<'a>,
    pub rows: Option<&'a [usize]>,
}

impl<'a> Rows<'a> {
    /// The states of all bodies.
    pub fn all(states: &'a StatesPart<'a>) -> Self {
        Rows { states, rows: None }
    }

    /// The rows of some of the bodies.
    pub fn rows_of(&self, some: &[usize]) -> Result<Vec<usize>, Error> {
        memory::collected("bodies", some.len(), some.iter().map(|&body| self.row(body)))
    }

    fn row(&self, body: usize) -> usize {
        self.rows.map_or(body, |rows| rows[body])
    }

    fn steps(&self, body: usize) -> u64 {
        self.states.steps[self.row(body)]
    }

    fn recorded(&self, body: usize, times: usize) -> Recorded<'a> {
        let states = self.states;
        let all = Recorded {
            omega: states.omega.as_deref().map_or(&[], |column| column.as_chunks().0),
            gamma: states.gamma.as_deref().map(|column| column.as_chunks().0),
            attitude: states.attitude.as_deref().map(|column| column.as_chunks().0),
            work: states.work.as_deref(),
            states: states.states.as_deref().map(|column| column.as_chunks().0),
        };
        all.of(self.row(body), times)
    }
}

/// A run with longer steps, or by a larger tolerance.
#[derive(Clone, Copy)]
pub struct Coarser<'a> {
    pub states: Rows<'a>,
    /// Its tolerance, if that tells its error.
    pub tolerance: Option<f64>,
}

/// Factor from the difference of two runs to the stated error of the finer run.
fn safety_of_finer(halvings: f64) -> f64 {
    if halvings == HALVINGS { SAFETY_OF_FINER } else { SAFETY }
}

/// The errors of the bodies that finished below the step limit, by a function of their numbers, batch and states; the errors of
/// the others are unknown. None if all bodies finished.
pub fn of_finished(
    batch: &Batch,
    states: Rows,
    own: impl FnOnce(&[usize], &Batch, Rows) -> Result<Vec<Estimate>, Error>,
) -> Result<Option<Vec<Estimate>>, Error> {
    let n = batch.len();
    let finished = |&body: &usize| states.states.status[states.row(body)] != Status::StepLimit;
    let count = (0..n).filter(finished).count();
    if count == n {
        return Ok(None);
    }
    let mut all = memory::filled("errors of the bodies", n, Estimate::UNKNOWN)?;
    if count > 0 {
        let some = memory::collected("bodies", count, (0..n).filter(finished))?;
        let rows = states.rows_of(&some)?;
        write(&mut all, &some, &own(&some, &batch.select(&some)?, Rows { rows: Some(&rows), ..states })?);
    }
    Ok(Some(all))
}

/// The errors of states that were made with these steps, from second runs; or from a coarser run with these steps.
pub fn estimate(
    batch: &Batch,
    solver: Solver,
    states: Rows,
    steps: Steps,
    coarser: Option<Coarser>,
) -> Result<Vec<Estimate>, Error> {
    let of_some = |some: &[usize], batch: &Batch, states: Rows| {
        let longest = steps.longest.map(|longest| picked("steps", longest, some)).transpose()?;
        let steps = Steps { longest: longest.as_deref(), ..steps };
        let rows = coarser.map(|coarser| coarser.states.rows_of(some)).transpose()?;
        let coarser = coarser
            .map(|coarser| Coarser { states: Rows { rows: rows.as_deref(), ..coarser.states }, ..coarser });
        estimate(batch, solver, states, steps, coarser)
    };
    if let Some(all) = of_finished(batch, states, of_some)? {
        return Ok(all);
    }
    let n = batch.len();
    if (0..n).all(|body| batch.span_of(body) == 0.0) {
        return memory::filled("errors of the bodies", n, Estimate::NONE);
    }
    let longer = coarser.map_or(states, |coarser| coarser.states);
    let taken: Vec<u64> = memory::collected("steps", n, (0..n).map(|body| longer.steps(body)))?;
    let mut checks = Vec::new();
    let (safety, tolerance) = match coarser {
        Some(coarser) => (safety_of_finer(steps.halvings), coarser.tolerance),
        None => {
            let count = if is_ruled_by_rounding(solver) { ROUNDINGS } else { 1 };
            // A run that carries its rounding on, from the same start, shows all rounding of this one. From a start beside it the
            // rounding of both is of one size, and less than a third of it shows in one of ten runs.
            let as_it_is = is_checked_by_compensated(solver).then_some(None);
            for rounding in (0..count).map(Some).chain(as_it_is) {
                checks.push(second_run(batch, solver, steps, &taken, rounding)?);
            }
            (SAFETY, None)
        }
    };
    let checks: Vec<_> = checks.iter_mut().map(|states| states.whole()).collect();
    let others: Vec<_> = match coarser {
        Some(coarser) => vec![coarser.states],
        None => checks.iter().map(Rows::all).collect(),
    };
    let told = stated_of_all(batch, solver, states, &taken, &others, (safety, tolerance), false)?;
    let mut all = memory::collected("errors of the bodies", n, told.iter().map(|stated| stated.estimate))?;
    if told.iter().any(|stated| stated.looks > 0.0) {
        count_turns(batch, solver, &taken, &told, &mut all)?;
    }
    Ok(all)
}

/// What is stated of states from those of other runs: safety times the distance of the farthest, and what all may have in
/// common; or the distance alone. `taken` are the steps of the run with the longer ones; a coarser run names its tolerance.
fn stated_of_all(
    batch: &Batch,
    solver: Solver,
    states: Rows,
    taken: &[u64],
    others: &[Rows],
    (safety, coarser_tolerance): (f64, Option<f64>),
    alone: bool,
) -> Result<Vec<Stated>, Error> {
    let (n, m, job) = (batch.len(), batch.number_of_times(), batch.job);
    let mut errors = memory::zeros("errors of a body", m.saturating_mul(2))?;
    let (error, apart) = errors.split_at_mut(m);
    let mut all = memory::reserved("errors of the bodies", n)?;
    for (index, body) in batch.bodies.iter().enumerate() {
        if index % BETWEEN_QUESTIONS == 0 && job.call.stop.is_wanted() {
            return Err(Error::Stopped);
        }
        let mut run = Run {
            body,
            forces: batch.forces().of(index),
            times: batch.times_of(index),
            states: states.recorded(index, m),
            drift: states.states.energy_drift[states.row(index)],
            steps: states.steps(index) as f64,
            taken: taken[index] as f64,
            change: None,
            method: solver.method,
            tolerance: solver.tolerance,
            coarser_tolerance,
        };
        if !alone && depends_on_change(&run) {
            run.change = Some(measured_change(&run, (job.scene, batch.forces(), index), job.call)?);
        }
        let others = others.iter().map(|other| other.recorded(index, m));
        all.push(stated(job.call.isa, &run, others, safety, alone, [&mut *error, &mut *apart]));
    }
    Ok(all)
}

/// Compares runs that may differ by whole turns at more times; writes larger errors over the estimates.
///
/// The steps of a run are equal between output times. So that no bit of its states depends on the estimate, a pair of further
/// runs is compared.
fn count_turns(
    batch: &Batch,
    solver: Solver,
    taken: &[u64],
    stated: &[Stated],
    all: &mut [Estimate],
) -> Result<(), Error> {
    // Bodies that are looked at as often share their times.
    let mut groups: BTreeMap<(usize, usize), Vec<usize>> = BTreeMap::new();
    for (body, own) in stated.iter().enumerate().filter(|(_, own)| own.looks > 0.0) {
        let alone = if batch.shares_times() { 0 } else { body };
        let group = groups.entry((own.looks.min(BETWEEN) as usize, alone)).or_default();
        memory::push("bodies with whole turns", group, body)?;
    }
    for ((looks, _), some) in groups {
        let times = between(batch.times_of(some[0]), looks)?;
        let dense = batch.at_times(&some, times)?;
        let taken = picked("steps", taken, &some)?;
        let step = |body: usize| dense.span_of(body) / taken[body] as f64;
        let longest = memory::collected("steps", some.len(), (0..some.len()).map(step))?;
        // It stops at more times.
        let mut states = dense.run(solver.with_more_steps(), Some(&longest), 1.0)?;
        let steps = Steps { longest: Some(&longest), refinement: 1.0, halvings: HALVINGS };
        let mut other = second_run(&dense, solver, steps, &taken, Some(0))?;
        let (states, other) = (states.whole(), other.whole());
        let [states, other] = [&states, &other].map(Rows::all);
        let own = stated_of_all(&dense, solver, states, &taken, &[other], (SAFETY, None), true)?;
        for (own, body) in own.iter().zip(some) {
            if own.estimate.error > all[body].error {
                all[body] = own.estimate;
            }
        }
    }
    Ok(())
}

/// Ascending times with so many more, evenly spread between the first and the last of the times and 0.
fn between(times: &[f64], looks: usize) -> Result<Vec<f64>, Error> {
    let [first, last] = time_range(times);
    let step = (last - first) / (looks + 1) as f64;
    let more = (1..=looks).map(|k| k as f64 * step + first);
    let mut all = memory::collected("times", times.len() + looks, times.iter().copied().chain(more))?;
    all.sort_unstable_by(f64::total_cmp);
    all.dedup();
    Ok(all)
}

/// The errors, raised to the phase errors that drift causes beside the separatrix.
pub fn with_phase_errors(batch: &Batch, states: Rows, mut all: Vec<Estimate>) -> Vec<Estimate> {
    let m = batch.number_of_times();
    for (index, own) in all.iter_mut().enumerate() {
        let recorded = states.recorded(index, m);
        let reached = time_range(batch.times_of(index));
        let near =
            phase_error(batch.job.call.isa, &batch.bodies[index], recorded.omega, recorded.work, reached);
        // Of a body that was not run again no error is known, but that its phase is lost.
        if own.error.is_nan() && !near.lost_from.is_finite() {
            continue;
        }
        if near.error > 0.0 {
            own.error = own.error.max(near.error);
        }
        if !(own.lost_from.abs() < near.lost_from.abs()) {
            own.lost_from = near.lost_from;
        }
    }
    all
}

/// Writes the estimates of some bodies.
pub fn write(all: &mut [Estimate], some: &[usize], own: &[Estimate]) {
    for (&body, &own) in some.iter().zip(own) {
        all[body] = own;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_between_are_spread_evenly_and_keep_the_output_times() {
        assert_eq!(between(&[1.0, 4.0], 3).unwrap(), [1.0, 2.0, 3.0, 4.0]);
        assert_eq!(between(&[-1.0, 2.0], 1).unwrap(), [-1.0, 0.5, 2.0]);
    }
}
