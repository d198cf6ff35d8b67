//! The splittings. Only halves of palindromes are listed; the other fractions follow from sums.

use super::splitting::flow_code;
use super::{Composition, EngineName, Facts, ForcedStep, Method, Numbers, Processor, Step, power};

/// Alternating fractions of kicks and drifts: a palindrome that begins with a kick, which may be 0. The lists omit the
/// last fractions of kicks and drifts, because each kind sums to one.
const fn alternating<const N: usize>(kicks: &[f64], drifts: &[f64]) -> [f64; N] {
    let lists = [kicks, drifts];
    let mut sums = [0.0; 2];
    let mut all = [0.0; N];
    let middle = N / 2;
    let mut i = 0;
    while i <= middle {
        let list = lists[i % 2];
        all[i] = if i + 1 < middle {
            list[i / 2]
        } else if i < middle {
            0.5 - sums[i % 2]
        } else {
            1.0 - 2.0 * sums[i % 2]
        };
        sums[i % 2] += all[i];
        all[N - 1 - i] = all[i];
        i += 1;
    }
    all
}

/// Alternating fractions of kicks and drifts of a symmetric composition of steps `kick/2, drift, kick/2`; the fraction
/// of the middle step follows from the sum.
const fn composed<const N: usize>(steps: &[f64]) -> [f64; N] {
    let mut all = [0.0; N];
    let (mut last, mut sum) = (0.0, 0.0);
    let mut i = 0;
    while 2 * i <= N / 2 {
        let step = if i < steps.len() { steps[i] } else { 1.0 - 2.0 * sum };
        all[2 * i] = 0.5 * (last + step);
        all[N - 1 - 2 * i] = all[2 * i];
        if 2 * i < N / 2 {
            all[2 * i + 1] = step;
            all[N - 2 - 2 * i] = step;
        }
        sum += step;
        last = step;
        i += 1;
    }
    all
}

/// Fractions for the four parts of `PLANAR` from a splitting into two parts: sweeps through the parts, forwards and
/// backwards in turn (McLachlan, SIAM J. Sci. Comput. 16 (1995) 151). Between two sweeps, the outermost part has the
/// fraction of a kick and the innermost part that of a drift.
const fn in_four_parts<const N: usize, const M: usize>(two: &[f64; N]) -> [f64; M] {
    assert!(M == 3 * (N - 1) + 1);
    let mut sweeps = [0.0; N];
    sweeps[0] = two[0];
    let mut i = 1;
    while i < N / 2 {
        sweeps[i] = two[i] - sweeps[i - 1];
        i += 1;
    }
    let mut all = [0.0; M];
    let mut i = 0;
    while i < N - 1 {
        let sweep = if i < N / 2 { sweeps[i] } else { sweeps[N - 2 - i] };
        // Rotation about axis 1, then the kick; a backward sweep has the reverse order and equal fractions.
        let at = 3 * i;
        all[at] = two[i];
        all[at + 1] = sweep;
        all[at + 2] = sweep;
        i += 1;
    }
    all[M - 1] = two[N - 1];
    all
}

/// Planar rotations about the principal axes of any body; the exact rotor of a symmetric body. The code of the planar
/// step is specialised. The method is used in the frame of the body, as published.
pub const SPLITTING: Method = Method {
    facts: Facts {
        name: "splitting",
        title: "Lie-Poisson integrator: planar rotations, or the exact rotor if symmetric; weight as a kick",
        order: 2,
        stages: 7,
        symplectic: true,
        reversible: true,
        group_preserving: true,
        conserves: &["momentum"],
        angle_per_step: 1.0 / 16.0,
        longest_angle: 0.15,
        citation: "S. Reich, Momentum conserving symplectic integrators, Physica D 76 (1994) 375-383; \
                   R. I. McLachlan, Explicit Lie-Poisson integration and the Euler equations, \
                   Phys. Rev. Lett. 71 (1993) 3043-3046; A. Dullweber, B. Leimkuhler, R. McLachlan, \
                   Symplectic splitting methods for rigid body molecular dynamics, \
                   J. Chem. Phys. 107 (1997) 5840-5851",
        doi: "10.1063/1.474310",
    },
    any: Step { engine: EngineName::Planar, numbers: &Numbers::of(&[0.5, 0.5, 0.5, 1.0, 0.5, 0.5, 0.5]) },
    symmetric: Step { engine: EngineName::KickRotor, numbers: &Numbers::of(&[0.5, 1.0, 0.5]) },
    forced: Some(ForcedStep { step: Step::plain(EngineName::Affine), damping_limit: f64::INFINITY }),
};

