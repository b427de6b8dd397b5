"use strict";
// The numbers of the page: what the program wrote as base64 becomes typed arrays with a shape.

const KINDS = { float32: Float32Array, uint8: Uint8Array, uint16: Uint16Array };

function unpack(packed) {
  const text = atob(packed.base64);
  const bytes = Uint8Array.from(text, (letter) => letter.charCodeAt(0));
  return { shape: packed.shape, values: new KINDS[packed.kind](bytes.buffer) };
}

/** Row `i` of an array whose first axis counts instants, as a flat view. */
function rowOf(array, i) {
  const width = array.shape.slice(1).reduce((product, size) => product * size, 1);
  return array.values.subarray(i * width, (i + 1) * width);
}

/** Column `j` of a table (n, m), scaled. */
function columnOf(array, j, scale = 1) {
  const width = array.shape[1];
  return Array.from({ length: array.shape[0] }, (_, i) => scale * array.values[i * width + j]);
}

function unpackMaps(maps) {
  return {
    ...maps,
    t: unpack(maps.t).values,
    modes: unpack(maps.modes).values,
    y: Array.from(unpack(maps.y).values),
    z: Array.from(unpack(maps.z).values),
    levels: unpack(maps.levels),
    loops: maps.loops.map(unpack),
  };
}

function unpackMotion(name, motion) {
  const tables = ["pose", "q", "qd", "modes", "feet", "cartJoints", "platformJoints"];
  const unpacked = Object.fromEntries(tables.map((table) => [table, unpack(motion[table])]));
  const [t, kappa] = [unpack(motion.t).values, unpack(motion.kappa).values];
  const groups = motion.nearest.map(({ of, pairs, distances }) => ({
    of,
    pairs: unpack(pairs).values,
    distances: unpack(distances).values,
  }));
  return { name, t, kappa, ...unpacked, groups, nearest: nearestOf(groups), maps: unpackMaps(motion.maps) };
}

/** The nearest pair of all groups at every instant; null without any. */
function nearestOf(groups) {
  if (groups.length === 0) return null;
  const [first, ...others] = groups;
  const best = Array.from(first.distances, (_, i) =>
    others.reduce((one, other) => (other.distances[i] < one.distances[i] ? other : one), first),
  );
  return { pairs: best.map((group, i) => group.pairs[i]), distances: best.map((group, i) => group.distances[i]) };
}

function unpackBody(body) {
  const [vertices, shares, faces] = [body.vertices, body.shares, body.faces].map((packed) => unpack(packed).values);
  return { ...body, vertices, shares, faces };
}

/** The numbers, with the colours of the theme that is on, whichever that is when they are asked for. */
async function readReport() {
  const report = JSON.parse(await unpackText("report-data"));
  const motions = Object.entries(report.motions).map(([name, motion]) => [name, unpackMotion(name, motion)]);
  return {
    ...report,
    scene: { ...report.scene, bodies: report.scene.bodies.map(unpackBody) },
    motions: Object.fromEntries(motions),
    get colours() {
      return { ...report.mapColours, ...report.themes[theme()] };
    },
  };
}

const DARK = matchMedia("(prefers-color-scheme: dark)");
let printing = false;

function theme() {
  return DARK.matches && !printing ? "dark" : "light";
}

/** Place of the value in an ascending array that is nearest to `wanted`. */
function nearest(ascending, wanted) {
  let [low, high] = [0, ascending.length - 1];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (ascending[middle] <= wanted) low = middle;
    else high = middle;
  }
  return wanted - ascending[low] <= ascending[high] - wanted ? low : high;
}

const DEGREES = 180 / Math.PI;
/** What all plots have in common: text, labels of values, and no frame of their own. */
function commonLayout({ text, line, ground }) {
  const family = 'system-ui, -apple-system, "Segoe UI", Roboto, "DejaVu Sans", sans-serif';
  const font = { family, size: 12, color: text };
  return {
    font,
    hoverlabel: { font, bgcolor: ground, bordercolor: line },
    paper_bgcolor: "rgba(0,0,0,0)",
    plot_bgcolor: "rgba(0,0,0,0)",
  };
}
const CALM = { displaylogo: false, displayModeBar: false, responsive: true };
/** Fingers scroll the page rather than the plots. */
const TOUCH = matchMedia("(pointer: coarse)").matches;

/** A number with a true minus sign. */
function formatted(value, decimals) {
  const text = value.toFixed(decimals);
  return Number(text) === 0 ? (0).toFixed(decimals) : text.replace("-", "−");
}
