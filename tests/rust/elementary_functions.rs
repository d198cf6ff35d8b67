//! sincos, exp, ln, atan2 and the coefficients of Rodrigues' formula against 40-digit values
//! (tests/golden/make_elementary.py).

use rigid::special::{atan2, exp, ln, rodrigues, sincos, sincos_of_sum};
use serde_json::Value;
use std::f64::consts::{FRAC_PI_4, TAU};

/// A value with more digits than a double: the nearest double, and the difference in ulp.
#[derive(Clone, Copy)]
struct Golden {
    near: f64,
    miss: f64,
}

impl Golden {
    /// Error of `got` in ulp. The difference of neighbours and the division by a power of two are exact.
    fn ulps(self, got: f64) -> f64 {
        ((got - self.near) / ulp(self.near) - self.miss).abs()
    }
}

/// Distance from |x| to the next larger double.
fn ulp(x: f64) -> f64 {
    x.abs().next_up() - x.abs()
}

/// The rows of a table: N arguments, then the values.
fn golden<const N: usize>(table: &str) -> Vec<([f64; N], Vec<Golden>)> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/golden/elementary.json");
    let file: Value = serde_json::from_reader(std::fs::File::open(path).unwrap()).unwrap();
    let row = |row: &Value| {
        let numbers: Vec<f64> = row.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect();
        let (arguments, values) = numbers.split_first_chunk::<N>().unwrap();
        (*arguments, values.chunks(2).map(|pair| Golden { near: pair[0], miss: pair[1] }).collect())
    };
    file[table].as_array().unwrap().iter().map(row).collect()
}

/// Asserts the largest error of `function` over a table, in ulp, and names the arguments.
fn within_ulps<const N: usize>(bound: f64, table: &str, function: impl Fn([f64; N]) -> Vec<f64>) {
    let mut worst = (0.0, [f64::NAN; N]);
    for (x, values) in golden(table) {
        for (value, got) in values.iter().zip(function(x)) {
            let error = value.ulps(got);
            assert!(error.is_finite(), "{table}{x:?} = {got:e} instead of {:e}", value.near);
            if error > worst.0 {
                worst = (error, x);
            }
        }
    }
    println!("{table}: {:.3} ulp at {:?}", worst.0, worst.1);
    assert!(worst.0 <= bound, "{table}: {} ulp at {:?}", worst.0, worst.1);
}

#[test]
fn the_table_is_read_exactly() {
    // An error of an ulp in the decimal reader would look like an error of the functions.
    let ln_of_two = golden("ln").into_iter().find(|(x, _)| *x == [2.0]).unwrap().1[0];
    assert_eq!(ln_of_two.near, std::f64::consts::LN_2);
    // ln 2 = 0.693147180559945309417232121458..., 0.208881 ulp above its double.
    assert_eq!(ln_of_two.miss, 0.208_881);
    assert!(golden::<1>("exp").iter().any(|(_, v)| v[0].near == 5e-324));
}

#[test]
fn sine_and_cosine() {
    within_ulps(1.0, "sincos", |[x]| {
        let (sin, cos) = sincos(x);
        vec![sin, cos]
    });
}

/// A long phase in two parts: after the reduction the remainder is as small as its tail, or smaller.
///
/// The tail is at most half an ulp of the phase. The error of sin and cos of either part is at most an ulp, that of
/// their products and the sum three roundings, that of the function an ulp: 2 + 3/2 + 1 ulp of 1, each at most eps.
#[test]
fn sine_of_a_sum() {
    for phase in [1.0, 22.0, 355.0, 1e4, 1e6, 833_719.5, 1e8, 3e10, 1e12, 1e14_f64] {
        for near in 0..40 {
            let x = phase * (1.0 + 1e-3 * f64::from(near));
            for part in [0.5, -0.5, 0.3, -1e-3, 0.0] {
                let tail = part * ulp(x);
                let (sin, cos) = sincos_of_sum(x, tail);
                let ((s, c), (s_tail, c_tail)) = (sincos(x), sincos(tail));
                let expected = (s.mul_add(c_tail, c * s_tail), c.mul_add(c_tail, -(s * s_tail)));
                let miss = (sin - expected.0).abs().max((cos - expected.1).abs());
                assert!(miss <= 4.5 * f64::EPSILON, "{x:e} + {tail:e}: {miss:e}");
            }
        }
    }
}

