//! What tables over time give: a torque in the body and one in space, the momentum of a rotor, linear between their
//! times, and the trajectory whose gravity gradient acts, a cubic spline.

use super::Trajectory;
use crate::error::{Error, refuse};
use crate::inertia::moment_range;
use crate::kinematics::{direction, dot, plain_dot};
use crate::memory;
use crate::real::Real;

/// Values at the knots of a table, of one body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Samples<'a, T> {
    /// Times of the values, ascending; empty for constant values.
    pub times: &'a [f64],
    /// The value at each time; empty if there is no table.
    pub values: &'a [T],
}

/// The tables of one body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Table<'a> {
    /// Torque in the body and torque in space. Two equal times are a jump.
    pub torque: Samples<'a, [[f64; 3]; 2]>,
    /// The momentum of the rotor relative to the body.
    pub rotor: Samples<'a, [f64; 3]>,
    /// The trajectory whose gravity gradient acts.
    pub trajectory: Samples<'a, Knot>,
    /// How much of the doubt of the trajectory is added to it.
    pub doubt: f64,
}

/// The spline of a trajectory at a knot: `sqrt(3 gm / r^3) o` in space and its slope, and by how much both are in doubt.
pub type Knot = [[f64; 3]; 4];

/// How much of the difference from the spline of every second sample is the doubt of a spline.
///
/// The error of a cubic spline falls with the fourth power of the spacing of its knots: that of every second sample is 16
/// times as large, and has the same sign. A third of the difference, 5 errors, is still an error where a table is so
/// coarse that half the spacing makes the error a quarter.
const DOUBT: f64 = 1.0 / 3.0;

/// The fewest samples of a trajectory: every second of them are five, whose spline has two pieces.
const FEWEST_SAMPLES: usize = 9;

/// The cosine of the largest angle between neighbouring samples of a trajectory, 45 degrees.
///
/// A passage that falls between two samples is in no spline. In a scan of 3000 orbits and flybys some errors were larger than
/// the doubt from 30 degrees on, most of them near an eccentricity of one, where the whole passage lies between two samples.
const NEAR: f64 = std::f64::consts::FRAC_1_SQRT_2;

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
    let wanted = times.len().max(1);
    for values in [body, space] {
        let is_missing = values.is_empty() && !times.is_empty();
        if is_missing || !values.len().is_multiple_of(wanted) || values.len() != body.len() {
            let (expected, got) = (format!("({wanted}, 3)"), format!("({}, 3)", values.len()));
            return Err(Error::Shape { argument: "torque", expected, got });
        }
        if let Some(&bad) = values.iter().flatten().find(|x| !x.is_finite()) {
            return refuse("torque", bad, "must be finite");
        }
    }
    if let Some(&bad) = times.iter().find(|x| !x.is_finite()) {
        return refuse("torque times", bad, "must be finite");
    }
    if let Some(pair) = times.windows(2).find(|pair| pair[1] < pair[0]) {
        return refuse("torque times", format_args!("{pair:?}"), "must be ascending");
    }
    if let Some(three) = times.windows(3).find(|three| three[0] == three[2]) {
        return refuse("torque times", format_args!("{three:?}"), "at most two values may share a time");
    }
    if times.len() == 1 {
        return refuse("torque times", times[0], "a table has at least two times");
    }
    Ok(())
}

/// Refuses impossible times and values of tables without jumps.
///
/// # Errors
/// If a number is not finite, if the times do not ascend, or if there are too few or not one value for each time.
pub(super) fn check_smooth(
    argument: &'static str,
    times: &[f64],
    values: &[[f64; 3]],
    fewest: usize,
) -> Result<(), Error> {
    if times.len() < fewest || values.is_empty() || !values.len().is_multiple_of(times.len()) {
        let (expected, got) = (format!("({fewest} or more, 3)"), format!("({}, 3)", values.len()));
        return Err(Error::Shape { argument, expected, got });
    }
    if let Some(&bad) = values.iter().flatten().chain(times).find(|x| !x.is_finite()) {
        return refuse(argument, bad, "must be finite");
    }
    match times.windows(2).find(|pair| !(pair[0] < pair[1])) {
        Some(pair) => {
            refuse(argument, format_args!("{pair:?}"), "the times of its table must ascend, without a jump")
        }
        None => Ok(()),
    }
}

