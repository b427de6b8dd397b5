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

function createCameraChoice(onChoice) {
  const buttons = Object.keys(CAMERAS).map((name, i) => {
    const button = element("cameras").appendChild(document.createElement("button"));
    Object.assign(button, { type: "button", textContent: name });
    button.setAttribute("aria-keyshortcuts", String(i + 1));
    button.addEventListener("click", () => choose(i));
    return button;
  });
  function choose(i) {
    buttons.forEach((button, k) => button.setAttribute("aria-pressed", String(k === i)));
    onChoice(buttons[i].textContent);
  }
  buttons.forEach((button, k) => button.setAttribute("aria-pressed", String(k === 0)));
  return { choose, count: buttons.length };
}

/** Keys work anywhere on the page, but never take a key from the control that has the focus. */
function listenToKeys(player, paths, cameras) {
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
  document.addEventListener("keydown", (event) => {
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

/** Plots have the size of their boxes, whatever changes it. */
function followSize(div) {
  new ResizeObserver(() => Plotly.Plots.resize(div)).observe(div);
}

async function start() {
  const report = readReport();
  if (report.proof) await createProofView(element("proof"), report);
  if (report.motions.refined) await showMotions(report);
  document.body.dataset.ready = "yes";
}

async function showMotions(report) {
  const map = {
    div: element("map"),
    point: element("point"),
    title: element("map-title"),
    scale: element("map-scale"),
  };
  const views = [createMachineView(element("machine"), report), createMapView(map, report)];
  const timeline = createTimeline(element("timeline"), element("cursor"), report, (t) => player.goToTime(t));
  const readout = createReadout(element("readout"), report);
  let motion = report.motions.refined;

  const player = createPlayer(
    { play: element("play"), slider: element("time"), text: element("time-text"), speed: element("speed") },
    (frame) => {
      readout.moveTo(motion, frame);
      return Promise.all([...views, timeline].map((view) => view.moveTo(frame)));
    },
  );

  function choose(name) {
    motion = report.motions[name];
    for (const id of ["path-key", "point-key"]) element(id).style.background = report.colours[name];
    for (const view of [...views, timeline]) view.show(motion);
    player.show(motion);
  }

  await Promise.all([...views.map((view) => view.create()), timeline.create(motion)]);
  const paths = createPathChoice(report.motions, choose);
  const cameras = createCameraChoice((camera) => views[0].look(camera));
  choose("refined");
  for (const id of ["machine", "map", "timeline"]) followSize(element(id));
  listenToKeys(player, paths, cameras);
}

start();
