//! Deviation vectors of a body made orthogonal: what they span, however much they grow and align.

use crate::observe::Deviation;
use crate::real::{Outlined, Real};
use crate::simd::Isa;
use crate::special::ln;

/// Most deviation vectors of a body: the rates and the rotation vector have six components.
pub const MAX_DEVIATIONS: usize = 6;

/// The deviation vectors that began with given vectors are `O U`: the columns of O are orthogonal and near one in size,
/// U is upper triangular. Element (j, i) of U is `upper[j][i] 2^column[i]`, and 2^diagonal[i] on the diagonal, so that
/// what has aligned beyond the digits of a double is still known.
#[derive(Clone, Copy)]
pub struct Frame {
    count: usize,
    isa: Isa,
    upper: [[f64; MAX_DEVIATIONS]; MAX_DEVIATIONS],
    column: [i64; MAX_DEVIATIONS],
    diagonal: [i64; MAX_DEVIATIONS],
}

/// Mantissa in [1, 2) and exponent of a positive number.
#[inline(always)]
fn parts(x: f64) -> (f64, i64) {
    let (mantissa, exponent) = x.frexp();
    (mantissa, exponent as i64)
}

/// `x 2^n`, zero if it is less than any double.
#[inline(always)]
pub(super) fn times_power_of_two(x: f64, n: i64) -> f64 {
    // Two factors, so that neither leaves the range of normal numbers.
    let n = n.clamp(-2000, 2000);
    let half = n / 2;
    x * f64::from_bits(((1023 + half) as u64) << 52) * f64::from_bits(((1023 + n - half) as u64) << 52)
}

#[inline(always)]
fn product(a: &[f64; 6], b: &[f64; 6]) -> f64 {
    let mut sum = 0.0;
    for k in 0..6 {
        sum = a[k].mul_add(b[k], sum);
    }
    sum
}

impl Frame {
    /// So many deviation vectors at their start. Each instruction set gives the same bits.
    pub fn new(count: usize, isa: Isa) -> Frame {
        let mut upper = [[0.0; MAX_DEVIATIONS]; MAX_DEVIATIONS];
        for i in 0..MAX_DEVIATIONS {
            upper[i][i] = 1.0;
        }
        let zeros = [0; MAX_DEVIATIONS];
        Frame { count, isa, upper, column: zeros, diagonal: zeros }
    }

    /// Number of deviation vectors.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Makes deviation vectors orthogonal to those before them (modified Gram-Schmidt) and returns the power of two by
    /// which each was divided. The first is only divided. `norm` measures them; `gamma` is that of the body.
    pub fn renormalise(
        &mut self,
        norm: &Deviation,
        gamma: &[f64; 3],
        deviations: &mut [[f64; 6]],
    ) -> [i64; MAX_DEVIATIONS] {
        self.isa.call_with_fma(Renormalisation { frame: self, norm, gamma, deviations })
    }

    /// Multiplies U from the left by the factors of a round.
    #[inline(always)]
    fn advance(&mut self, factors: &[[f64; MAX_DEVIATIONS]; MAX_DEVIATIONS], shifts: &[i64; MAX_DEVIATIONS]) {
        for i in 0..self.count {
            let on_diagonal = times_power_of_two(1.0, self.diagonal[i] - self.column[i]);
            let (mut next, mut largest) = ([0.0; MAX_DEVIATIONS], 0.0_f64);
            for j in 0..i {
                let mut sum = factors[j][i].mul_add(on_diagonal, self.upper[j][i]);
                for l in j + 1..i {
                    sum = factors[j][l].mul_add(self.upper[l][i], sum);
                }
                next[j] = times_power_of_two(sum, shifts[j]);
                largest = largest.max(next[j].abs());
            }
            self.diagonal[i] += shifts[i];
            let mut shift = self.diagonal[i] - self.column[i];
            if largest > f64::MIN_POSITIVE && largest.is_finite() {
                shift = shift.max(parts(largest).1);
            }
            self.column[i] += shift;
            for j in 0..i {
                self.upper[j][i] = times_power_of_two(next[j], -shift);
            }
        }
    }

