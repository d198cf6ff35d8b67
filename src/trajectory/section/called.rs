//! The zeros of a function of the user inside a step.
//!
//! The function is looked at sixteen places of a piece of the step, eight at once. If the polynomial through its values has
//! settled, all zeros of the polynomial are found. Else the piece is halved: at last, where the function bends or jumps,
//! changes of sign between two places count alone, each narrowed down to rounding.

use super::{NEAR, NOISE, Polynomial, Side, Surface, Zero};
use crate::forces::{EIGHT, MOST_STATES, TorqueCall, TorqueRows};
use crate::real::Real;
use crate::simd::{Arr, LANES, Row};
use crate::special::sincos;
use std::f64::consts::PI;

/// Places of a piece. A step is so short that the terms of its series fall by 4 and more, the coefficients of Chebyshev's
/// polynomials by 12: the last of these places tells rounding.
const PLACES: usize = 2 * EIGHT;

/// The degree of the polynomial through them.
const DEGREE: usize = PLACES - 1;

/// Halvings of a step until changes of sign count alone.
const DEPTH: usize = 8;

/// Largest sum of the sizes of the coefficients, in the scale of the function: it times rounding is the noise.
const LARGEST: f64 = 64.0;

/// Narrowings of a change of sign, each to a ninth: the first tell the slope, all the place.
const NARROWINGS: [usize; 2] = [3, 16];

/// What a function is told: the time, the rates, the attitude, the states and the place on the orbit.
pub struct Told {
    pub time: f64,
    pub omega: [f64; 3],
    pub attitude: [f64; 4],
    pub states: [f64; MOST_STATES],
    pub place: [f64; 3],
}

/// A function whose sign changes, in all lanes.
pub struct Called {
    rows: TorqueRows<'static>,
    direction: i8,
    /// The value that is crossed.
    value: Row,
    /// The largest size of the function until now.
    scale: Row,
    /// The error of the state, in that scale.
    error: f64,
    /// Whether the last piece ended with a positive value; `None` at the start.
    positive: [Option<bool>; LANES],
    /// The places in [0, 1]: the extrema of Chebyshev's polynomial.
    places: [f64; PLACES],
    /// Cosines of the multiples of the angle between two places.
    cosines: [f64; 2 * DEGREE],
}

type Values = [f64; PLACES];
type Eight = Arr<f64, EIGHT>;

impl Called {
    /// A function that is told all and writes its value as the first number of a torque.
    pub fn new(function: TorqueCall<'static>, direction: i8) -> Called {
        let mut rows = TorqueRows::NONE;
        (0..EIGHT).for_each(|seat| rows.set(seat, Some(function)));
        let mut cosines = [0.0; 2 * DEGREE];
        for (k, cosine) in cosines.iter_mut().enumerate() {
            *cosine = sincos(PI * k as f64 / DEGREE as f64).1;
        }
        let mut places = [0.0; PLACES];
        for (k, place) in places.iter_mut().enumerate() {
            let half = sincos(0.5 * PI * k as f64 / DEGREE as f64).0;
            *place = half * half;
        }
        places[DEGREE] = 1.0;
        Called {
            rows,
            direction,
            value: Row::ZERO,
            scale: Row::ZERO,
            error: 0.0,
            positive: [None; LANES],
            places,
            cosines,
        }
    }

    /// Puts a body into a lane.
    pub fn enter(&mut self, lane: usize, surface: &Surface) {
        self.value.0[lane] = surface.value;
        self.scale.0[lane] = surface.value.abs();
        self.positive[lane] = None;
    }

    /// Finds the wanted zeros of the last step of a lane with their slopes, by the step, NaN where the function jumps, and
    /// `Point::share`; returns whether the function has its value all along, or `None` if it is no number. `error` is that
    /// of the state, relative to its scale.
    pub fn zeros(
        &mut self,
        lane: usize,
        error: f64,
        told: &impl Fn(f64) -> Told,
        found: &mut impl FnMut(Zero, [f64; 2]),
    ) -> Option<bool> {
        self.error = error;
        let wanted = self.direction;
        self.zeros_of_piece(lane, [0.0, 1.0], DEPTH, told, &mut |zero, slope| {
            if wanted == 0 || zero.direction == 0 || zero.direction == wanted {
                found(zero, [slope, 1.0]);
            }
        })
    }