impl<'a, T> Samples<'a, T> {
    /// Raises an error for a time outside the table, where the values are unknown.
    fn check_reaches(&self, time: f64, rule: &'static str) -> Result<(), Error> {
        match (self.times.first(), self.times.last()) {
            (Some(&first), Some(&last)) if !(first <= time && time <= last) => refuse("t", time, rule),
            _ => Ok(()),
        }
    }

    /// The interval of the table that a motion enters at a time: its begin and end, each with the value there; `None`
    /// of constant values.
    fn piece(&self, time: f64, backward: bool) -> Option<[(f64, &'a T); 2]> {
        if self.times.len() < 2 {
            return None;
        }
        let after = if backward {
            self.times.partition_point(|&knot| knot < time)
        } else {
            self.times.partition_point(|&knot| knot <= time)
        };
        let end = after.clamp(1, self.times.len() - 1);
        Some([end - 1, end].map(|k| (self.times[k], &self.values[k])))
    }

    /// The next knot after a time, forward or backward.
    fn next_knot(&self, time: f64, backward: bool) -> Option<f64> {
        if backward {
            self.times[..self.times.partition_point(|&knot| knot < time)].last().copied()
        } else {
            self.times.get(self.times.partition_point(|&knot| knot <= time)).copied()
        }
    }

    /// How many knots are between two times.
    fn knots_between(&self, first: f64, last: f64) -> usize {
        let inside = self.times.partition_point(|&knot| knot < last);
        inside.saturating_sub(self.times.partition_point(|&knot| knot <= first))
    }
}

/// The value at a time between two others, and the rate of change.
fn linear([(begin, from), (end, to)]: [(f64, &[f64; 3]); 2], time: f64) -> [[f64; 3]; 2] {
    let mut value = [[0.0; 3]; 2];
    for k in 0..3 {
        let slope = if end > begin { (to[k] - from[k]) / (end - begin) } else { 0.0 };
        value[1][k] = slope;
        value[0][k] = from[k] + slope * (time - begin);
    }
    value
}

impl Samples<'_, Knot> {
    /// The polynomial of the trajectory from a time on, with a share of its doubt.
    pub fn polynomial(&self, time: f64, backward: bool, doubt: f64) -> Trajectory<f64> {
        let mut powers = [[0.0; 3]; 4];
        let Some([(begin, from), (end, to)]) = self.piece(time, backward) else { return Trajectory(powers) };
        let (width, since) = (end - begin, time - begin);
        for i in 0..3 {
            let [[a, b], [c, d]] =
                [from, to].map(|knot| [knot[0][i] + doubt * knot[2][i], knot[1][i] + doubt * knot[3][i]]);
            let chord = (c - a) / width;
            let cubic = (b + d - 2.0 * chord) / (width * width);
            let square = (3.0 * chord - 2.0 * b - d) / width;
            powers[0][i] = a + since * (b + since * (square + since * cubic));
            powers[1][i] = b + since * (2.0 * square + 3.0 * since * cubic);
            powers[2][i] = square + 3.0 * since * cubic;
            powers[3][i] = cubic;
        }
        Trajectory(powers)
    }

    /// Bounds between two times of `|c|^2`, and of the integral of `2 |c| |c'|`, of the trajectory c.
    fn bounds(&self, [from, to]: [f64; 2]) -> [f64; 2] {
        let (mut largest, mut sum) = (0.0_f64, 0.0);
        for (times, knots) in self.times.windows(2).zip(self.values.windows(2)) {
            let [begin, end] = [times[0].max(from), times[1].min(to)];
            if begin >= end {
                continue;
            }
            // Inside the hull of its control points, as its slope is inside that of their differences.
            let (third, [a, b]) = ((times[1] - times[0]) / 3.0, [knots[0], knots[1]]);
            let point = |knot: Knot, share: f64| [0, 1, 2].map(|i| knot[0][i] + share * knot[1][i]);
            let points = [point(a, 0.0), point(a, third), point(b, -third), point(b, 0.0)];
            let square = |v: [f64; 3]| plain_dot(&v, &v);
            let size = points.iter().map(|&p| square(p)).fold(0.0, f64::max);
            let slopes = points.windows(2).map(|p| square([0, 1, 2].map(|i| (p[1][i] - p[0][i]) / third)));
            largest = largest.max(size);
            sum += 2.0 * (size * slopes.fold(0.0, f64::max)).sqrt() * (end - begin);
        }
        [largest, sum]
    }
}

