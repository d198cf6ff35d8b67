//! The same request gives the same bits: on every instruction set, in every lane, beside any neighbours, on any
//! number of threads, however the work is cut, and whatever else is recorded.
//!
//! No tolerance appears here. A NaN equals any NaN: its payload is no number.

use rigid::ensemble::{Class, Criterion, Judge, Map, Pixel, Statistics};
use rigid::exact::derived::{free_quantities, sign_changes, tilt_time, top_quantities};
use rigid::exact::{Evaluator, ExitRows, Kind, Place, StartRows, StateRows};
use rigid::group::{Group, LANES, Row};
use rigid::kernel::{Compiled, Kernel, System, Table, Watch};
use rigid::method::Method;
use rigid::observe::TiltLimit;
use rigid::sample::{Law, uniforms};
use rigid::simd::Isa;
use rigid::start::{Body, Seat, load};
use rigid::trajectory::{Record, Request, Schedule, Solver, States, Status, simulate};
use std::sync::atomic::AtomicBool;

static GO: AtomicBool = AtomicBool::new(false);

fn bits(x: f64) -> u64 {
    if x.is_nan() { f64::NAN.to_bits() } else { x.to_bits() }
}

fn all_bits(numbers: &[f64]) -> Vec<u64> {
    numbers.iter().map(|&x| bits(x)).collect()
}

const SYSTEMS: [(System, &[Watch]); 9] = [
    (System::FreeRates, &[Watch::Nothing, Watch::Flips]),
    (System::FreeAxis, &[Watch::Nothing, Watch::Tilt]),
    (System::FreeAttitude, &[Watch::Nothing]),
    (System::TopAxis, &[Watch::Nothing, Watch::Flips, Watch::Tilt]),
    (System::TopTwoAxes, &[Watch::Nothing, Watch::Tilt]),
    (System::TopAttitude, &[Watch::Nothing]),
    (System::SpinFreeAxis, &[Watch::Nothing]),
    (System::SpinFreeTwoAxes, &[Watch::Nothing]),
    (System::SpinFreeAttitude, &[Watch::Nothing]),
];

/// Every kernel there is.
fn kernels() -> Vec<Kernel> {
    let of_system = |(system, watches): (System, &'static [Watch])| {
        let of_watch = move |&watch| {
            let moving = Table::ALL.into_iter().filter(move |table| table.moves(system));
            moving.map(move |table| Kernel { system, table, watch })
        };
        watches.iter().flat_map(of_watch)
    };
    SYSTEMS.into_iter().flat_map(of_system).collect()
}

/// Of the kernels that share code, the one with the longest table.
fn codes() -> Vec<Kernel> {
    let all = kernels();
    let shared = |a: &Kernel, b: &Kernel| {
        (a.system, a.watch) == (b.system, b.watch) && a.table.engine() == b.table.engine()
    };
    let last = |&i: &usize| !all[i + 1..].iter().any(|later| shared(&all[i], later));
    (0..all.len()).filter(last).map(|i| all[i]).collect()
}

#[test]
fn the_list_of_kernels_is_complete() {
    for (system, watches) in SYSTEMS {
        let table = Table::ALL.into_iter().find(|table| table.moves(system)).unwrap();
        for watch in [Watch::Nothing, Watch::Flips, Watch::Tilt] {
            let kernel = Kernel { system, table, watch };
            let exists = std::panic::catch_unwind(|| Compiled::new(kernel, Isa::Scalar)).is_ok();
            assert_eq!(exists, watches.contains(&watch), "{kernel:?}");
        }
    }
}

/// A tumbling body, another for every number; a top if asked; symmetric about one of its axes if asked.
fn body(number: u64, is_top: bool, symmetric: bool) -> Body {
    let u = |block| uniforms([1, 2], block, number, 0);
    let [a, b, c, _] = u(0).map(|x| 0.2 + x);
    // Moments of three masses on the axes: any real body.
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
    let attitude = rigid::sample::attitude(Law::UniformAttitude, 0.0, [1.0, 0.0, 0.0, 0.0], u(3));
    Body { moments, weight, omega: [x, y, z], attitude }
}

/// What a lane of the test group carries.
struct Load {
    body: Body,
    watched: i32,
    step: f64,
    /// Of the tilt, small ones compared by the sine, large ones by the cosine.
    limit: TiltLimit,
}

/// The lane that overflows within a few steps, and one whose body turns by radians a step.
const WILD: usize = 7;
const FAST: usize = 12;

