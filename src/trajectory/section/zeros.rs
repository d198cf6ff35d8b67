//! All zeros of a polynomial in [0, 1], and where it touches zero without crossing.
//!
//! The Bernstein coefficients enclose the polynomial and, by Descartes' rule, bound the number of its zeros, as their
//! differences do for its extrema. Intervals are halved until each has at most one extremum; between extrema a change of
//! sign is one zero. F. Rouillier, P. Zimmermann, J. Comput. Appl. Math. 162 (2004) 33 (doi 10.1016/j.cam.2003.08.015).

use crate::method::MAX_ORDER;

/// Most coefficients of a polynomial.
pub const TERMS: usize = MAX_ORDER + 1;

/// Halvings of an interval until what is in it counts as one point.
const DEPTH: usize = 50;

/// Terms that mostly show whether there is a zero: the others are small.
const FIRST_TERMS: usize = 9;

/// Newton steps below this are the last.
const LAST_STEP: f64 = 2e-12;

/// A zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Zero {
    /// Where it is, in [0, 1].
    pub at: f64,
    /// 1 rising, -1 falling, 0 if the polynomial touches zero as far as can be told.
    pub direction: i8,
    /// Whether an extremum beside the zero is so small that rounding may decide about the crossing.
    pub grazes: bool,
}

/// The sides on which a polynomial begins: those on which the one before has ended, so that no zero at a joint is lost
/// or found twice, whatever the rounding.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Side {
    /// Whether the values are positive.
    pub positive: bool,
    /// Whether they rise; `None` leaves this to the polynomial.
    pub rising: Option<bool>,
}

impl Side {
    /// Just after the begin of a polynomial, which may begin with a zero; numbers up to `noise` count as none.
    pub fn after_begin(powers: &[f64], noise: f64) -> Side {
        let first = |from: usize| {
            let coefficient = powers[from..].iter().find(|a| a.abs() > noise);
            coefficient.is_some_and(|&a| a > 0.0)
        };
        Side { positive: first(0), rising: Some(first(1)) }
    }
}

/// What is asked of a polynomial.
pub struct Polynomial<'a> {
    /// Its coefficients of 1, x, x², …
    pub powers: &'a [f64],
    /// The error of its values by rounding: an extremum that is smaller is one point.
    pub noise: f64,
    /// Extrema up to this size graze.
    pub near: f64,
}

