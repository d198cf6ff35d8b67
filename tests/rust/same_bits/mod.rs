//! The same request gives the same bits: on every instruction set, in every lane, with any other bodies, on any number
//! of threads, with any division of the work, and with any other records.
//!
//! No tolerance appears here. All NaN are equal: the payload of a NaN is no number.

mod closed_forms;
mod elliptic_functions;
mod maps;
mod trajectories;

use crate::tests::scene_of;
use rigid::body::Body;
use rigid::call::Call;
use rigid::exact::derived::{free_quantities, sign_changes, tilt_time, top_quantities};
use rigid::exact::{CanonicalForm, Evaluator, Exit, StartRows, StateRows};
use rigid::forces::{BodyForces, Forces};
use rigid::kernel::Group;
use rigid::kernel::{Compiled, ForcesRows, Kernel, System};
use rigid::kernel::{Entry, KernelAssignment, load};
use rigid::map::{
    Check, Class, Condition, Criterion, Distributions, Logic, Map, Pixel, Rule, Statistics, Verdict,
};
use rigid::method::{self, AnyMethod, EngineName, Method, Step};
use rigid::observe::{Bound, Deviation, EXIT_TIME, Flips, Observed, Quantity, Tilt};
use rigid::sample::{Distribution, uniforms};
use rigid::simd::Isa;
use rigid::simd::{LANES, Row};
use rigid::status::Status;
use rigid::trajectory::{Record, Request, Schedule, States, simulate};
use std::mem::discriminant;

fn bits(x: f64) -> u64 {
    if x.is_nan() { f64::NAN.to_bits() } else { x.to_bits() }
}

fn all_bits(numbers: &[f64]) -> Vec<u64> {
    numbers.iter().map(|&x| bits(x)).collect()
}

// Limits that some of the bodies below pass, and some do not.
const TILT: Observed = Observed::Tilt(Tilt::within(2.2));
const RATE: Observed = above(Quantity::Rate, 0.3);
const SPEED: Observed = above(Quantity::Speed, 1.6);
const IN_BODY: Observed = below(Quantity::Turn { of_momentum: true, in_space: false });
const IN_SPACE: Observed = below(Quantity::Turn { of_momentum: false, in_space: true });
const ATTITUDE: Observed = below(Quantity::Attitude);

const fn above(quantity: Quantity, limit: f64) -> Observed {
    Observed::Bound(Bound { quantity, limit, below: false, after: 0.0 })
}

const fn below(quantity: Quantity) -> Observed {
    Observed::Bound(Bound { quantity, limit: 0.9, below: true, after: 1.2 })
}

const SYSTEMS: [(System, &[Observed]); 8] = [
    (System::FreeRates, &[Observed::Nothing, Observed::Flips, RATE, IN_BODY]),
    (System::FreeAxis, &[Observed::Nothing, TILT]),
    (System::FreeAttitude, &[Observed::Nothing]),
    (System::TopAxis, &[Observed::Nothing, Observed::Flips, TILT, SPEED, IN_BODY]),
    (System::TopTwoAxes, &[Observed::Nothing, TILT, IN_SPACE, ATTITUDE]),
    (System::TopAttitude, &[Observed::Nothing]),
    (System::TopTurns, &[Observed::Nothing, TILT, RATE, IN_SPACE, ATTITUDE]),
    (System::TopTangent, &[Observed::Nothing, Observed::Growth]),
];

/// The assignment with which some method integrates a body in a kernel.
fn assignment(kernel: Kernel, body: &Body) -> Option<KernelAssignment> {
    let of_method = |method: &Method| KernelAssignment::of(method, body, kernel.system.scene);
    let methods =
        method::ALL.iter().copied().filter(|method| !kernel.system.scene.has_weight || method.moves_tops());
    methods.map(of_method).find(|assignment| assignment.step == kernel.step)
}

/// Every kernel that some method needs.
fn kernels() -> Vec<Kernel> {
    let of_system = |(system, observables): (System, &'static [Observed])| {
        let of_observable = move |&observed| {
            // Of a series maps observe the growth of deviation vectors only, but under a function.
            let fits = move |step: Step| {
                !step.is_series() || matches!(observed, Observed::Nothing | Observed::Growth)
            };
            let moving =
                method::steps().into_iter().filter(move |&step| system.is_moved_by(step) && fits(step));
            let kernels = moving.map(move |step| Kernel { system, step, observed });
            kernels.filter(|&kernel| assignment(kernel, &lane_starts(kernel)[0].body).is_some())
        };
        observables.iter().flat_map(of_observable)
    };
    SYSTEMS.into_iter().flat_map(of_system).collect()
}