fn loads(kernel: Kernel) -> Vec<Load> {
    let of_lane = |lane: usize| {
        let symmetric = kernel.table.is_for_symmetric() || is_spin_free(kernel.system);
        let mut body = body(lane as u64, kernel.system.is_top(), symmetric);
        // Turns of 0.1 to 0.7 in a step: of such angles up to one in a hundred has another sine by the code for
        // large angles, of smaller ones hardly any, and a lane that took the wrong code would not be seen.
        let mut step = 0.1 + 0.01 * lane as f64;
        if format!("{:?}", kernel.table).starts_with("Dmv") {
            // The equation of these drifts has no solution beyond a turn of one: not a number, half of the lanes.
            step *= 0.25;
        }
        match lane {
            WILD => body.omega = [1e18; 3],
            FAST => step = 1.7,
            3 | 20 => step = 0.0,
            _ => {}
        }
        // Not the axis of symmetry, about which nothing ever flips.
        let watched = [2, 3, 1, -2, -3, -1][lane % 6];
        let limit = TiltLimit::new([0.3, 0.9, 1.6, 3.1][lane % 4]);
        Load { body, watched, step, limit }
    };
    (0..LANES).map(of_lane).collect()
}

fn is_spin_free(system: System) -> bool {
    matches!(system, System::SpinFreeAxis | System::SpinFreeTwoAxes | System::SpinFreeAttitude)
}

fn place(group: &mut Group, lane: usize, kernel: Kernel, compiled: Compiled, it: &Load) {
    let spin_free = is_spin_free(kernel.system);
    let of_method = |method| {
        let of = if spin_free { Seat::of_path } else { Seat::of };
        of(method, &it.body, kernel.system.is_top())
    };
    let fits = |seat: &Seat| seat.table == kernel.table && seat.is_spin_free() == spin_free;
    let seat = Method::ALL.into_iter().map(of_method).find(fits).expect("a method for every table");
    load(group, lane, (kernel, compiled), seat, &it.body, it.watched, it.step);
    (group.limit[0].0[lane], group.limit[1].0[lane]) = (it.limit.cosine, it.limit.sine2);
}

/// Steps in bursts of several lengths: 200, or 40 of those that are long and dear.
fn run(group: &mut Group, kernel: Kernel, compiled: Compiled) {
    let drifts = format!("{:?}", kernel.table).starts_with("Dmv");
    let short = drifts || matches!(kernel.table, Table::Rk4 | Table::Planar | Table::Rotor);
    for steps in if short { [1, 16, 83, 100] } else { [1, 5, 14, 20] } {
        compiled.advance(group, steps);
    }
}

fn full_group(kernel: Kernel, compiled: Compiled) -> Group {
    let mut group = Group::waiting();
    for (lane, it) in loads(kernel).iter().enumerate() {
        place(&mut group, lane, kernel, compiled, it);
    }
    group
}

fn rows(g: &Group) -> Vec<&Row> {
    let singles = [&g.step, &g.count, &g.side, &g.flips, &g.left, &g.cosine, &g.sine2, &g.unit];
    let drifts = [&g.energy, &g.momentum].into_iter().flat_map(|d| [&d.start, &d.inverse_scale, &d.worst]);
    let vectors = g.moments.iter().chain(&g.weight).chain(&g.axis).chain(&g.limit);
    let rows: Vec<_> = g.state.iter().chain(&g.carry).chain(vectors).chain(singles).chain(drifts).collect();
    // Nothing of a group is left out.
    assert_eq!(size_of::<Group>(), rows.len() * size_of::<Row>());
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
        let scalar = after(Isa::Scalar);
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

        // The case is worth comparing: the wild body overflowed, it alone (an explicit method may lose the fast
        // one too), and something was seen.
        for lane in 0..LANES {
            let finite = state(&scalar, lane).iter().all(|x| x.is_finite());
            assert!(finite != (lane == WILD) || lane == FAST, "{kernel:?} lane {lane}");
            assert_eq!(scalar.energy.worst.0[lane].is_finite(), finite, "{kernel:?} lane {lane}");
        }
        if kernel.watch == Watch::Flips {
            assert!(scalar.flips.0.iter().sum::<f64>() >= 10.0, "{kernel:?}");
        }
        if kernel.watch == Watch::Tilt {
            let lost = scalar.left.0.iter().filter(|t| t.is_finite()).count();
            assert!(scalar.sine2.0[0] > 0.01 && (5..LANES).contains(&lost), "{kernel:?}");
        }
    }
}