impl Polynomial<'_> {
    /// Finds all zeros in ascending order, given the sides at the begin; returns whether the end is positive.
    pub fn zeros(&self, begin: Side, found: &mut impl FnMut(Zero)) -> bool {
        let end = self.powers.iter().sum::<f64>();
        let last = end >= 0.0;
        match self.at_first_sight(begin, last) {
            Some(false) => {}
            Some(true) => {
                let at = refined([0.0, 1.0], !last, |x| self.value(x));
                found(Zero { at, direction: if last { 1 } else { -1 }, grazes: false });
            }
            None => {
                let mut coefficients = [0.0; TERMS];
                let coefficients = &mut coefficients[..self.powers.len()];
                bernstein(self.powers, coefficients);
                // One definition of the end for all: the next polynomial begins with it.
                coefficients[self.powers.len() - 1] = end;
                self.zeros_of_piece(coefficients, [0.0, 1.0], begin, DEPTH, found);
            }
        }
        last
    }

    /// Whether there is a zero, exactly one, if the first terms show it: no value or no slope is zero, whatever the rest.
    fn at_first_sight(&self, begin: Side, last: bool) -> Option<bool> {
        let (head, rest) = self.powers.split_at(self.powers.len().min(FIRST_TERMS));
        let (mut error, mut slope_error) = (self.near, self.near);
        for (k, a) in rest.iter().enumerate() {
            error += a.abs();
            slope_error += (FIRST_TERMS + k) as f64 * a.abs();
        }
        let mut coefficients = [0.0; FIRST_TERMS];
        let coefficients = &mut coefficients[..head.len()];
        bernstein(head, coefficients);
        let sign = if begin.positive { 1.0 } else { -1.0 };
        if begin.positive == last && coefficients.iter().all(|b| b * sign > error) {
            return Some(false);
        }
        let slope_error = slope_error / (head.len() - 1) as f64;
        let has_slope = |sign: f64| coefficients.windows(2).all(|b| (b[1] - b[0]) * sign > slope_error);
        let rising = match (has_slope(1.0), has_slope(-1.0)) {
            (true, _) => true,
            (_, true) => false,
            _ => return None,
        };
        // At a joint an extremum may lie between the slopes of both sides.
        begin.rising.is_none_or(|before| before == rising).then_some(begin.positive != last)
    }

    /// Value and slope.
    pub fn value(&self, x: f64) -> (f64, f64) {
        let (mut value, mut slope) = (0.0, 0.0);
        for &a in self.powers.iter().rev() {
            slope = slope * x + value;
            value = value * x + a;
        }
        (value, slope)
    }

    /// Slope and curvature.
    fn slope(&self, x: f64) -> (f64, f64) {
        let (mut slope, mut curvature) = (0.0, 0.0);
        for (k, &a) in self.powers.iter().enumerate().skip(1).rev() {
            curvature = curvature * x + slope;
            slope = slope * x + k as f64 * a;
        }
        (slope, curvature)
    }

    fn zeros_of_piece(
        &self,
        b: &[f64],
        [low, high]: [f64; 2],
        begin: Side,
        depth: usize,
        found: &mut impl FnMut(Zero),
    ) {
        let (first, last) = (begin.positive, b[b.len() - 1] >= 0.0);
        if first == last && b.iter().all(|&x| x.abs() > self.near && (x >= 0.0) == first) {
            return;
        }
        let mut rising = begin.rising.unwrap_or(b[1] >= b[0]);
        let rising_first = rising;
        let mut extrema = 0;
        for i in 1..b.len() - 1 {
            let next = b[i + 1] >= b[i];
            extrema += usize::from(next != rising);
            rising = next;
        }
        let direction = if last { 1 } else { -1 };
        let mut crossing = |ends: [f64; 2], to: bool, grazes: bool| {
            let at = refined(ends, !to, |x| self.value(x));
            found(Zero { at, direction: if to { 1 } else { -1 }, grazes });
        };
        match extrema {
            0 if first != last => crossing([low, high], last, false),
            0 => {}
            1 => {
                let top = refined([low, high], rising_first, |x| self.slope(x));
                let (extreme, _) = self.value(top);
                let (side, grazes) = (extreme >= 0.0, extreme.abs() <= self.near);
                if first != last {
                    let ends = if side == first { [top, high] } else { [low, top] };
                    crossing(ends, last, grazes);
                } else if side != first && extreme.abs() > self.noise {
                    crossing([low, top], side, grazes);
                    crossing([top, high], last, grazes);
                } else if grazes {
                    found(Zero { at: top, direction: 0, grazes });
                }
            }
            _ if depth == 0 => {
                let direction = if first == last { 0 } else { direction };
                found(Zero { at: low + 0.5 * (high - low), direction, grazes: true });
            }
            _ => {
                let (mut left, mut right) = ([0.0; TERMS], [0.0; TERMS]);
                let (left, right) = (&mut left[..b.len()], &mut right[..b.len()]);
                halves(b, left, right);
                let middle = low + 0.5 * (high - low);
                // The slope in the middle, as the left half sees it.
                let rising = Some(left[b.len() - 1] >= left[b.len() - 2]);
                self.zeros_of_piece(left, [low, middle], begin, depth - 1, found);
                let begin = Side { positive: right[0] >= 0.0, rising };
                self.zeros_of_piece(right, [middle, high], begin, depth - 1, found);
            }
        }
    }
}

/// The Bernstein coefficients on [0, 1].
fn bernstein(powers: &[f64], coefficients: &mut [f64]) {
    let degree = powers.len() - 1;
    let mut binomial = 1.0;
    for (k, &a) in powers.iter().enumerate() {
        coefficients[k] = a / binomial;
        binomial = binomial * (degree - k) as f64 / (k + 1) as f64;
    }
    for row in 1..=degree {
        for i in (row..=degree).rev() {
            coefficients[i] += coefficients[i - 1];
        }
    }
}

