//! Body-steps per second of every kernel as a share of the FMA peak measured in the same process.
//!
//! `cargo bench --bench kernels`. Thread CPU time, best of several repeats, kernel and peak interleaved.

use rigid::kernel::Group;
use rigid::kernel::{Compiled, ForcingRows, Kernel, System};
use rigid::observe::{Displacement, Observed, Start};
use rigid::parallel::thread_nanoseconds;
use rigid::scheme::{self, Engine};
use rigid::simd::Isa;
use rigid::simd::{LANES, Row};
use rigid::start::Body;
use std::hint::black_box;

const STEPS: usize = 2000;
const REPEATS: usize = 15;

/// A group of slightly different tumbling bodies.
fn bodies(kernel: Kernel) -> Group {
    let mut group = Group::inactive();
    for lane in 0..LANES {
        let moments = if kernel.step.engine == Engine::KickRotor { [1.0, 1.0, 0.7] } else { [1.0, 1.6, 0.7] };
        let first = 0.31 * (1.0 + 1e-3 * lane as f64);
        let start = [first, -0.42, 0.93, 0.36, 0.48, 0.8, 0.8, -0.6, 0.0, 0.1, 0.2, 0.3];
        for i in 0..3 {
            group.moments[i].0[lane] = moments[i];
        }
        if kernel.system.scene().has_weight {
            group.weight = [Row([0.36; LANES]), Row([0.24; LANES]), Row([1.1; LANES])];
        }
        for i in 0..kernel.system.len() {
            group.state[i].0[lane] = start[i];
        }
        if let Some(at) = kernel.system.quaternion_at() {
            for i in 0..4 {
                group.state[at + i].0[lane] = 0.5;
            }
        }
        group.step.0[lane] = 0.02;
        let body = Body {
            moments,
            weight: [0.0; 3],
            omega: [start[0], start[1], start[2]],
            attitude: [1.0, 0.0, 0.0, 0.0],
        };
        let third = [0.0, 0.0, 1.0];
        let limit = f64::INFINITY;
        let rows = kernel.observed.start(&Start {
            body: &body,
            forcing: None,
            axis: 3,
            unit: third,
            direction: third,
            limit,
            displacement: &Displacement::NONE,
            bound: None,
            rates: body.omega,
            momentum: [0, 1, 2].map(|i| moments[i] * body.omega[i]),
            frame: [third, [1.0, 0.0, 0.0]],
        });
        for (row, number) in group.observed.iter_mut().zip(rows) {
            row.0[lane] = number;
        }
    }
    group
}

/// Nanoseconds per body-step, once.
fn once(compiled: Compiled, start: &Group) -> f64 {
    let mut group = black_box(start.clone());
    let begin = thread_nanoseconds();
    compiled.advance(&mut group, &ForcingRows::NONE, STEPS);
    let elapsed = thread_nanoseconds() - begin;
    black_box(&group);
    elapsed as f64 / (STEPS * LANES) as f64
}

/// Floating-point operations per nanosecond of a loop of independent FMAs.
#[cfg(target_arch = "x86_64")]
fn fma_peak(isa: Isa) -> f64 {
    use std::arch::x86_64::*;
    const LOOPS: usize = 100_000;
    macro_rules! peak {
        ($name:ident, $features:literal, $set:ident, $fma:ident, $lanes:literal) => {{
            #[target_feature(enable = $features)]
            fn $name() -> f64 {
                let factor = black_box($set(0.999_999));
                let term = black_box($set(1e-9));
                let mut sums = [$set(1.0); 12];
                let begin = thread_nanoseconds();
                for _ in 0..LOOPS {
                    for sum in &mut sums {
                        *sum = $fma(*sum, factor, term);
                    }
                }
                let elapsed = thread_nanoseconds() - begin;
                black_box(sums);
                (LOOPS * 12 * $lanes * 2) as f64 / elapsed as f64
            }
            // SAFETY: the caller names an available instruction set.
            unsafe { $name() }
        }};
    }
    match isa {
        Isa::Avx512 => peak!(wide, "avx512f", _mm512_set1_pd, _mm512_fmadd_pd, 8),
        Isa::Avx2 => peak!(narrow, "avx2,fma", _mm256_set1_pd, _mm256_fmadd_pd, 4),
        Isa::Scalar => f64::NAN,
    }
}

