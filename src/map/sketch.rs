//! A sketch of the values of many samples: exact sums, extremes, and a histogram from which quantiles follow.
//!
//! The bins are the numbers with one sign, one exponent and six leading bits of the mantissa: a bin is at most 1/64 as
//! wide as its numbers are large. All that is stored are whole numbers, so merging is exact and no order of the samples
//! changes a bit. (The bins are those of an HDR histogram; compare DDSketch, C. Masson, J. E. Rim, H. K. Lee, Proc. VLDB
//! Endow. 12 (2019) 2195, doi 10.14778/3352063.3352135.)

use super::Value;
use crate::error::{Error, refuse};
use crate::memory;

/// Bits of the mantissa below the bin.
const REST: u32 = 46;

/// The most values of a sketch: as many squares of offsets, below 2^92 each, have a sum that fits.
const MOST_VALUES: u128 = 1 << 36;

/// What a sketch is called if it does not fit into memory.
const SKETCH: &str = "measures of the pixels";

/// The values of a bin. Their offsets are the mantissa bits below the bin: a value is that many units in the last place
/// farther from zero than the number of the bin that is nearest to zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bin {
    /// The sign, exponent and leading bits: `bits >> 46` of a value that is not negative, else `-1 - (bits >> 46)` of its
    /// absolute value. Keys are in the order of the values.
    pub key: i32,
    /// Number of values.
    pub count: u64,
    /// Least and largest offset.
    pub ends: [u64; 2],
    /// Sum of the offsets.
    pub sum: u128,
    /// Sum of their squares.
    pub squares: u128,
    /// Bits of the largest error of the values, which are in the order of the errors; [`Bin::UNKNOWN`] if none is known.
    pub error: i64,
}

impl Bin {
    /// The numbers of a bin as a file has them.
    pub const LEN: usize = 9;

    /// The bits of no error: below all others, and those of a NaN.
    pub const UNKNOWN: i64 = -1;

    fn of(value: &Value) -> Bin {
        let bits = value.number.abs().to_bits();
        let (key, offset) = ((bits >> REST) as i32, bits & ((1 << REST) - 1));
        let is_negative = value.number < 0.0;
        let wide = u128::from(offset);
        Bin {
            key: if is_negative { -1 - key } else { key },
            count: 1,
            ends: [offset; 2],
            sum: wide,
            squares: wide * wide,
            error: if value.error.is_nan() { Bin::UNKNOWN } else { value.error.to_bits() as i64 },
        }
    }

    fn merge(&mut self, other: &Bin) {
        self.count = self.count.saturating_add(other.count);
        self.ends = [self.ends[0].min(other.ends[0]), self.ends[1].max(other.ends[1])];
        self.sum = self.sum.saturating_add(other.sum);
        self.squares = self.squares.saturating_add(other.squares);
        self.error = self.error.max(other.error);
    }

    /// The numbers of the bin.
    pub fn numbers(&self) -> [i64; Bin::LEN] {
        let halves = |wide: u128| [wide as i64, (wide >> 64) as i64];
        let ([s0, s1], [q0, q1]) = (halves(self.sum), halves(self.squares));
        let [least, largest] = self.ends.map(|end| end as i64);
        [self.key.into(), self.count as i64, least, largest, s0, s1, q0, q1, self.error]
    }

    /// The bin with these numbers.
    ///
    /// # Errors
    /// If no finite values have them.
    pub fn from_numbers(numbers: [i64; Bin::LEN]) -> Result<Bin, Error> {
        let [key, count, least, largest, s0, s1, q0, q1, error] = numbers;
        let wide = |low: i64, high: i64| u128::from(low as u64) | u128::from(high as u64) << 64;
        // The keys of infinities.
        let above = (f64::INFINITY.to_bits() >> REST) as i64;
        let is_bin = (-above..above).contains(&key)
            && count > 0
            && (0..1 << REST).contains(&least)
            && (least..1 << REST).contains(&largest)
            && wide(s0, s1) <= u128::from(largest as u64) * count as u128
            && wide(q0, q1) <= u128::from(largest as u64).pow(2).saturating_mul(count as u128)
            && (Bin::UNKNOWN..f64::INFINITY.to_bits() as i64).contains(&error);
        if !is_bin {
            return refuse("a bin", format_args!("{numbers:?}"), "must be numbers of finite values");
        }
        Ok(Bin {
            key: key as i32,
            count: count as u64,
            ends: [least as u64, largest as u64],
            sum: wide(s0, s1),
            squares: wide(q0, q1),
            error,
        })
    }
}

