//! Hermite steps: their derivatives, the nodes before a start, and the polynomial of a step.

use rigid::forcing::ForcingInterval;
use rigid::scene::{
    Attitude, Axis, ForcedFrame, ForcedRates, Free, Layout, Model, Parameters, Rates, Top, TwoAxes,
};
use rigid::scheme::{self, Coefficients, DERIVATIVES, Hermite, NODES, Past, Stepper, Taylor, ages};

const EPS: f64 = f64::EPSILON;

type Series<M> = Taylor<f64, M>;

fn forcing(is_in_space: bool) -> ForcingInterval<f64> {
    let mut forcing = ForcingInterval::none();
    forcing.body = [[0.3, -0.2, 0.5], [0.4, 0.1, -0.3]];
    forcing.damping = [0.2, 0.3, 0.1, 0.05, -0.04, 0.02];
    if is_in_space {
        forcing.space = [[-0.4, 0.6, 0.2], [0.3, -0.5, 0.7]];
    }
    forcing
}

fn parameters(step: f64) -> Parameters<f64> {
    Parameters { moments: [1.0, 1.6, 0.7], weight: [0.36, 0.24, 1.1], step }
}

/// Rates, directions (or a quaternion, which needs no length), balance.
fn start<const D: usize>() -> [f64; D] {
    let numbers = [0.5, 0.4, 1.3, 0.36, 0.48, 0.8, 0.8, -0.6, 0.0, 0.48, 0.64, -0.6, 0.3, -0.2, 0.7];
    std::array::from_fn(|d| numbers[d])
}

/// The state on the series through `y`, some steps later.
fn on_series<M: Model<f64>, L: Layout, const D: usize>(
    p: &Parameters<f64>,
    forcing: &ForcingInterval<f64>,
    y: &[f64; D],
    steps: f64,
) -> ([f64; D], Coefficients<f64, D>) {
    let series = <Series<M> as Stepper<f64, M, L, D>>::new(p, forcing, scheme::TAYLOR26.any.numbers);
    let mut c = Coefficients::new();
    Stepper::<f64, M, L, D>::expand(&series, p.step, y, &mut c);
    let mut at = [0.0_f64; D];
    for k in (0..=26).rev() {
        for d in 0..D {
            at[d] = at[d].mul_add(steps, c.order(k)[d]);
        }
    }
    (at, c)
}

fn past_of<M: Model<f64>, L: Layout, const D: usize>(
    p: &Parameters<f64>,
    forcing: &ForcingInterval<f64>,
    y: &[f64; D],
) -> Past<f64, D> {
    let hermite = <Hermite<f64, M> as Stepper<f64, M, L, D>>::new(p, forcing, scheme::HERMITE9.any.numbers);
    let mut past = [[[0.0; D]; DERIVATIVES]; NODES];
    Stepper::<f64, M, L, D>::begin(&hermite, y, &mut past);
    past
}

/// The derivatives at a start are factorials times the coefficients of the series, and those at the nodes before it are
/// derivatives at states of the series. Numbers are sums of up to thirty products, each at most 3 for the rates and
/// directions of the test. The nodes converge to rounding, because the turn in a step is small.
fn of_a_motion<M: Model<f64>, L: Layout, const D: usize>(forcing: &ForcingInterval<f64>) {
    let p = parameters(0.02);
    let y = start::<D>();
    let past = past_of::<M, L, D>(&p, forcing, &y);
    let (_, series) = on_series::<M, L, D>(&p, forcing, &y, 0.0);
    let mut factorial = 1.0;
    for k in 0..DERIVATIVES {
        factorial *= k as f64 + 1.0;
        let size = p.step.powi(k as i32 + 1) * 3.0_f64.powi(k as i32 + 2);
        for d in 0..D {
            let off = past[0][k][d] - factorial * series.order(k + 1)[d];
            assert!(off.abs() < 30.0 * EPS * size, "{D} numbers, derivative {k} of {d}: {off:e}");
        }
    }
    for node in 1..NODES {
        let (at, _) = on_series::<M, L, D>(&p, forcing, &y, -(node as f64));
        let there = past_of::<M, L, D>(&p, forcing, &at);
        for k in 0..DERIVATIVES {
            let size = p.step.powi(k as i32 + 1) * 3.0_f64.powi(k as i32 + 2);
            for d in 0..D {
                let off = past[node][k][d] - there[0][k][d];
                assert!(off.abs() < 60.0 * EPS * size, "{D} numbers, node {node}, {k} of {d}: {off:e}");
            }
        }
    }
}

