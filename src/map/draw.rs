//! The starts of samples, drawn side by side: each a pure function of seed, pixel and sample.

use super::{Map, Pixel};
use crate::body::Body;
use crate::error::Error;
use crate::memory;
use crate::real::Pack;
use crate::sample::{self, Distribution, Empirical, Mix};
use crate::simd::{Isa, LANES, Row, Work, load_rows, set_lane, store_rows};
use std::ops::Range;

/// The distributions of the perturbations of a start.
#[derive(Clone, Debug)]
pub struct Distributions {
    /// Of the rates.
    pub omega: Distribution,
    /// Of the attitude.
    pub attitude: Distribution,
    /// Factor of the covariance of both, for normal perturbations that hang together.
    pub mix: Option<Mix>,
    /// Whether the perturbations of the rates and of the attitude are mixed by this factor.
    pub mixed: [bool; 2],
    /// Perturbations that are given one by one.
    pub empirical: Option<Empirical>,
}

impl Distributions {
    /// No perturbation.
    pub const NONE: Distributions = Distributions {
        omega: Distribution::None,
        attitude: Distribution::None,
        mix: None,
        mixed: [false; 2],
        empirical: None,
    };
}

/// One start of a mixture.
#[derive(Clone, Debug)]
pub struct Mixed {
    /// The share of the samples that begin so or as one before.
    pub until: f64,
    /// Its perturbations.
    pub distributions: Distributions,
    /// The nominal start of each pixel, and the sizes of its perturbations.
    pub pixels: Vec<Pixel>,
}

/// The block of draws that tells which start of a mixture a sample takes; those before are of the rates and the attitude.
const OF_MIXTURE: u64 = 2;

/// Number of blocks of draws of a start.
pub const OF_START: u64 = 3;

/// Samples whose random bits are drawn in turn: together they take two thirds of their time one by one.
const TOGETHER: usize = 4;

const NOTHING: Row = Row([0.0; LANES]);

/// The uniforms of each lane, the nominal starts and the sizes of the perturbations.
struct Draws {
    uniforms: [Row; 4],
    /// The uniforms of the rates, while attitudes are drawn that hang together with them.
    of_rates: [Row; 4],
    sizes: [Row; 4],
    /// Rates or an attitude: first the nominal, then the perturbed ones.
    start: [Row; 4],
}

#[inline(always)]
fn vectors<P: Pack>(distribution: Distribution, mix: Option<&Mix>, draws: &mut Draws) {
    for at in (0..LANES).step_by(P::LANES) {
        if let Distribution::VonMisesFisher(_) = distribution {
            let ([size, ..], [x, y, z, _]) =
                (load_rows::<P, 4>(&draws.sizes, at), load_rows::<P, 4>(&draws.start, at));
            let rates = sample::turned_rates(size, [x, y, z], load_rows(&draws.uniforms, at));
            store_rows(&rates, &mut draws.start, at);
            continue;
        }
        let mut v = sample::vector(distribution, load_rows::<P, 4>(&draws.uniforms, at));
        if let Some(mix) = mix {
            v = sample::mixed_rates(mix, v);
        }
        let (sizes, start) = (load_rows::<P, 4>(&draws.sizes, at), load_rows::<P, 4>(&draws.start, at));
        for k in 0..3 {
            sizes[k].fma(v[k], start[k]).store(&mut draws.start[k].0[at..]);
        }
    }
}

#[inline(always)]
fn attitudes<P: Pack>(distribution: Distribution, mix: Option<&Mix>, draws: &mut Draws) {
    for at in (0..LANES).step_by(P::LANES) {
        let [s0, s1, s2, _] = load_rows::<P, 4>(&draws.sizes, at);
        let (u, q) = (load_rows::<P, 4>(&draws.uniforms, at), load_rows(&draws.start, at));
        let q = match mix {
            None => sample::attitude(distribution, [s0, s1, s2], q, u),
            Some(mix) => {
                let rates = sample::vector(distribution, load_rows(&draws.of_rates, at));
                sample::turned(
                    [s0, s1, s2],
                    sample::mixed_turn(mix, rates, sample::vector(distribution, u)),
                    q,
                )
            }
        };
        store_rows(&q, &mut draws.start, at);
    }
}

/// The draws of all lanes, for packs of any width.
struct Drawing<'a> {
    distribution: Distribution,
    mix: Option<&'a Mix>,
    draws: &'a mut Draws,
    of_attitudes: bool,
}

impl Work for Drawing<'_> {
    type Out = ();
    #[inline(always)]
    fn run<P: Pack>(self) {
        let Drawing { distribution, mix, draws, of_attitudes } = self;
        if of_attitudes {
            attitudes::<P>(distribution, mix, draws)
        } else {
            vectors::<P>(distribution, mix, draws)
        }
    }
}

impl Map {
    /// The numbers that a place draws by: those of its pixel and its sample in the whole map.
    pub(super) fn counter(&self, (pixel, sample): (u64, u64)) -> [u64; 2] {
        let at = pixel as usize;
        let first = self.first.get(at).copied().unwrap_or(0);
        [self.numbers.get(at).copied().unwrap_or(pixel), first + sample]
    }