#[test]
fn exponential() {
    within_ulps(1.0, "exp", |[x]| vec![exp(x)]);
}

#[test]
fn logarithm() {
    within_ulps(1.0, "ln", |[x]| vec![ln(x)]);
}

#[test]
fn angle_of_a_point() {
    within_ulps(2.0, "atan2", |[y, x]| vec![atan2(y, x)]);
}

#[test]
fn zeros() {
    for zero in [0.0, -0.0] {
        assert_eq!(sincos(zero), (0.0, 1.0));
        assert_eq!(exp(zero), 1.0);
    }
    assert_eq!(ln(1.0_f64).to_bits(), 0);
    assert_eq!(rodrigues(0.0), (1.0, 0.5));
    assert_eq!(atan2(0.0, 0.0), 0.0);
}

/// Both branches, and the limit between them, have the symmetry of the functions to the bit.
#[test]
fn sine_is_odd_and_cosine_even() {
    for ([x], _) in golden("sincos") {
        let ((s, c), (minus_s, minus_c)) = (sincos(x), sincos(-x));
        assert_eq!((minus_s, minus_c), (-s, c), "at {x:e}");
    }
}

#[test]
fn out_of_range() {
    let limit = 2.0_f64.powi(50);
    for x in [limit, -limit, 1e300, f64::INFINITY, f64::NEG_INFINITY, f64::NAN] {
        let (sin, cos) = sincos(x);
        assert!(sin.is_nan() && cos.is_nan(), "sincos({x:e}) = ({sin}, {cos})");
    }
    let (sin, cos) = sincos(limit.next_down());
    // The error of s^2 + c^2 from two values with an error of an ulp: 2 (|s| + |c|) ulp(1)/2 <= 2 sqrt(2) eps / 2.
    assert!((sin * sin + cos * cos - 1.0).abs() < 2.0 * f64::EPSILON);

    for x in [-745.2, -800.0, -1e300, f64::NEG_INFINITY] {
        assert_eq!(exp(x), 0.0, "exp({x})");
    }
    for x in [709.8, 800.0, 1e300, f64::INFINITY] {
        assert_eq!(exp(x), f64::INFINITY, "exp({x})");
    }
    assert!(exp(f64::NAN).is_nan());
}

/// sin a / a and (1 - cos a) / a^2 on both sides of the limit between series and division.
///
/// Below the limit both functions are 1 + z p(z) or 1/2 - z q(z) with a correction below half the sum: one rounding of
/// the sum, and a tenth of a rounding from the polynomial, so 1 ulp. Above the limit the angle is a rounded root with
/// an error of half an ulp, which changes sin a by |a cos a| eps/2 and the quotients by at most eps/2 and 2 eps/2 /a <=
/// 1.3 eps. With an ulp each of the sines, the product and the quotient the bound is 2.5 eps absolute (sin a / a
/// vanishes at pi, so there is no relative bound).
#[test]
fn rodrigues_on_both_sides_of_its_limit() {
    let limit = FRAC_PI_4 * FRAC_PI_4;
    let mut counts = [0; 2];
    for ([z], values) in golden("rodrigues") {
        let (first, second) = rodrigues(z);
        for (value, got) in values.iter().zip([first, second]) {
            if z <= limit {
                assert!(value.ulps(got) <= 1.0, "rodrigues({z:e}): {} ulp", value.ulps(got));
            } else {
                let error = value.ulps(got) * ulp(value.near);
                assert!(error <= 2.5 * f64::EPSILON, "rodrigues({z:e}): {:.2} eps", error / f64::EPSILON);
            }
        }
        counts[usize::from(z > limit)] += 1;
    }
    assert!(counts[0] >= 90 && counts[1] >= 90, "{counts:?} points below and above the limit");
    // An angle whose square overflows is undetermined.
    assert!(rodrigues(f64::INFINITY).0.is_nan());
    // A full turn with an error of half an ulp of the angle: its sine is as small as this error.
    assert!(rodrigues(TAU * TAU).0.abs() <= 2.5 * f64::EPSILON);
}
