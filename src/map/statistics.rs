//! The outcome of a sample, and the statistics of all samples of a pixel.

use crate::named::named;
use crate::status::Status;

named! {
    /// The classification of a sample.
    pub enum Class {
        /// Stayed stable until the horizon.
        Stable => "stable",
        /// Left stability before.
        Unstable => "unstable",
        /// The second method disagrees.
        Undecided => "undecided",
        /// Not classified: step limit, not finite, or drifted.
        Failed => "failed",
    }
}

impl Class {
    /// The class of a sample from those of its two runs. They agree, or one of them is unstable and the other cannot tell.
    pub fn agreed(self, second: Class) -> Class {
        match (self, second) {
            (Class::Failed, _) => Class::Failed,
            (first, second) if first == second => first,
            (Class::Unstable, Class::Undecided) | (Class::Undecided, Class::Unstable) => Class::Unstable,
            _ => Class::Undecided,
        }
    }
}

/// The outcome of one run of one sample.
#[derive(Clone, Copy, Debug)]
pub struct Outcome {
    /// Stable, unstable or failed; undecided if the run itself cannot tell.
    pub class: Class,
    /// Status at the end of the run.
    pub status: Status,
    /// Observed sign changes.
    pub flips: u64,
    /// Time at which stability was lost, infinite if it was not.
    pub left: f64,
    /// Largest tilt, NaN if no tilt is observed (rad).
    pub tilt: f64,
    /// Time from which on a bound is kept, infinite if it is not at the end; NaN if none is observed.
    pub settled: f64,
    /// Mean rate about the observed axis, NaN if it is not observed.
    pub mean_rate: f64,
    /// Logarithm of the growth of a deviation vector over the time, at the end; NaN if it is not observed (1/s).
    pub exponent: f64,
    /// The mean over the time of MEGNO, at the end; NaN if it is not observed.
    pub mean_megno: f64,
    /// Largest relative energy error at the ends of blocks of steps.
    pub energy_drift: f64,
    /// Largest relative error of the conserved momentum at the ends of blocks of steps.
    pub momentum_drift: f64,
    /// Largest error of the length of a direction at the ends of blocks of steps; 0 if no direction is carried.
    pub unit_drift: f64,
    /// Step.
    pub step: f64,
    /// Steps made.
    pub steps: u64,
    /// Classified in closed form: nothing drifts, and there are no steps.
    pub exact: bool,
}

impl Outcome {
    pub(super) fn was_run(&self) -> bool {
        self.status != Status::StepLimit
    }

    /// A drift, infinite if the sample overflowed on its steps. A sample that was not integrated has a NaN, and so has
    /// one of which nothing is constant.
    fn lost(&self, drift: f64) -> f64 {
        if drift.is_nan() && self.status == Status::NotFinite { f64::INFINITY } else { drift }
    }

    /// A number in units of 2^-20; zero if it is not known. Sums of such numbers do not depend on their order.
    fn fixed(number: f64) -> i64 {
        // Most criteria measure no such number.
        if number.is_nan() {
            return 0;
        }
        // Far below 2^63, which no sum reaches then.
        (number * FIXED_POINT).round().clamp(-LARGEST_FIXED, LARGEST_FIXED) as i64
    }

    /// A sample that was not integrated: one that would need more steps than allowed.
    pub const REFUSED: Outcome = Outcome {
        class: Class::Failed,
        status: Status::StepLimit,
        flips: 0,
        left: f64::INFINITY,
        tilt: f64::NAN,
        settled: f64::NAN,
        mean_rate: f64::NAN,
        exponent: f64::NAN,
        mean_megno: f64::NAN,
        energy_drift: f64::NAN,
        momentum_drift: f64::NAN,
        unit_drift: f64::NAN,
        step: f64::NAN,
        steps: 0,
        exact: false,
    };
}

/// One over the unit of sums in fixed point.
pub const FIXED_POINT: f64 = (1_u64 << 20) as f64;

