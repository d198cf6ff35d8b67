//! Carlson's integrals, the arithmetic-geometric mean, Jacobi's functions and their quarter period
//! against values of far more than 40 digits (tests/golden/make_elliptic.py), and against their relations.
//!
//! The bounds in ulp are the largest errors of some 1e4 random points of each function, rounded up; the table contains
//! these points.

use rigid::special::{agm, carlson_rc, carlson_rd, carlson_rf, carlson_rj, complete_k, jacobi};
use serde_json::Value;
use std::f64::consts::{FRAC_PI_2, SQRT_2};

/// A value with more digits than a double: the nearest double, and the difference in ulp.
#[derive(Clone, Copy)]
struct Golden {
    near: f64,
    miss: f64,
}

impl Golden {
    /// Error of `got` in ulp.
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
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/golden/elliptic.json");
    let file: Value = serde_json::from_reader(std::fs::File::open(path).unwrap()).unwrap();
    let row = |row: &Value| {
        let numbers: Vec<f64> = row.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect();
        let (arguments, values) = numbers.split_first_chunk::<N>().unwrap();
        (*arguments, values.chunks(2).map(|pair| Golden { near: pair[0], miss: pair[1] }).collect())
    };
    file[table].as_array().unwrap().iter().map(row).collect()
}

/// Asserts the largest error of `function` over a table, in ulp, and names the arguments.
fn within_ulps<const N: usize>(bound: f64, table: &str, function: impl Fn([f64; N]) -> f64) {
    let mut worst = (0.0, [f64::NAN; N]);
    for (x, values) in golden(table) {
        let (value, got) = (values[0], function(x));
        let error = value.ulps(got);
        assert!(error.is_finite(), "{table}{x:?} = {got:e} instead of {:e}", value.near);
        if error > worst.0 {
            worst = (error, x);
        }
    }
    println!("{table}: {:.3} ulp at {:?}", worst.0, worst.1);
    assert!(worst.0 <= bound, "{table}: {} ulp at {:?}", worst.0, worst.1);
}

/// Asserts that two results agree within a number of ulp, the sum of the bounds of both.
fn close(a: f64, b: f64, ulps: f64, what: &str) {
    assert!((a - b).abs() <= ulps * ulp(b), "{what}: {a:e} and {b:e}, {} ulp", (a - b).abs() / ulp(b));
}

#[test]
fn first_symmetric_integral() {
    within_ulps(4.0, "rf", |[x, y, z]| carlson_rf(x, y, z));
}

#[test]
fn degenerate_symmetric_integral() {
    within_ulps(6.0, "rc", |[x, y]| carlson_rc(x, y));
}

#[test]
fn second_symmetric_integral() {
    within_ulps(6.0, "rd", |[x, y, z]| carlson_rd(x, y, z));
}

#[test]
fn third_symmetric_integral() {
    within_ulps(8.0, "rj", |[x, y, z, p]| carlson_rj(x, y, z, p));
}

#[test]
fn arithmetic_geometric_mean() {
    within_ulps(4.0, "agm", |[a, b]| agm(a, b));
}

#[test]
fn quarter_period() {
    within_ulps(5.0, "complete_k", |[mc]| complete_k(mc));
}

/// sn, cn and dn: 5 ulp, and 4 roundings of the argument times the derivative, because the period has this error.
#[test]
fn elliptic_sine_cosine_and_delta() {
    let mut worst = [(0.0, [f64::NAN; 2]); 3];
    for ([u, mc], values) in golden("jacobi") {
        let (sn, cn, dn) = jacobi(u, mc);
        let [s, c, d] = [values[0].near, values[1].near, values[2].near];
        let slopes = [c * d, s * d, (1.0 - mc) * s * c];
        let rounding = 0.5 * f64::EPSILON * u.abs();
        for (i, got) in [sn, cn, dn].into_iter().enumerate() {
            let allowed = 5.0 + 4.0 * rounding * slopes[i].abs() / ulp(values[i].near);
            let part = values[i].ulps(got) / allowed;
            assert!(part.is_finite(), "jacobi({u:e}, {mc:e}): {got:e} instead of {:e}", values[i].near);
            if part > worst[i].0 {
                worst[i] = (part, [u, mc]);
            }
        }
    }
    println!("parts of the bounds of sn, cn, dn at (u, mc): {worst:?}");
    assert!(worst.iter().all(|w| w.0 <= 1.0), "{worst:?}");
}

/// The separatrix, and a pendulum of small amplitude.
#[test]
fn circular_and_hyperbolic_limits() {
    assert_eq!(jacobi(0.0, 0.3), (0.0, 1.0, 1.0));
    assert_eq!(jacobi(0.0, 0.7), (0.0, 1.0, 1.0));
    assert_eq!(complete_k(1.0), FRAC_PI_2);
    assert_eq!(complete_k(0.0), f64::INFINITY);
    let (sn, cn, dn) = jacobi(1e300, 0.0);
    assert_eq!((sn, cn), (1.0, dn));
    assert!(cn < 1e-150);
    for u in [0.1, 1.0, -7.0, 300.0] {
        // The first orders in m and mc (DLMF 22.10.4, 22.10.7) are below an ulp.
        let (sn, cn, dn) = jacobi(u, 1.0 - 0.5 * f64::EPSILON);
        let (s, c, _) = jacobi(u, 1.0);
        assert!((sn - s).abs() <= 1e-16 * u.abs() && (cn - c).abs() <= 1e-16 * u.abs());
        assert!((dn - 1.0).abs() <= f64::EPSILON);
    }
    let (sn, cn, dn) = jacobi(20.0, 1e-60);
    assert_eq!(jacobi(20.0, 0.0), (sn, cn, dn));
}

