// The starts of bodies, drawn as the core draws them (src/sample.rs), bit for bit: Philox4x64-10 (Salmon, Moraes, Dror, Shaw,
// SC'11, doi 10.1145/2063384.2063405), keyed by the seed, its counter (block of draws + 1, sample, pixel, 0).
const MASK = (1n << 64n) - 1n;

function uniformsOf(key, block, sample, pixel) {  // four in [0, 1)
  let [a, b, c, d] = [block + 1, sample, pixel, 0].map(BigInt), [k, l] = key;
  for (let round = 0; round < 10; round++) {
    const first = a * 0xD2E7470EE14C6C93n, second = c * 0xCA5A826395121157n;
    [a, b, c, d] = [second >> 64n ^ b ^ k, second & MASK, first >> 64n ^ d ^ l, first & MASK];
    [k, l] = [k + 0x9E3779B97F4A7C15n & MASK, l + 0xBB67AE8584CAA73Bn & MASK];
  }
  return [a, b, c, d].map(bits => Number(bits >> 11n) / 2 ** 53);
}

const DOUBLE = new DataView(new ArrayBuffer(8));
function wholeOf(x) {  // x = whole 2^exponent, of a normal number
  DOUBLE.setFloat64(0, x);
  const bits = DOUBLE.getBigUint64(0), whole = bits & (1n << 52n) - 1n | 1n << 52n;
  return [x < 0 ? -whole : whole, Number(bits >> 52n & 0x7FFn) - 1075];
}

// a b + c, rounded once, if it is a normal number: a sum of whole numbers becomes a double by one rounding.
function fma(a, b, c) {
  if (a === 0 || b === 0 || c === 0) return a * b + c;
  const [[wa, ea], [wb, eb]] = [wholeOf(a), wholeOf(b)];
  const product = [wa * wb, ea + eb], term = wholeOf(c);
  const least = Math.max(product[1], term[1]) - 300;  // below there only the sign decides
  const aligned = ([whole, power]) => power < least ? (whole < 0n ? -1n : 1n) : whole << BigInt(power - least);
  const half = least >> 1;
  return Number(aligned(product) + aligned(term)) * 2 ** half * 2 ** (least - half);
}
const fnma = (a, b, c) => fma(-a, b, c), fms = (a, b, c) => fma(a, b, -c);
const nearest = x => x + 6755399441055744 - 6755399441055744;  // a whole number, ties to even
const horner = (x, c) => c.reduceRight((sum, a) => fma(sum, x, a));

// The functions of src/special/elementary.rs, with their coefficients: FreeBSD msun, Sun Microsystems 1993.
const SIN = [-1.66666666666666324348e-1, 8.33333333332248946124e-3, -1.98412698298579493134e-4, 2.75573137070700676789e-6,
  -2.50507602534068634195e-8, 1.58969099521155010221e-10];
const COS = [4.16666666666666019037e-2, -1.38888888888741095749e-3, 2.48015872894767294178e-5, -2.75573143513906633035e-7,
  2.08757232129817482790e-9, -1.13596475577881948265e-11];
const LG = [6.666666666666735130e-1, 3.999999999940941908e-1, 2.857142874366239149e-1, 2.222219843214978396e-1,
  1.818357216161805012e-1, 1.531383769920937332e-1, 1.479819860511658591e-1];
const [LN2_HIGH, LN2_LOW] = [6.93147180369123816490e-1, 1.90821492927058770002e-10];

function logarithm(x) {
  DOUBLE.setFloat64(0, x);
  const bits = DOUBLE.getBigUint64(0), power = Number(bits >> 52n) - 1023;
  DOUBLE.setBigUint64(0, bits & (1n << 52n) - 1n | 0x3FFn << 52n);
  const m = DOUBLE.getFloat64(0), high = Math.SQRT2 < m, k = high ? power + 1 : power, f = (high ? m * 0.5 : m) - 1;
  const s = f / (2 + f), z = s * s, half = f * f * 0.5, r = z * horner(z, LG);
  return k * LN2_HIGH - (half - fma(s, half + r, k * LN2_LOW) - f);
}