const S6: [f64; 13] = alternating(
    &[0.0792036964311957, 0.353172906049774, -0.0420650803577195],
    &[0.209515106613362, -0.143851773179818],
);
const KAHAN_LI_17: [f64; 35] = composed(&[
    0.13020248308889008088,
    0.56116298177510838456,
    -0.38947496264484728641,
    0.15884190655515560090,
    -0.39590389413323757734,
    0.18453964097831570709,
    0.25837438768632204729,
    0.29501172360931029887,
]);

/// A composition of order above two of the flows of [`SPLITTING`]: `two` for the exact rotor, `four` for planar
/// rotations.
const fn composition(facts: Facts, two: &'static Numbers, four: &'static Numbers) -> Method {
    Method {
        facts: Facts { stages: four.fractions.len(), ..facts },
        any: Step { engine: EngineName::ComposedPlanar, numbers: four },
        symmetric: Step { engine: EngineName::KickRotor, numbers: two },
        forced: None,
    }
}

/// The flows of [`SPLITTING`], composed to order 4.
pub const SPLITTING4: Method = composition(
    Facts {
        name: "splitting4",
        title: "Lie-Poisson integrator: the flows of \"splitting\", composed to order 4",
        order: 4,
        longest_angle: 1.0,
        citation: "S. Blanes, P. C. Moan, Practical symplectic partitioned Runge-Kutta and Runge-Kutta-Nystrom methods, \
         J. Comput. Appl. Math. 142 (2002) 313-330, table 2, S6",
        doi: "10.1016/S0377-0427(01)00492-7",
        ..SPLITTING.facts
    },
    &Numbers::of(&S6),
    &Numbers::of(&in_four_parts::<13, 37>(&S6)),
);

/// The flows of [`SPLITTING`], composed to order 8.
pub const SPLITTING8: Method = composition(
    Facts {
        name: "splitting8",
        title: "Lie-Poisson integrator: the flows of \"splitting\", composed to order 8",
        order: 8,
        longest_angle: 1.5,
        citation: "W. Kahan, R.-C. Li, Composition constants for raising the orders of unconventional methods for ordinary \
         differential equations, Math. Comp. 66 (1997) 1089-1099, 17 steps",
        doi: "10.1090/S0025-5718-97-00873-9",
        ..SPLITTING.facts
    },
    &Numbers::of(&KAHAN_LI_17),
    &Numbers::of(&in_four_parts::<35, 103>(&KAHAN_LI_17)),
);

const CHIN_4A: [f64; 5] = [1.0 / 6.0, 0.5, 2.0 / 3.0, 0.5, 1.0 / 6.0];

/// Takahashi and Imada's kernel: half a drift, the kick with its gradient, half a drift. Here the half drifts of
/// neighbouring steps are one drift, and the processor contains the first and the last half.
const PMLF_4: [f64; 2] = [1.0, 1.0];
const PMLF_4_ENTER: [f64; 6] = [
    0.1859353996846055,
    0.8749306155955435,
    0.0731969797858114,
    -0.237106680151022,
    -0.1576624269298081,
    -0.5363539829039128 + 0.5,
];

/// The outer drifts of this kernel are joined in the same way.
const PMLF_6: [f64; 6] = {
    const DRIFT: f64 = -0.0682610383918630;
    const KICK: f64 = 0.2621129352517028;
    [KICK, 0.5 - DRIFT, 1.0 - 2.0 * KICK, 0.5 - DRIFT, KICK, 2.0 * DRIFT]
};
/// Begins with a drift, and ends with the outer drift of the kernel.
const PMLF_6_ENTER: [f64; 14] = [
    0.0,
    0.07943288242455420,
    1.3599424487455264,
    0.02974829169467665,
    -0.6505973747535132,
    -0.7057074964815896,
    -0.033542814598338416,
    0.3190423451260838,
    -0.040129915275115030,
    -0.2869147334299646,
    0.044579729809902803,
    0.564398710666239478150885,
    -0.680252073928462652752103,
    PMLF_6[5] / 2.0,
];
const PMLF_6_ENTER_GRADIENTS: [f64; 7] = [
    0.0,
    -0.034841228074994859,
    0.031675672097525204,
    -0.005661054677711889,
    0.004262222269023640,
    0.005,
    -0.005,
];

