//! Properties of splittings beside their order: reversibility, lengths, energy, the exact motion of a symmetric body,
//! and renamed axes. And one step of each method equals its table, written out naively.

use crate::tests::scene_of;
use nalgebra::{Quaternion, SVector, Unit, UnitQuaternion, Vector3};
use rigid::body::Body;
use rigid::call::Call;
use rigid::forces::{Forces, ForcesInterval};
use rigid::method::{
    self, AnyMethod, ComposedPlanar, Engine, ExactRotor, Flow, KickRotor, Method, Numbers, Planar,
    Rk4Tableau, Round, RungeKutta, Splitting,
};
use rigid::real::Real;
use rigid::sample::{Distribution, attitude, uniforms};
use rigid::scene::{Attitude, AxisAttitude, Free, Layout, Model, Parameters, Top};
use rigid::simd::Isa;
use rigid::trajectory::{Record, Request, Schedule, States, simulate};

const EPS: f64 = f64::EPSILON;

/// A body with weight in a general motion; its state is momenta (or rates), vertical, quaternion.
fn general() -> (Parameters<f64>, [f64; 10]) {
    let p = Parameters { moments: [1.0, 1.6, 0.7], weight: [0.2, -0.1, 0.3], step: 0.02 };
    (p, start([0.9, -0.4, 1.1]))
}

/// A symmetric body in a general motion; the centre of mass need not lie on the symmetry axis.
fn symmetric() -> (Parameters<f64>, [f64; 10]) {
    let p = Parameters { moments: [1.0, 1.0, 0.7], weight: [0.2, -0.1, 0.3], step: 0.02 };
    (p, start([0.9, -0.4, 1.1]))
}

fn start([l1, l2, l3]: [f64; 3]) -> [f64; 10] {
    // The vertical of this attitude, the third row of R.
    [l1, l2, l3, 0.8, 0.48, 0.36, 0.8, 0.4, -0.4, 0.2]
}

/// The state of a free body from that of a top: without the vertical.
fn without_gamma(y: [f64; 10]) -> [f64; 7] {
    [y[0], y[1], y[2], y[6], y[7], y[8], y[9]]
}

/// The numbers that an engine is tested with.
trait Tested {
    const NUMBERS: &'static Numbers;
}
impl<M> Tested for RungeKutta<Rk4Tableau, f64, M> {
    const NUMBERS: &'static Numbers = method::RK4.any.numbers;
}
impl Tested for Splitting<Planar, f64> {
    const NUMBERS: &'static Numbers = method::SPLITTING.any.numbers;
}
impl Tested for Splitting<KickRotor, f64> {
    const NUMBERS: &'static Numbers = method::SPLITTING.symmetric.numbers;
}

fn go<S, M, L, const D: usize>(p: &Parameters<f64>, y: &mut [f64; D], steps: usize)
where
    M: Model<f64>,
    L: Layout,
    S: Engine<f64, M, L, D> + Tested,
{
    go_by::<S, M, L, D>(S::NUMBERS, p, y, steps);
}

fn go_by<S, M, L, const D: usize>(
    numbers: &'static Numbers,
    p: &Parameters<f64>,
    y: &mut [f64; D],
    steps: usize,
) where
    M: Model<f64>,
    L: Layout,
    S: Engine<f64, M, L, D>,
{
    let engine = S::new(p, &ForcesInterval::none(), numbers);
    for _ in 0..steps {
        engine.step(p, y);
    }
}

fn backwards(p: Parameters<f64>) -> Parameters<f64> {
    Parameters { step: -p.step, ..p }
}

fn norm(v: &[f64]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| (x - y).powi(2)).sum::<f64>().sqrt()
}

// --- Reversibility ---------------------------------------------------------------------------------------------

const ROUND_TRIP: usize = 2000;

