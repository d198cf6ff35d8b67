//! Deviation vectors: the derivative of the steps, without any change of the motion.

use crate::tests::scene_of;
use rigid::body::Body;
use rigid::call::Call;
use rigid::forces::{BodyForces, Forces, ForcesInterval, ParameterChange};
use rigid::kernel::{
    Compiled, DeviationRows, Entry, ForcesRows, Group, Kernel, KernelAssignment, System, load,
};
use rigid::method::{
    self, AnyMethod, ComposedPlanar, Dop853Tableau, Engine, EngineName, KickRotor, Method, Numbers, Planar,
    Rk4Tableau, Round, RungeKutta, Splitting, Taylor,
};
use rigid::observe::{Deviation, Growth, MAX_ROWS, Observed};
use rigid::real::{Outlined, Real};
use rigid::scene::{
    Axis, AxisTangent, ForcedFrame, ForcedFrameTangent, Free, Layout, Model, Parameters, Top,
};
use rigid::simd::{Isa, LANES};
use rigid::trajectory::{Record, Request, Schedule, simulate};
use std::ops::{Add, Div, Mul, Neg, Sub};

const BODY: Body = Body {
    moments: [1.0, 1.6, 0.7],
    weight: [0.3, 0.2, 1.1],
    omega: [0.5, 0.4, 1.25],
    attitude: [0.9, 0.3, 0.2, 0.245],
};
const DEVIATION: [f64; 6] = [0.5, -0.25, 0.375, 0.3125, 0.4375, -0.5];
/// A change of moments, weight, damping and torque, and of no further force.
const CHANGE: [f64; ParameterChange::LEN] = {
    let known = [0.3, -0.2, 0.25, 0.4, -0.3, 0.1, 0.2, 0.1, -0.15, 0.05, 0.02, -0.04, 0.1, 0.3, -0.2];
    let mut change = [0.0; ParameterChange::LEN];
    let mut k = 0;
    while k < known.len() {
        change[k] = known[k];
        k += 1;
    }
    change
};

fn methods() -> impl Iterator<Item = &'static Method> {
    method::ALL.iter().copied().filter(|method| method.has_tangent())
}

fn assert_equal_bits(a: &[f64], b: &[f64], what: &str) {
    let bits = |x: &[f64]| x.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
    assert_eq!(bits(a), bits(b), "{what}");
}

/// The torque, in body and in space, and the damping of a test.
fn interval() -> ForcesInterval<'static, f64> {
    let mut interval = ForcesInterval::none();
    interval.body = [[0.1, -0.2, 0.05], [0.03, 0.0, -0.02]];
    interval.space = [[-0.1, 0.15, 0.2], [0.0, 0.04, 0.01]];
    interval.damping = [0.06, 0.03, 0.12, 0.01, 0.0, -0.01];
    interval
}

