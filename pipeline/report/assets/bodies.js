"use strict";
// The bodies of the machine: triangles that move with platform, carts and links, or not at all.

/** R = Rx Rz Ry by rows: about y first, then z, then x. */
function rotation(rx, ry, rz) {
  const [cx, cy, cz] = [rx, ry, rz].map(Math.cos);
  const [sx, sy, sz] = [rx, ry, rz].map(Math.sin);
  return [
    [cz * cy, -sz, cz * sy],
    [cx * sz * cy + sx * sy, cx * cz, cx * sz * sy - sx * cy],
    [sx * sz * cy - cx * sy, sx * cz, sx * sz * sy + cx * cy],
  ];
}

function across(a, b) {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}

/** Axes by rows whose third is along a unit vector: the bodies of links are round, so that their turn does not matter. */
function axesAlong(z) {
  const least = z.map(Math.abs).reduce((best, size, axis, sizes) => (size < sizes[best] ? axis : best), 0);
  const x = across(
    [0, 1, 2].map((axis) => Number(axis === least)),
    z,
  );
  const size = Math.hypot(...x);
  const first = x.map((value) => value / size);
  const second = across(z, first);
  return [0, 1, 2].map((row) => [first[row], second[row], z[row]]);
}

const FIXED = {
  axes: [
    [1, 0, 0],
    [0, 1, 0],
    [0, 0, 1],
  ],
  origin: [0, 0, 0],
  length: 0,
};

/** Where the frame of a body is at an instant of a motion. */
function frameOf(body, motion, frame) {
  const pointOf = (table) => Array.from(rowOf(table, frame).subarray(3 * body.number, 3 * body.number + 3));
  if (body.frame === "platform") {
    const pose = rowOf(motion.pose, frame);
    return { axes: rotation(pose[3], pose[4], pose[5]), origin: Array.from(pose.subarray(0, 3)), length: 0 };
  }
  if (body.frame === "cart") return { ...FIXED, origin: pointOf(motion.feet) };
  if (body.frame === "link") {
    const origin = pointOf(motion.cartJoints);
    const vector = pointOf(motion.platformJoints).map((value, axis) => value - origin[axis]);
    const length = Math.hypot(...vector);
    return { axes: axesAlong(vector.map((value) => value / length)), origin, length };
  }
  return FIXED;
}

/** The corners of bodies at an instant, one body after the other. */
function cornersOf(bodies, motion, frame) {
  const corners = { x: [], y: [], z: [] };
  for (const body of bodies) {
    const { axes, origin, length } = frameOf(body, motion, frame);
    const { vertices, shares } = body;
    for (let i = 0; i < shares.length; i += 1) {
      const [x, y, z] = [vertices[3 * i], vertices[3 * i + 1], vertices[3 * i + 2] + shares[i] * length];
      ["x", "y", "z"].forEach((name, row) =>
        corners[name].push(origin[row] + axes[row][0] * x + axes[row][1] * y + axes[row][2] * z),
      );
    }
  }
  return corners;
}

/** A trace of bodies; `opacity` below one lets through what is behind. */
function bodiesTrace(name, bodies, opacity) {
  const [i, j, k, names] = [[], [], [], []];
  let first = 0;
  for (const { faces, shares, name: body } of bodies) {
    for (let n = 0; n < faces.length; n += 3) {
      i.push(first + faces[n]);
      j.push(first + faces[n + 1]);
      k.push(first + faces[n + 2]);
    }
    first += shares.length;
    names.push(...Array(shares.length).fill(body));
  }
  const looks = { opacity, flatshading: true, hoverinfo: "text", hovertext: names };
  return { type: "mesh3d", name, ...looks, i, j, k, x: [], y: [], z: [] };
}

/** A colour for every triangle: `colourOf` gives that of a body. */
function faceColours(bodies, colourOf) {
  return bodies.flatMap((body) => Array(body.faces.length / 3).fill(colourOf(body)));
}

/** The bodies of the nearest pair at an instant where it is near enough to be red. */
function alarmed(report, motion, frame) {
  if (!motion.nearest || motion.nearest.distances[frame] >= report.scene.alarmDistance) return [];
  const { bodies } = report.scene.pairs[motion.nearest.pairs[frame]];
  return bodies.filter((number) => number >= 0).map((number) => report.scene.bodies[number]);
}