/// The distance of a state from its start after 2000 steps forward and back, and the bound of its rounding error.
///
/// A step rounds each number about ten times (five rotations, two roundings each), eps/2 at most. The factor by which
/// the motion magnifies an error on the way back is measured with neighbours at the far end. Roundings are taken as
/// independent: 4 standard deviations of 2 x 2000 steps.
fn round_trip<S, M, L, const D: usize>(p: Parameters<f64>, start: [f64; D]) -> (f64, f64)
where
    M: Model<f64>,
    L: Layout,
    S: Engine<f64, M, L, D> + Tested,
{
    let mut far = start;
    go::<S, M, L, D>(&p, &mut far, ROUND_TRIP);
    assert!(distance(&far, &start) > 0.1, "it moved");
    let back = |mut y: [f64; D]| {
        go::<S, M, L, D>(&backwards(p), &mut y, ROUND_TRIP);
        y
    };
    let home = back(far);
    let mut growth = 1.0_f64;
    for d in 0..D {
        let mut neighbour = far;
        neighbour[d] += 1e-7;
        growth = growth.max(distance(&back(neighbour), &home) / 1e-7);
    }
    let roundings = 2.0 * 10.0 * ROUND_TRIP as f64;
    (distance(&home, &start), 4.0 * roundings.sqrt() * EPS / 2.0 * growth)
}

#[test]
fn there_and_back() {
    let (p, y) = general();
    let (twist, free) = (symmetric().0, without_gamma(y));
    for (trip, bound) in [
        round_trip::<Splitting<Planar, f64>, Free<f64>, Attitude, 7>(p, free),
        round_trip::<Splitting<Planar, f64>, Top<f64>, AxisAttitude, 10>(p, y),
        round_trip::<Splitting<KickRotor, f64>, Free<f64>, Attitude, 7>(twist, free),
        round_trip::<Splitting<KickRotor, f64>, Top<f64>, AxisAttitude, 10>(twist, y),
    ] {
        println!("{trip:.1e} of {bound:.1e}");
        assert!(trip <= bound && bound < 1e-9, "{trip:e}, bound {bound:e}");
    }

    // The same flows in an order that is no palindrome, and the classical method, are not reversible.
    let (change, _) = round_trip::<Splitting<OneWay, f64>, Top<f64>, AxisAttitude, 10>(p, y);
    assert!(change > 1e-3, "{change:e}");
    let (change, bound) =
        round_trip::<RungeKutta<Rk4Tableau, f64, Top<f64>>, Top<f64>, AxisAttitude, 10>(p, y);
    assert!(change > 100.0 * bound, "{change:e}, bound {bound:e}");
}

/// A composition of order 1: the flows one after the other.
#[derive(Clone, Copy)]
struct OneWay;

impl Round for OneWay {
    type Drift<R: Real> = ExactRotor<R>;
    const FLOWS: &'static [Flow] = &[Flow::Turn(0), Flow::Turn(1), Flow::Turn(2), Flow::Kick];
}
impl Tested for Splitting<OneWay, f64> {
    const NUMBERS: &'static Numbers = &Numbers::of(&[1.0; 4]);
}

// --- Lengths and energy ----------------------------------------------------------------------------------------

const LONG: usize = 100_000;

/// Relative change of three lengths during 1e5 steps: momentum, vertical (if integrated), quaternion.
fn lengths<S, M, L, const D: usize>(p: Parameters<f64>, start: [f64; D]) -> Vec<f64>
where
    M: Model<f64>,
    L: Layout,
    S: Engine<f64, M, L, D> + Tested,
{
    let parts = [0..3, 3..L::QUATERNION_AT, L::QUATERNION_AT..D];
    let mut y = start;
    go::<S, M, L, D>(&p, &mut y, LONG);
    let part = |r: &std::ops::Range<usize>| (norm(&y[r.clone()]) / norm(&start[r.clone()]) - 1.0).abs();
    parts.iter().filter(|r| !r.is_empty()).map(part).collect()
}

