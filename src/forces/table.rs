//! The table of a torque over time, linear between its times: one torque in the body and one in space.

use crate::error::Error;
use crate::kinematics::direction;
use crate::real::Real;

/// The table of one body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Table<'a> {
    /// Times of the values, ascending; two equal times are a jump. Empty for constant torques.
    pub times: &'a [f64],
    /// Torque in the body and torque in space at each time; empty if no torque is applied.
    pub values: &'a [[[f64; 3]; 2]],
}

/// Adds a torque in space, in body components, to `sum`.
#[inline(always)]
pub fn add_space_torque<R: Real, const D: usize>(torque: &[R; 3], y: &[R; D], sum: &mut [R; 3]) {
    // The third row of the matrix, the vertical, comes first in the state.
    for (part, row) in [(torque[2], 0), (torque[0], 1), (torque[1], 2)] {
        let row = direction(y, row);
        for i in 0..3 {
            sum[i] = part.fma(row[i], sum[i]);
        }
    }
}

/// Refuses impossible times and torques of any number of tables.
///
/// # Errors
/// If a number is not finite, if the times descend, or if there is not one value for each time.
pub(super) fn check(times: &[f64], body: &[[f64; 3]], space: &[[f64; 3]]) -> Result<(), Error> {
    let refuse = |argument, value: String, rule| Err(Error::Value { argument, value, rule });
    let wanted = times.len().max(1);
    for values in [body, space] {
        if !values.len().is_multiple_of(wanted) || values.len() != body.len() {
            let (expected, got) = (format!("({wanted}, 3)"), format!("({}, 3)", values.len()));
            return Err(Error::Shape { argument: "torque", expected, got });
        }
        if let Some(&bad) = values.iter().flatten().find(|x| !x.is_finite()) {
            return refuse("torque", bad.to_string(), "must be finite");
        }
    }
    if let Some(&bad) = times.iter().find(|x| !x.is_finite()) {
        return refuse("torque times", bad.to_string(), "must be finite");
    }
    if let Some(pair) = times.windows(2).find(|pair| pair[1] < pair[0]) {
        return refuse("torque times", format!("{pair:?}"), "must be ascending");
    }
    if let Some(three) = times.windows(3).find(|three| three[0] == three[2]) {
        return refuse("torque times", format!("{three:?}"), "at most two values may share a time");
    }
    if times.len() == 1 {
        return refuse("torque times", times[0].to_string(), "a table has at least two times");
    }
    Ok(())
}

impl Table<'_> {
    /// No torque.
    pub const NONE: Table<'static> = Table { times: &[], values: &[] };

    /// Whether the torque is zero at all times.
    pub fn is_zero(&self) -> bool {
        self.values.iter().flatten().flatten().all(|&x| x == 0.0)
    }

    /// Whether a torque in space acts at any time.
    pub fn acts_in_space(&self) -> bool {
        self.values.iter().any(|[_, space]| space.iter().any(|&x| x != 0.0))
    }

    /// The first values; zero if no torque is applied.
    fn first(&self) -> [[f64; 3]; 2] {
        self.values.first().copied().unwrap_or_default()
    }

    /// Raises an error for a time outside the table of the torque, where the torque is unknown.
    pub fn check_reaches(&self, time: f64) -> Result<(), Error> {
        match (self.times.first(), self.times.last()) {
            (Some(&first), Some(&last)) if !(first <= time && time <= last) => Err(Error::Value {
                argument: "t",
                value: time.to_string(),
                rule: "the table of the torque does not reach this time",
            }),
            _ => Ok(()),
        }
    }

    /// The torques in the body and in space at a time, each with its rate of change.
    pub fn torques(&self, time: f64, backward: bool) -> [[[f64; 3]; 2]; 2] {
        let [mut value, mut slope] = [self.first(), [[0.0; 3]; 2]];
        if self.times.len() > 1 {
            let piece = self.piece(time, backward);
            let (begin, end) = (self.times[piece], self.times[piece + 1]);
            for f in 0..2 {
                for k in 0..3 {
                    let (from, to) = (self.values[piece][f][k], self.values[piece + 1][f][k]);
                    slope[f][k] = if end > begin { (to - from) / (end - begin) } else { 0.0 };
                    value[f][k] = from + slope[f][k] * (time - begin);
                }
            }
        }
        [[value[0], slope[0]], [value[1], slope[1]]]
    }

    /// The interval of the table that a motion enters at a time.
    fn piece(&self, time: f64, backward: bool) -> usize {
        let after = if backward {
            self.times.partition_point(|&knot| knot < time)
        } else {
            self.times.partition_point(|&knot| knot <= time)
        };
        after.clamp(1, self.times.len() - 1) - 1
    }

    /// The next knot after a time, forward or backward.
    pub fn next_knot(&self, time: f64, backward: bool) -> Option<f64> {
        if backward {
            self.times[..self.times.partition_point(|&knot| knot < time)].last().copied()
        } else {
            self.times.get(self.times.partition_point(|&knot| knot <= time)).copied()
        }
    }

    /// Whether the table of the torque has two values at a time.
    pub fn jumps_at(&self, time: f64) -> bool {
        let first = self.times.partition_point(|&knot| knot < time);
        self.times[first..].get(..2) == Some(&[time; 2][..])
    }

    /// A bound of the integral of `|I^(-1/2) torque|` between two times, which bounds the increase of the root of twice
    /// the energy. The size of a linear function is convex, so the sum of trapezoids is a bound.
    pub fn gain(&self, moments: [f64; 3], from: f64, to: f64) -> f64 {
        if self.times.is_empty() {
            return size(moments, self.first()) * (to - from).abs();
        }
        let at = |time: f64, backward: bool| {
            let [body, space] = self.torques(time, backward);
            size(moments, [body[0], space[0]])
        };
        let inner = self.times.iter().copied().filter(|&knot| from < knot && knot < to);
        let mut last = from;
        let area = |next: f64| {
            let begin = std::mem::replace(&mut last, next);
            0.5 * (at(begin, false) + at(next, true)) * (next - begin)
        };
        inner.chain(std::iter::once(to)).map(area).sum()
    }

    /// A bound of `|I^(-1/2) torque|` at all times.
    pub fn strength(&self, moments: [f64; 3]) -> f64 {
        self.values.iter().map(|&value| size(moments, value)).fold(0.0, f64::max)
    }
}

/// A bound of `|I^(-1/2) torque|` for the sum of a torque in the body and a torque in space.
fn size(moments: [f64; 3], [body, space]: [[f64; 3]; 2]) -> f64 {
    let least = moments.iter().fold(f64::INFINITY, |a, &b| a.min(b));
    let own: f64 = (0..3).map(|k| body[k] * body[k] / moments[k]).sum();
    let turned: f64 = space.iter().map(|x| x * x).sum::<f64>() / least;
    own.sqrt() + turned.sqrt()
}
