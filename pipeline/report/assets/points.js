"use strict";
// Points and lines in space, as the numbers of the page become what the library draws.

function points(flat) {
  return Array.from({ length: flat.length / 3 }, (_, i) => Array.from(flat.subarray(3 * i, 3 * i + 3)));
}

function coordinates(list) {
  const [x, y, z] = [0, 1, 2].map((axis) => list.map((point) => (point ? point[axis] : null)));
  return { x, y, z };
}

/** Separate lines as one: a gap after each pair of ends. */
function segments(pairs) {
  return coordinates(pairs.flatMap(([from, to]) => [from, to, null]));
}

function repeated(texts, times) {
  return texts.flatMap((text) => Array(times).fill(text));
}

/** Least and largest x, y, z of everything shown in any motion. */
function extent(report) {
  const seen = [report.scene.rails.flat(2)];
  for (const motion of Object.values(report.motions)) {
    seen.push(motion.feet.values, motion.cartJoints.values, motion.platformJoints.values);
    for (let part = 0; part <= 10; part += 1) {
      const { x, y, z } = cornersOf(report.scene.bodies, motion, Math.round((part / 10) * (motion.t.length - 1)));
      seen.push(x.flatMap((value, i) => [value, y[i], z[i]]));
    }
  }
  const range = [0, 1, 2].map(() => [Infinity, -Infinity]);
  for (const flat of seen)
    flat.forEach((value, i) => {
      const limits = range[i % 3];
      limits[0] = Math.min(limits[0], value);
      limits[1] = Math.max(limits[1], value);
    });
  return range.map(([least, largest]) => [least - 0.05, largest + 0.05]);
}
