//! Observables: a few numbers of a motion that are updated during the integration. Nothing is stored per step.
//!
//! An observable is one type, listed in `observables!`. Each body has a few rows of numbers, which the observable
//! updates after each step and after each block of steps. Code is compiled only for systems that the observable fits.

mod bounds;
mod dense;
mod flips;
mod growth;
mod mean_rate;
mod tilt;

pub use bounds::{Bound, Bounds, Direction, Quantity};
pub use flips::Flips;
pub use growth::{Deviation, Growth};
pub use mean_rate::MeanRate;
pub use tilt::{Tilt, largest_tilt};

use crate::forces::{ForcesInterval, OrbitPlace};
use crate::method::{Coefficients, Engine, in_halves};
use crate::real::{Apart, Pack, Real};
use crate::scene::{Layout, Model, Parameters};
use crate::simd::Row;
use crate::start::Body;
use std::marker::PhantomData;

/// The row of the time at which stability was lost, the same for every observable; infinite before.
pub const EXIT_TIME: usize = 0;

/// The rows of one body.
pub type Rows<R> = [R; MAX_ROWS];

/// The numbers of an observable for one body.
pub trait Observable {
    /// Number of rows for each body, `EXIT_TIME` among them.
    const ROWS: usize;
    /// Number of leading rows that change after the start.
    const CHANGING: usize;
    /// The numbers at the start.
    fn start(start: &Start) -> Rows<f64>;
    /// The observed value at the end.
    fn outcome(rows: &Rows<f64>) -> f64;
}

/// Updates of an observable by the steps of a model in a layout.
pub trait Update<R: Real, M: Model<R>, L: Layout, const D: usize>: Observable {
    /// Whether the observable fits the model and the layout. Code is compiled only if the observable fits.
    const FITS: bool;
    /// Updates the rows after a step.
    fn after_step<S: Engine<R, M, L, D>>(
        engine: &S,
        p: &Parameters<R>,
        rows: &mut Rows<R>,
        segment: &Segment<R, D>,
    );
    /// Updates the rows after a step over an anomaly of a body for which it matters what is inside the step.
    #[inline(always)]
    fn look<S: Engine<R, M, L, D>>(
        _engine: &S,
        _p: &Parameters<R>,
        _rows: &mut Rows<R>,
        _segment: &Segment<R, D>,
    ) {
        unreachable!("only some observables look inside such steps")
    }
    /// Updates the rows at the end of a block of steps.
    #[inline(always)]
    fn after_block<S: Engine<R, M, L, D>>(_engine: &S, _p: &Parameters<R>, _rows: &mut Rows<R>, _y: &[R; D]) {
    }
}

/// A look inside a step over an anomaly, of the bodies that need it.
struct Look<'a, O, R: Real, M, L, S, const D: usize> {
    engine: &'a S,
    p: &'a Parameters<R>,
    rows: &'a mut Rows<R>,
    begin: R,
    before: &'a [R; D],
    after: &'a [R; D],
    wanted: R::Mask,
    of: PhantomData<(O, M, L)>,
}

impl<O, R, M, L, S, const D: usize> Apart for Look<'_, O, R, M, L, S, D>
where
    O: Update<R, M, L, D>,
    R: Real,
    M: Model<R>,
    L: Layout,
    S: Engine<R, M, L, D>,
{
    #[inline(always)]
    fn run(self) {
        let Look { engine, p, rows, begin, before, after, wanted, .. } = self;
        let mut seen = *rows;
        O::look(engine, p, &mut seen, &Segment { begin, before, after, dense: &Coefficients::new() });
        for r in 0..O::CHANGING {
            rows[r] = R::select(wanted, seen[r], rows[r]);
        }
    }
}

/// Updates the rows of the bodies that need the motion inside a step over an anomaly, in a function of its own.
#[inline(always)]
fn look_inside<O, R, M, L, S, const D: usize>(
    engine: &S,
    p: &Parameters<R>,
    rows: &mut Rows<R>,
    segment: &Segment<R, D>,
    wanted: R::Mask,
) where
    O: Update<R, M, L, D>,
    R: Real,
    M: Model<R>,
    L: Layout,
    S: Engine<R, M, L, D>,
{
    if R::any(wanted) {
        let &Segment { begin, before, after, .. } = segment;
        R::apart(Look::<O, R, M, L, S, D> { engine, p, rows, begin, before, after, wanted, of: PhantomData });
    }
}

