// A map on a canvas: where it lies, its colours, its scales, and the lines of theory.
const CIVIDIS = ["#00224e", "#123570", "#3b496c", "#575d6d", "#707173", "#8a8678", "#a59c74", "#c3b369", "#e1cc55", "#fee838"];

function mixedInk(share) {
  const at = clamp(share, 0, 1) * (CIVIDIS.length - 1), k = Math.min(Math.floor(at), CIVIDIS.length - 2);
  const [a, b] = [CIVIDIS[k], CIVIDIS[k + 1]].map(c => [1, 3, 5].map(i => parseInt(c.slice(i, i + 2), 16)));
  return `rgb(${a.map((x, i) => Math.round(x + (at - k) * (b[i] - x))).join(",")})`;
}

const shown = (x, digits = 4) => Number.isFinite(x) ? String(Number(x.toPrecision(digits))) : x === Infinity ? "never" : "none";

const DASHES = {solid: [], dashed: [6, 2.6], dashdot: [10, 2.6, 1.6, 2.6], dotted: [1.6, 2.6]};  // as Matplotlib's
const [IMPOSSIBLE, UNKNOWN] = ["#cccccc", "#f4f4f4"];

class MapOnCanvas {
  constructor(canvas) {
    this.canvas = canvas;
    this.map = null;
  }

  take(map) {
    this.map = map;
    [this.ny, this.nx] = map.shape.slice(-2);
    this.plane = this.nx * this.ny;
    this.slice = 0;
    this.pixel = null;  // its number in C order of the grid
    this.edges = [map.axes[0].edges, map.axes[1]?.edges ?? [0, 1]];
    this.own = this.edges.flatMap(edges => [Math.min(...edges), Math.max(...edges)]);
    this.all = map.all ?? this.own;  // how far the reader may zoom out
    this.view = [...this.own];
  }

  // Place of the map on the canvas, and from the canvas.
  room() {
    const width = this.canvas.clientWidth, height = this.canvas.clientHeight;
    return {width, height, left: 62, right: width - 12, top: 8, bottom: height - 40};
  }

  place([x, y]) {
    const {left, right, top, bottom} = this.room(), [x0, x1, y0, y1] = this.view;
    return [left + (right - left) * (x - x0) / (x1 - x0), bottom - (bottom - top) * (y - y0) / (y1 - y0)];
  }

  from(event) {
    const box = this.canvas.getBoundingClientRect(), {left, right, top, bottom} = this.room(), [x0, x1, y0, y1] = this.view;
    const [u, v] = [(event.clientX - box.left - left) / (right - left), (bottom - event.clientY + box.top) / (bottom - top)];
    return [x0 + u * (x1 - x0), y0 + v * (y1 - y0), u >= 0 && u <= 1 && v >= 0 && v <= 1];
  }

  pixelAt([x, y, inside]) {
    if (!inside) return null;
    const cell = (edges, value) => edges.slice(1).findIndex((edge, k) => (value - edges[k]) * (value - edge) <= 0);
    const [i, j] = [cell(this.edges[0], x), cell(this.edges[1], y)];
    return i < 0 || j < 0 ? null : this.slice * this.plane + j * this.nx + i;
  }

  middle() {  // of the chosen pixel, where it is in view, else of the view
    const [x0, x1, y0, y1] = this.view, center = [(x0 + x1) / 2, (y0 + y1) / 2];
    if (this.pixel === null) return center;
    const at = [this.pixel % this.nx, Math.floor(this.pixel % this.plane / this.nx)];
    const [x, y] = at.map((k, which) => (this.edges[which][k] + this.edges[which][k + 1]) / 2);
    return x > x0 && x < x1 && y > y0 && y < y1 ? [x, y] : center;
  }

  // No emptiness beside the whole map, no closer than a thousandth of the map that is shown, and no closer than labels tell.
  within(view) {
    return [0, 1].flatMap(which => {
      const [least, most] = this.all.slice(2 * which), [low, high] = view.slice(2 * which);
      if (this.edges[which].length < 3) return [least, most];  // a single value
      const closest = Math.max(1e-3 * (this.own[2 * which + 1] - this.own[2 * which]), 1e-9 * Math.max(Math.abs(low), Math.abs(high)));
      const width = clamp(high - low, closest, most - least);
      const begin = clamp(0.5 * (low + high - width), least, most - width);
      return [begin, begin + width];
    });
  }

  ink(pixel) {
    const {map, layer} = this, value = layer.data[pixel];
    if (map.status[pixel]) return css(IMPOSSIBLE);
    if (!Number.isFinite(value)) return this.isUndecided(pixel) ? map.inks.outcomes.undecided : css(UNKNOWN);
    const [low, high, at] = layer.log ? [layer.low, layer.high, value].map(Math.log) : [layer.low, layer.high, value];
    return mixedInk(high > low ? (at - low) / (high - low) : 0.5);
  }

