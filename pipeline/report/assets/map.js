"use strict";
// kappa over the YZ plane, for the tilt and working mode of the machine at the chosen instant.

const [MAP, LOOPS, WAY, SO_FAR, HERE] = [0, 1, 2, 3, 4];

function createMapView(div, report) {
  const { colours } = report;
  let [motion, shown] = [null, -1];

  function traces() {
    const line = (colour, width) => ({ type: "scatter", mode: "lines", hoverinfo: "skip", x: [], y: [], line: { color: colour, width } });
    return [
      {
        type: "heatmap", x: [], y: [], z: [[]], customdata: [[]], hoverongaps: false,
        hovertemplate: "y %{x:.2f} m<br>z %{y:.2f} m<br>κ %{customdata:.1f}<extra></extra>",
        colorscale: colours.map.map((colour, i) => [i / (colours.map.length - 1), colour]),
        colorbar: { title: { text: "κ (moments in m)", side: "right" }, thickness: 12, outlinewidth: 0, xpad: 6 },
      },
      line(colours.singular, 2.5),
      line("#000000", 1),
      line("#000000", 3),
      { type: "scatter", mode: "markers", x: [], y: [], hovertemplate: "TCP: y %{x:.3f} m, z %{y:.3f} m<extra></extra>", marker: { size: 12, line: { color: "#000000", width: 1.5 } } },
    ];
  }

  function layout() {
    return {
      font: FONT, showlegend: false, dragmode: false, hovermode: "closest", hoverlabel: { font: FONT },
      margin: { l: 46, r: 10, t: 48, b: 42 }, plot_bgcolor: colours.outOfReach,
      title: { text: "", font: { size: 13 }, x: 0.5, y: 0.975, yanchor: "top" },
      xaxis: { title: { text: "y (m)", standoff: 4 }, showgrid: false, zeroline: false, constrain: "domain" },
      yaxis: { title: { text: "z (m)", standoff: 4 }, showgrid: false, zeroline: false, scaleanchor: "x", constrain: "domain" },
    };
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
    Plotly.restyle(div, { x: [maps.y], y: [maps.z], z: [kappa.map((row) => row.map((value) => value && Math.log10(value)))], customdata: [kappa] }, [MAP]);
    Plotly.restyle(div, { x: [columnOf(loop, 0)], y: [columnOf(loop, 1)] }, [LOOPS]);
    Plotly.relayout(div, { "title.text": `${maps.titles[map]}<br>κ around the TCP at ${formatted(maps.t[map], 2)} s` });
    shown = map;
  }

  return {
    create: () => Plotly.newPlot(div, traces(), layout(), CALM),
    show(chosen) {
      [motion, shown] = [chosen, -1];
      const { maps } = motion;
      const colour = colours[motion.name];
      const ticks = [1, 2, 3, 5, 7, 10, 15, 20, 30, 50, 70, 100, 200, 500, 1000].filter((tick) => tick >= maps.kappaRange[0] && tick <= maps.kappaRange[1]);
      const scale = { zmin: Math.log10(maps.kappaRange[0]), zmax: Math.log10(maps.kappaRange[1]), "colorbar.tickvals": [ticks.map(Math.log10)], "colorbar.ticktext": [ticks.map((tick) => (tick === maps.kappaRange[1] ? `≥ ${tick}` : `${tick}`))] };
      Plotly.restyle(div, scale, [MAP]);
      Plotly.restyle(div, { x: [columnOf(motion.pose, 1)], y: [columnOf(motion.pose, 2)], "line.color": colour }, [WAY]);
      Plotly.restyle(div, { "line.color": colour }, [SO_FAR]);
      Plotly.restyle(div, { "marker.color": colour }, [HERE]);
      Plotly.relayout(div, { "xaxis.range": ends(maps.y), "yaxis.range": ends(maps.z) });
    },
    moveTo(frame) {
      const map = nearest(motion.maps.t, motion.t[frame]);
      if (map !== shown) showMap(map);
      const [y, z] = [1, 2].map((axis) => columnOf(motion.pose, axis).slice(0, frame + 1));
      return Plotly.restyle(div, { x: [y, [y[frame]]], y: [z, [z[frame]]] }, [SO_FAR, HERE]);
    },
  };
}

function ends(values) {
  const half = (values[1] - values[0]) / 2;
  return [values[0] - half, values[values.length - 1] + half];
}