/// The flows of a processor backwards, between a kick of 0 and a drift of 0.
const fn backwards<const N: usize>(fractions: &[f64]) -> [f64; N] {
    assert!(N == fractions.len() + 2);
    let mut all = [0.0; N];
    let mut i = 0;
    while i < fractions.len() {
        all[fractions.len() - i] = -fractions[i];
        i += 1;
    }
    all
}
const fn backwards_gradients<const N: usize>(gradients: &[f64]) -> [f64; N] {
    assert!(N == gradients.len() + 1);
    let mut all = [0.0; N];
    let mut i = 0;
    while i < gradients.len() {
        all[gradients.len() - i] = -gradients[i];
        i += 1;
    }
    all
}

/// Kicks and drifts. The drift of a symmetric body is the exact rotor; the drift of any other body is a discrete
/// Moser-Veselov drift, whose order is so high that its error is negligible.
const fn kicks_and_drifts(facts: Facts, numbers: &'static Numbers) -> Method {
    Method {
        facts,
        any: Step { engine: EngineName::KickMoserVeselov, numbers },
        symmetric: Step { engine: EngineName::KickRotor, numbers },
        forced: None,
    }
}
const DRIFTS: Numbers = Numbers { drift_order: 10, ..Numbers::NONE };

/// Properties of all methods of kicks and drifts.
const EXACT_DRIFT: Facts =
    Facts { title: "Lie-group integrator: free motion and kicks", longest_angle: 0.6, ..SPLITTING.facts };

/// Chin's algorithm A.
pub const CHIN4A: Method = kicks_and_drifts(
    Facts {
        name: "chin4a",
        title: "Lie-group integrator: free motion and kicks, one of them with its force gradient",
        order: 4,
        stages: 5,
        citation: "S. A. Chin, Symplectic integrators from composite operator factorizations, \
                   Phys. Lett. A 226 (1997) 344-348, algorithm A",
        doi: "10.1016/S0375-9601(97)00003-0",
        ..EXACT_DRIFT
    },
    &Numbers { fractions: &CHIN_4A, gradients: &[0.0, 1.0 / 72.0, 0.0], ..DRIFTS },
);

/// Takahashi and Imada's kernel, processed.
pub const PMLF4: Method = kicks_and_drifts(
    Facts {
        name: "pmlf4",
        title: "processed Lie-group integrator: a drift and a kick with its force gradient",
        order: 4,
        stages: 2,
        reversible: false,
        citation: "M. Takahashi, M. Imada, J. Phys. Soc. Jpn. 53 (1984) 3765-3769; J. Wisdom, M. Holman, J. Touma, \
                   Symplectic correctors, Fields Inst. Commun. 10 (1996) 217-244; digits: H. Rein, D. Tamayo, \
                   G. Brown, High-order symplectic integrators for planetary dynamics, MNRAS 489 (2019) 4632-4640",
        doi: "10.1093/mnras/stz2503",
        ..EXACT_DRIFT
    },
    &Numbers {
        fractions: &PMLF_4,
        gradients: &[1.0 / 24.0],
        processor: Some(Processor {
            enter: Composition { fractions: &PMLF_4_ENTER, gradients: &[0.0; 3] },
            leave: Composition { fractions: &backwards::<8>(&PMLF_4_ENTER), gradients: &[0.0; 4] },
        }),
        ..DRIFTS
    },
);

/// Blanes, Casas and Ros, processed.
pub const PMLF6: Method = kicks_and_drifts(
    Facts {
        name: "pmlf6",
        title: "processed Lie-group integrator: three drifts and kicks, one with its force gradient",
        order: 6,
        stages: 6,
        reversible: false,
        citation: "S. Blanes, F. Casas, J. Ros, High-order Runge-Kutta-Nystrom geometric methods with processing, \
                   Appl. Numer. Math. 39 (2001) 245-259; digits: H. Rein, MNRAS 492 (2020) 5413-5419",
        doi: "",
        ..EXACT_DRIFT
    },
    &Numbers {
        fractions: &PMLF_6,
        gradients: &[0.0, 0.0164011128160783, 0.0],
        processor: Some(Processor {
            enter: Composition { fractions: &PMLF_6_ENTER, gradients: &PMLF_6_ENTER_GRADIENTS },
            leave: Composition {
                fractions: &backwards::<16>(&PMLF_6_ENTER),
                gradients: &backwards_gradients::<8>(&PMLF_6_ENTER_GRADIENTS),
            },
        }),
        ..DRIFTS
    },
);

