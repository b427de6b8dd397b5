"use strict";
// kappa, pose and actuators over time, one above the other, with one cursor through all of them.

const GAP = 0.034;

function createTimeline(div, cursor, report, onPick) {
  const duration = Math.max(...Object.values(report.motions).map((one) => one.t[one.t.length - 1]));
  let [motion, panels] = [null, []];

  function traces() {
    return panels.flatMap((panel, row) =>
      panel.curves.map((curve) => ({
        type: "scatter",
        mode: "lines",
        name: curve.name,
        x: Array.from(curve.t),
        y: curve.values,
        yaxis: `y${row + 1}`,
        line: { color: curve.colour, width: curve.faint ? 1 : 2, simplify: false },
        opacity: curve.faint ? 0.45 : 1,
        hovertemplate: `${curve.name} %{y:.${panel.decimals}f} ${curve.unit}<extra></extra>`,
      })),
    );
  }

  function layout() {
    const height = heightOf(panels);
    const made = {
      font: FONT,
      showlegend: false,
      hovermode: "x unified",
      dragmode: false,
      hoverlabel: { font: FONT },
      margin: { l: 46, r: 14, t: 48, b: 40 },
      xaxis: {
        title: { text: "time (s)", standoff: 6 },
        range: [0, duration],
        fixedrange: true,
        anchor: `y${panels.length}`,
        gridcolor: "#e5e5e5",
        zeroline: false,
        unifiedhovertitle: { text: "%{x:.3f} s" },
      },
      shapes: [],
      annotations: [],
    };
    panels.forEach((panel, row) => {
      const top = 1 - row * (height + GAP);
      made[`yaxis${row + 1}`] = {
        domain: [top - height, top],
        range: rangeOf(panel),
        fixedrange: true,
        gridcolor: "#e5e5e5",
        zeroline: false,
        nticks: 5,
      };
      made.annotations.push(titleOf(panel, top));
      for (const limit of panel.limits) made.shapes.push(limitLine(panel, limit, row));
    });
    for (const { t, mode } of modeChanges(report, motion)) {
      if (t > 0) made.shapes.push(...panels.map((_, row) => changeLine(t, row)));
      made.annotations.push({
        text: mode,
        showarrow: false,
        xref: "x",
        x: t,
        xanchor: "left",
        yref: "paper",
        y: 1,
        yanchor: "bottom",
        yshift: 18,
        font: { color: "#57606a" },
      });
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
  return {
    type: "line",
    xref: "x",
    x0: t,
    x1: t,
    yref: `y${row + 1} domain`,
    y0: 0,
    y1: 1,
    line: { color: "#7f7f7f", width: 1, dash: "dot" },
  };
}

function limitLine(panel, limit, row) {
  const shared = panel.limits.every(({ value }) => panel.limits.filter((other) => other.value === value).length > 1);
  const colour = shared && panel.limits.length > 2 ? "#7f7f7f" : limit.colour;
  return {
    type: "line",
    xref: "paper",
    x0: 0,
    x1: 1,
    yref: `y${row + 1}`,
    y0: limit.value,
    y1: limit.value,
    layer: "between",
    line: { color: colour, width: 1, dash: "dash" },
  };
}

/** The title of a panel names its curves in their colours. */
function titleOf(panel, top) {
  const curves = panel.curves.map(({ name, colour }) => `<span style="color:${colour}"><b>${name}</b></span>`);
  const named = panel.limits
    .filter(({ name }) => name)
    .map(({ name, colour }) => `<span style="color:${colour}">-- ${name}</span>`);
  const limits = panel.limits.length > named.length ? [`<span style="color:#57606a">-- limit</span>`] : [];
  return {
    text: `${panel.title}&nbsp;&nbsp; ${[...curves, ...named, ...limits].join("&nbsp; ")}`,
    showarrow: false,
    xref: "paper",
    yref: "paper",
    x: 0,
    y: top,
    xanchor: "left",
    yanchor: "bottom",
    xshift: -40,
  };
}
