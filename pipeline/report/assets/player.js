"use strict";
// Time: playing, scrubbing and stepping. Every view is notified of each new instant.

function createPlayer(controls, onFrame) {
  const { play, slider, text, speed } = controls;
  let [motion, frame, clock, waiting, playing, last] = [null, 0, 0, false, false, 0];

  const end = () => motion.t[motion.t.length - 1];

  /** Show a frame; where the last one is still being drawn, the next to come is shown instead. */
  function show(wanted) {
    frame = Math.max(0, Math.min(motion.t.length - 1, wanted));
    slider.value = frame;
    text.textContent = `${formatted(motion.t[frame], 2)} / ${formatted(end(), 2)} s`;
    slider.setAttribute("aria-valuetext", `${formatted(motion.t[frame], 2)} seconds`);
    if (waiting) return;
    waiting = true;
    const drawn = frame;
    Promise.resolve(onFrame(drawn)).finally(() => {
      waiting = false;
      slider.dataset.drawn = drawn;
      if (frame !== drawn && !playing) show(frame);
    });
  }

  function tick(now) {
    if (!playing) return;
    clock += ((now - last) / 1000) * Number(speed.value);
    last = now;
    if (clock >= end()) setPlaying(false);
    show(nearest(motion.t, Math.min(clock, end())));
    if (playing) requestAnimationFrame(tick);
  }

  function setPlaying(wanted) {
    playing = wanted;
    play.textContent = playing ? "Pause" : "Play";
    if (!playing) return;
    clock = frame === motion.t.length - 1 ? 0 : motion.t[frame];
    last = performance.now();
    requestAnimationFrame(tick);
  }

  function goTo(wanted) {
    show(wanted);
    clock = motion.t[frame];
  }

  play.addEventListener("click", () => setPlaying(!playing));
  slider.addEventListener("input", () => goTo(Number(slider.value)));

  return {
    /** Take another motion, at the same part of its duration. */
    show(chosen) {
      const part = motion ? motion.t[frame] / end() : 0;
      motion = chosen;
      slider.max = motion.t.length - 1;
      goTo(nearest(motion.t, part * end()));
    },
    toggle: () => setPlaying(!playing),
    step: (frames) => goTo(frame + frames),
    goToTime: (t) => goTo(nearest(motion.t, t)),
    toStart: () => goTo(0),
    toEnd: () => goTo(motion.t.length - 1),
  };
}
