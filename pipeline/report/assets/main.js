"use strict";
// Puts the page together: one player, and everything that follows it.

function element(id) {
  return document.getElementById(id);
}

/** A radio button for every path there is; the refined one is shown first. */
function createPathChoice(motions, onChoice) {
  const radios = Object.keys(motions).map((name) => {
    const label = element("paths").appendChild(document.createElement("label"));
    const radio = label.appendChild(document.createElement("input"));
    Object.assign(radio, { type: "radio", name: "path", value: name, checked: name === "refined" });
    label.append(name);
    radio.addEventListener("change", () => onChoice(name));
    return radio;
  });
  return {
    next() {
      const now = radios.findIndex((radio) => radio.checked);
      radios[(now + 1) % radios.length].click();
    },
  };
}

/** Buttons for the views, of which one is on, and for turns from there. */
function createCameraChoice(view) {
  const buttonFor = (box, text) => {
    const button = element(box).appendChild(document.createElement("button"));
    Object.assign(button, { type: "button", textContent: text });
    return button;
  };
  const press = (pressed) => buttons.forEach((button, k) => button.setAttribute("aria-pressed", String(k === pressed)));
  const buttons = Object.keys(CAMERAS).map((name, i) => {
    const button = buttonFor("cameras", name);
    button.setAttribute("aria-keyshortcuts", String(i + 1));
    button.addEventListener("click", () => choose(i));
    return button;
  });
  function choose(i) {
    press(i);
    view.look(buttons[i].textContent);
  }
  for (const [name, turn] of Object.entries(TURNS)) {
    const button = buttonFor("turns", turn.sign);
    button.setAttribute("aria-label", name);
    button.title = name;
    button.addEventListener("click", () => {
      press(null);
      view.turn(turn);
    });
  }
  press(0);
  return { choose, count: buttons.length };
}

/** Keys work while the focus is in the section of the motion, but never take a key from the control that has it. */
function listenToKeys(section, player, paths, cameras) {
  const far = (event) => (event.shiftKey ? 10 : 1);
  const actions = {
    " ": () => player.toggle(),
    ArrowLeft: (event) => player.step(-far(event)),
    ArrowRight: (event) => player.step(far(event)),
    Home: () => player.toStart(),
    End: () => player.toEnd(),
    c: () => paths.next(),
  };
  for (let i = 0; i < cameras.count; i += 1) actions[String(i + 1)] = () => cameras.choose(i);
  section.addEventListener("keydown", (event) => {
    const action = actions[event.key.length === 1 ? event.key.toLowerCase() : event.key];
    if (!action || event.ctrlKey || event.metaKey || event.altKey || hasOwnUse(event)) return;
    event.preventDefault();
    action(event);
  });
}

function hasOwnUse(event) {
  const focused = event.target;
  if (focused.id === "time") return false;
  if (event.key === " ") return focused.matches("button, select, summary, input, a");
  const moves = event.key.startsWith("Arrow") || event.key === "Home" || event.key === "End";
  return moves ? focused.matches("select, input, pre, .scroll") : focused.matches("select");
}

/** Plots have the size of their boxes, whatever changes it; one that is not displayed has none. */
function followSize(div) {
  new ResizeObserver(() => div.clientWidth && Plotly.Plots.resize(div)).observe(div);
}

/** Draw again in the colours of the other theme when that comes on. */
function followTheme(paints) {
  DARK.addEventListener("change", () => paints.forEach((paint) => paint()));
}

/**
 * Prepare the page for paper before it is printed, and undo that: plots get the size and colours they have on paper, the
 * 3-D view is replaced by a still, and what is folded is opened. Nothing here may take until later.
 */
function preparePrints(report, paints) {
  let folded = [];
  const draw = (onPaper) => {
    printing = onPaper;
    document.body.classList.toggle("paper", onPaper);
    for (const one of folded) one.open = onPaper;
    for (const paint of paints) paint(true);
  };
  addEventListener("beforeprint", () => {
    keepStill(report.colours.panel);
    folded = [...document.querySelectorAll("details:not([open])")];
    draw(true);
  });
  addEventListener("afterprint", () => draw(false));
}

/** Copy what the 3-D view shows, on its own ground: a canvas of WebGL is empty on paper. */
function keepStill(ground) {
  const [seen, still] = [document.querySelector("#machine canvas"), document.getElementById("machine-still")];
  if (!seen) return;
  [still.width, still.height] = [seen.width, seen.height];
  const context = still.getContext("2d");
  context.fillStyle = ground;
  context.fillRect(0, 0, still.width, still.height);
  context.drawImage(seen, 0, 0);
}

async function start() {
  await loadLibrary();
  const report = await readReport();
  const paints = [];
  if (report.proof) paints.push(() => createProofView(element("proof"), report));
  if (report.motions.refined) paints.push(createMotionViews(report));
  await Promise.all(paints.map((paint) => paint()));
  for (const plot of document.querySelectorAll(".js-plotly-plot")) followSize(plot);
  followTheme(paints);
  preparePrints(report, paints);
  document.body.dataset.ready = "yes";
}

/** Put player, views and controls together; the function returned draws all views, or those in 2-D only, anew. */
function createMotionViews(report) {
  const map = {
    div: element("map"),
    point: element("point"),
    title: element("map-title"),
    scale: element("map-scale"),
  };
  const machine = createMachineView(element("machine"), report);
  const flat = [
    createMapView(map, report),
    createTimeline(element("timeline"), element("cursor"), report, (t) => player.goToTime(t)),
  ];
  const views = [machine, ...flat];
  const readout = createReadout(element("readout"), report);
  let motion = report.motions.refined;

  const player = createPlayer(
    { play: element("play"), slider: element("time"), text: element("time-text"), speed: element("speed") },
    (frame) => {
      readout.moveTo(motion, frame);
      return Promise.all(views.map((view) => view.moveTo(frame)));
    },
  );

  const solid = element("bodies");
  if (solid) solid.addEventListener("change", () => machine.showBodies(solid.checked));

  function choose(name) {
    motion = report.motions[name];
    for (const id of ["path-key", "point-key", "point"]) element(id).dataset.path = name;
    for (const view of views) view.show(motion);
    player.show(motion);
  }

  async function paint(flatOnly = false) {
    const drawn = (flatOnly ? flat : views).map((view) => view.create(motion));
    choose(motion.name);
    await Promise.all(drawn);
  }

  const paths = createPathChoice(report.motions, choose);
  listenToKeys(element("motion"), player, paths, createCameraChoice(machine));
  return paint;
}

/** Say that there are no moving pictures: all else on the page is there. */
start().catch((error) => {
  element("no-pictures").hidden = false;
  throw error;
});