    fn zeros_of_piece(
        &mut self,
        lane: usize,
        [low, high]: [f64; 2],
        depth: usize,
        told: &impl Fn(f64) -> Told,
        found: &mut impl FnMut(Zero, f64),
    ) -> Option<bool> {
        let (width, mut values) = (high - low, [0.0; PLACES]);
        for half in 0..2 {
            let told = std::array::from_fn(|k| told(low + self.places[EIGHT * half + k] * width));
            let own = self.values::<Eight, EIGHT>(lane, told)?;
            values[EIGHT * half..][..EIGHT].copy_from_slice(&own);
        }
        let largest = values.iter().fold(self.scale.0[lane], |a, b| a.max(b.abs()));
        self.scale.0[lane] = largest;
        let near = NEAR.max(self.error) * largest;
        if values.iter().all(|x| x.abs() <= near) {
            return Some(true);
        }
        let noise = NOISE * largest;
        let coefficients = self.coefficients(&values);
        let powers = powers_of(&coefficients);
        let rest = coefficients[DEGREE].abs() + coefficients[DEGREE - 1].abs();
        let size = powers.iter().map(|a| a.abs()).sum::<f64>();
        if rest <= noise && size <= LARGEST * largest {
            let side = match self.positive[lane] {
                Some(positive) => Side { positive, rising: None },
                None => Side::after_begin(&powers, noise),
            };
            let polynomial = Polynomial { powers: &powers, noise, near };
            let positive = polynomial.zeros(side, &mut |zero| {
                let slope = polynomial.value(zero.at).1 / width;
                found(Zero { at: low + zero.at * width, ..zero }, slope);
            });
            self.positive[lane] = Some(positive);
            return Some(false);
        }
        if depth > 0 {
            let middle = low + 0.5 * width;
            let first = self.zeros_of_piece(lane, [low, middle], depth - 1, told, found)?;
            let second = self.zeros_of_piece(lane, [middle, high], depth - 1, told, found)?;
            return Some(first && second);
        }
        let mut before = (low, values[0]);
        for next in self.places.map(|x| low + x * width).into_iter().zip(values) {
            let positive = next.1 >= 0.0;
            if self.positive[lane].is_some_and(|side| side != positive) {
                let (at, slope) = self.narrowed(lane, [before, next], told)?;
                found(Zero { at, direction: if positive { 1 } else { -1 }, grazes: false }, slope);
            }
            self.positive[lane] = Some(positive);
            before = next;
        }
        Some(false)
    }

    /// The function less the value of a lane; no number where the function is none.
    pub fn value(&self, lane: usize, told: Told) -> f64 {
        self.values::<f64, 1>(lane, [told]).map_or(f64::NAN, |[value]| value)
    }

    /// The function less the value at some places; `None` if one is no number.
    fn values<R: Real, const N: usize>(&self, lane: usize, told: [Told; N]) -> Option<[f64; N]> {
        let each = |number: &dyn Fn(&Told) -> f64| {
            let numbers = told.each_ref().map(number);
            R::load(&numbers)
        };
        let calls = self.rows.of::<R>(0).expect("eight functions");
        let returned = calls.returned(
            each(&|one| one.time),
            &std::array::from_fn(|k| each(&|one| one.omega[k])),
            &std::array::from_fn(|k| each(&|one| one.attitude[k])),
            &std::array::from_fn(|k| each(&|one| one.states[k])),
            (&std::array::from_fn(|k| each(&|one| one.place[k])), false),
        );
        let mut values = [0.0; N];
        returned.torque[0].store(&mut values);
        let values = values.map(|value| value - self.value.0[lane]);
        values.iter().all(|value| value.is_finite()).then_some(values)
    }

    /// The coefficients of Chebyshev's polynomials of the polynomial through values.
    fn coefficients(&self, values: &Values) -> Values {
        std::array::from_fn(|k| {
            let mut sum = 0.0;
            for (j, value) in values.iter().enumerate() {
                let share = if j == 0 || j == DEGREE { 0.5 } else { 1.0 };
                sum += share * value * self.cosines[k * j % self.cosines.len()];
            }
            // The places ascend, so that their cosines fall.
            let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
            let share = if k == 0 || k == DEGREE { 1.0 } else { 2.0 };
            sign * share * sum / DEGREE as f64
        })
    }

    /// Just behind the change of sign between two places, which have values, and the slope there.
    fn narrowed(
        &self,
        lane: usize,
        [mut before, mut behind]: [(f64, f64); 2],
        told: &impl Fn(f64) -> Told,
    ) -> Option<(f64, f64)> {
        let (mut slope, mut early) = (f64::NAN, f64::INFINITY);
        for round in 1..=NARROWINGS[1] {
            let share = (behind.0 - before.0) / (EIGHT + 1) as f64;
            let places = std::array::from_fn(|k| before.0 + (k + 1) as f64 * share);
            let values = self.values::<Eight, EIGHT>(lane, places.map(told))?;
            for next in places.into_iter().zip(values) {
                if (next.1 >= 0.0) == (behind.1 >= 0.0) {
                    behind = next;
                    break;
                }
                before = next;
            }
            let rise = behind.1 - before.1;
            if round == NARROWINGS[0] {
                (slope, early) = (rise / (behind.0 - before.0), rise.abs());
            }
            if round == NARROWINGS[1] && rise.abs() > 0.5 * early {
                slope = f64::NAN;
            }
        }
        Some((behind.0, slope))
    }
}

/// The coefficients of powers of the place in [0, 1], from those of Chebyshev's polynomials there.
fn powers_of(coefficients: &Values) -> Values {
    let (mut powers, mut last, mut now) = ([0.0; PLACES], [0.0; PLACES], [0.0; PLACES]);
    now[0] = 1.0;
    for (k, coefficient) in coefficients.iter().enumerate() {
        (0..=k).for_each(|i| powers[i] += coefficient * now[i]);
        // Twice 2 x - 1 times this one, less the last; the first is one, the second 2 x - 1.
        let factor = if k == 0 { 1.0 } else { 2.0 };
        let next = std::array::from_fn(|i| {
            let raised = if i > 0 { 2.0 * now[i - 1] } else { 0.0 };
            factor * (raised - now[i]) - last[i]
        });
        (last, now) = (now, next);
    }
    powers
}
