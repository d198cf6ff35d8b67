//! Body-steps per second of every kernel as a share of the FMA peak measured in the same process.
//!
//! `cargo bench --bench kernels`, and the words that the names of some kernels contain. Thread CPU time, best of several
//! repeats, kernel and peak interleaved.

#[path = "timing.rs"]
mod timing;

use rigid::body::Body;
use rigid::forces::BodyForces;
use rigid::kernel::{Compiled, Entry, ForcesRows, Group, Kernel, KernelAssignment, System, load};
use rigid::method::{self, EngineName};
use rigid::observe::{Deviation, Observed, Tilt};
use rigid::parallel::thread_nanoseconds;
use rigid::simd::Isa;
use rigid::simd::LANES;
use std::hint::black_box;

/// The largest tilt, without a limit.
const TILT: Observed = Observed::Tilt(Tilt::within(f64::INFINITY));

const STEPS: usize = 2000;
const REPEATS: usize = 15;

/// Slightly different tumbling bodies, one in each lane; `None` if no method integrates them so.
fn bodies(compiled: Compiled) -> Option<Group> {
    let kernel = compiled.kernel();
    let symmetric = kernel.step.engine == EngineName::KickRotor;
    let weight = if kernel.system.scene.has_weight { [0.36, 0.24, 1.1] } else { [0.0; 3] };
    let mut group = Group::inactive();
    for lane in 0..LANES {
        let body = Body {
            moments: if symmetric { [1.0, 1.0, 0.7] } else { [1.0, 1.6, 0.7] },
            weight,
            omega: [0.31 * (1.0 + 1e-3 * lane as f64), -0.42, 0.93],
            attitude: [0.5; 4],
        };
        let assignments = method::ALL.iter().map(|of| KernelAssignment::of(of, &body, kernel.system.scene));
        let assignment = assignments.into_iter().find(|assignment| assignment.step == kernel.step)?;
        let mut deviation = Deviation::new([0.1, 0.2, 0.3, 0.4, 0.5, 0.6]);
        deviation.inverse_scale = [1.0; 3];
        let entry = Entry {
            axis: 3,
            deviation,
            ..Entry::unobserved(&body, BodyForces::NONE, (0.0, None), None, 0.02)
        };
        load(&mut group, lane, compiled, assignment, &entry);
    }
    Some(group)
}

/// The first rate of each body of a group: that about a symmetry axis, the third, is constant.
fn rates(group: &Group) -> Vec<f64> {
    group.state[0].0.to_vec()
}

/// Nanoseconds per body-step, once.
fn once(compiled: Compiled, start: &Group) -> Result<f64, String> {
    let mut group = black_box(start.clone());
    let elapsed = timing::timed(|| compiled.advance(&mut group, &ForcesRows::NONE, STEPS))?;
    timing::changed(&rates(start), &rates(black_box(&group)))?;
    Ok(elapsed / (STEPS * LANES) as f64)
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
        #[cfg(plain)]
        Isa::Scalar => f64::NAN,
    }
}

