"use strict";
// The certificate against the samples: the bound of kappa over every box, and kappa itself.

function createProofView(div, report) {
  const { colours, proof } = report;
  const edges = Array.from(unpack(proof.edges).values);
  const [length, kappa] = [unpack(proof.length), unpack(proof.kappa)].map((array) => Array.from(array.values));
  const bound = [...proof.bound, proof.bound[proof.bound.length - 1]];
  const traces = [
    {
      name: "proven bound",
      x: edges,
      y: bound,
      mode: "lines",
      line: { shape: "hv", color: colours.bound, width: 2 },
      hovertemplate: "bound %{y:.3f}<extra></extra>",
    },
    {
      name: "sampled",
      x: length,
      y: kappa,
      mode: "lines",
      line: { color: colours.refined, width: 2, simplify: false },
      hovertemplate: "κ %{y:.3f}<extra></extra>",
    },
  ];
  const layout = {
    ...commonLayout(colours),
    hovermode: "x unified",
    dragmode: false,
    margin: { l: 46, r: 14, t: 30, b: 40 },
    legend: { orientation: "h", x: 0, y: 1.02, yanchor: "bottom" },
    xaxis: {
      title: { text: "length along the path (steps)", standoff: 6 },
      range: [0, edges[edges.length - 1]],
      gridcolor: colours.line,
      zeroline: false,
    },
    yaxis: { title: { text: `κ (${report.scene.momentUnit})`, standoff: 6 }, gridcolor: colours.line, zeroline: false },
  };
  return Plotly.newPlot(div, traces, layout, CALM);
}