fn rows(interval: &ForcesInterval<'static, f64>) -> ForcesRows<'static> {
    let mut rows = ForcesRows::NONE;
    (0..LANES).for_each(|lane| rows.set(lane, interval));
    rows
}

/// A group whose lanes take different steps, after some steps. Between them `divide` may change the deviation vectors.
fn moved(
    system: System,
    (method, isa): (&'static Method, Isa),
    observed: Observed,
    forces: &ForcesRows,
    divide: impl Fn(&mut Group, usize),
) -> Group {
    let compiled = Compiled::new(Kernel { system, step: method.any, observed }, isa);
    let assignment = KernelAssignment::of(method, &BODY, scene_of(true));
    let mut group = Group::inactive();
    for lane in 0..LANES {
        let step = 0.05 + 0.002 * lane as f64;
        let deviation = Deviation { of_attitude: lane % 2 == 0, ..Deviation::new(DEVIATION) };
        let entry =
            Entry { deviation, ..Entry::unobserved(&BODY, BodyForces::NONE, (0.0, None), None, step) };
        load(&mut group, lane, compiled, assignment, &entry);
    }
    for block in 0..10 {
        compiled.advance(&mut group, forces, 5);
        divide(&mut group, block);
    }
    group
}

fn nothing(_: &mut Group, _: usize) {}

#[test]
fn the_motion_has_the_same_bits_with_and_without_a_deviation() {
    for (plain, varied, forces, len) in [
        (System::TopAxis, System::TopTangent, ForcesRows::NONE, Axis::LEN),
        (System::ForcedFrame, System::ForcedTangent, rows(&interval()), ForcedFrame::LEN),
    ] {
        // Forced Runge-Kutta steps integrate a quaternion without a deviation, the space axes with one.
        // The constants of a motion alone contain the step of dop853, which rounds in another way.
        let suits = |method: &&Method| {
            (plain == System::TopAxis || method.has_forced_tangent()) && *method != &method::DOP853
        };
        for method in methods().filter(suits).filter(|method| plain.is_moved_by(method.any)) {
            let scalar = moved(varied, (method, Isa::NARROWEST), Observed::Growth, &forces, nothing);
            for isa in Isa::available() {
                let without = moved(plain, (method, isa), Observed::Nothing, &forces, nothing);
                let with = moved(varied, (method, isa), Observed::Growth, &forces, nothing);
                let what = |d| format!("{varied:?} {method:?} {isa:?}, number {d}");
                for d in 0..len {
                    assert_equal_bits(&without.state[d].0, &with.state[d].0, &what(d));
                }
                for d in 0..varied.len {
                    assert_equal_bits(&scalar.state[d].0, &with.state[d].0, &what(d));
                }
                for (d, row) in with.observed.iter().enumerate() {
                    assert_equal_bits(&scalar.observed[d].0, &row.0, &what(d));
                }
            }
        }
    }
}

#[test]
fn a_deviation_that_shares_a_motion_has_the_bits_of_one_with_a_lane_of_its_own() {
    let deviation = |j: usize| DEVIATION.map(|x| x * (1.0 + 0.3 * j as f64) + 0.1 * j as f64);
    for (system, forces) in
        [(System::TopTangent, ForcesRows::NONE), (System::ForcedTangent, rows(&interval()))]
    {
        for method in methods().filter(|method| method.is_series()) {
            let assignment = KernelAssignment::of(method, &BODY, scene_of(true));
            for isa in Isa::available() {
                let kernel = Kernel { system, step: method.any, observed: Observed::Growth };
                let compiled = Compiled::new(kernel, isa);
                assert!(compiled.shares_motion());
                let at = system.tangent_at.unwrap();
                let (mut own, mut shared) = (Group::inactive(), Group::inactive());
                shared.further = vec![DeviationRows::ZERO; 5];
                let lane = 9;
                for j in 0..6 {
                    let deviation = Deviation::new(deviation(j));
                    let entry = Entry {
                        deviation,
                        ..Entry::unobserved(&BODY, BodyForces::NONE, (0.0, None), None, 0.1)
                    };
                    load(&mut own, j, compiled, assignment, &entry);
                    if j == 0 {
                        load(&mut shared, lane, compiled, assignment, &entry);
                    } else {
                        for k in 0..6 {
                            shared.further[j - 1].state[k].0[lane] = deviation.start[k];
                        }
                    }
                }
                for group in [&mut own, &mut shared] {
                    compiled.advance(group, &forces, 25);
                }
                for j in 0..6 {
                    for k in 0..6 {
                        let alone = [own.state[at + k].0[j], own.compensation[at + k].0[j]];
                        let rows = match j {
                            0 => [&shared.state[at + k], &shared.compensation[at + k]],
                            _ => [&shared.further[j - 1].state[k], &shared.further[j - 1].compensation[k]],
                        };
                        let what = format!("{system:?} {method:?} {isa:?}, number {k} of {j}");
                        assert_equal_bits(&alone, &rows.map(|row| row.0[lane]), &what);
                    }
                }
                for row in 0..MAX_ROWS {
                    assert_equal_bits(&[own.observed[row].0[0]], &[shared.observed[row].0[lane]], "growth");
                }
            }
        }
    }
}

/// The equations of a deviation vector are linear: a power of two changes no digit, now or later.
#[test]
fn it_does_not_matter_when_a_deviation_is_divided_by_a_power_of_two() {
    let divide = |power: f64| {
        move |group: &mut Group, block: usize| {
            if block % 3 != 1 {
                return;
            }
            let at = System::TopTangent.tangent_at.unwrap();
            for d in at..at + 6 {
                for row in [&mut group.state[d], &mut group.compensation[d]] {
                    row.0.iter_mut().for_each(|x| *x *= 2.0_f64.powf(-power));
                }
            }
            group.observed[Growth::SHIFT].0.iter_mut().for_each(|shift| *shift += power);
        }
    };
    for method in methods() {
        let run = |power: f64| {
            let isa = Isa::available()[0];
            moved(System::TopTangent, (method, isa), Observed::Growth, &ForcesRows::NONE, divide(power))
        };
        let whole = run(0.0);
        for power in [1.0, 60.0, -13.0] {
            let divided = run(power);
            for row in [Growth::LOG, Growth::LARGEST, Growth::AREA, Growth::MEAN_AREA] {
                assert_equal_bits(
                    &whole.observed[row].0,
                    &divided.observed[row].0,
                    &format!("{method:?} {row}"),
                );
            }
            assert!(whole.observed[Growth::LARGEST].0.iter().all(|&log| log > 0.5));
        }
    }
}

/// Deviation vectors of all bodies, by their start or by parameters, forward and backward in time.
fn deviations(
    method: &'static Method,
    (tolerance, by_parameters): (Option<f64>, bool),
    threads: usize,
    isa: Isa,
) -> Vec<f64> {
    let bodies: Vec<Body> = (0..70).map(|i| Body { omega: [0.5, 0.4, 0.1 * f64::from(i)], ..BODY }).collect();
    let (starts, changes) = ([DEVIATION; 70], [ParameterChange::of(&CHANGE); 70]);
    let record = if by_parameters { Record::Sensitivity(&changes) } else { Record::Tangent(&starts) };
    let request = Request {
        bodies: &bodies,
        scene: scene_of(true),
        forces: Forces::NONE,
        method: AnyMethod::Steps(method),
        record,
        schedule: Schedule::Times(&[-1.0, 0.0, 0.7, 3.0]),
        steps: &vec![0.05; bodies.len()],
        refinement: 1.0,
        tolerance,
        max_steps: 1 << 20,
    };
    simulate(&request, Call::to_the_end(isa, threads)).unwrap().tangent.unwrap()
}

#[test]
fn deviations_have_the_same_bits_on_every_instruction_set_and_number_of_threads() {
    for method in methods() {
        let tolerance = method.is_series().then_some(1e-15);
        for which in [(None, false), (tolerance, false), (None, true), (tolerance, true)] {
            if which.1 && !method.has_forced_tangent() {
                continue;
            }
            let scalar = deviations(method, which, 1, Isa::NARROWEST);
            assert_equal_bits(&scalar[6..12], if which.1 { &[0.0; 6] } else { &DEVIATION }, "at the start");
            for isa in Isa::available() {
                for threads in [1, 3] {
                    let other = deviations(method, which, threads, isa);
                    assert_equal_bits(&scalar, &other, &format!("{method:?} {which:?} {isa:?} {threads}"));
                }
            }
        }
    }
}

/// A number and its derivative.
#[derive(Clone, Copy, Debug)]
struct Dual {
    value: f64,
    slope: f64,
}

const fn dual(value: f64, slope: f64) -> Dual {
    Dual { value, slope }
}

impl Add for Dual {
    type Output = Dual;
    fn add(self, b: Dual) -> Dual {
        dual(self.value + b.value, self.slope + b.slope)
    }
}
impl Sub for Dual {
    type Output = Dual;
    fn sub(self, b: Dual) -> Dual {
        dual(self.value - b.value, self.slope - b.slope)
    }
}
impl Mul for Dual {
    type Output = Dual;
    fn mul(self, b: Dual) -> Dual {
        dual(self.value * b.value, self.slope * b.value + self.value * b.slope)
    }
}
impl Div for Dual {
    type Output = Dual;
    fn div(self, b: Dual) -> Dual {
        let value = self.value / b.value;
        dual(value, (self.slope - value * b.slope) / b.value)
    }
}
impl Neg for Dual {
    type Output = Dual;
    fn neg(self) -> Dual {
        dual(-self.value, -self.slope)
    }
}
impl Real for Dual {
    type Mask = bool;
    fn outlined<W: Outlined>(work: W) -> W::Out {
        work.run()
    }
    fn splat(x: f64) -> Self {
        dual(x, 0.0)
    }
    fn first(self) -> f64 {
        self.value
    }
    fn fma(self, b: Self, c: Self) -> Self {
        self * b + c
    }
    fn fnma(self, b: Self, c: Self) -> Self {
        c - self * b
    }
    fn fms(self, b: Self, c: Self) -> Self {
        self * b - c
    }
    fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        dual(root, 0.5 * self.slope / root)
    }
    fn abs(self) -> Self {
        if self.value < 0.0 { -self } else { self }
    }
    fn min(self, other: Self) -> Self {
        if self.value < other.value { self } else { other }
    }
    fn max(self, other: Self) -> Self {
        if self.value > other.value { self } else { other }
    }
    fn round(self) -> Self {
        dual(self.value.round_ties_even(), 0.0)
    }
    fn lt(self, other: Self) -> bool {
        self.value < other.value
    }
    fn select(mask: bool, a: Self, b: Self) -> Self {
        if mask { a } else { b }
    }
    fn any(mask: bool) -> bool {
        mask
    }
    fn exp2i(self) -> Self {
        unreachable!("steps contain no powers")
    }
    fn frexp(self) -> (Self, Self) {
        unreachable!("steps contain no logarithms")
    }
    fn neg_if_odd(self, n: Self) -> Self {
        if Self::odd(n) { -self } else { self }
    }
    fn odd(n: Self) -> bool {
        f64::odd(n.value)
    }
}

/// One step of a state.
fn stepped<R: Real, M: Model<R>, L: Layout, S: Engine<R, M, L, D>, const D: usize>(
    numbers: &'static Numbers,
    interval: &ForcesInterval<'static, R>,
    step: f64,
    y: [R; D],
) -> [R; D] {
    let weight = if M::HEAVY { BODY.weight } else { [0.0; 3] };
    let p = Parameters {
        moments: BODY.moments.map(R::splat),
        weight: weight.map(R::splat),
        step: R::splat(step),
    };
    stepped_by::<R, M, L, S, D>(numbers, interval, &p, y)
}

/// One step of a state of a body.
fn stepped_by<R: Real, M: Model<R>, L: Layout, S: Engine<R, M, L, D>, const D: usize>(
    numbers: &'static Numbers,
    interval: &ForcesInterval<'static, R>,
    p: &Parameters<R>,
    mut y: [R; D],
) -> [R; D] {
    S::new(p, interval, numbers).step(p, &mut y);
    y
}

fn interval_of<R: Real>(x: &ForcesInterval<f64>) -> ForcesInterval<'static, R> {
    let mut interval = ForcesInterval::none();
    interval.body = x.body.map(|v| v.map(R::splat));
    interval.space = x.space.map(|v| v.map(R::splat));
    interval.damping = x.damping.map(R::splat);
    interval
}

