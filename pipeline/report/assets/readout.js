"use strict";
// All values at the chosen instant, as text.

function createReadout(list, report) {
  const { names } = report;
  const cells = new Map();

  function cell(label) {
    if (!cells.has(label)) {
      const box = list.appendChild(document.createElement("div"));
      box.appendChild(document.createElement("dt")).textContent = label;
      cells.set(label, box.appendChild(document.createElement("dd")));
    }
    return cells.get(label);
  }

  return {
    moveTo(motion, frame) {
      const [pose, q, qd] = [motion.pose, motion.q, motion.qd].map((table) => rowOf(table, frame));
      cell("working mode").textContent = names.modes[motion.modes.values[frame]];
      cell("κ").textContent = formatted(motion.kappa[frame], 2);
      ["x", "y", "z"].forEach((name, axis) => (cell(name).textContent = `${formatted(pose[axis], 4)} m`));
      ["rx", "ry", "rz"].forEach((name, axis) => (cell(name).textContent = `${formatted(pose[3 + axis] * DEGREES, 2)}°`));
      names.actuators.forEach((name, k) => (cell(name).textContent = `${formatted(q[k], 4)} m`));
      names.actuators.forEach((name, k) => (cell(`${name} velocity`).textContent = `${formatted(qd[k], 3)} m/s`));
    },
  };
}
