"use strict";
// kappa, pose and actuators over time, one above the other, with one cursor through all of them.

const GAP = 0.034;

/** What the panels show of a motion: title, decimals, curves and lines for limits. */
function panelsOf(report, motion) {
  const { colours, names, scene } = report;
  const curve = (name, unit, values, colour) => ({ name, unit, t: motion.t, values, colour });
  const pose = (name, axis, unit, scale, colour) => curve(name, unit, columnOf(motion.pose, axis, scale), colours.axes[colour]);
  const actuator = (k, table, unit) => curve(names.actuators[k], unit, columnOf(table, k), colours.actuators[k]);
  const speeds = (k) => (scene.qdLimits[k] === null ? [] : [scene.qdLimits[k], -scene.qdLimits[k]]);
  const limits = (group, of) => group.flatMap((k) => of(k).map((value) => ({ value, colour: colours.actuators[k] })));
  const [carts, telescopes] = [[0, 1, 2], [3, 4]];
  return [
    { title: "κ (moments in m)", decimals: 2, curves: kappaCurves(report, motion), limits: bounds(report) },
    { title: "position (m)", decimals: 4, limits: [], curves: [pose("x", 0, "m", 1, 0), pose("y", 1, "m", 1, 1), pose("z", 2, "m", 1, 2)] },
    { title: "tilt (°)", decimals: 2, limits: [], curves: [pose("rx", 3, "°", DEGREES, 0), pose("ry", 4, "°", DEGREES, 1), pose("rz", 5, "°", DEGREES, 2)] },
    { title: "carts (m)", decimals: 4, curves: carts.map((k) => actuator(k, motion.q, "m")), limits: limits(carts, (k) => scene.qLimits[k]) },
    { title: "telescopes (m)", decimals: 4, curves: telescopes.map((k) => actuator(k, motion.q, "m")), limits: limits(telescopes, (k) => scene.qLimits[k]) },
    { title: "cart velocity (m/s)", decimals: 4, curves: carts.map((k) => actuator(k, motion.qd, "m/s")), limits: limits(carts, speeds) },
    { title: "telescope velocity (m/s)", decimals: 4, curves: telescopes.map((k) => actuator(k, motion.qd, "m/s")), limits: limits(telescopes, speeds) },
  ];
}

function kappaCurves(report, chosen) {
  const last = Object.values(report.motions).sort((a) => (a === chosen ? 1 : -1));
  return last.map((motion) => ({
    name: motion.name, unit: "", t: motion.t, values: Array.from(motion.kappa), colour: report.colours[motion.name], faint: motion !== chosen,
  }));
}

/** The largest bound of kappa that is proven, where there is a proof. */
function bounds(report) {
  if (!report.proof || report.proof.bound.includes(null)) return [];
  return [{ value: Math.max(...report.proof.bound), colour: report.colours.bound, name: "proven bound" }];
}