impl Table<'_> {
    /// No table.
    pub const NONE: Table<'static> = Table {
        torque: Samples { times: &[], values: &[] },
        rotor: Samples { times: &[], values: &[] },
        trajectory: Samples { times: &[], values: &[] },
        doubt: 0.0,
    };

    /// Whether no table acts, not even one of zeros.
    pub fn is_none(&self) -> bool {
        self.torque.values.is_empty() && !self.acts_further()
    }

    /// Whether a rotor or a trajectory acts.
    pub fn acts_further(&self) -> bool {
        !self.rotor.values.is_empty() || !self.trajectory.values.is_empty()
    }

    /// Whether something changes with the time.
    pub fn has_knots(&self) -> bool {
        !self.torque.times.is_empty() || self.acts_further()
    }

    /// Whether there is no torque at any time: nor by a rotor whose momentum changes, nor by a trajectory.
    pub fn is_zero(&self) -> bool {
        !self.acts_further() && self.torque.values.iter().flatten().flatten().all(|&x| x == 0.0)
    }

    /// Whether a torque in space acts at any time.
    pub fn acts_in_space(&self) -> bool {
        let torque = self.torque.values.iter().any(|[_, space]| space.iter().any(|&x| x != 0.0));
        torque || !self.trajectory.values.is_empty()
    }

    /// Raises an error for a time outside a table.
    pub fn check_reaches(&self, time: f64) -> Result<(), Error> {
        self.torque.check_reaches(time, "the table of the torque does not reach this time")?;
        self.rotor.check_reaches(time, "the table of the rotor does not reach this time")?;
        self.trajectory.check_reaches(time, "the table of the orbit does not reach this time")
    }

    /// The torques in the body and in space at a time, each with its rate of change. That in the body is with what the
    /// rotor takes while its momentum changes.
    pub fn torques(&self, time: f64, backward: bool) -> [[[f64; 3]; 2]; 2] {
        let mut torques = match self.torque.piece(time, backward) {
            Some([(begin, from), (end, to)]) => {
                [0, 1].map(|f| linear([(begin, &from[f]), (end, &to[f])], time))
            }
            None => self.torque.values.first().copied().unwrap_or_default().map(|value| [value, [0.0; 3]]),
        };
        if let Some([_, change]) = self.momentum(time, backward) {
            (0..3).for_each(|k| torques[0][0][k] -= change[k]);
        }
        torques
    }

    /// The momentum of the rotor at a time, and its rate of change; `None` without its table.
    pub fn momentum(&self, time: f64, backward: bool) -> Option<[[f64; 3]; 2]> {
        self.rotor.piece(time, backward).map(|piece| linear(piece, time))
    }

    /// The largest momentum of the rotor at any time; `None` without its table.
    pub fn largest_momentum(&self) -> Option<[f64; 3]> {
        self.rotor.values.iter().copied().max_by(|a, b| plain_dot(a, a).total_cmp(&plain_dot(b, b)))
    }

    /// The next knot after a time, forward or backward.
    pub fn next_knot(&self, time: f64, backward: bool) -> Option<f64> {
        let knots = [
            self.torque.next_knot(time, backward),
            self.rotor.next_knot(time, backward),
            self.trajectory.next_knot(time, backward),
        ];
        let nearer = |a: f64, b: f64| if backward { a.max(b) } else { a.min(b) };
        knots.into_iter().flatten().reduce(nearer)
    }

    /// How many knots are between two times; those of two tables count twice.
    pub fn knots_between(&self, first: f64, last: f64) -> usize {
        let others = self.rotor.knots_between(first, last) + self.trajectory.knots_between(first, last);
        self.torque.knots_between(first, last) + others
    }

    /// Whether the table of the torque has two values at a time.
    pub fn jumps_at(&self, time: f64) -> bool {
        let times = self.torque.times;
        let first = times.partition_point(|&knot| knot < time);
        times[first..].get(..2) == Some(&[time; 2][..])
    }

    /// A bound of the integral of `|I^(-1/2) torque|` between two times, which bounds the increase of the root of twice
    /// the energy. The size of a linear function is convex, so the sum of trapezoids is a bound. Without the trajectory.
    pub fn gain(&self, moments: [f64; 3], from: f64, to: f64) -> f64 {
        let at = |time: f64, backward: bool| {
            let [body, space] = self.torques(time, backward);
            size(moments, [body[0], space[0]])
        };
        if self.torque.times.is_empty() && self.rotor.times.is_empty() {
            return at(from, false) * (to - from).abs();
        }
        let (mut last, mut sum) = (from, 0.0);
        while last < to {
            let next = self.next_knot(last, false).map_or(to, |knot| knot.min(to));
            sum += 0.5 * (at(last, false) + at(next, true)) * (next - last);
            last = next;
        }
        sum
    }

    /// The square of the bound of the root of twice the energy, if that is `root` at the start of a motion between two times on
    /// a trajectory. With the potential `c.Ic / 2` the energy changes only as c does in space; what is the same in all
    /// directions turns nothing.
    pub fn reach(&self, moments: [f64; 3], root: f64, range: [f64; 2]) -> f64 {
        if self.trajectory.values.is_empty() {
            return root;
        }
        let [largest, changes] = self.trajectory.bounds(range);
        let [least, most] = moment_range(moments);
        (root * root + (most - least) * (largest + changes)).sqrt()
    }

    /// A bound of `|I^(-1/2) torque|` at all times.
    pub fn strength(&self, moments: [f64; 3]) -> f64 {
        let none = [[0.0; 3]; 2];
        let torque = self.torque.values.iter().map(|&value| size(moments, value)).fold(0.0, f64::max);
        let knots = self.rotor.times.iter();
        let rotor = knots.map(|&knot| {
            let change = self.momentum(knot, false).map_or(none, |momentum| [momentum[1], [0.0; 3]]);
            size(moments, change)
        });
        let mut strength = torque + rotor.fold(0.0, f64::max);
        if !self.trajectory.values.is_empty() {
            let [least, most] = moment_range(moments);
            let [largest, _] = self.trajectory.bounds([f64::NEG_INFINITY, f64::INFINITY]);
            strength += 0.5 * (most - least) * largest / least.sqrt();
        }
        strength
    }
}