    /// The uniforms of a block of draws, of each place in a lane.
    #[inline(always)]
    fn draw_uniforms(&self, block: u64, places: &[(u64, u64)], rows: &mut [Row; 4]) {
        for (first, places) in (0..).step_by(TOGETHER).zip(places.chunks(TOGETHER)) {
            // A short chunk has its last place several times.
            let mut samples = [[0; 2]; TOGETHER];
            for k in 0..TOGETHER {
                samples[k] = self.counter(places[k.min(places.len() - 1)]);
            }
            let uniforms = sample::uniforms_together(self.key, block, samples);
            for k in 0..TOGETHER {
                set_lane(rows, first + k, &uniforms[k]);
            }
        }
    }

    /// The starts of a range of samples in pixel-major order; the nominal ones where the pixel has no body.
    pub fn draw(&self, isa: Isa, range: Range<u64>) -> Result<Vec<Body>, Error> {
        // As many as a block has at most.
        let count = (range.end - range.start) as usize;
        let places = memory::collected("starts of a block", count, self.pixels_and_samples(range))?;
        self.draw_at(isa, &places)
    }

    /// The starts of samples, given by pixel and number in the pixel.
    pub fn draw_at(&self, isa: Isa, places: &[(u64, u64)]) -> Result<Vec<Body>, Error> {
        const MIXTURE: &str = "starts of a mixture";
        if self.mixture.is_empty() {
            return self.drawn(isa, &self.distributions, &self.pixels, places);
        }
        let of_each = places.iter().map(|place| {
            let [number, sample] = self.counter(*place);
            let [u, ..] = sample::uniforms(self.key, OF_MIXTURE, sample, number);
            self.mixture.partition_point(|mixed| mixed.until <= u)
        });
        let of_each = memory::collected(MIXTURE, places.len(), of_each)?;
        let nominal = places.iter().map(|place| self.pixels[place.0 as usize].body);
        let mut bodies = memory::collected(MIXTURE, places.len(), nominal)?;
        for (k, mixed) in self.mixture.iter().enumerate() {
            let mut mine = memory::reserved(MIXTURE, places.len())?;
            mine.extend((0..places.len()).filter(|&at| of_each[at] == k));
            let own = memory::collected(MIXTURE, mine.len(), mine.iter().map(|&at| places[at]))?;
            for (&at, body) in mine.iter().zip(self.drawn(isa, &mixed.distributions, &mixed.pixels, &own)?) {
                bodies[at] = body;
            }
        }
        Ok(bodies)
    }

    /// The starts of samples, perturbed by these distributions from the nominal ones of these pixels.
    fn drawn(
        &self,
        isa: Isa,
        distributions: &Distributions,
        pixels: &[Pixel],
        places: &[(u64, u64)],
    ) -> Result<Vec<Body>, Error> {
        let count = places.len();
        let pixel = |place: &(u64, u64)| &pixels[place.0 as usize];
        let bodies = places.iter().map(|place| pixel(place).body);
        let mut bodies = memory::collected("starts of a block", count, bodies)?;
        let mut draws = Draws {
            uniforms: [NOTHING; 4],
            of_rates: [NOTHING; 4],
            sizes: [NOTHING; 4],
            start: [NOTHING; 4],
        };
        let mix = distributions.mix.as_ref();
        let [of_rates, of_attitude] = distributions.mixed;
        let (rates_mix, attitude_mix) = (mix.filter(|_| of_rates), mix.filter(|_| of_attitude));
        for (bodies, places) in bodies.chunks_mut(LANES).zip(places.chunks(LANES)) {
            if distributions.omega != Distribution::None {
                self.draw_uniforms(0, places, &mut draws.uniforms);
                for (lane, place) in places.iter().enumerate() {
                    let Pixel { body, omega_size, .. } = pixel(place);
                    set_lane(&mut draws.sizes, lane, omega_size);
                    set_lane(&mut draws.start, lane, &body.omega);
                }
                isa.call(Drawing {
                    distribution: distributions.omega,
                    mix: rates_mix,
                    draws: &mut draws,
                    of_attitudes: false,
                });
                for (lane, (body, place)) in bodies.iter_mut().zip(places).enumerate() {
                    if pixel(place).possible {
                        for k in 0..3 {
                            body.omega[k] = draws.start[k].0[lane];
                        }
                    }
                }
            }
            if distributions.attitude != Distribution::None {
                self.draw_uniforms(1, places, &mut draws.uniforms);
                if attitude_mix.is_some() {
                    self.draw_uniforms(0, places, &mut draws.of_rates);
                }
                for (lane, place) in places.iter().enumerate() {
                    let Pixel { body, attitude_size, .. } = pixel(place);
                    set_lane(&mut draws.sizes, lane, attitude_size);
                    set_lane(&mut draws.start, lane, &body.attitude);
                }
                let (distribution, mix) = (distributions.attitude, attitude_mix);
                isa.call(Drawing { distribution, mix, draws: &mut draws, of_attitudes: true });
                for (lane, (body, place)) in bodies.iter_mut().zip(places).enumerate() {
                    if pixel(place).possible {
                        for k in 0..4 {
                            body.attitude[k] = draws.start[k].0[lane];
                        }
                    }
                }
            }
        }
        if let Some(given) = &distributions.empirical {
            for (body, place) in bodies.iter_mut().zip(places).filter(|(_, place)| pixel(place).possible) {
                let [number, sample] = self.counter(*place);
                let index = given.index(sample, sample::uniforms(self.key, 0, sample, number));
                given.perturb(index, &mut body.omega, &mut body.attitude);
            }
        }
        Ok(bodies)
    }
}