/// Floating-point operations of one step (fma = 2), counted by hand from the source; see benches/README.md.
fn flops(kernel: Kernel) -> Option<f64> {
    match (kernel.system, kernel.step.engine, kernel.observed) {
        // 4 stages of 3 mul, 3 x (3 stage fma, 5 add, 1 fma).
        (System::FreeRates, EngineName::Rk4, Observed::Nothing) => Some(12.0 + 3.0 * 13.0),
        // 4 x (6 mul + 6 fma; 3 mul + 3 fma), 3 x (3 stage add, 5 add, 1 fma), 3 x (3 stage fma, 5 add, 1 fma).
        (System::TopAxis, EngineName::Rk4, Observed::Nothing) => Some(4.0 * 27.0 + 3.0 * 10.0 + 3.0 * 13.0),
        // 12 stages of 6 mul, 3 x (50 fma of stages, 1 mul, 7 fma and an addition).
        (System::FreeRates, EngineName::Dop853, Observed::Nothing) => Some(72.0 + 3.0 * 116.0),
        // 12 x 27 as above and 3 mul, 6 x the same.
        (System::TopAxis, EngineName::Dop853, Observed::Nothing) => Some(360.0 + 6.0 * 116.0),
        (system, _, Observed::Nothing) => {
            let order = kernel.step.is_series().then_some(kernel.step.numbers.order as f64)?;
            let vectors = (system.len - 3) / 3;
            // Products; Euler's equations and the factor of each order; the sum and its compensation.
            let [products, of_order] = match system {
                System::FreeRates => [3.0, 3.0 + 1.0 + 3.0],
                System::TopAxis | System::TopTwoAxes => {
                    [3.0 + 6.0 * vectors as f64, 15.0 + 1.0 + system.len as f64]
                }
                _ => return None,
            };
            let numbers = system.len as f64;
            Some(products * order * (order + 1.0) + of_order * order + numbers * (order - 1.0 + 7.0))
        }
        _ => None,
    }
}

/// Prints a row for each kernel whose name contains a filter, the best of some repeats; returns how many.
///
/// # Errors
/// If a result is impossible.
pub fn print_rows(filter: Option<&str>, repeats: usize) -> Result<usize, String> {
    println!("{:40} {:>8} {:>9} {:>12} {:>10}", "kernel", "path", "ns/step", "M steps/s", "of peak");
    let (mut peaks, mut rows) = ([0.0_f64; 3], 0);
    use System::*;
    let systems = [
        (FreeRates, Observed::Nothing),
        (FreeRates, Observed::Flips),
        (FreeAxis, Observed::Nothing),
        (FreeAxis, TILT),
        (FreeAttitude, Observed::Nothing),
        (TopAxis, Observed::Nothing),
        (TopAxis, Observed::Flips),
        (TopAxis, TILT),
        (TopTwoAxes, TILT),
        (TopAttitude, Observed::Nothing),
        (TopTurns, Observed::Nothing),
        (ForcedAxis, Observed::Nothing),
        (ForcedTurns, Observed::Nothing),
        (TopTangent, Observed::Nothing),
        (TopTangent, Observed::Growth),
    ];
    for step in method::steps() {
        for (system, observed) in systems.into_iter().filter(|&(system, _)| system.is_moved_by(step)) {
            let kernel = Kernel { system, step, observed };
            let words = format!("{system:?} {step:?} {observed:?}");
            let name = words.split('(').next().unwrap_or_default();
            if filter.is_some_and(|filter| !name.contains(filter)) {
                continue;
            }
            for isa in Isa::available() {
                let compiled = Compiled::new(kernel, isa);
                let Some(start) = bodies(compiled) else { continue };
                let (mut time, mut peak) = (f64::MAX, 0.0_f64);
                for _ in 0..repeats {
                    time = time.min(once(compiled, &start).map_err(|why| format!("{name}: {why}"))?);
                    #[cfg(target_arch = "x86_64")]
                    {
                        peak = peak.max(fma_peak(isa));
                    }
                }
                peaks[isa as usize] = peaks[isa as usize].max(peak);
                let share = match flops(kernel) {
                    Some(count) if peak > 0.0 => {
                        timing::share(count / time, peak).map_err(|why| format!("{name}: {why}"))?
                    }
                    _ => f64::NAN,
                };
                println!("{name:40} {:>8} {time:>9.3} {:>12.0} {share:>10.2}", isa.name(), 1e3 / time);
                rows += 1;
            }
        }
    }
    for isa in Isa::available() {
        println!("FMA peak, {}: {:.1} Gflop/s", isa.name(), peaks[isa as usize]);
    }
    Ok(rows)
}

/// Measures all kernels, or those that the first argument names.
#[allow(dead_code)] // A test prints rows too.
fn main() -> Result<(), String> {
    let filter = std::env::args().nth(1).filter(|word| !word.starts_with("--"));
    print_rows(filter.as_deref(), REPEATS).map(|_| ())
}