/// One kernel for each code: the one with the longest table.
fn codes() -> Vec<Kernel> {
    let all = kernels();
    let shared = |a: &Kernel, b: &Kernel| {
        (a.system, a.observed) == (b.system, b.observed) && a.step.engine == b.step.engine
    };
    let last = |&i: &usize| !all[i + 1..].iter().any(|later| shared(&all[i], later));
    (0..all.len()).filter(last).map(|i| all[i]).collect()
}

#[test]
fn the_list_of_kernels_is_complete() {
    for (system, observables) in SYSTEMS {
        let step = method::steps().into_iter().find(|&step| system.is_moved_by(step)).unwrap();
        for observed in [Observed::Nothing, Observed::Flips, TILT, Observed::Growth, RATE] {
            let kernel = Kernel { system, step, observed };
            let exists = std::panic::catch_unwind(|| Compiled::new(kernel, Isa::NARROWEST)).is_ok();
            let is_same = |other: &Observed| discriminant(other) == discriminant(&observed);
            assert_eq!(exists, observables.iter().any(is_same), "{kernel:?}");
        }
    }
}

/// A random tumbling body, determined by `number`; a top if `is_top`; symmetric about an axis if `symmetric`.
fn body(number: u64, is_top: bool, symmetric: bool) -> Body {
    let u = |block| uniforms([1, 2], block, number, 0);
    let [a, b, c, _] = u(0).map(|x| 0.2 + x);
    // Moments of three masses on the axes: those of any rigid body.
    let mut moments = [b + c, c + a, a + b];
    let axis = (number % 3) as usize;
    if symmetric {
        moments[(axis + 1) % 3] = moments[(axis + 2) % 3];
    }
    let [x, y, z, _] = u(1).map(|x| 4.0 * x - 2.0);
    let mut weight = [0.0; 3];
    if is_top && symmetric {
        weight[axis] = 1.5;
    } else if is_top {
        weight = u(2).map(|x| 2.0 * x - 1.0)[..3].try_into().unwrap();
    }
    let attitude =
        rigid::sample::attitude(Distribution::UniformAttitude, [0.0; 3], [1.0, 0.0, 0.0, 0.0], u(3));
    Body { moments, weight, omega: [x, y, z], attitude }
}

/// The start of a lane of the test group.
struct LaneStart {
    body: Body,
    observed_axis: i32,
    step: f64,
}

/// The lane that overflows within a few steps, and the lane whose body turns by radians a step.
const OVERFLOWING: usize = 7;
const FAST: usize = 12;

fn lane_starts(kernel: Kernel) -> Vec<LaneStart> {
    let of_lane = |lane: usize| {
        let symmetric = kernel.step.engine == EngineName::KickRotor;
        let mut body = body(lane as u64, kernel.system.scene.has_weight, symmetric);
        // Angles of 0.1 to 0.7 in a step. The code for large angles gives another sine for up to one in a hundred of
        // these angles, but for hardly any smaller angle, so smaller angles would not show a lane with the wrong code.
        let mut step = 0.1 + 0.01 * lane as f64;
        if kernel.step.engine == EngineName::KickMoserVeselov {
            // At angles above one the equation of these drifts has no solution, and half of the lanes would be NaN.
            step *= 0.25;
        }
        match lane {
            OVERFLOWING => body.omega = [1e18; 3],
            FAST => step = 1.7,
            3 | 20 => step = 0.0,
            _ => {}
        }
        // Not the symmetry axis: the rate about this axis never changes sign.
        let observed_axis = [2, 3, 1, -2, -3, -1][lane % 6];
        LaneStart { body, observed_axis, step }
    };
    (0..LANES).map(of_lane).collect()
}

fn load_lane(group: &mut Group, lane: usize, kernel: Kernel, compiled: Compiled, lane_start: &LaneStart) {
    let assignment = assignment(kernel, &lane_start.body).expect("some method asks for every kernel");
    let entry = Entry {
        axis: lane_start.observed_axis,
        deviation: Deviation::new([0.5, -0.25, 0.375, 0.3125, 0.4375, -0.5]),
        ..Entry::unobserved(&lane_start.body, BodyForces::NONE, (0.0, None), None, lane_start.step)
    };
    load(group, lane, compiled, assignment, &entry);
}

