// The film of a motion that the page has computed: the body of a pixel, and its vectors.

function boxOf(moments) {  // faces of half the sides of the homogeneous box with these moments, the longest 1
  const [a, b, c] = moments, sides = [b + c - a, a + c - b, a + b - c].map(x => Math.sqrt(Math.max(x, 0)));
  const half = sides.map(x => Math.max(x / Math.max(...sides), 0.02));
  const ends = [[-1, -1], [1, -1], [1, 1], [-1, 1]], faces = [];
  for (let axis = 0; axis < 3; axis++)
    for (const side of [-1, 1])
      faces.push(ends.map(([u, v]) => {
        const corner = [0, 0, 0];
        corner[axis] = side * half[axis];
        corner[(axis + 1) % 3] = u * half[(axis + 1) % 3];
        corner[(axis + 2) % 3] = v * half[(axis + 2) % 3];
        return corner;
      }));
  return [faces, half];
}

// A spinning top with the fixed point at the origin and the centre of mass at the distance 1.
const PROFILE = [[0.02, 0], [0.06, 0.3], [1, 0.85], [1, 1.1], [0.08, 1.25], [0.06, 1.45], [0, 1.45]];
const SECTORS = 48;

function topOf(moments, direction) {
  const [first, second, along] = across(direction), [a, b, c] = moments;
  const spread = [b + c - a, a + c - b, a + b - c].map(x => 0.5 * Math.max(x, 0));
  const form = (u, v) => u.reduce((sum, x, i) => sum + x * v[i] * spread[i], 0);
  const [p, q, r] = [form(first, first), form(first, second), form(second, second)];
  const turn = 0.5 * Math.atan2(2 * q, p - r);
  const axes = [0, 0.5 * Math.PI].map(more =>
    sum(scaled(first, Math.cos(turn + more)), second, Math.sin(turn + more)));
  const widths = axes.map(axis => Math.sqrt(Math.max(form(axis, axis), 0))), widest = Math.max(...widths) || 1;
  const [one, two] = widths.map(x => Math.max(0.5 * x / widest, 0.05));
  const rings = PROFILE.map(([radius, height]) => Array.from({length: SECTORS + 1}, (_, k) => {
    const angle = 2 * Math.PI * k / SECTORS;
    const rim = sum(scaled(axes[0], one * radius * Math.cos(angle)), axes[1], two * radius * Math.sin(angle));
    return sum(rim, along, height);
  }));
  return rings.slice(1).flatMap((next, j) => next.slice(1).map((_, k) =>
    [rings[j][k], rings[j][k + 1], next[k + 1], next[k]]));
}

function separatrixOf(moments) {
  const [low, mid, high] = [0, 1, 2].sort((i, j) => moments[i] - moments[j]), inverse = moments.map(x => 1 / x);
  const first = inverse[low] - inverse[mid], last = inverse[mid] - inverse[high];
  if (!(first > 0 && last > 0)) return [];
  return [1, -1].map(sign => Array.from({length: 97}, (_, k) => {
    const point = [0, 0, 0], angle = 2 * Math.PI * k / 96;
    point[mid] = Math.cos(angle);
    point[low] = Math.sin(angle) * Math.sqrt(last / (first + last));
    point[high] = sign * Math.sin(angle) * Math.sqrt(first / (first + last));
    return point;
  }));
}

// The strip chart of a quantity that the page offers.
function stripOf(map, chart, pixel, numbers, motion, doubtful) {
  const {inks} = map, values = quantityOf(chart, numbers, motion), isRates = chart.what === "rates";
  const ink = chart.what === "rate" ? inks.axes[Math.abs(chart.axis) - 1]
    : {tilt: inks.body, turn: inks.body, pointing: inks.planet, distance: inks.planet, direction: chart.of === "L" ? inks.L : inks.omega, speed: inks.omega}[chart.what];
  // Criteria and axes count angles in rad, charts in degrees.
  const limits = chart.limits.map(limits => limits[pixel]), unit = /\((.*)\)$/.exec(chart.label)?.[1] ?? "";
  const limitName = limit => unit === "°" ? `limit ${shown(limit)}° = ${shown(limit * Math.PI / 180)} rad` : `limit ${shown(limit)} ${unit}`;
  return {label: chart.label, names: isRates ? ["ω₁", "ω₂", "ω₃"] : [], colours: isRates ? inks.axes : [ink], axes: inks.axes,
    values, limits, limitNames: limits.map(limitName), after: chart.after, doubtful};
}

const PLANET = 2;  // where the planet is drawn: its direction alone is to scale