/// A body alone in a group of waiting lanes, 17 lanes further, has the bits that it has in company: of bodies
/// with other steps, of one that overflows, and of one that sends the others through the code for large angles.
#[test]
fn every_lane_is_alone() {
    for kernel in codes() {
        for isa in Isa::available() {
            let compiled = Compiled::new(kernel, isa);
            let mut company = full_group(kernel, compiled);
            run(&mut company, kernel, compiled);
            for (lane, it) in loads(kernel).iter().enumerate() {
                let elsewhere = (lane + 17) % LANES;
                let mut group = Group::waiting();
                place(&mut group, elsewhere, kernel, compiled, it);
                run(&mut group, kernel, compiled);
                assert_eq!(
                    lane_bits(&group, elsewhere),
                    lane_bits(&company, lane),
                    "{kernel:?} {isa:?} lane {lane}"
                );
            }
        }
    }
}

/// A step of 0 leaves every number of the state as it is.
#[test]
fn a_waiting_lane_stays() {
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
            assert_eq!(lane(group.flips), 0.0);
        }
    }
}

// --- Trajectories ---------------------------------------------------------------------------------------------

/// A body for each table in turn, one in between that overflows.
fn crowd(is_top: bool) -> Vec<Body> {
    let mut bodies: Vec<_> = (0..203).map(|i| body(i, is_top, i % 3 == 0)).collect();
    bodies[100].omega = [1e18, 1e18, 1.0];
    bodies
}

fn own_steps(n: usize) -> Vec<f64> {
    (0..n).map(|i| [0.03, 0.25, 0.003, 0.9][i % 4]).collect()
}

const TIMES: [f64; 5] = [-0.7, 0.0, 0.3, 0.31, 2.0];
const STRIDES: [u64; 4] = [0, 1, 40, 7];

#[derive(Clone, Copy)]
struct Question {
    is_top: bool,
    method: Method,
    record: Record,
    at_times: bool,
}

impl Question {
    fn ask(self, bodies: &[Body], steps: &[f64], threads: usize, isa: Isa) -> States {
        let schedule = if self.at_times { Schedule::Times(&TIMES) } else { Schedule::Strides(&STRIDES) };
        let Question { is_top, method, record, .. } = self;
        let solver = Solver::Steps(method);
        let request =
            Request { bodies, is_top, solver, record, schedule, steps, tolerance: None, max_steps: 500 };
        simulate(&request, threads, isa, &GO).unwrap().unwrap()
    }
}

/// Of the methods that share code for all bodies, the last: it has the longest table.
fn methods(is_top: bool) -> Vec<Method> {
    let all: Vec<_> = Method::ALL.into_iter().filter(|method| method.check(is_top, false).is_ok()).collect();
    let code = |method| {
        let tables =
            [true, false].map(|symmetric| Seat::of(method, &body(0, is_top, symmetric), is_top).table);
        (tables.map(Table::engine), tables.map(Table::is_processed))
    };
    let last = |&i: &usize| !all[i + 1..].iter().any(|&later| code(later) == code(all[i]));
    (0..all.len()).filter(last).map(|i| all[i]).collect()
}

fn questions() -> Vec<Question> {
    let mut all = Vec::new();
    for is_top in [false, true] {
        for method in methods(is_top) {
            for record in [Record::Rates, Record::Axis, Record::Attitude] {
                for at_times in [true, false] {
                    all.push(Question { is_top, method, record, at_times });
                }
            }
        }
    }
    all
}

/// Everything that is known of a body.
fn of_body(states: &States, i: usize) -> (Vec<u64>, Status, u64) {
    let n = states.status.len();
    let mut numbers = Vec::new();
    for field in
        [Some(&states.omega), states.vertical.as_ref(), states.attitude.as_ref()].into_iter().flatten()
    {
        let width = field.len() / n;
        numbers.extend_from_slice(&field[i * width..][..width]);
    }
    numbers.extend([states.energy_drift[i], states.momentum_drift[i], states.unit_drift[i]]);
    (all_bits(&numbers), states.status[i], states.steps[i])
}

#[test]
fn a_body_alone_and_in_a_crowd() {
    let isa = Isa::available()[0];
    for question in questions() {
        let bodies = crowd(question.is_top);
        let steps = own_steps(bodies.len());
        let crowd = question.ask(&bodies, &steps, 1, isa);
        for i in 0..bodies.len() {
            let alone = question.ask(&bodies[i..=i], &steps[i..=i], 1, isa);
            assert_eq!(of_body(&alone, 0), of_body(&crowd, i), "body {i}");
        }

        let mut mirrored = (bodies.clone(), steps.clone());
        mirrored.0.reverse();
        mirrored.1.reverse();
        let mirrored = question.ask(&mirrored.0, &mirrored.1, 1, isa);
        for i in 0..bodies.len() {
            assert_eq!(of_body(&mirrored, bodies.len() - 1 - i), of_body(&crowd, i), "body {i}");
        }

        // Every way to end is among them: 0.003 needs 900 steps for the times.
        let count = |status| crowd.status.iter().filter(|&&s| s == status).count();
        assert!(count(Status::NotFinite) >= 1 && count(Status::Finished) > 100);
        assert_eq!(count(Status::StepLimit), if question.at_times { 51 } else { 0 });
    }
}

