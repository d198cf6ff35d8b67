//! The doors of the core: public functions that take numbers and names of a caller. Bytes become a call of one of them.
//!
//! Whatever the numbers are, a door refuses them or gives a result that is one: states that are called finished are
//! finite, samples are counted once, and nothing panics.

use rigid::body::{Body, unit_quaternion};
use rigid::call::Call;
use rigid::error::Error;
use rigid::exact::derived::{free_quantities, saddle, sign_changes, tilt_time, top_quantities};
use rigid::forces::Forces;
use rigid::inertia::{check_moments, principal_axes};
use rigid::map::{Check, Condition, Criterion, Distributions, Logic, Map, NAMED, Pixel, clopper_pearson};
use rigid::method::{self, AnyMethod, default_step};
use rigid::parallel::Interrupt;
use rigid::sample::Distribution;
use rigid::scene::{FREE, Scene, TOP};
use rigid::simd::Isa;
use rigid::special;
use rigid::status::Status;
use rigid::trajectory::{self, Motion, Record, Request, Schedule};

/// The steps that a body may take.
const MAX_STEPS: u64 = 500;

/// Calls the door that the first byte names.
pub fn knock(bytes: &[u8]) {
    let Some((&door, rest)) = bytes.split_first() else { return };
    let numbers = &mut Bytes(rest);
    match door % 7 {
        0 => simulate(numbers),
        1 => map(numbers),
        2 => closed_forms(numbers),
        3 => special_functions(numbers),
        4 => forcing_and_axes(numbers),
        5 => motion(numbers),
        _ => names(rest),
    }
}

/// Bytes that are read as numbers; after the last one all are zero.
struct Bytes<'a>(&'a [u8]);

impl Bytes<'_> {
    fn byte(&mut self) -> u8 {
        let Some((&first, rest)) = self.0.split_first() else { return 0 };
        self.0 = rest;
        first
    }

    fn below(&mut self, count: usize) -> usize {
        usize::from(self.byte()) % count
    }

    fn of<T: Copy, const N: usize>(&mut self, all: [T; N]) -> T {
        all[self.below(N)]
    }

    /// Mostly an ordinary number, at times any double.
    fn number(&mut self) -> f64 {
        let special = [0.0, -0.0, 5e-324, 1e-300, 1e-15, 1e15, 1e300, f64::INFINITY, f64::NAN];
        match self.byte() {
            0..32 => self.of(special),
            32..64 => f64::from_bits(u64::from_le_bytes([(); 8].map(|()| self.byte()))),
            64..96 => self.small(),
            _ => self.small() / 8.0,
        }
    }

    fn small(&mut self) -> f64 {
        f64::from(self.byte().cast_signed())
    }

    fn vector<const N: usize>(&mut self) -> [f64; N] {
        [(); N].map(|()| self.number())
    }

    fn list<T>(&mut self, most: usize, mut one: impl FnMut(&mut Self) -> T) -> Vec<T> {
        (0..self.below(most + 1)).map(|_| one(self)).collect()
    }

    fn isa(&mut self) -> Isa {
        let available = Isa::available();
        available[self.below(available.len())]
    }

    fn scene(&mut self) -> &'static Scene {
        self.of([&FREE, &TOP])
    }

    /// A body whose moments and attitude were let in; rates and weight may be any numbers.
    fn body(&mut self, scene: &Scene) -> Body {
        let moments =
            self.of([[1.0, 2.0, 3.0], [1.0, 1.0, 0.5], [2.0, 2.0, 2.0], [1e-9, 1.0, 1.0], [1.0, 2.0, 2.5]]);
        let other = self.vector();
        let moments = if self.below(2) == 0 || check_moments(other).is_err() { moments } else { other };
        let weight = match (scene.has_weight, self.below(2)) {
            (false, _) => [0.0; 3],
            (true, 0) => [0.0, 0.0, self.number()],
            (true, _) => self.vector(),
        };
        let attitude = unit_quaternion(self.vector()).unwrap_or([1.0, 0.0, 0.0, 0.0]);
        Body { moments, weight, omega: self.vector(), attitude }
    }

    fn forcing(&mut self) -> Result<Forces, Error> {
        let mut times = self.list(4, Bytes::number);
        if self.below(4) > 0 {
            times.sort_by(f64::total_cmp);
        }
        let rows = times.len().max(1) + usize::from(self.byte() == 7);
        let [body, space] = [(); 2].map(|()| (0..rows).map(|_| self.vector()).collect::<Vec<_>>());
        let damping = match self.below(3) {
            0 => [0.5, 0.25, 0.125, 0.0, 0.0, 0.0],
            1 => {
                let even = self.number().abs();
                [even, even, even, 0.0, 0.0, 0.0]
            }
            _ => self.vector(),
        };
        Forces::new(&times, &body, &space, &[damping])
    }

    fn method(&mut self) -> AnyMethod {
        match self.below(1 + method::ALL.len()) {
            0 => AnyMethod::Exact,
            number => AnyMethod::Steps(method::ALL[number - 1]),
        }
    }
}

