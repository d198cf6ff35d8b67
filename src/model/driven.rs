//! A body that something acts on from outside: I omega' = (I omega) x omega + gamma x (mgl com) + torque - D omega.
//!
//! Of a torque in the body the rates alone need to know; of a torque in space they need all rows of the attitude's
//! matrix, in which it is linear. Work and impulse are integrated with the motion: energy less work, and momentum
//! less impulse, stay as they are, so that a drift tells the error here too
//! (not of the exponential scheme, which makes them up from what it gained).

use super::{Drive, Free, Model, Parameters, Top, cross, direction, dot};
use crate::real::Real;

/// A body, free or with weight, under torques and damping. Without directions (a state of six numbers) there is
/// neither weight nor torque in space.
#[derive(Clone, Copy)]
pub struct Driven<R> {
    free: Free<R>,
    top: Top<R>,
    moments: [R; 3],
    weight: [R; 3],
    inverse: [R; 3],
    drive: Drive<R>,
}

/// Length of the state without directions.
const BARE: usize = 6;

/// Where work, impulse and time are in a state of that length.
const fn work(d: usize) -> usize {
    d - 3
}
const fn impulse(d: usize) -> usize {
    d - 2
}
const fn time(d: usize) -> usize {
    d - 1
}

impl<R: Real> Driven<R> {
    /// The torque that is there without motion: that in the body, and the parts of that in space along the rows.
    #[inline(always)]
    fn torques_at(&self, time: R) -> [[R; 3]; 2] {
        let mut at = [self.drive.body[0], self.drive.space[0]];
        for i in 0..3 {
            at[0][i] = time.fma(self.drive.body[1][i], at[0][i]);
            at[1][i] = time.fma(self.drive.space[1][i], at[1][i]);
        }
        at
    }

    /// sum -= D omega.
    #[inline(always)]
    fn damp<const D: usize>(&self, y: &[R; D], sum: &mut [R; 3]) {
        let [d11, d22, d33, d23, d31, d12] = self.drive.damping;
        let [w1, w2, w3] = [y[0], y[1], y[2]];
        *sum = [
            d31.fnma(w3, d12.fnma(w2, d11.fnma(w1, sum[0]))),
            d23.fnma(w3, d22.fnma(w2, d12.fnma(w1, sum[1]))),
            d33.fnma(w3, d23.fnma(w2, d31.fnma(w1, sum[2]))),
        ];
    }
}

/// sum += a torque in space, seen from the body.
#[inline(always)]
fn add_seen<R: Real, const D: usize>(torque: &[R; 3], y: &[R; D], sum: &mut [R; 3]) {
    // The third row of the matrix comes first in the state: it is the vertical.
    for (part, row) in [(torque[2], 0), (torque[0], 1), (torque[1], 2)] {
        let row = direction(y, row);
        for i in 0..3 {
            sum[i] = part.fma(row[i], sum[i]);
        }
    }
}

impl<R: Real> Model<R> for Driven<R> {
    const DRIVEN: bool = true;