#[test]
fn lengths_at_rounding() {
    // A rotation multiplies a length by 1 + d, |d| <= eps: s^2 + c^2 differs from 1 by 2 c ulp(c) <= eps for a small
    // angle, a length by half of that, and the two fused sums add a half. The angles change from step to step, so the d
    // are taken as independent: 3 standard deviations of 5 rotations a step.
    let changing = 3.0 * (5.0 * LONG as f64).sqrt() * EPS;
    // A free symmetric body turns by the same two angles in each step, so their d add up: eps a step.
    let constant = LONG as f64 * EPS;
    let (p, y) = general();
    let (twist, free) = (symmetric().0, without_gamma(y));
    let planar = lengths::<Splitting<Planar, f64>, Free<f64>, Attitude, 7>(p, free);
    let rotor = lengths::<Splitting<KickRotor, f64>, Free<f64>, Attitude, 7>(twist, free);
    // The weight changes |L|; the vertical and the attitude keep their lengths.
    let planar_top = lengths::<Splitting<Planar, f64>, Top<f64>, AxisAttitude, 10>(p, y);
    let rotor_top = lengths::<Splitting<KickRotor, f64>, Top<f64>, AxisAttitude, 10>(twist, y);
    assert!(planar_top[0] > 1e-3 && rotor_top[0] > 1e-3);
    for (lengths, bound) in [
        (&planar[..], changing),
        (&rotor, constant),
        (&planar_top[1..], changing),
        (&rotor_top[1..], changing),
    ] {
        println!("{lengths:?}, bound {bound:.1e}");
        assert!(lengths.iter().all(|&d| d <= bound), "{lengths:?}, bound {bound:e}");
    }

    // The error of the classical method is about h^5 a step.
    let change = lengths::<RungeKutta<Rk4Tableau, f64, Top<f64>>, Top<f64>, AxisAttitude, 10>(p, y);
    assert!(change[1] > 1e3 * changing && change[2] > 1e3 * changing, "{change:?}");
}

/// Largest energy error in the first tenth and in all of 1e5 steps.
fn energy_errors<S, M, L, const D: usize>(p: Parameters<f64>, mut y: [f64; D]) -> [f64; 2]
where
    M: Model<f64>,
    L: Layout,
    S: Engine<f64, M, L, D> + Tested,
{
    let energy = |y: &[f64; D]| S::VARIABLES.kinetic(&p, y) + M::potential(&p, y);
    let start = energy(&y);
    let engine = S::new(&p, &ForcesInterval::none(), S::NUMBERS);
    let (mut early, mut worst) = (0.0, 0.0_f64);
    for i in 0..LONG {
        engine.step(&p, &mut y);
        worst = worst.max((energy(&y) - start).abs());
        if i == LONG / 10 {
            early = worst;
        }
    }
    [early, worst]
}

#[test]
fn energy_does_not_drift() {
    let (p, y) = general();
    let halved = Parameters { step: p.step / 2.0, ..p };
    type PlanarSteps = Splitting<Planar, f64>;
    type RotorSteps = Splitting<KickRotor, f64>;
    let twist = symmetric().0;
    let cases = [
        (
            energy_errors::<PlanarSteps, Free<f64>, Attitude, 7>(p, without_gamma(y)),
            energy_errors::<PlanarSteps, Free<f64>, Attitude, 7>(halved, without_gamma(y)),
        ),
        (
            energy_errors::<PlanarSteps, Top<f64>, AxisAttitude, 10>(p, y),
            energy_errors::<PlanarSteps, Top<f64>, AxisAttitude, 10>(halved, y),
        ),
        (
            energy_errors::<RotorSteps, Top<f64>, AxisAttitude, 10>(twist, y),
            energy_errors::<RotorSteps, Top<f64>, AxisAttitude, 10>(Parameters { step: 0.01, ..twist }, y),
        ),
    ];
    for ([early, worst], [_, half]) in cases {
        println!("{early:.3e} {worst:.3e} {half:.3e}");
        // Bounded: the error has nearly its maximum after a tenth of the time (a drift would grow ten times, a random
        // walk three times). Of order 2: half the step has a quarter of the error, up to terms of order h^2.
        assert!(worst < 1.3 * early, "{early:e} then {worst:e}");
        assert!((worst / half - 4.0).abs() < 0.3, "{worst:e} and {half:e}");
    }
}

// --- The exact motion of a symmetric body -----------------------------------------------------------------------

