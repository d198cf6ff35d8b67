//! Observables: a few numbers of a motion that are updated during the integration. Nothing is stored per step.
//!
//! An observable is one type, listed in `observables!`. Each body has a few rows of numbers, which the observable
//! updates after each step. Code is compiled only for systems that the observable fits.

mod bounds;
mod flips;
mod growth;
mod inside;
mod mean_rate;
mod tilt;

pub use bounds::{Angle, Bound, Direction, Quantity};
pub use flips::Flips;
pub use growth::{Deviation, Growth};
pub use mean_rate::MeanRate;
pub use tilt::Tilt;

use crate::body::Body;
use crate::forces::{ForcesInterval, OrbitPlace};
use crate::kinematics::dot;
use crate::method::{Coefficients, Engine, in_halves};
use crate::real::{Outlined, Pack, Real};
use crate::scene::{Layout, Model, Parameters};
use crate::simd::Row;
use crate::special::{atan2, sincos};
use std::f64::consts::PI;
use std::marker::PhantomData;

/// The row of the time at which stability was lost, the same for every observable; infinite before.
pub const EXIT_TIME: usize = 0;

/// The rows of one body.
pub type Rows<R> = [R; MAX_ROWS];

/// An observable, and its numbers for one body.
pub trait Observable: Copy {
    /// Number of rows for each body, `EXIT_TIME` among them.
    const ROWS: usize;
    /// Number of leading rows that change after the start.
    const CHANGING: usize;
    /// The numbers at the start.
    fn start(self, start: &Start) -> Rows<f64>;
    /// The observed value at the end.
    fn outcome(rows: &Rows<f64>) -> f64;
}

/// Updates of an observable by the steps of a model in a layout.
pub trait Update<R: Real, M: Model<R>, L: Layout, const D: usize>: Observable {
    /// Whether the observable fits the model and the layout. Code is compiled only if the observable fits.
    const FITS: bool;
    /// Updates the rows after a step.
    fn after_step<S: Engine<R, M, L, D>>(self, rows: &mut Rows<R>, segment: &Segment<R, S, D>);
    /// Updates the rows after a step of a body for which it matters what is inside the step.
    #[inline(always)]
    fn look<S: Engine<R, M, L, D>>(self, _rows: &mut Rows<R>, _segment: &Segment<R, S, D>) {
        unreachable!("only some observables look inside such steps")
    }
}

/// A look inside a step, of the bodies that need it.
struct Look<'a, O, R: Real, M, L, S, const D: usize> {
    observable: O,
    engine: &'a S,
    p: &'a Parameters<R>,
    rows: &'a mut Rows<R>,
    begin: R,
    before: &'a [R; D],
    after: &'a [R; D],
    of: PhantomData<(M, L)>,
}

impl<O, R, M, L, S, const D: usize> Outlined for Look<'_, O, R, M, L, S, D>
where
    O: Update<R, M, L, D>,
    R: Real,
    M: Model<R>,
    L: Layout,
    S: Engine<R, M, L, D>,
{
    type Out = ();
    #[inline(always)]
    fn run(self) {
        let Look { observable, engine, p, rows, begin, before, after, .. } = self;
        observable.look(rows, &Segment { engine, p, begin, before, after, dense: &Coefficients::new() });
    }
}

/// Updates the rows of the bodies that need the motion inside a step, in a function of its own.
#[expect(clippy::manual_memcpy, reason = "a copied slice has an address: its state would stay in memory")]
#[inline(always)]
fn look_inside<O, R, M, L, S, const D: usize>(
    observable: O,
    rows: &mut Rows<R>,
    segment: &Segment<R, S, D>,
    wanted: R::Mask,
) where
    O: Update<R, M, L, D>,
    R: Real,
    M: Model<R>,
    L: Layout,
    S: Engine<R, M, L, D>,
{
    if R::any(wanted) {
        // Copies: what a function of its own sees would be in memory in every step, observed or not.
        let &Segment { engine, p, begin, .. } = segment;
        let [mut before, mut after] = [[begin; D]; 2];
        in_halves!(d in D { before[d] = segment.before[d]; });
        in_halves!(d in D { after[d] = segment.after[d]; });
        let (mut seen, length) = ([begin; MAX_ROWS], const { O::ROWS });
        in_halves!(r in length { seen[r] = rows[r]; });
        let (before, after, of) = (&before, &after, PhantomData);
        R::outlined(Look { observable, engine, p, rows: &mut seen, begin, before, after, of });
        for r in 0..O::CHANGING {
            rows[r] = R::select(wanted, seen[r], rows[r]);
        }
    }
}

/// The motion inside a step, in a function that all observables share.
struct MotionInside<'a, R: Real, M, L, S, const D: usize> {
    engine: &'a S,
    p: &'a Parameters<R>,
    ends: [&'a [R; D]; 2],
    dense: &'a mut Coefficients<R, D>,
    of: PhantomData<(M, L)>,
}

