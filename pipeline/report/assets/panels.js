"use strict";
// What the panels over time show of a motion: their curves, limits and ranges, and when working modes change.

/** Curves of one panel differ in colour and dashes; the sign stands for them in its title. */
const DASHES = [
  { dash: "solid", sign: "━━" },
  { dash: "9px,3px", sign: "━ ━" },
  { dash: "3px,2px", sign: "╍╍" },
];
/** Distances are shown so far above their limit, or farther, up to this, so that some of each curve is seen. */
const [NEAR_MM, FAR_MM] = [60, 150];
const LIMIT = { dash: "12px,3px,1px,3px", sign: "─·─" };

/** What the panels show of a motion: title, decimals, curves and lines for limits. */
function panelsOf(report, motion) {
  const { colours, names, scene } = report;
  const series = [colours.first, colours.second, colours.third];
  const curve = (name, unit, values, i) => ({ name, unit, t: motion.t, values, colour: series[i], ...DASHES[i] });
  const pose = (name, axis, unit, scale, i) => curve(name, unit, columnOf(motion.pose, axis, scale), i);
  const actuator = (k, i, table, unit) => curve(names.actuators[k], unit, columnOf(table, k), i);
  const speeds = (k) => (scene.qdLimits[k] === null ? [] : [scene.qdLimits[k], -scene.qdLimits[k]]);
  const limits = (group, of) => group.flatMap((k, i) => of(k).map((value) => ({ value, colour: series[i] })));
  const [carts, telescopes] = [
    [0, 1, 2],
    [3, 4],
  ];
  return [
    { title: "κ", decimals: 2, curves: kappaCurves(report, motion), limits: bounds(report) },
    ...(motion.groups.length > 0 ? [nearestPanel(report, motion, curve)] : []),
    {
      title: "position (m)",
      decimals: 4,
      limits: [],
      curves: [pose("x", 0, "m", 1, 0), pose("y", 1, "m", 1, 1), pose("z", 2, "m", 1, 2)],
    },
    {
      title: "tilt (°)",
      decimals: 2,
      limits: [],
      curves: [pose("rx", 3, "°", DEGREES, 0), pose("ry", 4, "°", DEGREES, 1), pose("rz", 5, "°", DEGREES, 2)],
    },
    {
      title: "carts (m)",
      decimals: 4,
      curves: carts.map((k, i) => actuator(k, i, motion.q, "m")),
      limits: limits(carts, (k) => scene.qLimits[k]),
    },
    {
      title: "telescopes (m)",
      decimals: 4,
      curves: telescopes.map((k, i) => actuator(k, i, motion.q, "m")),
      limits: limits(telescopes, (k) => scene.qLimits[k]),
    },
    {
      title: "cart velocity (m/s)",
      decimals: 4,
      curves: carts.map((k, i) => actuator(k, i, motion.qd, "m/s")),
      limits: limits(carts, speeds),
    },
    {
      title: "telescope velocity (m/s)",
      decimals: 4,
      curves: telescopes.map((k, i) => actuator(k, i, motion.qd, "m/s")),
      limits: limits(telescopes, speeds),
    },
  ];
}

/** How near the nearest pairs are, of bodies and of obstacles; what is far is not seen. */
function nearestPanel({ scene, colours }, motion, curve) {
  const clearance = 1000 * scene.clearance;
  const least = motion.groups.map(({ distances }) => 1000 * Math.min(...distances));
  return {
    title: "nearest pair (mm)",
    decimals: 1,
    curves: motion.groups.map(({ of, pairs, distances }, i) => ({
      ...curve(of, "mm", Array.from(distances, (value) => 1000 * value), i),
      texts: Array.from(pairs, (pair) => scene.pairs[pair].name),
    })),
    limits: [{ value: clearance, colour: colours.limit }],
    largest: Math.max(clearance + NEAR_MM, Math.min(FAR_MM, 1.25 * Math.max(...least))),
  };
}

function kappaCurves(report, chosen) {
  const last = Object.values(report.motions).sort((a) => (a === chosen ? 1 : -1));
  return last.map((motion) => ({
    name: motion.name,
    unit: "",
    t: motion.t,
    values: Array.from(motion.kappa),
    colour: report.colours[motion.name],
    ...DASHES[motion.name === "coarse" ? 1 : 0],
    faint: motion !== chosen,
  }));
}

/** The largest bound of kappa that is proven, where there is a proof. */
function bounds(report) {
  if (!report.proof || report.proof.bound.includes(null)) return [];
  return [{ value: Math.max(...report.proof.bound), colour: report.colours.bound, name: "proven bound" }];
}

/** When which working mode begins. */
function modeChanges(report, motion) {
  const modes = Array.from(motion.modes.values, (mode) => report.names.modes[mode]);
  const begins = modes.map((mode, i) => ({ t: motion.t[i], mode, isNew: i === 0 || mode !== modes[i - 1] }));
  return begins.filter((one) => one.isNew);
}

function rangeOf(panel) {
  const values = [...panel.curves.flatMap((curve) => curve.values), ...panel.limits.map(({ value }) => value)];
  const [least, largest] = values.reduce(
    ([a, b], value) => [Math.min(a, value), Math.max(b, value)],
    [Infinity, -Infinity],
  );
  const top = Math.min(largest, panel.largest ?? Infinity);
  const margin = 0.06 * (top - least) || 0.01;
  return [least - margin, top + margin];
}