#[test]
fn the_rotor_is_exact_for_any_step() {
    let (p, y) = symmetric();
    let y = without_gamma(y);
    for h in [1e-3, 0.1, 1.0, 10.0, 100.0, -7.0] {
        let mut once = y;
        go::<Splitting<KickRotor, f64>, Free<f64>, Attitude, 7>(&Parameters { step: h, ..p }, &mut once, 1);
        let mut often = y;
        let small = Parameters { step: h / 64.0, ..p };
        go::<Splitting<KickRotor, f64>, Free<f64>, Attitude, 7>(&small, &mut often, 64);

        // In closed form: a turn by |L| h / I1 about L, then by (1/I3 - 1/I1) L3 h about axis 3.
        let l = Vector3::new(y[0], y[1], y[2]);
        let whole = UnitQuaternion::from_scaled_axis(l * h / p.moments[0]);
        let angle = (1.0 / p.moments[2] - 1.0 / p.moments[0]) * y[2] * h;
        let spin = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle);
        let q = (Quaternion::new(y[3], y[4], y[5], y[6]) * (whole * spin).into_inner()).coords;
        let l = spin.inverse() * l;
        let exact = [l.x, l.y, l.z, q.w, q.x, q.y, q.z];

        // The two angles have four roundings each, eps/2; a step adds two rotations of 2.5 eps.
        let angles = norm(&y[..3]) * h.abs() / p.moments[0] + angle.abs();
        let bound = |steps: f64| (2.0 * angles + 5.0 * steps) * EPS * norm(&y);
        assert!(distance(&once, &often) <= bound(64.0), "step {h}: {:e}", distance(&once, &often));
        assert!(distance(&once, &exact) <= bound(2.0), "step {h}: {:e}", distance(&once, &exact));
    }
}

// --- Renamed axes ----------------------------------------------------------------------------------------------

fn run(bodies: &[Body], is_top: bool, method: &'static Method) -> States {
    let steps = vec![0.02; bodies.len()];
    let request = Request {
        bodies,
        scene: scene_of(is_top),
        forces: Forces::NONE,
        method: AnyMethod::Steps(method),
        record: Record::Attitude,
        schedule: Schedule::Strides(&[1, 199]),
        steps: &steps,
        tolerance: None,
        refinement: 1.0,
        max_steps: 1000,
    };
    simulate(&request, Call::to_the_end(Isa::available()[0], 1)).unwrap()
}

/// The body with its axes renamed: new axis i is old axis i + 1. The quaternion of the renaming is
/// (1, 1, 1, 1)/2, a third of a turn about the diagonal.
fn renamed(body: &Body) -> Body {
    let turn = |v: [f64; 3]| [v[1], v[2], v[0]];
    let q = rigid::kinematics::quaternion_product(&body.attitude, &[0.5, 0.5, 0.5, 0.5]);
    Body { moments: turn(body.moments), weight: turn(body.weight), omega: turn(body.omega), attitude: q }
}

#[test]
fn the_renaming_is_one() {
    let (p, y) = general();
    let body = Body {
        moments: p.moments,
        weight: p.weight,
        omega: [1.0, 2.0, 3.0],
        attitude: [0.8, 0.4, -0.4, 0.2],
    };
    let [a, b, c] = body.gamma();
    let other = renamed(&body).gamma();
    assert!(distance(&other, &[b, c, a]) < 2.0 * EPS);
    // The vertical of the states above is that of their attitude.
    assert!(distance(&[a, b, c], &y[3..6]) < 2.0 * EPS, "{:?}", [a, b, c]);
}

#[test]
fn axes_may_be_renamed() {
    for is_top in [false, true] {
        for method in method::ALL.iter().copied().filter(|m| !is_top || m.moves_tops()) {
            for moments in [[1.0, 1.6, 0.7], [1.0, 1.0, 0.7], [0.7, 1.0, 1.0], [1.6, 1.0, 0.7]] {
                let weight = if is_top { [0.2, -0.1, 0.3] } else { [0.0; 3] };
                let body = Body { moments, weight, omega: [0.9, -0.4, 1.1], attitude: [0.8, 0.4, -0.4, 0.2] };
                let once = renamed(&body);
                for (turns, other) in [(1, once), (2, renamed(&once))] {
                    renamed_motion(is_top, method, [body, other], turns);
                }
            }
        }
    }
}

