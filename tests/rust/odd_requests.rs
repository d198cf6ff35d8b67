//! Requests with odd numbers are refused, or give results that are ones. `fuzz/` takes many more.

#[path = "../../fuzz/doors.rs"]
mod doors;

use proptest::prelude::*;
use proptest::test_runner::RngSeed;

proptest! {
    #![proptest_config(ProptestConfig { cases: 3000, rng_seed: RngSeed::Fixed(2026), ..ProptestConfig::default() })]

    #[test]
    fn odd_numbers_are_refused_or_understood(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        doors::knock(&bytes);
    }
}