/// A result is let out; a refusal must not be that of a panic.
fn let_out<T>(result: Result<T, Error>) -> Option<T> {
    if let Err(Error::Fault { words }) = &result {
        panic!("a worker panicked: {words}");
    }
    result.ok()
}

fn simulate(numbers: &mut Bytes) {
    let scene = numbers.scene();
    let mut bodies = numbers.list(40, |numbers| numbers.body(scene));
    let forces = if numbers.below(3) == 0 { let_out(numbers.forcing()) } else { None };
    let method = numbers.method();
    let mut times = numbers.list(5, Bytes::number);
    // The caller checks that times ascend and that numbers of the start are finite.
    times.retain(|time| time.is_finite());
    times.sort_by(f64::total_cmp);
    bodies.retain(|body| body.omega.iter().chain(&body.weight).all(|x| x.is_finite()));
    let strides = numbers.list(3, |numbers| u64::from(numbers.byte()));
    let schedule = if numbers.below(4) == 0 { Schedule::Strides(&strides) } else { Schedule::Times(&times) };
    let step = numbers.number().abs().max(1e-300);
    let request = Request {
        steps: &vec![step; bodies.len()],
        bodies: &bodies,
        scene,
        forces: forces.as_ref().unwrap_or(Forces::NONE),
        method,
        record: numbers.of([Record::Rates, Record::Axis, Record::Attitude]),
        schedule,
        refinement: numbers.of([1.0, 1.25, 3.0]),
        tolerance: (numbers.below(4) == 0).then(|| numbers.of([1e-16, 1e-9, 1e-3, 1.0])),
        max_steps: MAX_STEPS,
    };
    let (isa, count) = (numbers.isa(), request.schedule.len());
    let Some(states) = let_out(trajectory::simulate(&request, Call::to_the_end(isa, 2))) else {
        return;
    };
    assert_eq!((states.status.len(), states.rates().len()), (bodies.len(), 3 * count * bodies.len()));
    for (body, &status) in states.status.iter().enumerate() {
        let rates = &states.rates()[3 * count * body..][..3 * count];
        assert!(
            status != Status::Finished || rates.iter().all(|x| x.is_finite()),
            "{status:?} {:?}",
            bodies[body]
        );
    }
}

fn motion(numbers: &mut Bytes) {
    let scene = numbers.scene();
    let mut bodies = numbers.list(40, |numbers| numbers.body(scene));
    bodies.retain(|body| body.omega.iter().chain(&body.weight).all(|x| x.is_finite()));
    let forces = if numbers.below(3) == 0 { let_out(numbers.forcing()) } else { None };
    let forces = forces.unwrap_or(Forces::NONE.copied().expect("there is room for none"));
    let AnyMethod::Steps(method) = numbers.method() else { return };
    let (isa, never) = (numbers.isa(), Interrupt::never());
    let Some(mut motion) = let_out(Motion::new(&bodies, 0.0, scene, method, forces, isa)) else { return };
    for _ in 0..3 {
        let torques = numbers.list(2, Bytes::vector);
        if let_out(motion.step(numbers.number(), &torques, 2, &never)).is_none() {
            return;
        }
        for body in motion.bodies() {
            let length = body.attitude.iter().map(|x| x * x).sum::<f64>().sqrt();
            assert!((length - 1.0).abs() <= 0.1, "{body:?}");
        }
    }
}