#[test]
fn trajectories_on_any_number_of_threads_and_instruction_set() {
    for question in questions() {
        let bodies = crowd(question.is_top);
        let steps = own_steps(bodies.len());
        let everything = |threads, isa| {
            let states = question.ask(&bodies, &steps, threads, isa);
            (0..bodies.len()).map(|i| of_body(&states, i)).collect::<Vec<_>>()
        };
        let once = everything(1, Isa::Scalar);
        for threads in [1, 2, 3, 7] {
            assert_eq!(everything(threads, Isa::available()[0]), once, "{threads} threads");
        }
        for isa in Isa::available() {
            assert_eq!(everything(2, isa), once, "{isa:?}");
        }
    }
}

/// What else is recorded does not touch the rates, nor the vertical of a top.
#[test]
fn less_asked_is_the_same() {
    let isa = Isa::available()[0];
    for is_top in [false, true] {
        for method in methods(is_top) {
            let bodies = crowd(is_top);
            let steps = own_steps(bodies.len());
            let ask =
                |record| Question { is_top, method, record, at_times: true }.ask(&bodies, &steps, 2, isa);
            let attitude = ask(Record::Attitude);
            for record in [Record::Rates, Record::Axis] {
                let less = ask(record);
                assert_eq!(
                    all_bits(&less.omega),
                    all_bits(&attitude.omega),
                    "{record:?} {method:?} {is_top}"
                );
                if is_top && record == Record::Axis {
                    let verticals = [&less, &attitude].map(|s| all_bits(s.vertical.as_ref().unwrap()));
                    assert_eq!(verticals[0], verticals[1], "{method:?}");
                }
            }
        }
    }
}

// --- Closed forms ---------------------------------------------------------------------------------------------

/// Bodies of a closed form in its variables: ordinary ones, and beside them in the same registers those at every
/// border of its code: separatrices, near and met exactly, poles, turning points, stable axes, extreme units.
fn placed(kind: Kind) -> Vec<Body> {
    let special = |number: u64| -> Body {
        let ordinary = body(number, kind == Kind::Lagrange, kind != Kind::Free);
        let tiny = 10.0_f64.powi(-((number / 14) as i32) - 4);
        let free = |moments, omega| Body { moments, omega, ..ordinary };
        let top = |theta: f64, omega: [f64; 3], mgl| {
            let attitude = [(0.5 * theta).cos(), (0.5 * theta).sin(), 0.0, 0.0];
            Body { moments: [1.0, 1.0, 0.5], weight: [0.0, 0.0, mgl], omega, attitude }
        };
        let upright = |q| Body { attitude: q, ..top(0.0, [1.5, -0.5, 6.0], 4.0) };
        match (kind, number % 14) {
            (Kind::Free, 1) => free([1.0, 2.0, 3.0], [tiny, 1.0, tiny]),
            (Kind::Free, 2) => free([3.0, 2.0, 1.0], [0.0, -1.0, tiny]),
            (Kind::Free, 3) => free([1.0, 2.0, 2.25], [-0.375, 0.25, 0.5]),
            (Kind::Free, 4) => free([1.0, 3.0, 2.0], [tiny, 1.0, -tiny]),
            (Kind::Free, 5) => free([1.0, 1.0 + tiny, 1.5], [0.4, -0.3, 1.2]),
            (Kind::Free, 6) => free([1e-150, 2e-150, 2.5e-150], [3e8, 1e8, -2e8]),
            (Kind::Symmetric, 1) => free([1.5; 3], [0.3, 1.0, -2.0]),
            (Kind::Symmetric, 2) => free([2.0, 2.0, 3.0], [0.0; 3]),
            (Kind::Symmetric, 3) => free([2.0, 2.0, 3.0], [0.0, 0.0, -1e-200]),
            (Kind::Symmetric, 4) => free([1.0, 1.0, 0.2], [tiny, 0.0, 1e3]),
            (Kind::Lagrange, 1) => top(tiny, [0.0, 0.0, 3.0], 4.0),
            (Kind::Lagrange, 2) => top(tiny, [0.0, 0.0, 12.0], 4.0),
            (Kind::Lagrange, 3) => upright([1.0, 0.0, 0.0, 0.0]),
            (Kind::Lagrange, 4) => upright([0.0, 0.6, 0.8, 0.0]),
            (Kind::Lagrange, 5) => top(1.2, [0.0; 3], -4.0),
            (Kind::Lagrange, 6) => top(1.2, [2.0, 0.0, 0.0], 4.0),
            (Kind::Lagrange, 7) => top(1.2, [0.0, 0.7, 0.0], 4.0),
            (Kind::Lagrange, 8) => top(1.2, [0.3, 0.7, 6.0], -4.0),
            // Through the bottom at the speed that just reaches the top.
            (Kind::Lagrange, 9) => Body { attitude: [0.0, 1.0, 0.0, 0.0], ..top(0.0, [4.0, 0.0, 0.0], 4.0) },
            (Kind::Lagrange, 10) => top(1.2, [2.0, 0.3, 1e5], 1e-4),
            _ => ordinary,
        }
    };
    let places = (0..140).map(special).map(|body| (Place::of(&body).unwrap(), body));
    let of_kind = places.filter(|(place, _)| place.kind() == kind);
    let bodies: Vec<Body> = of_kind.map(|(place, body)| place.canonical(&body)).collect();
    assert!(bodies.len() >= 130, "{kind:?}: {}", bodies.len());
    bodies
}

