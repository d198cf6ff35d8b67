"use strict";
// Vectors, quaternions (w, x, y, z) from body to space, and colours.
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const sum = (a, b, share) => [a[0] + share * b[0], a[1] + share * b[1], a[2] + share * b[2]];
const scaled = (a, share) => [a[0] * share, a[1] * share, a[2] * share];
const size = a => Math.hypot(a[0], a[1], a[2]);
const unit = a => { const s = size(a); return s > 0 ? scaled(a, 1 / s) : [0, 0, 0]; };
const clamp = (x, low, high) => Math.min(Math.max(x, low), high);

function turned([w, ...axis], vector) {  // v + 2 w u × v + 2 u × (u × v)
  const once = cross(axis, vector), twice = cross(axis, once);
  return vector.map((value, i) => value + 2 * w * once[i] + 2 * twice[i]);
}

function across(direction) {  // a right-handed triad with the direction as its third vector
  const along = unit(direction);
  const least = [0, 1, 2].reduce((i, j) => Math.abs(along[j]) < Math.abs(along[i]) ? j : i);
  const axis = [0, 1, 2].map(i => i === least ? 1 : 0);
  const first = unit(sum(axis, along, -dot(axis, along)));
  return [first, cross(along, first), along];
}

// The page around sends its theme; without one the theme of the system is used.
let theme = null;
const dark = () => theme ? theme === "dark" : window.matchMedia("(prefers-color-scheme: dark)").matches;

function followTheme(changed) {
  window.addEventListener("message", ({data}) => {
    if (data?.rigidTheme !== "light" && data?.rigidTheme !== "dark") return;
    document.documentElement.dataset.theme = theme = data.rigidTheme;
    changed();
  });
  window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", changed);
}

// The colour on the paper of the page: on dark paper greys are turned round and deep colours are raised.
function inked(colour) {
  const shown = dark() && ON_DARK[colour] || colour;
  const rgb = [1, 3, 5].map(i => parseInt(shown.slice(i, i + 2), 16) / 255);
  if (!dark() || ON_DARK[colour]) return rgb;
  const light = 0.3 * rgb[0] + 0.59 * rgb[1] + 0.11 * rgb[2];
  if (Math.max(...rgb) - Math.min(...rgb) < 0.1) return rgb.map(x => 1 - 0.85 * x);
  return light < 0.35 ? rgb.map(x => x + (1 - x) * (0.35 - light) * 1.6) : rgb;
}

const css = (colour, alpha = 1) =>
  `rgba(${inked(colour).map(x => Math.round(255 * x)).join(",")},${alpha})`;

// The table of pictures, rigid.drawing.colours, on dark ground.
const ON_DARK = {
  "#000000": "#ffffff", "#0062a3": "#4fa3e0", "#00825e": "#1fbf8f", "#c25200": "#f0803c",
  "#946800": "#e6a817", "#ae3f86": "#de8cbb", "#1b7bb5": "#7cc8f5", "#6b4fbb": "#a794e8",
  "#555555": "#b0b0b0", "#949494": "#707070",
};