#[test]
fn derivatives_are_those_of_the_series_in_every_layout() {
    let none = ForcingInterval::none();
    of_a_motion::<Free<f64>, Rates, 3>(&none);
    of_a_motion::<Free<f64>, Axis, 6>(&none);
    of_a_motion::<Free<f64>, Attitude, 7>(&none);
    of_a_motion::<Top<f64>, Axis, 6>(&none);
    of_a_motion::<Top<f64>, TwoAxes, 9>(&none);
    of_a_motion::<Free<f64>, ForcedRates, 6>(&forcing(false));
    of_a_motion::<Top<f64>, ForcedFrame, 15>(&forcing(true));
}

/// The error of a step is c h^10 from the corrector and d h^11 from the predicted rate of change, which the corrector
/// uses; where the error is a hundred roundings or more, the second part is the larger one. Two slopes of its logarithm
/// give the power to the square of the step.
#[test]
fn one_step_errs_by_at_least_the_tenth_power_of_its_length() {
    type Engine = Hermite<f64, Top<f64>>;
    let none = ForcingInterval::none();
    let error = |h: f64| {
        let p = parameters(h);
        let y = start::<9>();
        let mut past = past_of::<Top<f64>, TwoAxes, 9>(&p, &none, &y);
        let engine =
            <Engine as Stepper<f64, Top<f64>, TwoAxes, 9>>::new(&p, &none, scheme::HERMITE9.any.numbers);
        let mut after = y;
        Stepper::<f64, Top<f64>, TwoAxes, 9>::advance(&engine, &mut after, &mut past, ages(0));
        let (truth, _) = on_series::<Top<f64>, TwoAxes, 9>(&p, &none, &y, 1.0);
        (0..9).map(|d| (after[d] - truth[d]).powi(2)).sum::<f64>().sqrt()
    };
    let slope = |h: f64| (error(h * 1.1) / error(h / 1.1)).ln() / (2.0 * 1.1_f64.ln());
    let order = 2.0 * slope(0.08) - slope(0.16);
    assert!(order > 9.7 && order < 11.3, "{order}: slopes {} and {}", slope(0.08), slope(0.16));
}

/// The polynomial of a step has the states at both ends, and between them those of the series up to the eighth power of
/// the step over the largest value of s^4 (1 - s)^4, 1/256, and 8!.
#[test]
fn the_polynomial_of_a_step_is_the_motion_inside_it() {
    type Engine = Hermite<f64, Top<f64>>;
    let none = ForcingInterval::none();
    let p = parameters(0.1);
    let y = start::<9>();
    let mut past = past_of::<Top<f64>, TwoAxes, 9>(&p, &none, &y);
    let engine = <Engine as Stepper<f64, Top<f64>, TwoAxes, 9>>::new(&p, &none, scheme::HERMITE9.any.numbers);
    let mut after = y;
    Stepper::<f64, Top<f64>, TwoAxes, 9>::advance(&engine, &mut after, &mut past, ages(0));
    let [begin, end] = [&past[ages(1)[1]], &past[ages(1)[0]]];
    let mut dense = Coefficients::new();
    Stepper::<f64, Top<f64>, TwoAxes, 9>::polynomial(&engine, [&y, &after], [begin, end], &mut dense);
    assert_eq!(dense.highest(), 7);
    for s in [0.0, 0.2, 0.5, 0.9, 1.0] {
        let (truth, _) = on_series::<Top<f64>, TwoAxes, 9>(&p, &none, &y, s);
        for d in 0..9 {
            let value = (0..=7).rev().fold(0.0, |sum: f64, k| sum.mul_add(s, dense.order(k)[d]));
            // The eighth derivative is at most 2e4 here: eight factors of rates and weights below 3.5.
            let bound = 3.5_f64.powi(8) * p.step.powi(8) / (256.0 * 40320.0) + 100.0 * EPS;
            assert!((value - truth[d]).abs() < bound, "{d} at {s}: {:e} of {bound:e}", value - truth[d]);
        }
    }
}