const MOMENTS_OF_TIME: [f64; 6] = [2.0, -3.7, 0.0, 0.3, 41.3, 1e4];

/// What each lane is asked; see `Exit`.
fn asked(number: usize) -> [f64; 3] {
    [(number % 3) as f64, [0.05, 0.6, 1.0, 1.9][number % 4], [1.0, -1.0][number / 2 % 2]]
}

/// States, rates and exit of each lane: numbered bodies, the lanes at different times.
fn evaluated(kind: Kind, isa: Isa, lanes: &[(usize, Body)]) -> Vec<Vec<u64>> {
    let mut starts = StartRows::filled(&lanes[0].1);
    let nothing = Row([0.0; LANES]);
    let mut exits = ExitRows { axis: nothing, limit: nothing, direction: nothing };
    let mut times = [nothing; MOMENTS_OF_TIME.len()];
    for (lane, (number, body)) in lanes.iter().enumerate() {
        starts.set(lane, body);
        let [axis, limit, direction] = asked(*number);
        (exits.axis.0[lane], exits.limit.0[lane], exits.direction.0[lane]) = (axis, limit, direction);
        for (k, row) in times.iter_mut().enumerate() {
            row.0[lane] = MOMENTS_OF_TIME[(k + number) % MOMENTS_OF_TIME.len()];
        }
    }
    let evaluator = Evaluator::new(kind, isa);
    let mut states = [StateRows::ZERO; MOMENTS_OF_TIME.len()];
    let mut rates = states;
    let mut left = nothing;
    evaluator.states(&starts, &times, &mut states);
    evaluator.rates(&starts, &times, &mut rates);
    evaluator.exits(&starts, &exits, &mut left);
    let of_lane = |lane: usize| {
        let of_state = |state: &StateRows| {
            let rows = state.omega.iter().chain(&state.attitude);
            rows.map(|row| bits(row.0[lane])).collect::<Vec<u64>>()
        };
        let mut numbers: Vec<u64> = states.iter().chain(&rates).flat_map(of_state).collect();
        numbers.push(bits(left.0[lane]));
        numbers
    };
    (0..lanes.len()).map(of_lane).collect()
}

/// A body in all lanes at once, and among others in every lane, has the same bits.
#[test]
fn closed_forms_on_every_instruction_set_and_in_every_lane() {
    for kind in [Kind::Symmetric, Kind::Free, Kind::Lagrange] {
        let bodies: Vec<(usize, Body)> = placed(kind).into_iter().enumerate().collect();
        let alone = |it: &(usize, Body)| evaluated(kind, Isa::Scalar, &[*it; LANES]).swap_remove(0);
        let once: Vec<Vec<u64>> = bodies.iter().map(alone).collect();
        // A start that is no number would compare equal to anything that is none.
        let unknown = once.iter().flatten().filter(|&&x| x == f64::NAN.to_bits()).count();
        assert_eq!(unknown, 0, "{kind:?}");
        for isa in Isa::available() {
            for (it, expected) in bodies.iter().zip(&once) {
                for (lane, got) in evaluated(kind, isa, &[*it; LANES]).iter().enumerate() {
                    assert_eq!(got, expected, "{kind:?} {isa:?} lane {lane}: {it:?}");
                }
            }
            for shift in 0..LANES {
                let mut shifted = bodies.clone();
                shifted.rotate_left(shift);
                for lanes in shifted.chunks(LANES) {
                    for ((number, body), got) in lanes.iter().zip(evaluated(kind, isa, lanes)) {
                        assert_eq!(got, once[*number], "{kind:?} {isa:?} shift {shift}: {body:?}");
                    }
                }
            }
        }
    }
}