/// The largest number in fixed point: no motion that can be integrated has a logarithm of 2^32.
const LARGEST_FIXED: f64 = (1_u64 << 52) as f64;

/// A sample as the statistics see it: its classification, its run, and the run of the cross-check if there is one.
#[derive(Clone, Copy)]
pub(super) struct Sample<'a> {
    pub(super) class: Class,
    pub(super) first: &'a Outcome,
    pub(super) second: Option<&'a Outcome>,
    /// The second run did not depend on the outcome of the first.
    pub(super) audited: bool,
    /// The horizon.
    pub(super) t_end: f64,
}

impl Sample<'_> {
    /// Its verdict, apart from the memory of its runs.
    pub(super) fn verdict(&self) -> Verdict {
        let Sample { class, first, second, audited, .. } = *self;
        Verdict { class, first: *first, second: second.copied(), audited }
    }
}

/// What became of a sample.
#[derive(Clone, Copy)]
pub struct Verdict {
    /// Its class, by both runs.
    pub class: Class,
    /// The outcome of its first run.
    pub first: Outcome,
    /// That of the run of the cross-check, if there is one.
    pub second: Option<Outcome>,
    /// The second run did not depend on the outcome of the first.
    pub audited: bool,
}

impl Verdict {
    /// That of a sample that was not run.
    pub const NONE: Verdict =
        Verdict { class: Class::Failed, first: Outcome::REFUSED, second: None, audited: false };

    /// The sample as the statistics see it, up to a horizon.
    pub(super) fn sample(&self, t_end: f64) -> Sample<'_> {
        let Verdict { class, first, second, audited } = self;
        Sample { class: *class, first, second: second.as_ref(), audited: *audited, t_end }
    }
}

/// Operation that merges the values of two parts of the samples. The result does not depend on the order.
trait Reduction<T> {
    /// The value of no samples.
    const NONE: T;
    fn merged(one: T, other: T) -> T;
}

struct Sum;
struct Max;
struct Min;

impl Reduction<u64> for Sum {
    const NONE: u64 = 0;
    fn merged(one: u64, other: u64) -> u64 {
        one.saturating_add(other)
    }
}

impl Reduction<i64> for Sum {
    const NONE: i64 = 0;
    fn merged(one: i64, other: i64) -> i64 {
        one.saturating_add(other)
    }
}

impl Reduction<f64> for Sum {
    const NONE: f64 = 0.0;
    fn merged(one: f64, other: f64) -> f64 {
        one + other
    }
}

impl Reduction<f64> for Max {
    // `max` ignores a NaN, so the result is NaN only if no sample has a value.
    const NONE: f64 = f64::NAN;
    fn merged(one: f64, other: f64) -> f64 {
        one.max(other)
    }
}

impl Reduction<f64> for Min {
    const NONE: f64 = f64::INFINITY;
    fn merged(one: f64, other: f64) -> f64 {
        one.min(other)
    }
}

/// An output of a map: one number for each pixel.
pub struct Column {
    /// Name of the output.
    pub name: &'static str,
    /// The name of its reduction: `sum`, `max` or `min`.
    pub reduction: &'static str,
    /// Unit of the output, `1` if it has none.
    pub unit: &'static str,
    /// Meaning of the output in a few words.
    pub words: &'static str,
    /// Whether the request determines it; otherwise it is a measurement of the machine.
    pub reproducible: bool,
    /// Its field in the statistics.
    pub field: Field,
}

/// The field of a column.
#[derive(Clone, Copy)]
pub enum Field {
    /// A whole number.
    Count(fn(&mut Statistics) -> &mut u64),
    /// A sum in fixed point.
    Fixed(fn(&mut Statistics) -> &mut i64),
    /// A number.
    Number(fn(&mut Statistics) -> &mut f64),
}