fn renamed_motion(is_top: bool, method: &'static Method, bodies: [Body; 2], turns: usize) {
    let states = run(&bodies, is_top, method);
    let attitudes = states.attitude.as_ref().unwrap();
    // 200 steps, of so many flows or evaluations, of some ten roundings each.
    let roundings = (200.0 * 10.0 * method.facts.stages as f64).sqrt() * EPS / 2.0;
    for time in 0..2 {
        let [old, new] = [0, 1].map(|body| &states.rates()[3 * (2 * body + time)..][..3]);
        for i in 0..3 {
            let (a, b) = (old[(i + turns) % 3], new[i]);
            // A free body has the same operations on the same numbers. The vertical of a top starts with another
            // rounding, an eps or two, whose effect is 4 eps t, t = 4; all later roundings differ too.
            let slack = if is_top { 16.0 * EPS + roundings } else { 0.0 };
            assert!((a - b).abs() <= slack, "{method:?} {bodies:?}: {a:e} {b:e}");
        }
        // Attitudes: one more product.
        let [old, new] = [0, 1].map(|body| &attitudes[4 * (2 * body + time)..][..4]);
        let mut q: [f64; 4] = old.try_into().unwrap();
        for _ in 0..turns {
            q = rigid::kinematics::quaternion_product(&q, &[0.5, 0.5, 0.5, 0.5]);
        }
        let miss = distance(&q, new);
        assert!(miss <= 4.0 * roundings, "{method:?} {bodies:?}: {miss:e}");
    }
}

// --- One step, naively ----------------------------------------------------------------------------------------

/// A state with the types of nalgebra: momenta or rates, vertical, attitude.
#[derive(Clone, Copy)]
struct Naive {
    first: Vector3<f64>,
    gamma: Vector3<f64>,
    attitude: Quaternion<f64>,
}

impl Naive {
    fn of(y: &[f64; 10]) -> Naive {
        Naive {
            first: Vector3::new(y[0], y[1], y[2]),
            gamma: Vector3::new(y[3], y[4], y[5]),
            attitude: Quaternion::new(y[6], y[7], y[8], y[9]),
        }
    }

    fn numbers(self) -> [f64; 10] {
        let Naive { first: a, gamma: b, attitude: q } = self;
        [a.x, a.y, a.z, b.x, b.y, b.z, q.w, q.i, q.j, q.k]
    }

    /// The body turns by this rotation, given in the body.
    fn turn(&mut self, by: UnitQuaternion<f64>) {
        self.first = by.inverse() * self.first;
        self.gamma = by.inverse() * self.gamma;
        self.attitude *= by.into_inner();
    }
}

fn naive_splitting<C: Round>(numbers: &Numbers, p: &Parameters<f64>, y: &[f64; 10]) -> [f64; 10] {
    let mut state = Naive::of(y);
    for (i, fraction) in numbers.fractions.iter().enumerate() {
        let flow = C::FLOWS[i % C::FLOWS.len()];
        let h = fraction * p.step;
        match flow {
            Flow::Turn(k) => {
                let axis = Unit::new_unchecked(Vector3::ith(k, 1.0));
                let angle = state.first[k] / p.moments[k] * h;
                state.turn(UnitQuaternion::from_axis_angle(&axis, angle));
            }
            Flow::Drift => {
                let spin = (1.0 / p.moments[2] - 1.0 / p.moments[0]) * state.first.z * h;
                state.turn(UnitQuaternion::from_scaled_axis(state.first / p.moments[0] * h));
                state.turn(UnitQuaternion::from_axis_angle(&Vector3::z_axis(), spin));
            }
            Flow::Kick => state.first += state.gamma.cross(&Vector3::from(p.weight)) * h,
        }
    }
    state.numbers()
}