/// What is said of a whole motion.
#[test]
fn derived_quantities_on_every_instruction_set() {
    for is_top in [false, true] {
        for body in exact_crowd(is_top) {
            // As text, which shows every bit of a number and in which a NaN equals itself.
            let told = |isa| {
                let changes: Vec<_> = (0..3).map(|axis| sign_changes(isa, &body, axis)).collect();
                let times: Vec<_> = [0.1, 1.0, 2.0].map(|limit| tilt_time(isa, &body, limit)).into();
                let quantities = (free_quantities(isa, &body), top_quantities(isa, &body));
                format!("{changes:?} {times:?} {quantities:?}")
            };
            let scalar = told(Isa::Scalar);
            for isa in Isa::available() {
                assert_eq!(told(isa), scalar, "{isa:?} {body:?}");
            }
        }
    }
}

/// Bodies with every closed form in turn, those of one code side by side and not.
fn exact_crowd(is_top: bool) -> Vec<Body> {
    let bodies = |i: u64| {
        let mut body = body(i, is_top, is_top || i.is_multiple_of(3) || i > 150);
        match i % 11 {
            // A spin, an upright top, a hanging one, a swing in a plane.
            3 if !is_top => body.omega = [0.0, 0.7, 0.0],
            3 => {
                body = Body { weight: [0.0, 0.0, 1.5], moments: [1.0, 1.0, 1.2], ..body };
                (body.omega, body.attitude) = ([0.0, 0.0, 2.0], [0.6, 0.0, 0.0, 0.8]);
            }
            5 if is_top => {
                body = Body { moments: [1.0, 1.4, 0.9], weight: [0.0, 0.3, -0.7], ..body };
                (body.omega, body.attitude) = ([1.5, 0.0, 0.0], [0.8, 0.6, 0.0, 0.0]);
            }
            _ => {}
        }
        body
    };
    (0..203).map(bodies).collect()
}

fn ask_exactly(
    (is_top, bodies): (bool, &[Body]),
    times: &[f64],
    record: Record,
    threads: usize,
    isa: Isa,
) -> States {
    let steps = vec![f64::NAN; bodies.len()];
    let (solver, schedule) = (Solver::Exact, Schedule::Times(times));
    let request =
        Request { bodies, is_top, solver, record, schedule, steps: &steps, tolerance: None, max_steps: 0 };
    simulate(&request, threads, isa, &GO).unwrap().unwrap()
}

/// A body alone has its times in the lanes, a crowd has bodies in them.
#[test]
fn closed_forms_with_times_or_bodies_in_the_lanes() {
    let few = TIMES.to_vec();
    // More than are evaluated between two looks at the stop flag.
    let many: Vec<f64> = (0..300).map(|k| 0.37 * f64::from(k) - 40.0).collect();
    for is_top in [false, true] {
        let bodies = exact_crowd(is_top);
        for record in [Record::Rates, Record::Axis, Record::Attitude] {
            for times in [&few, &many] {
                let ask = |bodies: &[Body], threads, isa| {
                    ask_exactly((is_top, bodies), times, record, threads, isa)
                };
                let everything = |threads, isa| {
                    let states = ask(&bodies, threads, isa);
                    (0..bodies.len()).map(|i| of_body(&states, i)).collect::<Vec<_>>()
                };
                let once = everything(1, Isa::Scalar);
                assert!(once.iter().all(|body| body.1 == Status::Finished));
                for isa in Isa::available() {
                    for threads in [1, 2, 3] {
                        assert_eq!(everything(threads, isa), once, "{threads} threads, {isa:?}");
                    }
                    for i in 0..bodies.len() {
                        let alone = ask(&bodies[i..=i], 1, isa);
                        assert_eq!(of_body(&alone, 0), once[i], "body {i}, {isa:?}");
                    }
                }
            }
        }
    }
}

/// The state at a time does not depend on the other times, however many.
#[test]
fn closed_forms_at_any_number_of_times() {
    let times: Vec<f64> = (0..2 * 8192 + 5).map(|k| 0.01 * f64::from(k)).collect();
    for is_top in [false, true] {
        let bodies = &exact_crowd(is_top)[..2];
        let isa = Isa::available()[0];
        let omega = |times: &[f64]| ask_exactly((is_top, bodies), times, Record::Rates, 1, isa).omega;
        let all = omega(&times);
        for at in [0, 1, 31, 8191, 8192, 16383, 16384, 16388] {
            let single = omega(&times[at..=at]);
            for body in 0..2 {
                let in_all = &all[3 * (body * times.len() + at)..][..3];
                assert_eq!(all_bits(&single[3 * body..][..3]), all_bits(in_all), "body {body}, time {at}");
            }
        }
    }
}