function createTimeline(div, cursor, report, onPick) {
  const duration = Math.max(...Object.values(report.motions).map((one) => one.t[one.t.length - 1]));
  let [motion, panels] = [null, []];

  function traces() {
    return panels.flatMap((panel, row) => panel.curves.map((curve) => ({
      type: "scatter", mode: "lines", name: curve.name, x: Array.from(curve.t), y: curve.values, yaxis: `y${row + 1}`,
      line: { color: curve.colour, width: curve.faint ? 1 : 2, simplify: false }, opacity: curve.faint ? 0.45 : 1,
      hovertemplate: `${curve.name} %{y:.${panel.decimals}f} ${curve.unit}<extra></extra>`,
    })));
  }

  function layout() {
    const height = heightOf(panels);
    const made = {
      font: FONT, showlegend: false, hovermode: "x unified", dragmode: false, hoverlabel: { font: FONT },
      margin: { l: 46, r: 14, t: 48, b: 40 },
      xaxis: { title: { text: "time (s)", standoff: 6 }, range: [0, duration], fixedrange: true, anchor: `y${panels.length}`, gridcolor: "#e5e5e5", zeroline: false, unifiedhovertitle: { text: "%{x:.3f} s" } },
      shapes: [], annotations: [],
    };
    panels.forEach((panel, row) => {
      const top = 1 - row * (height + GAP);
      made[`yaxis${row + 1}`] = { domain: [top - height, top], range: rangeOf(panel), fixedrange: true, gridcolor: "#e5e5e5", zeroline: false, nticks: 5 };
      made.annotations.push(titleOf(panel, top));
      for (const limit of panel.limits) made.shapes.push(limitLine(panel, limit, row));
    });
    for (const { t, mode } of modeChanges(report, motion)) {
      if (t > 0) made.shapes.push(...panels.map((_, row) => changeLine(t, row)));
      made.annotations.push({ text: mode, showarrow: false, xref: "x", x: t, xanchor: "left", yref: "paper", y: 1, yanchor: "bottom", yshift: 18, font: { color: "#57606a" } });
    }
    return made;
  }

  return {
    create: (first) => {
      [motion, panels] = [first, panelsOf(report, first)];
      cursor.style.background = striped(panels);
      const made = Plotly.newPlot(div, traces(), layout(), CALM);
      div.on("plotly_click", (event) => onPick(event.points[0].x));
      return made;
    },
    show(chosen) {
      [motion, panels] = [chosen, panelsOf(report, chosen)];
      return Plotly.react(div, traces(), layout(), CALM);
    },
    moveTo(frame) {
      cursor.style.setProperty("--part", motion.t[frame] / duration);
    },
  };
}

function heightOf(panels) {
  return (1 + GAP) / panels.length - GAP;
}

/** A colour for the cursor that leaves the titles between the panels readable. */
function striped(panels) {
  const [height, step] = [100 * heightOf(panels), 100 * (heightOf(panels) + GAP)];
  return `repeating-linear-gradient(to bottom, var(--text) 0 ${height}%, transparent ${height}% ${step}%)`;
}

function changeLine(t, row) {
  return { type: "line", xref: "x", x0: t, x1: t, yref: `y${row + 1} domain`, y0: 0, y1: 1, line: { color: "#7f7f7f", width: 1, dash: "dot" } };
}

function limitLine(panel, limit, row) {
  const shared = panel.limits.every(({ value }) => panel.limits.filter((other) => other.value === value).length > 1);
  const colour = shared && panel.limits.length > 2 ? "#7f7f7f" : limit.colour;
  return { type: "line", xref: "paper", x0: 0, x1: 1, yref: `y${row + 1}`, y0: limit.value, y1: limit.value, layer: "between", line: { color: colour, width: 1, dash: "dash" } };
}

/** The title of a panel names its curves in their colours. */
function titleOf(panel, top) {
  const curves = panel.curves.map(({ name, colour }) => `<span style="color:${colour}"><b>${name}</b></span>`);
  const named = panel.limits.filter(({ name }) => name).map(({ name, colour }) => `<span style="color:${colour}">-- ${name}</span>`);
  const limits = panel.limits.length > named.length ? [`<span style="color:#57606a">-- limit</span>`] : [];
  return {
    text: `${panel.title}&nbsp;&nbsp; ${[...curves, ...named, ...limits].join("&nbsp; ")}`, showarrow: false,
    xref: "paper", yref: "paper", x: 0, y: top, xanchor: "left", yanchor: "bottom", xshift: -40,
  };
}

/** When which working mode begins. */
function modeChanges(report, motion) {
  const modes = Array.from(motion.modes.values, (mode) => report.names.modes[mode]);
  const begins = modes.map((mode, i) => ({ t: motion.t[i], mode, isNew: i === 0 || mode !== modes[i - 1] }));
  return begins.filter((one) => one.isNew);
}

function rangeOf(panel) {
  const values = [...panel.curves.flatMap((curve) => curve.values), ...panel.limits.map(({ value }) => value)];
  const [least, largest] = values.reduce(([a, b], value) => [Math.min(a, value), Math.max(b, value)], [Infinity, -Infinity]);
  const margin = 0.06 * (largest - least) || 0.01;
  return [least - margin, largest + margin];
}