/// Writes `Statistics` and all that follows from its rows. A row is: type, reduction, unit, meaning, whether it is
/// reproducible, and the value of one sample.
macro_rules! columns {
    ($($(#[$doc:meta])* $name:ident: $type:tt $reduction:ident, $unit:literal, $words:literal, $reproducible:literal,
        |$sample:pat_param| $value:expr;)*) => {
        /// The statistics of a pixel.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct Statistics {
            $($(#[$doc])* pub $name: $type,)*
        }

        impl Statistics {
            /// The statistics of no samples.
            pub const NONE: Statistics = Statistics {
                $($name: <$reduction as Reduction<$type>>::NONE,)*
            };

            /// All columns.
            pub const COLUMNS: &[Column] = &[$(Column {
                name: stringify!($name),
                reduction: reduction_name!($reduction),
                unit: $unit,
                words: $words,
                reproducible: $reproducible,
                field: field!($type, $name),
            },)*];

            /// Merges the statistics of other samples of the pixel into these.
            pub fn merge(&mut self, other: &Statistics) {
                $(self.$name = <$reduction as Reduction<$type>>::merged(self.$name, other.$name);)*
            }

            /// Merges one sample into the statistics.
            #[inline(always)]
            pub(super) fn add(&mut self, sample: &Sample) {
                $({
                    let $sample = sample;
                    self.$name = <$reduction as Reduction<$type>>::merged(self.$name, $value);
                })*
            }
        }
    };
}

macro_rules! reduction_name {
    (Sum) => {
        "sum"
    };
    (Max) => {
        "max"
    };
    (Min) => {
        "min"
    };
}

macro_rules! field {
    (u64, $name:ident) => {
        Field::Count(|statistics| &mut statistics.$name)
    };
    (i64, $name:ident) => {
        Field::Fixed(|statistics| &mut statistics.$name)
    };
    (f64, $name:ident) => {
        Field::Number(|statistics| &mut statistics.$name)
    };
}

columns! {
    /// Samples that stayed stable.
    stable: u64 Sum, "1", "stable bodies", true, |s| u64::from(s.class == Class::Stable);
    /// Samples that left stability before the horizon.
    unstable: u64 Sum, "1", "unstable bodies", true, |s| u64::from(s.class == Class::Unstable);
    /// Samples that the cross-check classifies otherwise.
    undecided: u64 Sum, "1", "undecided bodies", true, |s| u64::from(s.class == Class::Undecided);
    /// Samples without a classification.
    failed: u64 Sum, "1", "failed bodies", true, |s| u64::from(s.class == Class::Failed);
    /// Samples that were cross-checked.
    checked: u64 Sum, "1", "checked bodies", true, |s| u64::from(s.second.is_some_and(Outcome::was_run));
    /// Samples that were cross-checked whatever their first run.
    audited: u64 Sum, "1", "audited bodies", true, |s| u64::from(s.audited && s.second.is_some_and(Outcome::was_run));
    /// Audited samples that the cross-check classifies otherwise.
    audited_undecided: u64 Sum, "1", "undecided bodies among the audited", true,
        |s| u64::from(s.audited && s.second.is_some_and(Outcome::was_run) && s.class == Class::Undecided);
    /// Failed samples that would have needed too many steps.
    step_limit: u64 Sum, "1", "step limit bodies", true, |s| u64::from(s.first.status == Status::StepLimit);
    /// Failed samples that overflowed.
    not_finite: u64 Sum, "1", "not finite bodies", true, |s| u64::from(s.first.status == Status::NotFinite);
    /// Failed samples that lost an invariant.
    drifted: u64 Sum, "1", "drifted bodies", true, |s| u64::from(s.first.status == Status::Drifted);
    /// Largest energy drift, NaN if nothing was integrated.
    energy_drift: f64 Max, "1", "worst relative drift of the energy", true, |s| s.first.lost(s.first.energy_drift);
    /// Largest momentum drift, NaN if nothing was integrated.
    momentum_drift: f64 Max, "1", "worst relative drift of the momentum", true, |s| s.first.lost(s.first.momentum_drift);
    /// Largest drift of the length of a direction, NaN if nothing was integrated.
    unit_drift: f64 Max, "1", "worst drift of unit lengths", true, |s| s.first.lost(s.first.unit_drift);
    /// Earliest loss of stability; infinite if none.
    earliest: f64 Min, "s", "first time of leaving stability", true,
        |s| if s.class == Class::Unstable { s.first.left } else { f64::INFINITY };
    /// Sum of the growth of deviation vectors over the horizon, at the rate that it had when the run ended.
    growth: i64 Sum, "2^-20", "sum of exponents times the horizon", true, |s| Outcome::fixed(s.first.exponent * s.t_end);
    /// Sum of the mean MEGNO.
    megno: i64 Sum, "2^-20", "sum of mean MEGNO", true, |s| Outcome::fixed(s.first.mean_megno);
    /// Largest exponent; NaN if none was measured.
    largest_exponent: f64 Max, "1/s", "largest exponent", true, |s| s.first.exponent;
    /// Steps of all runs.
    steps: u64 Sum, "1", "time steps", true, |s| s.first.steps + s.second.map_or(0, |run| run.steps);
    /// Samples classified in closed form.
    exact: u64 Sum, "1", "bodies classified in closed form", true, |s| u64::from(s.first.exact);
    /// Processor time, shared out over a block after its end.
    nanoseconds: f64 Sum, "ns", "processor time", false, |_| 0.0;
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(class: Class, left: f64, energy_drift: f64) -> Outcome {
        let momentum_drift = 0.5 * energy_drift;
        let run = Outcome { class, status: Status::Finished, left, steps: 16, ..Outcome::REFUSED };
        let known = Outcome { energy_drift, momentum_drift, unit_drift: momentum_drift, ..run };
        Outcome { exponent: 3.0 * energy_drift, mean_megno: 2.0, ..known }
    }

    #[test]
    fn merging_parts_is_adding_samples() {
        let outcomes = [
            sample(Class::Stable, f64::INFINITY, 1e-9),
            sample(Class::Unstable, 3.0, 1e-7),
            sample(Class::Unstable, 2.0, 1e-8),
            Outcome::REFUSED,
        ];
        let of = |part: &[Outcome]| {
            let mut all = Statistics::NONE;
            for first in part {
                all.add(&Sample { class: first.class, first, second: None, audited: false, t_end: 4.0 });
            }
            all
        };
        let whole = of(&outcomes);
        let mut merged = of(&outcomes[2..]);
        merged.merge(&of(&outcomes[..2]));
        assert_eq!(merged, whole);
        assert_eq!([whole.stable, whole.unstable, whole.failed, whole.step_limit], [1, 2, 1, 1]);
        assert_eq!((whole.earliest, whole.energy_drift, whole.steps), (2.0, 1e-7, 48));
        assert_eq!((whole.megno, whole.largest_exponent), (6 << 20, 3e-7));
    }

    #[test]
    fn a_sample_that_overflowed_has_an_infinite_drift() {
        let first = Outcome { status: Status::NotFinite, exact: false, ..Outcome::REFUSED };
        let mut all = Statistics::NONE;
        all.add(&Sample { class: Class::Failed, first: &first, second: None, audited: false, t_end: 4.0 });
        assert_eq!((all.energy_drift, all.not_finite), (f64::INFINITY, 1));
    }

    #[test]
    fn columns_reach_their_fields() {
        let mut statistics = Statistics::NONE;
        for (value, column) in Statistics::COLUMNS.iter().enumerate() {
            match column.field {
                Field::Count(of) => *of(&mut statistics) = value as u64,
                Field::Fixed(of) => *of(&mut statistics) = value as i64,
                Field::Number(of) => *of(&mut statistics) = value as f64,
            }
        }
        let last = (Statistics::COLUMNS.len() - 1) as f64;
        assert_eq!((statistics.stable, statistics.nanoseconds), (0, last));
    }
}