/// Blocks of several lengths: 200 steps, or 40 steps of expensive methods.
fn run(group: &mut Group, kernel: Kernel, compiled: Compiled) {
    let splitting = [method::SPLITTING.any, method::SPLITTING.symmetric].contains(&kernel.step);
    let short = splitting || matches!(kernel.step.engine, EngineName::Rk4 | EngineName::KickMoserVeselov);
    for steps in if short { [1, 16, 83, 100] } else { [1, 5, 14, 20] } {
        compiled.advance(group, &ForcesRows::NONE, steps);
    }
}

fn full_group(kernel: Kernel, compiled: Compiled) -> Group {
    let mut group = Group::inactive();
    for (lane, lane_start) in lane_starts(kernel).iter().enumerate() {
        load_lane(&mut group, lane, kernel, compiled, lane_start);
    }
    group
}

fn rows(g: &Group) -> Vec<&Row> {
    let singles = [&g.step, &g.count, &g.unit];
    let drifts = [&g.energy, &g.momentum].into_iter().flat_map(|d| [&d.start, &d.inverse_scale, &d.worst]);
    let vectors = g.moments.iter().chain(&g.weight).chain(&g.observed);
    let rows: Vec<_> =
        g.state.iter().chain(&g.compensation).chain(vectors).chain(singles).chain(drifts).collect();
    // The list contains every row of a group; the further deviation vectors take the room that a row is aligned to.
    assert_eq!(size_of::<Group>(), rows.len() * size_of::<Row>() + align_of::<Row>());
    rows
}

fn lane_bits(group: &Group, lane: usize) -> Vec<u64> {
    rows(group).iter().map(|row| bits(row.0[lane])).collect()
}

fn state(group: &Group, lane: usize) -> Vec<f64> {
    group.state.iter().map(|row| row.0[lane]).collect()
}

#[test]
fn every_kernel_on_every_instruction_set() {
    for kernel in kernels() {
        let after = |isa| {
            let compiled = Compiled::new(kernel, isa);
            let mut group = full_group(kernel, compiled);
            run(&mut group, kernel, compiled);
            group
        };
        let scalar = after(Isa::NARROWEST);
        for isa in Isa::available() {
            let group = after(isa);
            for lane in 0..LANES {
                assert_eq!(
                    lane_bits(&group, lane),
                    lane_bits(&scalar, lane),
                    "{kernel:?} {isa:?} lane {lane}"
                );
            }
        }

        // The comparison is meaningful: only one body overflowed (an explicit method may lose the fast body too), and
        // the observable changed.
        for lane in 0..LANES {
            let finite = state(&scalar, lane).iter().all(|x| x.is_finite());
            assert!(finite != (lane == OVERFLOWING) || lane == FAST, "{kernel:?} lane {lane}");
            assert_eq!(scalar.energy.worst.0[lane].is_finite(), finite, "{kernel:?} lane {lane}");
        }
        if kernel.observed == Observed::Flips {
            assert!(scalar.observed[Flips::COUNT].0.iter().sum::<f64>() >= 10.0, "{kernel:?}");
        }
        if kernel.observed == TILT {
            let exits = scalar.observed[EXIT_TIME].0.iter().filter(|t| t.is_finite()).count();
            let largest = TILT.outcome(&scalar.observed_in(0));
            assert!(largest > 0.1 && (5..LANES).contains(&exits), "{kernel:?}");
        }
        if let Observed::Bound(_) = kernel.observed {
            let exits = scalar.observed[EXIT_TIME].0.iter().filter(|&&t| 0.0 < t && t.is_finite()).count();
            assert!((5..LANES).contains(&exits), "{kernel:?}: {exits}");
        }
    }
}

/// A body in a group of inactive lanes, 17 lanes further, has the same bits as with other bodies: bodies with other
/// steps, a body that overflows, and a body for which all lanes compute the code for large angles.
#[test]
fn no_lane_depends_on_another_lane() {
    for kernel in codes() {
        for isa in Isa::available() {
            let compiled = Compiled::new(kernel, isa);
            let mut full = full_group(kernel, compiled);
            run(&mut full, kernel, compiled);
            for (lane, lane_start) in lane_starts(kernel).iter().enumerate() {
                let elsewhere = (lane + 17) % LANES;
                let mut group = Group::inactive();
                load_lane(&mut group, elsewhere, kernel, compiled, lane_start);
                run(&mut group, kernel, compiled);
                assert_eq!(
                    lane_bits(&group, elsewhere),
                    lane_bits(&full, lane),
                    "{kernel:?} {isa:?} lane {lane}"
                );
            }
        }
    }
}