function filmOf(map, numbers, strip, {t, omega, attitude}, speed) {
  const {inks} = map, body = named(numbers), {moments, weight, orbit} = body;
  const isTop = size(weight) > 0, hasOrbit = orbit[0] > 0, isFree = numbers.slice(3).every(x => x === 0);
  // A rotor and an energy sink leave the angular momentum at rest.
  const keepsMomentum = Object.entries(body).every(([name, values]) => ["moments", "rotor", "dissipation"].includes(name) || values.every(x => x === 0));
  const momentum = omega.map((w, k) => turned(attitude[k], momentumOf(body, w)));
  const rates = omega.map((w, k) => turned(attitude[k], w));
  const longest = vectors => vectors.reduce((most, v) => Math.max(most, size(v)), 0) || 1;
  const part = (kind, points, colours, more = {}) => ({kind, points, colours, opacity: 1, carried: false, label: "", meaning: "", ...more});
  const unitVectors = [[1, 0, 0], [0, 1, 0], [0, 0, 1]], up = hasOrbit ? axesOfOrbit(orbit, 0).normal : keepsMomentum && size(momentum[0]) > 0 ? unit(momentum[0]) : [0, 0, 1];
  let parts, reach, centre = [0, 0, 0];
  if (isTop) {
    const direction = unit(weight);
    parts = [part("faces", topOf(moments, direction), [...Array(6).fill(inks.body), ...Array(6).fill(inks.axes[0])], {carried: true}),
      part("trail", attitude.map(q => scaled(turned(q, direction), 1.45)), [inks.axes[2]], {meaning: "path of the axis through the centre of mass"}),
      part("arrow", [[0, 0, 1.6]], [inks.vertical], {label: "vertical"})];
    const tips = parts[1].points, lowest = tips.reduce((least, tip) => Math.min(least, tip[2]), 0);
    centre = [0, 0, 0.5 * (1.6 + lowest)];
    reach = 0.1 + tips.reduce((most, tip) => Math.max(most, size(sum(tip, centre, -1))), 1.6 - centre[2]);
  } else {
    const [faces, half] = boxOf(moments), most = longest(rates), spun = longest(momentum);
    const tips = rates.map(w => scaled(w, 1.2 / most));
    parts = [part("faces", faces, inks.axes.flatMap(ink => [ink, ink]), {carried: true}),
      ...unitVectors.map((e, i) => part("arrow", [scaled(e, half[i] + 0.35)], [inks.axes[i]], {carried: true, label: String(i + 1), meaning: "principal axes"})),
      part("trail", tips, [inks.space], {meaning: "path of ω"}),
      part("arrow", tips, [inks.omega], {label: "ω", meaning: "angular velocity"}),
      part("arrow", momentum.map(v => scaled(v, 1.5 / spun)), [inks.L], {label: "L", meaning: "angular momentum"})];
    reach = 1.75;
    if (hasOrbit) {
      const [first, second] = across(up), circle = Array.from({length: 97}, (_, k) => Math.PI * k / 48);
      parts.push(part("line", circle.map(angle => sum(scaled(first, PLANET * Math.cos(angle)), second, PLANET * Math.sin(angle))), [inks.path], {meaning: "plane of the orbit"}),
        part("planet", t.map(time => scaled(axesOfOrbit(orbit, time).radial, -PLANET)), [inks.planet], {label: "planet", meaning: "direction to the planet"}));
      reach = 1.15 * PLANET;
    }
  }
  const some = Array.from({length: 64}, (_, k) => attitude[Math.floor(k * (attitude.length - 1) / 63)]);
  const grounded = isTop && parts[0].points.flat().every(p => some.every(q => turned(q, p)[2] > -0.02));
  const step = t.length > 1 ? t[1] - t[0] : 1, digits = Math.max(0, Math.ceil(-Math.log10(map.clock.factor * step) - 1e-9));
  return {view: isTop ? "top" : "box", title: map.scene, clock: map.clock, grounded, t, digits, shown: t.map(() => step / speed),
    trail: hasOrbit ? Math.min(0.25 * t[t.length - 1], 12 * t.length / rates.reduce((all, w) => all + size(w), 0)) : 0.25 * t[t.length - 1], attitude, frame: across(up), centre, reach, camera: map.camera, parts, chart: strip,
    polhode: isFree && isFinite(momentum[0][0]) && size(momentum[0]) > 0 ? {
      points: omega.map(w => unit(w.map((x, i) => x * moments[i]))), separatrix: separatrixOf(moments)} : null};
}