/// The sketch of the values of a pixel: its bins in the order of their values.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Sketch(Vec<Bin>);

impl Sketch {
    /// The sketch of no values.
    pub const NONE: Sketch = Sketch(Vec::new());

    /// Adds a value; what is not finite is none.
    pub fn add(&mut self, value: &Value) -> Result<(), Error> {
        if value.number.is_finite() { self.put(&Bin::of(value)) } else { Ok(()) }
    }

    /// Makes room for more bins with these counts.
    ///
    /// # Errors
    /// If the memory cannot be had, or the values are too many.
    pub fn reserve(&mut self, counts: impl ExactSizeIterator<Item = u64>) -> Result<(), Error> {
        memory::room(SKETCH, &mut self.0, counts.len())?;
        let values: u128 = counts.chain(self.0.iter().map(|bin| bin.count)).map(u128::from).sum();
        if values > MOST_VALUES {
            return refuse("values of a pixel", values, "must be at most 2^36 with those that are known");
        }
        Ok(())
    }

    /// Adds the values of a bin.
    pub fn put(&mut self, bin: &Bin) -> Result<(), Error> {
        match self.0.binary_search_by_key(&bin.key, |known| known.key) {
            Ok(at) => self.0[at].merge(bin),
            Err(at) => {
                memory::push(SKETCH, &mut self.0, *bin)?;
                self.0[at..].rotate_right(1);
            }
        }
        Ok(())
    }

    /// Adds the values of another sketch.
    pub fn merge(&mut self, other: &Sketch) -> Result<(), Error> {
        other.0.iter().try_for_each(|bin| self.put(bin))
    }

    /// The bins, in the order of their values.
    pub fn bins(&self) -> &[Bin] {
        &self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn merging_in_any_order_is_adding_in_any_order() {
        let values = [3.5, -2.0, 0.0, -0.0, 1e-310, -1e300, 3.5, 3.51, f64::NAN, f64::INFINITY, 7.0];
        let of = |values: &mut dyn Iterator<Item = f64>| {
            let mut sketch = Sketch::NONE;
            // Errors that some bodies have, others in the same bin larger ones, and others none.
            let error = |number: f64| if number > 0.0 { 1e-9 * number } else { f64::NAN };
            values.for_each(|number| sketch.add(&Value { number, error: error(number) }).unwrap());
            sketch
        };
        let whole = of(&mut values.into_iter());
        assert_eq!(of(&mut values.into_iter().rev()), whole);
        let mut merged = of(&mut values[4..].iter().copied());
        merged.merge(&of(&mut values[..4].iter().copied())).unwrap();
        assert_eq!(merged, whole);
        assert_eq!(whole.bins().iter().map(|bin| bin.count).sum::<u64>(), 9);
        assert!(whole.bins().is_sorted_by_key(|bin| bin.key));
        for bin in whole.bins() {
            assert_eq!(Bin::from_numbers(bin.numbers()).unwrap(), *bin);
            for (place, wrong) in
                [(0, 1 << 17), (1, 0), (1, -1), (2, -1), (2, 1 << REST), (3, 1 << REST), (8, -2)]
            {
                let mut numbers = bin.numbers();
                numbers[place] = wrong;
                assert!(Bin::from_numbers(numbers).is_err(), "{numbers:?}");
            }
        }
    }
}
