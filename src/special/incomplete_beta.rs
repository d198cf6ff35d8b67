//! The regularised incomplete beta function of whole numbers a and b, and its inverse.
//!
//! I_x(a, b) is the chance of a successes or more in a + b - 1 trials that each succeed with chance x.
//!
//! Power of x and beta function: C. Loader, Fast and accurate computation of binomial probabilities, 2000. Continued
//! fraction: A. R. DiDonato and A. H. Morris, ACM Trans. Math. Softw. 18 (1992) 360.

use super::{exp, ln};
use std::f64::consts::TAU;

/// ln n! - (n + 1/2) ln n + n - ln(2 pi) / 2 for n = 1, 2, …, from 40 digits.
const STIRLING_ERROR: [f64; 15] = [
    0.081_061_466_795_327_258_219_7,
    0.041_340_695_955_409_294_093_8,
    0.027_677_925_684_998_339_148_8,
    0.020_790_672_103_765_093_111_5,
    0.016_644_691_189_821_192_163_2,
    0.013_876_128_823_070_747_998_7,
    0.011_896_709_945_891_770_095_1,
    0.010_411_265_261_972_096_497_5,
    0.009_255_462_182_712_732_917_73,
    0.008_330_563_433_362_871_256_47,
    0.007_573_675_487_951_840_794_97,
    0.006_942_840_107_209_529_865_66,
    0.006_408_994_188_004_207_068_44,
    0.005_951_370_112_758_847_735_62,
    0.005_554_733_551_962_801_371_04,
];

/// The error of Stirling's formula for ln n!, absolutely below 1e-17.
fn stirling_error(n: f64) -> f64 {
    if n < 16.0 {
        return STIRLING_ERROR[n as usize - 1];
    }
    let z = 1.0 / (n * n);
    let terms = [-691.0 / 360_360.0, 1.0 / 1188.0, -1.0 / 1680.0, 1.0 / 1260.0, -1.0 / 360.0, 1.0 / 12.0];
    terms.into_iter().fold(0.0, |sum, term| z * sum + term) / n
}

/// Terms of `2 artanh v - 2 v` for |v| < 0.1: each is below a hundredth of the one before, so the last adds nothing.
const MOST_TERMS: usize = 9;

/// Fractions that are more than the continued fraction needs: half of the root of a + b, for a + b up to 2^50 4.5e5.
const MOST_FRACTIONS: f64 = 1e6;

/// More steps than Newton's method needs: 8 for any a + b up to 2^50 and any level that is one minus a double.
const MOST_STEPS: usize = 32;

/// count ln(count / mean) + mean - count without cancellation; `excess` is count - mean.
fn deviance(count: f64, mean: f64, excess: f64) -> f64 {
    let v = excess / (count + mean);
    if v.abs() >= 0.1 {
        return count * ln(count / mean) - excess;
    }
    // ln(count / mean) = 2 artanh v.
    let (mut sum, mut power, mut n) = (excess * v, 2.0 * count * v, 1.0);
    for _ in 0..MOST_TERMS {
        power *= v * v;
        n += 2.0;
        sum += power / n;
    }
    sum
}

/// ln I_x(a, b) and its derivative by ln x, for 0 < x <= (a + 1) / (a + b).
fn ln_incomplete_beta(a: f64, b: f64, x: f64) -> (f64, f64) {
    let (all, y) = (a + b, 1.0 - x);
    let excess = (-all).mul_add(x, a);
    // x^a y^b / B(a, b) is the root of ab / (2 pi (a + b)) times the exponential of this.
    let exponent = stirling_error(all)
        - stirling_error(a)
        - stirling_error(b)
        - deviance(a, all * x, excess)
        - deviance(b, all * y, -excess);
    let power = exponent + 0.5 * ln(a / all * b / TAU);
    // All terms of the fraction are positive, so it has no cancellation; it ends at m = b.
    let denominator = |m: f64| {
        let odd = (a + m) * (excess + 1.0 + m * (1.0 + y)) / (a + 2.0 * m + 1.0);
        if m == 0.0 { odd } else { m + m * (b - m) * x / (a + 2.0 * m - 1.0) + odd }
    };
    let (mut fraction, mut m) = (denominator(0.0), 0.0);
    let (mut above, mut below) = (fraction, 0.0);
    while m < b.min(MOST_FRACTIONS) {
        m += 1.0;
        let ratio = x / (a + 2.0 * m - 1.0);
        let numerator = (a + m - 1.0) * (all + m - 1.0) * m * (b - m) * ratio * ratio;
        let next = denominator(m);
        below = 1.0 / (next + numerator * below);
        above = next + numerator / above;
        fraction *= above * below;
        if (above * below - 1.0).abs() <= 4.0 * f64::EPSILON {
            break;
        }
    }
    (power - ln(fraction), fraction / y)
}

/// The x with I_x(a, b) = level, for whole a and b from 1 on and a level up to 1/2.
///
/// Relative error below 2e-15 for a + b up to 1e6.
pub fn inverse_incomplete_beta(a: f64, b: f64, level: f64) -> f64 {
    let wanted = ln(level);
    let mut x = a / (a + b);
    for _ in 0..MOST_STEPS {
        // ln I is a concave function of ln x, so Newton's steps approach the root from one side.
        let (value, slope) = ln_incomplete_beta(a, b, x);
        let step = (wanted - value) / slope;
        x *= exp(step);
        // The error after a step is of the order of the square of the step.
        if step.abs() < 1e-10 {
            break;
        }
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stirling_errors_are_those_of_factorials() {
        let mut factorial = 1.0_f64; // exact up to 22!
        for n in 1..=22 {
            let n = f64::from(n);
            factorial *= n;
            let expected = ln(factorial) - ((n + 0.5) * ln(n) - n + 0.5 * ln(TAU));
            // The terms of this difference go up to 70: an ulp of it is 1.4e-14.
            assert!((stirling_error(n) - expected).abs() < 3e-14, "{n}");
        }
    }

    #[test]
    fn the_incomplete_beta_function_is_a_binomial_sum() {
        for trials in 1..=30 {
            for least in 1..=trials {
                let (a, b) = (f64::from(least), f64::from(trials - least + 1));
                for part in [1e-3, 0.2, 0.7, 1.0] {
                    let x = part * a / (a + b);
                    let y = 1.0 - x;
                    let (mut term, mut sum) = ((0..trials).fold(1.0, |power, _| power * y), 0.0);
                    for k in 0..=trials {
                        if k >= least {
                            sum += term;
                        }
                        term *= f64::from(trials - k) / f64::from(k + 1) * x / y;
                    }
                    let (value, _) = ln_incomplete_beta(a, b, x);
                    // A hundred roundings of the products above.
                    assert!((exp(value) / sum - 1.0).abs() < 1e-13, "{trials} {least} {x}");
                }
            }
        }
    }
}
