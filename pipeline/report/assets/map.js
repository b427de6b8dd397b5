"use strict";
// kappa over the YZ plane, for the tilt and working mode of the machine at the chosen instant.

const [MAP, LOOPS, WAY] = [0, 1, 2];

function createMapView(parts, report) {
  const { div, point, title, scale } = parts;
  let [motion, shown] = [null, -1];

  function traces() {
    const { colours } = report;
    const line = (colour, width) => ({
      type: "scatter",
      mode: "lines",
      hoverinfo: "skip",
      x: [],
      y: [],
      line: { color: colour, width },
    });
    return [
      {
        type: "heatmap",
        x: [],
        y: [],
        z: [[]],
        customdata: [[]],
        hoverongaps: false,
        hovertemplate: "y %{x:.2f} m<br>z %{y:.2f} m<br>κ %{customdata:.1f}<extra></extra>",
        colorscale: colours.scale.map((colour, i) => [i / (colours.scale.length - 1), colour]),
        showscale: false,
      },
      line(colours.singular, 2.5),
      line("#000000", 2.5),
    ];
  }

  function layout() {
    const { colours } = report;
    return {
      ...commonLayout(colours),
      showlegend: false,
      dragmode: false,
      hovermode: "closest",
      margin: { l: 46, r: 14, t: 8, b: 40 },
      plot_bgcolor: colours.unreachable,
      xaxis: { title: { text: "y (m)", standoff: 4 }, showgrid: false, zeroline: false, fixedrange: true },
      yaxis: { title: { text: "z (m)", standoff: 4 }, showgrid: false, zeroline: false, fixedrange: true },
    };
  }

  /** The map nearest in time among those of the same working mode. */
  function mapAt(frame) {
    const { t, modes } = motion.maps;
    const distance = (map) =>
      modes[map] === motion.modes.values[frame] ? Math.abs(t[map] - motion.t[frame]) : Infinity;
    return Array.from(t.keys()).reduce((best, map) => (distance(map) < distance(best) ? map : best));
  }

  /** kappa of every point of a map (null: out of reach), from its levels on a logarithmic scale. */
  function kappaOf(map) {
    const { maps } = motion;
    const [least, largest] = maps.kappaRange;
    const flat = rowOf(maps.levels, map);
    const value = (level) => (level === 0 ? null : least * (largest / least) ** ((level - 1) / 254));
    return maps.z.map((_, i) => Array.from(flat.subarray(i * maps.y.length, (i + 1) * maps.y.length), value));
  }

  function showMap(map) {
    const { maps } = motion;
    const kappa = kappaOf(map);
    const loop = maps.loops[map];
    const colour = kappa.map((row) => row.map((value) => value && Math.log10(value)));
    // What is undefined stays as it is.
    const update = {
      z: [colour, undefined],
      customdata: [kappa, undefined],
      x: [undefined, columnOf(loop, 0)],
      y: [undefined, columnOf(loop, 1)],
    };
    title.textContent = `${maps.titles[map]}, at ${formatted(maps.t[map], 2)} s`;
    shown = map;
    return Plotly.restyle(div, update, [MAP, LOOPS]);
  }

  return {
    create: () => Plotly.newPlot(div, traces(), layout(), CALM),
    show(chosen) {
      [motion, shown] = [chosen, -1];
      const { maps } = motion;
      const { colours } = report;
      // Maps are the same on both grounds, and so are the paths on them.
      const colour = report.themes.light[motion.name];
      drawScale(scale, colours.scale, maps.kappaRange, report.scene.momentUnit);
      Plotly.restyle(
        div,
        { x: [maps.y], y: [maps.z], zmin: Math.log10(maps.kappaRange[0]), zmax: Math.log10(maps.kappaRange[1]) },
        [MAP],
      );
      Plotly.restyle(div, { x: [columnOf(motion.pose, 1)], y: [columnOf(motion.pose, 2)], "line.color": colour }, [
        WAY,
      ]);
      const [y, z] = [ends(maps.y), ends(maps.z)];
      // The plot gets the shape of what it shows, so that a metre is as long up as across.
      div.parentElement.style.setProperty("--aspect", (z[1] - z[0]) / (y[1] - y[0]));
      Plotly.relayout(div, { "xaxis.range": y, "yaxis.range": z });
    },
    moveTo(frame) {
      const [, y, z] = rowOf(motion.pose, frame);
      const part = (value, [least, largest]) => (value - least) / (largest - least);
      point.style.setProperty("--part", part(y, ends(motion.maps.y)));
      point.style.setProperty("--up", part(z, ends(motion.maps.z)));
      const map = mapAt(frame);
      return map === shown ? undefined : showMap(map);
    },
  };
}

/** The colours of kappa from least to largest, evenly on a logarithmic scale, with round numbers below. */
function drawScale(scale, colours, [least, largest], unit) {
  const bar = document.createElement("div");
  bar.style.background = `linear-gradient(to right, ${colours.join(", ")})`;
  const label = (text, part) => {
    const span = document.createElement("span");
    span.textContent = text;
    if (part === undefined) span.className = "name";
    else span.style.left = `${100 * part}%`;
    return span;
  };
  const round = [1, 2, 3, 5, 7, 10, 15, 20, 30, 50, 70, 100, 200, 500, 1000, 10000].filter(
    (kappa) => kappa >= least && kappa < largest / 1.2,
  );
  const place = (kappa) => Math.log(kappa / least) / Math.log(largest / least);
  const ticks = round.map((kappa) => label(String(kappa), place(kappa)));
  scale.replaceChildren(bar, ...ticks, label(`≥ ${largest}`, 1), label(`κ (${unit})`));
}

function ends(values) {
  const half = (values[1] - values[0]) / 2;
  return [values[0] - half, values[values.length - 1] + half];
}