/// A bound of `|I^(-1/2) torque|` for the sum of a torque in the body and a torque in space.
fn size(moments: [f64; 3], [body, space]: [[f64; 3]; 2]) -> f64 {
    let [least, _] = moment_range(moments);
    let own: f64 = (0..3).map(|k| body[k] * body[k] / moments[k]).sum();
    own.sqrt() + (plain_dot(&space, &space) / least).sqrt()
}

/// The spline of a trajectory through samples of `sqrt(3 gm / r^3) o`, and its doubt.
///
/// # Errors
/// As `check_smooth`, or if the spline does not fit into memory.
pub fn spline(times: &[f64], samples: &[[f64; 3]]) -> Result<Vec<Knot>, Error> {
    const SPLINE: &str = "spline of the orbit";
    check_smooth("orbit", times, samples, FEWEST_SAMPLES)?;
    for (pair, two) in times.windows(2).zip(samples.windows(2)) {
        let [a, b] = [two[0], two[1]];
        if !(dot(&a, &b) >= NEAR * (dot(&a, &a) * dot(&b, &b)).sqrt()) {
            let rule = "between these times the direction from the planet turns by more than 45 degrees: the table tells too few positions";
            return refuse("orbit", format_args!("{pair:?}"), rule);
        }
    }
    let slopes = slopes(SPLINE, times, samples)?;
    let is_every_second = |&k: &usize| k.is_multiple_of(2) || k + 1 == times.len();
    let every_second = || (0..times.len()).filter(is_every_second);
    let count = every_second().count();
    let coarse_times = memory::collected(SPLINE, count, every_second().map(|k| times[k]))?;
    let coarse = memory::collected(SPLINE, count, every_second().map(|k| samples[k]))?;
    let coarse_slopes = self::slopes(SPLINE, &coarse_times, &coarse)?;
    let coarse = coarse.iter().zip(&coarse_slopes).map(|(&value, &slope)| [value, slope, [0.0; 3], [0.0; 3]]);
    let coarse = memory::collected(SPLINE, count, coarse)?;
    let coarse = Samples { times: coarse_times.as_slice(), values: coarse.as_slice() };
    let knot = |(k, &time): (usize, &f64)| {
        let Trajectory([value, slope, ..]) = coarse.polynomial(time, false, 0.0);
        let doubt = |fine: [f64; 3], coarse: [f64; 3]| [0, 1, 2].map(|i| DOUBT * (fine[i] - coarse[i]));
        [samples[k], slopes[k], doubt(samples[k], value), doubt(slopes[k], slope)]
    };
    memory::collected(SPLINE, times.len(), times.iter().enumerate().map(knot))
}