/// What else is recorded does not touch the rates.
#[test]
fn less_asked_of_closed_forms_is_the_same() {
    for is_top in [false, true] {
        let bodies = exact_crowd(is_top);
        let isa = Isa::available()[0];
        let ask = |record| ask_exactly((is_top, &bodies), &TIMES, record, 2, isa).omega;
        let attitude = ask(Record::Attitude);
        for record in [Record::Rates, Record::Axis] {
            let less = ask(record);
            for (i, body) in bodies.iter().enumerate() {
                let [a, b] =
                    [&less, &attitude].map(|w| all_bits(&w[3 * TIMES.len() * i..][..3 * TIMES.len()]));
                assert_eq!(a, b, "{record:?} {body:?}");
            }
        }
    }
}

// --- Maps -----------------------------------------------------------------------------------------------------

const SAMPLES: u64 = 1000;

/// Pixels of both tables of a splitting, one impossible, one that overflows or needs too many steps.
fn map(is_top: bool, judge: Judge, criterion: Criterion, step: Option<f64>) -> Map {
    let pixel = |number, symmetric| Pixel {
        body: body(number, is_top, symmetric),
        omega_size: [0.3, 0.2, 0.1],
        attitude_size: 0.1,
        possible: true,
    };
    let mut pixels = vec![pixel(1, false), pixel(2, true), pixel(5, false), pixel(6, false), pixel(7, false)];
    pixels[2].possible = false;
    pixels[3].body.omega = [1e17; 3];
    Map {
        is_top,
        judge,
        pixels,
        omega_law: Law::Normal,
        attitude_law: Law::Direction,
        criterion,
        axis: -2,
        t_end: 4.0,
        step,
        max_steps: 2000,
        samples: SAMPLES,
        checked: 100,
        key: [2026, 11],
    }
}

fn maps() -> Vec<Map> {
    let [rk4, splitting] = [Method::Rk4, Method::Splitting].map(|method| Judge::Only(Solver::Steps(method)));
    vec![
        map(false, rk4, Criterion::NoFlip, Some(0.05)),
        map(false, splitting, Criterion::TiltFromStart(1.5), None),
        map(true, rk4, Criterion::TiltFromVertical(2.2), None),
        map(true, splitting, Criterion::NoFlip, Some(0.05)),
        map(true, splitting, Criterion::TiltFromStart(2.6), Some(0.05)),
    ]
}

/// Free bodies all in closed form; tops of one pixel in closed form, of the others stepped, in the same blocks.
fn maps_in_closed_form() -> Vec<Map> {
    let mut maps = vec![
        map(false, Judge::Auto, Criterion::NoFlip, None),
        map(false, Judge::Only(Solver::Exact), Criterion::NoFlip, None),
        map(true, Judge::Auto, Criterion::TiltFromVertical(2.2), None),
    ];
    for map in &mut maps {
        // Symmetric about the watched axis, a top's centre of mass on it.
        map.pixels[0].body = body(4, map.is_top, true);
    }
    maps
}

/// Everything but the time that it took.
fn timeless(mut statistics: Statistics) -> Statistics {
    statistics.nanoseconds = 0.0;
    statistics
}

fn merged(a: Statistics, b: Statistics) -> Statistics {
    Statistics {
        stable: a.stable + b.stable,
        unstable: a.unstable + b.unstable,
        undecided: a.undecided + b.undecided,
        failed: a.failed + b.failed,
        step_limit: a.step_limit + b.step_limit,
        not_finite: a.not_finite + b.not_finite,
        drifted: a.drifted + b.drifted,
        exact: a.exact + b.exact,
        checked: a.checked + b.checked,
        energy_drift: a.energy_drift.max(b.energy_drift),
        momentum_drift: a.momentum_drift.max(b.momentum_drift),
        earliest: a.earliest.min(b.earliest),
        steps: a.steps + b.steps,
        nanoseconds: 0.0,
    }
}

/// The whole map in pieces of `cut` samples.
fn in_pieces(map: &Map, cut: u64, threads: usize, isa: Isa) -> Vec<Statistics> {
    let none = Statistics { earliest: f64::INFINITY, ..Default::default() };
    let mut all = vec![none; map.pixels.len()];
    for start in (0..map.len()).step_by(cut as usize) {
        let (first, part) = map.run(start, map.len().min(start + cut), threads, isa, &GO).unwrap();
        for (pixel, statistics) in (first as usize..).zip(part) {
            all[pixel] = merged(all[pixel], timeless(statistics));
        }
    }
    all
}

