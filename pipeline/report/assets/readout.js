"use strict";
// All values at the chosen instant, as text.

function createReadout(list, report) {
  const { names } = report;
  const cells = new Map();

  /** Write texts under a label, in a cell that is made when it is first needed. */
  function write(label, kind, ...texts) {
    if (!cells.has(label)) {
      const box = list.appendChild(document.createElement("div"));
      box.className = kind;
      box.appendChild(document.createElement("dt")).textContent = label;
      cells.set(
        label,
        texts.map(() => box.appendChild(document.createElement("dd"))),
      );
    }
    cells.get(label).forEach((cell, i) => (cell.textContent = texts[i]));
  }

  return {
    moveTo(motion, frame) {
      const [pose, q, qd] = [motion.pose, motion.q, motion.qd].map((table) => rowOf(table, frame));
      write("κ", "pose", formatted(motion.kappa[frame], 2));
      if (motion.nearest) {
        const { name } = report.scene.pairs[motion.nearest.pairs[frame]];
        const distance = `${formatted(1000 * motion.nearest.distances[frame], 1)} mm`;
        const near = motion.nearest.distances[frame] < report.scene.alarmDistance;
        write("nearest bodies", "bodies", `${distance}: ${name}`);
        list.querySelector(".bodies").classList.toggle("near", near);
      }
      ["x", "y", "z"].forEach((name, i) => write(name, "pose", `${formatted(pose[i], 4)} m`));
      write("working mode", "pose", names.modes[motion.modes.values[frame]]);
      ["rx", "ry", "rz"].forEach((name, i) => write(name, "pose angle", `${formatted(pose[3 + i] * DEGREES, 2)}°`));
      names.actuators.forEach((name, k) =>
        write(name, "actuator", `${formatted(q[k], 4)} m`, `${formatted(qd[k], 3)} m/s`),
      );
    },
  };
}