/// Euler's equations of a top.
fn naive_rate(p: &Parameters<f64>, y: &SVector<f64, 10>) -> SVector<f64, 10> {
    let state = Naive::of(&y.as_slice().try_into().unwrap());
    let (omega, moments) = (state.first, Vector3::from(p.moments));
    let torque = state.gamma.cross(&Vector3::from(p.weight));
    let momentum = moments.component_mul(&omega);
    let rate = Naive {
        first: (momentum.cross(&omega) + torque).component_div(&moments),
        gamma: state.gamma.cross(&omega),
        attitude: state.attitude * Quaternion::from_imag(omega) * 0.5,
    };
    SVector::from(rate.numbers())
}

fn naive_rk4(p: &Parameters<f64>, y: &[f64; 10]) -> [f64; 10] {
    let (y, h) = (SVector::from(*y), p.step);
    let k1 = naive_rate(p, &y);
    let k2 = naive_rate(p, &(y + k1 * (h / 2.0)));
    let k3 = naive_rate(p, &(y + k2 * (h / 2.0)));
    let k4 = naive_rate(p, &(y + k3 * h));
    (y + (k1 + k2 * 2.0 + k3 * 2.0 + k4) * (h / 6.0)).into()
}

#[test]
fn one_step_as_its_table_says() {
    for sample in 0..200 {
        let u = |block| uniforms([3, 4], block, sample, 0);
        let [a, b, c, step] = u(0);
        let [x, y, z, _] = u(1).map(|u| 2.0 * u - 1.0);
        let [w1, w2, w3, _] = u(2).map(|u| 2.0 * u - 1.0);
        let q = attitude(Distribution::UniformAttitude, [0.0; 3], [1.0, 0.0, 0.0, 0.0], u(3));
        let [g1, g2, g3] = rigid::kinematics::to_body_frame(&q, &[0.0, 0.0, 1.0]);
        let state = [x, y, z, g1, g2, g3, q[0], q[1], q[2], q[3]];
        let moments = [0.5 + b + c, 0.5 + c + a, 0.5 + a + b];
        let p = Parameters { moments, weight: [w1, w2, w3], step: 0.4 * step };
        let twist = Parameters { moments: [moments[0], moments[0], moments[2]], ..p };

        let mut planar = state;
        go::<Splitting<Planar, f64>, Top<f64>, AxisAttitude, 10>(&p, &mut planar, 1);
        let mut rotor = state;
        go::<Splitting<KickRotor, f64>, Top<f64>, AxisAttitude, 10>(&twist, &mut rotor, 1);
        let mut planar4 = state;
        let [four, eight] = [method::SPLITTING4.any.numbers, method::SPLITTING8.symmetric.numbers];
        go_by::<Splitting<ComposedPlanar, f64>, Top<f64>, AxisAttitude, 10>(four, &p, &mut planar4, 1);
        let mut rotor8 = state;
        go_by::<Splitting<KickRotor, f64>, Top<f64>, AxisAttitude, 10>(eight, &twist, &mut rotor8, 1);
        let mut rk4 = state;
        go::<RungeKutta<Rk4Tableau, f64, Top<f64>>, Top<f64>, AxisAttitude, 10>(&p, &mut rk4, 1);

        // Numbers of size one, at most ten roundings of eps/2 on either side: no number has an error above 10 eps, and
        // the mean square of ten numbers has less. Five times as many flows: the same.
        for (name, got, naive) in [
            ("planar", planar, naive_splitting::<Planar>(method::SPLITTING.any.numbers, &p, &state)),
            (
                "rotor",
                rotor,
                naive_splitting::<KickRotor>(method::SPLITTING.symmetric.numbers, &twist, &state),
            ),
            ("planar 4", planar4, naive_splitting::<ComposedPlanar>(four, &p, &state)),
            ("rotor 8", rotor8, naive_splitting::<KickRotor>(eight, &twist, &state)),
            ("rk4", rk4, naive_rk4(&p, &state)),
        ] {
            let miss = distance(&got, &naive);
            assert!(miss <= 10.0 * EPS, "{name}, sample {sample}: {:.1} eps", miss / EPS);
        }
    }
}