function sinCosReduced(x) {
  const n = nearest(x * (2 / Math.PI)), high = n * (Math.PI / 2), low = fms(n, Math.PI / 2, high);
  const a = x - high, b = a - low, bError = a - b - low;
  const c = n * 6.123233995736766e-17, cLow = fms(n, 6.123233995736766e-17, c), r = b - c, back = r - b;
  const tail = fnma(n, -1.4973849048591833e-33, b - (r - back) - (c + back) + (bError - cLow));
  const z = r * r, half = z * 0.5, head = 1 - half;
  const sin = r + fma(r * z, horner(z, SIN), tail * head);
  const cos = head + fma(z * z, horner(z, COS), fnma(r, tail, 1 - head - half));
  const quarter = (n % 4 + 4) % 4;
  return [[sin, cos], [cos, -sin], [-sin, -cos], [-cos, sin]][quarter];
}

function sinCos(x) {
  if (Math.abs(x) > Math.PI / 4) return sinCosReduced(x);
  const z = x * x, half = z * 0.5, head = 1 - half;
  return [fma(x * z, horner(z, SIN), x), head + fma(z * z, horner(z, COS), 1 - head - half)];
}

function rotationBy(v) {  // exp of a rotation vector, by Rodrigues' formula
  const quarter = fma(v[0], v[0], fma(v[1], v[1], v[2] * v[2])) * 0.25;
  let first = fma(horner(quarter, SIN), quarter, 1), second = fnma(horner(quarter, COS), quarter, 0.5);
  if (quarter > (Math.PI / 4) ** 2) {
    const angle = Math.sqrt(quarter), [sin] = sinCosReduced(angle), [half] = sinCosReduced(angle * 0.5);
    [first, second] = [sin / angle, half * half * 2 / quarter];
  }
  const s = first * 0.5;
  return [fnma(quarter, second, 1), s * v[0], s * v[1], s * v[2]];
}

const quaternionProduct = (a, b) => [
  fnma(a[3], b[3], fnma(a[2], b[2], fms(a[0], b[0], a[1] * b[1]))),
  fnma(a[3], b[2], fma(a[2], b[3], fma(a[0], b[1], a[1] * b[0]))),
  fnma(a[1], b[3], fma(a[3], b[1], fma(a[0], b[2], a[2] * b[0]))),
  fnma(a[2], b[1], fma(a[1], b[2], fma(a[0], b[3], a[3] * b[0])))];

function perturbation(law, u) {  // three numbers of unit size
  const normals = (x, y) => {  // Box and Muller 1958
    const radius = Math.sqrt(-2 * logarithm(1 - x)), [sin, cos] = sinCos(2 * Math.PI * y);
    return [radius * cos, radius * sin];
  };
  if (law === "normal") return [...normals(u[0], u[1]), normals(u[2], u[3])[0]];
  if (law === "uniform") return u.slice(0, 3).map(x => 2 * x - 1);
  const z = 2 * u[0] - 1, radius = Math.sqrt((1 - z) * (1 + z)), [sin, cos] = sinCos(2 * Math.PI * u[1]);  // a direction
  return [radius * cos, radius * sin, z];
}

function attitudeOf(law, size, q, u) {
  if (law !== "uniform_attitude") return quaternionProduct(q, rotationBy(perturbation(law, u).map((v, k) => size[k] * v)));
  const [s1, c1] = sinCos(2 * Math.PI * u[1]), [s2, c2] = sinCos(2 * Math.PI * u[2]), [a, b] = [Math.sqrt(1 - u[0]), Math.sqrt(u[0])];
  return [a * s1, a * c1, b * s2, b * c2];  // Shoemake, Graphics Gems III, 1992
}

// Rates and attitude of a body: the nominal ones of its pixel, perturbed by the distributions of the map.
function startOf(draw, pixel, sample) {
  const row = (array, width) => Array.from(array.subarray(width * pixel, width * pixel + width)), key = draw.key.map(BigInt);
  const uniforms = block => uniformsOf(key, block, sample, draw.numbers[pixel]), [ofRates, ofAttitude] = draw.laws;
  let omega = row(draw.omega, 3), attitude = row(draw.attitude, 4);
  const [sizes, turns] = [row(draw.omega_size, 3), row(draw.attitude_size, 3)];
  if (ofRates) omega = perturbation(ofRates, uniforms(0)).map((v, k) => fma(sizes[k], v, omega[k]));
  if (ofAttitude) attitude = attitudeOf(ofAttitude, turns, attitude, uniforms(1));
  return [omega, attitude];
}
