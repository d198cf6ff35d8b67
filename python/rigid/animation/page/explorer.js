// The map explorer: the map with its layers, the bodies of a pixel, and the film of one body.
const FRAMES = 4000;
const CLOSER = 0.7;  // of the view, by a key or a button
const SIGNS = {stable: "", unstable: "↯", undecided: "?", failed: "×"};
const KEYS = [["n p", "next, previous body"], ["arrows on bodies", "choose a body"], ["arrows on the map", "choose a pixel"], ["+ − 0 on the map", "closer, farther, the whole map"]];
const NEEDED = "Chromium 80, Firefox 113, Safari 16.4";
const ARRAYS = {uint8: Uint8Array, int32: Int32Array, float32: Float32Array, float64: Float64Array};

async function unpacked({type, data}) {
  const bytes = Uint8Array.from(atob(data), c => c.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  const planes = new Uint8Array(await new Response(stream).arrayBuffer());
  const width = ARRAYS[type].BYTES_PER_ELEMENT, count = planes.length / width, mixed = new Uint8Array(planes.length);
  for (let k = 0; k < width; k++) for (let i = 0; i < count; i++) mixed[i * width + k] = planes[k * count + i];
  return new ARRAYS[type](mixed.buffer);
}

class Explorer extends MapOnCanvas {
  constructor() {
    super(document.querySelector(".map"));
    this.loads = 0;
    this.kept = () => {};  // called when the reader has changed the view
    this.bodiesOf = pixel => this.bodiesIn(this.map, pixel);  // the bodies of a pixel, or a promise of them
    this.quantity = this.find(".quantity");
    this.hasAsked = false;  // whether the reader has chosen the chart
  }

  find(name) {
    return document.querySelector(name);
  }

  listen() {
    const find = name => this.find(name);
    find(".layer").onchange = () => { this.layer = this.map.layers[find(".layer").selectedIndex]; this.draw(); this.kept(); };
    this.quantity.onchange = () => {
      this.hasAsked = true;
      this.kept();
      if (!this.player || this.player.root.hidden) return;
      this.player.films[0].chart = this.strip();
      this.player.chart();
    };
    this.steer();
    find(".whole").onclick = () => { this.view = [...this.all]; this.draw(); this.kept(); };
    find(".closer").onclick = () => this.closer(...this.middle(), CLOSER);
    find(".farther").onclick = () => this.closer(...this.middle(), 1 / CLOSER);
    find(".before").onclick = () => this.next(-1);
    find(".after").onclick = () => this.next(1);
    find(".copy").onclick = () => this.copy();
    find(".dots").addEventListener("keydown", event => {
      const by = {ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1}[event.key];
      const at = {Home: 0, End: this.order.length - 1}[event.key];
      if (!by && at === undefined) return;
      event.preventDefault();
      event.stopPropagation();  // the film has the same keys elsewhere
      if (by) this.next(by);
      else this.pick(this.order[at]);
      find(".dots [tabindex='0']").focus();
    });
    document.addEventListener("keydown", event => {
      if (event.ctrlKey || event.altKey || event.metaKey || event.target instanceof HTMLSelectElement) return;
      if (event.key === "n" || event.key === "p") this.next(event.key === "n" ? 1 : -1);
    });
    new ResizeObserver(() => this.draw()).observe(this.canvas);
  }

  // Shows the map of a text in JSON, with the view of an address. A later call overtakes an earlier one.
  async load(text, address) {
    const number = ++this.loads;
    try {
      if (!window.DecompressionStream) throw new Error(`this browser cannot unpack the map; it needs ${NEEDED}, or newer`);
      const map = await this.read(text);
      if (number === this.loads) this.show(map, address);
    } catch (error) {
      this.find(".detail").textContent = `The map cannot be shown: ${error.message}.`;
      throw error;
    }
  }

  read(text) {
    return unpackAll(JSON.parse(text));
  }

  show(map, address) {
    const find = name => this.find(name), layer = this.layer?.name;
    const options = (list, labels, values = labels) => list.replaceChildren(...labels.map((label, k) => new Option(label, values[k])));
    if (!this.map) this.listen();
    this.take(map);
    this.bodies = null;
    this.sample = 0;
    this.hovered = null;
    document.title = map.title;
    find("h1").textContent = map.title;
    find(".detail").textContent = map.detail + (map.complete ? "" : "; the map is not complete");
    options(find(".layer"), map.layers.map(one => one.label), map.layers.map(one => one.name));
    this.chooseLayer(layer);
    const quantity = Math.max(this.quantity.selectedIndex, 0);
    options(this.quantity, map.charts.map(chart => chart.label));
    this.quantity.selectedIndex = quantity;
    find(".slices").replaceChildren();
    this.slices = map.axes.slice(2).map(axis => {
      const label = document.createElement("label"), list = document.createElement("select");
      label.append(`${axis.label} `, list);
      options(list, axis.values.map(value => shown(value)), axis.values);
      list.onchange = () => { this.slice = this.numberOfSlice(); this.draw(); this.kept(); };
      find(".slices").append(label);
      return list;
    });
    this.digits = map.axes.map(({values}) =>
      values.slice(1).reduce((most, value, k) => digitsOf(value, values[k], Math.abs(value - values[k]), most), 4));
    this.canvas.setAttribute("aria-label", `${map.title}: the map. Arrow keys choose a pixel, plus and minus zoom`);
    this.empty("Click a pixel to see its bodies.");
    this.note();
    this.restore(address);
    this.canvas.dataset.ready = "yes";
  }

  chooseLayer(name) {
    const {map} = this, at = Math.max(map.layers.findIndex(one => one.name === name), 0);
    [this.layer, this.find(".layer").selectedIndex] = [map.layers[at], at];
  }

  // No bodies, for this reason.
  empty(reason) {
    this.order = [];
    for (const name of [".dots", ".kinds", ".facts"]) this.find(name).replaceChildren();
    this.find(".chosen").textContent = reason;
    this.find(".python").textContent = "";
    this.rest();
  }

  rest() {
    if (!this.player) return;
    this.player.play(false);
    this.player.root.hidden = true;
  }

  numberOfSlice() {
    return this.slices.reduceRight((number, list, k) =>
      number * this.map.axes[k + 2].values.length + list.selectedIndex, 0);
  }

  index(pixel) {  // [..., y, x]
    const index = [];
    for (const length of [...this.map.axes].map(axis => axis.values.length)) {
      index.unshift(pixel % length);
      pixel = Math.floor(pixel / length);
    }
    return index;
  }

  restore(address) {
    const asked = new URLSearchParams(address.slice(1)), {map} = this;
    if (asked.has("layer")) this.chooseLayer(asked.get("layer"));
    if (map.charts[asked.get("chart")]) [this.quantity.selectedIndex, this.hasAsked] = [Number(asked.get("chart")), true];
    const view = (asked.get("zoom") ?? "").split(",").map(Number);
    if (view.length === 4 && view.every(Number.isFinite) && view[0] < view[1] && view[2] < view[3]) this.view = view;
    const index = (asked.get("pixel") ?? "").split(",").map(Number), lengths = map.axes.map(axis => axis.values.length).reverse();
    if (index.length === lengths.length && index.every((at, k) => Number.isInteger(at) && at >= 0 && at < lengths[k]) && asked.has("pixel"))
      this.choose(index.reduce((number, at, k) => number * lengths[k] + at, 0), Number(asked.get("body")) || 0);
    this.draw();
  }

  get address() {
    const parts = [`layer=${this.layer.name}`];
    if (this.hasAsked && this.quantity.selectedIndex) parts.push(`chart=${this.quantity.selectedIndex}`);
    if (this.pixel !== null) parts.push(`pixel=${this.index(this.pixel).join()}`, `body=${this.sample}`);
    if (this.view.some((x, i) => x !== this.own[i])) parts.push(`zoom=${this.view.map(x => Number(x.toPrecision(8))).join()}`);
    return `#${parts.join("&")}`;
  }

  // What a finer map is wanted of, as widget.js asks the kernel for it: null for the whole map.
  get region() {
    const {map, view} = this, [wide, high] = [this.own[1] - this.own[0], this.own[3] - this.own[2]];
    const isAt = place => view.every((x, i) => Math.abs(x - place[i]) <= 1e-9 * (i < 2 ? wide : high));
    if (isAt(this.all)) return null;
    if (isAt(this.own)) return map.region;  // it is shown
    return {view, at: map.region?.at ?? this.slices.map(list => list.selectedIndex)};
  }

  say(words) {
    this.find(".said").textContent = words;
  }

  // The pixel on the border of stability that is nearest to the middle: neighbours lie on both sides of a share of 1/2, and of
  // each pair the pixel nearer to 1/2 counts. Without a border, the possible pixel nearest to the middle.
  border() {
    const {map, nx, ny} = this, share = map.layers.find(layer => layer.name === "share").data;
    const found = [], far = pixel => Math.hypot((pixel % nx + 0.5) / nx - 0.5, (Math.floor(pixel / nx) + 0.5) / ny - 0.5);
    const isKnown = pixel => !map.status[pixel] && map.counts.samples[pixel] > 0 && Number.isFinite(share[pixel]);
    for (let a = 0; a < this.plane; a++)
      for (const b of [a % nx + 1 < nx ? a + 1 : a, a + nx < this.plane ? a + nx : a]) {
        if (!isKnown(a) || !isKnown(b) || (share[a] < 0.5) === (share[b] < 0.5)) continue;
        const [of_a, of_b] = [a, b].map(pixel => Math.abs(share[pixel] - 0.5));
        if (of_a <= of_b) found.push(a);
        if (of_b <= of_a) found.push(b);
      }
    if (!found.length) found.push(...Array(this.plane).keys());
    const possible = found.filter(pixel => !map.status[pixel] && map.counts.samples[pixel]);
    return possible.reduce((best, pixel) => best === null || far(pixel) < far(best) ? pixel : best, null);
  }

  // One finger or button moves, and chooses a pixel where it has not moved; two fingers or the wheel zoom.
  steer() {
    const {canvas} = this, fingers = new Map();
    let travelled = 0;
    const held = () => {
      const places = [...fingers.values()], [a, b] = [places[0], places.at(-1)];
      return {middle: [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2], span: Math.hypot(a[0] - b[0], a[1] - b[1])};
    };
    canvas.addEventListener("pointerdown", event => {
      canvas.setPointerCapture(event.pointerId);
      fingers.set(event.pointerId, [event.clientX, event.clientY]);
      travelled = fingers.size > 1 ? Infinity : 0;
    });
    canvas.addEventListener("pointermove", event => {
      if (!fingers.has(event.pointerId)) return this.hover(this.pixelAt(this.from(event)));
      const before = held();
      fingers.set(event.pointerId, [event.clientX, event.clientY]);
      const {middle, span} = held();
      travelled += Math.hypot(middle[0] - before.middle[0], middle[1] - before.middle[1]);
      if (travelled <= 4) return;
      const isWhole = this.view.every((x, i) => x === this.all[i]);
      if (isWhole && event.pointerType === "touch" && fingers.size === 1)  // nothing to move: the finger scrolls the page
        return window.scrollBy(0, before.middle[1] - middle[1]);
      // What was below the middle of the fingers stays below it.
      const [x0, x1, y0, y1] = this.view, at = ([clientX, clientY]) => this.from({clientX, clientY}), factor = fingers.size === 2 && span > 0 ? before.span / span : 1;
      const [x, y] = at(before.middle), [toX, toY] = at(middle), [u, v] = [(toX - x0) / (x1 - x0), (toY - y0) / (y1 - y0)];
      const [wide, high] = [factor * (x1 - x0), factor * (y1 - y0)];
      this.view = this.within([x - u * wide, x + (1 - u) * wide, y - v * high, y + (1 - v) * high]);
      this.draw();
    });
    canvas.addEventListener("pointerup", event => {
      fingers.delete(event.pointerId);
      if (fingers.size) return;
      const pixel = this.pixelAt(this.from(event));
      if (travelled > 4) this.kept();
      else if (pixel !== null) this.choose(pixel, 0);
    });
    canvas.addEventListener("pointercancel", event => fingers.delete(event.pointerId));
    canvas.addEventListener("pointerleave", () => this.hover(null));
    canvas.addEventListener("wheel", event => {
      event.preventDefault();
      const [x, y] = this.from(event);
      this.closer(x, y, Math.exp(0.0015 * event.deltaY));
    }, {passive: false});
    canvas.addEventListener("keydown", event => {
      const factor = {"+": CLOSER, "=": CLOSER, "-": 1 / CLOSER, 0: Infinity}[event.key];
      if (factor) {
        event.preventDefault();
        event.stopPropagation();
        if (factor < Infinity) this.closer(...this.middle(), factor);
        else this.find(".whole").click();
        return;
      }
      const move = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1]}[event.key];
      if (!move) return;
      event.preventDefault();
      event.stopPropagation();
      const old = this.pixel === null ? [this.nx >> 1, this.ny >> 1] : this.index(this.pixel).reverse();
      const turns = this.edges.map(edges => edges[0] > edges[edges.length - 1] ? -1 : 1);
      const i = clamp(old[0] + turns[0] * move[0], 0, this.nx - 1), j = clamp((old[1] ?? 0) + turns[1] * move[1], 0, this.ny - 1);
      this.choose(this.slice * this.plane + j * this.nx + i, 0);
    });
  }

  closer(x, y, factor) {  // to a place, by a factor below 1
    const [x0, x1, y0, y1] = this.view;
    this.view = this.within([x - factor * (x - x0), x + factor * (x1 - x), y - factor * (y - y0), y + factor * (y1 - y)]);
    this.draw();
    this.kept();
  }

  // What the colours and the lines of the map are.
  legend() {
    const {layer, map} = this, legend = this.find(".legend"), {counts} = map, pixels = [...map.status.keys()];
    const entry = (mark, words) => {
      const made = document.createElement("span");
      made.innerHTML = mark;
      made.append(` ${words}`);
      return made;
    };
    const swatch = ink => `<i style="background:${ink}"></i>`, isOfShare = layer.name === "share";
    const bar = `<span style="display:inline-block;width:70px;height:10px;background:linear-gradient(90deg,${CIVIDIS.join()})"></span>`;
    const entries = isOfShare && map.of === 1
      ? [[swatch(CIVIDIS.at(-1)), map.words.stable], [swatch(CIVIDIS[0]), map.words.unstable]]
      : [[`${shown(layer.low)} ${bar} ${shown(layer.high)}`, layer.label + (layer.log ? " (logarithmic)" : "")]];
    if (pixels.some(pixel => this.isUndecided(pixel))) entries.push([swatch(map.inks.outcomes.undecided), "undecided"]);
    if (map.status.some(status => status)) entries.push([swatch(css(IMPOSSIBLE)), "no such body"]);
    if (pixels.some(pixel => !map.status[pixel] && !counts.samples[pixel])) entries.push([swatch(css(UNKNOWN)), "not computed"]);
    for (const {label, dashes} of map.curves)
      entries.push([`<svg width="34" height="14" aria-hidden="true"><path d="M2 7H32" stroke="#000" stroke-width="4"/>
        <path d="M2 7H32" stroke="#fff" stroke-width="1.8" stroke-dasharray="${DASHES[dashes]}"/></svg>`, `theory: ${label}`]);
    legend.replaceChildren(...entries.map(one => entry(...one)));
  }

  where(pixel) {
    const {map} = this, index = this.index(pixel).reverse();
    return map.axes.map((axis, k) => `${axis.name} = ${shown(axis.values[index[k]], this.digits[k])} ${axis.unit}`.trim()).join(", ");
  }

  // The share of a pixel with its interval, and the value of the layer that is shown.
  share(pixel) {
    const {map} = this, value = name => shown(map.layers.find(layer => layer.name === name).data[pixel], 3);
    if (map.status[pixel]) return `no such body is possible: ${map.statuses[map.status[pixel]]}`;
    if (!map.counts.samples[pixel]) return "not computed";
    const share = map.of === 1 ? [] : [`share ${map.words.stable} ${value("share")}, 95 % interval ${value("lower")} to ${value("upper")}`];
    return [...share, ...this.isOfShare() ? [] : [`${this.layer.label}: ${shown(this.layer.data[pixel])}`]].join("; ");
  }

  time(t, digits = 4) {  // in words
    const {unit, factor} = this.map.clock;
    return `${shown(factor * t, digits)} ${unit}`;
  }

  counted(pixel) {  // [outcome, number of bodies] of all bodies of a pixel
    return this.map.classes.map(name => [name, this.map.counts[name][pixel]]);
  }

  hover(pixel) {
    if (pixel === this.hovered) return;
    this.hovered = pixel;
    const {map} = this, of = () => this.counted(pixel).map(([name, count]) => `${count} ${map.words[name]}`).join(", ");
    this.find(".hover").textContent = pixel === null ? ""
      : [this.where(pixel), this.share(pixel), ...map.counts.samples[pixel] ? [`${of()} of ${map.counts.samples[pixel]}`] : []].filter(line => line).join("\n");
  }

  choose(pixel, sample) {
    const {map} = this;
    this.pixel = pixel;
    this.slice = Math.floor(pixel / this.plane);
    let rest = this.slice;
    this.slices.forEach((list, k) => {
      const length = map.axes[k + 2].values.length;
      list.selectedIndex = rest % length;
      rest = Math.floor(rest / length);
    });
    this.empty("");
    this.find(".facts").textContent = this.share(pixel);
    if (map.counts.samples[pixel]) this.count(pixel);
    this.draw();
    return this.list(pixel, sample);
  }

  // The bodies of a pixel, by its number in arrays of the bodies of pixels. Starts are in arrays too, or are drawn.
  bodiesIn({outcome, left, omega, attitude, draw, own}, pixel) {
    const {samples} = this.map, first = pixel * samples, row = (array, width, k) => Array.from(array.subarray(width * k, width * (k + 1)));
    return {outcome: row(outcome, samples, pixel), left: row(left, samples, pixel),
      own: k => own?.columns.map((column, j) => [column, own.values[(first + k) * own.columns.length + j]]) ?? [],
      start: k => draw ? startOf(draw, pixel, k) : [row(omega, 3, first + k), row(attitude, 4, first + k)]};
  }

  async list(pixel, sample) {
    const {map} = this, bodies = await this.bodiesOf(pixel);
    if (this.map !== map || this.pixel !== pixel || !bodies) return;
    this.bodies = bodies;
    const of = k => map.classes[bodies.outcome[k]] ?? "", left = k => bodies.left[k];
    // By outcome, and those that left in the order of their times.
    this.order = bodies.outcome.map((_, k) => k).filter(k => of(k)).sort((a, b) =>
      map.classes.indexOf(of(a)) - map.classes.indexOf(of(b)) || (left(a) || 0) - (left(b) || 0) || a - b);
    this.find(".dots").replaceChildren(...this.order.map(k => {
      const button = document.createElement("button");
      button.type = "button";
      button.className = of(k);
      button.style.background = map.inks.outcomes[of(k)];
      button.textContent = SIGNS[of(k)];
      const when = map.leaves && Number.isFinite(left(k)) ? `, left at ${this.time(left(k))}` : "";
      button.title = `body ${k}: ${map.words[of(k)]}${when}`;
      button.setAttribute("aria-label", button.title);
      button.dataset.sample = k;
      button.onclick = () => this.pick(k);
      return button;
    }));
    this.find(".bodies").hidden = map.samples === 1;
    this.pick(this.order.includes(sample) ? sample : this.order[0] ?? 0);
  }

  // The key of the dots, with the counts of all bodies of the pixel.
  count(pixel) {
    const {map} = this, all = map.counts.samples[pixel];
    this.find(".kinds").replaceChildren(...this.counted(pixel).map(([name, count]) => {
      const kind = document.createElement("span"), dot = document.createElement("i");
      dot.className = name;
      dot.style.background = map.inks.outcomes[name];
      kind.append(dot, ` ${SIGNS[name]} ${count} ${map.words[name]}`);
      return kind;
    }), map.samples < all ? `of ${all} bodies; the first ${map.samples} are here` : all === 1 ? "" : `of ${all} bodies`);
  }

  next(by) {
    if (this.pixel === null || !this.order.length) return;
    const at = this.order.indexOf(this.sample), count = this.order.length;
    this.pick(this.order[(at + by + count) % count]);
  }

  pick(sample) {
    const {map, pixel} = this;
    this.sample = sample;
    let picked = null;
    for (const button of this.find(".dots").children) {
      const isThis = Number(button.dataset.sample) === sample;
      button.setAttribute("aria-pressed", String(isThis));
      button.tabIndex = isThis ? 0 : -1;  // one stop of the tabulator, and arrows
      if (!isThis) continue;
      picked = button.title;
      const row = this.find(".dots");  // in view, without moving the page
      row.scrollLeft = clamp(row.scrollLeft, button.offsetLeft + button.offsetWidth + 8 - row.clientWidth, button.offsetLeft - 8);
      row.scrollTop = clamp(row.scrollTop, button.offsetTop + button.offsetHeight + 8 - row.clientHeight, button.offsetTop - 8);
    }
    this.find(".chosen").textContent = `${this.where(pixel)} — ${picked ?? "no body"}`;
    const index = this.index(pixel), replay = `${map.python}.replay(pixel=${index.length > 1 ? `(${index.join(", ")})` : index[0]}, sample=${sample})`;
    const drawn = map.leaves ? `animate(${map.load && '"body.html"'})` : `plot()${map.load && '.figure.savefig("body.png")'}`;
    this.code = `${map.load}body = ${replay}\nbody.run.${drawn}\n`;
    this.find(".python").textContent = replay;
    this.kept();
    if (picked && map.motion) this.film(pixel, sample, picked);
    else {
      this.note();
      this.rest();
    }
  }

  // What the reader must know of the motion.
  note(doubtful = Infinity) {
    const {map} = this;
    this.find(".note").textContent = !map.motion
      ? "The page does not compute motions under the torque of a function: use the Python line."
      : `The page computes the motions from the exact starts of the bodies by a Taylor series; the outcomes come from the map. ${Number.isFinite(doubtful)
        ? `A change of this start by 1e-12 shows from t = ${this.time(doubtful)} on: from there this motion may differ from the motions of the map and of replay.`
        : "Chaotic motions may differ from the map."}`;
    if (!map.motion) this.find(".about").open = true;
  }

  // The chart whose limit a body meets at the time at which it left.
  broken(left) {
    const {pixel, numbers, motion} = this.moved, {charts} = this.map;
    const at = Math.max(motion.t.findIndex(time => time >= left), 0);
    const misses = charts.map(chart => {
      const of = quantityOf(chart, numbers, motion), range = of.flat().reduce((most, x) => Math.max(most, Math.abs(x)), 0) || 1;
      return Math.min(...chart.limits.flatMap(limits => of.map(values => Math.abs(values[at] - limits[pixel]) / range)));
    });
    return misses.indexOf(Math.min(...misses));
  }

  strip() {
    const {pixel, numbers, motion, doubtful} = this.moved;
    return stripOf(this.map, this.map.charts[this.quantity.selectedIndex], pixel, numbers, motion, doubtful);
  }

  film(pixel, sample, words) {
    const {map} = this, numbers = Array.from(map.motion.numbers.subarray(WIDTH * pixel, WIDTH * (pixel + 1))), horizon = map.horizon[pixel];
    for (const [column, value] of this.bodies.own(sample)) numbers[column] = value;
    const [omega, attitude] = this.bodies.start(sample);
    const begun = performance.now(), {orbit} = named(numbers), pace = Math.max(size(omega), orbit[1] < 1 ? 2 * orbit[0] : 0);
    const frames = Math.round(clamp(horizon * pace / 0.2, 500, FRAMES));
    const times = Array.from({length: frames + 1}, (_, k) => horizon * k / frames);
    const motion = motionOf(numbers, omega, attitude, times);
    const doubtful = doubtfulFrom(numbers, omega, attitude, times, motion);
    this.computed = performance.now() - begun;
    this.moved = {pixel, numbers, motion, doubtful};
    this.note(doubtful);
    const left = this.bodies.left[sample];
    if (!this.hasAsked) this.quantity.selectedIndex = map.leaves && Number.isFinite(left) ? this.broken(left) : 0;
    const seconds = Math.max(clamp(horizon, 4, 20), Math.min(horizon * pace / 9, 90)), speed = horizon / seconds;
    this.player ??= new Player(this.find("#player"), KEYS);
    this.player.root.hidden = false;
    const film = filmOf(map, numbers, this.strip(), motion, speed);
    const short = motion.omega.length < times.length ? "; the page could not compute it to the end" : "";
    this.player.show([film], `${words}; ${map.clock.unit === "s" ? `film at ${shown(speed)} × the speed of the motion` : `a second of the film is ${this.time(speed, 3)}`}${short}`);
  }

  async copy() {
    const line = this.find(".python"), button = this.find(".copy");
    try {
      await navigator.clipboard.writeText(this.code);
      button.textContent = "copied";
    } catch {  // not allowed: the code is selected for the reader to copy
      line.textContent = this.code;
      getSelection().selectAllChildren(line);
      button.textContent = "press Ctrl+C";
    }
    setTimeout(() => { button.textContent = "copy Python"; }, 1500);
  }
}

// Unpacks all arrays inside plain data.
async function unpackAll(data) {
  await Promise.all(Object.entries(data).map(async ([name, value]) => {
    if (value?.type in ARRAYS) data[name] = await unpacked(value);
    else if (value instanceof Object) await unpackAll(value);
  }));
  return data;
}

// A saved page holds its map, and its address keeps the view. In a notebook widget.js gives the maps.
function begin() {
  const text = document.getElementById("map").textContent, explorer = new Explorer();
  window.explorer = explorer;
  followTheme(() => { if (explorer.map) explorer.draw(); });  // a page around may send its theme before there is a map
  if (text === "null") return;
  let address = location.hash;
  explorer.kept = () => {
    ({address} = explorer);
    if (location.protocol !== "about:") history.replaceState(null, "", address);  // a notebook's frame has no address
  };
  window.addEventListener("hashchange", () => { if (location.hash !== address && explorer.map) explorer.restore(location.hash); });
  explorer.load(text, address).then(() => {
    const border = explorer.pixel ?? explorer.border();
    if (explorer.pixel === null && border !== null) explorer.choose(border, 0);
  });
}

begin();