/// The slopes at its knots of the cubic spline without a knot at its second and last but one (C. de Boor, A Practical Guide
/// to Splines, rev. ed., 2001, ch. IV): the equations are of three neighbours each.
fn slopes(what: &str, times: &[f64], values: &[[f64; 3]]) -> Result<Vec<[f64; 3]>, Error> {
    let last = times.len() - 1;
    let width = |k: usize| times[k + 1] - times[k];
    let chord = |k: usize, i: usize| (values[k + 1][i] - values[k][i]) / width(k);
    // What is left of the next slope in the equation of each, and of the right-hand side.
    let mut next = memory::filled(what, times.len(), 0.0)?;
    let mut slopes = memory::filled(what, times.len(), [0.0; 3])?;
    let (first, second) = (width(0), width(1));
    let both = first + second;
    next[0] = both / second;
    for i in 0..3 {
        let sum = (first + 2.0 * both) * second * chord(0, i) + first * first * chord(1, i);
        slopes[0][i] = sum / (both * second);
    }
    for k in 1..last {
        let (before, after) = (width(k - 1), width(k));
        let pivot = 2.0 * (before + after) - after * next[k - 1];
        next[k] = before / pivot;
        for i in 0..3 {
            let sum = 3.0 * (after * chord(k - 1, i) + before * chord(k, i));
            slopes[k][i] = (sum - after * slopes[k - 1][i]) / pivot;
        }
    }
    let (before, after) = (width(last - 2), width(last - 1));
    let both = before + after;
    let pivot = before - both * next[last - 1];
    for i in 0..3 {
        let sum = after * after * chord(last - 2, i) + (2.0 * both + after) * before * chord(last - 1, i);
        slopes[last][i] = (sum / both - both * slopes[last - 1][i]) / pivot;
    }
    for k in (0..last).rev() {
        for i in 0..3 {
            slopes[k][i] -= next[k] * slopes[k + 1][i];
        }
    }
    Ok(slopes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cubic_is_its_own_spline() {
        let cubic = |t: f64| [t * t * t - 2.0 * t + 100.0, 3.0 - t * t, 0.5 * t * t * t];
        let times = [0.0, 0.5, 0.75, 1.5, 2.0, 3.0, 3.5, 4.5, 5.0, 6.0];
        let knots = spline(&times, &times.map(cubic)).unwrap();
        let samples = Samples { times: &times, values: &knots };
        for time in [0.1, 0.6, 2.5, 5.9] {
            let Trajectory([value, slope, ..]) = samples.polynomial(time, false, 1.0);
            for i in 0..3 {
                assert!((value[i] - cubic(time)[i]).abs() < 1e-12 * (1.0 + cubic(6.0)[i].abs()));
            }
            assert!((slope[0] - (3.0 * time * time - 2.0)).abs() < 1e-10);
        }
        assert!(spline(&times[..8], &[[1.0; 3]; 8]).is_err());
        assert!(spline(&[0.0, 1.0, 2.0, 3.0, 4.0, 4.0, 5.0, 6.0, 7.0], &[[1.0; 3]; 9]).is_err());
        let back = times.map(|t| if t < 3.0 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] });
        assert!(spline(&times, &back).unwrap_err().to_string().contains("45 degrees"));
    }

    #[test]
    fn the_doubt_of_a_spline_is_above_its_error() {
        for count in [9, 10, 17, 40, 200] {
            let times: Vec<f64> = (0..count).map(|k| 6.0 * f64::from(k) / f64::from(count - 1)).collect();
            // About a passage at distance 1.
            let root = |t: f64| {
                let square = 1.0 + (t - 3.1) * (t - 3.1);
                [1.0, t - 3.1, 0.0].map(|x| x / square.powf(1.25))
            };
            let values: Vec<[f64; 3]> = times.iter().map(|&t| root(t)).collect();
            let knots = spline(&times, &values).unwrap();
            let samples = Samples { times: &times, values: &knots };
            let [mut error, mut doubt] = [[0.0_f64; 3]; 2];
            for k in 0..1000 {
                let time = 0.006 * f64::from(k);
                let [plain, doubtful] = [0.0, 1.0].map(|doubt| samples.polynomial(time, false, doubt).0[0]);
                for i in 0..3 {
                    error[i] = error[i].max((plain[i] - root(time)[i]).abs());
                    doubt[i] = doubt[i].max((doubtful[i] - plain[i]).abs());
                }
            }
            for i in 0..2 {
                assert!(error[i] <= doubt[i] && doubt[i] <= 30.0 * error[i], "{count}: {error:?} {doubt:?}");
            }
        }
    }
}