/// The Bernstein coefficients on both halves, by de Casteljau's rule.
fn halves(b: &[f64], left: &mut [f64], right: &mut [f64]) {
    let n = b.len();
    right.copy_from_slice(b);
    for row in 0..n {
        left[row] = right[0];
        for i in 0..n - 1 - row {
            right[i] = 0.5 * (right[i] + right[i + 1]);
        }
    }
}

/// The zero between two ends, given whether the function is positive at the lower: Newton steps, and halvings where they
/// leave the ends.
fn refined([mut low, mut high]: [f64; 2], positive: bool, function: impl Fn(f64) -> (f64, f64)) -> f64 {
    let ends = [function(low).0, function(high).0];
    let share = ends[0] / (ends[0] - ends[1]);
    let mut x = low + if share > 0.0 && share < 1.0 { share } else { 0.5 } * (high - low);
    for _ in 0..2 * DEPTH {
        let (value, slope) = function(x);
        if (value >= 0.0) == positive {
            low = x;
        } else {
            high = x;
        }
        let next = x - value / slope;
        // A NaN is not inside.
        let inside = low <= next && next <= high;
        let next = if inside { next } else { low + 0.5 * (high - low) };
        let step = (next - x).abs();
        x = next;
        if (inside && step < LAST_STEP) || high - low < f64::EPSILON * 0.25 {
            break;
        }
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The polynomial with these zeros.
    fn with_zeros(zeros: &[f64]) -> Vec<f64> {
        let mut powers = vec![1.0];
        for &zero in zeros {
            let mut next = vec![0.0; powers.len() + 1];
            for (k, &a) in powers.iter().enumerate() {
                next[k + 1] += a;
                next[k] -= zero * a;
            }
            powers = next;
        }
        powers
    }

    fn all(powers: &[f64], near: f64) -> Vec<Zero> {
        let mut found = Vec::new();
        let polynomial = Polynomial { powers, noise: 1e-15, near };
        polynomial.zeros(Side::after_begin(powers, 1e-15), &mut |zero| found.push(zero));
        found
    }

    #[test]
    fn every_zero_inside_is_found_and_no_other() {
        let inside = [0.1, 0.101, 0.35, 0.6, 0.97];
        let found =
            all(&with_zeros(&[-0.3, 1.2, inside[0], inside[1], inside[2], inside[3], inside[4]]), 1e-15);
        assert_eq!(found.len(), inside.len());
        for (zero, expected) in found.iter().zip(inside) {
            // The polynomial is of the order of 1e-6 between the close zeros: rounding moves them.
            assert!((zero.at - expected).abs() < 1e-11, "{zero:?} is not {expected}");
            assert!(!zero.grazes);
        }
        let directions: Vec<_> = found.iter().map(|zero| zero.direction).collect();
        assert!(directions.windows(2).all(|pair| pair[0] == -pair[1]), "{directions:?}");
    }

    #[test]
    fn a_double_zero_grazes() {
        let found = all(&with_zeros(&[0.4, 0.4, 1.5]), 1e-13);
        assert_eq!(found.len(), 1);
        assert!(found[0].grazes && (found[0].at - 0.4).abs() < 1e-7, "{found:?}");
        let misses = with_zeros(&[0.4, 0.4])
            .iter()
            .enumerate()
            .map(|(k, a)| a + if k == 0 { 1e-9 } else { 0.0 })
            .collect::<Vec<_>>();
        assert_eq!(all(&misses, 1e-13), []);
        assert_eq!(all(&misses, 1e-8).len(), 1);
    }

    #[test]
    fn the_side_of_the_begin_decides_at_a_joint() {
        let powers = [0.0, 1.0];
        let polynomial = Polynomial { powers: &powers, noise: 1e-15, near: 1e-13 };
        for (positive, count) in [(true, 0), (false, 1)] {
            let mut found = Vec::new();
            polynomial.zeros(Side { positive, rising: Some(true) }, &mut |zero: Zero| found.push(zero.at));
            assert_eq!(found, vec![0.0; count]);
        }
        // A zero at the begin is not one after it.
        assert_eq!(all(&powers, 1e-13), []);
        assert_eq!(all(&[0.0, 0.0, -1.0], 1e-13), []);
    }
}