/// Free motion without kicks: Moser-Veselov drifts of any body, the exact rotor of a symmetric body.
const fn drift(name: &'static str, order: u32, numbers: &'static Numbers) -> Method {
    let facts = Facts {
        name,
        title: "Lie-group integrator of the free body: discrete Moser-Veselov, moments modified",
        order,
        stages: 1,
        conserves: &["momentum", "energy"],
        citation: "J. Moser, A. P. Veselov, Commun. Math. Phys. 139 (1991) 217-243; R. I. McLachlan, \
                           A. Zanna, Found. Comput. Math. 5 (2005) 87-123; E. Hairer, G. Vilmart, Preprocessed \
                           discrete Moser-Veselov algorithm for the full dynamics of a rigid body, \
                           J. Phys. A 39 (2006) 13225-13235",
        doi: "10.1007/BF02352494",
        longest_angle: 0.55,
        ..SPLITTING.facts
    };
    Method {
        facts,
        any: Step { engine: EngineName::KickMoserVeselov, numbers },
        symmetric: SPLITTING.symmetric,
        forced: None,
    }
}
const DRIFT: Numbers = Numbers::of(&[0.0, 1.0]);

/// Discrete Moser-Veselov drifts of order 2.
pub const DMV2: Method = drift("dmv2", 2, &Numbers { drift_order: 2, ..DRIFT });
/// Discrete Moser-Veselov drifts of order 10.
pub const DMV10: Method = drift("dmv10", 10, &Numbers { drift_order: 10, ..DRIFT });

const fn is_near(a: f64, b: f64) -> bool {
    // The rounding error of a sum of up to 35 numbers of size one with 16 digits.
    a - b < 2e-14 && b - a < 2e-14
}

/// Checks a composition. The fractions of each flow sum to one; the fractions are a palindrome, so the method is
/// reversible and of even order; kicks and drifts satisfy the quadrature conditions of the order. The last drift of a
/// processed kernel is split in two for the palindrome.
pub(super) const fn check_composition(step: Step, facts: Facts) {
    let Some(flows) = step.engine.facts().flows else { panic!("composes no flows") };
    let all = step.numbers.fractions;
    let n = all.len();
    let processed = step.is_processed();
    assert!(flows.len() <= 6 && (processed || n % flows.len() == 1));
    assert!(facts.reversible != processed);
    let mut sums = [0.0; 5];
    let palindrome = if processed { n - 1 } else { n };
    let mut i = 0;
    while i < n {
        let flow = flow_code(flows[i % flows.len()]);
        if i < palindrome {
            let mirror = palindrome - 1 - i;
            assert!(flow == flow_code(flows[mirror % flows.len()]) && all[i] == all[mirror]);
        }
        sums[flow] += all[i];
        i += 1;
    }
    let [x, y, z, drift, kick] = sums;
    let planar = is_near(x, 1.0) && is_near(y, 1.0) && is_near(z, 1.0) && drift == 0.0;
    let exact = x == 0.0 && y == 0.0 && z == 0.0 && is_near(drift, 1.0);
    assert!((planar || exact) && is_near(kick, 1.0));
    if exact && !processed {
        check_order(step.numbers, facts.order);
    }
}

/// Checks `sum b c^k = 1/(k+1)` below the order, where `c` is the time of each kick; above order 2 also
/// `sum a d^2 - 2 sum gradients = 1/3`, where `d` is the sum of the kicks before each drift.
const fn check_order(numbers: &Numbers, order: u32) {
    let mut k = 0;
    while k < order as usize {
        let (mut sum, mut time) = (0.0, 0.0);
        let mut i = 0;
        while i < numbers.fractions.len() {
            if i % 2 == 1 {
                time += numbers.fractions[i];
            } else {
                sum += numbers.fractions[i] * power(time, k);
            }
            i += 1;
        }
        assert!(is_near(sum, 1.0 / (k + 1) as f64));
        k += 1;
    }
    let (mut sum, mut weight) = (0.0, 0.0);
    let mut i = 0;
    while i < numbers.fractions.len() {
        if i % 2 == 0 {
            weight += numbers.fractions[i];
        } else {
            sum += numbers.fractions[i] * weight * weight;
        }
        if i % 2 == 0 && !numbers.gradients.is_empty() {
            sum -= 2.0 * numbers.gradients[i / 2];
        }
        i += 1;
    }
    assert!(order < 4 || is_near(sum, 1.0 / 3.0));
}