fn map(numbers: &mut Bytes) {
    let scene = numbers.scene();
    let distributions = [
        Distribution::None,
        Distribution::Normal,
        Distribution::Uniform,
        Distribution::Direction,
        Distribution::VonMisesFisher(0),
    ];
    let (_, needed, criterion) = numbers.of(NAMED);
    let asked = Map {
        scene,
        forces: None,
        method: if numbers.below(2) == 0 { AnyMethod::Auto } else { numbers.method() },
        pixels: numbers.list(3, |numbers| Pixel {
            body: numbers.body(scene),
            omega_size: numbers.vector(),
            attitude_size: numbers.vector(),
            possible: numbers.below(4) > 0,
        }),
        distributions: Distributions {
            omega: numbers.of(distributions),
            attitude: if numbers.below(4) == 0 {
                Distribution::UniformAttitude
            } else {
                numbers.of(distributions)
            },
            ..Distributions::NONE
        },
        mixture: Vec::new(),
        conditions: vec![Condition {
            axis: numbers.of([-3, -2, -1, 1, 2, 3, 0]),
            criterion: criterion(&numbers.vector::<4>()[..needed]),
        }],
        logic: Logic::parse("0", 1).unwrap(),
        measures: Vec::new(),
        t_end: numbers.number(),
        step: (numbers.below(2) == 0).then(|| numbers.number()),
        max_steps: MAX_STEPS,
        samples: u64::from(numbers.byte()),
        check: Check::Before(numbers.byte().into()),
        key: [numbers.byte().into(), u64::MAX],
        numbers: Vec::new(),
        first: Vec::new(),
    };
    let Some(map) = let_out(asked.checked()) else { return };
    let isa = numbers.isa();
    let ran = let_out(map.run(0, map.len(), Call::to_the_end(isa, 2)));
    for (pixel, s) in map.pixels.iter().zip(ran.expect("a map that was let in is computed").1) {
        let counted = s.stable + s.unstable + s.undecided + s.failed;
        assert_eq!(counted, if pixel.possible { map.samples } else { 0 });
        assert!(s.step_limit + s.not_finite + s.drifted <= map.samples && s.exact <= map.samples);
    }
}

fn closed_forms(numbers: &mut Bytes) {
    let scene = numbers.scene();
    let body = numbers.body(scene);
    let isa = numbers.isa();
    let free = free_quantities(isa, &body);
    assert!(!(free.period() < 0.0), "{body:?}");
    top_quantities(isa, &body);
    saddle(isa, &body);
    for times in (0..3).filter_map(|axis| sign_changes(isa, &body, axis)) {
        assert!(!times.iter().any(|&time| time < 0.0), "{times:?} {body:?}");
    }
    assert!(tilt_time(isa, &body, numbers.number()).is_none_or(|time| !(time < 0.0)), "{body:?}");
}

fn special_functions(numbers: &mut Bytes) {
    let [x, y, z, p] = numbers.vector();
    special::sincos(x);
    special::exp(x);
    special::ln(x);
    special::atan2(y, x);
    special::rodrigues(x);
    special::carlson_rf(x, y, z);
    special::carlson_rc(x, y);
    special::carlson_rd(x, y, z);
    special::carlson_rj(x, y, z, p);
    special::agm(x, y);
    special::jacobi(x, y);
    special::complete_k(x);
    let [successes, trials] = [numbers.byte(), numbers.byte()].map(|byte| 1_u64 << (byte % 60));
    if let Some([lower, upper]) = let_out(clopper_pearson(successes, trials, numbers.number())) {
        let share = successes as f64 / trials as f64;
        assert!((0.0..=share).contains(&lower) && (share..=1.0).contains(&upper), "{successes} of {trials}");
    }
}

fn forcing_and_axes(numbers: &mut Bytes) {
    if let Some((_, axes)) = let_out(principal_axes([(); 3].map(|()| numbers.vector()))) {
        assert!(axes.iter().flatten().all(|x| x.abs() <= 1.0 + 1e-12));
    }
    let Some(all) = let_out(numbers.forcing()) else { return };
    let forces = all.of(0);
    let body = numbers.body(&FREE);
    let time = numbers.number();
    let modes = forces.damping.modes(body.moments);
    if forces.table.check_reaches(time).is_ok() {
        forces.interval(time, numbers.below(2) == 0, modes);
        forces.table.next_knot(time, numbers.below(2) == 0);
    }
    if let AnyMethod::Steps(method) = numbers.method() {
        default_step(method, body.step_rate(method, forces, [0.0, time]));
    }
}

fn names(bytes: &[u8]) {
    let name = String::from_utf8_lossy(bytes);
    let refused = [
        AnyMethod::parse(&name).err(),
        Scene::parse(&name).err(),
        Distribution::parse("distribution", &name).err(),
        // A known criterion of more limits is refused by their number.
        Criterion::parse(&name, &[1.0]).err().filter(|error| !matches!(error, Error::Shape { .. })),
    ];
    assert!(refused.iter().flatten().all(|error| error.to_string().contains(&*name)));
}