    #[inline(always)]
    fn new(p: &Parameters<R>) -> Self {
        Self::driven(p, &Drive::none())
    }
    #[inline(always)]
    fn driven(p: &Parameters<R>, drive: &Drive<R>) -> Self {
        let one = R::splat(1.0);
        let [i1, i2, i3] = p.moments;
        let inverse = [one / i1, one / i2, one / i3];
        Driven {
            free: Free::new(p),
            top: Top::new(p),
            moments: p.moments,
            weight: p.weight,
            inverse,
            drive: *drive,
        }
    }
    #[inline(always)]
    fn euler<const D: usize>(&self, products: &[R; 3], y: &[R; D]) -> [R; 3] {
        if D == BARE { self.free.euler(products, y) } else { self.top.euler(products, y) }
    }
    #[inline(always)]
    fn acceleration<const D: usize>(&self, omega: &[R; 3], y: &[R; D]) -> [R; 3] {
        let [w1, w2, w3] = *omega;
        let mut rate = self.euler(&[w2 * w3, w3 * w1, w1 * w2], y);
        let outside = self.over_moments(&self.outside(y));
        for i in 0..3 {
            rate[i] = rate[i] + outside[i];
        }
        rate
    }
    #[inline(always)]
    fn undamped<const D: usize>(&self, y: &[R; D]) -> [R; 3] {
        let [mut sum, space] = self.torques_at(y[time(D)]);
        if D != BARE {
            add_seen(&space, y, &mut sum);
        }
        sum
    }
    #[inline(always)]
    fn forcing<const D: usize>(&self, y: &[R; D]) -> [R; 3] {
        let mut sum = self.undamped(y);
        let omega = [y[0], y[1], y[2]];
        let mut momentum = omega;
        for i in 0..3 {
            momentum[i] = momentum[i] * self.moments[i];
        }
        let mut whole = cross(&momentum, &omega);
        if D != BARE {
            let weight = cross(&direction(y, 0), &self.weight);
            for i in 0..3 {
                whole[i] = whole[i] + weight[i];
            }
        }
        for i in 0..3 {
            sum[i] = sum[i] + whole[i];
        }
        sum
    }
    #[inline(always)]
    fn outside<const D: usize>(&self, y: &[R; D]) -> [R; 3] {
        let mut sum = self.undamped(y);
        self.damp(y, &mut sum);
        sum
    }
    #[inline(always)]
    fn outside_of_order<const D: usize>(&self, start: &[R; D], now: &[R; D], before: &[R; D]) -> [R; 3] {
        // The series of the time ends after order 1; so does that of a torque in the body.
        let mut sum = self.drive.body[1];
        for i in 0..3 {
            sum[i] = sum[i] * now[time(D)];
        }
        if D != BARE {
            // (a + b t) times the row: a row[k] + b row[k - 1] step; the row before is given times the step.
            let space = self.torques_at(start[time(D)])[1];
            add_seen(&space, now, &mut sum);
            add_seen(&self.drive.space[1], before, &mut sum);
        }
        self.damp(now, &mut sum);
        sum
    }
    #[inline(always)]
    fn over_moments(&self, torque: &[R; 3]) -> [R; 3] {
        [torque[0] * self.inverse[0], torque[1] * self.inverse[1], torque[2] * self.inverse[2]]
    }
    #[inline(always)]
    fn balance<const D: usize>(&self, torque: &[R; 3], y: &[R; D]) -> [R; 2] {
        let omega = [y[0], y[1], y[2]];
        let impulse = if D == BARE {
            let mut momentum = omega;
            for i in 0..3 {
                momentum[i] = momentum[i] * self.moments[i];
            }
            let half = dot(torque, &momentum);
            half + half
        } else {
            dot(torque, &direction(y, 0))
        };
        [dot(torque, &omega), impulse]
    }
    #[inline(always)]
    fn kick<const D: usize>(p: &Parameters<R>, h: R, momentum: &mut [R; 3], y: &[R; D]) {
        if D != BARE {
            Top::kick(p, h, momentum, y);
        }
    }
    #[inline(always)]
    fn gradient_kick<const D: usize>(p: &Parameters<R>, h: R, weight: R, momentum: &mut [R; 3], y: &[R; D]) {
        if D != BARE {
            Top::gradient_kick(p, h, weight, momentum, y);
        }
    }
    #[inline(always)]
    fn torque<const D: usize>(p: &Parameters<R>, y: &[R; D]) -> [R; 3] {
        if D == BARE { Free::torque(p, y) } else { Top::torque(p, y) }
    }
    #[inline(always)]
    fn potential<const D: usize>(p: &Parameters<R>, y: &[R; D]) -> R {
        let weight = if D == BARE { R::splat(0.0) } else { Top::potential(p, y) };
        weight - y[work(D)]
    }
    #[inline(always)]
    fn conserved<const D: usize>(momentum: &[R; 3], y: &[R; D]) -> R {
        let whole = if D == BARE { Free::conserved(momentum, y) } else { Top::conserved(momentum, y) };
        whole - y[impulse(D)]
    }
}