fn cross(a: &[f64], b: &[f64]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// The start in the layout: rates, the space axes z, x and y as far as there is room, and zeros.
fn start<const D: usize>(vectors: usize) -> [f64; D] {
    let mut y = [0.0; D];
    y[..3].copy_from_slice(&BODY.omega);
    // The rows of a rotation matrix.
    let axes = [[2.0, -2.0, 1.0], [1.0, 2.0, 2.0], [-2.0, -1.0, 2.0]];
    for v in 0..vectors {
        y[3 + 3 * v..6 + 3 * v].copy_from_slice(&axes[v].map(|x| x / 3.0));
    }
    y
}

/// The largest difference of the deviations of rates and directions after a step from the derivative of the step, for
/// the rates and for all.
macro_rules! differences {
    ([$engine:ident $($table:ident)?], $model:ident, $plain:ty, $varied:ty, $numbers:expr, $interval:expr, $step:expr) => {{
        const D: usize = <$plain>::LEN;
        const E: usize = <$varied>::LEN;
        let vectors = <$plain>::VECTORS;
        let mut y: [f64; E] = start(vectors);
        y[<$varied>::TANGENT_AT..].copy_from_slice(&DEVIATION);
        let mut z = start::<D>(vectors).map(|x| dual(x, 0.0));
        for k in 0..3 {
            z[k].slope = DEVIATION[k];
        }
        for v in 0..vectors {
            let change = cross(&y[3 + 3 * v..6 + 3 * v], &DEVIATION[3..]);
            for k in 0..3 {
                z[3 + 3 * v + k].slope = change[k];
            }
        }
        let y = stepped::<f64, $model<f64>, $varied, $engine<$($table,)? f64, $model<f64>>, E>(
            $numbers, &interval_of(&$interval), $step, y,
        );
        let z = stepped::<Dual, $model<Dual>, $plain, $engine<$($table,)? Dual, $model<Dual>>, D>(
            $numbers, &interval_of(&$interval), $step, z,
        );
        let turn = &y[<$varied>::TANGENT_AT + 3..];
        let mut found = [0.0_f64; 2];
        for k in 0..3 {
            found[0] = found[0].max((y[<$varied>::TANGENT_AT + k] - z[k].slope).abs());
        }
        for v in 0..vectors {
            let change = cross(&y[3 + 3 * v..6 + 3 * v], turn);
            for k in 0..3 {
                found[1] = found[1].max((change[k] - z[3 + 3 * v + k].slope).abs());
            }
        }
        [found[0], found[0].max(found[1])]
    }};
}

type Series<R, M> = Taylor<R, M>;

/// The rates of a body without weight depend on nothing else, so their deviation vector is the derivative of the step
/// to rounding at any step. With weight or a torque in space the deviation vector of a direction is `n x x`, where x
/// has its own equation: equal to the derivative of the step up to the error of the step.
#[test]
fn a_deviation_is_the_derivative_of_the_step() {
    let none = ForcesInterval::none();
    let taylor = method::TAYLOR12.any.numbers;
    for step in [0.1, 0.5, 1.0] {
        for [rates, _] in [
            differences!([RungeKutta Rk4Tableau], Free, Axis, AxisTangent, &Numbers::NONE, none, step),
            differences!([RungeKutta Dop853Tableau], Free, Axis, AxisTangent, &Numbers::NONE, none, step),
            differences!([Series], Free, Axis, AxisTangent, taylor, none, step),
        ] {
            assert!(rates < 8.0 * f64::EPSILON, "step {step}: {rates:e}");
        }
    }
    let forced = interval();
    for [long, short, order] in [
        [
            differences!([RungeKutta Rk4Tableau], Top, Axis, AxisTangent, &Numbers::NONE, none, 0.2)[1],
            differences!([RungeKutta Rk4Tableau], Top, Axis, AxisTangent, &Numbers::NONE, none, 0.1)[1],
            4.0,
        ],
        [
            differences!([RungeKutta Dop853Tableau], Top, Axis, AxisTangent, &Numbers::NONE, none, 0.4)[1],
            differences!([RungeKutta Dop853Tableau], Top, Axis, AxisTangent, &Numbers::NONE, none, 0.2)[1],
            8.0,
        ],
        [
            differences!([Series], Top, Axis, AxisTangent, taylor, none, 0.8)[1],
            differences!([Series], Top, Axis, AxisTangent, taylor, none, 0.4)[1],
            12.0,
        ],
        [
            differences!(
                [RungeKutta Rk4Tableau],
                Top,
                ForcedFrame,
                ForcedFrameTangent,
                &Numbers::NONE,
                forced,
                0.2
            )[1],
            differences!(
                [RungeKutta Rk4Tableau],
                Top,
                ForcedFrame,
                ForcedFrameTangent,
                &Numbers::NONE,
                forced,
                0.1
            )[1],
            4.0,
        ],
        [
            differences!([Series], Top, ForcedFrame, ForcedFrameTangent, taylor, forced, 0.8)[1],
            differences!([Series], Top, ForcedFrame, ForcedFrameTangent, taylor, forced, 0.4)[1],
            12.0,
        ],
    ] {
        println!("order {order}: {long:e} {short:e}");
        // The error of one step falls with one power more than the order.
        assert!(short < long * 2.0_f64.powf(-order - 0.5), "order {order}: {long:e} {short:e}");
        assert!(short > 0.0);
    }
}

/// The largest difference of the rates and directions after a step, that deviate by a change of parameters, from the
/// derivative of the step by them, for the rates and for all.
macro_rules! effects {
    ([$engine:ident $($table:ident)?], $numbers:expr, $weight:expr, $interval:expr, $change:expr, $step:expr) => {{
        const D: usize = ForcedFrame::LEN;
        const E: usize = ForcedFrameTangent::LEN;
        const AT: usize = ForcedFrameTangent::TANGENT_AT;
        let (change, interval): (ParameterChange<f64>, ForcesInterval<f64>) = ($change, $interval);
        let p = Parameters { moments: BODY.moments, weight: $weight, step: $step };
        let pair = |x: [f64; 3], change: [f64; 3]| [0, 1, 2].map(|k| dual(x[k], change[k]));
        let q = Parameters {
            moments: pair(p.moments, change.moments),
            weight: pair(p.weight, change.weight),
            step: dual($step, 0.0),
        };
        let mut varied: ForcesInterval<Dual> = interval_of(&interval);
        varied.body[0] = pair(interval.body[0], change.torque);
        for k in 0..6 {
            varied.damping[k].slope = change.damping[k];
        }
        let y = stepped_by::<f64, Top<f64>, ForcedFrameTangent, $engine<$($table,)? f64, Top<f64>>, E>(
            $numbers, &ForcesInterval { change, ..interval }, &p, start(ForcedFrame::VECTORS),
        );
        let z = stepped_by::<Dual, Top<Dual>, ForcedFrame, $engine<$($table,)? Dual, Top<Dual>>, D>(
            $numbers, &varied, &q, start::<D>(ForcedFrame::VECTORS).map(|x| dual(x, 0.0)),
        );
        let mut found = [0.0_f64; 2];
        for k in 0..3 {
            found[0] = found[0].max((y[AT + k] - z[k].slope).abs());
        }
        for v in 0..ForcedFrame::VECTORS {
            let turned = cross(&y[3 + 3 * v..6 + 3 * v], &y[AT + 3..]);
            for k in 0..3 {
                found[1] = found[1].max((turned[k] - z[3 + 3 * v + k].slope).abs());
            }
        }
        [found[0], found[0].max(found[1])]
    }};
}

/// Without weight and torque in space the rates depend on nothing else: to rounding at any step. Else to the order.
#[test]
fn the_effect_of_a_change_of_parameters_is_the_derivative_of_the_step() {
    let (none, forced, taylor) = (&Numbers::NONE, interval(), method::TAYLOR12.any.numbers);
    let change = ParameterChange::of(&CHANGE);
    let light = ForcesInterval { space: [[0.0; 3]; 2], ..forced };
    let of_light = ParameterChange { weight: [0.0; 3], ..change };
    for step in [0.1, 0.5, 1.0] {
        for [rates, _] in [
            effects!([RungeKutta Rk4Tableau], none, [0.0; 3], light, of_light, step),
            effects!([RungeKutta Dop853Tableau], none, [0.0; 3], light, of_light, step),
            effects!([Series], taylor, [0.0; 3], light, of_light, step),
        ] {
            assert!(rates < 8.0 * f64::EPSILON, "step {step}: {rates:e}");
        }
    }
    for [long, short, order] in [
        [
            effects!([RungeKutta Rk4Tableau], none, BODY.weight, forced, change, 0.2)[1],
            effects!([RungeKutta Rk4Tableau], none, BODY.weight, forced, change, 0.1)[1],
            4.0,
        ],
        [
            effects!([RungeKutta Dop853Tableau], none, BODY.weight, forced, change, 0.6)[1],
            effects!([RungeKutta Dop853Tableau], none, BODY.weight, forced, change, 0.3)[1],
            8.0,
        ],
        [
            effects!([Series], taylor, BODY.weight, forced, change, 0.8)[1],
            effects!([Series], taylor, BODY.weight, forced, change, 0.4)[1],
            12.0,
        ],
    ] {
        println!("order {order}: {long:e} {short:e}");
        assert!(short < long * 2.0_f64.powf(-order - 0.5), "order {order}: {long:e} {short:e}");
        assert!(short > 0.0);
    }
}

/// The difference of a deviation vector after a step of a splitting from the derivative of the step, and the size of
/// the derivative.
fn difference_of_splitting<C: Round>(numbers: &'static Numbers, moments: [f64; 3], step: f64) -> [f64; 2] {
    const D: usize = Axis::LEN;
    const E: usize = AxisTangent::LEN;
    const AT: usize = AxisTangent::TANGENT_AT;
    fn parameters<R: Real>(moments: [f64; 3], step: f64) -> Parameters<R> {
        Parameters { moments: moments.map(R::splat), weight: BODY.weight.map(R::splat), step: R::splat(step) }
    }
    let mut y: [f64; E] = start(1);
    y[AT..].copy_from_slice(&DEVIATION);
    let mut z = start::<D>(1).map(|x| dual(x, 0.0));
    let change = cross(&y[3..6], &DEVIATION[3..]);
    for k in 0..3 {
        (z[k].slope, z[3 + k].slope) = (DEVIATION[k], change[k]);
    }
    let y = stepped_by::<f64, Top<f64>, AxisTangent, Splitting<C, f64>, E>(
        numbers,
        &ForcesInterval::none(),
        &parameters(moments, step),
        y,
    );
    let z = stepped_by::<Dual, Top<Dual>, Axis, Splitting<C, Dual>, D>(
        numbers,
        &ForcesInterval::none(),
        &parameters(moments, step),
        z,
    );
    let change = cross(&y[3..6], &y[AT + 3..]);
    let pairs = (0..3).flat_map(|k| [(y[AT + k], z[k].slope), (change[k], z[3 + k].slope)]);
    pairs.fold([0.0, 0.0], |[off, size], (found, true_)| {
        [f64::max(off, (found - true_).abs()), f64::max(size, true_.abs())]
    })
}

/// Rotations and kicks are differentiated one by one, so at any step: momenta and vertical.
#[test]
fn a_deviation_is_the_derivative_of_a_splitting() {
    let symmetric = [1.0, 1.0, 0.6];
    for step in [0.0, 1e-9, 0.1, 0.7, 1.0] {
        for method in methods().filter(|method| method.facts.symplectic) {
            let found = match method.any.engine {
                EngineName::Planar => {
                    difference_of_splitting::<Planar>(method.any.numbers, BODY.moments, step)
                }
                _ => difference_of_splitting::<ComposedPlanar>(method.any.numbers, BODY.moments, step),
            };
            let rotor = difference_of_splitting::<KickRotor>(method.symmetric.numbers, symmetric, step);
            for [off, size] in [found, rotor] {
                assert!(off < 8.0 * f64::EPSILON * size, "{method:?}, step {step}: {off:e} of {size:e}");
            }
        }
    }
}
