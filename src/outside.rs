//! What acts on the bodies of a request from outside: a torque over time, and damping.

use crate::error::Error;
use crate::model::Drive;
use crate::special::exp;

/// A torque, piecewise linear in time, and linear damping.
#[derive(Clone, Debug, PartialEq)]
pub struct Outside {
    /// Ascending; two equal times are a jump. Empty for a torque that is constant.
    times: Vec<f64>,
    /// Torque in the body, and in space, at each of these times, or always.
    values: Vec<[[f64; 3]; 2]>,
    /// Entries 11, 22, 33, 23, 31, 12 of the matrix that turns rates into the torque against them.
    damping: [f64; 6],
}

impl Outside {
    /// A torque given in the body and in space at some times (none: constant), and damping.
    ///
    /// # Errors
    /// Naming the argument: numbers that are not finite, times that descend or that are not as many as the values,
    /// damping that would feed a motion.
    pub fn new(
        times: &[f64],
        body: &[[f64; 3]],
        space: &[[f64; 3]],
        damping: [f64; 6],
    ) -> Result<Outside, Error> {
        let refuse = |argument, value: String, rule| Err(Error::Value { argument, value, rule });
        let wanted = times.len().max(1);
        for values in [body, space] {
            if values.len() != wanted {
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
            return refuse("torque times", format!("{three:?}"), "a jump has two values, not more");
        }
        if times.len() == 1 {
            return refuse("torque times", times[0].to_string(), "a table has at least two times");
        }
        if !damping.iter().all(|x| x.is_finite()) {
            return refuse("damping", format!("{damping:?}"), "must be finite");
        }
        let values = body.iter().zip(space).map(|(&body, &space)| [body, space]).collect();
        let made = Outside { times: times.to_vec(), values, damping };
        let [least, .., largest] = made.damping_rates([1.0; 3]);
        // Eigenvalues are found to a few roundings of the largest.
        if least < -8.0 * f64::EPSILON * largest.abs().max(least.abs()) {
            let rule = "must be positive semi-definite: no motion may be fed by it";
            return refuse("damping", format!("{damping:?}"), rule);
        }
        Ok(made)
    }

    /// Whether a torque in space acts at any time: the rates then need the attitude.
    pub fn acts_in_space(&self) -> bool {
        self.values.iter().any(|[_, space]| space.iter().any(|&x| x != 0.0))
    }

    /// The times between which the torque changes evenly.
    pub fn knots(&self) -> &[f64] {
        &self.times
    }

    /// Refuses a time that the table of the torque does not reach: what acts there is not known.
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

    /// What acts on a body with these moments from that time on, forward or backward, until the next knot.
    pub fn drive(&self, time: f64, backward: bool, moments: [f64; 3]) -> Drive<f64> {
        let [[body, body_slope], [space, space_slope]] = self.torques(time, backward);
        let (rates, modes) = self.damping_modes(moments);
        Drive { body: [body, body_slope], space: [space, space_slope], damping: self.damping, rates, modes }
    }

    /// The torques in the body and in space then, each with its rate of change.
    fn torques(&self, time: f64, backward: bool) -> [[[f64; 3]; 2]; 2] {
        let [mut value, mut slope] = [self.values[0], [[0.0; 3]; 2]];
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

    /// The piece of the table that a motion enters at that time.
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

    /// The rates at which damping alone slows a body with these moments, ascending: the eigenvalues of
    /// `I^(-1/2) D I^(-1/2)`.
    pub fn damping_rates(&self, moments: [f64; 3]) -> [f64; 3] {
        let mut rates = self.damping_modes(moments).0;
        rates.sort_by(f64::total_cmp);
        rates
    }

    /// These eigenvalues, and their vectors as columns.
    pub fn damping_modes(&self, moments: [f64; 3]) -> ([f64; 3], [[f64; 3]; 3]) {
        let [d11, d22, d33, d23, d31, d12] = self.damping;
        let mut scaled = [[d11, d12, d31], [d12, d22, d23], [d31, d23, d33]];
        for i in 0..3 {
            for k in 0..3 {
                // The root of a square would round.
                scaled[i][k] /= if i == k { moments[i] } else { moments[i].sqrt() * moments[k].sqrt() };
            }
        }
        eigen(scaled)
    }

    /// The largest `|I^(-1/2) torque|` times its time, between two times: what the root of twice the energy can gain.
    /// The size of a linear function is convex, so the trapezoids bound it.
    fn gain(&self, moments: [f64; 3], from: f64, to: f64) -> f64 {
        if self.times.is_empty() {
            return size(moments, self.values[0]) * (to - from).abs();
        }
        let at = |time: f64, backward: bool| {
            let [body, space] = self.torques(time, backward);
            size(moments, [body[0], space[0]])
        };
        let inner = self.times.iter().copied().filter(|&knot| from < knot && knot < to);
        let mut stops: Vec<f64> = std::iter::once(from).chain(inner).collect();
        stops.push(to);
        stops.windows(2).map(|w| 0.5 * (at(w[0], false) + at(w[1], true)) * (w[1] - w[0])).sum()
    }

    /// The rate k, if nothing acts but a damping `D = k I`: it then slows all components of the momentum alike, and the
    /// motion is the free one in another time. Equal but for the rounding of the products.
    pub fn slows_evenly(&self, moments: [f64; 3]) -> Option<f64> {
        let [d11, d22, d33, ..] = self.damping;
        let still = self.values.iter().flatten().flatten().all(|&x| x == 0.0);
        let diagonal = self.damping[3..].iter().all(|&x| x == 0.0);
        let own = [d11, d22, d33];
        let fits = |&k: &f64| (0..3).all(|i| k * moments[i] == own[i]);
        (0..3).map(|i| own[i] / moments[i]).find(fits).filter(|_| still && diagonal)
    }

    /// The largest `|I^(-1/2) torque|`, at any time.
    fn strength(&self, moments: [f64; 3]) -> f64 {
        self.values.iter().map(|&value| size(moments, value)).fold(0.0, f64::max)
    }

    /// A bound of |omega| between two times around 0, from the power balance. Twice the kinetic energy at the start,
    /// the weight `mgl`, and the energy that the body can gain by falling.
    ///
    /// With `u = |I^(1/2) omega|`, `u' <= |I^(-1/2) torque| - d u`, and `|omega| <= u / sqrt(I_min)`; `d` is the least
    /// damping rate. Backward in time damping feeds the motion at the largest one.
    pub fn fastest_rate(
        &self,
        moments: [f64; 3],
        [twice_kinetic, mgl, fall]: [f64; 3],
        [first, last]: [f64; 2],
    ) -> f64 {
        let least = moments.iter().fold(f64::INFINITY, |a, &b| a.min(b));
        let [d, .., fastest] = self.damping_rates(moments);
        let (start, reach) = (twice_kinetic.sqrt(), (twice_kinetic + 2.0 * fall).sqrt());
        let mut forward = reach + self.gain(moments, 0.0, last.max(0.0));
        let mut swing = (mgl / least).sqrt();
        if d > 0.0 {
            forward = forward.min(start + (mgl / least.sqrt() + self.strength(moments)) / d);
            swing = swing.min(mgl / (least * d));
        }
        let back = first.min(0.0);
        let mut u = forward;
        if back < 0.0 {
            u = u.max((reach + self.gain(moments, back, 0.0)) * exp(-fastest.max(0.0) * back));
        }
        (u / least.sqrt()).max(swing)
    }
}

/// `|I^(-1/2) torque|` at most, of a torque in the body and one in space.
fn size(moments: [f64; 3], [body, space]: [[f64; 3]; 2]) -> f64 {
    let least = moments.iter().fold(f64::INFINITY, |a, &b| a.min(b));
    let own: f64 = (0..3).map(|k| body[k] * body[k] / moments[k]).sum();
    let turned: f64 = space.iter().map(|x| x * x).sum::<f64>() / least;
    own.sqrt() + turned.sqrt()
}

/// Eigenvalues and eigenvectors (columns) of a symmetric matrix, by plane rotations (Jacobi 1846): with nothing but
/// arithmetic and roots, so that the bits are the same everywhere.
fn eigen(mut a: [[f64; 3]; 3]) -> ([f64; 3], [[f64; 3]; 3]) {
    let mut vectors = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    // Convergence is quadratic: the off-diagonal part of any matrix is gone after five or six sweeps.
    for _ in 0..12 {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            if a[p][q] == 0.0 {
                continue;
            }
            let tau = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
            // The smaller root of t^2 + 2 tau t = 1; of a tau whose square overflows it is zero.
            let t = tau.signum() / (tau.abs() + (1.0 + tau * tau).sqrt());
            let cos = 1.0 / (1.0 + t * t).sqrt();
            let sin = t * cos;
            let (app, aqq, apq) = (a[p][p], a[q][q], a[p][q]);
            let r = 3 - p - q;
            let (apr, aqr) = (a[p][r], a[q][r]);
            a[p][p] = app - t * apq;
            a[q][q] = aqq + t * apq;
            (a[p][q], a[q][p]) = (0.0, 0.0);
            a[p][r] = cos * apr - sin * aqr;
            a[q][r] = sin * apr + cos * aqr;
            (a[r][p], a[r][q]) = (a[p][r], a[q][r]);
            for row in &mut vectors {
                let (vp, vq) = (row[p], row[q]);
                row[p] = cos * vp - sin * vq;
                row[q] = sin * vp + cos * vq;
            }
        }
    }
    ([a[0][0], a[1][1], a[2][2]], vectors)
}
