//! The driver of lanes: bodies are integrated side by side, and a lane whose body is finished gets the next one.

use crate::error::Error;
use crate::simd::LANES;

/// What is integrated in lanes: it says what to load, when to look, and what to record.
pub trait Job {
    /// The body of a lane, and what is known of its motion.
    type Task;
    /// Loads the next body that waits into a lane; `None` if none waits.
    fn load(&mut self, lane: usize) -> Result<Option<Self::Task>, Error>;
    /// Advances all lanes until one is to be looked at.
    fn advance(&mut self, tasks: &[Option<Self::Task>; LANES]) -> Result<(), Error>;
    /// Records what a lane has reached. Whether its body moves on; if not, the lane is inactive.
    fn look(&mut self, lane: usize, task: &mut Self::Task) -> Result<bool, Error>;
}

/// Does a job. It ends if `load` has finitely many bodies and `look` lets none move on for ever: each job counts its steps
/// against a limit, or its stops.
#[inline]
pub fn drive<J: Job>(job: &mut J) -> Result<(), Error> {
    let mut tasks: [Option<J::Task>; LANES] = [const { None }; LANES];
    loop {
        for (lane, task) in tasks.iter_mut().enumerate() {
            if task.is_none() {
                *task = job.load(lane)?;
            }
        }
        if tasks.iter().all(Option::is_none) {
            return Ok(());
        }
        job.advance(&tasks)?;
        for (lane, place) in tasks.iter_mut().enumerate() {
            if let Some(task) = place
                && !job.look(lane, task)?
            {
                *place = None;
            }
        }
    }
}