impl<R: Real, M: Model<R>, L: Layout, S: Engine<R, M, L, D>, const D: usize> Outlined
    for MotionInside<'_, R, M, L, S, D>
{
    type Out = ();
    #[inline(always)]
    fn run(self) {
        self.engine.motion_inside(self.p, self.ends, self.dense);
    }
}

/// The motion inside a step.
#[inline(always)]
fn motion_inside<R: Real, M: Model<R>, L: Layout, S: Engine<R, M, L, D>, const D: usize>(
    &Segment { engine, p, before, after, .. }: &Segment<R, S, D>,
) -> Coefficients<R, D> {
    let (mut dense, ends) = (Coefficients::new(), [before, after]);
    R::outlined(MotionInside { engine, p, ends, dense: &mut dense, of: PhantomData::<(M, L)> });
    dense
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
    /// The second observed body axis of a bound likewise; zeros without one.
    pub second_unit: [f64; 3],
    /// The direction in space that is integrated for the observable, in body components along the axes of the kernel.
    pub direction: [f64; 3],
    /// The deviation vector at the start.
    pub deviation: &'a Deviation,
    /// The variables of further forces.
    pub own: &'a [f64],
    /// The states of a function.
    pub states: &'a [f64],
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
pub struct Segment<'a, R, S, const D: usize> {
    /// The engine that made it.
    pub engine: &'a S,
    /// The parameters of the bodies.
    pub p: &'a Parameters<R>,
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
    (@value $name:ident) => { $name };
    (@value $name:ident $value:ident) => { $value };
    ($($name:ident $(($value:ident))?)*) => {
        /// The observable of a kernel.
        #[derive(Clone, Copy, Debug, PartialEq)]
        #[allow(missing_docs)] // The names are those of the types.
        pub enum Observed {
            Nothing,
            $($name $((observables!(@value $value $name)))?,)*
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
                    $(Observed::$name { .. } => <$name as Update<f64, M, L, D>>::FITS,)*
                }
            }

            /// The numbers at the start.
            pub fn start(self, start: &Start) -> Rows<f64> {
                match self {
                    Observed::Nothing => UNOBSERVED,
                    $(Observed::$name $(($value))? => observables!(@value $name $($value)?).start(start),)*
                }
            }

            /// The observed value at the end; NaN if nothing was observed.
            pub fn outcome(self, rows: &Rows<f64>) -> f64 {
                match self {
                    Observed::Nothing => f64::NAN,
                    $(Observed::$name { .. } => $name::outcome(rows),)*
                }
            }

            /// Updates the rows after a step of the pack that begins at a lane.
            #[inline(always)]
            pub fn after_step<P: Pack, M: Model<P>, L: Layout, S: Engine<P, M, L, D>, const D: usize>(
                self,
                rows: &mut [Row; MAX_ROWS],
                at: usize,
                segment: &Segment<P, S, D>,
            ) {
                $(if const { <$name as Update<P, M, L, D>>::FITS && is_observed::<P, M, L, S, D>() }
                    && let Observed::$name $(($value))? = self
                {
                    let mut values = [P::splat(0.0); MAX_ROWS];
                    load::<P, $name>(rows, at, &mut values);
                    let observable = observables!(@value $name $($value)?);
                    Update::<P, M, L, D>::after_step(observable, &mut values, segment);
                    store::<P, $name>(rows, at, &values);
                })*
            }
        }
    };
}
observables! { Flips Tilt(tilt) Growth Bound(bound) MeanRate }

impl Observed {
    /// The second body axis that is observed: 1, 2, 3 or -1, -2, -3; 0 if there is none.
    pub fn second_axis(self) -> i32 {
        match self {
            Observed::Bound(Bound { quantity: Quantity::Angle { normal, .. }, .. }) => normal,
            _ => 0,
        }
    }
}

/// Whether maps observe the steps of the engine: of a series the growth of deviation vectors only.
const fn is_observed<R: Real, M: Model<R>, L: Layout, S: Engine<R, M, L, D>, const D: usize>() -> bool {
    !S::IS_SERIES || L::TANGENT || L::FUNCTION
}

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

/// The square of a distance.
#[inline(always)]
fn chord2<R: Real>(a: &[R; 3], b: &[R; 3]) -> R {
    let d = [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    dot(&d, &d)
}

/// The square of the chord of an angle; infinite for half a turn, as no angle between directions is larger.
fn chord2_of(angle: f64) -> f64 {
    let half = sincos(0.5 * angle.min(PI)).0;
    if angle < PI { 4.0 * half * half } else { f64::INFINITY }
}

/// The angle whose chord has this square.
fn angle_of(chord2: f64) -> f64 {
    2.0 * atan2(chord2.max(0.0).sqrt(), (4.0 - chord2).max(0.0).sqrt())
}

/// A vector of space in the body, from the axes of space there. The third axis alone keeps its bits.
#[inline(always)]
fn combined<R: Real>(v: &[R; 3], axes: &[[R; 3]; 3]) -> [R; 3] {
    let [first, second, third] = axes;
    let mut sum = *third;
    for i in 0..3 {
        sum[i] = v[2].fma(third[i], v[0].fma(first[i], v[1] * second[i]));
    }
    sum
}