#[test]
fn symmetries_to_the_bit() {
    for ([u, mc], _) in golden("jacobi") {
        let ((sn, cn, dn), (minus_sn, minus_cn, minus_dn)) = (jacobi(u, mc), jacobi(-u, mc));
        assert_eq!((minus_sn, minus_cn, minus_dn), (-sn, cn, dn), "at {u:e}, {mc:e}");
    }
    // Powers of four change only exponents: the degrees are -1/2, -1/2 and -3/2.
    let four = 4.0_f64.powi(20);
    let two = 2.0_f64.powi(20);
    for ([x, y, z], _) in golden("rd") {
        assert_eq!(carlson_rf(four * x, four * y, four * z) * two, carlson_rf(x, y, z));
        assert_eq!(carlson_rd(four * x, four * y, four * z) * two * four, carlson_rd(x, y, z));
    }
    for ([x, y, z, p], _) in golden("rj") {
        assert_eq!(
            carlson_rj(four * x, four * y, four * z, four * p) * two * four,
            carlson_rj(x, y, z, p),
            "{x:e} {y:e} {z:e} {p:e}"
        );
        assert_eq!(carlson_rc(four * y, four * z) * two, carlson_rc(y, z));
    }
}

#[test]
fn symmetric_integrals_are_symmetric() {
    for ([x, y, z], _) in golden("rf") {
        let value = carlson_rf(x, y, z);
        close(carlson_rf(z, x, y), value, 8.0, "R_F(z, x, y)");
        close(carlson_rf(y, x, z), value, 8.0, "R_F(y, x, z)");
    }
    for ([x, y, z, p], _) in golden("rj") {
        let value = carlson_rj(x, y, z, p);
        close(carlson_rj(z, x, y, p), value, 16.0, "R_J(z, x, y, p)");
        close(carlson_rj(y, x, z, p), value, 16.0, "R_J(y, x, z, p)");
    }
    assert_eq!(carlson_rf(0.0, 0.0, 1.0), f64::INFINITY);
    assert!(carlson_rf(f64::NAN, 1.0, 1.0).is_nan());
}

#[test]
fn equal_arguments_degenerate() {
    for ([x, y, z], _) in golden("rd") {
        close(carlson_rj(x, y, z, z), carlson_rd(x, y, z), 14.0, "R_J(x, y, z, z)");
        close(carlson_rf(x, z, z), carlson_rc(x, z), 10.0, "R_F(x, z, z)");
    }
    // The lemniscate constants, DLMF 19.20.2 and 19.20.22.
    close(carlson_rf(0.0, 1.0, 2.0), 1.311_028_777_146_059_9, 4.0, "R_F(0, 1, 2)");
    close(carlson_rd(0.0, 2.0, 1.0), 1.797_210_352_103_388_3, 6.0, "R_D(0, 2, 1)");
    close(1.0 / agm(1.0, SQRT_2), 0.834_626_841_674_073_2, 4.0, "Gauss's constant");
}

/// Legendre's relation, E K' + E' K - K K' = pi/2, with E by a sum that does not cancel (DLMF 19.25.1): three products, each of two factors with errors of at most 5 ulp and
/// one rounding, and two sums. An ulp is at most 2^-52 of the value.
#[test]
fn legendre_relation() {
    for ([mc], _) in golden::<1>("complete_k") {
        let m = 1.0 - mc;
        if m < 1e-3 || mc < 1e-3 || 1.0 - m != mc {
            continue;
        }
        let (k, k_other) = (complete_k(mc), complete_k(m));
        let second = |mc: f64| mc / 3.0 * (carlson_rd(0.0, mc, 1.0) + carlson_rd(0.0, 1.0, mc));
        let (e, e_other) = (second(mc), second(m));
        let sum = e * k_other + (e_other * k - k * k_other);
        let largest = (k * k_other).max(e * k_other).max(e_other * k);
        let allowed = (3.0 * (5.0 + 5.0 + 0.5) + 2.0 * 0.5) * f64::EPSILON * largest;
        assert!((sum - FRAC_PI_2).abs() <= allowed, "mc = {mc}: {sum}");
    }
}

/// u = sn R_F(cn^2, dn^2, 1) up to half the quarter period.
///
/// The shift of the argument, 4 2^-53 |u|, is common to the three functions and returns unchanged: 2 eps. The errors of
/// the functions are 5 eps each: that of sn counts once; cn^2 and dn^2 have errors of 2 5 + 1/2, of which R_F (of
/// degree -1/2 and decreasing in each argument) keeps at most half. R_F itself has 4, the product 1/2.
#[test]
fn the_integral_inverts_the_functions() {
    for ([u, mc], _) in golden("jacobi") {
        if u.abs() > 0.5 * complete_k(mc) || u == 0.0 {
            continue;
        }
        let (sn, cn, dn) = jacobi(u, mc);
        let back = sn * carlson_rf(cn * cn, dn * dn, 1.0);
        let allowed = (2.0 + 5.0 + 0.5 * 10.5 + 4.0 + 0.5) * f64::EPSILON * u.abs();
        assert!((back - u).abs() <= allowed, "u = {u:e}, mc = {mc:e}: {back:e}");
    }
}

#[test]
fn out_of_range() {
    for mc in [0.2, 0.8] {
        for u in [1e300, f64::INFINITY, f64::NEG_INFINITY, f64::NAN] {
            let (sn, cn, dn) = jacobi(u, mc);
            assert!(sn.is_nan() && cn.is_nan() && dn.is_nan(), "jacobi({u:e}, {mc}) = {sn}, {cn}, {dn}");
        }
    }
    let (sn, cn, dn) = jacobi(1.0, f64::NAN);
    assert!(sn.is_nan() && cn.is_nan() && dn.is_nan());
}