/// The statistics of all samples of a map, after they were compared however it is cut and shared out.
fn compared(map: &Map) -> Statistics {
    let widest = Isa::available()[0];
    let whole = in_pieces(map, map.len(), 1, widest);
    for threads in [2, 3, 7] {
        assert_eq!(in_pieces(map, map.len(), threads, widest), whole, "{threads} threads");
    }
    for cut in [1, 13, 4096] {
        assert_eq!(in_pieces(map, cut, 1, widest), whole, "pieces of {cut}");
    }
    assert_eq!(in_pieces(map, 13, 3, widest), whole);
    for isa in Isa::available() {
        assert_eq!(in_pieces(map, map.len(), 2, isa), whole, "{isa:?}");
    }
    whole.into_iter().reduce(merged).unwrap()
}

#[test]
fn a_map_however_it_is_cut_and_shared_out() {
    for map in maps() {
        // The case is worth comparing.
        let total = compared(&map);
        assert!(total.stable > 0 && total.unstable > 0 && total.failed >= SAMPLES, "{total:?}");
        assert_eq!(total.stable + total.unstable + total.undecided + total.failed, 4 * SAMPLES);
        assert!(total.energy_drift > 0.0 && total.earliest < map.t_end);
    }
    for map in maps_in_closed_form() {
        let total = compared(&map);
        assert!(total.stable > 0 && total.unstable > 0 && total.earliest < map.t_end, "{total:?}");
        assert_eq!(total.exact, if map.is_top { SAMPLES } else { 4 * SAMPLES });
        assert_eq!(total.steps > 0, map.is_top, "{total:?}");
    }
}

#[test]
fn a_sample_alone_is_the_sample_of_the_map() {
    for mut map in maps().into_iter().chain(maps_in_closed_form()) {
        // Counted once: the steps of a statistic are those of both runs.
        map.checked = 0;
        let isa = Isa::available()[0];
        for flat in (0..map.len()).step_by(37) {
            let (pixel, sample) = (flat / SAMPLES, flat % SAMPLES);
            let (body, class, outcome) = map.sample(pixel, sample, isa, &GO).unwrap();
            let statistics = map.run(flat, flat + 1, 1, isa, &GO).unwrap().1[0];
            let mut expected = Statistics {
                energy_drift: f64::NAN,
                momentum_drift: f64::NAN,
                earliest: f64::INFINITY,
                ..Default::default()
            };
            if map.pixels[pixel as usize].possible {
                match class {
                    Class::Stable => expected.stable = 1,
                    Class::Unstable => expected.unstable = 1,
                    Class::Undecided => expected.undecided = 1,
                    Class::Failed => expected.failed = 1,
                }
                match outcome.status {
                    Status::StepLimit => expected.step_limit = 1,
                    Status::NotFinite => expected.not_finite = 1,
                    Status::Drifted => expected.drifted = 1,
                    Status::Finished | Status::Stopped => {}
                }
                expected.steps = outcome.steps;
                expected.exact = u64::from(outcome.exact);
                if outcome.status != Status::StepLimit && !outcome.exact {
                    // What overflowed lost all.
                    let lost = |drift: f64| if drift.is_nan() { f64::INFINITY } else { drift };
                    expected.energy_drift = lost(outcome.energy_drift);
                    expected.momentum_drift = lost(outcome.momentum_drift);
                }
                if class == Class::Unstable {
                    expected.earliest = outcome.left;
                }
            }
            // As text, in which a NaN equals itself.
            assert_eq!(format!("{:?}", timeless(statistics)), format!("{expected:?}"), "sample {flat}");
            assert_eq!(body, map.draw(isa, flat..flat + 1)[0]);
        }
    }
}

#[test]
fn draws_on_every_instruction_set() {
    let laws = [Law::None, Law::Normal, Law::Uniform, Law::Direction, Law::UniformAttitude];
    let numbers = |b: Body| all_bits(&[&b.moments[..], &b.weight, &b.omega, &b.attitude].concat());
    for omega_law in laws {
        for attitude_law in laws {
            let map = Map { omega_law, attitude_law, ..maps().swap_remove(2) };
            // From the last samples of a pixel to the first of the next but one.
            let range = 2 * SAMPLES - 40..3 * SAMPLES + 45;
            let alone = |flat: u64| numbers(map.draw(Isa::Scalar, flat..flat + 1)[0]);
            let scalar: Vec<_> = range.clone().map(alone).collect();
            for isa in Isa::available() {
                // Other cuts put a sample into other lanes.
                for offset in [0, 1, 7, 33] {
                    let drawn = map.draw(isa, range.start + offset..range.end);
                    let drawn: Vec<_> = drawn.into_iter().map(numbers).collect();
                    assert_eq!(drawn, scalar[offset as usize..], "{isa:?} {omega_law:?} {attitude_law:?}");
                }
            }
        }
    }
}