/// The motion inside a step, in a function that all observables share.
struct MotionInside<'a, R: Real, M, L, S, const D: usize> {
    engine: &'a S,
    p: &'a Parameters<R>,
    before: &'a [R; D],
    dense: &'a mut Coefficients<R, D>,
    of: PhantomData<(M, L)>,
}

impl<R: Real, M: Model<R>, L: Layout, S: Engine<R, M, L, D>, const D: usize> Apart
    for MotionInside<'_, R, M, L, S, D>
{
    #[inline(always)]
    fn run(self) {
        let (mut after, mut unused) = (*self.before, *self.before);
        self.engine.step_inside(self.p, &mut after, &mut unused, self.dense);
    }
}

/// The motion inside a step, which is made once more.
#[inline(always)]
fn motion_inside<R: Real, M: Model<R>, L: Layout, S: Engine<R, M, L, D>, const D: usize>(
    engine: &S,
    p: &Parameters<R>,
    before: &[R; D],
) -> Coefficients<R, D> {
    let mut dense = Coefficients::new();
    R::apart(MotionInside { engine, p, before, dense: &mut dense, of: PhantomData::<(M, L)> });
    dense
}

/// A bound from below of a number inside a step, from its values and slopes at both ends: the least control point of the
/// cubic, and what the number may be below the cubic. That is at most `s^4 / 384` of the size of a number that turns by
/// `s` in the step; a sixteenth of the slopes is twenty times as much for steps up to 1 rad.
#[inline(always)]
fn lowest_inside<R: Real>([begin, end]: [R; 2], [begin_slope, end_slope]: [R; 2]) -> R {
    let third = R::splat(1.0 / 3.0);
    let (after_begin, before_end) = (third.fma(begin_slope, begin), third.fnma(end_slope, end));
    let lowest = begin.min(after_begin).min(before_end.min(end));
    let spread = begin_slope.abs() + end_slope.abs();
    spread.fnma(R::splat(1.0 / 16.0), lowest)
}

/// Data of a body at its start for an observable.
pub struct Start<'a> {
    /// The body.
    pub body: &'a Body,
    /// Forces of the body from the start on, and a bound of its |omega|; `None` without forces.
    pub forces: Option<(&'a ForcesInterval<'a, f64>, f64)>,
    /// The observed body axis: 1, 2, 3 or -1, -2, -3; 0 for none.
    pub axis: i32,
    /// The observed body axis as a unit vector, in the axes of the kernel.
    pub unit: [f64; 3],
    /// The direction in space that is integrated for the observable, in body components along the axes of the kernel.
    pub direction: [f64; 3],
    /// The largest allowed angle.
    pub limit: f64,
    /// The deviation vector at the start.
    pub deviation: &'a Deviation,
    /// The bound that is observed, if one is.
    pub bound: Option<&'a Bound>,
    /// The variables of further forces.
    pub own: &'a [f64],
    /// The place on the orbit, and the axes of its frame in the body, of a body that is integrated over the anomaly.
    pub on_orbit: Option<(&'a OrbitPlace, [[f64; 3]; 3])>,
    /// Rates and angular momentum, in the axes of the kernel.
    pub rates: [f64; 3],
    /// See `rates`.
    pub momentum: [f64; 3],
    /// Space axes 3 and 1 in body components, along the axes of the kernel; anything where they are not integrated.
    pub frame: [[f64; 3]; 2],
}

/// A completed step.
pub struct Segment<'a, R, const D: usize> {
    /// Time at the begin of the step.
    pub begin: R,
    /// The state before the step.
    pub before: &'a [R; D],
    /// The state after the step.
    pub after: &'a [R; D],
    /// The coefficients of the motion in powers of the fraction of the step, if the step is a series.
    pub dense: &'a Coefficients<R, D>,
}