    /// Logarithms of the sizes that the deviation vectors keep across those before them: the diagonal of R in
    /// `deviations = Q R`, whose means over the time are the Lyapunov exponents. Not less those of the start.
    pub fn log_diagonal(
        &self,
        norm: &Deviation,
        gamma: &[f64; 3],
        deviations: &[[f64; 6]],
    ) -> [f64; MAX_DEVIATIONS] {
        let mut logs = [f64::NAN; MAX_DEVIATIONS];
        for i in 0..self.count {
            let own = norm.measured(&deviations[i], gamma);
            logs[i] = log_size(product(&own, &own), self.diagonal[i]);
        }
        logs
    }

    /// Logarithms of GALI_2, GALI_3, …: of the volumes that the first deviation vectors span, each of length one
    /// (Skokos, Bountis & Antonopoulos 2007, doi 10.1016/j.physd.2007.04.004); and SALI, the smaller of the lengths of
    /// the sum and the difference of the first two (Skokos 2001, doi 10.1088/0305-4470/34/47/309).
    pub fn alignment(
        &self,
        norm: &Deviation,
        gamma: &[f64; 3],
        deviations: &[[f64; 6]],
    ) -> ([f64; MAX_DEVIATIONS], f64) {
        let (mut logs, mut sali) = ([f64::NAN; MAX_DEVIATIONS], f64::NAN);
        let mut squares = [0.0; MAX_DEVIATIONS];
        let mut volume = 0.0;
        for i in 0..self.count {
            let own = norm.measured(&deviations[i], gamma);
            squares[i] = product(&own, &own);
            // The size across those before, and along them, in units of 2^column.
            let across = times_power_of_two(1.0, self.diagonal[i] - self.column[i]) * squares[i].sqrt();
            let along: f64 = (0..i).map(|j| self.upper[j][i].powi(2) * squares[j]).sum();
            let length2 = across.mul_add(across, along);
            volume += log_size(squares[i], self.diagonal[i]) - log_size(length2, self.column[i]);
            logs[i] = volume;
            if i == 1 {
                // Of unit vectors at the angle a: 2 sin(a / 2) = sin(a) sqrt(2 / (1 + cos(a))), a acute.
                let cosine = (along / length2).sqrt();
                sali = crate::special::exp(volume) * (2.0 / (1.0 + cosine)).sqrt();
            }
        }
        (logs, sali)
    }
}

/// One round of [`Frame::renormalise`].
struct Renormalisation<'a> {
    frame: &'a mut Frame,
    norm: &'a Deviation,
    gamma: &'a [f64; 3],
    deviations: &'a mut [[f64; 6]],
}

impl Outlined for Renormalisation<'_> {
    type Out = [i64; MAX_DEVIATIONS];
    #[inline(always)]
    fn run(self) -> [i64; MAX_DEVIATIONS] {
        let Renormalisation { frame, norm, gamma, deviations } = self;
        let mut shifts = [0; MAX_DEVIATIONS];
        let (mut measured, mut squares) = ([[0.0; 6]; MAX_DEVIATIONS], [0.0; MAX_DEVIATIONS]);
        // The factors of this round: unit upper triangular.
        let mut factors = [[0.0; MAX_DEVIATIONS]; MAX_DEVIATIONS];
        for i in 0..frame.count {
            let mut own = norm.measured(&deviations[i], gamma);
            for j in 0..i {
                let factor = product(&measured[j], &own) / squares[j];
                factors[j][i] = factor;
                for k in 0..6 {
                    deviations[i][k] = (-factor).mul_add(deviations[j][k], deviations[i][k]);
                    own[k] = (-factor).mul_add(measured[j][k], own[k]);
                }
            }
            (measured[i], squares[i]) = (own, product(&own, &own));
        }
        for i in 0..frame.count {
            let square = squares[i];
            // Half of the exponent, rounded down.
            shifts[i] = if square > 0.0 && square.is_finite() { parts(square).1.div_euclid(2) } else { 0 };
            for k in 0..6 {
                deviations[i][k] = times_power_of_two(deviations[i][k], -shifts[i]);
            }
        }
        frame.advance(&factors, &shifts);
        shifts
    }
}

/// ln of `sqrt(square) 2^exponent`.
fn log_size(square: f64, exponent: i64) -> f64 {
    if !(square >= f64::MIN_POSITIVE && square.is_finite()) {
        return if square == 0.0 { f64::NEG_INFINITY } else { f64::NAN };
    }
    let (mantissa, own) = parts(square);
    0.5 * ((own + 2 * exponent) as f64).mul_add(std::f64::consts::LN_2, ln(mantissa))
}
