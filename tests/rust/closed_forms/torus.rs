//! Jacobi functions on the torus, against other code.

use super::*;

/// On both sides of 1/2, where the nome is largest and the series change.
const COMPLEMENTS: [f64; 18] = [
    1e-30,
    1e-20,
    1e-16,
    1e-12,
    1e-8,
    1e-5,
    1e-3,
    0.03,
    0.2,
    0.45,
    0.499,
    0.499_999,
    0.5,
    0.501,
    0.6,
    0.9,
    1.0 - 1e-9,
    1.0,
];

/// sn, cn and dn.
fn functions(torus: &Torus<f64>, phase: &Phase<f64>) -> [f64; 3] {
    let (numerators, denominator) = torus.series(phase, &torus.multiples(phase));
    [0, 1, 2].map(|i| torus.quotient[i] * numerators[i] / denominator)
}

/// sn, cn and dn as quotients of theta series, with the phase counted in quarter periods, against `special::jacobi`,
/// which shares no code with the series.
///
/// The functions of `special::jacobi` are within 5 ulp; here twelve more operations on series of the first order give
/// no larger error. Both shift the argument: by 4 roundings there, by 6 of the rate, the product and the quarter period
/// here.
#[test]
fn theta_quotients_are_jacobi_functions() {
    let mut worst = 0.0_f64;
    for mc in COMPLEMENTS {
        let torus = Torus::new(1.0 - mc, mc, 0.0);
        let quarter = complete_k(mc);
        for k in -120..=120 {
            let u = quarter * (0.043 * f64::from(k) + 1e-4);
            let start = Phase { quarters: 0.0, rest: 0.0 };
            let phase = torus.advance(&start, torus.scale, u);
            assert!(phase.rest.abs() <= 0.5 * torus.quarter() * (1.0 + 4.0 * EPS), "mc = {mc:e}, u = {u:e}");
            let got = functions(&torus, &phase);
            let (sn, cn, dn) = jacobi(u, mc);
            let slopes = [cn * dn, sn * dn, (1.0 - mc) * sn * cn];
            for (i, (got, expected)) in got.into_iter().zip([sn, cn, dn]).enumerate() {
                let allowed = 10.0 * EPS * expected.abs() + 10.0 * 0.5 * EPS * u.abs() * slopes[i].abs();
                let part = (got - expected).abs() / allowed;
                assert!(part <= 1.0, "{i} of jacobi({u:e}, {mc:e}): {got:e} and {expected:e}, part {part}");
                worst = worst.max(part);
            }
        }
    }
    println!("part of the bound: {worst:.2}");
}

/// The phase from sn, cn and dn equals the phase of these functions, also close to either end of the quarter period.
///
/// Each function is within 5 ulp, which the integral of the first kind turns into at most 20 ulp of the argument (see
/// `the_integral_inverts_the_functions`), measured from the nearer end; the scale adds 4.
#[test]
fn the_phase_of_jacobi_functions() {
    for mc in COMPLEMENTS {
        let torus = Torus::new(1.0 - mc, mc, 0.0);
        for part in [0.0, 1e-12, 1e-3, 0.1, 0.3, 0.49, 0.51, 0.8, 0.999, 1.0 - 1e-12, 1.0] {
            for sign in [1.0, -1.0] {
                // Measured from the far end if that is nearer, so that the small distance is known too.
                let far = part > 0.5;
                let rest = torus.quarter() * if far { part - 1.0 } else { part };
                let at = Phase { quarters: if far { sign } else { 0.0 }, rest: sign * rest };
                let [sn, cn, dn] = functions(&torus, &at);
                let found = torus.phase(sn, cn, dn, [torus.reduced, torus.unit]);
                let apart = (found.quarters - at.quarters) * torus.quarter() + (found.rest - at.rest);
                // In the middle the phase may be measured from the other end, at the same distance.
                let length = at.rest.abs().max(found.rest.abs());
                assert!(
                    apart.abs() <= 24.0 * EPS * length,
                    "mc = {mc:e}, part {part}: {} eps",
                    apart / length / EPS
                );
            }
        }
    }
}

/// On the separatrix a phase has no quarter periods, and the functions are tanh and sech.
#[test]
fn the_torus_of_the_separatrix() {
    let torus = Torus::new(1.0, 0.0, 0.0);
    assert_eq!((torus.quarter(), torus.scale), (f64::INFINITY, 1.0));
    for u in [-30.0, -1.0, 0.0, 1e-9, 0.5, 7.0, 120.0] {
        let phase = torus.advance(&Phase { quarters: 0.0, rest: 0.0 }, 1.0, u);
        assert_eq!((phase.quarters, phase.rest), (0.0, u));
        let got = functions(&torus, &phase);
        let sech = 1.0 / u.cosh();
        for (got, expected) in got.into_iter().zip([u.tanh(), sech, sech]) {
            // The argument of exp is rounded: |u| eps/2 on both sides.
            assert!(
                (got - expected).abs() <= (10.0 + u.abs()) * EPS * expected.abs(),
                "{u}: {got} {expected}"
            );
        }
    }
}
