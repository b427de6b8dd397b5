"use strict";
// The machine in 3-D: rails, carts, links of both kinds and the platform, or their bodies, at one instant of a motion.

const PARTS = [
  "rails",
  "way",
  "beams",
  "fixed links",
  "telescopes",
  "platform",
  "joints",
  "carts",
  "TCP",
  "bodies",
  "fixed bodies",
  "bodies around",
];
const STILL_BODIES = ["fixed bodies", "bodies around"];
const MOVING = PARTS.slice(2, -STILL_BODIES.length).map((part) => PARTS.indexOf(part));
const SEEN_THROUGH = 0.3;
const ARM_OF_LINK = [0, 1, 1, 2, 2, 2];

function createMachineView(div, report) {
  const { scene, names } = report;
  const isTelescope = (link) => names.telescopes.includes(link);
  const links = names.links.map((_, link) => link);
  const bodies = {
    bodies: scene.bodies.filter((body) => body.frame !== "fixed"),
    "fixed bodies": scene.bodies.filter((body) => body.frame === "fixed" && !body.around),
    "bodies around": scene.bodies.filter((body) => body.around),
  };
  const covered = coveredParts(scene.bodies);
  let [motion, solid, red] = [null, true, ""];

  function traces() {
    const { colours } = report;
    const line = (name, colour, width) => ({
      type: "scatter3d",
      mode: "lines",
      name,
      line: { color: colour, width },
      hoverinfo: "text",
      x: [],
      y: [],
      z: [],
    });
    const dots = (name, marker) => ({
      type: "scatter3d",
      mode: "markers",
      name,
      marker,
      hoverinfo: "text",
      x: [],
      y: [],
      z: [],
    });
    const still = (name, opacity) => ({
      ...bodiesTrace(name, bodies[name], opacity),
      ...cornersOf(bodies[name]),
      facecolor: faceColours(bodies[name], () => colours.rail),
    });
    red = "";
    return [
      {
        ...line("rails", colours.rail, 7),
        ...segments(scene.rails),
        hovertext: repeated(["rail 1", "rail 2", "rail 3"], 3),
      },
      { ...line("way", colours.refined, 3), hoverinfo: "skip" },
      { ...line("beams", colours.frame, 4), hoverinfo: "skip" },
      line("fixed links", colours.first, 7),
      line("telescopes", colours.third, 7),
      { ...line("platform", colours.platform, 9), hoverinfo: "skip" },
      { ...dots("joints", { size: 3, color: colours.frame }), hoverinfo: "skip" },
      dots("carts", { size: 8, symbol: "square", line: { color: colours.frame, width: 2 } }),
      dots("TCP", { size: 6, color: colours.refined, line: { color: colours.frame, width: 1 } }),
      bodiesTrace("bodies", bodies.bodies, 1),
      still("fixed bodies", 1),
      still("bodies around", SEEN_THROUGH),
    ].map((trace) => ({ ...trace, visible: isVisible(trace.name) }));
  }

  /** Lines stand for what has no body, or for everything where bodies are not wanted. */
  function isVisible(part) {
    return part in bodies ? solid && bodies[part].length > 0 : !(solid && covered.includes(part));
  }

  function colourOf(body, mode, near) {
    const { colours } = report;
    if (near.includes(body)) return colours.near;
    if (body.frame === "platform") return colours.platform;
    if (body.frame === "cart") return mode[body.number] === "L" ? colours.first : colours.second;
    if (body.frame === "link") return isTelescope(body.number) ? colours.third : colours.first;
    return colours.rail;
  }

  function layout() {
    const { colours } = report;
    const [x, y, z] = extent(report);
    const axis = (title, range) => ({
      title: { text: title },
      range,
      nticks: 6,
      backgroundcolor: colours.panel,
      gridcolor: colours.line,
      showspikes: false,
      zeroline: false,
    });
    return {
      ...commonLayout(colours),
      margin: { l: 0, r: 0, t: 0, b: 0 },
      paper_bgcolor: colours.panel,
      showlegend: false,
      scene: {
        aspectmode: "data",
        camera: div.layout?.scene?.camera ?? cameraOf("Overview", div),
        dragmode: "orbit",
        xaxis: axis("x (m)", x),
        yaxis: axis("y (m)", y),
        zaxis: axis("z (m)", z),
      },
    };
  }

  /** Everything that moves, by part: coordinates and hover texts. */
  function partsAt(frame) {
    const { colours } = report;
    const feet = points(rowOf(motion.feet, frame));
    const carts = points(rowOf(motion.cartJoints, frame));
    const joints = points(rowOf(motion.platformJoints, frame));
    const [pose, q] = [rowOf(motion.pose, frame), rowOf(motion.q, frame)];
    const tcp = [pose[0], pose[1], pose[2]];
    const mode = names.modes[motion.modes.values[frame]];
    const near = alarmed(report, motion, frame);
    const linksOf = (chosen) => ({
      ...segments(chosen.map((link) => [carts[link], joints[link]])),
      hovertext: repeated(
        chosen.map((link) => linkText(names.links[link], carts[link], joints[link])),
        3,
      ),
    });
    return [
      segments(links.map((link) => [feet[ARM_OF_LINK[link]], carts[link]])),
      linksOf(links.filter((link) => !isTelescope(link))),
      linksOf(links.filter(isTelescope)),
      segments(scene.platformBars.map((bar) => bar.map((corner) => [tcp, ...joints][corner]))),
      coordinates([...carts, ...joints]),
      {
        ...coordinates(feet),
        hovertext: feet.map(
          (_, arm) =>
            `cart ${arm + 1}: ${formatted(q[arm], 4)} m, ${mode[arm] === "L" ? "left" : "right"} of its joint`,
        ),
        colour: [...mode].map((letter) => (letter === "L" ? colours.first : colours.second)),
      },
      { ...coordinates([tcp]), hovertext: [`TCP: ${tcp.map((value) => formatted(value, 4)).join(", ")} m`] },
      {
        ...cornersOf(bodies.bodies, motion, frame),
        faces: faceColours(bodies.bodies, (body) => colourOf(body, mode, near)),
      },
    ];
  }

  /** Colour what does not move where that changes; drawing it again at every instant would take as long as all else. */
  function colourStill(frame) {
    const near = alarmed(report, motion, frame).filter((body) => body.frame === "fixed");
    const names = near.map((body) => body.name).join();
    if (names === red) return;
    red = names;
    const colours = STILL_BODIES.map((part) => faceColours(bodies[part], (body) => colourOf(body, "", near)));
    const places = STILL_BODIES.map((part) => PARTS.indexOf(part));
    Plotly.restyle(div, { facecolor: colours }, places);
  }

  return {
    create: () => Plotly.newPlot(div, traces(), layout(), { ...CALM, scrollZoom: !TOUCH }),
    show(chosen) {
      motion = chosen;
      const colour = report.colours[motion.name];
      const way = {
        x: [columnOf(motion.pose, 0)],
        y: [columnOf(motion.pose, 1)],
        z: [columnOf(motion.pose, 2)],
        "line.color": colour,
      };
      Plotly.restyle(div, way, [PARTS.indexOf("way")]);
      Plotly.restyle(div, { "marker.color": colour }, [PARTS.indexOf("TCP")]);
    },
    moveTo(frame) {
      const parts = partsAt(frame);
      colourStill(frame);
      const all = (key) => parts.map((part) => part[key]);
      const update = { x: all("x"), y: all("y"), z: all("z"), hovertext: all("hovertext") };
      // Carts and bodies alone change their colours: what is undefined stays as it is.
      if (parts.some((part) => part.colour)) update["marker.color"] = all("colour");
      update.facecolor = all("faces");
      return Plotly.restyle(div, update, MOVING);
    },
    showBodies(wanted) {
      solid = wanted;
      Plotly.restyle(div, { visible: PARTS.map(isVisible) });
    },
    look: (camera) => Plotly.relayout(div, { "scene.camera": cameraOf(camera, div) }),
    turn: (turn) => Plotly.relayout(div, { "scene.camera": turned(div.layout.scene.camera, turn) }),
  };
}

/** Parts whose lines are within bodies. */
function coveredParts(bodies) {
  const has = (frame) => bodies.some((body) => body.frame === frame);
  const onRails = bodies.filter(({ frame, number }) => frame === "fixed" && number > 0);
  const rails = new Set(onRails.map(({ number }) => number));
  return [
    ...(bodies.some((body) => body.isLink) ? ["fixed links", "telescopes"] : []),
    ...(has("platform") ? ["platform"] : []),
    ...(rails.size === 3 ? ["rails"] : []),
  ];
}

function linkText(name, from, to) {
  const length = Math.hypot(...from.map((value, axis) => value - to[axis]));
  return `link ${name}: ${formatted(length, 4)} m`;
}