/// A step of 0 changes no number of the state.
#[test]
fn an_inactive_lane_keeps_its_state() {
    for kernel in kernels() {
        for isa in Isa::available() {
            let compiled = Compiled::new(kernel, isa);
            let start = full_group(kernel, compiled);
            let mut group = start.clone();
            run(&mut group, kernel, compiled);
            assert_eq!(state(&group, 20), state(&start, 20), "{kernel:?} {isa:?}");
            assert_ne!(state(&group, 19), state(&start, 19), "{kernel:?} {isa:?}");
            let lane = |row: Row| row.0[20];
            assert_eq!(lane(group.energy.worst), 0.0);
            assert_eq!(lane(group.momentum.worst), 0.0);
            // Of other observables this row contains another number.
            let is_other = matches!(kernel.observed, Observed::Tilt(_) | Observed::Bound(_));
            assert!(is_other || lane(group.observed[Flips::COUNT]) == 0.0);
        }
    }
}

const TIMES: [f64; 5] = [-0.7, 0.0, 0.3, 0.31, 2.0];

/// A body for each table in turn; one of them overflows.
fn batch(is_top: bool) -> Vec<Body> {
    let mut bodies: Vec<_> = (0..203).map(|i| body(i, is_top, i % 3 == 0)).collect();
    bodies[100].omega = [1e18, 1e18, 1.0];
    bodies
}

fn step_lengths(n: usize) -> Vec<f64> {
    (0..n).map(|i| [0.03, 0.25, 0.003, 0.9][i % 4]).collect()
}

const STRIDES: [u64; 4] = [0, 1, 40, 7];

#[derive(Clone, Copy)]
struct Case {
    is_top: bool,
    method: &'static Method,
    record: Record<'static>,
    at_times: bool,
}

impl Case {
    fn integrate(self, bodies: &[Body], steps: &[f64], threads: usize, isa: Isa) -> States {
        let schedule = if self.at_times { Schedule::Times(&TIMES) } else { Schedule::Strides(&STRIDES) };
        let Case { is_top, method, record, .. } = self;
        let method = AnyMethod::Steps(method);
        let request = Request {
            bodies,
            scene: scene_of(is_top),
            forces: Forces::NONE,
            method,
            record,
            schedule,
            steps,
            tolerance: None,
            refinement: 1.0,
            max_steps: 500,
        };
        simulate(&request, Call::to_the_end(isa, threads)).unwrap()
    }
}

/// The last of the methods that share all code, which has the longest table.
fn methods(is_top: bool) -> Vec<&'static Method> {
    let all: Vec<_> =
        method::ALL.iter().copied().filter(|method| method.check(scene_of(is_top)).is_ok()).collect();
    let code = |method: &Method| {
        let steps = [true, false].map(|symmetric| {
            KernelAssignment::of(method, &body(0, is_top, symmetric), scene_of(is_top)).step
        });
        (steps.map(|step| step.engine), steps.map(Step::is_processed))
    };
    let last = |&i: &usize| !all[i + 1..].iter().any(|&later| code(later) == code(all[i]));
    (0..all.len()).filter(last).map(|i| all[i]).collect()
}

fn cases() -> Vec<Case> {
    let mut all = Vec::new();
    for is_top in [false, true] {
        for method in methods(is_top) {
            for record in [Record::Rates, Record::Axis, Record::Attitude] {
                for at_times in [true, false] {
                    all.push(Case { is_top, method, record, at_times });
                }
            }
        }
    }
    all
}

/// All results of a body.
fn of_body(states: &States, i: usize) -> (Vec<u64>, Status, u64) {
    let n = states.status.len();
    let mut numbers = Vec::new();
    for field in [&states.omega, &states.gamma, &states.attitude].into_iter().flatten() {
        let width = field.len() / n;
        numbers.extend_from_slice(&field[i * width..][..width]);
    }
    numbers.extend([states.energy_drift[i], states.momentum_drift[i], states.unit_drift[i]]);
    (all_bits(&numbers), states.status[i], states.steps[i])
}