/// The list of all observables.
macro_rules! observables {
    ($($name:ident)*) => {
        /// The observable of a kernel.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[allow(missing_docs)] // The names are those of the types.
        pub enum Observed {
            Nothing,
            $($name,)*
        }

        /// The largest number of rows of an observable.
        pub const MAX_ROWS: usize = {
            let mut most = 1;
            $(most = if $name::ROWS > most { $name::ROWS } else { most };)*
            most
        };

        impl Observed {
            /// Whether the observable fits a model in a layout.
            pub const fn fits<M: Model<f64>, L: Layout, const D: usize>(self) -> bool {
                match self {
                    Observed::Nothing => true,
                    $(Observed::$name => <$name as Update<f64, M, L, D>>::FITS,)*
                }
            }

            /// The numbers at the start.
            pub fn start(self, start: &Start) -> Rows<f64> {
                match self {
                    Observed::Nothing => UNOBSERVED,
                    $(Observed::$name => $name::start(start),)*
                }
            }

            /// The observed value at the end; NaN if nothing was observed.
            pub fn outcome(self, rows: &Rows<f64>) -> f64 {
                match self {
                    Observed::Nothing => f64::NAN,
                    $(Observed::$name => $name::outcome(rows),)*
                }
            }

            /// Updates the rows after a step of the pack that begins at a lane.
            #[inline(always)]
            pub fn after_step<P: Pack, M: Model<P>, L: Layout, S: Engine<P, M, L, D>, const D: usize>(
                self,
                engine: &S,
                p: &Parameters<P>,
                rows: &mut [Row; MAX_ROWS],
                at: usize,
                segment: &Segment<P, D>,
            ) {
                $(if const { <$name as Update<P, M, L, D>>::FITS } && self == Observed::$name {
                    let mut values = [P::splat(0.0); MAX_ROWS];
                    load::<P, $name>(rows, at, &mut values);
                    <$name as Update<P, M, L, D>>::after_step(engine, p, &mut values, segment);
                    store::<P, $name>(rows, at, &values);
                })*
            }

            /// Updates the rows at the end of a block of steps of the pack that begins at a lane.
            #[inline(always)]
            pub fn after_block<P: Pack, M: Model<P>, L: Layout, S: Engine<P, M, L, D>, const D: usize>(
                self,
                engine: &S,
                p: &Parameters<P>,
                rows: &mut [Row; MAX_ROWS],
                at: usize,
                y: &[P; D],
            ) {
                $(if const { <$name as Update<P, M, L, D>>::FITS } && self == Observed::$name {
                    let mut values = [P::splat(0.0); MAX_ROWS];
                    load::<P, $name>(rows, at, &mut values);
                    <$name as Update<P, M, L, D>>::after_block(engine, p, &mut values, y);
                    store::<P, $name>(rows, at, &values);
                })*
            }
        }
    };
}
observables! { Flips Tilt Growth Bounds MeanRate }

/// The rows of a body that is not observed.
pub const UNOBSERVED: Rows<f64> = {
    let mut rows = [0.0; MAX_ROWS];
    rows[EXIT_TIME] = f64::INFINITY;
    rows
};

#[inline(always)]
fn load<P: Pack, O: Observable>(rows: &[Row; MAX_ROWS], at: usize, values: &mut Rows<P>) {
    let length = const { O::ROWS };
    in_halves!(r in length { values[r] = P::load(&rows[r].0[at..]); });
}

#[inline(always)]
fn store<P: Pack, O: Observable>(rows: &mut [Row; MAX_ROWS], at: usize, values: &Rows<P>) {
    for r in 0..O::CHANGING {
        values[r].store(&mut rows[r].0[at..]);
    }
}

/// Three neighbouring rows.
#[inline(always)]
fn three<R: Real>(rows: &Rows<R>, first: usize) -> [R; 3] {
    [rows[first], rows[first + 1], rows[first + 2]]
}

/// The component of a vector along a frame axis; the sum is exact, because two components of `axis` are zero.
#[inline(always)]
fn along<R: Real>(axis: &[R; 3], v: &[R; 3]) -> R {
    axis[0].fma(v[0], axis[1].fma(v[1], axis[2] * v[2]))
}

/// `at`, unless stability was lost before.
#[inline(always)]
fn first_time<R: Real>(exit_time: R, at: R) -> R {
    R::select(exit_time.lt(R::splat(f64::INFINITY)), exit_time, at)
}