/// Floating-point operations of one step (fma = 2), counted by hand from the source; see benches/README.md.
fn flops(kernel: Kernel) -> Option<f64> {
    match (kernel.system, kernel.step.engine, kernel.observed) {
        // 4 right-hand sides of 6 mul, 3 x 3 stage fma, 3 x (2 fma, 1 add, 1 fma).
        (System::FreeRates, Engine::Rk4, Observed::Nothing) => Some(24.0 + 18.0 + 21.0),
        // 4 x (6 mul + 6 fma; 3 mul + 3 fma), 18 stage fma, 6 x (2 fma + 1 add + 1 fma).
        (System::TopAxis, Engine::Rk4, Observed::Nothing) => Some(4.0 * 27.0 + 36.0 + 42.0),
        (system, _, Observed::Nothing) => {
            let order = kernel.step.is_series().then_some(kernel.step.numbers.order as f64)?;
            let vectors = (system.len() - 3) / 3;
            // Products; Euler's equations and the factor of each order; the sum and its compensation.
            let [products, of_order] = match system {
                System::FreeRates => [3.0, 3.0 + 1.0 + 3.0],
                System::TopAxis | System::TopTwoAxes => {
                    [3.0 + 6.0 * vectors as f64, 15.0 + 1.0 + system.len() as f64]
                }
                _ => return None,
            };
            let numbers = system.len() as f64;
            Some(products * order * (order + 1.0) + of_order * order + numbers * (order - 1.0 + 7.0))
        }
        _ => None,
    }
}

fn main() {
    let filter = std::env::args().nth(1).filter(|a| !a.starts_with("--"));
    println!("{:40} {:>8} {:>9} {:>12} {:>10}", "kernel", "path", "ns/step", "M steps/s", "of peak");
    let mut peaks = [0.0_f64; 3];
    use System::*;
    let systems = [
        (FreeRates, Observed::Nothing),
        (FreeRates, Observed::Flips),
        (FreeAxis, Observed::Nothing),
        (FreeAxis, Observed::Tilt),
        (FreeAttitude, Observed::Nothing),
        (TopAxis, Observed::Nothing),
        (TopAxis, Observed::Flips),
        (TopAxis, Observed::Tilt),
        (TopTwoAxes, Observed::Tilt),
        (TopAttitude, Observed::Nothing),
        (TopTangent, Observed::Nothing),
        (TopTangent, Observed::Growth),
        (ReducedTopAxis, Observed::Nothing),
        (ReducedTopAttitude, Observed::Nothing),
    ];
    for step in scheme::steps() {
        for (system, observed) in systems.into_iter().filter(|&(system, _)| system.is_moved_by(step)) {
            let kernel = Kernel { system, step, observed };
            let name = format!("{system:?} {step:?} {observed:?}");
            if filter.as_ref().is_some_and(|f| !name.contains(f.as_str())) {
                continue;
            }
            let start = bodies(kernel);
            for isa in Isa::available() {
                if isa == Isa::Scalar {
                    continue;
                }
                let compiled = Compiled::new(kernel, isa);
                let (mut time, mut peak) = (f64::MAX, 0.0_f64);
                for _ in 0..REPEATS {
                    time = time.min(once(compiled, &start));
                    #[cfg(target_arch = "x86_64")]
                    {
                        peak = peak.max(fma_peak(isa));
                    }
                }
                peaks[isa as usize] = peaks[isa as usize].max(peak);
                let share = flops(kernel).map_or(String::from("-"), |f| format!("{:.2}", f / time / peak));
                println!("{name:40} {:>8} {time:>9.3} {:>12.0} {share:>10}", isa.name(), 1e3 / time);
            }
        }
    }
    for isa in Isa::available() {
        if isa != Isa::Scalar {
            println!("FMA peak, {}: {:.1} Gflop/s", isa.name(), peaks[isa as usize]);
        }
    }
}
