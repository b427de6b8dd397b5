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
        line: { color: curve.colour, dash: curve.dash, width: curve.faint ? 1 : 2, simplify: false },
        opacity: curve.faint ? 0.7 : 1,
        text: curve.texts,
        hovertemplate: `${curve.name} %{y:.${panel.decimals}f} ${curve.unit}${curve.texts ? ": %{text}" : ""}<extra></extra>`,
      })),
    );
  }

  function layout() {
    const { colours } = report;
    const height = heightOf(panels);
    const made = {
      ...commonLayout(colours),
      showlegend: false,
      hovermode: "x unified",
      dragmode: false,
      margin: { l: 46, r: 14, t: 48, b: 40 },
      xaxis: {
        title: { text: "time (s)", standoff: 6 },
        range: [0, duration],
        fixedrange: true,
        anchor: `y${panels.length}`,
        gridcolor: colours.line,
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
        gridcolor: colours.line,
        zeroline: false,
        nticks: 5,
      };
      made.annotations.push(titleOf(panel, top, colours));
      for (const limit of panel.limits) made.shapes.push(limitLine(panel, limit, row, colours));
    });
    for (const { t, mode } of modeChanges(report, motion)) {
      if (t > 0) made.shapes.push(...panels.map((_, row) => changeLine(t, row, colours)));
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
        font: { color: colours.soft },
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

function changeLine(t, row, colours) {
  return {
    type: "line",
    xref: "x",
    x0: t,
    x1: t,
    yref: `y${row + 1} domain`,
    y0: 0,
    y1: 1,
    line: { color: colours.change, width: 1, dash: "dot" },
  };
}

function limitLine(panel, limit, row, colours) {
  const shared = panel.limits.every(({ value }) => panel.limits.filter((other) => other.value === value).length > 1);
  const colour = shared && panel.limits.length > 2 ? colours.limit : limit.colour;
  return {
    type: "line",
    xref: "paper",
    x0: 0,
    x1: 1,
    yref: `y${row + 1}`,
    y0: limit.value,
    y1: limit.value,
    layer: "between",
    line: { color: colour, width: 1, dash: LIMIT.dash },
  };
}

/** The title of a panel names its curves, with their colours and dashes. */
function titleOf(panel, top, colours) {
  const entry = (colour, text) => `<span style="color:${colour}">${text}</span>`;
  const curves = panel.curves.map(({ name, colour, sign }) => entry(colour, `${sign}&nbsp;<b>${name}</b>`));
  const named = panel.limits.filter(({ name }) => name);
  const limits = named.map(({ name, colour }) => entry(colour, `${LIMIT.sign}&nbsp;${name}`));
  if (panel.limits.length > named.length) limits.push(entry(colours.soft, `${LIMIT.sign}&nbsp;limit`));
  return {
    text: `${panel.title}&nbsp;&nbsp; ${[...curves, ...limits].join("&nbsp; ")}`,
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
