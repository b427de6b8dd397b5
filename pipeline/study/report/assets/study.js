// Draws the pictures of a study, in the colours of the page's theme.

/** The value of a property of the theme. */
function themed(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
}

/** A layout in the theme's colours, with what the picture says itself. */
function dressed(layout) {
  const [text, ground, line] = ["text", "ground", "line"].map(themed);
  const own = { ...layout };
  for (const name of Object.keys(own).filter((key) => /^[xy]axis\d*$/.test(key)).concat("xaxis", "yaxis")) {
    own[name] = { gridcolor: line, linecolor: line, zeroline: false, automargin: true, ...own[name] };
  }
  return {
    font: { size: 13, color: text },
    paper_bgcolor: ground,
    plot_bgcolor: ground,
    legend: { orientation: "h", y: 1.02, yanchor: "bottom" },
    hoverlabel: { bgcolor: themed("panel"), font: { color: text } },
    autosize: true,
    ...own,
    margin: { l: 80, r: 20, t: 40, b: 60, ...own.margin },
  };
}

async function drawStudy() {
  const figures = JSON.parse(await unpackText("report-data"));
  await loadLibrary();
  const paint = () =>
    Promise.all(
      figures.map((figure, index) =>
        Plotly.react(`plot-${index}`, figure.data, dressed(figure.layout), { responsive: true, displaylogo: false }),
      ),
    );
  await paint();
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", paint);
  document.body.dataset.ready = "";
}

drawStudy().catch((error) => {
  document.getElementById("no-pictures").hidden = false;
  throw error;
});