  isUndecided(pixel) {  // no share, because no body of the pixel was decided
    const {samples, undecided} = this.map.counts;
    return this.isOfShare() && undecided[pixel] > 0 && undecided[pixel] === samples[pixel];
  }

  isOfShare() {
    return ["share", "lower", "upper"].includes(this.layer.name);
  }

  draw() {
    const [pen, width, height] = sharp(this.canvas), {left, right, top, bottom} = this.room(), {map, nx, ny, edges} = this;
    if (!(right > left && bottom > top)) return;
    pen.clearRect(0, 0, width, height);
    pen.save();
    pen.beginPath();
    pen.rect(left, top, right - left, bottom - top);
    pen.clip();
    const xs = edges[0].map(x => this.place([x, 0])[0]), ys = edges[1].map(y => this.place([0, y])[1]);
    for (let j = 0; j < ny; j++)
      for (let i = 0; i < nx; i++) {
        const [x, y] = [Math.min(xs[i], xs[i + 1]), Math.min(ys[j], ys[j + 1])];
        const [wide, high] = [Math.abs(xs[i + 1] - xs[i]), Math.abs(ys[j + 1] - ys[j])];
        if (x > right || x + wide < left || y > bottom || y + high < top) continue;
        pen.fillStyle = this.ink(this.slice * this.plane + j * nx + i);
        pen.fillRect(Math.floor(x), Math.floor(y), Math.ceil(x + wide) - Math.floor(x), Math.ceil(y + high) - Math.floor(y));
      }
    map.curves.forEach(curve => this.line(pen, curve));
    if (this.pixel !== null && Math.floor(this.pixel / this.plane) === this.slice) {
      const [i, j] = [this.pixel % nx, Math.floor(this.pixel % this.plane / nx)], [x, y] = [(xs[i] + xs[i + 1]) / 2, (ys[j] + ys[j + 1]) / 2];
      for (const [ink, wide] of [["#000", 4], ["#fff", 1.8]]) {
        pen.strokeStyle = ink;
        pen.lineWidth = wide;
        pen.beginPath();
        pen.arc(x, y, 7, 0, 7);
        pen.stroke();
      }
    }
    pen.restore();
    pen.font = "11px system-ui, sans-serif";
    pen.fillStyle = css("#444444");
    this.scale(pen, 0);
    if (map.axes.length > 1) this.scale(pen, 1);
    this.legend();
  }

  scale(pen, which) {
    const {left, right, top, bottom} = this.room(), axis = this.map.axes[which];
    const [low, high] = this.view.slice(2 * which, 2 * which + 2), wanted = which ? (bottom - top) / 40 : (right - left) / 70;
    let marks = ticks(low, high, Math.max(2, wanted));
    if (axis.geometric) {
      const each = [1, 2, 5].flatMap(m => Array.from({length: 41}, (_, k) => m * 10 ** (k - 20))).map(x => [Math.log(x), shown(x)]);
      marks = each.filter(([x]) => x >= low && x <= high);
      if (marks.length > wanted) marks = marks.filter(([x]) => Math.abs(x / Math.LN10 - Math.round(x / Math.LN10)) < 1e-9);
      if (marks.length < 2) marks = ticks(low, high, 3).map(([x]) => [x, shown(Math.exp(x))]);
    }
    pen.textAlign = which ? "right" : "center";
    pen.textBaseline = which ? "middle" : "top";
    for (const [at, text] of marks) {
      const [x, y] = this.place([at, at]);
      if (which) pen.fillText(text, left - 5, y);
      else pen.fillText(text, x, bottom + 5);
    }
    pen.textAlign = "center";
    if (!which) return pen.fillText(axis.label, (left + right) / 2, bottom + 22);
    pen.save();
    pen.translate(10, (top + bottom) / 2);
    pen.rotate(-Math.PI / 2);
    pen.fillText(axis.label, 0, 0);
    return pen.restore();
  }

  // Lines of theory, white and dashed on black.
  line(pen, {dashes, planes}) {
    const points = planes[this.slice] ?? [];
    pen.beginPath();
    for (let k = 0, isFirst = true; k < points.length; k += 2) {
      const isEnd = Number.isNaN(points[k]);
      if (!isEnd) pen[isFirst ? "moveTo" : "lineTo"](...this.place([points[k], points[k + 1]]));
      isFirst = isEnd;
    }
    for (const [ink, wide, dash] of [["#000", 3.4, []], ["#fff", 1.6, DASHES[dashes]]]) {
      pen.strokeStyle = ink;
      pen.lineWidth = wide;
      pen.setLineDash(dash);
      pen.stroke();
    }
    pen.setLineDash([]);
  }
}
